"""Compute the robustness of all exposed surfaces to an inward push at one point of every surface cell.

A cell is exposed if neither a contact nor another body covers it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Bool, Float, Objects, checked_number, checked_whole, objects
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.painters import paint
from holdfast.base.progress import reported
from holdfast.base.public import Pictured, Record, Summary, column
from holdfast.base.ranges import COORDINATES, LENGTH
from holdfast.base.values import Table
from holdfast.certificates.certified import Certified
from holdfast.certificates.question import Question
from holdfast.contacts.interface import Patch
from holdfast.engines.answers import Answers, joined
from holdfast.engines.contract import EXACT, Within
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.engines.mechanism import Mode
from holdfast.engines.verdict import Status, Verdict
from holdfast.geometry.cells import Cells, blocked, surface_cells
from holdfast.geometry.hull import search_tree
from holdfast.geometry.polygon import inside, shapely_polygon
from holdfast.queries.lower_bounds import covering
from holdfast.queries.request import (
    DEFAULT_ENGINE,
    EngineChoice,
    body_numbers,
    checked_assembly,
    engine_of,
    push_columns,
)
from holdfast.queries.result import Forces, amount, gives_way, least, verdict_words
from holdfast.scene.scene import Scene

TOGETHER = 1000  # bodies are answered in one batch until the batch has this many points
MAX_POINTS = 2_000_000  # largest number of points in one map; more would exhaust the memory


class MapPoint(Record, kw_only=True):
    """One point of a robustness map, and what a push there does.

    A push of ``force`` [N] at ``point`` (3,) [m] along the inward unit vector ``direction`` (3,), both in the world
    frame, is the largest before the bodies named in ``moving`` begin to move. ``mode`` and ``status`` have the same
    meaning as in Robustness: if the status is UNDECIDED, the force 0 is no answer. ``mechanism`` is the motion in
    words.
    """

    body: str
    point: tuple[float, float, float]
    direction: tuple[float, float, float]
    force: float
    status: Status
    mode: Mode
    moving: tuple[str, ...]
    mechanism: str


class RobustnessMap(Certified, Pictured, Forces):
    """The robustness to inward pushes at n points on the exposed surfaces of bodies.

    ``points`` (n, 3) [m] and the outward unit ``normals`` (n, 3) are in the world frame; ``body`` (n,) holds the name
    of the body at each point. ``force`` (n,) [N] is the largest push along minus the normal. ``status``, ``lower``,
    ``upper``, ``moving``, ``mode`` and ``mechanism``, each (n,), have the same meaning as in Robustness.

    ``cells`` maps each body name to the surface cells that the points represent, in the order of the points. ``hidden``
    maps it to the covered cells, where no push is possible.
    """

    assembly: Assembly
    points: Float = column("n 3")
    normals: Float = column("n 3")
    body: Objects = column("n", of=str)
    cells: Table[str, Cells]
    hidden: Table[str, Cells]

    plain = "points normals body force status lower upper moving mode"

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the cells that were read from a file are not those of the points."""
        named = [name for name, cells in self.cells.items() for _ in cells.points]
        if named != self.body.tolist() or not all(map(_whole, (*self.cells.values(), *self.hidden.values()))):
            raise HoldfastError(message("map", "its cells are not those of its points", "needs a cell for each point"))

    def save_html(self, path: str | os.PathLike[str]) -> None:
        """Write the map as one HTML page that opens offline and shows the largest push under the pointer."""
        paint(self, path, ".html")

    def save_glb(self, path: str | os.PathLike[str]) -> None:
        """Write the map as a glTF file: a node for each body, with the colours of the picture at its vertices.

        ``_FORCE`` of a vertex is the largest push [N]: 3.4028235e38 where no push moves anything, -1 where it is
        undecided and -2 where the surface is covered or fixed. ``_KIND`` says which: 0 a force, 1 no push moves it, 2
        it is only balanced, 3 it falls without a push, 4 undecided, 5 no value. Places are in metres with y up: (x, y,
        z) is at (x, z, -y). The ``extras`` of the scene hold the legend, under ``holdfast_map``.
        """
        paint(self, path, ".glb")

    def save_ply(self, path: str | os.PathLike[str]) -> None:
        """Write the map as a PLY file with the colours of the picture at its vertices.

        Their properties ``force`` and ``kind`` are as in ``save_glb``, but infinity is ``inf``; ``body`` is a number.
        Places are those of the scene; comments hold the names of bodies and the legend.
        """
        paint(self, path, ".ply")

    @property
    def questions(self) -> tuple[Question, ...]:
        """The pushes that a certificate proves."""
        columns = [
            push_columns(self.assembly, self.assembly.index[name], cells.points, -cells.normals)
            for name, cells in self.cells.items()
        ]
        return (Question.of(self.assembly, np.hstack(columns), self.points),)

    def where(self, row: int) -> dict[str, Any]:
        """Return the body and the point that a row answers, as plain data."""
        return {"body": self.body[row], "point": to_dict(self.points[row])}

    def about(self) -> dict[str, Any]:
        """Return what applies to the whole map as plain data, and its weakest points."""
        weakest = self.weakest() if len(self.force) else None
        points = {"weakest": to_dict(weakest), "weakest_of_each_body": to_dict(self.weakest_of_each_body())}
        return {"scene": self.assembly.scene.name} | super().about() | points

    def summary(self) -> Summary:
        """Summarise the map by the weakest point of every body."""
        name = self.assembly.scene.name or "assembly"
        headline = (
            f"{name}: {verdict_words(self.verdict)}; {len(self.force):,} inward pushes, {least(self.answers, 'N')}"
        )
        rows = [
            [
                self.body[k],
                amount(self.status[k], self.force[k], "N"),
                str(self.status[k]),
                gives_way(self.mode[k], self.moving[k]),
            ]
            for k in self._weakest_of_each_body
        ]
        return Summary(headline, self.facts(), ("weakest of", "force", "status", "what gives way"), rows, self.notes)

    def weakest(self) -> MapPoint:
        """Return the point where the smallest push moves something; among equal points, the first.

        If no push moves anything, its force is infinite. Undecided points are skipped. If all points are undecided, the
        status of the returned point is UNDECIDED, and its force 0 is no answer.
        """
        return self.at(int(self.answers.ranking[0]))

    def strongest(self) -> MapPoint:
        """Return the point that withstands the largest push; among equal points, the first.

        Its force is infinite if no push there moves anything. Undecided points are skipped. If all points are
        undecided, the status of the returned point is UNDECIDED, and its force 0 is no answer.
        """
        return self.at(int(np.argmax(np.where(self.answers.decided, self.force, -np.inf))))

    def weakest_of_each_body(self) -> tuple[MapPoint, ...]:
        """Return the weakest point of every body, beginning with the weakest body.

        Bodies without a decided point come last, with a point whose status is UNDECIDED.
        """
        return tuple(self.at(index) for index in self._weakest_of_each_body)

    @cached_property
    def _weakest_of_each_body(self) -> tuple[int, ...]:
        first: dict[str, int] = {}
        for index in self.answers.ranking.tolist():
            first.setdefault(self.body[index], index)
        return tuple(first.values())

    def at(self, index: int) -> MapPoint:
        """Return the point with number ``index``, from 0; -1 is the last one. Raises HoldfastError for any other."""
        count = len(self.points)
        index = checked_whole(index, "robustness map: index", -count, count - 1, HoldfastError)
        return map_point(self.answers, index, self.body[index], self.points[index], self.normals[index])


def map_point(answers: Answers, row: int, body: str, point: Float, normal: Float) -> MapPoint:
    """Return one ``row`` of answers as an inward push at a ``point`` (3,) [m] of a body with the outward ``normal``."""
    px, py, pz = (float(v) for v in point)
    dx, dy, dz = (0.0 - float(v) for v in normal)
    motion = answers.mechanism[row]
    return MapPoint(
        body=body,
        point=(px, py, pz),
        direction=(dx, dy, dz),
        force=float(answers.force[row]),
        status=answers.status[row],
        mode=answers.mode[row],
        moving=answers.moving[row],
        mechanism="" if motion is None else motion.text,
    )


def _whole(cells: Cells) -> bool:
    """Return whether cells that were read from a file have consistent indices."""
    corners, owners = cells.triangles, cells.cell
    within = (corners >= 0) & (corners < len(cells.vertices))
    return bool(within.all() and ((owners >= 0) & (owners < len(cells.points))).all())


def robustness_map(
    assembly: Assembly | Scene,
    bodies: Sequence[str] | None = None,
    *,
    spacing: float = 0.01,
    engine: EngineChoice = DEFAULT_ENGINE,
    accuracy: float = 0.01,
    imperfect: Imperfect | None = None,
) -> RobustnessMap:
    """Compute the robustness R to inward normal pushes over all exposed surfaces of ``bodies``.

    ``bodies`` are the names of the bodies to map; by default, all movable bodies. ``spacing`` [m] is the distance
    between neighbouring points. They are the middles of cells, half a spacing inside the edges, where pushes withstand
    less. Points on a contact patch are left out, and so are points where another body is less than half a spacing away
    in front of the surface.

    Engines ``compliant`` and ``graph`` answer every point as ``robustness`` answers a push there. Engine ``limit``,
    which proves both bounds, stops where (upper - lower) / upper <= ``accuracy``; with 0 it, too, solves every point.

    ``imperfect`` has the same meaning as in ``robustness``. The weakest tenth of each body's points is computed on all
    samples, and the rest only on the samples that are worst for these points.

    Raises SceneError if ``bodies`` is empty or a text, if a body is unknown, or if ``spacing`` would give more than
    2,000,000 points.
    """
    assembly = checked_assembly(assembly)
    step = checked_number(spacing, "robustness_map: spacing", above=0, within=LENGTH)
    wanted = checked_number(accuracy, "robustness_map: accuracy", minimum=0)
    if bodies is None and not assembly.movable:
        raise SceneError(message("robustness_map", "there is no movable body", "name bodies, or free one"))
    names = [body.name for body in assembly.movable] if bodies is None else bodies
    numbers = body_numbers(assembly, names, "robustness_map")
    check_count(assembly, list(numbers), step)
    method = engine_of(engine)
    state, covers = prepared(method, assembly), covering(imperfect, method, assembly)
    shown: dict[str, Cells] = {}
    hidden: dict[str, Cells] = {}
    within = EXACT if wanted == 0 else Within(wanted)
    answers: list[Answers] = []
    waiting: list[Float] = []
    for place, (name, index) in enumerate(reported("robustness of all surfaces", list(numbers.items())), start=1):
        shown[name], hidden[name] = exposed_cells(assembly, name, step)
        waiting.append(push_columns(assembly, index, shown[name].points, -shown[name].normals))
        ends = np.cumsum([columns.shape[1] for columns in waiting])
        if place < len(numbers) and ends[-1] < TOGETHER:
            continue
        found = state.load_factor(np.hstack(waiting), within)
        for columns, end in zip(waiting, ends.tolist(), strict=True):
            own = found.rows(slice(end - columns.shape[1], end))
            answers.append(own if covers is None else covers.over_surface(own, columns))
        waiting = []
    movable = [number for number in numbers.values() if number != FIXED]
    verdict = state.verdict_on(movable)
    return _map_of(assembly, replace(joined(answers), verdict=verdict), shown, hidden)


def _map_of(
    assembly: Assembly, answers: Answers, shown: Mapping[str, Cells], hidden: Mapping[str, Cells]
) -> RobustnessMap:
    return RobustnessMap(
        answers=answers,
        assembly=assembly,
        points=np.vstack([cells.points for cells in shown.values()]),
        normals=np.vstack([cells.normals for cells in shown.values()]),
        body=objects([name for name, cells in shown.items() for _ in cells.points]),
        cells=Table(shown),
        hidden=Table(hidden),
    )


def joined_maps(parts: Sequence[RobustnessMap], verdict: Verdict) -> RobustnessMap:
    """Join maps of different bodies of one assembly into one, in order, with this ``verdict``.

    The parts must have been computed with the same spacing, engine and accuracy. Raises HoldfastError if there are
    none.
    """
    answers = replace(joined([part.answers for part in parts]), verdict=verdict)
    shown = {name: cells for part in parts for name, cells in part.cells.items()}
    hidden = {name: cells for part in parts for name, cells in part.hidden.items()}
    return _map_of(parts[0].assembly, answers, shown, hidden)


def expected_points(assembly: Assembly, names: Sequence[str], spacing: float) -> float:
    """Estimate the number of points of a map of these bodies at this ``spacing`` [m]; covered surfaces have none."""
    return _area(assembly, names) / spacing**2


def spacing_for(assembly: Assembly, names: Sequence[str], count: float) -> float:
    """Return the spacing [m] at which the surfaces of these bodies have about so many points."""
    return float(np.sqrt(_area(assembly, names) / count))


def _area(assembly: Assembly, names: Sequence[str]) -> float:
    return float(sum(assembly.scene.body(name).surface_world.area for name in names))


def check_count(assembly: Assembly, names: Sequence[str], spacing: float) -> None:
    """Raise SceneError if ``spacing`` [m] would give too many points, before any point is computed."""
    area, expected = _area(assembly, names), expected_points(assembly, names, spacing)
    if expected > MAX_POINTS:
        problem = f"spacing {spacing:g} m gives about {expected:,.0f} points on {area:.3g} m²"
        remedy = f"use {np.sqrt(area / MAX_POINTS) * 1.05:.2g} m or more, or name fewer bodies"
        raise SceneError(message("robustness_map", problem, remedy))


def exposed_cells(assembly: Assembly, name: str, spacing: float) -> tuple[Cells, Cells]:
    """Divide the surface of a body into cells, and return the exposed and the covered ones.

    ``spacing`` [m] is the distance between neighbouring cells. A cell is covered if it lies on a contact patch, or if
    another body is less than half a spacing away in front of it.
    """
    cells = surface_cells(assembly.scene.body(name).surface_world, spacing)
    under = np.zeros(len(cells.points), dtype=bool)
    for interface in assembly.interfaces:
        if name in interface.bodies:
            gap = assembly.tolerances.base(*(assembly.scene.body(other) for other in interface.bodies))
            under |= covered(cells, interface.patches, gap)
    for other in assembly.bodies:
        if other.name != name:
            under |= blocked(cells, other.surface_world, spacing / 2)
    return cells.chosen(~under), cells.chosen(under)


def covered(cells: Cells, patches: Sequence[Patch], gap: float) -> Bool:
    """Return for each of the C cells whether its point lies on a contact face: a boolean array (C,).

    A point lies on a face patch if it is within ``gap`` [m] of the patch's plane and inside its outline, and if the
    cell is roughly parallel to the patch. Contacts along lines and at points cover nothing. A merged patch covers the
    points that are near one of its ``spots``: nearer than the side of a square with the area of that spot.
    """
    result = np.zeros(len(cells.points), dtype=bool)
    for patch in patches:
        if patch.spots is not None:
            distance, spot = search_tree(patch.spots.points).query(cells.points)
            along = np.abs((cells.normals * patch.spots.normals[spot]).sum(1)) > 0.9
            result |= along & (distance <= gap + np.sqrt(patch.spots.shares[spot]))
            continue
        if patch.kind != "face":
            continue
        arm = cells.points - patch.polygon[0]
        near = (np.abs(arm @ patch.normal) <= gap) & (np.abs(cells.normals @ patch.normal) > 0.9)
        if near.any():
            outline = shapely_polygon(patch.rings).buffer(-COORDINATES * patch.size)
            result[near] |= inside(outline, arm[near] @ patch.frame.T)
    return result
