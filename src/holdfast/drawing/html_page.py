"""A map as an interactive 3D page in one HTML file, which opens offline; and the templates of pages."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
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
    HeatSurface,
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
    parts = layers(picture)
    switches = [
        f'<label><input type="checkbox" data-layer="{number}" data-role="{layer.role}" checked>'
        f'<i style="background:{layer.swatch}"></i>{escaped(layer.name)}</label>'
        for number, layer in enumerate(parts)
    ]
    items = "".join(f"<li>{escaped(arrow.label)}</li>" for arrow in picture.weakest)
    return template("map.html").substitute(
        hash=allowed,
        title=escaped(picture.title),
        subtitle=escaped(picture.subtitle),
        switches="\n".join(switches),
        weakest=f"<h2>Weakest pushes</h2><ol>{items}</ol>" if items else "",
        scale=_scale(picture),
        data=_packed(picture, parts),
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


@dataclass(frozen=True)
class Faces:
    """Triangles (T, 3) of vertices (V, 3) [m]; ``cell`` (V,) is the cell to which each vertex belongs.

    Each cell has a colour, ``rgb`` (C, 3) in 0..1, and in ``texts`` (C,) the HTML that is shown under the pointer, or
    "". ``solid`` is True for surfaces of bodies and False for arrows.
    """

    vertices: Float
    triangles: Int
    cell: Int
    rgb: Float
    texts: tuple[str, ...]
    solid: bool


@dataclass(frozen=True)
class Lines:
    """Segments (E, 2, 3) [m] of one colour and width [px]."""

    segments: Float
    colour: Rgb
    width: float


@dataclass(frozen=True)
class Dots:
    """Points (N, 3) [m] of one colour and diameter [px]."""

    points: Float
    colour: Rgb
    width: float


class Switch(NamedTuple):
    """The parts that one switch of the page shows and hides.

    ``swatch`` is the CSS colour beside the name. The page's script identifies the switch by its ``role``.
    """

    name: str
    swatch: str
    parts: tuple[Faces | Lines | Dots, ...]
    role: str = ""


def layers(picture: Picture) -> list[Switch]:
    """Return what the picture has, in the order of the page's switches."""
    size = size_of(picture)
    contacts: list[Lines | Dots] = []
    if picture.outlines:
        contacts.append(Lines(sides_of(picture.outlines), rgb_of(CONTACT), 2.5))
    if len(picture.contact_points):
        contacts.append(Dots(picture.contact_points, rgb_of(CONTACT), 5.0))
    arrows = _arrows(picture.contact_forces, FORCE_COLOUR, FORCE_RADIUS * size)
    switches = [
        *_heat(picture),
        *_neutral(picture),
        Switch("contact patches", CONTACT, tuple(contacts)),
        Switch("contact forces at rest", FORCE_COLOUR, arrows),
        Switch("weakest pushes", INK, _arrows(picture.weakest, INK, PUSH_RADIUS * size), "pushes"),
    ]
    return [switch for switch in switches if switch.parts]


def sides_of(rings: Sequence[Float]) -> Float:
    """Return the sides (E, 2, 3) [m] of closed polylines (k, 3) [m]."""
    sides = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in rings]
    return np.concatenate([np.empty((0, 2, 3)), *sides])


def _heat(picture: Picture) -> list[Switch]:
    scale = colours.scale_of(forces(picture))
    named = {Kind.FORCE: ("largest push, by colour", colours.gradient())}
    named |= {kind: (name, colours.hex_of(colours.SPECIAL[kind])) for kind, name in legend(picture).items()}
    switches = []
    for kind, (name, swatch) in named.items():
        parts = [_cells(surface, kind, scale) for surface in picture.heat if (surface.kind == kind).any()]
        switches.append(Switch(name, swatch, (_joined(parts),) if parts else ()))
    return switches


def _cells(surface: HeatSurface, kind: Kind, scale: colours.Scale | None) -> Faces:
    corners = corners_of(surface, surface.kind == kind)
    owners, cell = np.unique(corners.cell, return_inverse=True)
    rgb = colours.colours(scale, surface.force[owners], surface.kind[owners])
    texts = tuple(surface.hover[k] for k in owners)
    return Faces(surface.vertices[corners.vertex], corners.triangles, cell, rgb, texts, solid=True)


def _joined(parts: list[Faces]) -> Faces:
    """Return several surfaces as one, so that it takes a single draw call."""
    corners = np.cumsum([0, *(len(part.vertices) for part in parts)])
    cells = np.cumsum([0, *(len(part.texts) for part in parts)])
    return Faces(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, corners, strict=False)]),
        np.concatenate([part.cell + start for part, start in zip(parts, cells, strict=False)]),
        np.concatenate([part.rgb for part in parts]),
        tuple(text for part in parts for text in part.texts),
        parts[0].solid,
    )


def _neutral(picture: Picture) -> list[Switch]:
    covered = tuple(solid for solid in picture.solids if not solid.fixed)
    masked, still = movable(Picture("", "", (), covered), None), _without_undersides(fixed(picture), picture)
    floor: tuple[Faces | Lines, ...] = (*_surface(still, colours.FIXED), *_edges(still, rgb_of(_FIXED_EDGE), 1.2))
    return [
        Switch("covered, cannot be pushed", colours.hex_of(colours.COVERED), _surface(masked, colours.COVERED)),
        Switch("fixed bodies", colours.hex_of(colours.FIXED), floor, "fixed"),
        Switch("body edges", INK, _edges(movable(picture, None), rgb_of(INK), 1.6)),
    ]


def _without_undersides(still: Soup, picture: Picture) -> Soup:
    """Remove the faces that face down below everything else, such as the underside of a floor."""
    level = float((heat_points(picture) @ picture.up).min())
    height = (still.vertices @ picture.up)[still.triangles].max(axis=1)
    kept = ~((still.normals @ picture.up < -0.9) & (height < level))
    return Soup(still.vertices, still.triangles[kept], still.rgb[kept], still.normals[kept], still.body[kept])


def _surface(soup: Soup, colour: Rgb) -> tuple[Faces, ...]:
    if not len(soup.triangles):
        return ()
    used, corners = np.unique(soup.triangles.ravel(), return_inverse=True)
    one = np.zeros(len(used), dtype=np.int64)
    return (Faces(soup.vertices[used], corners.reshape(-1, 3), one, np.array([colour]), ("",), solid=True),)


def _edges(soup: Soup, colour: Rgb, width: float) -> tuple[Lines, ...]:
    segments = feature_edges(soup)
    return (Lines(segments, colour, width),) if len(segments) else ()


def _arrows(arrows: Sequence[Arrow], colour: str, radius: float) -> tuple[Faces, ...]:
    drawn = tuple(arrow for arrow in arrows if not np.array_equal(arrow.tail, arrow.head))
    if not drawn:
        return ()
    vertices, triangles = arrow_mesh(drawn, radius)
    cell = np.repeat(np.arange(len(drawn)), len(vertices) // len(drawn))
    rgb = np.tile(rgb_of(colour), (len(drawn), 1))
    return (Faces(vertices, triangles, cell, rgb, tuple(escaped(arrow.label) for arrow in drawn), solid=False),)


def _packed(picture: Picture, parts: list[Switch]) -> str:
    front = front_view(picture)
    packer = Packer()
    drawn = [{"role": layer.role, "parts": [_part(part, packer) for part in layer.parts]} for layer in parts]
    tails, heads = ends_of(picture.weakest)
    shown = heat_points(picture)
    return packer.text(
        {
            "layers": drawn,
            "up": picture.up.tolist(),
            "views": {"front": front.toward.tolist(), "back": back_view(picture, front).toward.tolist()},
            "bounds": [shown.min(axis=0).tolist(), shown.max(axis=0).tolist()],
            "shown": packer.put(np.concatenate([_extremes(shown), tails]), "f4"),
            "badges": (tails + 0.15 * (tails - heads)).tolist(),
        }
    )


def _extremes(points: Float) -> Float:
    """Return the extreme points (N, 3) in many directions, which need as much room in a view as all points."""
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 13)
    level, above = (grid.ravel() for grid in np.meshgrid(turn, tilt))
    ways = np.stack([np.cos(above) * np.cos(level), np.cos(above) * np.sin(level), np.sin(above)])
    return np.asarray(points[np.unique(np.argmax(points @ ways, axis=0))])


def _part(part: Faces | Lines | Dots, packer: Packer) -> dict[str, Any]:
    match part:
        case Faces():
            vertices, triangles, cell = _welded(part)
            marked = (part.rgb == colours.UNDECIDED).all(axis=1) * _HATCHED
            return {
                "shape": "faces",
                "solid": part.solid,
                "vertices": packer.put(vertices, "f4"),
                "triangles": packer.put(triangles, "u4"),
                "cell": packer.put(cell, "u4"),
                "paint": packer.put(np.column_stack([np.rint(part.rgb * 255.0), marked]), "u1"),
                "texts": part.texts,
            }
        case Lines():
            ends = packer.put(part.segments.reshape(-1, 3), "f4")
            return {"shape": "lines", "vertices": ends, "colour": part.colour, "width": part.width}
    points = packer.put(part.points, "f4")
    return {"shape": "dots", "vertices": points, "colour": part.colour, "width": part.width}


def _welded(part: Faces) -> tuple[Float, Int, Int]:
    """Return vertices, triangles and cells with common corners of the triangles of a cell merged.

    Corners are equal if their coordinates are equal in single precision.
    """
    place = np.ascontiguousarray(part.vertices, dtype=np.float32) + np.float32(0.0)  # -0 becomes 0
    rows = np.column_stack([place.view(np.uint32).astype(np.int64), part.cell])
    _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # in the original order, which compresses well
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    kept = first[order]
    return part.vertices[kept], rank[number.ravel()][part.triangles], part.cell[kept]


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
