"""The model of the window: the assembly, the answers about it, the map in portions among them, and the selection."""

from __future__ import annotations

import time
from collections import deque
from typing import Final, NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.rigid import tangents
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.verdict import Status
from holdfast.geometry.triangles import first_hit
from holdfast.live.steps import ShownStep
from holdfast.queries.map import RobustnessMap, check_count, expected_points, joined_maps, robustness_map
from holdfast.queries.push import Robustness, robustness
from holdfast.queries.request import EngineChoice, engine_of
from holdfast.queries.stability import Stability, stability

COARSER: Final = (4, 2, 1)  # the spacing of each round, as multiples of the final one
FEW: Final = 1000  # a map of fewer points is computed in one round
POINTS_ACROSS: Final = 50  # default number of points of a map along the size of the assembly
PORTION: Final = 2.0  # [s] approximate time of a portion of the map
REMEMBERED: Final = 100  # number of edits that can be undone
STEEPEST: Final = 85.0  # [degrees] largest angle between a push and the inward normal


class MappedBody(NamedTuple):
    """The map of one body, and its ``spacing`` [m]."""

    spacing: float
    map: RobustnessMap


class Portions:
    """A map of all movable bodies of an assembly, as far as it is known.

    ``go_on`` computes the next portion. An exception in it loses only that portion.
    """

    def __init__(self, assembly: Assembly, engine: Engine, spacing: float) -> None:
        self.assembly, self.engine = assembly, engine
        names = [body.name for body in assembly.movable]
        check_count(assembly, names, spacing)
        self._size = {name: expected_points(assembly, [name], spacing) for name in names}
        rounds = COARSER if sum(self._size.values()) > FEW else COARSER[-1:]
        self._rounds = [multiple * spacing for multiple in rounds]
        self._parts: dict[str, MappedBody] = {}

    @property
    def done(self) -> bool:
        """Whether every body is mapped at the final spacing."""
        return bool(self._size) and self._round() is None

    @property
    def text(self) -> str:
        """The number of bodies that are mapped at each spacing, in words, the finest first."""
        count = len(self._size)
        known = [(s, sum(part.spacing == s for part in self._parts.values())) for s in reversed(self._rounds)]
        return ", ".join(f"{n} of {count} bodies at points {s:.2g} m apart" for s, n in known if n)

    @property
    def map(self) -> RobustnessMap:
        """The map of the bodies so far, in the order of the assembly, with the verdict on all bodies."""
        verdict = prepared(self.engine, self.assembly).verdict()
        return joined_maps([self._parts[name].map for name in self._size if name in self._parts], verdict)

    def go_on(self, first: str | None = None) -> None:
        """Map one more body, or the same more finely.

        In each round, the body ``first`` comes before the others, which come from the largest to the smallest. Raises
        HoldfastError if nothing is left to map, and the errors of ``robustness_map``.
        """
        spacing = self._round()
        if spacing is None:
            raise HoldfastError(message("live map", "nothing is left to map", "needs a movable body"))
        left = [name for name in self._size if self._spacing(name) > spacing]
        name = min(left, key=lambda name: (name != first, -self._size[name]))
        self._parts[name] = MappedBody(
            spacing, robustness_map(self.assembly, [name], spacing=spacing, engine=self.engine)
        )

    def _round(self) -> float | None:
        """Return the spacing [m] of the first round that is not complete; None after the last."""
        return next((s for s in self._rounds if any(self._spacing(name) > s for name in self._size)), None)

    def _spacing(self, name: str) -> float:
        return self._parts[name].spacing if name in self._parts else float("inf")


class Pick(NamedTuple):
    """A chosen point (3,) [m] of a body, with the outward normal (3,) of its surface there, world frame."""

    body: str
    point: Float
    normal: Float


class ViewModel:
    """The state of a live view.

    ``assembly`` is the assembly on show. ``verdict`` and ``map`` are the answers about it, None until they are
    computed; an edit resets them. The map is computed in ``portions``, None before the first. ``pick`` is the chosen
    point. The push there leans by ``tilt`` [degrees] from the inward normal, towards ``turn`` [degrees] about it.
    ``push`` is its answer, None until it is computed. ``steps`` are the states of an answer for the slider, and
    ``step`` is the number of the one on show. ``past`` holds the assemblies before the last edits, the newest last.
    """

    def __init__(
        self,
        assembly: Assembly,
        *,
        engine: EngineChoice,
        spacing: float | None = None,
        known: RobustnessMap | None = None,
    ) -> None:
        self.given = self.assembly = assembly
        self.engine = engine_of(engine)
        self.spacing = assembly.size / POINTS_ACROSS if spacing is None else spacing
        self.map = known
        self.portions: Portions | None = None
        self.verdict: Stability | None = None
        self.pick: Pick | None = None
        self.turn = self.tilt = 0.0
        self.push: Robustness | None = None
        self.steps: tuple[ShownStep, ...] = ()
        self.step = 0
        self.past: deque[Assembly] = deque(maxlen=REMEMBERED)

    @property
    def state(self) -> ShownStep:
        """The state on show: that of the slider, or the assembly as it is."""
        return self.steps[min(self.step, len(self.steps) - 1)] if self.steps else ShownStep("")

    @property
    def direction(self) -> Float | None:
        """The unit direction (3,) of the push at the chosen point, or None if no point is chosen."""
        if self.pick is None:
            return None
        first, second = tangents(self.pick.normal)
        turn, tilt = np.deg2rad([self.turn, self.tilt])
        level = np.cos(turn) * first + np.sin(turn) * second
        return np.asarray(np.sin(tilt) * level - np.cos(tilt) * self.pick.normal)

    @property
    def mechanism(self) -> Mechanism | None:
        """The mechanism under the push or, if the assembly does not stand, without one; None if there is none."""
        pushed: Mechanism | None = None if self.push is None else self.push.mechanism[0]
        if pushed is not None:
            return pushed
        return None if self.verdict is None else self.verdict.mechanism

    def ask_verdict(self) -> None:
        """Compute whether the assembly stands."""
        self.verdict = stability(self.assembly, engine=self.engine)

    @property
    def mapped(self) -> bool:
        """Whether the map is complete: of all movable bodies, at points ``spacing`` apart."""
        return self.map is not None and (self.portions is None or self.portions.done)

    def ask_map(self) -> None:
        """Compute one more portion of the map: of more bodies, or of the same at more points."""
        if self.portions is None:
            self.portions = Portions(self.assembly, self.engine, self.spacing)
        until = time.monotonic() + (PORTION if self.map is not None else 0.0)
        while True:
            self.portions.go_on(None if self.pick is None else self.pick.body)
            if self.portions.done or time.monotonic() > until:
                break
        self.map = self.portions.map

    def choose(self, origin: Float, ray: Float) -> bool:
        """Choose the first point where a ray hits a body as it is drawn; return whether that body is movable.

        Nothing is chosen if the ray hits nothing or a fixed body.
        """
        nearest, pick = np.inf, None
        for body in self.assembly.bodies:
            if body.name in self.state.hidden:
                continue
            place = np.linalg.inv(self.state.moved.get(body.name, np.eye(4)))
            surface = body.surface_world
            start, along = place[:3, :3] @ origin + place[:3, 3], place[:3, :3] @ ray
            hit = first_hit(surface.vertices, surface.faces, start, along)
            if hit is not None and hit.distance < nearest:
                nearest = hit.distance
                a, b, c = surface.vertices[surface.faces[hit.triangle]]
                normal = np.cross(b - a, c - a)
                point = start + hit.distance * along
                pick = None if body.fixed else Pick(body.name, point, normal / np.linalg.norm(normal))
        self.pick, self.push = pick, None
        self.turn = self.tilt = 0.0
        return pick is not None

    def aim(self, turn: float, tilt: float) -> None:
        """Aim the push at the chosen point at these angles [degrees], and drop its answer."""
        self.turn, self.tilt = turn % 360.0, min(max(tilt, 0.0), STEEPEST)
        self.push = None

    def ask_push(self) -> None:
        """Compute the answer for the push at the chosen point, with bounds if the engine has them."""
        if self.pick is None or self.direction is None:
            return
        self.push = robustness(
            self.assembly, self.pick.body, self.pick.point, self.direction,
            engine=self.engine, bounds=self.engine.name == "compliant",
        )  # fmt: skip

    def edit(self, assembly: Assembly) -> None:
        """Show another assembly; the old one can be restored by ``undo``, but its answers are dropped."""
        self.past.append(self.assembly)
        self._begin(assembly)

    def undo(self) -> None:
        """Show the assembly before the last edit, if there was one."""
        if self.past:
            self._begin(self.past.pop())

    def _begin(self, assembly: Assembly) -> None:
        self.assembly = assembly
        self.map = self.portions = self.verdict = self.push = self.pick = None
        self.steps, self.step = (), 0

    def show(self, steps: tuple[ShownStep, ...]) -> None:
        """Show the states of an answer, beginning with the first."""
        self.steps, self.step = steps, 0

    def status_of_groups(self) -> dict[str, Status]:
        """Return the status of the group of each movable body, by name; {} before there is a verdict."""
        if self.verdict is None:
            return {}
        return {name: group.verdict.status for group in self.verdict.groups for name in group.bodies}
