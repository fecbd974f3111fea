"""What is said about a verdict, a push and a map."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import strengths_of
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Int
from holdfast.base.public import at_least, number
from holdfast.base.text import LONGEST_NAME, one_line
from holdfast.engines.answers import Bound
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint, RobustnessMap
from holdfast.queries.push import Robustness
from holdfast.queries.result import doubted, endless, gives_way, holds_up_to, promised, vector_text
from holdfast.queries.stability import Stability
from holdfast.report import description as wording
from holdfast.report.description import MOST_ROWS, STYLES, WORDS, Headline, Line, Report, ReportTable

if TYPE_CHECKING:
    from holdfast.applications.placement.result import Placement

MOST_PATCHES = 8  # largest number of patches of an interface, as under legs, that have rows of their own


def stability_report(assembly: Assembly, result: Stability) -> Report:
    """Return the verdict, its reason and a table of the contacts."""
    word, style = WORDS[result.status], STYLES[result.status]
    if result.crushed:
        word, style = f"{word}, but {len(result.crushed)} crushed", STYLES[Status.UNSTABLE]
    bearing = [
        Line(f"crushed: {one.text}", "red") if one.crushed else Line(f"bearing: {one.text}", "dim")
        for one in result.bearing[:MOST_ROWS]
    ]
    movable = f"{len(assembly.movable)} movable {'body' if len(assembly.movable) == 1 else 'bodies'}"
    interfaces = f"{len(assembly.interfaces)} interface{'' if len(assembly.interfaces) == 1 else 's'}"
    return Report(
        Headline(assembly.scene.name or "scene", word, style, wording.by_engine(result.engine, result.claim)),
        Line(result.reason, "dim"),
        *bearing,
        *wording.noted(result.notes),
        Line(f"{movable}, {interfaces}; {assembly.tolerances.text}"),
        _contacts(assembly, result),
    )


def _contacts(assembly: Assembly, result: Stability) -> ReportTable:
    """Return the table of interfaces, with rows for their patches, and the share of the limit of friction in use."""
    rows = []
    for k, interface in enumerate(assembly.interfaces[:MOST_ROWS]):
        here = np.empty(0, dtype=np.int64) if result.forces is None else np.flatnonzero(result.forces.interface == k)
        a, b = (one_line(name, LONGEST_NAME) for name in interface.bodies)
        flags = interface.flags if interface.certain else (*interface.flags, "may not exist")
        pair = f"{a} - {b}" + (f" ({', '.join(flags)})" if flags else "")
        mu, area = f"{assembly.mu[k]:g}", f"{interface.area * 1e4:.4g}"
        rows.append((pair, area, mu, *_carried(assembly, result, k, here, interface.area)))
        if not 1 < len(interface.patches) <= MOST_PATCHES:
            continue
        points, apart = np.empty((0, 3)) if result.forces is None else result.forces.points[here], []
        for each in interface.patches:
            ring, off = each.rings[0], points - each.polygon[0]
            kind = (shapely.Point, shapely.LineString, shapely.Polygon)[min(len(ring), 3) - 1]
            outline = kind(ring[0] if len(ring) == 1 else ring)
            apart.append(np.hypot(shapely.distance(outline, shapely.points(off @ each.frame.T)), off @ each.normal))
        patch = np.asarray(np.argmin(apart, axis=0))
        for number_, one in enumerate(interface.patches):
            place = f"  at {vector_text(1e3 * one.centroid, '.0f')} mm"
            carried = _carried(assembly, result, k, here[patch == number_], one.area)
            rows.append((place, f"{one.area * 1e4:.4g}", "", *carried))
    if len(assembly.interfaces) > MOST_ROWS:
        rows.append((f"... and {len(assembly.interfaces) - MOST_ROWS} more", "", "", "", ""))
    heads = ("between", "area [cm²]", "μ", "normal force [N]", "friction used")
    return ReportTable(heads, rows, right=range(1, 5), most=len(rows))


def _carried(assembly: Assembly, result: Stability, k: int, nodes: Int, area: float) -> tuple[str, str]:
    """Return the normal force of ``nodes`` of interface ``k``, on ``area`` [m²], and the used share of friction."""
    if result.forces is None:
        return "-", "-"
    rounding = 1e-9 * assembly.weight
    force, normal = result.forces.force[nodes], result.forces.normal[nodes]
    along = (force * normal).sum(1, keepdims=True)
    pressing, tangential = float(along.sum()), float(np.linalg.norm((force - along * normal).sum(0)))
    tension = strengths_of(assembly)[k].tension * area
    limit = assembly.mu[k] * (pressing + tension)
    shown = f"{pressing:.3g}" if abs(pressing) > rounding else "0"
    return shown, f"{tangential / limit:.0%}" if limit > rounding else "-"


def interfaces_data(assembly: Assembly) -> list[dict[str, Any]]:
    """Return the interfaces of an assembly as plain data."""
    return [
        {
            "bodies": list(interface.bodies),
            "area": interface.area,
            "status": interface.status,
            "flags": list(interface.flags),
            "certain": interface.certain,
            "gap": gap,
            "mu": mu,
            "tension": strength.tension,
            "patches": [{"polygon": p.polygon.tolist(), "normal": p.normal.tolist()} for p in interface.patches],
        }
        for interface, mu, gap, strength in zip(
            assembly.interfaces, assembly.mu, assembly.gaps, strengths_of(assembly), strict=True
        )
    ]


def contact_details(assembly: Assembly) -> dict[str, Any]:
    """Return what ``holdfast assess --json`` tells of the contacts of an assembly."""
    return {
        "scene": assembly.scene.name,
        "gap": assembly.tolerances.gap,
        "gap_by_pair": assembly.tolerances.by_pair,
        "angle_degrees": assembly.tolerances.angle,
        "overlaps": to_dict(assembly.overlaps),
        "interfaces": interfaces_data(assembly),
    }


def placement_details(result: Placement) -> dict[str, Any]:
    """Return what ``holdfast place --json`` tells of the contacts of an object in place."""
    contacts = [] if result.assembly is None else interfaces_data(result.assembly)
    return {"contacts": [contact for contact in contacts if result.name in contact["bodies"]]}


def push_report(result: Robustness) -> Report:
    """Return the force of the first push of an answer, its bounds, and what moves."""
    status, force = result.status[0], float(result.force[0])
    sure = not doubted(result.answers, 0)
    without_end = f"{'however hard: ' if sure else ''}{endless(result.answers, 0, 'N')}"
    outcome, style = {
        Status.FINITE: (f"{number(force, 'N')} before something moves", "bold"),
        Status.INFINITE: (without_end, "bold green" if sure else "bold yellow"),
        Status.UNSTABLE: ("nothing: it does not stand even without a push", "bold red"),
        Status.UNDECIDED: ("undecided", "bold yellow"),
    }[status]
    lines: list[Line] = []
    mechanism = result.mechanism[0]
    if status is Status.FINITE:
        if force > 0:  # bounds of what is only balanced are rounding
            lines.append(Line("; ".join(bounds_text(result))))
        lines.append(Line(mechanism.text if mechanism else gives_way(result.mode[0], result.moving[0]), "dim"))
    if status is Status.UNDECIDED:
        lines += [Line(reason, "yellow") for reason in result.undecided.reasons]
    if status is Status.UNSTABLE:
        crushed = mechanism is not None and mechanism.mode == "crush"
        lines.append(Line(mechanism.text if mechanism and crushed else result.verdict.reason, "dim"))
    above = () if status is Status.FINITE else (*result.undecided.reasons, result.verdict.reason)
    notes = [note for note in result.notes if note not in above and not wording.repeats(note, result.verdict)]
    headline = Headline(result.body, outcome, style, wording.by_engine(result.engine, result.claim))
    return Report(headline, *lines, *wording.noted(notes))


def bounds_text(result: Robustness) -> list[str]:
    """Describe the lower and the upper bound of the first push of an answer."""
    lines = []
    if result.lower_bound is not Bound.NONE:
        lines.append(holds_up_to(result.answers, 0, "N"))
    if result.upper_bound is not Bound.NONE and math.isfinite(result.upper[0]):
        lines.append(f"{result.upper_bound} to move above {at_least(result.upper[0], 'N')}")
    return lines or ["no bound is known on either side"]


def map_report(result: RobustnessMap) -> Report:
    """Return the bound that holds at all points, and a table with the weakest point of every body."""
    status = result.verdict.status
    rest = f", {len(result.force):,} inward pushes{wording.by_engine(result.engine, result.claim)}"
    row, least = result.answers.holding, promised(result.answers, "N")
    of_all = []
    if row is not None and least:
        place = f"{one_line(result.body[row], LONGEST_NAME)} at {vector_text(1e3 * result.points[row], '.0f')} mm"
        of_all.append(Line(f"{least} at each of these points, the least on {place}"))
    rows = []
    for weak in result.weakest_of_each_body():
        here = result.body == weak.body
        *cells, what = _weakest_row(weak)
        rows.append((*cells, what + wording.partly_undecided(int((here & ~result.answers.decided).sum()), here.sum())))
    return Report(
        Headline(result.assembly.scene.name or "scene", WORDS[status], STYLES[status], rest),
        *wording.remarks(result),
        *of_all,
        ReportTable(
            ("body", "force [N]", "at [mm]", "along", "what moves"), rows, "weakest push on each body",
            right=(1,), most=30, whole=True,
        ),
    )  # fmt: skip


def _weakest_row(weak: MapPoint) -> tuple[str, ...]:
    if weak.status is Status.INFINITE:
        return weak.body, "∞", "", "", "nothing"
    if weak.status is Status.UNDECIDED:
        return weak.body, "?", "", "", "undecided"
    if weak.status is Status.UNSTABLE:
        return weak.body, "0", "", "", wording.moving_words(weak.mode, weak.moving, "falls without a push")
    place = vector_text((1e3 * v for v in weak.point), ".0f")
    steep = int(np.argmax(np.abs(weak.direction)))
    if abs(weak.direction[steep]) > 1 - 1e-9:
        along = f"{'+' if weak.direction[steep] > 0 else '-'}{'xyz'[steep]}"
    else:
        along = vector_text(np.round(weak.direction, 2), ".2f")
    what = wording.moving_words(weak.mode, weak.moving, "" if weak.force > 0 else "only balanced")
    return weak.body, f"{weak.force:.4g}", place, along, what
