"""Show a verdict as a table for the terminal."""

from __future__ import annotations

import numpy as np
import shapely
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import strengths_of
from holdfast.base.arrays import Float, Int
from holdfast.base.text import LONGEST_NAME, one_line
from holdfast.contacts.interface import Interface
from holdfast.engines.verdict import Status
from holdfast.queries.result import vector_text
from holdfast.queries.stability import Stability
from holdfast.report.texts import MOST_ROWS, STYLES, WORDS, cell, headline, sentence

MOST_PATCHES = 8  # largest number of patches of an interface, as under legs, that have rows of their own


def stability_report(assembly: Assembly, result: Stability) -> RenderableType:
    """Return a table with the verdict, its reason and the contacts."""
    word, style = WORDS[result.status], STYLES[result.status]
    if result.crushed:
        word, style = f"{word}, but {len(result.crushed)} crushed", STYLES[Status.UNSTABLE]
    name = assembly.scene.name or "scene"
    head = headline(name, (word, style), f"  (engine {result.engine}: {result.claim.words})")
    lines: list[RenderableType] = [head, sentence(result.reason, "dim")]
    lines += [
        sentence(f"crushed: {one.text}", "red") if one.crushed else sentence(f"bearing: {one.text}", "dim")
        for one in result.bearing[:MOST_ROWS]
    ]
    lines += [sentence(f"note: {note}", "yellow") for note in result.notes]
    movable, interfaces = len(assembly.movable), len(assembly.interfaces)
    bodies, pairs = "body" if movable == 1 else "bodies", "interface" if interfaces == 1 else "interfaces"
    lines.append(sentence(f"{movable} movable {bodies}, {interfaces} {pairs}; {assembly.tolerances.text}"))
    return Group(*lines, _contacts(assembly, result))


def _contacts(assembly: Assembly, result: Stability) -> Table:
    interfaces = len(assembly.interfaces)
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in ("between", "area [cm²]", "μ", "normal force [N]", "friction used"):  # as a share of its limit
        table.add_column(cell(heading), justify="left" if heading == "between" else "right")
    for k, interface in enumerate(assembly.interfaces[:MOST_ROWS]):
        here = np.empty(0, dtype=np.int64) if result.forces is None else np.flatnonzero(result.forces.interface == k)
        a, b = (one_line(name, LONGEST_NAME) for name in interface.bodies)
        said = interface.flags if interface.certain else (*interface.flags, "may not exist")
        flags = f" ({', '.join(said)})" if said else ""
        mu = f"{assembly.mu[k]:g}"
        table.add_row(
            cell(f"{a} - {b}{flags}"), f"{interface.area * 1e4:.4g}", mu, *_carried(assembly, result, k, here)
        )
        if not 1 < len(interface.patches) <= MOST_PATCHES:
            continue
        patch = _nearest_patch(interface, np.empty((0, 3)) if result.forces is None else result.forces.points[here])
        for number, one in enumerate(interface.patches):
            place = f"  at {vector_text(1e3 * one.centroid, '.0f')} mm"
            row = _carried(assembly, result, k, here[patch == number], one.area)
            table.add_row(cell(place), f"{one.area * 1e4:.4g}", "", *row)
    if interfaces > MOST_ROWS:
        table.add_row(f"... and {interfaces - MOST_ROWS} more", "", "", "", "")
    return table


def _carried(assembly: Assembly, result: Stability, k: int, nodes: Int, area: float | None = None) -> tuple[str, str]:
    """Return the normal force of some ``nodes`` of interface ``k``, and the share of friction in use, in words.

    ``area`` [m²] is that of their patch, by default that of the interface.
    """
    if result.forces is None:
        return "-", "-"
    interface, rounding = assembly.interfaces[k], 1e-9 * assembly.weight
    force, normal = result.forces.force[nodes], result.forces.normal[nodes]
    along = (force * normal).sum(1, keepdims=True)
    pressing, tangential = float(along.sum()), float(np.linalg.norm((force - along * normal).sum(0)))
    tension = strengths_of(assembly)[k].tension * (interface.area if area is None else area)
    limit = assembly.mu[k] * (pressing + tension)
    shown = f"{pressing:.3g}" if abs(pressing) > rounding else "0"
    return shown, f"{tangential / limit:.0%}" if limit > rounding else "-"


def _nearest_patch(interface: Interface, points: Float) -> Int:
    """Return the number (n,) of the patch on which each of the points (n, 3) lies."""
    apart = []
    for patch in interface.patches:
        ring, own = patch.rings[0], points - patch.polygon[0]
        outline = (
            shapely.Point(ring[0]) if len(ring) == 1 else (shapely.LineString, shapely.Polygon)[len(ring) > 2](ring)
        )
        apart.append(np.hypot(shapely.distance(outline, shapely.points(own @ patch.frame.T)), own @ patch.normal))
    return np.asarray(np.argmin(apart, axis=0))
