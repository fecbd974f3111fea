"""All triangles of a picture in one array, each with its colour."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holdfast.drawing import colours
from holdfast.drawing.picture import HeatSurface, Picture, Solid
from holdfast.geometry.area import normals_of

Part = TypeVar("Part", HeatSurface | Solid, Solid)


@dataclass(frozen=True)
class Soup:
    """Triangles (T, 3) of vertices (V, 3) [m].

    Each triangle has a colour (T, 3) in 0..1, a unit normal (T, 3) and a body number (T,).
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    rgb: NDArray[np.float64]
    normals: NDArray[np.float64]
    body: NDArray[np.int64]


def forces(picture: Picture) -> NDArray[np.float64]:
    """Return the force [N] of every cell of the picture, (C,) over all surfaces."""
    return np.concatenate([*(surface.force for surface in picture.heat), np.empty(0)])


def movable(picture: Picture, scale: colours.Scale | None) -> Soup:
    """Return the coloured surfaces and the covered parts of the same bodies."""
    return soup_of(_movable_parts(picture), lambda part: _rgb(part, scale))


def movable_names(picture: Picture) -> list[str]:
    """Return the names of the bodies of ``movable``, in the order of their numbers."""
    return list(dict.fromkeys(part.name for part in _movable_parts(picture)))


def fixed(picture: Picture) -> Soup:
    """Return the bodies that never move."""
    return soup_of([solid for solid in picture.solids if solid.fixed], lambda part: _rgb(part, None))


def soup_of(parts: Iterable[Part], paint: Callable[[Part], ArrayLike]) -> Soup:
    """Return the triangles of all parts; parts with the same name are one body.

    ``paint`` returns the colour of a part, either (3,) or one for each of its triangles (T, 3).
    """
    vertices, triangles, rgb, body = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty((0, 3))], [[0][:0]]
    names: dict[str, int] = {}
    count = 0
    for part in parts:
        vertices.append(part.vertices)
        triangles.append(part.triangles + count)
        rgb.append(np.broadcast_to(np.asarray(paint(part), dtype=float), (len(part.triangles), 3)))
        body.append([names.setdefault(part.name, len(names))] * len(part.triangles))
        count += len(part.vertices)
    points, faces = np.concatenate(vertices), np.concatenate(triangles)
    numbers = np.concatenate([np.asarray(b, dtype=np.int64) for b in body])
    return Soup(points, faces, np.concatenate(rgb), normals_of(points, faces), numbers)


class Corners(NamedTuple):
    """Corners (N,) of triangles (T, 3), each of one cell: the vertex of the surface and the cell of each corner."""

    vertex: NDArray[np.int64]
    cell: NDArray[np.int64]
    triangles: NDArray[np.int64]


def corners_of(surface: HeatSurface, shown: NDArray[np.bool_] | None = None) -> Corners:
    """Return the corners of the cells of a surface, or of its ``shown`` (C,) cells.

    Cells share no corners, so that each corner can have the colour and the value of its cell.
    """
    kept = np.ones(len(surface.cell), dtype=bool) if shown is None else shown[surface.cell]
    keys = surface.cell[kept][:, None] * len(surface.vertices) + surface.triangles[kept]
    unique, inverse = np.unique(keys.ravel(), return_inverse=True)
    return Corners(unique % len(surface.vertices), unique // len(surface.vertices), inverse.reshape(-1, 3))


def _movable_parts(picture: Picture) -> list[HeatSurface | Solid]:
    return [*picture.heat, *(solid for solid in picture.solids if not solid.fixed)]


def _rgb(part: HeatSurface | Solid, scale: colours.Scale | None) -> ArrayLike:
    if isinstance(part, HeatSurface):
        return colours.colours(scale, part.force, part.kind)[part.cell]
    return colours.FIXED if part.fixed else colours.COVERED
