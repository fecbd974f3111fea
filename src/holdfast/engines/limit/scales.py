"""Units of forces and equations in which the numbers of an assembly are of order one, whatever its masses and sizes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.forces import lighter_share
from holdfast.engines.limit.rounding import Equilibrium
from holdfast.engines.rest import Rest

LIGHT = 0.25  # share of the weight of a node's lighter body that counts as its usual force, if it rests on nothing


@dataclass(frozen=True, eq=False)
class Scales:
    """Units of contact forces, ``force`` (3I,) [N], and of motions, ``motion`` (6J,).

    Forces are in units of the usual normal force of their node, times μ along the surface where μ < 1. An equation is
    multiplied by its unit of motion: its largest terms are then of order one.
    """

    force: Float
    motion: Float

    @classmethod
    def of(cls, equilibrium: Equilibrium, mu: Float, tau: Float) -> Scales:
        """Return the units for nodes with usual normal forces ``tau`` (I,) [N].

        They are 0 for forces that have to be 0 and for equations that none of the others enters.
        """
        force = np.repeat(tau, 3)
        force.reshape(-1, 3)[:, 1:] *= np.minimum(mu, 1.0)[:, None]
        H = equilibrium.magnitude
        squares = H * H if isinstance(H, np.ndarray) else H.multiply(H)
        size = np.sqrt(np.asarray(squares @ (force * force)).ravel())
        return cls(force, np.divide(1.0, size, out=np.zeros(len(size)), where=size > 0))


def usual_forces(assembly: Assembly, rest: Rest) -> Float:
    """Return the usual normal force (I,) [N] of every node: that at rest on its interface, or a share of a weight.

    Nodes of holds have their own.
    """
    nodes, owner = rest.nodes.contacts, rest.nodes.contacts.interface
    count = np.maximum(np.bincount(owner), 1)
    resting = np.bincount(owner, np.maximum(rest.forces[: len(nodes), 0], 0.0)) / count
    own = LIGHT * lighter_share(assembly, nodes) * assembly.weight
    return np.concatenate([np.maximum(resting[owner], own / count[owner]), rest.nodes.usual])
