"""STL, binary and text."""

from __future__ import annotations

from codecs import BOM_UTF8

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.text import quoted
from holdfast.scene.meshes.text_meshes import Rows, numbers, rows_of

HEAD = 84  # bytes before the first triangle of a binary file; the last four are the number of triangles
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
WORDS = ("solid", "facet", "outer", "endloop", "endfacet", "endsolid")  # rows that hold no vertex


def read(content: bytes) -> tuple[Float, Int]:
    """Return the vertices (three for each triangle) and the triangles of an STL file.

    Raises ValueError if the length of a binary file does not fit its number of triangles, or if a row of a text file is
    not understood.
    """
    count = int.from_bytes(content[HEAD - 4 : HEAD], "little")
    if len(content) >= HEAD and len(content) == HEAD + count * TRIANGLE.itemsize:
        corners: Float = np.frombuffer(content, dtype=TRIANGLE, offset=HEAD)["corners"].reshape(-1, 3)
    elif content[:HEAD].removeprefix(BOM_UTF8).lstrip().lower().startswith(b"solid"):
        corners = _corners_of_text(content)
    else:
        raise ValueError(f"has {len(content):,} bytes, but says {count:,} triangles, and does not begin with solid")
    return np.asarray(corners, dtype=np.float64), np.arange(len(corners), dtype=np.int64).reshape(-1, 3)


def _corners_of_text(content: bytes) -> Float:
    corners, closed, opened, number = Rows(), 0, 0, 0
    for number, words in rows_of(content, comment="\0"):
        word = words[0].lower()
        if word == "vertex" and len(words) == 4:
            corners.add(numbers(words[1:], number, 3))
        elif word == "vertex" or word not in WORDS:
            raise ValueError(f"line {number}: needs a row of an STL file, got {quoted(' '.join(words))}")
        if word == "endfacet" and len(corners) != 3 * (closed := closed + 1):
            raise ValueError(f"line {number}: facet {closed} ends at vertex {len(corners)}")
        opened += (word == "solid") - (word == "endsolid")
    if opened or len(corners) != 3 * closed:
        raise ValueError(f"ends at line {number}, within a solid")
    return corners.array()
