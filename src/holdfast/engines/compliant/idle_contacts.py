"""Contacts that are open as detected and carry nothing at rest: bodies need not touch there, so no bound leans on them.

Rest is the same without all of them. A load may close them; but how far bodies have to move first, in compressions that
are not known, is the gap over the compression: to the law of elastic contacts a gap of a tenth of a millimetre is none,
to a steel cube it is the end of the world.
"""

from __future__ import annotations

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float
from holdfast.contacts.flags import EXACT
from holdfast.contacts.interface import Interface
from holdfast.elastic.model import Elastic
from holdfast.engines.compliant.places import Places
from holdfast.native import core

HARDLY = 1e-9  # a contact that carries no more than this share of the total weight at rest carries nothing but rounding
LEANS = 0.01  # an answer leans on contacts that are idle at rest if they carry more than this share of the load


def is_open(assembly: Assembly, interface: Interface) -> bool:
    """Tell whether surfaces are further apart than rounding explains, by EXACT times the tolerance of the pair."""
    if interface.separation is None:
        return False
    one, two = (assembly.scene.body(name) for name in interface.bodies)
    tolerance = assembly.tolerances.between(one, two).gap
    inside = one.shape.surface.sagitta + two.shape.surface.sagitta  # triangles lie inside of curved surfaces
    return interface.separation - inside > EXACT * tolerance


def open_pair(assembly: Assembly, number: int) -> str:
    """Name the pair of bodies of an open interface, with how far they are apart."""
    interface = assembly.interfaces[number]
    return f"{'-'.join(interface.bodies)} ({(interface.separation or 0.0) * 1e3:.2g} mm apart)"


def idle(places: Places, m: Elastic, q: Float) -> tuple[int, ...]:
    """Return the numbers of interfaces that are open and carry nothing at rest, with displacements q (6J,)."""
    assembly = places.assembly
    carried = _carried(places, m, q)
    there = np.flatnonzero(carried <= HARDLY).tolist()
    return tuple(k for k in there if is_open(assembly, assembly.interfaces[k]))


def leaning(places: Places, m: Elastic, idle: tuple[int, ...], loads: Float, q: Float) -> Bool:
    """Tell in which states q (k, 6J) under ``loads`` (k, 6J), of the model, ``idle`` contacts carry some of them."""
    found = np.zeros(len(q), dtype=bool)
    thrust = np.linalg.norm(loads.reshape(len(q), -1, 6)[:, :, :3], axis=2).sum(1)
    for row in range(len(q)):
        found[row] = _carried(places, m, q[row])[list(idle)].sum() > LEANS * thrust[row]
    return found


def _carried(places: Places, m: Elastic, q: Float) -> Float:
    """Return the normal force of each interface (interfaces,) at q (6J,), in the model's unit."""
    forces = np.empty((len(m.k), 3))
    core.node_forces(m, q, forces)
    return np.bincount(places.nodes.interface, forces[:, 0], len(places.assembly.interfaces)).astype(np.float64)
