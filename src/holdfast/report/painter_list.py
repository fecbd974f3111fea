"""The painters of all answers, and the small pictures of scenes and answers in notebooks.

The methods ``save_png``, ``save_html``, ``save_glb`` and ``save_ply`` of an answer find them there.
"""

from __future__ import annotations

import base64
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import numpy as np

from holdfast.applications.carrying.carry import Carried
from holdfast.applications.disassembly.order import Disassembly
from holdfast.applications.placement.result import Placement, Placements
from holdfast.applications.pushing.firmer import Firmer
from holdfast.applications.resting_poses import RestingPoses
from holdfast.applications.settled import Settled
from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.base.painters import register_glimpse, register_painter
from holdfast.base.text import escaped
from holdfast.drawing import colours
from holdfast.drawing.html_page import write_html
from holdfast.drawing.map_files import write_glb, write_ply
from holdfast.drawing.map_png import write_png
from holdfast.drawing.panel_sheets import write_sequence
from holdfast.drawing.picture import forces, legend
from holdfast.drawing.plots import write_timeline
from holdfast.drawing.render import map_thumbnail, thumbnail
from holdfast.drawing.svg import rose
from holdfast.queries.map import RobustnessMap
from holdfast.report.carrier_report import LEVEL, frame_names, level_angles, save_polar, timeline
from holdfast.report.map_picture import picture_of, solids_of
from holdfast.report.order_report import placements_strip, strip_of
from holdfast.report.pose_report import save_firmer_png, save_placement_png, save_resting_png, save_settled_png
from holdfast.scene.scene import Scene

SIZE = (300, 210)  # width and height of a picture in a notebook [px]


def register() -> None:
    """Register the painters of all answers that can be drawn."""
    for suffix, write in ((".png", write_png), (".html", write_html), (".glb", write_glb), (".ply", write_ply)):
        register_painter(RobustnessMap, suffix, partial(_painted, picture_of, write))
    register_painter(TransportLimits, ".png", save_polar)
    register_painter(Carried, ".png", partial(_painted, timeline, write_timeline))
    register_painter(Disassembly, ".png", partial(_painted, strip_of, write_sequence))
    register_painter(Placement, ".png", save_placement_png)
    register_painter(Placements, ".png", partial(_painted, placements_strip, write_sequence))
    register_painter(Firmer, ".png", save_firmer_png)
    register_painter(RestingPoses, ".png", save_resting_png)
    register_painter(Settled, ".png", save_settled_png)
    register_glimpse(glimpse)


def _painted(content: Callable[[Any], Any], write: Callable[[Any, str], None], result: object, path: str) -> None:
    write(content(result), path)


def glimpse(value: object) -> str:
    """Return the picture of a scene or an answer as HTML without scripts, or "" if it has none."""
    match value:
        case RobustnessMap():
            return _map(value)
        case TransportLimits():
            if len(value.directions) < 3 or np.abs(value.directions @ value.assembly.scene.up).max() > LEVEL:
                return ""
            names = frame_names(value.assembly)
            return rose(level_angles(value), value.acceleration, value.answers.decided, "m/s²", names)
        case Placement():
            return "" if value.assembly is None else _scene(value.assembly.scene, (value.name,))
        case Settled():
            return _scene(value.scene, [fall.body for fall in value.fell])
        case Disassembly():
            return _scene(value.assembly.scene, value.order[:1])
        case Assembly():
            return _scene(value.scene)
        case Scene():
            return _scene(value)
    return ""


def _scene(scene: Scene, coloured: Collection[str] = ()) -> str:
    return _image(thumbnail(solids_of(scene.bodies), scene.up, coloured, SIZE), "the bodies of the scene")


def _map(result: RobustnessMap) -> str:
    picture = picture_of(result)
    parts = [_image(map_thumbnail(picture, SIZE), "the map on the bodies")]
    scale = colours.scale_of(forces(picture))
    if scale is not None:
        low, *_, high = colours.ticks(scale)
        parts.append(
            f'<div style="width:{SIZE[0]}px;font-size:12px">'
            f'<div style="height:12px;background:{colours.gradient()}"></div>'
            f'<div style="float:left">{escaped(low.label)} N{", logarithmic" if scale.log else ""}</div>'
            f'<div style="float:right">{escaped(high.label)} N</div><br></div>'
        )
    swatch = "display:inline-block;width:12px;height:12px;margin-right:6px;background:"
    parts += [
        f'<div style="font-size:12px"><span style="{swatch}{colours.hex_of(colours.SPECIAL[kind])}"></span>'
        f"{escaped(name)}</div>"
        for kind, name in legend(picture).items()
    ]
    return "".join(parts)


def _image(png: bytes, what: str) -> str:
    content = base64.b64encode(png).decode("ascii")
    return (
        f'<img alt="{what}" style="background:white;border-radius:4px" src="data:image/png;base64,{content}" '
        f'width="{SIZE[0]}" height="{SIZE[1]}">'
    )
