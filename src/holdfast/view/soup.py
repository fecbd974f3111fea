"""All triangles of a picture in one array, each with its colour."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holdfast.view import colours
from holdfast.view.picture import HeatSurface, Picture, Solid


@dataclass(frozen=True)
class Soup:
    """Triangles (T, 3) of vertices (V, 3) [m] with colour (T, 3) 0..1, unit normal (T, 3) and body number (T,)."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    rgb: NDArray[np.float64]
    normals: NDArray[np.float64]
    body: NDArray[np.int64]


def forces(picture: Picture) -> NDArray[np.float64]:
    """Every cell's force [N] of the picture, (C,) over all surfaces."""
    return np.concatenate([*(surface.force for surface in picture.heat), np.empty(0)])


def movable(picture: Picture, scale: colours.Scale | None) -> Soup:
    """Return the coloured surfaces and the covered parts of the same bodies."""
    parts: list[HeatSurface | Solid] = [*picture.heat, *(solid for solid in picture.solids if not solid.fixed)]
    return _soup(parts, scale)


def fixed(picture: Picture) -> Soup:
    """Return the bodies that never move."""
    return _soup([solid for solid in picture.solids if solid.fixed], None)


def triangle_normals(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return unit normals (T, 3); zero where a triangle has no area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    length[length == 0.0] = 1.0
    return np.asarray(normal / length, dtype=float)


def _rgb(part: HeatSurface | Solid, scale: colours.Scale | None) -> NDArray[np.float64]:
    if isinstance(part, HeatSurface):
        return colours.colours(scale, part.force)[part.cell]
    return np.tile(np.asarray(colours.FIXED if part.fixed else colours.COVERED), (len(part.triangles), 1))


def _soup(parts: Iterable[HeatSurface | Solid], scale: colours.Scale | None) -> Soup:
    vertices, triangles, rgb, body = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty((0, 3))], [[0][:0]]
    names: dict[str, int] = {}
    count = 0
    for part in parts:
        vertices.append(part.vertices)
        triangles.append(part.triangles + count)
        rgb.append(_rgb(part, scale))
        body.append([names.setdefault(part.name, len(names))] * len(part.triangles))
        count += len(part.vertices)
    points, faces = np.concatenate(vertices), np.concatenate(triangles)
    numbers = np.concatenate([np.asarray(b, dtype=np.int64) for b in body])
    return Soup(points, faces, np.concatenate(rgb), triangle_normals(points, faces), numbers)
