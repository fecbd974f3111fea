"""Robustness over all exposed surfaces: inward pushes at a point of every cell."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import archived, to_dict
from holdfast.base.arrays import Float, Int, Objects, checked_number, objects
from holdfast.base.errors import SceneError, message
from holdfast.base.painters import paint
from holdfast.base.progress import report
from holdfast.base.public import Summary, number
from holdfast.base.values import Table, Value
from holdfast.engines.answers import joined
from holdfast.engines.contract import EXACT, FORCES_ONLY, Within
from holdfast.engines.mechanism import Mode
from holdfast.engines.verdict import Status
from holdfast.geometry.cells import Cells, blocked, surface_cells
from holdfast.queries.exposed import covered
from holdfast.queries.request import (
    DEFAULT_ENGINE,
    EngineChoice,
    body_number,
    checked_assembly,
    engine_of,
    push_columns,
)
from holdfast.queries.result import Forces, gives_way, least, told
from holdfast.scene.scene import Scene

MAX_POINTS = 2_000_000
SIGNIFICANT = 6  # digits of a force that count in a ranking


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MapPoint(Value):
    """One point of a map: a push of ``force`` along ``direction`` (inward) at ``point`` moves ``moving``.

    Where not ``solved``, ``force`` was interpolated, with a stated relative ``error``.
    """

    body: str
    point: tuple[float, float, float]
    direction: tuple[float, float, float]
    force: float
    status: Status
    mode: Mode
    moving: tuple[str, ...]
    mechanism: str
    solved: bool
    error: float


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RobustnessMap(Forces):
    """Robustness to inward pushes over the exposed surfaces of bodies.

    ``points`` and outward ``normals`` (n, 3), ``body`` (n,) names, ``force`` (n,) [N] for a push along minus the
    normal; ``status``, ``lower``, ``upper``, ``moving``, ``mode`` (n,) and ``mechanism`` (n,) as in Robustness.
    ``cells`` holds the surface pieces of each body that the points stand for (in the order of the points), ``hidden``
    those where nobody can push. ``solved`` (n,) tells which points were solved, ``error`` (n,) the stated relative
    error of ``force`` where it was interpolated between them (0 elsewhere).
    """

    assembly: Assembly
    points: Float
    normals: Float
    body: Objects
    cells: Table[str, Cells]
    hidden: Table[str, Cells]

    def save_png(self, path: str | os.PathLike[str]) -> None:
        """Draw the map as a picture; needs no display."""
        paint(self, path, ".png")

    def save_html(self, path: str | os.PathLike[str]) -> None:
        """Write the map as one page that opens offline: turn it, point at it, read the largest push there."""
        paint(self, path, ".html")

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: the columns and the weakest points, without meshes and motions."""
        names = ("points", "normals", "body", "force", "status", "lower", "upper", "moving", "mode", "solved", "error")
        weakest = {
            "weakest": to_dict(self.weakest()) if len(self.force) else None,
            "weakest_of_each_body": to_dict(self.weakest_of_each_body()),
        }
        return {"scene": self.assembly.scene.name} | self.about() | weakest | self.columns(*names)

    def summary(self) -> Summary:
        """The weakest point of every body."""
        name = self.assembly.scene.name or "assembly"
        headline = f"{name}: {told(self.verdict)}; {len(self.force):,} inward pushes, {least(self.force, 'N')}"
        rows = [
            [self.body[k], number(self.force[k], "N"), str(self.status[k]), gives_way(self.mode[k], self.moving[k])]
            for k in self._weakest_of_each_body
        ]
        return Summary(headline, self.facts(), ("weakest of", "force", "status", "what gives way"), rows, self.notes)

    def weakest(self) -> MapPoint:
        """The point where the smallest push moves something (the first of equals); an infinite one if none does."""
        return self.at(int(self._ranking[0]))

    def weakest_of_each_body(self) -> tuple[MapPoint, ...]:
        """The weakest point of every body, weakest body first."""
        return tuple(self.at(index) for index in self._weakest_of_each_body)

    @cached_property
    def _weakest_of_each_body(self) -> tuple[int, ...]:
        first: dict[str, int] = {}
        for index in self._ranking.tolist():
            first.setdefault(self.body[index], index)
        return tuple(first.values())

    @cached_property
    def _ranking(self) -> Int:
        """(n,) points from weak to strong; forces that differ by rounding alone stay in the order of the points."""
        with np.errstate(divide="ignore"):
            magnitude = np.floor(np.log10(self.force)) - SIGNIFICANT
        unit = np.where(np.isfinite(magnitude), 10.0 ** np.where(np.isfinite(magnitude), magnitude, 0), 1.0)
        return np.argsort(np.round(self.force / unit) * unit, kind="stable")

    def at(self, index: int) -> MapPoint:
        """The point of that number."""
        px, py, pz = (float(v) for v in self.points[index])
        dx, dy, dz = (float(-v) for v in self.normals[index])
        motion = self.mechanism[index]
        return MapPoint(
            body=self.body[index],
            point=(px, py, pz),
            direction=(dx, dy, dz),
            force=float(self.force[index]),
            status=self.status[index],
            mode=self.mode[index],
            moving=self.moving[index],
            mechanism="" if motion is None else motion.text,
            solved=bool(self.solved[index]),
            error=float(self.error[index]),
        )


def robustness_map(
    assembly: Assembly | Scene,
    bodies: Sequence[str] | None = None,
    *,
    spacing: float = 0.01,
    engine: EngineChoice = DEFAULT_ENGINE,
    gap: float = 0.01,
) -> RobustnessMap:
    """R for inward normal pushes over all exposed surfaces of ``bodies`` (all movable ones unless named).

    ``spacing`` [m] is the distance of neighbouring points. Points on contact patches, and points with another body
    less than half a spacing in front of them, are left out: nobody can push there. ``gap`` is the largest
    (upper - lower) / upper wanted of engines that give bounds. ``compliant`` interpolates between points that it solved
    until the expected relative error is at most ``gap``; up to three times that is stated. With 0 every point is solved
    on its own. ``graph`` takes no notice.
    """
    assembly = checked_assembly(assembly)
    step = checked_number(spacing, "robustness_map: spacing", above=0)
    wanted = checked_number(gap, "robustness_map: gap", minimum=0)
    if isinstance(bodies, str):
        raise SceneError(message("robustness_map", f"bodies is the text {bodies!r}", "needs a list of names"))
    names = [body.name for body in assembly.movable] if bodies is None else list(bodies)
    if not names:
        problem = "there is no movable body" if bodies is None else "bodies is empty"
        raise SceneError(message("robustness_map", problem, "name bodies, or free one"))
    numbers = {name: body_number(assembly, name) for name in names}
    _check_count(assembly, names, step)
    method = engine_of(engine)
    state = method.prepare(assembly)
    shown: dict[str, Cells] = {}
    hidden: dict[str, Cells] = {}
    accuracy = EXACT if wanted == 0 else Within(wanted) if wanted < 1 else FORCES_ONLY
    answers = []
    for done, (name, index) in enumerate(numbers.items()):
        report("robustness of all surfaces", done, len(numbers))
        cells = surface_cells(assembly.scene.body(name).surface_world, step)
        patches = [patch for i in assembly.interfaces if name in i.bodies for patch in i.patches]
        under = covered(cells, patches, assembly.tolerances.gap)
        for other in assembly.bodies:
            if other.name != name:
                under |= blocked(cells, other.surface_world, step / 2)
        shown[name], hidden[name] = cells.chosen(~under), cells.chosen(under)
        columns = push_columns(assembly, index, shown[name].points, -shown[name].normals)
        answers.append(state.load_factor(columns, accuracy))
    report("robustness of all surfaces", len(numbers), len(numbers))
    return RobustnessMap(
        answers=joined(answers),
        assembly=assembly,
        points=np.vstack([cells.points for cells in shown.values()]),
        normals=np.vstack([cells.normals for cells in shown.values()]),
        body=objects([name for name, cells in shown.items() for _ in cells.points]),
        cells=Table(shown),
        hidden=Table(hidden),
    )


def _check_count(assembly: Assembly, names: Sequence[str], spacing: float) -> None:
    """Refuse a spacing that would take more points than memory, before taking any."""
    area = sum(assembly.scene.body(name).surface_world.area for name in names)
    expected = area / spacing**2
    if expected > MAX_POINTS:
        problem = f"spacing {spacing:g} m gives about {expected:,.0f} points on {area:.3g} m²"
        remedy = f"use {np.sqrt(area / MAX_POINTS) * 1.05:.2g} m or more, or name fewer bodies"
        raise SceneError(message("robustness_map", problem, remedy))
