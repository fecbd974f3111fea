"""Clipping of opposing triangles of two surfaces against each other, within a gap and an angle."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Int
from holdfast.contacts.facing_polygons import Piece
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Angles
from holdfast.native import core


def clip_faces(a: SearchMesh, b: SearchMesh, pairs: Int, *, gap: float, depth: float, angles: Angles) -> list[Piece]:
    """Return where faces of ``pairs`` (m, 2) face each other, up to ``gap`` apart or ``depth`` into each other [m]."""
    flat, curved = angles.cosine(np.array([False, True])).tolist()
    corners, counts, normals, heights, bent = core.clip_faces(a, b, pairs, gap, depth, flat, curved)
    ends = np.cumsum(counts).tolist()
    return [
        Piece((corners[end - count : end].copy(),), normal.copy(), (low, high), round_ > 0)
        for end, count, normal, (low, high), round_ in zip(
            ends, counts.tolist(), normals, heights.tolist(), bent.tolist(), strict=True
        )
    ]
