"""Maps as glTF and PLY files: surfaces with their colours, and with the forces as numbers at their vertices."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.files import write_atomically
from holdfast.base.text import LONGEST_ITEM, LONGEST_NAME, one_line
from holdfast.drawing import colours
from holdfast.drawing.colours import INK, Kind
from holdfast.drawing.edges import PUSH_RADIUS, arrow_mesh, feature_edges
from holdfast.drawing.picture import Picture, corners_of, fixed, forces, legend, movable, size_of
from holdfast.geometry.gltf import LARGEST, Gltf, Primitive

UNDECIDED: Final = -1.0  # [N] in place of an undecided force; negative, so that it is never the strongest point
NO_VALUE: Final = -2.0  # [N] in place of the force on covered faces and fixed bodies
KEY: Final = "holdfast_map"
WHITE: Final = (1.0, 1.0, 1.0)
# what the numbers mean; glTF has no infinity
CODES: Final = {
    "_FORCE": {"unit": "N", "no push moves it": LARGEST, "undecided": UNDECIDED, "no value": NO_VALUE},
    "_KIND": "the number of one of the kinds",
}
MOST_NAMES: Final = 100  # largest number of bodies in comments, because readers limit the length of a header
FAR: Final = 100.0  # distance from the origin, in sizes, beyond which single precision is not enough
BESIDE: Final = [("red", "u1"), ("green", "u1"), ("blue", "u1"), ("force", "<f4"), ("kind", "u1"), ("body", "<i4")]
FACE: Final = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
TYPES: Final = {"<f8": "double", "<f4": "float", "|u1": "uchar", "<i4": "int"}


@dataclass(frozen=True)
class Painted:
    """The surface of one body.

    ``vertices`` (V, 3) [m] are in the world frame, ``triangles`` (T, 3) have outward winding, and ``rgb`` (V, 3) are
    sRGB colours in 0..1. ``force`` (V,) [N] is inf where no push moves anything, UNDECIDED or NO_VALUE; ``kind`` (V,)
    is a ``Kind``, which tells the zeros apart.
    """

    name: str
    vertices: Float
    triangles: Int
    rgb: Float
    force: Float
    kind: Int


def painted(picture: Picture) -> list[Painted]:
    """Return the surface of every body: exposed, covered and fixed parts."""
    scale = colours.scale_of(forces(picture))
    parts: dict[str, list[Painted]] = {}
    for surface in picture.heat:
        corner = corners_of(surface)
        rgb = colours.colours(scale, surface.force, surface.kind)[corner.cell]
        force = np.where(surface.kind == Kind.UNDECIDED, UNDECIDED, surface.force)[corner.cell]
        part = Painted(
            surface.name, surface.vertices[corner.vertex], corner.triangles, rgb, force, surface.kind[corner.cell]
        )
        parts.setdefault(surface.name, []).append(part)
    for solid in picture.solids:
        used, inverse = np.unique(solid.triangles.ravel(), return_inverse=True)
        rgb = np.tile(np.array(colours.FIXED if solid.fixed else colours.COVERED), (len(used), 1))
        force, kind = np.full(len(used), NO_VALUE), np.full(len(used), Kind.NONE, dtype=np.int64)
        part = Painted(solid.name, solid.vertices[used], inverse.reshape(-1, 3), rgb, force, kind)
        parts.setdefault(solid.name, []).append(part)
    return [_joined(name, of_body) for name, of_body in parts.items()]


def _joined(name: str, parts: list[Painted]) -> Painted:
    """Return several surfaces as one of this name."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])[:-1]
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=True)]
    return Painted(
        name,
        np.concatenate([np.empty((0, 3)), *(part.vertices for part in parts)]),
        np.concatenate([np.empty((0, 3), np.int64), *triangles]),
        np.concatenate([np.empty((0, 3)), *(part.rgb for part in parts)]),
        np.concatenate([np.empty(0), *(part.force for part in parts)]),
        np.concatenate([np.empty(0, np.int64), *(part.kind for part in parts)]),
    )


def _legend_data(picture: Picture) -> dict[str, Any]:
    """Return the legend as plain data: the title, the scale with its marks, and the kinds of answers."""
    scale = colours.scale_of(forces(picture))
    data: dict[str, Any] = {"title": picture.title, "subtitle": picture.subtitle, "value": picture.value_name}
    if scale is not None:
        marks = [
            {"text": mark.label, "colour": colours.hex_of(colours.sample(mark.position))}
            for mark in colours.ticks(scale)
        ]
        data["scale"] = {"low": scale.low, "high": scale.high, "logarithmic": scale.log, "marks": marks}
    names = {Kind.FORCE: "force on the scale", **legend(picture), Kind.NONE: "fixed or covered: no value"}
    data["kinds"] = [
        {"kind": int(kind), "name": name}
        | ({"colour": colours.hex_of(colours.SPECIAL[kind])} if kind in colours.SPECIAL else {})
        for kind, name in names.items()
    ]
    return data


def write_glb(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the picture as a binary glTF file; if writing fails, an existing file is left unchanged.

    ``_FORCE`` [N] and ``_KIND`` at the vertices are as in ``Painted``, but LARGEST stands for infinity. Materials are
    unlit: a viewer shows the colours of the legend.
    """
    file = Gltf()
    for body in painted(picture):
        values = {"_FORCE": np.minimum(body.force, LARGEST), "_KIND": body.kind.astype(float)}
        _add(file, body.name, body.vertices, body.triangles, WHITE, {"body": body.name}, body.rgb, values)
    ink = rgb_of(INK)
    segments = np.concatenate([feature_edges(movable(picture, None)), feature_edges(fixed(picture))])
    if len(segments):
        ends = np.arange(2 * len(segments)).reshape(-1, 2)
        _add(file, "edges", segments.reshape(-1, 3), ends, ink)
    for number, arrow in enumerate(picture.weakest, 1):
        vertices, triangles = arrow_mesh((arrow,), PUSH_RADIUS * size_of(picture))
        if len(triangles):
            name = f"weakest push {number}: {one_line(arrow.label)}"
            _add(file, name, vertices, triangles, ink, {"push": arrow.label})
    write_atomically(path, file.content({KEY: _legend_data(picture) | {"attributes": CODES}}))


def lit_glb(vertices: Float, triangles: Int, light: Float) -> bytes:
    """Return triangles (T, 3) of vertices (V, 3) [m] with this emitted ``light`` (V, 3) as binary glTF, with y up."""
    file = Gltf()
    primitive = Primitive(vertices, triangles, file.material(WHITE, unlit=True), light=light)
    file.node("surface", file.mesh([primitive]), np.eye(4))
    return file.content({})


def _add(
    file: Gltf,
    name: str,
    vertices: Float,
    corners: Int,
    colour: Rgb,
    extras: dict[str, str] | None = None,
    rgb: Float | None = None,
    values: dict[str, Float] | None = None,
) -> None:
    """Add a node with its frame at the middle of its vertices (V, 3) [m], because the file has single precision."""
    pose = np.eye(4)
    pose[:3, 3] = (vertices.min(0) + vertices.max(0)) / 2
    primitive = Primitive(vertices - pose[:3, 3], corners, file.material(colour, unlit=True), rgb, values or {})
    file.node(name, file.mesh([primitive]), pose, extras)


def write_ply(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the surfaces of the picture as a PLY file; if writing fails, an existing file is left unchanged.

    ``force`` [N] and ``kind`` are as in ``Painted``, and ``body`` numbers the bodies, whose names are comments.
    """
    bodies = painted(picture)
    whole = _joined("", bodies)
    near = np.abs(whole.vertices).max() <= FAR * np.ptp(whole.vertices, axis=0).max()
    axes = [(axis, "<f4" if near else "<f8") for axis in "xyz"]  # WebGL knows single precision only
    vertices = np.zeros(len(whole.vertices), np.dtype([*axes, *BESIDE]))
    for k, axis in enumerate("xyz"):
        vertices[axis] = whole.vertices[:, k]
    for k, channel in enumerate(("red", "green", "blue")):
        vertices[channel] = np.rint(255 * whole.rgb[:, k])
    vertices["force"], vertices["kind"] = whole.force, whole.kind
    vertices["body"] = np.repeat(np.arange(len(bodies)), [len(body.vertices) for body in bodies])
    faces = np.zeros(len(whole.triangles), FACE)
    faces["count"], faces["corners"] = 3, whole.triangles
    data = _legend_data(picture)
    comments = ["written by holdfast", data["title"], data["subtitle"]]
    comments += [f"force: largest push [N]; inf: no push moves it; {UNDECIDED:g}: undecided; {NO_VALUE:g}: no value"]
    comments += [f"kind {each['kind']}: {each['name']} {each.get('colour', '')}".rstrip() for each in data["kinds"]]
    comments += [f"{mark['text']} N {mark['colour']}" for mark in data.get("scale", {}).get("marks", ())]
    names = [one_line(body.name, LONGEST_NAME) for body in bodies[:MOST_NAMES]]
    comments += [f"body {number}: {name}" for number, name in enumerate(names)]
    comments += [f"and {len(bodies) - MOST_NAMES} more bodies"] if len(bodies) > MOST_NAMES else []
    rows = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {one_line(text, LONGEST_ITEM).encode('ascii', 'backslashreplace').decode()}" for text in comments),
        f"element vertex {len(vertices)}",
        *(f"property {TYPES[vertices.dtype[name].str]} {name}" for name in vertices.dtype.names or ()),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    write_atomically(path, "\n".join(rows).encode("ascii") + b"\n" + vertices.tobytes() + faces.tobytes())
