"""Write a robustness map as one interactive HTML file in 3D, which needs neither a library nor a network."""

from __future__ import annotations

import base64
import hashlib
import os
from pathlib import Path
from string import Template
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.files import write_atomically
from holdfast.base.text import escaped
from holdfast.drawing import colours
from holdfast.drawing.camera import back_view, front_view, heat_points
from holdfast.drawing.layers import Dots, Faces, Layer, Lines, gradient, layers, welded
from holdfast.drawing.packed import Packer
from holdfast.drawing.picture import Picture
from holdfast.drawing.soup import forces

_STATIC: Final = Path(__file__).parent / "static"
_HATCHED: Final = 1  # value of the fourth byte of a cell's colour if the cell is hatched


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
    return Template((_STATIC / "map.html").read_text(encoding="utf-8")).substitute(
        hash=allowed,
        title=escaped(picture.title),
        subtitle=escaped(picture.subtitle),
        switches=_switches(parts),
        weakest=_weakest(picture),
        scale=_scale(picture),
        data=_packed(picture, parts),
        script=script,
    )


def _switches(parts: list[Layer]) -> str:
    return "\n".join(
        f'<label><input type="checkbox" data-layer="{number}" data-role="{layer.role}" checked>'
        f'<i style="background:{layer.swatch}"></i>{escaped(layer.name)}</label>'
        for number, layer in enumerate(parts)
    )


def _weakest(picture: Picture) -> str:
    if not picture.weakest:
        return ""
    items = "".join(f"<li>{escaped(arrow.label)}</li>" for arrow in picture.weakest)
    return f"<h2>Weakest pushes</h2><ol>{items}</ol>"


def _scale(picture: Picture) -> str:
    scale = colours.scale_of(forces(picture))
    if scale is None:
        return ""
    marks = "".join(
        f'<span style="left:{100 * mark.position:.2f}%">{escaped(mark.label)}</span>' for mark in colours.ticks(scale)
    )
    title = escaped(picture.value_name) + (" (logarithmic)" if scale.log else "")
    bar = f'<div id="bar" style="background:{gradient()}"></div><div id="marks">{marks}</div>'
    ends = "<figcaption>◂ weak: gives way first<span>strong ▸</span></figcaption>"
    return f'<figure id="scale"><strong>{title}</strong>{bar}{ends}</figure>'


def _packed(picture: Picture, parts: list[Layer]) -> str:
    front = front_view(picture)
    packer = Packer()
    drawn = [{"role": layer.role, "parts": [_part(part, packer) for part in layer.parts]} for layer in parts]
    tails, heads = (np.array([getattr(a, end) for a in picture.weakest]).reshape(-1, 3) for end in ("tail", "head"))
    shown = heat_points(picture)
    return packer.text(
        {
            "layers": drawn,
            "up": picture.up.tolist(),
            "views": {"front": front.toward.tolist(), "back": back_view(picture, front).toward.tolist()},
            "bounds": [shown.min(axis=0).tolist(), shown.max(axis=0).tolist()],
            "shown": packer.put(np.concatenate([_corners(shown), tails]), "f4"),
            "badges": (tails + 0.15 * (tails - heads)).tolist(),
        }
    )


def _corners(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the extreme points (N, 3) in many directions, which need as much room in a view as all points."""
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 13)
    level, above = (grid.ravel() for grid in np.meshgrid(turn, tilt))
    ways = np.stack([np.cos(above) * np.cos(level), np.cos(above) * np.sin(level), np.sin(above)])
    return np.asarray(points[np.unique(np.argmax(points @ ways, axis=0))])


def _part(part: Faces | Lines | Dots, packer: Packer) -> dict[str, Any]:
    if isinstance(part, Faces):
        part = welded(part)
        marked = (part.rgb == colours.UNDECIDED).all(axis=1) * _HATCHED
        paint = np.column_stack([np.rint(part.rgb * 255.0), marked])
        return {
            "shape": "faces",
            "solid": part.solid,
            "vertices": packer.put(part.vertices, "f4"),
            "triangles": packer.put(part.triangles, "u4"),
            "cell": packer.put(part.cell, "u4"),
            "paint": packer.put(paint, "u1"),
            "texts": part.texts,
        }
    if isinstance(part, Lines):
        ends = packer.put(part.segments.reshape(-1, 3), "f4")
        return {"shape": "lines", "vertices": ends, "colour": part.colour, "width": part.width}
    return {
        "shape": "dots", "vertices": packer.put(part.points, "f4"), "colour": part.colour, "width": part.width
    }  # fmt: skip
