"""A carrier in MuJoCo: a tray that really drives off, faster and faster, until what stands on it moves.

The fixed bodies are one heavy body on three sliding joints, the mobile base, and a force drives it so that it and its
load would accelerate together by a level that grows slowly from 0. Nothing is assumed about inertial forces. The
maximum is taken as reached when a contact node moves against its counterpart by more than SPEED, the criterion of
Nadeau & Kelly (Sec. VII-B). Bodies need time to get that fast while the level grows on: ramps are repeated from just
before the motion, each slower than the last.

Contacts as in ``baselines/mujoco.py``. Optional: ``pip install 'holdfast[simulators]'``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Float, checked, unit
from holdfast.validation.baselines.mujoco import describe, equal_stiffness, mujoco_module, node_motion
from holdfast.validation.baselines.search import grid_nodes

SIDE = 5  # nodes along a side unless given
STEP = 5e-4  # [s]
SPEED = 0.05  # [m/s] of contact nodes against each other: the assembly moves
CALM = 2e-3  # [m/s]: below that it rests
HEAVY = 100.0  # mass of the carrier over that of its load: how little the load's motion slows it down
SETTLE = 0.3  # [s] at rest, before it drives off
RATES = (8.0, 1.0, 0.1)  # [m/s³] of the ramps
BACK = 2.5  # a slower ramp starts that many times what a body that slides freely needs to reach SPEED before its end
MOST = 60.0  # [m/s²] at which a ramp ends
LOOK = 10  # steps between looks


Mark: TypeAlias = tuple[float, Float]  # a level and MuJoCo's state there


@dataclass(frozen=True)
class Ramp:
    """How far a carrier's acceleration could be raised along one direction [m/s²].

    ``acceleration``: where contact nodes exceeded SPEED (inf: nowhere up to MOST; 0: they did at rest). ``calm``: up to
    where they stayed below CALM. ``steps`` of time, of all ramps.
    """

    acceleration: float
    calm: float
    steps: int


class Carrier:
    """An assembly on its carrier in MuJoCo, before it drives off. ``rests``: whether nothing moves by then."""

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
        """Levels where the nodes exceed SPEED and up to where they rest, and states on the way there by level."""
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
        """One step of time, with the force on the carrier that gives it and its load ``acceleration`` (3,)."""
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
