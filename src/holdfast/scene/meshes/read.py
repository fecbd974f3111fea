"""Read the triangles of a mesh file: here files of rows of text, Wavefront OBJ, OFF, and STL, which may also be binary.

Normals, textures and material files say nothing about the shape.
"""

from __future__ import annotations

from codecs import BOM_UTF8
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from holdfast.base.arrays import Float, Int, checked_word
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, message
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.rigid import Y_TO_Z, transform
from holdfast.base.text import quoted
from holdfast.scene.meshes import dae
from holdfast.scene.meshes.by_trimesh import read_glb, read_ply

MAX_BYTES = 1_000_000_000  # size of the largest mesh file that is read
BLOCK = 50_000  # rows that are converted at a time, because texts need several times the memory of numbers
OFF_HEADS = ("OFF", "COFF", "NOFF", "CNOFF")
STL_HEAD = 84  # bytes before the first triangle of a binary file; the last four are the number of triangles
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
STL_WORDS = ("solid", "facet", "outer", "endloop", "endfacet", "endsolid")  # rows that hold no vertex


def rows_of(content: bytes, comment: str = "#") -> Iterator[tuple[int, list[str]]]:
    """Yield the number of every line, from 1, with its words, leaving out empty lines and comments.

    Raises ValueError if the content is not text. A backslash at the end of a line continues it.
    """
    body = content.removeprefix(BOM_UTF8)
    if b"\0" in body:
        raise ValueError("neither text nor a complete binary file")
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError:
        text = body.decode("latin-1")  # for names and comments of older programs
    before: list[str] = []
    ends = "\n" if "\n" in text else "\r"
    for number, line in enumerate(text.split(ends), 1):
        words = line.split(comment, 1)[0].split()
        if words and words[-1] == "\\":
            before += words[:-1]
        elif before or words:
            yield number, before + words
            before = []


def numbers(words: Sequence[str], number: int, least: int) -> list[float]:
    """Return the first ``least`` words of a row as numbers; raise ValueError, with the line's number, otherwise."""
    try:
        found = [float(word) for word in words[:least]]
    except ValueError:
        found = []
    if len(found) < least:
        raise ValueError(f"line {number}: needs {least} numbers, got {quoted(' '.join(words))}")
    return found


def fan(corners: Sequence[int]) -> list[tuple[int, int, int]]:
    """Split a polygon into triangles that share its first corner."""
    return [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]


class Rows:
    """A growing table of rows of three numbers, stored as arrays of BLOCK rows."""

    def __init__(self) -> None:
        self._full: list[Float] = []
        self._open: list[Sequence[float]] = []

    def __len__(self) -> int:
        return BLOCK * len(self._full) + len(self._open)

    def add(self, row: Sequence[float]) -> None:
        """Add one row of three numbers."""
        self._open.append(row)
        if len(self._open) == BLOCK:
            self._full.append(np.array(self._open, dtype=np.float64))
            self._open = []

    def array(self) -> Float:
        """All rows (n, 3)."""
        return np.concatenate([*self._full, np.array(self._open, dtype=np.float64).reshape(-1, 3)])


def read_obj(content: bytes) -> tuple[Float, Int]:
    """Return the vertices and triangles of an OBJ file; faces of more corners are split into fans.

    Raises ValueError, with the number of the line, if a row has too few numbers or names a vertex that does not exist.
    """
    vertices, faces, _ = _parsed(content)
    return vertices, faces


def objects_of_obj(content: bytes) -> list[tuple[str, Float, Int]]:
    """Return the name, the vertices and the triangles of each object (``o``) of an OBJ file that has faces.

    In a file without objects they are its groups (``g``); faces before the first one are in an object "". Objects of
    one name are one. Raises ValueError as ``read_obj`` does.
    """
    vertices, faces, starts = _parsed(content)
    kind = "o" if any(tag == "o" for tag, _, _ in starts) else "g"
    begins = [("", 0), *((name, first) for tag, name, first in starts if tag == kind)]
    ends = [first for _, first in begins[1:]] + [len(faces)]
    whole: dict[str, list[Int]] = {}
    for (name, first), end in zip(begins, ends, strict=True):
        if end > first:
            whole.setdefault(name, []).append(faces[first:end])
    found = []
    for name, parts in whole.items():
        used, own = np.unique(np.concatenate(parts), return_inverse=True)
        found.append((name, vertices[used], own.reshape(-1, 3)))
    return found


def _parsed(content: bytes) -> tuple[Float, Int, list[tuple[str, str, int]]]:
    """Return vertices and triangles, and for each row ``o`` and ``g`` its name and the number of triangles before."""
    vertices, faces, starts = Rows(), Rows(), []
    for number, words in rows_of(content):
        if words[0] == "v":
            vertices.add(numbers(words[1:], number, 3))
        elif words[0] in ("o", "g"):
            starts.append((words[0], " ".join(words[1:]), len(faces)))
        elif words[0] in ("f", "fo"):
            corners = [_corner(word, len(vertices), number) for word in words[1:]]
            if len(corners) < 3:
                raise ValueError(f"line {number}: a face has {len(corners)} corners")
            for triangle in fan(corners):
                faces.add(triangle)
    found = faces.array()
    if len(found) and found.max() >= len(vertices):
        raise ValueError(f"a face names vertex {found.max() + 1:.0f} of {len(vertices)}")
    return vertices.array(), found.astype(np.int64), starts


def _corner(word: str, known: int, number: int) -> int:
    """Return the index of a corner such as 7, 7/2 or 7//3; negative ones count back from the vertex read last."""
    try:
        index = int(word.split("/", 1)[0])
    except ValueError:
        index = 0
    if index == 0 or index < -known:
        raise ValueError(f"line {number}: a face names vertex {quoted(word)} of {known}: they count from 1")
    return index - 1 if index > 0 else known + index


def read_off(content: bytes) -> tuple[Float, Int]:
    """Return the vertices and triangles of an OFF file; faces of more corners are split into fans.

    Raises ValueError if the file has fewer vertices or faces than its header says.
    """
    rows = rows_of(content)
    _, words = next(rows, (0, [""]))
    if words[0].upper() not in OFF_HEADS:
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
            for triangle in fan(_off_corners(row, number, most[0])):
                faces.add(triangle)
            count += 1
    if len(vertices) < most[0] or count < most[1]:
        raise ValueError(f"says {most[0]:,} vertices and {most[1]:,} faces, and has {len(vertices):,} and {count:,}")
    return vertices.array(), faces.array().astype(np.int64)


def _off_corners(words: list[str], number: int, known: int) -> list[int]:
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


def read_stl(content: bytes) -> tuple[Float, Int]:
    """Return the vertices (three for each triangle) and the triangles of an STL file.

    Raises ValueError if the length of a binary file does not fit its number of triangles, or if a row of a text file is
    not understood.
    """
    count = int.from_bytes(content[STL_HEAD - 4 : STL_HEAD], "little")
    if len(content) >= STL_HEAD and len(content) == STL_HEAD + count * TRIANGLE.itemsize:
        corners: Float = np.frombuffer(content, dtype=TRIANGLE, offset=STL_HEAD)["corners"].reshape(-1, 3)
    elif content[:STL_HEAD].removeprefix(BOM_UTF8).lstrip().lower().startswith(b"solid"):
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
        elif word == "vertex" or word not in STL_WORDS:
            raise ValueError(f"line {number}: needs a row of an STL file, got {quoted(' '.join(words))}")
        if word == "endfacet" and len(corners) != 3 * (closed := closed + 1):
            raise ValueError(f"line {number}: facet {closed} ends at vertex {len(corners)}")
        opened += (word == "solid") - (word == "endsolid")
    if opened or len(corners) != 3 * closed:
        raise ValueError(f"ends at line {number}, within a solid")
    return corners.array()


Reader = Callable[[bytes], tuple[Float, Int]]

READERS: dict[str, Reader] = {
    ".obj": read_obj,
    ".stl": read_stl,
    ".ply": read_ply,
    ".glb": read_glb,
    ".off": read_off,
    ".dae": dae.read,
}
SUFFIXES = tuple(READERS)  # suffixes of the mesh files that can be read


def triangles_of(path: Path, up_axis: str | None = None) -> tuple[Float, Int]:
    """Return the vertices (V, 3), in the units of the file, and the triangles (F, 3) of a mesh file.

    DAE files say their unit, so their vertices are in metres. All pieces of the file become one mesh; materials and
    textures are ignored. With ``up_axis="y"`` they are turned about x so that y is z; if ``up_axis`` is given, the up
    axis that a DAE file says does not count. Raises GeometryError if the file cannot be read completely.
    """
    if up_axis is not None:
        checked_word(up_axis, ("y", "z"), f"{path}: up_axis", GeometryError)
    where, reader = str(path), READERS.get(path.suffix.lower())
    check_ordinary(path, "mesh file", error=GeometryError, remedy="paths are relative to the scene file")
    if reader is None:
        raise GeometryError(message(where, f"suffix {path.suffix!r}", f"reads {', '.join(SUFFIXES)}"))
    content = read_ordinary(path, "mesh file", most=MAX_BYTES, error=GeometryError, too_large="simplify the mesh")
    with foreign(where, error=GeometryError), np.errstate(invalid="ignore"):  # NaN in integers is an error of the mesh
        vertices, faces = dae.read(content, any_up=True) if up_axis and reader is dae.read else reader(content)
    if not len(faces):
        raise GeometryError(message(where, "holds no triangles", "needs a surface mesh, not points or lines"))
    if up_axis == "y":
        vertices = transform(Y_TO_Z, np.asarray(vertices, dtype=np.float64))
    return np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)
