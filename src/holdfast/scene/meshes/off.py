"""Object file format, OFF."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.text import quoted
from holdfast.scene.meshes.text_meshes import Rows, fan, numbers, rows_of

HEADS = ("OFF", "COFF", "NOFF", "CNOFF")


def read(content: bytes) -> tuple[Float, Int]:
    """Return the vertices and triangles of an OFF file; faces of more corners are split into fans.

    Raises ValueError if the file has fewer vertices or faces than its header says.
    """
    rows = rows_of(content)
    _, words = next(rows, (0, [""]))
    if words[0].upper() not in HEADS:
        raise ValueError(f"begins with {quoted(words[0])}, not with OFF")
    if len(words) == 1:
        _, words = next(rows, (0, []))
    else:
        words = words[1:]
    if len(words) < 2 or not all(word.isascii() and word.isdigit() for word in words[:2]):
        raise ValueError(f"has no numbers of vertices and faces, but {quoted(' '.join(words))}")
    most = (int(words[0][:18]), int(words[1][:18]))
    vertices, faces, count = Rows(), Rows(), 0
    for number, row in rows:
        if len(vertices) < most[0]:
            vertices.add(numbers(row, number, 3))
        elif count < most[1]:
            for triangle in fan(_corners(row, number, most[0])):
                faces.add(triangle)
            count += 1
    if len(vertices) < most[0] or count < most[1]:
        raise ValueError(f"says {most[0]:,} vertices and {most[1]:,} faces, and has {len(vertices):,} and {count:,}")
    return vertices.array(), faces.array().astype(np.int64)


def _corners(words: list[str], number: int, known: int) -> list[int]:
    """Return the corners of a face, whose first number is how many there are."""
    try:
        count = int(words[0])
        corners = [int(word) for word in words[1 : count + 1]]
    except ValueError:
        raise ValueError(f"line {number}: a face is {quoted(' '.join(words))}") from None
    if count < 3 or len(corners) < count:
        raise ValueError(f"line {number}: a face says {count} corners and has {len(corners)}")
    wrong = [corner for corner in corners if not 0 <= corner < known]
    if wrong:
        raise ValueError(f"line {number}: a face names vertex {wrong[0]} of {known}")
    return corners
