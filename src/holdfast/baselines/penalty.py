"""A discrete-element referee: rigid bodies on springs, dashpots and sliders, stepped through time.

Cundall & Strack (1979): at every contact node a normal spring and dashpot that cannot pull, and a tangential spring
that remembers how far it was stretched and slides at μ times the normal force. Explicit steps, central differences.
Displacements are small: nodes and normals stay where they are. Cundall's local damping (a share of each unbalanced
force, against the motion) takes the energy out; it vanishes at rest and does not hold what drifts.

Nothing but the nodes and their tributary areas comes from elsewhere: no equilibrium is ever solved for. Friction
depends on history here, where engine ``compliant`` looks at displacements alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from holdfast.arrays import Bool, Float
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.baselines.search import Peak, Trial, grid_nodes, push
from holdfast.compiled import compiled

SINK = 1e-6  # sizes of the assembly by which all contacts together give way under its weight; drops out
DAMPING = 0.6  # of unbalanced forces
DASHPOT = 0.2  # of the critical damping of the fastest vibration
STEP = 0.4  # over the fastest angular frequency, 2 being the limit of stability
BALANCED = 1e-6  # of the total weight: unbalanced force, or torque over the assembly's size, of a body at rest
FAR = 20.0  # times the displacement before a step of load: what goes farther moves
CHECK = 200  # steps between looks
MOST = 400_000  # steps until neither rest nor motion was seen
FIRST = 0.02  # total weights: the first step of load
GROWTH = 0.04  # of the load: the largest step
ENDLESS = 50.0  # total weights up to which is searched


@dataclass(frozen=True, eq=False)
class State:
    """Displacements and velocities q, v (6J,) [m, rad, /s] and the tangential springs z (I, 2) [m]."""

    q: Float
    v: Float
    z: Float


@dataclass(frozen=True, eq=False)
class Blocks:
    """Bodies and springs in the form that is stepped; ``ratio`` tangential over normal stiffness."""

    assembly: Assembly
    nodes: ContactNodes
    ratio: float = 1.0

    def __post_init__(self) -> None:
        assembly, nodes = self.assembly, self.nodes
        centre = np.vstack([assembly.com, np.zeros((1, 3))])  # the last one is FIXED
        arms = [nodes.points - centre[end] for end in (nodes.a, nodes.b)]
        free = [(end >= 0)[:, None, None] for end in (nodes.a, nodes.b)]
        rows = [np.where(f, np.concatenate([nodes.axes, np.cross(r[:, None], nodes.axes)], 2), 0.0)
                for f, r in zip(free, arms, strict=True)]  # fmt: skip
        weight = assembly.weight or 1.0
        stiffness = nodes.weights / nodes.weights.sum() * weight / (SINK * assembly.size)
        inverse = np.zeros((len(assembly.movable), 6, 6))
        for k, body in enumerate(assembly.movable):
            turn = body.pose[:3, :3]
            inverse[k, :3, :3] = np.eye(3) / body.mass
            inverse[k, 3:, 3:] = turn @ np.linalg.inv(body.inertia_com) @ turn.T
        object.__setattr__(self, "on_a", np.ascontiguousarray(rows[0]))
        object.__setattr__(self, "on_b", np.ascontiguousarray(rows[1]))
        object.__setattr__(self, "stiffness", stiffness)
        object.__setattr__(self, "inverse", inverse)
        fastest = self._fastest()
        object.__setattr__(self, "dt", STEP / fastest)
        object.__setattr__(self, "dashpot", 2 * DASHPOT / fastest * stiffness)
