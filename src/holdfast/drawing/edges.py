"""Find the feature edges of a body: where its surface bends or ends, whatever its division into cells."""

from __future__ import annotations

from collections import defaultdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.drawing.raster import CREASE_COSINE
from holdfast.drawing.soup import Soup
from holdfast.geometry.topology import Edges

# distance below which vertices are merged, as a share of the body's size: cells have slightly different corners
_GRID: Final = 1e-6


def feature_edges(soup: Soup) -> NDArray[np.float64]:
    """Return the segments (E, 2, 3) [m] along which a body's surface bends by more than 24° or ends."""
    found = [np.empty((0, 2, 3))]
    for body in np.unique(soup.body):
        own = soup.body == body
        found.append(_of_one(soup.vertices, soup.triangles[own], soup.normals[own]))
    return np.concatenate(found)


def _of_one(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], normals: NDArray[np.float64]
) -> NDArray[np.float64]:
    size = float(np.ptp(vertices[triangles.ravel()], axis=0).max()) or 1.0
    flat = ~_slivers(vertices[triangles], size * _GRID)
    triangles, normals = triangles[flat], normals[flat]
    if not len(triangles):
        return np.empty((0, 2, 3))
    _, first, merged = np.unique(np.rint(vertices / (size * _GRID)), axis=0, return_index=True, return_inverse=True)
    edges = Edges.of(merged.ravel()[triangles], len(first))
    shared, ends = edges.shared, edges.ends
    # Where parts of a body touch, an edge may belong to more than two triangles. The first and the last of them are
    # compared, in the order of the edge's place within the triangle; the choice only affects the picture.
    count = len(triangles)
    place = edges.sides % 3 * count + edges.sides // 3
    one, other = (normals[end.reduceat(place, edges.first) % count] for end in (np.minimum, np.maximum))
    bends = np.einsum("ij,ij->i", one, other) < CREASE_COSINE
    points = vertices[first]
    lone = shared == 1
    return np.concatenate([points[ends[~lone & bends]], _open_ends(points[ends[lone]], one[lone], size)])


def _slivers(corners: NDArray[np.float64], thin: float) -> NDArray[np.bool_]:
    """Return which triangles (T, 3, 3) [m] are thinner than ``thin`` [m], so that their normals are unreliable."""
    sides = corners - np.roll(corners, -1, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return np.asarray(doubled <= thin * longest)


def _open_ends(segments: NDArray[np.float64], normals: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """Return the parts of the one-sided segments where no coplanar surface continues on the other side.

    Segments are one-sided also where cells of different grids meet, without shared vertices; these are dropped.
    """
    if not len(segments):
        return segments
    along = segments[:, 1] - segments[:, 0]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    leading = np.argmax(np.abs(along) > 1e-6, axis=1)
    along *= np.sign(along[np.arange(len(along)), leading])[:, None]
    moment = np.cross(segments[:, 0], along) / size
    lines: dict[bytes, list[int]] = defaultdict(list)
    for index, key in enumerate(np.rint(np.column_stack([along, moment]) * 1e5 + 0.317).astype(np.int64)):
        lines[key.tobytes()].append(index)
    parts = [_along_line(segments[m], normals[m], along[m[0]], size) for m in lines.values()]
    return np.concatenate([np.empty((0, 2, 3)), *parts])


def _along_line(
    segments: NDArray[np.float64], normals: NDArray[np.float64], along: NDArray[np.float64], size: float
) -> NDArray[np.float64]:
    span = np.sort(segments @ along, axis=1)
    foot = segments[0, 0] - (segments[0, 0] @ along) * along
    marks = np.unique(span)
    middle = (marks[1:] + marks[:-1]) / 2.0
    covers = (span[:, :1] < middle) & (middle < span[:, 1:])
    kept = []
    for k in np.flatnonzero(np.diff(marks) > size * 10 * _GRID):
        facing = normals[covers[:, k]]
        if len(facing) == 1 or (len(facing) and float((facing @ facing.T).min()) < CREASE_COSINE):
            kept.append([foot + marks[k] * along, foot + marks[k + 1] * along])
    return np.array(kept).reshape(-1, 2, 3)
