"""Sheets of panels as PNG: points of scenes coloured by their force, and states of an assembly in order."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.files import write_atomically
from holdfast.drawing import colours
from holdfast.drawing.camera import Camera, fit, front_view
from holdfast.drawing.canvas import PageBox, Writer, draw_axes
from holdfast.drawing.colours import GREY, INK
from holdfast.drawing.map_png import CAPTION
from holdfast.drawing.marks import PUSH, draw_arrows
from holdfast.drawing.picture import (
    Arrow,
    Picture,
    Solid,
    fixed,
    forces,
    legend,
    movable,
    movable_names,
    soup_of,
)
from holdfast.drawing.render import render

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HEAD, _FOOT, _PAD = 92, 96, 26  # heights above and below the panels, and the space around them [px]
_PALE: Final = (0.90, 0.905, 0.915)  # colour of bodies without a map
_ACCENT: Final = rgb_of("#5b8fd6")  # colour of the body named ``accent``
_GHOST: Final = rgb_of("#d9822b")  # colour of the bodies of a ghost picture
_FAINT: Final = 0.35  # opacity of a ghost picture, and of what others hide
_KEY: Final = 150  # left edge of the key to the arrows, beside the axes [px]
_SHIFT: Final = 0.004  # distance of points in front of their surface, as a share of the scene's size

_NEXT: Final = rgb_of("#ea7a3c")  # colour of the body that leaves next
_STAYS: Final = rgb_of("#b9c4d2")  # colour of the bodies that stay
_ARROW: Final = "#b5173f"  # colour of the arrows of a sequence
_ROW, _LEAST = 4, 3  # the most panels in a row, and the number of panels for which a row always has room
_PANEL: Final = (300, 300)  # width and height of a panel of aspect 1 [px]
_NOTED: Final = 64  # height of a panel's caption and note [px]
_SIDE, _GUTTER, _KEYED = 30, 12, 44  # margin of a sequence, distance between its panels, height of its footer [px]
_SMALLEST_ASPECT, _LARGEST_ASPECT = 0.75, 1.8  # limits of a panel's width divided by its height


@dataclass(frozen=True)
class PointsPanel:
    """One picture of a sheet: a scene, and points on it that are coloured by their force.

    ``points`` (n, 3) [m] have outward ``normals`` (n, 3) and ``force`` (n,) [N]; ``marks`` are drawn as arrows, which
    ``marked`` explains. Bodies without a map are pale, and the body named ``accent`` is blue. The movable bodies of the
    picture ``ghost`` are drawn faintly over it.
    """

    caption: str
    picture: Picture
    points: Float = field(default_factory=lambda: np.empty((0, 3)))
    normals: Float = field(default_factory=lambda: np.empty((0, 3)))
    force: Float = field(default_factory=lambda: np.empty(0))
    marks: tuple[Arrow, ...] = ()
    marked: str = ""
    accent: str = ""
    ghost: Picture | None = None


def sheet_png(
    rows: Sequence[Sequence[PointsPanel]], title: str, subtitle: str, *, panel: tuple[int, int] = (600, 450)
) -> bytes:
    """Return a PNG of panels of (width, height) pixels in rows; all panels of one row have the same view."""
    width = 2 * _PAD + max(len(row) for row in rows) * panel[0]
    every = [one for row in rows for one in row]
    keyed = any(one.picture.heat or len(one.points) for one in every)
    height = _HEAD + len(rows) * (panel[1] + CAPTION) + (_FOOT if keyed else _PAD)
    scale = colours.scale_of(np.concatenate([np.concatenate([one.force, forces(one.picture)]) for one in every]))
    writer = Writer(width, height)
    for i, row in enumerate(rows):
        shown = [arrow.tail[None] for one in row for arrow in one.marks] + [one.points for one in row]
        bodies = [drawn for one in row for drawn in (one.picture, one.ghost) if drawn is not None]
        around = [movable(drawn, None).vertices for drawn in bodies]
        camera = fit(front_view(replace(row[0].picture, weakest=())), np.concatenate([*around, *shown]), *panel, 30.0)
        for j, one in enumerate(row):
            box = PageBox(_PAD + j * panel[0], _HEAD + i * (panel[1] + CAPTION) + CAPTION, *panel)
            _draw_points_panel(writer, one, scale, camera, box)
    writer.head(title, subtitle, _PAD, (44, 74), (26, 16))
    if keyed:
        _draw_key(writer, scale, height - _FOOT + 24, every)
    return writer.png()


def _draw_points_panel(
    writer: Writer, one: PointsPanel, scale: colours.Scale | None, camera: Camera, box: PageBox
) -> None:
    soup = movable(one.picture, scale)
    rgb, shape = soup.rgb.copy(), (box.height, box.width)
    if not one.picture.heat:
        names = movable_names(one.picture)
        rgb[:] = _PALE
        if one.accent in names:
            rgb[soup.body == names.index(one.accent)] = _ACCENT
    drawn = render(replace(soup, rgb=rgb), fixed(one.picture), camera, shape)
    box.of(writer.image)[:] = drawn.image
    if one.ghost is not None:
        faint = movable(one.ghost, None)
        faint = replace(faint, rgb=np.broadcast_to(_GHOST, faint.rgb.shape).copy())
        box.of(writer.image)[:] += _FAINT * (render(faint, fixed(one.ghost), camera, shape).image - drawn.image)
    x, y = box.left, box.top
    writer.put_clipped(x + 6, y - 10, one.caption, 17, box.width - 12)
    draw_axes(writer.axes, box, camera.view, 1.0)
    if len(one.points):
        shift = _SHIFT * float(np.linalg.norm(np.ptp(np.concatenate([soup.vertices, one.points]), axis=0)))
        pixels = camera.pixels(one.points + shift * one.normals)
        # in the panel, facing the viewer, and not hidden by movable bodies
        rows, columns = drawn.depth.shape
        inside = ((pixels[:, :2] >= 0) & (pixels[:, :2] < [columns, rows])).all(1)
        column = np.clip(pixels[:, 0].astype(int), 0, columns - 1)
        row = np.clip(pixels[:, 1].astype(int), 0, rows - 1)
        facing = one.normals @ camera.view.toward > 0
        seen = inside & facing & (pixels[:, 2] <= drawn.depth[row, column] + 2.0 / camera.scale)
        writer.axes.scatter(
            x + pixels[seen, 0], y + pixels[seen, 1], s=26, c=colours.colours(scale, one.force)[seen],
            edgecolors=INK, linewidths=0.5, zorder=4,
        )  # fmt: skip
    style = {"arrowstyle": "-|>", "color": INK, "lw": 2.2, "mutation_scale": 17}
    ends = [camera.pixels(np.array([arrow.tail, arrow.head]))[:, :2] + [x, y] for arrow in one.marks]
    if one.marks and one.marked:
        low = y + box.height - 24
        ends.append(np.array([[x + _KEY, low + 10], [x + _KEY, low - 22]]))
        writer.put_clipped(x + _KEY + 16, low, one.marked, 14, box.width - _KEY - 30)
    for tail, head in ends:
        writer.axes.annotate("", xy=tuple(head), xytext=tuple(tail), arrowprops=style, zorder=6)


def _draw_key(writer: Writer, scale: colours.Scale | None, top: int, panels: Sequence[PointsPanel]) -> None:
    """Draw the colour scale, the colour of infinite forces, and the colours of other kinds of answers in the panels."""
    left, wide, tall = _PAD, 430, 16
    if scale is not None:
        writer.image[top : top + tall, left : left + wide] = colours.sample(np.linspace(0, 1, wide))[None]
        for tick in colours.ticks(scale):
            writer.put(left + tick.position * wide, top + tall + 20, tick.label, 13, colour=GREY, align="center")
        writer.put(left, top + tall + 42, "largest inward push [N]", 14)
    patch = left if scale is None else left + wide + 50
    whole = Picture("", "", tuple(surface for one in panels for surface in one.picture.heat), ())
    names = {colours.Kind.ENDLESS: ""} | legend(whole) | {colours.Kind.ENDLESS: "no push moves anything"}
    for number, (kind, name) in enumerate(names.items()):
        x, y = patch + 330 * (number // 3), top + 22 * (number % 3)
        writer.image[y : y + tall, x : x + 28] = colours.SPECIAL[kind]
        writer.put(x + 38, y + 14, name, 14)


@dataclass(frozen=True)
class StateFrame:
    """One state of a sequence: the bodies that are present, with a caption and a note below it.

    ``next`` is the name of the body that leaves next or arrived last, or "" if there is none: it is coloured and has an
    arrow.
    """

    solids: tuple[Solid, ...]
    next: str
    caption: str
    note: str = ""


@dataclass(frozen=True)
class StateSequence:
    """The states of an assembly in order.

    ``along`` (3,) is the unit direction in which bodies leave, or from where they arrive if ``arriving``, and ``up``
    (3,) is opposite to gravity. ``marked`` says what the body in colour and its arrow are.
    """

    title: str
    subtitle: str
    frames: tuple[StateFrame, ...]
    along: Float
    up: Float
    arriving: bool = False
    marked: str = ""

    @property
    def fullest(self) -> tuple[Solid, ...]:
        """The bodies of the frame that shows most of them."""
        return max(self.frames, key=lambda frame: len(frame.solids)).solids


def write_sequence(sequence: StateSequence, path: str | os.PathLike[str]) -> None:
    """Write the sequence as a PNG file; if this fails, an existing file is left unchanged."""
    rows = -(-len(sequence.frames) // _ROW)
    columns = max(-(-len(sequence.frames) // rows), _LEAST)
    camera, (wide, high), length = _sequence_camera(sequence)
    size = (2 * _SIDE + columns * (wide + _GUTTER) - _GUTTER, _HEAD + rows * (high + _NOTED) + _KEYED)
    writer = Writer(*size)
    writer.head(sequence.title, sequence.subtitle, _SIDE, (40, 66), (24, 15))
    for k, frame in enumerate(sequence.frames):
        left, top = _SIDE + k % columns * (wide + _GUTTER), _HEAD + k // columns * (high + _NOTED)
        _draw_frame(writer, sequence, frame, camera, PageBox(left, top, wide, high), length)
    if sequence.marked and any(frame.next for frame in sequence.frames):
        base = size[1] - 18
        writer.swatch(_SIDE + 12, base - 12, 14, 14, facecolor=_NEXT, edgecolor="none", zorder=1)
        near, far = np.array([[_SIDE + 40.0, base + 11.0]]), np.array([[_SIDE + 40.0, base - 22.0]])
        _draw_way(writer.axes, near, far, sequence.arriving)
        writer.put_clipped(_SIDE + 58, base, sequence.marked, 14.0, size[0] - 2 * _SIDE - 58)
    write_atomically(path, writer.png())


def _draw_frame(
    writer: Writer, sequence: StateSequence, frame: StateFrame, camera: Camera, box: PageBox, length: float
) -> None:
    """Draw one state, with an arrow of this ``length`` [m] at the body that leaves next or arrived last."""

    def colour(solid: Solid) -> Rgb:
        return colours.FIXED if solid.fixed else _NEXT if solid.name == frame.next else _STAYS

    free = soup_of([solid for solid in frame.solids if not solid.fixed], colour)
    still = soup_of([solid for solid in frame.solids if solid.fixed], colour)
    focus = np.concatenate([s.vertices for s in sequence.fullest if not s.fixed] or [np.zeros((1, 3))])
    box.of(writer.image)[:] = render(free, still, camera, (box.height, box.width), focus=focus).image
    writer.framed(box)
    if frame.next:
        leaving = next(solid for solid in frame.solids if solid.name == frame.next)
        behind = render(soup_of([leaving], colour), None, camera, (box.height, box.width), focus=focus)
        seen = behind.body >= 0  # where others hide it, it shines through
        box.of(writer.image)[seen] += _FAINT * (behind.image - box.of(writer.image))[seen]
        tail = leaving.vertices.mean(0)
        tail = tail + (leaving.vertices - tail).dot(sequence.along).max() * sequence.along
        ends = camera.pixels(np.array([tail, tail + length * sequence.along]))[:, :2] + [box.left, box.top]
        _draw_way(writer.axes, ends[:1], ends[1:], sequence.arriving)
    below = box.top + box.height
    writer.put_clipped(box.left + 12, below + 22, frame.caption, 16.0, box.width - 16, bold=True)
    writer.put_clipped(box.left + 12, below + 42, frame.note, 12.5, box.width - 16, colour=GREY)


def _draw_way(axes: Axes, near: Float, far: Float, arriving: bool) -> None:
    """Draw the arrow on which a body leaves from ``near`` to ``far`` (1, 2) [px], or arrives the other way."""
    draw_arrows(axes, *((far, near) if arriving else (near, far)), PUSH, _ARROW, zorder=6)


def _sequence_camera(sequence: StateSequence) -> tuple[Camera, tuple[int, int], float]:
    """Return the camera of all panels, their size [px] and the length of the arrows [m].

    There is room for all bodies and their arrows.
    """
    view = front_view(Picture("", "", (), tuple(s for s in sequence.fullest if not s.fixed), up=sequence.up))
    shown = [s for frame in sequence.frames for s in frame.solids if not s.fixed] or list(sequence.fullest)
    points = np.concatenate([s.vertices for s in shown])
    length = 0.22 * float(np.linalg.norm(np.ptp(points, axis=0))) if any(f.next for f in sequence.frames) else 0.0
    around = np.concatenate([points, points + length * sequence.along])
    extent = np.ptp(view.flat(around), axis=0)
    aspect = float(np.clip(extent[0] / max(extent[1], 1e-9), _SMALLEST_ASPECT, _LARGEST_ASPECT))
    wide = round(_PANEL[0] * np.sqrt(aspect))
    high = round(_PANEL[1] / np.sqrt(aspect))
    return fit(view, around, wide, high, 16.0), (wide, high), length
