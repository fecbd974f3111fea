"""The surfaces of a map with a colour, a force and a kind at every vertex, for files of other programs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from holdfast.drawing import colours
from holdfast.drawing.colours import Kind
from holdfast.drawing.picture import Picture, legend
from holdfast.drawing.soup import corners_of, forces

UNDECIDED: Final = -1.0  # [N] in place of an undecided force; negative, so that it is never the strongest point
NO_VALUE: Final = -2.0  # [N] in place of the force on covered faces and fixed bodies


@dataclass(frozen=True)
class Painted:
    """The surface of one body.

    ``vertices`` (V, 3) [m] are in the world frame, ``triangles`` (T, 3) have outward winding, and ``rgb`` (V, 3) are
    sRGB colours in 0..1. ``force`` (V,) [N] is inf where no push moves anything, UNDECIDED or NO_VALUE; ``kind`` (V,)
    is a ``Kind``, which tells the zeros apart.
    """

    name: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    rgb: NDArray[np.float64]
    force: NDArray[np.float64]
    kind: NDArray[np.int64]


def painted(picture: Picture) -> list[Painted]:
    """Return the surface of every body: exposed, covered and fixed parts."""
    scale = colours.scale_of(forces(picture))
    parts: dict[str, list[Painted]] = {}
    for surface in picture.heat:
        corners = corners_of(surface)
        rgb = colours.colours(scale, surface.force, surface.kind)
        force = np.where(surface.kind == Kind.UNDECIDED, UNDECIDED, surface.force)
        parts.setdefault(surface.name, []).append(
            Painted(
                surface.name,
                surface.vertices[corners.vertex],
                corners.triangles,
                rgb[corners.cell],
                force[corners.cell],
                surface.kind[corners.cell],
            )
        )
    for solid in picture.solids:
        used, inverse = np.unique(solid.triangles.ravel(), return_inverse=True)
        rgb = np.tile(np.array(colours.FIXED if solid.fixed else colours.COVERED), (len(used), 1))
        nothing = np.full(len(used), NO_VALUE)
        kinds = np.full(len(used), Kind.NONE, dtype=np.int64)
        parts.setdefault(solid.name, []).append(
            Painted(solid.name, solid.vertices[used], inverse.reshape(-1, 3), rgb, nothing, kinds)
        )
    return [joined(name, own) for name, own in parts.items()]


def joined(name: str, parts: list[Painted]) -> Painted:
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


def legend_of(picture: Picture) -> dict[str, Any]:
    """Return the legend as plain data: the title, the scale with its marks, and the kinds of answers."""
    scale = colours.scale_of(forces(picture))
    data: dict[str, Any] = {"title": picture.title, "subtitle": picture.subtitle, "value": picture.value_name}
    if scale is not None:
        data["scale"] = {
            "low": scale.low,
            "high": scale.high,
            "logarithmic": scale.log,
            "marks": [
                {"text": mark.label, "colour": colours.hex_of(colours.sample(mark.position))}
                for mark in colours.ticks(scale)
            ],
        }
    names = {Kind.FORCE: "force on the scale", **legend(picture), Kind.NONE: "fixed or covered: no value"}
    data["kinds"] = [
        {"kind": int(kind), "name": name}
        | ({"colour": colours.hex_of(colours.SPECIAL[kind])} if kind in colours.SPECIAL else {})
        for kind, name in names.items()
    ]
    return data
