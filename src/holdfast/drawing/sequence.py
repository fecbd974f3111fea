"""Draw a sequence of states as one PNG, with one panel for each state.

The body that leaves next, or that arrived last, is coloured and has an arrow.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.files import write_atomically
from holdfast.drawing import colours
from holdfast.drawing.camera import Camera, fit, front_view
from holdfast.drawing.canvas import blank, paint, pixel_axes, png_of
from holdfast.drawing.footer import GREY, Writer
from holdfast.drawing.marks import PUSH, arrow_shapes
from holdfast.drawing.picture import Picture, Solid
from holdfast.drawing.shade import render
from holdfast.drawing.soup import soup_of

NEXT: Final = rgb_of("#ea7a3c")  # colour of the body that leaves next
STAYS: Final = rgb_of("#b9c4d2")  # colour of the bodies that stay
ARROW: Final = "#b5173f"  # colour of the arrows
_ROW, _LEAST = 6, 3  # the most panels in a row, and the number of panels for which a row always has room
_PANEL: Final = (300, 300)  # width and height of a panel of aspect 1 [px]
_CAPTION: Final = 64  # height of a panel's caption [px]
_PAD, _GUTTER, _HEADER, _FOOT = 30, 12, 92, 44  # margin, distance between panels, height of header and of footer [px]
_SMALLEST_ASPECT, _LARGEST_ASPECT = 0.75, 1.8  # limits of a panel's width divided by its height


@dataclass(frozen=True)
class Frame:
    """One state of a sequence: the bodies that are present, with a caption and a note below it.

    ``next`` is the name of the body that leaves next or arrived last, or "" if there is none.
    """

    solids: tuple[Solid, ...]
    next: str
    caption: str
    note: str = ""


@dataclass(frozen=True)
class Sequence:
    """The states of an assembly in order.

    ``along`` (3,) is the unit direction in which bodies leave, or from where they arrive if ``arriving``, and ``up``
    (3,) is opposite to gravity. ``marked`` says what the body in colour and its arrow are.
    """

    title: str
    subtitle: str
    frames: tuple[Frame, ...]
    along: NDArray[np.float64]
    up: NDArray[np.float64]
    arriving: bool = False
    marked: str = ""


def write_sequence(sequence: Sequence, path: str | os.PathLike[str]) -> None:
    """Write the sequence as a PNG file; if this fails, an existing file is left unchanged."""
    write_atomically(path, _png(sequence))


def _png(sequence: Sequence) -> bytes:
    rows = -(-len(sequence.frames) // _ROW)
    columns = max(-(-len(sequence.frames) // rows), _LEAST)
    camera, (wide, high), length = _camera(sequence)
    size = (2 * _PAD + columns * (wide + _GUTTER) - _GUTTER, _HEADER + rows * (high + _CAPTION) + _FOOT)
    focus = np.concatenate([s.vertices for s in _fullest(sequence) if not s.fixed] or [np.zeros((1, 3))])
    page = np.ones((size[1], size[0], 3))
    figure, canvas = blank(*size)
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Rectangle

    axes = pixel_axes(figure, *size)
    writer = Writer(axes, canvas, 1.0)
    writer.put(_PAD, 40, writer.clipped(sequence.title, 24.0, size[0] - 2 * _PAD, bold=True), 24.0, bold=True)
    writer.put(_PAD, 66, writer.clipped(sequence.subtitle, 15.0, size[0] - 2 * _PAD), 15.0, colour=GREY)
    for k, frame in enumerate(sequence.frames):
        left, top = _PAD + k % columns * (wide + _GUTTER), _HEADER + k // columns * (high + _CAPTION)
        colour = partial(_colour, coloured=frame.next)
        movable = soup_of([s for s in frame.solids if not s.fixed], colour)
        fixed = soup_of([s for s in frame.solids if s.fixed], colour)
        page[top : top + high, left : left + wide] = render(movable, fixed, camera, (high, wide), focus=focus).image
        axes.add_patch(Rectangle((left, top), wide, high, fill=False, edgecolor="#dfe2e7", lw=0.8, zorder=1))
        if frame.next:
            leaving = next(s for s in frame.solids if s.name == frame.next)
            tail = leaving.vertices.mean(0)
            tail = tail + (leaving.vertices - tail).dot(sequence.along).max() * sequence.along
            ends = camera.pixels(np.array([tail, tail + length * sequence.along]))[:, :2] + [left, top]
            first, last = (ends[1:], ends[:1]) if sequence.arriving else (ends[:1], ends[1:])
            axes.add_collection(
                PolyCollection(arrow_shapes(first, last, PUSH), facecolors=ARROW, edgecolors="white", zorder=6)
            )
        writer.put(
            left + 12, top + high + 22, writer.clipped(frame.caption, 16.0, wide - 16, bold=True), 16.0, bold=True
        )
        writer.put(left + 12, top + high + 42, writer.clipped(frame.note, 12.5, wide - 16), 12.5, colour=GREY)
    if sequence.marked and any(frame.next for frame in sequence.frames):
        base = size[1] - 18
        axes.add_patch(Rectangle((_PAD + 12, base - 12), 14, 14, facecolor=NEXT, edgecolor="none"))
        ends = np.array([[[_PAD + 40.0, base - 22.0]], [[_PAD + 40.0, base + 11.0]]])
        first, last = ends if sequence.arriving else ends[::-1]
        key = PolyCollection(arrow_shapes(first, last, PUSH), facecolors=ARROW, edgecolors="white", zorder=6)
        axes.add_collection(key)
        writer.put(_PAD + 58, base, writer.clipped(sequence.marked, 14.0, size[0] - 2 * _PAD - 58), 14.0)
    paint(figure, page)
    return png_of(canvas)


def _camera(sequence: Sequence) -> tuple[Camera, tuple[int, int], float]:
    """Return the camera of all panels, their size [px] and the length of the arrows [m].

    There is room for all bodies and their arrows.
    """
    solids = _fullest(sequence)
    picture = Picture("", "", (), tuple(s for s in solids if not s.fixed), up=sequence.up)
    view = front_view(picture)
    shown = [s for frame in sequence.frames for s in frame.solids if not s.fixed] or list(solids)
    points = np.concatenate([s.vertices for s in shown])
    length = 0.22 * float(np.linalg.norm(np.ptp(points, axis=0))) if any(f.next for f in sequence.frames) else 0.0
    around = np.concatenate([points, points + length * sequence.along])
    extent = np.ptp(view.flat(around), axis=0)
    aspect = float(np.clip(extent[0] / max(extent[1], 1e-9), _SMALLEST_ASPECT, _LARGEST_ASPECT))
    wide = round(_PANEL[0] * np.sqrt(aspect))
    high = round(_PANEL[1] / np.sqrt(aspect))
    return fit(view, around, wide, high, 16.0), (wide, high), length


def _fullest(sequence: Sequence) -> tuple[Solid, ...]:
    """Return the bodies of the frame that shows most of them."""
    return max(sequence.frames, key=lambda frame: len(frame.solids)).solids


def _colour(solid: Solid, coloured: str) -> Rgb:
    return colours.FIXED if solid.fixed else NEXT if solid.name == coloured else STAYS
