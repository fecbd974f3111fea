"""A map as an interactive 3D page in one HTML file, which opens offline; and the templates of pages."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import Float, Int
from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.files import write_atomically
from holdfast.base.text import escaped
from holdfast.drawing import colours
from holdfast.drawing.camera import back_view, front_view
from holdfast.drawing.colours import CONTACT, FORCE_COLOUR, INK, Kind
from holdfast.drawing.edges import FORCE_RADIUS, PUSH_RADIUS, arrow_mesh, feature_edges
from holdfast.drawing.picture import (
    Arrow,
    Picture,
    Soup,
    corners_of,
    ends_of,
    fixed,
    forces,
    heat_points,
    legend,
    movable,
    size_of,
)

_STATIC: Final = Path(__file__).parent / "static"
_HATCHED: Final = 1  # value of the fourth byte of a cell's colour if the cell is hatched
_FIXED_EDGE: Final = "#a9a7a1"  # colour of the edges of fixed bodies


def template(name: str) -> Template:
    """Return the template of a page."""
    return Template((_STATIC / name).read_text(encoding="utf-8"))


def write_html(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the picture as a self-contained 3D page; if writing fails, an existing file is left unchanged."""
    write_atomically(path, page_of(picture).encode("utf-8"))


def page_of(picture: Picture) -> str:
    """Return the page as text.

    Its security policy allows only the script with the given hash, and no request. So scripts in the names of bodies
    cannot run.
    """
    script = (_STATIC / "map.js").read_text(encoding="utf-8")
    allowed = base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")
    packer = Packer()
    switches = switches_of(picture, packer)
    labels = [
        f'<label><input type="checkbox" data-layer="{number}" data-role="{switch.role}" checked>'
        f'<i style="background:{switch.swatch}"></i>{escaped(switch.name)}</label>'
        for number, switch in enumerate(switches)
    ]
    items = "".join(f"<li>{escaped(arrow.label)}</li>" for arrow in picture.weakest)
    front, shown = front_view(picture), heat_points(picture)
    tails, heads = ends_of(picture.weakest)
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 13)
    level, above = (grid.ravel() for grid in np.meshgrid(turn, tilt))
    ways = np.stack([np.cos(above) * np.cos(level), np.cos(above) * np.sin(level), np.sin(above)])
    extremes = shown[np.unique(np.argmax(shown @ ways, axis=0))]  # need as much room in a view as all points
    drawn = {
        "layers": [{"role": switch.role, "parts": switch.parts} for switch in switches],
        "up": picture.up.tolist(),
        "views": {"front": front.toward.tolist(), "back": back_view(picture, front).toward.tolist()},
        "bounds": [shown.min(axis=0).tolist(), shown.max(axis=0).tolist()],
        "shown": packer.put(np.concatenate([extremes, tails]), "f4"),
        "badges": (tails + 0.15 * (tails - heads)).tolist(),
    }
    return template("map.html").substitute(
        hash=allowed,
        title=escaped(picture.title),
        subtitle=escaped(picture.subtitle),
        switches="\n".join(labels),
        weakest=f"<h2>Weakest pushes</h2><ol>{items}</ol>" if items else "",
        scale=_scale(picture),
        data=packer.text(drawn),
        script=script,
    )


def _scale(picture: Picture) -> str:
    scale = colours.scale_of(forces(picture))
    if scale is None:
        return ""
    marks = "".join(
        f'<span style="left:{100 * mark.position:.2f}%">{escaped(mark.label)}</span>' for mark in colours.ticks(scale)
    )
    title = escaped(picture.value_name) + (" (logarithmic)" if scale.log else "")
    bar = f'<div id="bar" style="background:{colours.gradient()}"></div><div id="marks">{marks}</div>'
    ends = "<figcaption>◂ weak: gives way first<span>strong ▸</span></figcaption>"
    return f'<figure id="scale"><strong>{title}</strong>{bar}{ends}</figure>'


class Switch(NamedTuple):
    """The parts, packed, that one switch of the page shows and hides.

    ``swatch`` is the CSS colour beside the name. The page's script identifies the switch by its ``role``.
    """

    name: str
    swatch: str
    parts: Sequence[dict[str, Any]]
    role: str = ""


def switches_of(picture: Picture, packer: Packer) -> list[Switch]:
    """Pack what the picture has, and return it in the order of the page's switches."""
    size, blue, scale = size_of(picture), rgb_of(CONTACT), colours.scale_of(forces(picture))
    kinds = {Kind.FORCE: ("largest push, by colour", colours.gradient())}
    kinds |= {kind: (name, colours.hex_of(colours.SPECIAL[kind])) for kind, name in legend(picture).items()}
    covered = movable(Picture("", "", (), tuple(solid for solid in picture.solids if not solid.fixed)), None)
    base = fixed(picture)
    level = float((heat_points(picture) @ picture.up).min())
    height = (base.vertices @ picture.up)[base.triangles].max(axis=1)
    kept = ~((base.normals @ picture.up < -0.9) & (height < level))
    still = Soup(base.vertices, base.triangles[kept], base.rgb[kept], base.normals[kept], base.body[kept])
    switches = [Switch(name, swatch, _cells(picture, kind, scale, packer)) for kind, (name, swatch) in kinds.items()]
    switches += [
        Switch(
            "covered, cannot be pushed", colours.hex_of(colours.COVERED), _surface(covered, colours.COVERED, packer)
        ),
        Switch(
            "fixed bodies",
            colours.hex_of(colours.FIXED),
            [*_surface(still, colours.FIXED, packer), *_lines(feature_edges(still), rgb_of(_FIXED_EDGE), 1.2, packer)],
            "fixed",
        ),
        Switch("body edges", INK, _lines(feature_edges(movable(picture, None)), rgb_of(INK), 1.6, packer)),
    ]
    contacts = _lines(sides_of(picture.outlines), blue, 2.5, packer)
    if len(picture.contact_points):
        dots = packer.put(picture.contact_points, "f4")
        contacts.append({"shape": "dots", "vertices": dots, "colour": blue, "width": 5.0})
    arrows = _arrows(picture.contact_forces, FORCE_COLOUR, FORCE_RADIUS * size, packer)
    pushes = _arrows(picture.weakest, INK, PUSH_RADIUS * size, packer)
    switches += [
        Switch("contact patches", CONTACT, contacts),
        Switch("contact forces at rest", FORCE_COLOUR, arrows),
        Switch("weakest pushes", INK, pushes, "pushes"),
    ]
    return [switch for switch in switches if switch.parts]


def sides_of(rings: Sequence[Float]) -> Float:
    """Return the sides (E, 2, 3) [m] of closed polylines (k, 3) [m]."""
    sides = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in rings]
    return np.concatenate([np.empty((0, 2, 3)), *sides])


def _cells(picture: Picture, kind: Kind, scale: colours.Scale | None, packer: Packer) -> list[dict[str, Any]]:
    """Pack the cells of this kind of all surfaces as one part, so that they take a single draw call."""
    vertices, triangles, cells, rgb, texts = [], [], [], [], list[str]()
    corner_count = 0
    for surface in picture.heat:
        if not (surface.kind == kind).any():
            continue
        corners = corners_of(surface, surface.kind == kind)
        owners, cell = np.unique(corners.cell, return_inverse=True)
        vertices.append(surface.vertices[corners.vertex])
        triangles.append(corners.triangles + corner_count)
        cells.append(cell + len(texts))
        rgb.append(colours.colours(scale, surface.force[owners], surface.kind[owners]))
        texts += [surface.hover[k] for k in owners]
        corner_count += len(corners.vertex)
    if not vertices:
        return []
    faces = np.concatenate(vertices), np.concatenate(triangles), np.concatenate(cells)
    return [_faces(*faces, np.concatenate(rgb), texts, packer, solid=True)]


def _faces(
    vertices: Float, triangles: Int, cell: Int, rgb: Float, texts: Sequence[str], packer: Packer, *, solid: bool
) -> dict[str, Any]:
    """Pack triangles (T, 3) of vertices (V, 3) [m]; ``cell`` (V,) is the cell to which each vertex belongs.

    Each cell has a colour, ``rgb`` (C, 3) in 0..1, and in ``texts`` (C,) the HTML that is shown under the pointer, or
    "". ``solid`` is True for surfaces of bodies and False for arrows. Common corners of the triangles of a cell are
    merged: those whose coordinates are equal in single precision.
    """
    place = np.ascontiguousarray(vertices, dtype=np.float32) + np.float32(0.0)  # -0 becomes 0
    rows = np.column_stack([place.view(np.uint32).astype(np.int64), cell])
    _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in the original order, which compresses well
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    hatched = (rgb == colours.UNDECIDED).all(axis=1) * _HATCHED
    return {
        "shape": "faces",
        "solid": solid,
        "vertices": packer.put(vertices[first[order]], "f4"),
        "triangles": packer.put(rank[number.ravel()][triangles], "u4"),
        "cell": packer.put(cell[first[order]], "u4"),
        "paint": packer.put(np.column_stack([np.rint(rgb * 255.0), hatched]), "u1"),
        "texts": texts,
    }


def _lines(segments: Float, colour: Rgb, width: float, packer: Packer) -> list[dict[str, Any]]:
    """Pack segments (E, 2, 3) [m] of one colour and width [px]; nothing if there are none."""
    if not len(segments):
        return []
    ends = packer.put(segments.reshape(-1, 3), "f4")
    return [{"shape": "lines", "vertices": ends, "colour": colour, "width": width}]


def _surface(soup: Soup, colour: Rgb, packer: Packer) -> list[dict[str, Any]]:
    if not len(soup.triangles):
        return []
    used, corners = np.unique(soup.triangles.ravel(), return_inverse=True)
    one = np.zeros(len(used), dtype=np.int64)
    return [_faces(soup.vertices[used], corners.reshape(-1, 3), one, np.array([colour]), [""], packer, solid=True)]


def _arrows(arrows: Sequence[Arrow], colour: str, radius: float, packer: Packer) -> list[dict[str, Any]]:
    drawn = tuple(arrow for arrow in arrows if not np.array_equal(arrow.tail, arrow.head))
    if not drawn:
        return []
    vertices, triangles = arrow_mesh(drawn, radius)
    cell = np.repeat(np.arange(len(drawn)), len(vertices) // len(drawn))
    rgb = np.tile(rgb_of(colour), (len(drawn), 1))
    return [_faces(vertices, triangles, cell, rgb, [escaped(arrow.label) for arrow in drawn], packer, solid=False)]


class Packer:
    """Collects arrays, and packs them with a header that refers to them."""

    def __init__(self) -> None:
        self._chunks: list[bytes] = []
        self._length = 0

    def put(self, values: NDArray[Any], kind: str) -> dict[str, int | str]:
        """Add an array as little-endian ``kind`` ("f4", "u4" or "u1"), and return its entry for the header.

        Arrays of "u4" are stored byte plane by byte plane, the lowest bytes first, which halves their compressed size.
        """
        raw = np.ascontiguousarray(values, dtype=np.dtype(kind).newbyteorder("<"))
        content = raw.view(np.uint8).reshape(-1, 4).T.tobytes() if kind == "u4" else raw.tobytes()
        place: dict[str, int | str] = {"at": self._length, "count": int(np.size(values)), "kind": kind}
        padded = content + bytes(-len(content) % 4)
        self._chunks.append(padded)
        self._length += len(padded)
        return place

    def text(self, header: dict[str, Any]) -> str:
        """Return the header and all arrays, deflated (zlib), in base 64.

        Before that: the length of the header in bytes as a little-endian unsigned 32-bit number, the header as JSON
        padded with spaces to a multiple of four bytes, the arrays one after the other, each at its ``at`` from the
        first. Raises ValueError if a number of the header is not finite, which JSON does not have.
        """
        written = json.dumps(header, ensure_ascii=False, allow_nan=False).encode("utf-8")
        written += b" " * (-len(written) % 4)
        whole = struct.pack("<I", len(written)) + written + b"".join(self._chunks)
        return base64.b64encode(zlib.compress(whole, 9)).decode("ascii")
