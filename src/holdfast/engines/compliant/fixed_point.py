"""A second algorithm for the same model: convex programs, and the dilatancy of their friction law cancelled.

Repeat: minimise ½ Σ (f_n² + |f_t|²/ρ) / k + Σ φ f_n subject to equilibrium and the friction cones; read the slip z_t of
every node from the cone's dual; set φ = μ |z_t| (Acary, Cadoux, Lemaréchal, Malick, "A formulation of the linear
discrete Coulomb friction problem via convex optimization", ZAMM 91 (2011), Sec. 3). Associated friction would
open a sliding contact by μ |z_t|; at the fixed point φ takes exactly that back. Where no equilibrium exists the first
program says so; where one exists but the contacts never come to rest on it, φ grows for ever at a constant rate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np
from scipy import sparse

from holdfast.arrays import Float
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.conic.solve import Outcome, Prepared
from holdfast.engines.forces import ACCEPTED_RESIDUAL, force_program

SETTLED = 1e-7  # change of φ, relative to the largest displacement, at which it is fixed
MEMORY = 6  # earlier steps that Anderson acceleration combines
STEADY = 0.01  # relative change of the growth of φ below which it is steady
LONG = 12  # steps over which it must be


class Fixed(Enum):
    """How the iteration ended."""

    RESTS = auto()
    MOVES = auto()  # no equilibrium at all, or a drift that keeps growing
    UNDECIDED = auto()


@dataclass(frozen=True, eq=False)
class FixedPoint:
    """``forces`` (I, 3) local [N] at rest, ``twists`` (J, 6) of the motion, where there are such."""

    outcome: Fixed
    forces: Float | None
    twists: Float | None
    iterations: int


def fixed_point(
    assembly: Assembly, nodes: ContactNodes, wrench: Float, k: Float, ratio: float = 1.0, *, most: int = 150
) -> FixedPoint:
    """Whether contacts of stiffness ``k`` (I,) come to rest under ``wrench`` (6J,)."""
    program, G = force_program(assembly, nodes, wrench)
    stiffness = np.column_stack([k, ratio * k, ratio * k]) / k.mean()
    program = replace(program, P=sparse.diags(1 / stiffness.ravel(), format="csc"))
    prepared = Prepared(program, tolerance=1e-10)
    rough = nodes.mu > 0
    phi, q = np.zeros(len(nodes)), np.zeros(3 * len(nodes))
    inputs: list[Float] = []
    outputs: list[Float] = []
    grown: list[Float] = []
    twists: list[Float] = []
    accelerated = True
    for count in range(1, most + 1):
        q[::3] = phi
        prepared.aim(q)
        solution = prepared.solve()
        twist = (assembly.equation_scale * solution.z[: G.shape[0]]).reshape(-1, 6)
        if solution.outcome is Outcome.INFEASIBLE:
            return FixedPoint(Fixed.MOVES, None, twist, count)
        if solution.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED) or solution.residual > ACCEPTED_RESIDUAL:
            if accelerated and outputs:  # it leapt too far
                accelerated, grown, phi = False, [], outputs[-1]
                continue
            return FixedPoint(Fixed.UNDECIDED, None, None, count)
        slip = np.zeros(len(nodes))
        slip[rough] = np.linalg.norm(solution.z[-3 * int(rough.sum()) :].reshape(-1, 3)[:, 1:], axis=1)
        wanted = nodes.mu * slip
        forces = solution.x.reshape(-1, 3)
        scale = max(float(np.abs(forces / stiffness).max()), float(wanted.max(initial=0)))
        if np.abs(wanted - phi).max(initial=0) <= SETTLED * scale:
            return FixedPoint(Fixed.RESTS, forces * assembly.weight, None, count)
        if accelerated and count > most // 2:
            accelerated, grown = False, []
        grown.append(wanted - phi)
        twists.append(twist)
        if not accelerated and len(grown) > LONG:
            recent = np.array(grown[-LONG:])
            if np.abs(recent - recent[-1]).max() <= STEADY * np.abs(recent[-1]).max():
                return FixedPoint(Fixed.MOVES, None, twists[-1] - twists[-2], count)
        inputs.append(phi)
        outputs.append(wanted)
        phi = _mixed(inputs[-MEMORY:], outputs[-MEMORY:]) if accelerated else wanted
    return FixedPoint(Fixed.UNDECIDED, None, None, most)


def _mixed(inputs: list[Float], outputs: list[Float]) -> Float:
    """Anderson's combination of earlier steps, the one that would change least; never negative."""
    if len(inputs) == 1:
        return outputs[0]
    residual = np.array([o - i for i, o in zip(inputs, outputs, strict=True)])
    steps = np.diff(residual, axis=0).T
    weights, *_ = np.linalg.lstsq(steps, residual[-1], rcond=1e-8)
    mixed = outputs[-1] - np.diff(np.array(outputs), axis=0).T @ weights
    return np.asarray(np.maximum(mixed, 0.0))
