"""Write a robustness map as a PNG, without a display or a graphics card."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from holdfast.base.errors import HoldfastError
from holdfast.base.files import write_atomically
from holdfast.drawing import colours
from holdfast.drawing.canvas import blank, paint, pixel_axes, png_of
from holdfast.drawing.footer import GREY, Writer, draw_footer, draw_header, paint_bar
from holdfast.drawing.layout import Layout, Shot, layout_of
from holdfast.drawing.lettering import block, draw_axes, draw_names
from holdfast.drawing.marks import draw_contacts, draw_pushes, draw_scale_bar, visible
from holdfast.drawing.picture import Picture
from holdfast.drawing.shade import Panel, render
from holdfast.drawing.soup import fixed, forces, movable, movable_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SMALLEST = (480, 300)  # smallest legible picture: width and height [px]


def write_png(picture: Picture, path: str | os.PathLike[str], *, size: tuple[int, int] = (1600, 1000)) -> None:
    """Write the picture as a PNG file of ``size`` = (width, height) pixels.

    If this fails, an existing file is left unchanged. Raises HoldfastError if the size is too small.
    """
    if size[0] < _SMALLEST[0] or size[1] < _SMALLEST[1]:
        raise HoldfastError(f"size: {size} is too small for a legible picture; use at least {_SMALLEST}")
    write_atomically(path, _png(picture, size))


def _png(picture: Picture, size: tuple[int, int]) -> bytes:
    scale = colours.scale_of(forces(picture))
    layout = layout_of(picture, size)
    panels = [_panel(picture, shot, scale) for shot in layout.shots]
    figure, canvas = blank(*size)
    axes = pixel_axes(figure, *size)
    paint(figure, _page(layout, panels, scale, size))
    _annotate(Writer(axes, canvas, layout.unit), picture, layout, panels, scale)
    return png_of(canvas)


def _panel(picture: Picture, shot: Shot, scale: colours.Scale | None) -> Panel:
    still = fixed(picture) if shot.fixed else None
    shape = (shot.box.height, shot.box.width)
    return render(movable(picture, scale), still, shot.camera, shape, ghost=shot.contacts)


def _page(
    layout: Layout, panels: list[Panel], scale: colours.Scale | None, size: tuple[int, int]
) -> NDArray[np.float64]:
    page = np.ones((size[1], size[0], 3))
    for shot, panel in zip(layout.shots, panels, strict=True):
        box = shot.box
        page[box.top : box.top + box.height, box.left : box.left + box.width] = panel.image
    paint_bar(page, layout, scale)
    return page


def _annotate(
    writer: Writer, picture: Picture, layout: Layout, panels: list[Panel], scale: colours.Scale | None
) -> None:
    draw_header(writer, picture, layout.header)
    maps = [(shot, panel) for shot, panel in zip(layout.shots, panels, strict=True) if not shot.contacts]
    seen = [[visible(shot, panel.depth, arrow) for arrow in picture.weakest] for shot, panel in maps]
    for index, (shot, panel) in enumerate(maps):
        nowhere = {k: False for k in range(len(picture.weakest)) if index == 0 and not any(s[k] for s in seen)}
        here = {k: True for k, is_seen in enumerate(seen[index]) if is_seen}
        draw_pushes(writer.axes, shot, picture, here | nowhere, layout.unit)
        draw_names(writer, shot.box, panel.body, movable_names(picture), _written_on(shot, picture, layout.unit))
    for shot in layout.shots:
        _frame(writer.axes, shot, layout.unit)
        writer.put(shot.box.left + 12 * layout.unit, shot.box.top + 23 * layout.unit, shot.caption, 14.0, colour=GREY)
        if shot.contacts:
            draw_contacts(writer.axes, shot, picture, layout.unit)
        draw_axes(writer.axes, shot.box, shot.camera.view, layout.unit)
    draw_scale_bar(writer.axes, layout.shots[0], layout.unit)
    draw_footer(writer, picture, layout, scale)


def _written_on(shot: Shot, picture: Picture, unit: float) -> NDArray[np.bool_]:
    """Return the pixels of a panel that arrows, their numbers and the scale bar take, where no name is written."""
    taken = np.zeros((shot.box.height, shot.box.width), dtype=bool)
    size = round(34 * unit)
    for arrow in picture.weakest:
        for share in np.linspace(0.0, 1.6, 9):
            place = arrow.head + share * (arrow.tail - arrow.head)
            column, row, _ = shot.camera.pixels(place[None])[0]
            if 0 <= column < shot.box.width and 0 <= row < shot.box.height:
                block(taken, row, column, size, size)
    block(taken, shot.box.height - 30 * unit, shot.box.width - 70 * unit, round(150 * unit), round(50 * unit))
    return taken


def _frame(axes: Axes, shot: Shot, unit: float) -> None:
    from matplotlib.patches import Rectangle

    box = shot.box
    axes.add_patch(
        Rectangle((box.left, box.top), box.width, box.height, fill=False, edgecolor="#dfe2e7", lw=0.8 * unit, zorder=1)
    )
