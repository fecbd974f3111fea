"""The texts of a PNG: header, captions, colour bar, swatches and the list of the weakest pushes."""

from __future__ import annotations

from bisect import bisect
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.colour import rgb_of
from holdfast.base.text import one_line
from holdfast.drawing import colours
from holdfast.drawing.layout import Box, Layout, has_contacts
from holdfast.drawing.marks import CONTACT, FONT, INK, badge
from holdfast.drawing.picture import Picture, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

GREY: Final = "#59606b"  # colour of secondary text
_BAR_SHARE: Final = 0.37  # share of the footer's width that the colour bar takes
_SWATCH_SHARE: Final = 0.23  # share of the footer's width that the swatches take
_ROWS: Final = 5  # the most rows in a column of the list of weakest pushes
_ROW: Final = 25.0  # height of a row [px] at the design size
_POINTS_PER_PIXEL: Final = 0.72  # font size [points] of a letter height of one pixel


class Writer:
    """Writes and measures text on a page whose axes are in pixels."""

    def __init__(self, axes: Axes, canvas: FigureCanvasAgg, unit: float) -> None:
        self.axes = axes
        self.unit = unit
        self._renderer = canvas.get_renderer()

    def put(
        self,
        x: float,
        y: float,
        text: str,
        pixels: float,
        *,
        colour: str = INK,
        bold: bool = False,
        align: str = "left",
    ) -> Text:
        """Write one line of text with its baseline at row y; ``pixels`` is the letter height at the design size."""
        return self.axes.text(
            x,
            y,
            one_line(text),
            color=colour,
            fontsize=pixels * self.unit * _POINTS_PER_PIXEL,
            fontfamily=FONT,
            ha=align,
            va="baseline",
            fontweight="bold" if bold else "normal",
            zorder=9,
            parse_math=False,
        )

    def head(self, title: str, subtitle: str, page: float) -> None:
        """Write the title and the subtitle of a page that is ``page`` [px] wide."""
        self.put(60, 50, self.clipped(title, 27.0, page - 120, bold=True), 27.0, bold=True)
        self.put(60, 80, self.clipped(subtitle, 16.0, page - 120), 16.0, colour=GREY)

    def width(self, text: str, pixels: float, bold: bool = False) -> float:
        """Return the width of a line [px]."""
        text = one_line(text)
        from matplotlib.font_manager import FontProperties

        weight = "bold" if bold else "normal"
        font = FontProperties(family=FONT, size=pixels * self.unit * _POINTS_PER_PIXEL, weight=weight)
        return float(self._renderer.get_text_width_height_descent(text, font, False)[0])

    def clipped(self, text: str, pixels: float, room: float, bold: bool = False) -> str:
        """Return the text, shortened with an ellipsis if it is wider than ``room`` [px]."""
        text = one_line(text)
        if self.width(text, pixels, bold) <= room:
            return text
        end = bisect(range(len(text)), room, key=lambda n: self.width(text[:n] + "…", pixels, bold))
        return text[: max(end - 1, 0)].rstrip() + "…"

    def wrapped(self, text: str, pixels: float, room: float, lines: int) -> list[str]:
        """Return the text, broken at spaces into at most ``lines`` lines of ``room`` [px]."""
        result = [""]
        for word in one_line(text).split():
            longer = f"{result[-1]} {word}".strip()
            if len(result) == lines or not result[-1] or self.width(longer, pixels) <= room:
                result[-1] = longer
            else:
                result.append(word)
        return [self.clipped(line, pixels, room) for line in result]


def draw_header(writer: Writer, picture: Picture, box: Box) -> None:
    """Draw the title and up to two lines of subtitle."""
    unit = writer.unit
    size = 27.0
    title = picture.title
    while size > 18.0 and writer.width(title, size, bold=True) > box.width:
        size -= 1.0
    writer.put(box.left, 44 * unit, writer.clipped(title, size, box.width, bold=True), size, bold=True)
    for row, line in enumerate(writer.wrapped(picture.subtitle, 16.0, box.width, 2)):
        writer.put(box.left, (70 + 21 * row) * unit, line, 16.0, colour=GREY)


def paint_bar(page: NDArray[np.float64], layout: Layout, scale: colours.Scale | None) -> None:
    """Draw the colours of the scale into the page image (H, W, 3)."""
    if scale is None:
        return
    bar = _bar(layout)
    page[bar.top : bar.top + bar.height, bar.left : bar.left + bar.width] = colours.sample(
        np.linspace(0.0, 1.0, bar.width)
    )


def draw_footer(writer: Writer, picture: Picture, layout: Layout, scale: colours.Scale | None) -> None:
    """Draw the texts of the colour bar, the swatches, and the numbered list of the weakest pushes."""
    foot = layout.footer
    left = float(foot.left)
    if scale is not None:
        _draw_bar(writer, layout, scale, picture.value_name)
        left += _BAR_SHARE * foot.width + 44 * writer.unit
    _draw_swatches(writer, picture, left, foot)
    left += _SWATCH_SHARE * foot.width
    _draw_list(writer, picture, left, foot)


def _bar(layout: Layout) -> Box:
    foot, unit = layout.footer, layout.unit
    indent = round(20 * unit)
    return Box(
        foot.left + indent, foot.top + round(48 * unit), round(foot.width * _BAR_SHARE) - indent, round(24 * unit)
    )


def _draw_bar(writer: Writer, layout: Layout, scale: colours.Scale, name: str) -> None:
    unit, bar = writer.unit, _bar(layout)
    base = bar.top + bar.height
    title = name + ("   (logarithmic)" if scale.log else "")
    writer.put(layout.footer.left, bar.top - 16 * unit, title, 16.0, bold=True)
    for tick in colours.ticks(scale):
        x = bar.left + tick.position * bar.width
        writer.axes.plot([x, x], [base, base + 6 * unit], color=INK, lw=0.8 * unit, zorder=9)
        writer.put(x, base + 22 * unit, tick.label, 14.0, align="center")
    writer.put(bar.left, base + 46 * unit, "◂ weak: gives way first", 13.0, colour=GREY)
    writer.put(bar.left + bar.width, base + 46 * unit, "strong ▸", 13.0, colour=GREY, align="right")


def _draw_swatches(writer: Writer, picture: Picture, left: float, foot: Box) -> None:
    from matplotlib.patches import Rectangle

    unit = writer.unit
    rows = _swatches(picture)
    if rows:
        writer.put(left, foot.top + 32 * unit, "other surfaces", 16.0, bold=True)
    step = min(_ROW * unit, (foot.height - 50 * unit) / max(len(rows), 1))
    room = _SWATCH_SHARE * foot.width - 44 * unit
    for row, (colour, text) in enumerate(rows):
        y = foot.top + 48 * unit + row * step
        hatch = "////" if colour == colours.UNDECIDED else ""
        look: dict[str, Any] = {"facecolor": colour, "edgecolor": INK, "hatch": hatch, "lw": 0.6 * unit, "zorder": 9}
        writer.axes.add_patch(Rectangle((left, y), 24 * unit, 16 * unit, **look))
        writer.put(left + 34 * unit, y + 13 * unit, writer.clipped(text, 14.0, room), 14.0)


def _swatches(picture: Picture) -> list[tuple[str | tuple[float, ...], str]]:
    shown: list[tuple[bool, str | tuple[float, ...], str]] = [
        (any(solid.fixed for solid in picture.solids), colours.FIXED, "fixed body"),
        (any(not solid.fixed for solid in picture.solids), colours.COVERED, "covered, cannot be pushed"),
        (has_contacts(picture), (*rgb_of(CONTACT), 0.3), "contact patch"),
    ]
    special = [(colours.SPECIAL[kind], name) for kind, name in legend(picture).items()]
    return [*special, *((colour, text) for present, colour, text in shown if present)]


def _draw_list(writer: Writer, picture: Picture, left: float, foot: Box) -> None:
    unit = writer.unit
    labels = [arrow.label for arrow in picture.weakest]
    if not labels:
        return
    writer.put(left, foot.top + 32 * unit, "weakest pushes", 16.0, bold=True)
    room = foot.left + foot.width - left
    widest = max(writer.width(label, 14.0) for label in labels) + 50 * unit
    columns = 2 if widest <= room / 2 and len(labels) > _ROWS else 1
    letters = 14.0 if widest <= room / columns else 11.5
    fitting = columns * _ROWS
    shown = len(labels) if len(labels) <= fitting else fitting - 1
    for k, label in enumerate(labels[:shown]):
        x = left + (k // _ROWS) * room / columns
        y = foot.top + (56 + (k % _ROWS) * _ROW) * unit
        badge(writer.axes, x + 11 * unit, y, str(k + 1), 0.85 * unit)
        writer.put(x + 30 * unit, y + 5 * unit, writer.clipped(label, letters, room / columns - 40 * unit), letters)
    if shown < len(labels):
        x, y = left + (columns - 1) * room / columns, foot.top + (61 + (_ROWS - 1) * _ROW) * unit
        writer.put(x + 30 * unit, y, f"… and {len(labels) - shown} more", 14.0, colour=GREY)
