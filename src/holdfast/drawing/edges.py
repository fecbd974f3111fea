"""Lines and arrows in space: the feature edges of bodies, where their surfaces bend or end, and arrows as meshes."""

from __future__ import annotations

from collections import defaultdict
from typing import Final

import numpy as np

from holdfast.base.arrays import Float, Int, unit
from holdfast.drawing.picture import Arrow, Soup
from holdfast.drawing.render import CREASE_COSINE
from holdfast.geometry.triangles import Edges

# distance below which vertices are merged, as a share of the body's size: cells have slightly different corners
_GRID: Final = 1e-6
PUSH_RADIUS: Final = 0.0035  # radius of the arrows of pushes, as a share of the size of the picture
FORCE_RADIUS: Final = 0.0022  # radius of the arrows of contact forces, likewise
_SIDES: Final = 12  # number of sides of the rods and cones of an arrow


def feature_edges(soup: Soup) -> Float:
    """Return the segments (E, 2, 3) [m] along which a body's surface bends by more than 24° or ends."""
    segments = [np.empty((0, 2, 3))]
    for body in np.unique(soup.body):
        chosen = soup.body == body
        segments.append(_of_one(soup.vertices, soup.triangles[chosen], soup.normals[chosen]))
    return np.concatenate(segments)


def _of_one(vertices: Float, triangles: Int, normals: Float) -> Float:
    size = float(np.ptp(vertices[triangles.ravel()], axis=0).max()) or 1.0
    corners = vertices[triangles]
    sides = corners - np.roll(corners, -1, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    flat = doubled > size * _GRID * longest  # the normals of thinner ones are unreliable
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


def _open_ends(segments: Float, normals: Float, size: float) -> Float:
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
    kept = []
    for members in lines.values():
        ends, way = segments[members], along[members[0]]
        span = np.sort(ends @ way, axis=1)
        foot = ends[0, 0] - (ends[0, 0] @ way) * way
        marks = np.unique(span)
        middle = (marks[1:] + marks[:-1]) / 2.0
        covers = (span[:, :1] < middle) & (middle < span[:, 1:])
        for k in np.flatnonzero(np.diff(marks) > size * 10 * _GRID):
            facing = normals[members][covers[:, k]]
            if len(facing) == 1 or (len(facing) and float((facing @ facing.T).min()) < CREASE_COSINE):
                kept.append([foot + marks[k] * way, foot + marks[k + 1] * way])
    return np.array(kept).reshape(-1, 2, 3)


def arrow_mesh(arrows: tuple[Arrow, ...], radius: float) -> tuple[Float, Int]:
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
