"""A carrier in MuJoCo: a tray that really drives off, faster and faster, until what stands on it moves.

All fixed bodies form one heavy body on three sliding joints: the mobile base. A force drives it so that base and load
would accelerate together, at a rate that grows slowly from 0; no inertial forces are applied to the load. The largest
acceleration is reached when a contact node moves against its counterpart faster than SPEED, the criterion of
Nadeau & Kelly (Sec. VII-B). Bodies take time to become that fast, during which the acceleration grows further, so the
ramp is repeated from just before the motion with smaller and smaller slopes.

Contacts as in ``baselines/mujoco.py``. Optional: the extra ``bench``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from bench.baselines.mujoco import describe, equal_stiffness, mujoco_module, node_motion
from bench.baselines.search import grid_nodes
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float, checked, unit

SIDE = 5  # nodes along a side unless given
STEP = 5e-4  # [s]
SPEED = 0.05  # [m/s] relative speed of contact nodes from which the assembly counts as moving
CALM = 2e-3  # [m/s] relative speed of contact nodes below which the assembly counts as resting
HEAVY = 100.0  # mass of the carrier over that of its load, so that the load's motion hardly slows the carrier
SETTLE = 0.3  # [s] time at rest before the carrier moves
RATES = (8.0, 1.0, 0.1)  # [m/s³] slopes of the ramps, in turn
BACK = 2.5  # a slower ramp starts earlier by this multiple of what a freely sliding body needs to reach SPEED
MOST = 60.0  # [m/s²] acceleration at which a ramp ends
LOOK = 10  # time steps between two measurements of the speed


Mark: TypeAlias = tuple[float, Float]  # an acceleration [m/s²] and MuJoCo's state at it


@dataclass(frozen=True)
class Ramp:
    """The largest acceleration of a carrier along one direction, as simulated [m/s²].

    ``acceleration``: at which contact nodes became faster than SPEED (inf: not up to MOST; 0: already at rest).
    ``calm``: up to which they stayed slower than CALM. ``steps``: number of time steps of all ramps.
    """

    acceleration: float
    calm: float
    steps: int


class Carrier:
    """An assembly at rest on its carrier in MuJoCo. ``rests``: whether it is slower than SPEED before driving off."""

    def __init__(self, assembly: Assembly, nodes: ContactNodes | None = None, *, step: float = STEP) -> None:
        """``nodes``: grids of SIDE x SIDE on every (rectangular) patch unless given; ``step`` of time [s]."""
        self.assembly, self.step = assembly, step
        self.nodes = grid_nodes(assembly, SIDE) if nodes is None else nodes
        self.mujoco = mujoco_module()
        load = float(assembly.mass.sum())
        self.model: Any = self.mujoco.MjModel.from_xml_string(describe(assembly, self.nodes, HEAVY * load, step))
        equal_stiffness(self.model, self.nodes, step)
        self.total = (1 + HEAVY) * load
        self.data: Any = self.mujoco.MjData(self.model)
        self.mujoco.mj_forward(self.model, self.data)
        self.steps = 0
        for _ in range(round(SETTLE / step)):
            self._advance(np.zeros(3))
        self.start, self.rests = self._state(), self.speed() < SPEED

    def limit(self, direction: Float, rates: tuple[float, ...] = RATES) -> Ramp:
        """Raise the acceleration along ``direction`` (3,), scene axes, until something moves; ever slower ramps."""
        way = unit(checked(direction, (3,), "carrier: direction"))
        if not self.rests:
            return Ramp(0.0, 0.0, 0)
        begun = self.steps
        level, state = 0.0, self.start
        found = calm = 0.0
        for rate in rates:
            found, calm, marks = self._ramp(way, rate, level, state)
            if not 0 < found < np.inf:
                break
            early = found - BACK * np.sqrt(2 * SPEED * rate)
            level, state = next(((a, s) for a, s in reversed(marks) if a <= min(early, calm)), (0.0, self.start))
        return Ramp(found, calm, self.steps - begun)

    def _ramp(
        self, way: Float, rate: float, level: float, state: Float
    ) -> tuple[float, float, list[tuple[float, Float]]]:
        """Accelerations at which nodes exceed SPEED and up to which they rest, and the states on the way there."""
        self.mujoco.mj_setState(self.model, self.data, state, self.mujoco.mjtState.mjSTATE_INTEGRATION)
        self.mujoco.mj_forward(self.model, self.data)
        a = calm = level
        marks: list[Mark] = []
        while a < MOST:
            marks.append((a, self._state()))
            for _ in range(LOOK):
                a += rate * self.step
                self._advance(a * way)
            speed = self.speed()
            if speed < CALM:
                calm = a
            if not speed < SPEED:
                return a, calm, marks
        return np.inf, calm, marks

    def _advance(self, acceleration: Float) -> None:
        """One time step under the force that accelerates carrier and load together by ``acceleration`` (3,) [m/s²]."""
        self.data.qfrc_applied[-3:] = self.total * (acceleration - self.model.opt.gravity)
        self.mujoco.mj_step(self.model, self.data)
        self.steps += 1

    def speed(self) -> float:
        """The largest speed of a contact node against its counterpart [m/s]."""
        return float(np.linalg.norm(node_motion(self.assembly, self.nodes, self.data)[1], axis=1).max(initial=0.0))

    def _state(self) -> Float:
        kind = self.mujoco.mjtState.mjSTATE_INTEGRATION
        state = np.empty(self.mujoco.mj_stateSize(self.model, kind))
        self.mujoco.mj_getState(self.model, self.data, state, kind)
        return state
