"""The page of a map as a PNG file: panels from the front, from behind and of contacts, above their legend."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Final

import numpy as np

from holdfast.base.colour import rgb_of
from holdfast.base.errors import HoldfastError
from holdfast.base.files import write_atomically
from holdfast.drawing import colours
from holdfast.drawing.camera import back_view, fit, front_view
from holdfast.drawing.canvas import PageBox, Writer, badge, block, draw_axes, draw_names
from holdfast.drawing.colours import CONTACT, GREY, INK
from holdfast.drawing.marks import Shot, draw_contacts, draw_pushes, draw_scale_bar, visible
from holdfast.drawing.picture import Picture, ends_of, fixed, forces, heat_points, legend, movable, movable_names
from holdfast.drawing.render import Panel, render

_SMALLEST: Final = (480, 300)  # smallest legible picture: width and height [px]
_DESIGN: Final = (1200, 750)  # width and height of the design [px]; shown 800 px wide, its text is legible
_PAD: Final = 34  # left and right margin of the page [px], here and below at the design size
_HEADER: Final = 104  # height of the header [px]
_FOOTER: Final = 184  # height of the footer [px]
_GUTTER: Final = 16  # distance between panels [px]
CAPTION: Final = 34  # height of a panel's caption [px]
_MARGIN: Final = 30  # margin around the bodies in a panel [px]
_WIDE_SPLIT: Final = 0.585  # share of the width for the main panel, with the other panels stacked beside it
_COLUMN_SPLITS: Final = (0.42, 0.29, 0.29)  # shares of the width for three panels side by side
_MAIN_WEIGHT: Final = 2.0  # weight of the main panel's scale when two arrangements are compared
_BAR_SHARE: Final = 0.37  # share of the footer's width that the colour bar takes
_SWATCH_SHARE: Final = 0.23  # share of the footer's width that the swatches take
_ROWS: Final = 5  # the most rows in a column of the list of weakest pushes
_ROW: Final = 25.0  # height of a row of the footer [px]


def write_png(picture: Picture, path: str | os.PathLike[str], *, size: tuple[int, int] = (1600, 1000)) -> None:
    """Write the picture as a PNG file of ``size`` = (width, height) pixels.

    If this fails, an existing file is left unchanged. Raises HoldfastError if the size is too small.
    """
    write_atomically(path, map_png(picture, size=size))


def map_png(picture: Picture, *, size: tuple[int, int]) -> bytes:
    """Return what ``write_png`` writes."""
    if size[0] < _SMALLEST[0] or size[1] < _SMALLEST[1]:
        raise HoldfastError(f"size: {size} is too small for a legible picture; use at least {_SMALLEST}")
    scale = colours.scale_of(forces(picture))
    layout = layout_of(picture, size)
    writer = Writer(*size, layout.unit)
    panels = []
    for shot in layout.shots:
        still, shape = fixed(picture) if shot.fixed else None, (shot.box.height, shot.box.width)
        panels.append(render(movable(picture, scale), still, shot.camera, shape, ghost=shot.contacts))
        shot.box.of(writer.image)[:] = panels[-1].image
    unit, points = writer.unit, 27.0
    while points > 18.0 and writer.width(picture.title, points, bold=True) > layout.header.width:
        points -= 1.0
    writer.put_clipped(layout.header.left, 44 * unit, picture.title, points, layout.header.width, bold=True)
    for row, line in enumerate(writer.wrapped(picture.subtitle, 16.0, layout.header.width, 2)):
        writer.put(layout.header.left, (70 + 21 * row) * unit, line, 16.0, colour=GREY)
    _annotate(writer, picture, layout, panels)
    _draw_footer(writer, picture, layout, scale)
    return writer.png()


@dataclass(frozen=True)
class Layout:
    """The layout of a page: its header, panels and footer.

    ``unit`` is the size of a pixel of the design.
    """

    unit: float
    header: PageBox
    shots: tuple[Shot, ...]
    footer: PageBox


def layout_of(picture: Picture, size: tuple[int, int]) -> Layout:
    """Lay out a page of (width, height) pixels; of two arrangements, choose the one that draws the bodies larger."""
    width, height = size
    unit = min(width / _DESIGN[0], height / _DESIGN[1])
    pad, header, footer = (round(v * unit) for v in (_PAD, _HEADER, _FOOTER))
    inner = PageBox(pad, header, width - 2 * pad, height - header - footer)
    front = front_view(picture)
    bodies = heat_points(picture)
    pushes = np.concatenate([bodies, ends_of(picture.weakest)[0]])
    behind = "behind, from below" + ("  (fixed bodies left out)" if any(s.fixed for s in picture.solids) else "")
    plans = [
        ("front, from above", front, pushes, True, False),
        (behind, back_view(picture, front), pushes, False, False),
    ]
    if _has_contacts(picture):
        shown = "contact forces at rest" if picture.contact_forces else "contact patches"
        plans.append((shown, front, np.concatenate([bodies, *ends_of(picture.contact_forces)]), True, True))
    candidates = []
    for boxes in _arrangements(len(plans), inner, unit):
        shots, strip = [], round(CAPTION * unit)
        for (caption, view, points, with_fixed, contacts), box in zip(plans, boxes, strict=True):
            camera = fit(view, points, box.width, box.height - strip, _MARGIN * unit, top=strip)
            shots.append(Shot(caption, box, camera, with_fixed, contacts))
        candidates.append(shots)
    shots = max(candidates, key=lambda s: s[0].camera.scale * _MAIN_WEIGHT + sum(x.camera.scale for x in s[1:]))
    foot = PageBox(pad, height - footer, width - 2 * pad, footer)
    return Layout(unit, PageBox(pad, 0, width - 2 * pad, header), tuple(shots), foot)


def _has_contacts(picture: Picture) -> bool:
    return bool(picture.contact_forces or picture.outlines or len(picture.contact_points))


def _arrangements(count: int, inner: PageBox, unit: float) -> list[list[PageBox]]:
    """Return two arrangements of two or three panels: beside the main one, and in columns."""
    gutter = round(_GUTTER * unit)
    main = round(inner.width * _WIDE_SPLIT)
    left, side = inner.left + main + gutter, inner.width - main - gutter
    wide = [inner._replace(width=main)]
    rows = count - 1
    tall = (inner.height - (rows - 1) * gutter) // rows
    wide += [PageBox(left, inner.top + k * (tall + gutter), side, tall) for k in range(rows)]
    columns, x = [], inner.left
    for split in _COLUMN_SPLITS if count == 3 else (0.5, 0.5):
        share = round((inner.width - rows * gutter) * split)
        columns.append(PageBox(x, inner.top, share, inner.height))
        x += share + gutter
    return [wide, columns]


def _annotate(writer: Writer, picture: Picture, layout: Layout, panels: list[Panel]) -> None:
    """Draw pushes, names, contacts, captions and axes over the panels."""
    axes, unit = writer.axes, layout.unit
    maps = [(shot, panel) for shot, panel in zip(layout.shots, panels, strict=True) if not shot.contacts]
    seen = [[visible(shot, panel.depth, arrow) for arrow in picture.weakest] for shot, panel in maps]
    for index, (shot, panel) in enumerate(maps):
        nowhere = {k: False for k in range(len(picture.weakest)) if index == 0 and not any(s[k] for s in seen)}
        here = {k: True for k, is_seen in enumerate(seen[index]) if is_seen}
        draw_pushes(axes, shot, picture, here | nowhere, unit)
        taken = np.zeros((shot.box.height, shot.box.width), dtype=bool)
        size = round(34 * unit)
        for mark in picture.weakest:
            for share in np.linspace(0.0, 1.6, 9):
                place = mark.head + share * (mark.tail - mark.head)
                column, row, _ = shot.camera.pixels(place[None])[0]
                if 0 <= column < shot.box.width and 0 <= row < shot.box.height:
                    block(taken, row, column, size, size)
        block(taken, shot.box.height - 30 * unit, shot.box.width - 70 * unit, round(150 * unit), round(50 * unit))
        draw_names(writer, shot.box, panel.body, movable_names(picture), taken)
    for shot in layout.shots:
        box = shot.box
        writer.framed(box)
        writer.put(box.left + 12 * unit, box.top + 23 * unit, shot.caption, 14.0, colour=GREY)
        if shot.contacts:
            draw_contacts(axes, shot, picture, unit)
        draw_axes(axes, box, shot.camera.view, unit)
    draw_scale_bar(axes, layout.shots[0], unit)


def _draw_footer(writer: Writer, picture: Picture, layout: Layout, scale: colours.Scale | None) -> None:
    """Draw the texts of the colour bar, the swatches, and the numbered list of the weakest pushes."""
    foot, unit = layout.footer, writer.unit
    left = float(foot.left)
    if scale is not None:
        indent = round(20 * unit)
        width = round(foot.width * _BAR_SHARE) - indent
        bar = PageBox(foot.left + indent, foot.top + round(48 * unit), width, round(24 * unit))
        bar.of(writer.image)[:] = colours.sample(np.linspace(0.0, 1.0, width))
        base = bar.top + bar.height
        title = picture.value_name + ("   (logarithmic)" if scale.log else "")
        writer.put(foot.left, bar.top - 16 * unit, title, 16.0, bold=True)
        for tick in colours.ticks(scale):
            x = bar.left + tick.position * bar.width
            writer.axes.plot([x, x], [base, base + 6 * unit], color=INK, lw=0.8 * unit, zorder=9)
            writer.put(x, base + 22 * unit, tick.label, 14.0, align="center")
        writer.put(bar.left, base + 46 * unit, "◂ weak: gives way first", 13.0, colour=GREY)
        writer.put(bar.left + bar.width, base + 46 * unit, "strong ▸", 13.0, colour=GREY, align="right")
        left += _BAR_SHARE * foot.width + 44 * unit
    _draw_swatches(writer, picture, left, foot)
    if picture.weakest:
        _draw_list(writer, [arrow.label for arrow in picture.weakest], left + _SWATCH_SHARE * foot.width, foot)


def _draw_swatches(writer: Writer, picture: Picture, left: float, foot: PageBox) -> None:
    shown: list[tuple[bool, tuple[float, ...], str]] = [
        (any(solid.fixed for solid in picture.solids), colours.FIXED, "fixed body"),
        (any(not solid.fixed for solid in picture.solids), colours.COVERED, "covered, cannot be pushed"),
        (_has_contacts(picture), (*rgb_of(CONTACT), 0.3), "contact patch"),
    ]
    special = [(colours.SPECIAL[kind], name) for kind, name in legend(picture).items()]
    rows = [*special, *((colour, text) for present, colour, text in shown if present)]
    unit = writer.unit
    if rows:
        writer.put(left, foot.top + 32 * unit, "other surfaces", 16.0, bold=True)
    step = min(_ROW * unit, (foot.height - 50 * unit) / max(len(rows), 1))
    for row, (colour, text) in enumerate(rows):
        y = foot.top + 48 * unit + row * step
        hatch = "////" if colour == colours.UNDECIDED else ""
        writer.swatch(left, y, 24 * unit, 16 * unit, facecolor=colour, edgecolor=INK, hatch=hatch, lw=0.6)
        writer.put_clipped(left + 34 * unit, y + 13 * unit, text, 14.0, _SWATCH_SHARE * foot.width - 44 * unit)


def _draw_list(writer: Writer, labels: list[str], left: float, foot: PageBox) -> None:
    unit, room = writer.unit, foot.left + foot.width - left
    writer.put(left, foot.top + 32 * unit, "weakest pushes", 16.0, bold=True)
    widest = max(writer.width(label, 14.0) for label in labels) + 50 * unit
    columns = 2 if widest <= room / 2 and len(labels) > _ROWS else 1
    letters = 14.0 if widest <= room / columns else 11.5
    fitting = columns * _ROWS
    shown = len(labels) if len(labels) <= fitting else fitting - 1
    for k, label in enumerate(labels[:shown]):
        x = left + (k // _ROWS) * room / columns
        y = foot.top + (56 + (k % _ROWS) * _ROW) * unit
        badge(writer.axes, x + 11 * unit, y, str(k + 1), 0.85 * unit)
        writer.put_clipped(x + 30 * unit, y + 5 * unit, label, letters, room / columns - 40 * unit)
    if shown < len(labels):
        x, y = left + (columns - 1) * room / columns, foot.top + (61 + (_ROWS - 1) * _ROW) * unit
        writer.put(x + 30 * unit, y, f"… and {len(labels) - shown} more", 14.0, colour=GREY)
