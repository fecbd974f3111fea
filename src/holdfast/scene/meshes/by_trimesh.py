"""Calls of trimesh's readers; no other module reads meshes with trimesh."""

from __future__ import annotations

import io
import logging
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from holdfast.base.arrays import Float, Int

T = TypeVar("T")

_QUIET = logging.NullHandler()  # without a handler, Python would print trimesh's tracebacks


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
