"""Compute the robustness of all exposed surfaces to an inward push at one point of every surface cell."""

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
from holdfast.engines.presence import prepared
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

MAX_POINTS = 2_000_000  # the most points in one map; more would exhaust the memory
SIGNIFICANT = 6  # forces are ranked after rounding to about this many significant digits


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class MapPoint(Value):
    """One point of a robustness map, and what a push there does.

    A push of ``force`` [N] at ``point`` (3,) [m] along the inward unit vector ``direction`` (3,), both in the world
    frame, is the largest before the bodies named in ``moving`` begin to move. ``mode`` and ``status`` have the same
    meaning as in Robustness; ``mechanism`` is the motion in words. Where ``solved`` is false, ``force`` was
    interpolated and ``error`` is its stated relative error.
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
    """The robustness to inward pushes at n points on the exposed surfaces of bodies.

    ``points`` (n, 3) [m] and the outward unit ``normals`` (n, 3) are in the world frame; ``body`` (n,) holds the name
    of the body at each point. ``force`` (n,) [N] is the largest push along minus the normal. ``status``, ``lower``,
    ``upper``, ``moving``, ``mode`` and ``mechanism``, each (n,), have the same meaning as in Robustness.

    ``cells`` maps each body name to the surface cells that the points represent, in the order of the points. ``hidden``
    maps it to the cells where nobody can push. ``solved`` (n,) is true where a point was solved on its own; ``error``
    (n,) is the stated relative error of ``force`` where it was interpolated, and 0 elsewhere.
    """

    assembly: Assembly
    points: Float
    normals: Float
    body: Objects
    cells: Table[str, Cells]
    hidden: Table[str, Cells]

    def save_png(self, path: str | os.PathLike[str]) -> None:
        """Draw the map as a PNG picture; this needs no display."""
        paint(self, path, ".png")

    def save_html(self, path: str | os.PathLike[str]) -> None:
        """Write the map as one HTML page that opens offline and shows the largest push under the pointer."""
        paint(self, path, ".html")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: the columns and the weakest points, without meshes and mechanisms."""
        names = ("points", "normals", "body", "force", "status", "lower", "upper", "moving", "mode", "solved", "error")
        weakest = {
            "weakest": to_dict(self.weakest()) if len(self.force) else None,
            "weakest_of_each_body": to_dict(self.weakest_of_each_body()),
        }
        return {"scene": self.assembly.scene.name} | self.about() | weakest | self.columns(*names)

    def summary(self) -> Summary:
        """Summarise the map by the weakest point of every body."""
        name = self.assembly.scene.name or "assembly"
        headline = f"{name}: {told(self.verdict)}; {len(self.force):,} inward pushes, {least(self.force, 'N')}"
        rows = [
            [self.body[k], number(self.force[k], "N"), str(self.status[k]), gives_way(self.mode[k], self.moving[k])]
            for k in self._weakest_of_each_body
        ]
        return Summary(headline, self.facts(), ("weakest of", "force", "status", "what gives way"), rows, self.notes)

    def weakest(self) -> MapPoint:
        """Return the point where the smallest push moves something; among equal points, the first.

        If no push moves anything, the force of that point is infinite.
        """
        return self.at(int(self._ranking[0]))

    def weakest_of_each_body(self) -> tuple[MapPoint, ...]:
        """Return the weakest point of every body, beginning with the weakest body."""
        return tuple(self.at(index) for index in self._weakest_of_each_body)

    @cached_property
    def _weakest_of_each_body(self) -> tuple[int, ...]:
        first: dict[str, int] = {}
        for index in self._ranking.tolist():
            first.setdefault(self.body[index], index)
        return tuple(first.values())

    @cached_property
    def _ranking(self) -> Int:
        """The numbers (n,) of the points, ordered from weak to strong.

        Forces that differ only by rounding keep the order of the points.
        """
        with np.errstate(divide="ignore"):
            magnitude = np.floor(np.log10(self.force)) - SIGNIFICANT
        unit = np.where(np.isfinite(magnitude), 10.0 ** np.where(np.isfinite(magnitude), magnitude, 0), 1.0)
        return np.argsort(np.round(self.force / unit) * unit, kind="stable")

    def at(self, index: int) -> MapPoint:
        """Return the point with number ``index``."""
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
    """Compute the robustness R to inward normal pushes over all exposed surfaces of ``bodies``.

    ``bodies`` are the names of the bodies to map; by default, all movable bodies. ``spacing`` [m] is the distance
    between neighbouring points. Nobody can push on a contact patch, or where another body is less than half a spacing
    away in front of the surface; points there are left out.

    ``gap`` is the accuracy that is asked for. An engine that proves both bounds may stop where (upper - lower) / upper
    <= ``gap``. Engine ``compliant`` solves some points and interpolates between them with an expected relative error of
    at most ``gap``; the ``error`` that it states is at most three times that. With ``gap`` = 0 every point is solved on
    its own. Engine ``graph`` ignores ``gap``.

    Raises SceneError if ``bodies`` is empty or a text, if a body is unknown, or if ``spacing`` would give more than
    2,000,000 points.
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
    state = prepared(method, assembly)
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
    """Raise SceneError if ``spacing`` [m] would give too many points, before any point is computed."""
    area = sum(assembly.scene.body(name).surface_world.area for name in names)
    expected = area / spacing**2
    if expected > MAX_POINTS:
        problem = f"spacing {spacing:g} m gives about {expected:,.0f} points on {area:.3g} m²"
        remedy = f"use {np.sqrt(area / MAX_POINTS) * 1.05:.2g} m or more, or name fewer bodies"
        raise SceneError(message("robustness_map", problem, remedy))
