"""Pictures of scenes and of maps of robustness: bodies, contacts, forces at rest and the weakest pushes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Int
from holdfast.base.ranges import COORDINATES
from holdfast.base.text import LONGEST_NAME, escaped, listed, one_line
from holdfast.drawing.colours import Kind
from holdfast.drawing.picture import Arrow, HeatSurface, Picture, Solid
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import ContactForces, Status
from holdfast.geometry.cells import Cells
from holdfast.geometry.hull import search_tree
from holdfast.geometry.polygon import inside, shapely_polygon
from holdfast.queries.map import RobustnessMap
from holdfast.queries.result import endless, kind_of, promised
from holdfast.report.description import WORDS, what_moves
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

LONGEST_FORCE = 0.18  # length of the arrow of the largest contact force, as a share of the assembly's size
WEAK_ARROW = 0.12  # length of the arrows at the weakest points, as a share of the assembly's size
SHOWN_WEAKEST = 5  # largest number of bodies whose weakest push is shown
_KINDS = {Status.INFINITE: Kind.ENDLESS, Status.UNSTABLE: Kind.FALLS, Status.UNDECIDED: Kind.UNDECIDED}


def solids_of(bodies: Iterable[Body]) -> tuple[Solid, ...]:
    """Return the surfaces of bodies, world frame."""
    return tuple(Solid(b.name, b.surface_world.vertices, b.surface_world.faces, b.fixed) for b in bodies)


def bare_picture(scene: Scene, without: str = "") -> Picture:
    """Return a picture, without a map, of the bodies of a scene except the one named ``without``."""
    return Picture("", "", (), solids_of(body for body in scene.bodies if body.name != without), up=scene.up)


def picture_of(result: RobustnessMap) -> Picture:
    """Return the heat map with contacts, contact forces at rest and the weakest push on each body."""
    assembly, forces = result.assembly, result.verdict.forces
    rims = {name: rims_of(result, name) for name in result.cells}
    heat = [_surface(result, name, rims[name]) for name, cells in result.cells.items() if len(cells.points)]
    hidden = {name: rim.covered for name, rim in rims.items() if len(rim.covered.points)}
    covered = [Solid(name, cells.vertices, cells.triangles, False) for name, cells in hidden.items()]
    caution = ", may be too high off-centre" if result.claim is Claim.ESTIMATED else ""
    engine = f"engine {result.engine} ({result.claim.words}{caution})"
    parts = [WORDS[result.verdict.status], engine, f"{len(result.force):,} inward pushes"]
    promise = promised(result.answers, "N")
    if promise:
        parts.append(f"{promise} at each of these points")
    row = result.answers.holding
    if row is not None and result.status[row] is Status.INFINITE and result.lower[row] == 0:
        parts.append(f"{endless(result.answers, row, 'N')} at some")
    if result.undecided.count:
        parts.append(result.undecided.text)
    length, arrows = WEAK_ARROW * result.assembly.size, []
    for weak in [weak for weak in result.weakest_of_each_body() if weak.status is Status.FINITE][:SHOWN_WEAKEST]:
        how = f"{_newton(weak.force) if weak.force > 0 else 'the smallest push'}, "
        how += what_moves(weak.body, weak.mode, weak.moving)
        head, way = np.array(weak.point), np.array(weak.direction)
        arrows.append(Arrow(head - length * way, head, f"{one_line(weak.body, LONGEST_NAME)}: {how}"))
    return Picture(
        title=f"{assembly.scene.name or 'assembly'}: largest push before something moves",
        subtitle=" · ".join(parts),
        heat=tuple(heat),
        solids=(*solids_of(body for body in assembly.bodies if body.name not in result.cells), *covered),
        outlines=outlines_of(assembly),
        contact_points=np.empty((0, 3)) if forces is None else forces.points,
        contact_forces=() if forces is None else force_arrows(assembly, forces),
        weakest=tuple(arrows),
        up=assembly.scene.up,
    )


def _surface(result: RobustnessMap, name: str, rims: Rims) -> HeatSurface:
    cells = result.cells[name]  # with the rims, which have the same vertices
    numbers = np.flatnonzero(result.body == name).tolist()
    return HeatSurface(
        name, cells.vertices, np.concatenate([cells.triangles, rims.triangles]),
        np.concatenate([cells.cell, rims.beside]), cells.points, result.force[numbers],
        tuple(_hover(result, k) for k in numbers), np.array([_kind(result, k) for k in numbers], dtype=np.int64),
    )  # fmt: skip


def _kind(result: RobustnessMap, k: int) -> Kind:
    return _KINDS.get(result.status[k], Kind.FORCE if result.force[k] > 0 else Kind.BALANCED)


def _hover(result: RobustnessMap, k: int) -> str:
    place = ", ".join(f"{v:.3f}" for v in result.points[k])
    lines = [f"<b>{escaped(result.body[k], LONGEST_NAME)}</b> at ({place}) m"]
    status, kind = result.status[k], _kind(result, k)
    if status is Status.UNDECIDED:
        return "<br>".join([*lines, "<b>undecided</b>: this force is not known"])
    lines.append(f"push inward: <b>{_newton(result.force[k])}</b>")
    if kind is Kind.BALANCED:
        lines.append("only balanced: the smallest push moves it")
    if status is Status.FINITE:
        lines.append(escaped(f"{kind_of(result.mode[k])}: {listed(result.moving[k])} moves"))
    elif status is Status.INFINITE:
        lines.append(escaped(endless(result.answers, k, "N")))
    else:
        lines.append("falls without a push")
    return "<br>".join(lines)


def _newton(force: float) -> str:
    return "∞" if np.isinf(force) else f"{force:.0f} N" if force >= 1000 else f"{force:.3g} N"


def outlines_of(assembly: Assembly) -> tuple[Float, ...]:
    """Return the borders (k, 3) [m] of all contact patches and of their holes."""
    return tuple(ring for i in assembly.interfaces for patch in i.patches for ring in (patch.polygon, *patch.holes))


def force_arrows(assembly: Assembly, forces: ContactForces) -> tuple[Arrow, ...]:
    """Return one arrow for each interface: the total force on its second body, at the centre of pressure."""
    arrows: list[tuple[Float, Float, str]] = []
    for number, interface in enumerate(assembly.interfaces):
        here = forces.interface == number
        total = forces.force[here].sum(0)
        normal = np.maximum((forces.force[here] * forces.normal[here]).sum(1), 0)
        if not normal.sum() > 0:
            continue
        centre = normal @ forces.points[here] / normal.sum()
        a, b = (one_line(name, LONGEST_NAME) for name in interface.bodies)
        arrows.append((centre, total, f"{a} on {b}: {np.linalg.norm(total):.3g} N"))
    largest = max((float(np.linalg.norm(force)) for _, force, _ in arrows), default=1.0)
    scale = LONGEST_FORCE * assembly.size / largest
    return tuple(Arrow(centre - scale * force, centre, label) for centre, force, label in arrows)


class Rims(NamedTuple):
    """The ``covered`` cells that show no rim, and the ``triangles`` (T, 3) of the others.

    ``beside`` (T,) is the number of the exposed cell nearest to each of these triangles.
    """

    covered: Cells
    triangles: Int
    beside: Int


def rims_of(result: RobustnessMap, name: str) -> Rims:
    """Divide the covered cells of a body into those that contact faces cover and rims, which reach beyond them.

    What shows of a rim takes the answer of the nearest exposed cell that faces the same way. A cell without one
    remains covered, and so does one that another body only comes near.
    """
    hidden, shown = result.hidden[name], result.cells[name]
    if not len(hidden.points) or not len(shown.points):
        return Rims(hidden, np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64))
    corners, size = hidden.vertices[hidden.triangles], float(np.sqrt(hidden.areas).mean())
    on_patch, beyond = np.zeros(len(hidden.points), dtype=bool), np.ones(corners.shape[:2], dtype=bool)
    patches = (patch for i in result.assembly.interfaces if name in i.bodies for patch in i.patches)
    for patch in patches:
        if patch.kind != "face" or patch.spots is not None:
            continue
        outline, origin = shapely_polygon(patch.rings), patch.polygon[0]
        level = np.abs((hidden.points - origin) @ patch.normal) < size / 4
        near = level & (np.abs(hidden.normals @ patch.normal) > 0.9)
        on_patch[near] |= inside(outline, (hidden.points[near] - origin) @ patch.frame.T)
        near_corners = near[hidden.cell]
        places = (corners[near_corners] - origin).reshape(-1, 3) @ patch.frame.T
        beyond[near_corners] &= ~inside(outline.buffer(COORDINATES * patch.size), places).reshape(-1, 3)
    turned = result.assembly.size  # distance that a unit difference of normals counts as
    tree = search_tree(np.hstack([shown.points, turned * shown.normals]))
    beside = np.asarray(tree.query(np.hstack([hidden.points, turned * hidden.normals]))[1], dtype=np.int64)
    alike = (shown.normals[beside] * hidden.normals).sum(1) > 0.9
    rim = on_patch & alike & (np.bincount(hidden.cell, beyond.any(1), minlength=len(on_patch)) > 0)
    shows = rim[hidden.cell]
    return Rims(hidden.chosen(~rim), hidden.triangles[shows], beside[hidden.cell[shows]])
