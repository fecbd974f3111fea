"""Meshes that trimesh reads: nodes of its scenes, and PLY files after a check of their headers."""

from __future__ import annotations

import io
import logging
import re
from codecs import BOM_UTF8
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.text import quoted

T = TypeVar("T")

_QUIET = logging.NullHandler()  # without a handler, Python would print trimesh's tracebacks
LONGEST_HEADER = 100_000  # bytes
END = re.compile(rb"^end_header[ \t]*\r?\n", re.MULTILINE)


class _Nothing:
    """A resolver that refuses all names: a mesh is a single file, and other files are never opened."""

    file_name = None

    def get(self, name: str) -> bytes:
        raise ValueError(f"names another file, {name!r:.80}: put everything into one")

    __getitem__ = get


class Node(NamedTuple):
    """A named mesh of a scene: its vertices (V, 3) and triangles (F, 3), and the matrix (4, 4) that puts it there.

    ``extras`` is further plain data from the file.
    """

    name: str
    vertices: Float
    faces: Int
    matrix: Float
    extras: Any = None


def load(content: bytes, kind: str) -> tuple[Float, Int]:
    """Return the vertices and triangles that trimesh reads from the content of a file of this kind, as one mesh.

    Raises whatever the parser of the format does; who calls has it behind ``holdfast.base.borders.foreign``.
    """
    return _guarded(content, kind, _as_one)


def load_nodes(content: bytes, kind: str) -> list[Node]:
    """Return the meshes that trimesh reads from the content of a file of this kind, one for each node.

    Raises whatever the parser of the format does.
    """
    return _guarded(content, kind, nodes_of)


def nodes_of(scene: Any) -> list[Node]:  # noqa: ANN401 - a trimesh.Scene, whose types are not followed
    """Return the nodes of a trimesh.Scene that hold triangles; lines and points are left out."""
    found = []
    for name in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[name]
        mesh = scene.geometry[geometry]
        if len(getattr(mesh, "faces", ())):
            vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
            found.append(Node(str(name), vertices, faces, np.array(matrix, dtype=np.float64)))
    return found


def _as_one(scene: Any) -> tuple[Float, Int]:  # noqa: ANN401
    mesh = scene.to_mesh()
    return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)


def _guarded(content: bytes, kind: str, taken: Callable[[Any], T]) -> T:
    import trimesh

    logging.getLogger("trimesh").addHandler(_QUIET)
    resolver: Any = _Nothing()
    try:
        stream = io.BytesIO(content)
        return taken(trimesh.load_scene(stream, file_type=kind, resolver=resolver, process=False, skip_materials=True))
    except ImportError as cause:  # for text that is not UTF-8, trimesh needs an optional package
        raise ValueError("neither text nor a complete binary file") from cause


def read_ply(content: bytes) -> tuple[Float, Int]:
    """Return the vertices and triangles of a PLY file.

    Raises ValueError if the file is shorter than its header says, or is not a PLY file.
    """
    content = content.removeprefix(BOM_UTF8)
    end = END.search(content, 0, LONGEST_HEADER)
    if not content.startswith(b"ply") or end is None:
        raise ValueError("has no header of a PLY file")
    rows = [line.split() for line in content[: end.start()].decode("latin-1").splitlines()[1:]]
    forms = [words for words in rows if words[:1] == ["format"]]
    # comments may name an image, so they are dropped
    kept = [words for words in rows if words[:1] in (["element"], ["property"])]
    if len(forms) != 1:
        raise ValueError(f"has {len(forms)} rows that say its format")
    counts = _ply_counts(kept)
    body = content[end.end() :]
    text = forms[0][1:2] == ["ascii"]
    held = sum(1 for row in body.split(b"\n") if row.strip()) if text else len(body)
    if sum(counts.values()) > held:
        claimed = " and ".join(f"{count:,} of {quoted(name)}" for name, count in counts.items())
        raise ValueError(f"says {claimed}, and has {held:,} {'rows' if text else 'bytes'}")
    head = "\n".join(" ".join(words) for words in (["ply"], forms[0], *kept, ["end_header"]))
    return load(head.encode() + b"\n" + body, "ply")


def _ply_counts(rows: list[list[str]]) -> dict[str, int]:
    """Return how many items of each element the header says; every element that has items has properties."""
    counts: dict[str, int] = {}
    described: set[str] = set()
    for words in rows:
        if words[:1] == ["element"]:
            if len(words) != 3 or not (words[2].isascii() and words[2].isdigit()):
                raise ValueError(f"has the header row {quoted(' '.join(words))}")
            counts[words[1]] = int(words[2][:18])
        else:
            described |= set(list(counts)[-1:])
    bare = [name for name, count in counts.items() if count and name not in described]
    if bare:
        raise ValueError(f"does not say what its {quoted(bare[0])} holds")
    return counts
