"""Draw accelerations and the used share of a load's capacity over time, coloured by what would give way first."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.files import write_atomically
from holdfast.drawing.canvas import blank, pixel_axes, png_of
from holdfast.drawing.colours import UNDECIDED
from holdfast.drawing.footer import GREY, Writer
from holdfast.drawing.marks import FONT, INK
from holdfast.drawing.movers import colours_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE: Final = (1600, 900)  # width and height of the page [px]
_LEFT: Final = 110  # left edge of the plots [px]
_RIGHT: Final = 1090  # right edge of the plots [px]
_MOTION: Final = (130, 400)  # top and bottom edge of the upper plot [px]
_SHARE: Final = (470, 820)  # top and bottom edge of the lower plot [px]
_COLUMN: Final = 1130  # left edge of the column beside the plots [px]
_AXES: Final = ("#b5173f", "#3d8f5f", "#0b6aa8")  # colours of x, y and z
_MOST: Final = 3.0  # largest share on the axis; larger ones are clamped
_GROUPS: Final = 9  # largest number of groups of moving bodies in the legend


@dataclass(frozen=True)
class Timeline:
    """The content of the picture, at ``time`` (n,) [s].

    ``acceleration`` (n, 3) [m/s²] and ``turning`` (n, 3) [rad/s²] are those of the carrier. ``used`` (n,) is the used
    share of the load's capacity, nan where it is undecided, and ``proved`` (n,) a proved lower bound of it; both may be
    inf. ``movers`` (n,) says in words what would give way first, "" if nothing would. ``moved`` [s] is the time at
    which something begins to move, inf if nothing does. ``lines`` are the texts of the legend.
    """

    title: str
    subtitle: str
    time: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    turning: NDArray[np.float64]
    used: NDArray[np.float64]
    proved: NDArray[np.float64]
    movers: tuple[str, ...]
    moved: float
    lines: tuple[str, ...]


def write_timeline(picture: Timeline, path: str | os.PathLike[str]) -> None:
    """Write the picture as a PNG file; if this fails, an existing file is left unchanged."""
    write_atomically(path, _png(picture))


def _png(picture: Timeline) -> bytes:
    width, height = _SIZE
    figure, canvas = blank(width, height)
    writer = Writer(pixel_axes(figure, width, height), canvas, 1.0)
    writer.head(picture.title, picture.subtitle, width)
    writer.put(60, _MOTION[0] - 14, "acceleration of the carrier [m/s²]", 15.0, bold=True)
    _draw_motion(_box(figure, _MOTION), picture)
    writer.put(60, _SHARE[0] - 14, "share used of what the load withstands", 15.0, bold=True)
    colours = colours_of(picture.movers)
    _draw_share(_box(figure, _SHARE), picture, colours)
    _draw_legend(writer, picture, colours)
    return png_of(canvas)


def _box(figure: Figure, rows: tuple[int, int]) -> Axes:
    width, height = _SIZE
    top, bottom = rows
    axes = figure.add_axes((_LEFT / width, 1 - bottom / height, (_RIGHT - _LEFT) / width, (bottom - top) / height))
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.grid(color="#dfe2e7", lw=0.8)
    axes.set_axisbelow(True)
    return axes


def _ready(axes: Axes, picture: Timeline) -> None:
    """Set the range and the fonts of the axes, and mark the time at which something begins to move."""
    begin, end = float(picture.time[0]), float(picture.time[-1])
    spare = 0.02 * (end - begin) or 0.5
    axes.set_xlim(begin - spare, end + spare)
    if np.isfinite(picture.moved):
        axes.axvline(picture.moved, color=INK, lw=1.4, ls=(0, (4, 3)))
    for label in (*axes.get_xticklabels(), *axes.get_yticklabels()):
        label.set(color=GREY, fontfamily=FONT, fontsize=11.0)


def _draw_motion(axes: Axes, picture: Timeline) -> None:
    marker = "o" if len(picture.time) == 1 else ""
    for lines, style, name in ((picture.acceleration, "-", "a{}"), (picture.turning, ":", "α{} [rad/s²]")):
        for k, axis in enumerate("xyz"):
            if lines[:, k].any():
                label = name.format(axis)
                axes.plot(picture.time, lines[:, k], style, marker=marker, color=_AXES[k], lw=1.8, label=label)
    if axes.lines:
        axes.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False, borderaxespad=0.2, ncol=6, prop=_font(11.0)
        )
    _ready(axes, picture)


def _draw_share(axes: Axes, picture: Timeline, colours: dict[str, str]) -> None:
    known = picture.used <= _MOST  # not where it is nan
    top = _MOST if (picture.used > _MOST).any() else max(1.15, 1.15 * float(picture.used[known].max(initial=0.0)))
    axes.set_ylim(0, top)
    axes.axhspan(1, top, color="#b5173f", alpha=0.07, lw=0)
    axes.axhline(1, color="#b5173f", lw=1.4)
    used = np.where(np.isnan(picture.used), np.nan, np.minimum(picture.used, 1.02 * top))
    certain = np.minimum(np.nan_to_num(picture.proved, posinf=top), used)
    axes.fill_between(picture.time, certain, used, color=INK, alpha=0.12, lw=0)
    axes.plot(picture.time, used, color="#9aa3b0", lw=1.2)
    for words, colour in colours.items():
        mine = np.array([mover == words for mover in picture.movers])
        for marker, chosen in (("o", mine & ~(picture.used > top)), ("^", mine & (picture.used > top))):
            axes.plot(picture.time[chosen], np.minimum(used[chosen], top), marker, color=colour, ms=5.0, clip_on=False)
    for at in picture.time[np.isnan(picture.used)]:
        axes.axvline(at, color=(*UNDECIDED, 0.7), lw=2.5)
    axes.set_xlabel("time [s]", fontfamily=FONT, fontsize=12.0, color=GREY)
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    _ready(axes, picture)


def _draw_legend(writer: Writer, picture: Timeline, colours: dict[str, str]) -> None:
    y, room = float(_MOTION[0]), _SIZE[0] - _COLUMN - 50.0
    for line in picture.lines:
        for text in writer.wrapped(line, 15.0, room, 4):
            writer.put(_COLUMN, y, text, 15.0)
            y += 22
        y += 8
    y = max(y + 30, float(_SHARE[0]))
    if colours:
        writer.put(_COLUMN, y, "what would give way first", 16.0, bold=True)
    for number, (words, colour) in enumerate(colours.items()):
        y += 28
        if number == _GROUPS and len(colours) > _GROUPS + 1:
            writer.put(_COLUMN + 26, y, f"and {len(colours) - _GROUPS} more", 14.0, colour=GREY)
            break
        writer.axes.plot(_COLUMN + 8, y - 5, "o", color=colour, ms=7, zorder=9)
        writer.put(_COLUMN + 26, y, writer.clipped(words, 14.0, room - 26), 14.0)
    if (picture.used > _MOST).any():
        y += 28
        writer.axes.plot(_COLUMN + 8, y - 5, "^", color=GREY, ms=7, zorder=9)
        writer.put(_COLUMN + 26, y, "more than is drawn", 14.0)
    if np.isnan(picture.used).any():
        writer.axes.plot([_COLUMN + 8] * 2, [y + 12, y + 34], color=(*UNDECIDED, 0.7), lw=2.5, zorder=9)
        writer.put(_COLUMN + 26, y + 28, "not known", 14.0)


def _font(size: float) -> Any:  # noqa: ANN401 - matplotlib's own type
    from matplotlib.font_manager import FontProperties

    return FontProperties(family=FONT, size=size)
