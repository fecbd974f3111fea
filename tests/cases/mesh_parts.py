"""Meshes made of abutting or overlapping boxes, in every way that files hold them, with their exact mass properties."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

import holdfast as hf

Array = NDArray[np.float64]
Span = tuple[Sequence[float], Sequence[float]]  # the lowest and the highest corner of a box

W, H, T, B, D = 0.3, 0.2, 0.05, 0.04, 0.1  # [m] width, height, arm, base and depth of a U
ON_TOP: list[Span] = [((0, 0, 0), (W, D, B)), ((0, 0, B), (T, D, H)), ((W - T, 0, B), (W, D, H))]
BESIDE: list[Span] = [((T, 0, 0), (W - T, D, B)), ((0, 0, 0), (T, D, H)), ((W - T, 0, 0), (W, D, H))]
WHOLE_FACES: list[Span] = [*ON_TOP[1:], ((0, 0, 0), (T, D, B)), ((T, 0, 0), (W - T, D, B)), ((W - T, 0, 0), (W, D, B))]
US = {"on top": ON_TOP, "beside": BESIDE, "whole faces": WHOLE_FACES}


def spanning(low: Sequence[float], high: Sequence[float]) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=np.array([low, high], dtype=float))


def apart(parts: Sequence[trimesh.Trimesh]) -> hf.Mesh:
    """Every part with vertices of its own, as trimesh.util.concatenate and most exporters leave them."""
    together = trimesh.util.concatenate(list(parts))
    return hf.Mesh(together.vertices, together.faces)


def one_inside_out(parts: Sequence[trimesh.Trimesh]) -> hf.Mesh:
    first = trimesh.Trimesh(parts[0].vertices, parts[0].faces[:, ::-1], process=False)
    return apart([first, *parts[1:]])


def welded(parts: Sequence[trimesh.Trimesh]) -> hf.Mesh:
    """Vertices at the same place are one: four or more faces meet at common edges."""
    together = trimesh.util.concatenate(list(parts))
    together.merge_vertices()
    return hf.Mesh(together.vertices, together.faces)


def soup(parts: Sequence[trimesh.Trimesh]) -> hf.Mesh:
    """Triangles that share nothing, in mixed order, as in an STL file."""
    triangles = np.concatenate([part.triangles for part in parts])
    triangles = triangles[np.random.default_rng(0).permutation(len(triangles))]
    return hf.Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def all_inside_out(parts: Sequence[trimesh.Trimesh]) -> hf.Mesh:
    mesh = soup(parts)
    return hf.Mesh(mesh.vertices, mesh.faces[:, ::-1])


WAYS: dict[str, Callable[[Sequence[trimesh.Trimesh]], hf.Mesh]] = {
    "apart": apart,
    "one inside out": one_inside_out,
    "welded": welded,
    "soup": soup,
    "all inside out": all_inside_out,
}


def of_boxes(spans: Sequence[Span]) -> tuple[float, Array, Array]:
    """Volume, centre of mass and inertia about it of boxes that do not overlap."""
    low, high = (np.array([span[k] for span in spans], dtype=float) for k in (0, 1))
    sides, centres = high - low, (low + high) / 2
    volumes = sides.prod(1)
    com = volumes @ centres / volumes.sum()
    inertia = np.zeros((3, 3))
    for volume, side, arm in zip(volumes, sides, centres - com, strict=True):
        squares = side**2
        inertia += volume * (np.diag(squares.sum() - squares) / 12 + (arm @ arm) * np.eye(3) - np.outer(arm, arm))
    return float(volumes.sum()), com, inertia


def clean_u() -> hf.Mesh:
    """The U as one closed surface: a polygon of eight corners, drawn out along y."""
    outline = np.array([(0, 0), (W, 0), (W, H), (W - T, H), (W - T, B), (T, B), (T, H), (0, H)])
    front = np.column_stack([outline[:, 0], np.zeros(8), outline[:, 1]])
    cap = np.array([(0, 5, 6), (0, 6, 7), (0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4)])
    i = np.arange(8)
    j = (i + 1) % 8
    sides = np.vstack([np.column_stack([i, i + 8, j]), np.column_stack([j, i + 8, j + 8])])
    return hf.Mesh(np.vstack([front, front + np.array([0, D, 0])]), np.vstack([cap, cap[:, ::-1] + 8, sides]))
