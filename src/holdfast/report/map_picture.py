"""Build the picture of a robustness map: coloured surfaces, contact outlines and arrows of forces."""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.text import LONGEST_NAME, escaped, listed, one_line
from holdfast.drawing.colours import Kind
from holdfast.drawing.glb_map import write_glb
from holdfast.drawing.html import write_html
from holdfast.drawing.picture import Arrow, HeatSurface, Picture, Solid
from holdfast.drawing.ply_map import write_ply
from holdfast.drawing.png import write_png
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import ContactForces, Status
from holdfast.queries.map import RobustnessMap
from holdfast.queries.result import promised
from holdfast.report.bodies import solids_of
from holdfast.report.rims import Rims, rims_of
from holdfast.report.texts import WORDS, what_moves

LONGEST_FORCE = 0.18  # length of the arrow of the largest contact force, as a share of the assembly's size
WEAK_ARROW = 0.12  # length of the arrows at the weakest points, as a share of the assembly's size
SHOWN_WEAKEST = 5  # largest number of bodies whose weakest push is shown
_KINDS = {Status.INFINITE: Kind.ENDLESS, Status.UNSTABLE: Kind.FALLS, Status.UNDECIDED: Kind.UNDECIDED}


def save_png(result: RobustnessMap, path: str | os.PathLike[str]) -> None:
    """Write the map as a PNG picture; this needs no display."""
    write_png(picture_of(result), path)


def save_html(result: RobustnessMap, path: str | os.PathLike[str]) -> None:
    """Write the map as one HTML page that opens offline and shows the largest push under the pointer."""
    write_html(picture_of(result), path)


def save_glb(result: RobustnessMap, path: str | os.PathLike[str]) -> None:
    """Write the map as a glTF file with colours and forces at its vertices."""
    write_glb(picture_of(result), path)


def save_ply(result: RobustnessMap, path: str | os.PathLike[str]) -> None:
    """Write the map as a PLY file with colours and forces at its vertices."""
    write_ply(picture_of(result), path)


def picture_of(result: RobustnessMap) -> Picture:
    """Return the heat map with contacts, contact forces at rest and the weakest push on each body."""
    assembly = result.assembly
    rims = {name: rims_of(result, name) for name in result.cells}
    heat = [_surface(result, name, rims[name]) for name, cells in result.cells.items() if len(cells.points)]
    return Picture(
        title=_title(result),
        subtitle=_subtitle(result),
        heat=tuple(heat),
        solids=_solids(result, rims),
        outlines=outlines_of(assembly),
        contact_points=np.empty((0, 3)) if result.verdict.forces is None else result.verdict.forces.points,
        contact_forces=() if result.verdict.forces is None else force_arrows(assembly, result.verdict.forces),
        weakest=_weak_arrows(result),
        up=assembly.scene.up,
    )


def _title(result: RobustnessMap) -> str:
    name = result.assembly.scene.name or "assembly"
    return f"{name}: largest push before something moves"


def _subtitle(result: RobustnessMap) -> str:
    verdict = WORDS[result.verdict.status]
    caution = ", may be too high off-centre" if result.claim is Claim.ESTIMATED else ""
    unknown = f" · {result.undecided.text}" if result.undecided.count else ""
    engine = f"engine {result.engine} ({result.claim.words}{caution})"
    held = promised(result.answers, "N")
    everywhere = f" · {held} everywhere" if held else ""
    return f"{verdict} · {engine} · {len(result.force):,} inward pushes{everywhere}{unknown}"


def _surface(result: RobustnessMap, name: str, rims: Rims) -> HeatSurface:
    cells = result.cells[name]  # with the rims, which have the same vertices
    numbers = [k for k, body in enumerate(result.body) if body == name]
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
        lines.append(escaped(f"{result.mode[k]}: {listed(result.moving[k])} moves"))
    elif status is Status.INFINITE:
        lines.append("no push moves anything")
    else:
        lines.append("falls without a push")
    return "<br>".join(lines)


def _newton(force: float) -> str:
    return "∞" if np.isinf(force) else f"{force:.0f} N" if force >= 1000 else f"{force:.3g} N"


def _solids(result: RobustnessMap, rims: Mapping[str, Rims]) -> tuple[Solid, ...]:
    whole = solids_of(body for body in result.assembly.bodies if body.name not in result.cells)
    covered = (
        Solid(name, rim.covered.vertices, rim.covered.triangles, False)
        for name, rim in rims.items()
        if len(rim.covered.points)
    )
    return (*whole, *covered)


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


def _weak_arrows(result: RobustnessMap) -> tuple[Arrow, ...]:
    length = WEAK_ARROW * result.assembly.size
    weakest = [weak for weak in result.weakest_of_each_body() if weak.status is Status.FINITE]
    return tuple(
        Arrow(
            np.array(weak.point) - length * np.array(weak.direction),
            np.array(weak.point),
            f"{one_line(weak.body, LONGEST_NAME)}: "
            f"{_newton(weak.force) if weak.force > 0 else 'the smallest push'}, "
            f"{what_moves(weak.body, weak.mode, weak.moving)}",
        )
        for weak in weakest[:SHOWN_WEAKEST]
    )
