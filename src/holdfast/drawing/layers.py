"""The layers of a map that a page can show and hide, as plain arrays with a colour and a text for each cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.text import escaped
from holdfast.drawing import colours
from holdfast.drawing.arrows import FORCE_RADIUS, PUSH_RADIUS, arrow_mesh, size_of
from holdfast.drawing.camera import heat_points
from holdfast.drawing.edges import feature_edges
from holdfast.drawing.marks import CONTACT, INK
from holdfast.drawing.picture import Arrow, HeatSurface, Picture, legend
from holdfast.drawing.soup import Soup, corners_of, fixed, forces, movable

FORCE_COLOUR: Final = "#1d8fd6"  # colour of contact forces
FIXED_EDGE: Final = "#a9a7a1"  # colour of the edges of fixed bodies


@dataclass(frozen=True)
class Faces:
    """Triangles (T, 3) of vertices (V, 3) [m]; ``cell`` (V,) is the cell to which each vertex belongs.

    Each cell has a colour, ``rgb`` (C, 3) in 0..1, and in ``texts`` (C,) the HTML that is shown under the pointer, or
    "". ``solid`` is True for surfaces of bodies and False for arrows.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    cell: NDArray[np.int64]
    rgb: NDArray[np.float64]
    texts: tuple[str, ...]
    solid: bool


@dataclass(frozen=True)
class Lines:
    """Segments (E, 2, 3) [m] of one colour and width [px]."""

    segments: NDArray[np.float64]
    colour: Rgb
    width: float


@dataclass(frozen=True)
class Dots:
    """Points (N, 3) [m] of one colour and diameter [px]."""

    points: NDArray[np.float64]
    colour: Rgb
    width: float


class Layer(NamedTuple):
    """The parts that one switch of the page shows and hides.

    ``swatch`` is the CSS colour beside the name. The page's script identifies the layer by its ``role``.
    """

    name: str
    swatch: str
    parts: tuple[Faces | Lines | Dots, ...]
    role: str = ""


def layers(picture: Picture) -> list[Layer]:
    """Return the layers that the picture has, in the order of the page's switches."""
    found = [*_heat(picture), *_neutral(picture), *_contacts(picture)]
    found.append(Layer("weakest pushes", INK, _arrows(picture.weakest, INK, PUSH_RADIUS * size_of(picture)), "pushes"))
    return [layer for layer in found if layer.parts]


def gradient() -> str:
    """Return the colours of the scale from weak to strong as a CSS gradient towards the right."""
    count = 32
    return (
        "linear-gradient(90deg," + ",".join(colours.hex_of(colours.sample(k / count)) for k in range(count + 1)) + ")"
    )


def sides_of(rings: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the sides (E, 2, 3) [m] of closed polylines (k, 3) [m]."""
    sides = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in rings]
    return np.concatenate([np.empty((0, 2, 3)), *sides])


def _heat(picture: Picture) -> list[Layer]:
    scale = colours.scale_of(forces(picture))
    named = {colours.Kind.FORCE: ("largest push, by colour", gradient())}
    named |= {kind: (name, colours.hex_of(colours.SPECIAL[kind])) for kind, name in legend(picture).items()}
    found = []
    for kind, (name, swatch) in named.items():
        parts = [_cells(surface, kind, scale) for surface in picture.heat if (surface.kind == kind).any()]
        found.append(Layer(name, swatch, (_joined(parts),) if parts else ()))
    return found


def _cells(surface: HeatSurface, kind: colours.Kind, scale: colours.Scale | None) -> Faces:
    corners = corners_of(surface, surface.kind == kind)
    owners, cell = np.unique(corners.cell, return_inverse=True)
    rgb = colours.colours(scale, surface.force[owners], surface.kind[owners])
    texts = tuple(surface.hover[k] for k in owners)
    return Faces(surface.vertices[corners.vertex], corners.triangles, cell, rgb, texts, solid=True)


def _joined(parts: list[Faces]) -> Faces:
    """Return several surfaces as one, so that it takes a single draw call."""
    corners = np.cumsum([0, *(len(part.vertices) for part in parts)])
    cells = np.cumsum([0, *(len(part.texts) for part in parts)])
    return Faces(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, corners, strict=False)]),
        np.concatenate([part.cell + start for part, start in zip(parts, cells, strict=False)]),
        np.concatenate([part.rgb for part in parts]),
        tuple(text for part in parts for text in part.texts),
        parts[0].solid,
    )


def welded(part: Faces) -> Faces:
    """Return the same triangles with common corners of the triangles of a cell merged.

    Corners are equal if their coordinates are equal in single precision.
    """
    place = np.ascontiguousarray(part.vertices, dtype=np.float32) + np.float32(0.0)  # -0 becomes 0
    rows = np.column_stack([place.view(np.uint32).astype(np.int64), part.cell])
    _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in the original order, which compresses well
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    kept = first[order]
    triangles = rank[number.ravel()][part.triangles]
    return Faces(part.vertices[kept], triangles, part.cell[kept], part.rgb, part.texts, part.solid)


def _neutral(picture: Picture) -> list[Layer]:
    covered = tuple(solid for solid in picture.solids if not solid.fixed)
    masked, still = movable(Picture("", "", (), covered), None), _without_undersides(fixed(picture), picture)
    floor: tuple[Faces | Lines, ...] = (
        *_surface(still, colours.FIXED),
        *_edges(still, rgb_of(FIXED_EDGE), 1.2),
    )
    return [
        Layer("covered, cannot be pushed", colours.hex_of(colours.COVERED), _surface(masked, colours.COVERED)),
        Layer("fixed bodies", colours.hex_of(colours.FIXED), floor, "fixed"),
        Layer("body edges", INK, _edges(movable(picture, None), rgb_of(INK), 1.6)),
    ]


def _without_undersides(still: Soup, picture: Picture) -> Soup:
    """Remove the faces that face down below everything else, such as the underside of a floor."""
    level = float((heat_points(picture) @ picture.up).min())
    height = (still.vertices @ picture.up)[still.triangles].max(axis=1)
    kept = ~((still.normals @ picture.up < -0.9) & (height < level))
    return Soup(still.vertices, still.triangles[kept], still.rgb[kept], still.normals[kept], still.body[kept])


def _surface(soup: Soup, colour: Rgb) -> tuple[Faces, ...]:
    if not len(soup.triangles):
        return ()
    used, corners = np.unique(soup.triangles.ravel(), return_inverse=True)
    one = np.zeros(len(used), dtype=np.int64)
    return (Faces(soup.vertices[used], corners.reshape(-1, 3), one, np.array([colour]), ("",), solid=True),)


def _edges(soup: Soup, colour: Rgb, width: float) -> tuple[Lines, ...]:
    segments = feature_edges(soup)
    return (Lines(segments, colour, width),) if len(segments) else ()


def _contacts(picture: Picture) -> list[Layer]:
    blue = rgb_of(CONTACT)
    parts: list[Lines | Dots] = []
    if picture.outlines:
        parts.append(Lines(sides_of(picture.outlines), blue, 2.5))
    if len(picture.contact_points):
        parts.append(Dots(picture.contact_points, blue, 5.0))
    arrows = _arrows(picture.contact_forces, FORCE_COLOUR, FORCE_RADIUS * size_of(picture))
    return [Layer("contact patches", CONTACT, tuple(parts)), Layer("contact forces at rest", FORCE_COLOUR, arrows)]


def _arrows(arrows: Sequence[Arrow], colour: str, radius: float) -> tuple[Faces, ...]:
    drawn = tuple(arrow for arrow in arrows if not np.array_equal(arrow.tail, arrow.head))
    if not drawn:
        return ()
    vertices, triangles = arrow_mesh(drawn, radius)
    cell = np.repeat(np.arange(len(drawn)), len(vertices) // len(drawn))
    rgb = np.tile(rgb_of(colour), (len(drawn), 1))
    return (Faces(vertices, triangles, cell, rgb, tuple(escaped(arrow.label) for arrow in drawn), solid=False),)
