"""Wavefront OBJ: vertices and faces. Normals, textures, groups and material files say nothing about the shape."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.text import quoted
from holdfast.scene.meshes.text_meshes import Rows, fan, numbers, rows_of


def read(content: bytes) -> tuple[Float, Int]:
    """Return the vertices and triangles of an OBJ file; faces of more corners are split into fans.

    Raises ValueError, with the number of the line, if a row has too few numbers or names a vertex that does not exist.
    """
    vertices, faces = Rows(), Rows()
    for number, words in rows_of(content):
        if words[0] == "v":
            vertices.add(numbers(words[1:], number, 3))
        elif words[0] in ("f", "fo"):
            corners = [_corner(word, len(vertices), number) for word in words[1:]]
            if len(corners) < 3:
                raise ValueError(f"line {number}: a face has {len(corners)} corners")
            for triangle in fan(corners):
                faces.add(triangle)
    found = faces.array()
    if len(found) and found.max() >= len(vertices):
        raise ValueError(f"a face names vertex {found.max() + 1:.0f} of {len(vertices)}")
    return vertices.array(), found.astype(np.int64)


def _corner(word: str, known: int, number: int) -> int:
    """Return the index of a corner such as 7, 7/2 or 7//3; negative ones count back from the vertex read last."""
    try:
        index = int(word.split("/", 1)[0])
    except ValueError:
        index = 0
    if index == 0 or index < -known:
        raise ValueError(f"line {number}: a face names vertex {quoted(word)} of {known}: they count from 1")
    return index - 1 if index > 0 else known + index
