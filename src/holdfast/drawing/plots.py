"""Plots beside a legend as PNG: curves around a circle, and a motion over time with the used share of capacity."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.base.files import write_atomically
from holdfast.base.text import one_line
from holdfast.drawing.canvas import FONT, LETTERS, LONGEST, Writer, halo, write
from holdfast.drawing.colours import COVERED, FIXED, FRAME, GREY, INK, UNDECIDED, colours_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.projections.polar import PolarAxes

_SIZE: Final = (1340, 900)  # width and height of the page of a polar plot [px]
_COLOURS: Final = ("#b5173f", "#0b6aa8", "#14171c", "#d9820f", "#3d8f5f", "#7a4fa3")  # colours of the curves in turn
# markers of the curves in turn: dots, none, none, then the octagons and squares of the paper
_MARKERS: Final = ("o", "", "", "8", "s", "D")
_LINES: Final = ("-", "-", "--", ":", ":", ":")  # line styles of the curves in turn
_POLAR: Final = (90, 130, 660, 660)  # left and top edge, width and height of the plot [px]
_COLUMN: Final = 810  # left edge of the column beside the plot [px]
_VIEW: Final = (440, 230)  # width and height of the view from above [px]
_GROUPS: Final = 9  # largest number of groups of moving bodies in a legend

_WIDE: Final = (1340, 790)  # width and height of the page of a motion [px]
_LEFT: Final = 110  # left edge of the plots [px]
_RIGHT: Final = 850  # right edge of the plots [px]
_MOTION: Final = (130, 370)  # top and bottom edge of the upper plot [px]
_SHARE: Final = (435, 720)  # top and bottom edge of the lower plot [px]
_BESIDE: Final = 890  # left edge of the column beside the plots [px]
_AXES: Final = ("#b5173f", "#3d8f5f", "#0b6aa8")  # colours of x, y and z
_MOST: Final = 3.0  # largest share on the axis; larger ones are clamped


@dataclass(frozen=True)
class Curve:
    """The answers of one method: ``radius`` (n,) [m/s²] at ``angle`` (n,) [rad]; the radius is inf where nothing moves.

    ``lower`` (n,) [m/s²] is drawn as a band where it is above 0. ``lines`` are the texts of the legend. Where
    ``decided`` (n,) is false, the radius is not known: the curve has a gap there. ``movers`` (n,) says in words what
    gives way first; the marks of a curve that stands alone are coloured by it.
    """

    name: str
    angle: Float
    radius: Float
    lower: Float
    lines: tuple[str, ...]
    decided: Bool
    movers: tuple[str, ...] = ()


@dataclass(frozen=True)
class Footprint:
    """A body seen from above: its outline (k, 2) [m] in the axes of the plot; lower bodies are drawn first."""

    name: str
    outline: Float
    fixed: bool
    height: float


@dataclass(frozen=True)
class PolarPicture:
    """Several curves around one circle; ``axes`` names the directions at 0, 90, 180 and 270 degrees.

    Sectors in which the first curve is not decided are hatched, and ``undecided`` says in words how many there are.
    """

    title: str
    subtitle: str
    axes: tuple[str, str, str, str]
    curves: tuple[Curve, ...]
    footprints: tuple[Footprint, ...] = ()
    undecided: str = ""


def write_polar(picture: PolarPicture, path: str | os.PathLike[str]) -> None:
    """Write the picture as a PNG file; if this fails, an existing file is left unchanged."""
    writer = Writer(*_SIZE)
    writer.head(picture.title, picture.subtitle)
    draw_curves(writer.box(*_POLAR, projection="polar"), picture)
    below = _draw_footprints(writer, picture) if picture.footprints else 150.0
    _draw_curve_legend(writer, picture, below)
    write_atomically(path, writer.png())


def draw_curves(axes: PolarAxes, picture: PolarPicture) -> None:
    """Draw all curves into polar axes, with the first one on top."""
    axes.set_facecolor("none")
    finite = np.concatenate([curve.radius[np.isfinite(curve.radius)] for curve in picture.curves])
    end = 1.12 * float(finite.max(initial=0.0)) or 1.0
    axes.set_ylim(0, end)
    axes.grid(color=FRAME, lw=0.8)
    axes.spines["polar"].set_color("#c5cad2")
    axes.set_xticks(np.arange(12) * np.pi / 6)
    names = [f"{30 * k}°" for k in range(12)]
    names[::3] = picture.axes
    axes.set_xticklabels(names, fontfamily=FONT, fontsize=11.5, color=GREY)
    for label in axes.get_xticklabels()[::3]:
        label.set(color=INK, fontsize=13.5, fontweight="bold")
    axes.tick_params(pad=7)
    # the radial numbers stand between the axes, where the first curve is shortest
    candidates = np.array([15.0, 45.0, 75.0, 105.0, 135.0, 165.0, 195.0, 225.0, 255.0, 285.0, 315.0, 345.0])
    first = picture.curves[0]
    apart = np.abs((np.degrees(first.angle)[None] - candidates[:, None] + 180) % 360 - 180)
    reach = np.where(np.isfinite(first.radius), first.radius, 0.0)[apart.argmin(1)]
    axes.set_rlabel_position(float(candidates[reach.argmin()]))
    for label in axes.get_yticklabels():
        label.set(color=GREY, fontfamily=FONT, fontsize=10.5)
    _shade_undecided(axes, picture.curves[0], end)
    only = len(picture.curves) == 1
    for k, curve in reversed(list(enumerate(picture.curves))):
        colour = _COLOURS[k % len(_COLOURS)]
        radius = np.where(curve.decided, np.minimum(curve.radius, end), np.nan)
        shown = np.append(radius, radius[:1])
        angle = np.append(curve.angle, curve.angle[0] + 2 * np.pi)
        if only:
            axes.fill(angle, np.nan_to_num(shown), color=colour, alpha=0.08, lw=0)
        marker, line = _MARKERS[k % len(_MARKERS)], _LINES[k % len(_LINES)]
        if not marker:
            axes.plot(angle, shown, line, color=colour, lw=1.6, alpha=0.9, label=curve.name)
            continue
        face = colour if marker == "o" else "none"
        axes.plot(angle, shown, line, color=colour, lw=1.0, alpha=0.45)
        dots: dict[str, Any] = {"ms": 5.5, "mfc": face, "mec": colour, "mew": 1.0, "ls": "none", "clip_on": False}
        axes.plot(angle[:-1], shown[:-1], marker, **dots, label=curve.name)
        for words, group in colours_of(curve.movers).items() if only else ():
            chosen = np.array([mover == words for mover in curve.movers])
            axes.plot(angle[:-1][chosen], shown[:-1][chosen], marker, **dots | {"mfc": group, "mec": group})


def _shade_undecided(axes: PolarAxes, curve: Curve, end: float) -> None:
    """Hatch the sectors around the directions in which a curve is not decided, from the centre to ``end``."""
    if curve.decided.all():
        return
    single = np.full(1, 2 * np.pi)
    before = (curve.angle - np.roll(curve.angle, 1)) % (2 * np.pi) if len(curve.angle) > 1 else single
    after = np.roll(before, -1)
    unknown = ~curve.decided
    axes.bar(
        (curve.angle + (after - before) / 4)[unknown], np.full(unknown.sum(), end), ((before + after) / 2)[unknown],
        color=(*UNDECIDED, 0.35), edgecolor=(*UNDECIDED, 0.8), hatch="///", lw=0, zorder=0.5,
    )  # fmt: skip


def _draw_footprints(writer: Writer, picture: PolarPicture) -> float:
    """Draw the bodies from above, in the orientation of the plot, and return the row [px] below them."""
    from matplotlib.patches import Polygon

    width, height = _VIEW
    top = 150.0
    writer.put(_COLUMN, top, "seen from above", 16.0, bold=True)
    axes = writer.box(_COLUMN, top + 16, width, height)
    axes.set_axis_off()
    axes.set_aspect("equal")
    moving = [f.outline for f in picture.footprints if not f.fixed] or [f.outline for f in picture.footprints]
    points = np.vstack(moving)
    low, high = points.min(0), points.max(0)
    spare = 0.16 * float((high - low).max())
    axes.set_xlim(low[0] - spare, high[0] + spare)
    axes.set_ylim(low[1] - spare, high[1] + spare)
    for foot in sorted(picture.footprints, key=lambda f: (not f.fixed, f.height)):
        colour = FIXED if foot.fixed else COVERED
        axes.add_patch(
            Polygon(foot.outline, facecolor=colour, edgecolor=INK, lw=0.9, alpha=0.35 if foot.fixed else 0.8)
        )
    scale = min(width / np.ptp(axes.get_xlim()), height / np.ptp(axes.get_ylim()))  # [px / m], as the aspect is equal
    # names of movable bodies on their outlines, the highest first, where no other name is
    taken: list[Float] = []
    for foot in sorted(picture.footprints, key=lambda f: -f.height):
        text = one_line(foot.name, LONGEST)
        half = np.array([writer.width(text, LETTERS), 1.3 * LETTERS]) / (2 * scale)
        middle = (foot.outline.min(0) + foot.outline.max(0)) / 2
        box = np.array([middle - half, middle + half])
        if foot.fixed or any(((box[0] < other[1]) & (other[0] < box[1])).all() for other in taken):
            continue
        taken.append(box)
        write(axes, middle[0], middle[1], text, 0.72 * LETTERS, va="center", path_effects=halo(1.0), zorder=3)
    return top + height + 60


def _draw_curve_legend(writer: Writer, picture: PolarPicture, top: float) -> None:
    y = top
    room = _SIZE[0] - _COLUMN - 50.0
    for k, curve in enumerate(picture.curves):
        colour = _COLOURS[k % len(_COLOURS)]
        marker, line = _MARKERS[k % len(_MARKERS)], _LINES[k % len(_LINES)]
        x = np.array([_COLUMN, _COLUMN + 26.0])
        writer.axes.plot(x, [y - 5, y - 5], line, color=colour, lw=1.8 if not marker else 1.0, alpha=0.9, zorder=9)
        if marker:
            face = colour if marker == "o" else "none"
            writer.axes.plot(x.mean(), y - 5, marker, ms=6.5, mfc=face, mec=colour, mew=1.1, zorder=9)
        writer.put_clipped(_COLUMN + 40, y, curve.name, 16.0, room - 40, bold=True)
        for text in curve.lines:
            y += 23
            writer.put_clipped(_COLUMN + 40, y, text, 14.0, room - 40, colour=GREY)
        y += 38
    groups = colours_of(picture.curves[0].movers) if len(picture.curves) == 1 else {}
    if groups:
        y = _draw_groups(writer, _COLUMN, y, "what gives way first", groups) + 38
    if picture.undecided:
        look: dict[str, Any] = {"facecolor": (*UNDECIDED, 0.35), "edgecolor": UNDECIDED, "hatch": "///", "lw": 0.8}
        writer.swatch(_COLUMN, y - 13, 26, 16, **look)
        for line in writer.wrapped(picture.undecided, 14.0, room - 40, 4):
            writer.put(_COLUMN + 40, y, line, 14.0)
            y += 21


def _draw_groups(writer: Writer, left: int, y: float, title: str, groups: dict[str, str]) -> float:
    """Draw the legend of groups of moving bodies below row ``y`` [px], and return its last row."""
    writer.put(left, y, title, 16.0, bold=True)
    for number, (words, colour) in enumerate(groups.items()):
        y += 26
        if number == _GROUPS and len(groups) > _GROUPS + 1:
            writer.put(left + 26, y, f"and {len(groups) - _GROUPS} more", 14.0, colour=GREY)
            break
        writer.axes.plot(left + 8, y - 5, "o", color=colour, ms=7, zorder=9)
        writer.put_clipped(left + 26, y, words, 14.0, _SIZE[0] - left - 76)
    return y


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
    time: Float
    acceleration: Float
    turning: Float
    used: Float
    proved: Float
    movers: tuple[str, ...]
    moved: float
    lines: tuple[str, ...]


def write_timeline(picture: Timeline, path: str | os.PathLike[str]) -> None:
    """Write the picture as a PNG file; if this fails, an existing file is left unchanged."""
    writer = Writer(*_WIDE)
    writer.head(picture.title, picture.subtitle)
    groups = colours_of(picture.movers)
    writer.put(60, _MOTION[0] - 14, "acceleration of the carrier [m/s²]", 15.0, bold=True)
    axes = _time_axes(writer, _MOTION)
    marker = "o" if len(picture.time) == 1 else ""
    for lines, style, name in ((picture.acceleration, "-", "a{}"), (picture.turning, ":", "α{} [rad/s²]")):
        for k, axis in enumerate("xyz"):
            if lines[:, k].any():
                label = name.format(axis)
                axes.plot(picture.time, lines[:, k], style, marker=marker, color=_AXES[k], lw=1.8, label=label)
    if axes.lines:
        font = {"family": FONT, "size": 11.0}
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False, borderaxespad=0.2, ncol=6, prop=font)
    _ready(axes, picture)
    writer.put(60, _SHARE[0] - 14, "share used of what the load withstands", 15.0, bold=True)
    _draw_share(_time_axes(writer, _SHARE), picture, groups)
    _draw_time_legend(writer, picture, groups)
    write_atomically(path, writer.png())


def _time_axes(writer: Writer, rows: tuple[int, int]) -> Axes:
    """Return axes over time between two rows [px] of the page."""
    top, bottom = rows
    axes: Axes = writer.box(_LEFT, top, _RIGHT - _LEFT, bottom - top)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.grid(color=FRAME, lw=0.8)
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


def _draw_share(axes: Axes, picture: Timeline, groups: dict[str, str]) -> None:
    known = picture.used <= _MOST  # not where it is nan
    top = _MOST if (picture.used > _MOST).any() else max(1.15, 1.15 * float(picture.used[known].max(initial=0.0)))
    axes.set_ylim(0, top)
    axes.axhspan(1, top, color="#b5173f", alpha=0.07, lw=0)
    axes.axhline(1, color="#b5173f", lw=1.4)
    used = np.where(np.isnan(picture.used), np.nan, np.minimum(picture.used, 1.02 * top))
    certain = np.minimum(np.nan_to_num(picture.proved, posinf=top), used)
    axes.fill_between(picture.time, certain, used, color=INK, alpha=0.12, lw=0)
    axes.plot(picture.time, used, color="#9aa3b0", lw=1.2)
    for words, colour in groups.items():
        mine = np.array([mover == words for mover in picture.movers])
        for marker, chosen in (("o", mine & ~(picture.used > top)), ("^", mine & (picture.used > top))):
            axes.plot(picture.time[chosen], np.minimum(used[chosen], top), marker, color=colour, ms=5.0, clip_on=False)
    for at in picture.time[np.isnan(picture.used)]:
        axes.axvline(at, color=(*UNDECIDED, 0.7), lw=2.5)
    axes.set_xlabel("time [s]", fontfamily=FONT, fontsize=12.0, color=GREY)
    axes.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    _ready(axes, picture)


def _draw_time_legend(writer: Writer, picture: Timeline, groups: dict[str, str]) -> None:
    y, room = float(_MOTION[0]), _WIDE[0] - _BESIDE - 50.0
    for line in picture.lines:
        for text in writer.wrapped(line, 15.0, room, 4):
            writer.put(_BESIDE, y, text, 15.0)
            y += 22
        y += 8
    y = max(y + 30, float(_SHARE[0]))
    if groups:
        y = _draw_groups(writer, _BESIDE, y, "what would give way first", groups)
    if (picture.used > _MOST).any():
        y += 28
        writer.axes.plot(_BESIDE + 8, y - 5, "^", color=GREY, ms=7, zorder=9)
        writer.put(_BESIDE + 26, y, "more than is drawn", 14.0)
    if np.isnan(picture.used).any():
        writer.axes.plot([_BESIDE + 8] * 2, [y + 12, y + 34], color=(*UNDECIDED, 0.7), lw=2.5, zorder=9)
        writer.put(_BESIDE + 26, y + 28, "not known", 14.0)
