"""Write a robustness map as a binary PLY file, with colours and forces at the vertices."""

from __future__ import annotations

import os
from typing import Final

import numpy as np

from holdfast.base.files import write_atomically
from holdfast.base.text import LONGEST_ITEM, LONGEST_NAME, one_line
from holdfast.drawing.painted import NO_VALUE, UNDECIDED, joined, legend_of, painted
from holdfast.drawing.picture import Picture

MOST_NAMES: Final = 100  # largest number of bodies in comments, because readers limit the length of a header
FAR: Final = 100.0  # distance from the origin, in sizes, beyond which single precision is not enough
BESIDE: Final = [("red", "u1"), ("green", "u1"), ("blue", "u1"), ("force", "<f4"), ("kind", "u1"), ("body", "<i4")]
FACE: Final = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
TYPES: Final = {"<f8": "double", "<f4": "float", "|u1": "uchar", "<i4": "int"}


def write_ply(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the surfaces of the picture as a PLY file; if writing fails, an existing file is left unchanged.

    ``force`` [N] and ``kind`` are as in ``Painted``, and ``body`` numbers the bodies, whose names are comments.
    """
    bodies = painted(picture)
    whole = joined("", bodies)
    near = np.abs(whole.vertices).max() <= FAR * np.ptp(whole.vertices, axis=0).max()
    kind = np.dtype(
        [*((axis, "<f4" if near else "<f8") for axis in "xyz"), *BESIDE]
    )  # WebGL knows single precision only
    vertices = np.zeros(len(whole.vertices), kind)
    for k, axis in enumerate("xyz"):
        vertices[axis] = whole.vertices[:, k]
    for k, channel in enumerate(("red", "green", "blue")):
        vertices[channel] = np.rint(255 * whole.rgb[:, k])
    vertices["force"], vertices["kind"] = whole.force, whole.kind
    vertices["body"] = np.repeat(np.arange(len(bodies)), [len(body.vertices) for body in bodies])
    faces = np.zeros(len(whole.triangles), FACE)
    faces["count"], faces["corners"] = 3, whole.triangles
    properties = [f"property {TYPES[kind[name].str]} {name}" for name in kind.names or ()]
    rows = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {_fit(text)}" for text in _comments(picture, [body.name for body in bodies])),
        f"element vertex {len(vertices)}",
        *properties,
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    write_atomically(path, "\n".join(rows).encode("ascii") + b"\n" + vertices.tobytes() + faces.tobytes())


def _comments(picture: Picture, names: list[str]) -> list[str]:
    legend = legend_of(picture)
    kinds = [f"kind {each['kind']}: {each['name']} {each.get('colour', '')}".rstrip() for each in legend["kinds"]]
    marks = [f"{mark['text']} N {mark['colour']}" for mark in legend.get("scale", {}).get("marks", ())]
    said = [f"body {number}: {one_line(name, LONGEST_NAME)}" for number, name in enumerate(names[:MOST_NAMES])]
    more = [f"and {len(names) - MOST_NAMES} more bodies"] if len(names) > MOST_NAMES else []
    coded = f"force: largest push [N]; inf: no push moves it; {UNDECIDED:g}: undecided; {NO_VALUE:g}: no value"
    return ["written by holdfast", legend["title"], legend["subtitle"], coded, *kinds, *marks, *said, *more]


def _fit(text: str) -> str:
    """Return a text as one line of ASCII."""
    return one_line(text, LONGEST_ITEM).encode("ascii", "backslashreplace").decode("ascii")
