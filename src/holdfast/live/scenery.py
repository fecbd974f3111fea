"""The content of the window as arrays and HTML: coloured bodies, contacts, forces, the push, and texts."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from holdfast.base.arrays import Float, Int
from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.public import number
from holdfast.base.text import LONGEST_NAME, escaped
from holdfast.drawing import colours
from holdfast.drawing.colours import gradient
from holdfast.drawing.edges import arrow_mesh
from holdfast.drawing.map_files import Painted, painted
from holdfast.drawing.picture import Arrow, forces, legend
from holdfast.engines.verdict import Status
from holdfast.live.window_model import ViewModel
from holdfast.queries.map import RobustnessMap
from holdfast.queries.result import endless, gives_way
from holdfast.report.contact_report import bounds_text
from holdfast.report.description import WORDS
from holdfast.report.map_picture import bare_picture, force_arrows, picture_of

MAP, GROUPS = "largest push", "groups"
OPENING: Final = "#ff8c00"  # colour of contacts that open
SLIDING: Final = "#c800c8"  # colour of contacts that slide
PALE: Final = 0.55  # share of white in the colours of groups
PUSH_LENGTH: Final = 0.2  # length of the arrow of the push, as a share of the assembly's size
STATUS: Final = {Status.UNDECIDED: colours.UNDECIDED, Status.UNSTABLE: colours.FALLS}


def bodies(model: ViewModel, colour_by: str) -> list[Painted]:
    """Return the surface of every body in the colours of the map, or of the groups if it is not mapped."""
    if colour_by == MAP and model.map is not None:
        surfaces, mapped = painted(picture_of(model.map)), set(model.map.cells)
    else:
        surfaces, mapped = painted(bare_picture(model.assembly.scene)), set()
    rgb = {body.name: colours.FIXED for body in model.assembly.bodies if body.fixed} | group_colours(model)
    return [p if p.name in mapped else replace(p, rgb=np.tile(rgb[p.name], (len(p.vertices), 1))) for p in surfaces]


def group_colours(model: ViewModel) -> dict[str, Rgb]:
    """Return the colour of each movable body: that of its group, or of its status if that is not STABLE."""
    by_name: dict[str, Rgb] = {}
    for k, names in enumerate(model.assembly.groups):
        red, green, blue = ((1 - PALE) * c + PALE for c in rgb_of(colours.GROUPS[k % len(colours.GROUPS)]))
        by_name |= dict.fromkeys(names, (red, green, blue))
    statuses = model.status_of_groups().items()
    return by_name | {name: STATUS[status] for name, status in statuses if status in STATUS}


def resting_forces(model: ViewModel) -> tuple[Arrow, ...]:
    """Return the contact forces at rest as arrows; none if the assembly does not stand or has no verdict yet."""
    verdict = model.map.verdict if model.map is not None else model.verdict
    if verdict is None or verdict.forces is None:
        return ()
    return force_arrows(model.assembly, verdict.forces)


def push_arrow(model: ViewModel) -> tuple[Arrow, ...]:
    """Return the arrow of the push at the chosen point; none if no point is chosen."""
    if model.pick is None or model.direction is None:
        return ()
    tail = model.pick.point - PUSH_LENGTH * model.assembly.size * model.direction
    return (Arrow(tail, model.pick.point, ""),)


def arrows_mesh(arrows: tuple[Arrow, ...], size: float, colour: str) -> tuple[Float, Int, Float]:
    """Return vertices (V, 3), triangles (T, 3) and colours (V, 3) of arrows in a scene of this ``size`` [m]."""
    vertices, triangles = arrow_mesh(arrows, 0.005 * size)
    return vertices, triangles, np.tile(rgb_of(colour), (len(vertices), 1))


def legend_html(model: ViewModel, colour_by: str) -> str:
    """Return the legend: the scale in newtons with its marks, and the other colours."""
    box = "display:inline-block;width:14px;height:14px;margin:0 6px -2px 0;border:1px solid #8888;background:"
    if colour_by != MAP or model.map is None:
        statuses = model.status_of_groups().values()
        names = {Status.UNDECIDED: "undecided", Status.UNSTABLE: "falls"}
        rows = [(STATUS[status], text) for status, text in names.items() if status in statuses]
        return _legend("one colour for each group of bodies", "", rows, box)
    picture = picture_of(model.map)
    scale = colours.scale_of(forces(picture))
    rows = [(colours.SPECIAL[kind], name) for kind, name in legend(picture).items()]
    said = f'<div style="font-size:12px">{escaped(map_caption(model, model.map))}</div>'
    if scale is None:
        return _legend(picture.value_name, said, rows, box)
    mark_style = "position:absolute;white-space:nowrap;transform:translateX(-50%);"
    marks = "".join(
        f'<span style="{mark_style}left:{100 * mark.position:.2f}%">{escaped(mark.label)}</span>'
        for mark in colours.ticks(scale)
    )
    bar = f'<div id="scale" style="height:16px;background:{gradient()}"></div>'
    bar += f'<div style="position:relative;height:18px;font-size:11px">{marks}</div>' + said
    return _legend(picture.value_name + (" (logarithmic)" if scale.log else ""), bar, rows, box)


def map_caption(model: ViewModel, shown: RobustnessMap) -> str:
    """Return the caption of a map: engine, claim, number of pushes and, until it is complete, the progress."""
    text = f"engine {shown.engine} ({shown.claim.words}), {len(shown.force):,} inward pushes"
    if model.mapped or model.portions is None:
        return text
    left = len(model.assembly.movable) - len(shown.cells)
    pale = f", {left} pale {'one' if left == 1 else 'ones'} not asked yet" if left else ""
    return f"{text}: {model.portions.text}{pale}"


def _legend(title: str, bar: str, rows: list[tuple[Rgb, str]], box: str) -> str:
    swatches = "".join(
        f'<div style="font-size:12px"><span style="{box}{colours.hex_of(rgb)}"></span>{escaped(text)}</div>'
        for rgb, text in rows
    )
    return f'<div style="padding:2px 22px"><b style="font-size:13px">{escaped(title)}</b>{bar}{swatches}</div>'


def verdict_html(model: ViewModel) -> str:
    """Return the verdict with its reason."""
    if model.verdict is None:
        return _paragraph("<b>computing whether it stands ...</b>")
    name = escaped(model.assembly.scene.name or "scene", LONGEST_NAME)
    head = f"<b>{name} {WORDS[model.verdict.status]}</b> (engine {model.verdict.engine}: {model.verdict.claim.words})"
    return _paragraph(
        head + f"<br>{escaped(model.verdict.reason)}" + "".join(f"<br>{escaped(n)}" for n in model.verdict.notes)
    )


def push_html(model: ViewModel) -> str:
    """Return the answer for the push at the chosen point: R, its bounds, and what moves."""
    if model.pick is None:
        return _paragraph("Click a body to push it there.")
    place, answer = ", ".join(f"{v:.3f}" for v in model.pick.point), model.push
    lines = [f"<b>{escaped(model.pick.body, LONGEST_NAME)}</b> at ({place}) m"]
    if answer is None:
        lines.append("computing ...")
    elif answer.status[0] is Status.UNDECIDED:
        lines += ["<b>undecided</b>", escaped(answer.undecided.text)]
    elif answer.status[0] is Status.UNSTABLE:
        lines += ["<b>falls without a push</b>", escaped(answer.verdict.reason)]
    elif answer.status[0] is Status.INFINITE:
        lines.append(f"<b>{escaped(endless(answer.answers, 0, 'N'))}</b>, pushed in this direction")
    else:
        lines += [f"R = <b>{number(float(answer.force[0]), 'N')}</b>", *bounds_text(answer)]
        lines.append(escaped(gives_way(answer.mode[0], answer.moving[0])))
    return _paragraph("<br>".join(lines))


def _paragraph(html: str) -> str:
    return f'<div style="padding:2px 22px;font-size:13px;line-height:1.45">{html}</div>'
