"""Write a robustness map as a glTF file: a node for each body, with colours and forces at its vertices."""

from __future__ import annotations

import os
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.files import write_atomically
from holdfast.base.text import one_line
from holdfast.drawing.arrows import PUSH_RADIUS, arrow_mesh, size_of
from holdfast.drawing.edges import feature_edges
from holdfast.drawing.marks import INK
from holdfast.drawing.painted import NO_VALUE, UNDECIDED, legend_of, painted
from holdfast.drawing.picture import Picture
from holdfast.drawing.soup import fixed, movable
from holdfast.geometry.gltf import LARGEST, Gltf, Primitive

KEY: Final = "holdfast_map"
WHITE: Final = (1.0, 1.0, 1.0)
# what the numbers mean; glTF has no infinity
CODES: Final = {
    "_FORCE": {"unit": "N", "no push moves it": LARGEST, "undecided": UNDECIDED, "no value": NO_VALUE},
    "_KIND": "the number of one of the kinds",
}


def write_glb(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the picture as a binary glTF file; if writing fails, an existing file is left unchanged.

    ``_FORCE`` [N] and ``_KIND`` at the vertices are as in ``Painted``, but LARGEST stands for infinity. Materials are
    unlit: a viewer shows the colours of the legend.
    """
    file = Gltf()
    for body in painted(picture):
        force = np.minimum(body.force, LARGEST)
        values = {"_FORCE": force, "_KIND": body.kind.astype(float)}
        _add(file, body.name, body.vertices, body.triangles, WHITE, {"body": body.name}, body.rgb, values)
    ink = rgb_of(INK)
    segments = np.concatenate([feature_edges(movable(picture, None)), feature_edges(fixed(picture))])
    if len(segments):
        ends = np.arange(2 * len(segments)).reshape(-1, 2)
        _add(file, "edges", segments.reshape(-1, 3), ends, ink)
    for number, arrow in enumerate(picture.weakest, 1):
        vertices, triangles = arrow_mesh((arrow,), PUSH_RADIUS * size_of(picture))
        if len(triangles):
            _add(
                file, f"weakest push {number}: {one_line(arrow.label)}", vertices, triangles, ink, {"push": arrow.label}
            )
    write_atomically(path, file.content({KEY: legend_of(picture) | {"attributes": CODES}}))


def lit_glb(vertices: NDArray[np.float64], triangles: NDArray[np.int64], light: NDArray[np.float64]) -> bytes:
    """Return triangles (T, 3) of vertices (V, 3) [m] with this emitted ``light`` (V, 3) as binary glTF, with y up."""
    file = Gltf()
    primitive = Primitive(vertices, triangles, file.material(WHITE, unlit=True), light=light)
    file.node("surface", file.mesh([primitive]), np.eye(4))
    return file.content({})


def _add(
    file: Gltf,
    name: str,
    vertices: NDArray[np.float64],
    corners: NDArray[np.int64],
    colour: Rgb,
    extras: dict[str, str] | None = None,
    rgb: NDArray[np.float64] | None = None,
    values: dict[str, NDArray[np.float64]] | None = None,
) -> None:
    """Add a node with its frame at the middle of its vertices (V, 3) [m], because the file has single precision."""
    pose = np.eye(4)
    pose[:3, 3] = (vertices.min(0) + vertices.max(0)) / 2
    primitive = Primitive(vertices - pose[:3, 3], corners, file.material(colour, unlit=True), rgb, values or {})
    file.node(name, file.mesh([primitive]), pose, extras)
