"""Write a robustness map as one HTML file that turns under the pointer and needs no network."""

from __future__ import annotations

import json
import os
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holdfast.base.errors import HoldfastError
from holdfast.base.files import write_atomically
from holdfast.base.text import escaped
from holdfast.view import colours
from holdfast.view.camera import View, back_view, front_view, heat_points, stacked
from holdfast.view.marks import INK
from holdfast.view.page import PAGE
from holdfast.view.picture import Picture
from holdfast.view.soup import forces
from holdfast.view.traces import Group, groups

_MARGIN = 0.15  # margin around the picture, as a share of its longest side
# Half the opening angle of plotly's perspective camera, less a rim; and how much wider than high a plot usually is.
_OPENING = 0.86 * float(np.tan(np.pi / 8.0))
_WIDER = 1.25


def write_html(picture: Picture, path: str | os.PathLike[str]) -> None:
    """Write the picture as a self-contained 3D page; if writing fails, an existing file is left unchanged."""
    write_atomically(path, _page(picture).encode("utf-8"))


def _page(picture: Picture) -> str:
    try:
        from plotly.offline import get_plotlyjs
    except ImportError as error:
        raise HoldfastError(
            "writing an HTML page needs plotly, which is not installed; remedy: pip install 'holdfast[viewer]'"
        ) from error
    parts = groups(picture)
    traces = [trace for group in parts for trace in group.traces]
    views = _views(picture)
    data = {"traces": traces, "layout": _layout(picture, views["front"]), "views": views, "badges": _badges(picture)}
    return Template(PAGE).substitute(
        title=escaped(picture.title),
        subtitle=escaped(picture.subtitle),
        switches=_switches(parts),
        weakest=_weakest(picture),
        data=_json(data),
        plotly=get_plotlyjs(),
    )


def _json(data: object) -> str:
    # "</script>" inside a text would otherwise end the script that carries it.
    return json.dumps(data, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def _switches(parts: list[Group]) -> str:
    rows, first = [], 0
    for group in parts:
        numbers = ",".join(str(first + k) for k in range(len(group.traces)))
        first += len(group.traces)
        rows.append(
            f'<label><input type="checkbox" data-traces="{numbers}" data-role="{group.role}" checked>'
            f'<i style="background:{group.swatch}"></i>{escaped(group.name)}</label>'
        )
    return "\n".join(rows)


def _weakest(picture: Picture) -> str:
    if not picture.weakest:
        return ""
    items = "".join(f"<li>{escaped(arrow.label)}</li>" for arrow in picture.weakest)
    return f"<h2>Weakest pushes</h2><ol>{items}</ol>"


def _bounds(picture: Picture) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    ends = [end for arrow in (*picture.weakest, *picture.contact_forces) for end in (arrow.tail, arrow.head)]
    points = np.concatenate([heat_points(picture), stacked(ends)])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * (float((high - low).max()) or 1.0)
    return low - margin, high + margin


def _views(picture: Picture) -> dict[str, Any]:
    low, high = _bounds(picture)
    # Plotly measures its camera from the middle of the axis box, whose longest side the layout sets to 1.
    tails = stacked([arrow.tail for arrow in picture.weakest])
    points = (np.concatenate([heat_points(picture), tails]) - (low + high) / 2.0) / float((high - low).max())
    front = front_view(picture)
    return {"front": _camera(front, points), "back": _camera(back_view(picture, front), points)}


def _camera(view: View, points: NDArray[np.float64]) -> dict[str, Any]:
    flat = np.abs(view.flat(points)) / np.array([_OPENING * _WIDER, _OPENING])
    reach = float((flat.max(axis=1) + points @ view.toward).max())
    eye, up = (dict(zip("xyz", vector.tolist(), strict=True)) for vector in (reach * view.toward, view.up))
    return {"eye": eye, "up": up, "center": {"x": 0, "y": 0, "z": 0}}


def _layout(picture: Picture, camera: dict[str, Any]) -> dict[str, Any]:
    low, high = _bounds(picture)
    axes = {
        f"{axis}axis": {"visible": False, "range": [float(low[k]), float(high[k])], "autorange": False}
        for k, axis in enumerate("xyz")
    }
    # Aspect mode "data" would count the cropped parts of large floors; this keeps true proportions without them.
    ratio = dict(zip("xyz", ((high - low) / (high - low).max()).tolist(), strict=True))
    layout: dict[str, Any] = {
        "scene": {**axes, "aspectmode": "manual", "aspectratio": ratio, "camera": camera, "dragmode": "orbit"},
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "showlegend": False,
        "paper_bgcolor": "#ffffff",
        "hoverlabel": {"bgcolor": "#ffffff", "bordercolor": INK, "align": "left", "font": {"size": 14}},
    }
    scale = colours.scale_of(forces(picture))
    if scale is not None:
        layout["coloraxis"] = _coloraxis(scale, picture.value_name)
    return layout


def _badges(picture: Picture) -> list[dict[str, Any]]:
    look = {"showarrow": False, "bgcolor": INK, "bordercolor": "#ffffff", "borderpad": 3, "opacity": 0.92}
    font = {"color": "#ffffff", "size": 13}
    places = [arrow.tail + 0.15 * (arrow.tail - arrow.head) for arrow in picture.weakest]
    return [
        {**dict(zip("xyz", place.tolist(), strict=True)), "text": f"<b>{k + 1}</b>", "font": font, **look}
        for k, place in enumerate(places)
    ]


def _coloraxis(scale: colours.Scale, name: str) -> dict[str, Any]:
    stops = np.linspace(0.0, 1.0, len(colours.TABLE))
    marks = colours.ticks(scale)
    title = escaped(name) + ("  (logarithmic)" if scale.log else "")
    return {
        "cmin": 0.0,
        "cmax": 1.0,
        "colorscale": [[float(p), colours.hex_of(rgb)] for p, rgb in zip(stops, colours.TABLE, strict=True)],
        "colorbar": {
            "title": {"text": title, "side": "right"},
            "tickmode": "array",
            "tickvals": [mark.position for mark in marks],
            "ticktext": [mark.label for mark in marks],
            "thickness": 22,
            "len": 0.8,
            "outlinewidth": 0,
            "ticks": "outside",
        },
    }
