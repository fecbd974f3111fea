"""The parts of the 3D page as plotly traces, which are plain dictionaries for JSON."""

from __future__ import annotations

import base64
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import unit
from holdfast.base.text import escaped
from holdfast.view import colours
from holdfast.view.camera import heat_points
from holdfast.view.edges import feature_edges
from holdfast.view.marks import CONTACT, INK
from holdfast.view.picture import Arrow, HeatSurface, Picture, legend
from holdfast.view.soup import Soup, corners_of, fixed, forces, movable

Trace = dict[str, Any]

_FORCE_COLOUR: Final = "#1d8fd6"  # colour of contact forces
# lighting under which a surface shows exactly its colour
_UNLIT: Final = {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0, "fresnel": 0.0, "roughness": 1.0}
PUSH_RADIUS: Final = 0.0035  # radius of the arrows of pushes, as a share of the size of the picture
_SIDES: Final = 12  # number of sides of the rods and cones of an arrow


class Group(NamedTuple):
    """Traces that one switch of the page shows and hides; the page's script identifies the group by its ``role``."""

    name: str
    swatch: str
    traces: tuple[Trace, ...]
    role: str = ""


class _Cells(NamedTuple):
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    force: NDArray[np.float64]
    counts: list[int]
    texts: list[str]


def groups(picture: Picture) -> list[Group]:
    """Return the parts of the picture that exist, in the order of the page's switches."""
    scale = colours.scale_of(forces(picture))
    found = [*_heat_groups(picture, scale), *_neutral_groups(picture), *_contact_groups(picture)]
    if picture.weakest:
        found.append(
            Group("weakest pushes", INK, _arrows(picture.weakest, INK, PUSH_RADIUS * size_of(picture)), "pushes")
        )
    return [group for group in found if group.traces]


def arrow_mesh(arrows: tuple[Arrow, ...], radius: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return vertices (V, 3) [m] and triangles (T, 3) of arrows as rods of this ``radius`` [m] with cones.

    All arrows have the same number of vertices.
    """
    turn = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    ring = np.arange(_SIDES)
    following = (ring + 1) % _SIDES
    vertices, triangles = [np.empty((0, 3))], [np.empty((0, 3), np.int64)]
    count = 0
    for arrow in arrows:
        length = float(np.linalg.norm(arrow.head - arrow.tail))
        if length == 0.0:
            continue
        along = (arrow.head - arrow.tail) / length
        across = unit(np.cross(along, np.eye(3)[np.argmin(np.abs(along))]))
        circle = np.outer(np.cos(turn), across) + np.outer(np.sin(turn), np.cross(along, across))
        cap = min(5.0 * radius, 0.6 * length)
        neck = arrow.head - cap * along
        rod = radius * min(1.0, cap / (5.0 * radius) + 0.2)
        rings = [arrow.tail + rod * circle, neck + rod * circle, neck + 0.45 * cap * circle]
        vertices.append(np.concatenate([*rings, arrow.head[None], arrow.tail[None]]))
        for low in (0, _SIDES):
            a, b = ring + low, following + low
            triangles += [np.stack(part, axis=1) + count for part in ([a, b, b + _SIDES], [a, b + _SIDES, a + _SIDES])]
        tip = np.full(_SIDES, 3 * _SIDES)
        triangles.append(np.stack([ring + 2 * _SIDES, following + 2 * _SIDES, tip], axis=1) + count)
        triangles.append(np.stack([following, ring, tip + 1], axis=1) + count)
        count += 3 * _SIDES + 2
    return np.concatenate(vertices), np.concatenate(triangles)


def _packed(values: NDArray[np.float64] | NDArray[np.int64]) -> dict[str, str]:
    kind, code = (np.dtype("<f4"), "f4") if values.dtype.kind == "f" else (np.dtype("<i4"), "i4")
    return {"dtype": code, "bdata": base64.b64encode(values.astype(kind).tobytes()).decode("ascii")}


def _mesh(vertices: NDArray[np.float64], triangles: NDArray[np.int64], more: Trace) -> Trace:
    places = {axis: _packed(vertices[:, k]) for k, axis in enumerate("xyz")}
    corners = {corner: _packed(triangles[:, k]) for k, corner in enumerate("ijk")}
    return {"type": "mesh3d", **places, **corners, "lighting": _UNLIT, "flatshading": True, "showscale": False, **more}


def _lines(points: NDArray[np.float64], colour: str, width: float) -> Trace:
    places = {axis: [None if np.isnan(v) else round(float(v), 6) for v in points[:, k]] for k, axis in enumerate("xyz")}
    line = {"color": colour, "width": width}
    return {"type": "scatter3d", "mode": "lines", **places, "line": line, "hoverinfo": "skip"}


def _broken(pieces: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    gap = np.full((1, 3), np.nan)
    return np.concatenate([np.concatenate([piece, gap]) for piece in pieces])


def _cells(surfaces: tuple[HeatSurface, ...], kind: colours.Kind) -> _Cells:
    vertices, triangles, force = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty(0)]
    counts: list[int] = []
    texts: list[str] = []
    total = 0
    for surface in surfaces:
        corners = corners_of(surface, surface.kind == kind)
        owners, number = np.unique(corners.cell, return_counts=True)
        vertices.append(surface.vertices[corners.vertex])
        triangles.append(corners.triangles + total)
        force.append(surface.force[corners.cell])
        counts += number.tolist()
        texts += [surface.hover[k] for k in owners]
        total += len(corners.vertex)
    return _Cells(np.concatenate(vertices), np.concatenate(triangles), np.concatenate(force), counts, texts)


def _heat_groups(picture: Picture, scale: colours.Scale | None) -> list[Group]:
    named = {colours.Kind.FORCE: ("largest push, by colour", _gradient())}
    named |= {kind: (name, colours.hex_of(colours.SPECIAL[kind])) for kind, name in legend(picture).items()}
    result = []
    for kind, (name, colour) in named.items():
        cells = _cells(picture.heat, kind)
        paint: Trace = {"color": colour}
        if kind is colours.Kind.FORCE and scale is not None:
            paint = {"intensity": _packed(scale.position(cells.force)), "coloraxis": "coloraxis"}
        hover = {"hovertemplate": "%{text}<extra></extra>", "cell_texts": cells.texts, "cell_counts": cells.counts}
        mesh = _mesh(cells.vertices, cells.triangles, {**paint, **hover, "solid_body": True})
        result.append(Group(name, colour, (mesh,) if len(cells.triangles) else ()))
    return result


def _gradient() -> str:
    return "linear-gradient(90deg," + ",".join(colours.hex_of(colours.sample(k / 6.0)) for k in range(7)) + ")"


def _neutral_groups(picture: Picture) -> list[Group]:
    edges = _edge_trace(movable(picture, None), INK, 2.5)
    still = _without_undersides(fixed(picture), picture)
    covered = [solid for solid in picture.solids if not solid.fixed]
    masked = movable(Picture("", "", (), tuple(covered)), None)
    grey, dark = colours.hex_of(colours.FIXED), colours.hex_of(colours.COVERED)
    floor = (_solid(still, grey), *_edge_trace(still, "#a9a7a1", 2.0))
    return [
        Group("covered, cannot be pushed", dark, (_solid(masked, dark),) if covered else ()),
        Group("fixed bodies", grey, floor if len(still.triangles) else (), "fixed"),
        Group("body edges", INK, edges),
    ]


def _without_undersides(still: Soup, picture: Picture) -> Soup:
    """Leave out the faces that face down beneath everything else.

    Those of a cropped floor would look like a second sheet.
    """
    level = float((heat_points(picture) @ picture.up).min())
    height = (still.vertices @ picture.up)[still.triangles].max(axis=1)
    kept = ~((still.normals @ picture.up < -0.9) & (height < level))
    return Soup(still.vertices, still.triangles[kept], still.rgb[kept], still.normals[kept], still.body[kept])


def _solid(soup: Soup, colour: str) -> Trace:
    return _mesh(soup.vertices, soup.triangles, {"color": colour, "hoverinfo": "skip", "solid_body": True})


def _edge_trace(soup: Soup, colour: str, width: float) -> tuple[Trace, ...]:
    edges = feature_edges(soup)
    return (_lines(_broken(list(edges)), colour, width),) if len(edges) else ()


def _contact_groups(picture: Picture) -> list[Group]:
    patches = (_lines(_broken(list(picture.outlines)), CONTACT, 4.0),) if picture.outlines else ()
    nodes: tuple[Trace, ...] = ()
    if len(picture.contact_points):
        places = {axis: np.round(picture.contact_points[:, k], 6).tolist() for k, axis in enumerate("xyz")}
        marker = {"size": 3.0, "color": CONTACT}
        nodes = ({"type": "scatter3d", "mode": "markers", **places, "marker": marker, "hoverinfo": "skip"},)
    arrows = _arrows(picture.contact_forces, _FORCE_COLOUR, 0.0022 * size_of(picture))
    return [
        Group("contact patches", CONTACT, (*patches, *nodes)),
        Group("contact forces at rest", _FORCE_COLOUR, arrows),
    ]


def _arrows(arrows: tuple[Arrow, ...], colour: str, radius: float) -> tuple[Trace, ...]:
    drawn = tuple(arrow for arrow in arrows if not np.array_equal(arrow.tail, arrow.head))
    if not drawn:
        return ()
    vertices, triangles = arrow_mesh(drawn, radius)
    texts = [escaped(arrow.label) for arrow in drawn]
    hover = {"hovertemplate": "%{text}<extra></extra>", "cell_texts": texts}
    counts = [len(vertices) // len(drawn)] * len(drawn)
    return (_mesh(vertices, triangles, {"color": colour, "cell_counts": counts, **hover}),)


def size_of(picture: Picture) -> float:
    """Return the diagonal [m] of the box around what the picture shows."""
    return float(np.linalg.norm(np.ptp(heat_points(picture), axis=0))) or 1.0
