"""Marks on a panel of the page of a map: arrows with numbers, contacts, and a scale bar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import Float
from holdfast.base.colour import rgb_of
from holdfast.drawing.camera import Camera
from holdfast.drawing.canvas import PageBox, badge, room_of_axes, write
from holdfast.drawing.colours import CONTACT, INK
from holdfast.drawing.picture import Arrow, Picture, ends_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_HIDDEN_ALPHA: Final = 0.38  # opacity of an arrow whose point is hidden in this panel
_RELAX_ROUNDS: Final = 200  # largest number of rounds in which badges are moved apart


@dataclass(frozen=True)
class Shot:
    """One panel: its caption, its place and its camera.

    ``fixed`` says whether it shows the fixed bodies, and ``contacts`` whether it shows contacts instead of robustness.
    """

    caption: str
    box: PageBox
    camera: Camera
    fixed: bool
    contacts: bool


@dataclass(frozen=True)
class Pen:
    """The sizes of an arrow [px]: shaft width, head length, head width, and smallest length."""

    shaft: float
    head: float
    wide: float
    least: float


PUSH: Final = Pen(5.0, 17.0, 16.0, 34.0)
FORCE: Final = Pen(2.2, 10.0, 8.5, 3.0)


def visible(shot: Shot, depth: Float, arrow: Arrow) -> bool:
    """Return whether the pushed point is visible in this panel with the depth image ``depth`` (H, W) [m]."""
    length = float(np.linalg.norm(arrow.tail - arrow.head))
    outside = arrow.head + 0.02 * (arrow.tail - arrow.head)
    column, row, z = shot.camera.pixels(outside[None])[0]
    rows, columns = depth.shape
    if not (0 <= column < columns and 0 <= row < rows):
        return True
    faces = float((arrow.tail - arrow.head) @ shot.camera.view.toward) > -1e-9 * length
    return faces and bool(z <= depth[int(row), int(column)] + 2.0 / shot.camera.scale)


def on_page(shot: Shot, points: Float) -> Float:
    """Return the page pixels (N, 2) of world points (N, 3) [m]."""
    return np.asarray(shot.camera.pixels(points)[:, :2] + np.array([shot.box.left, shot.box.top]), dtype=float)


def arrow_shapes(tails: Float, heads: Float, pen: Pen) -> list[Float]:
    """Return the filled outlines (7, 2) [px] of arrows from tails to heads (N, 2).

    Arrows that are seen end on are left out.
    """
    shapes = []
    for tail, head in zip(tails, heads, strict=True):
        length = float(np.linalg.norm(head - tail))
        if length < 0.5:
            continue
        along = (head - tail) / length
        reach = max(length, pen.least)
        cap = min(pen.head, 0.6 * reach)
        side = np.array([-along[1], along[0]])
        wide = pen.wide / 2.0 * cap / pen.head
        start, neck = head - reach * along, head - cap * along
        thin = pen.shaft / 2.0 * min(1.0, cap / pen.head + 0.3)
        corners = [start + thin * side, neck + thin * side, neck + wide * side, head]
        mirrored = [neck - wide * side, neck - thin * side, start - thin * side]
        shapes.append(np.array([*corners, *mirrored]))
    return shapes


def draw_arrows(axes: Axes, tails: Float, heads: Float, pen: Pen, colour: str, **style: Any) -> None:  # noqa: ANN401
    """Draw arrows from tails to heads (N, 2) [px] with a white rim."""
    from matplotlib.collections import PolyCollection

    shapes = arrow_shapes(tails, heads, pen)
    axes.add_collection(PolyCollection(shapes, facecolors=colour, edgecolors="white", **style))


def draw_pushes(axes: Axes, shot: Shot, picture: Picture, state: dict[int, bool], unit: float) -> None:
    """Draw the weakest pushes with their numbers; ``state`` maps the index of each to whether it is visible."""
    if not state:
        return
    chosen = sorted(state)
    tails, heads = (on_page(shot, ends[chosen]) for ends in ends_of(picture.weakest))
    pen = Pen(PUSH.shaft * unit, PUSH.head * unit, PUSH.wide * unit, PUSH.least * unit)
    for k, tail, head in zip(chosen, tails, heads, strict=True):
        strength = 1.0 if state[k] else _HIDDEN_ALPHA
        draw_arrows(axes, tail[None], head[None], pen, INK, linewidths=1.1 * unit, alpha=strength, zorder=5)
        axes.plot(*head, "o", ms=4.0 * unit, mfc=INK, mec="white", mew=0.8 * unit, alpha=strength, zorder=6)
    along = tails - heads
    length = np.linalg.norm(along, axis=1, keepdims=True)
    direction = np.divide(along, length, out=np.tile([0.0, -1.0], (len(along), 1)), where=length > 0.5)
    ends = heads + direction * np.maximum(length, pen.least)
    places = badge_places(shot, ends + direction * 13.0 * unit, unit)
    for k, place, end in zip(chosen, places[nearest_badges(ends, places)], ends, strict=True):
        if np.linalg.norm(place - end) > 24.0 * unit:
            axes.plot(*np.stack([end, place], axis=1), color=INK, lw=0.8 * unit, zorder=4)
        badge(axes, place[0], place[1], str(k + 1), unit)


def draw_contacts(axes: Axes, shot: Shot, picture: Picture, unit: float) -> None:
    """Draw contact patches, nodes and the contact forces at rest over a pale panel."""
    from matplotlib.collections import PolyCollection

    patches = [on_page(shot, outline) for outline in picture.outlines]
    fill, edge = (*rgb_of(CONTACT), 0.16), (*rgb_of(CONTACT), 0.75)
    axes.add_collection(PolyCollection(patches, facecolors=fill, edgecolors=edge, linewidths=0.9 * unit, zorder=3))
    nodes = on_page(shot, picture.contact_points)
    axes.plot(nodes[:, 0], nodes[:, 1], "o", ms=2.6 * unit, mfc=CONTACT, mec="white", mew=0.4 * unit, zorder=4)
    tails, heads = (on_page(shot, ends) for ends in ends_of(picture.contact_forces))
    pen = Pen(FORCE.shaft * unit, FORCE.head * unit, FORCE.wide * unit, FORCE.least)
    draw_arrows(axes, tails, heads, pen, CONTACT, linewidths=0.5 * unit, zorder=5)


def badge_places(shot: Shot, places: Float, unit: float) -> Float:
    """Move places (N, 2) [px] so that badges overlap neither each other nor the axes nor the border of the panel.

    If there is not enough room, overlaps remain.
    """
    apart = 27.0 * unit
    box = shot.box
    low = np.array([box.left, box.top]) + 14.0 * unit
    high = np.array([box.left + box.width, box.top + box.height]) - 14.0 * unit
    # Coinciding badges need a direction in which to move apart, which depends on their number.
    turn = np.arange(len(places)) * 2.4
    nudge = 0.01 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    places = np.clip(places + nudge, low, high)
    middle, radius = room_of_axes(box, unit)
    radius += 14.0 * unit
    for _ in range(_RELAX_ROUNDS):
        gap = places[:, None] - places[None]
        distance = np.linalg.norm(gap, axis=2) + np.eye(len(places)) * 1e9
        overlap = np.clip(apart - distance, 0.0, None)
        inside = np.linalg.norm(places - middle, axis=1) < radius
        if not overlap.any() and not inside.any():
            break
        push = ((overlap / distance)[:, :, None] * gap).sum(axis=1)
        touching = np.maximum((overlap > 0.0).sum(axis=1), 1)
        places = places + 0.55 * push / touching[:, None]
        ways = places[inside] - middle  # right and up, where there is room
        ways = np.column_stack([ways[:, 0].clip(min=0.0), ways[:, 1].clip(max=0.0)])
        length = np.linalg.norm(ways, axis=1, keepdims=True)
        ways = np.where(length > 1e-6, ways / np.maximum(length, 1e-6), np.array([0.8, -0.6]))
        places[inside] = middle + (radius + 1.0) * ways + nudge[inside]
        places = np.clip(places, low, high)
    return np.asarray(np.clip(places, low, high), dtype=float)


def nearest_badges(ends: Float, places: Float) -> NDArray[np.intp]:
    """Return which of the ``places`` (N, 2) [px] each arrow takes, so that no number stands at another arrow's end.

    Badges that were moved apart may have passed each other. ``ends`` (N, 2) [px] are the ends of the arrows.
    """
    from scipy.optimize import linear_sum_assignment  # only here, as it takes long to import

    return np.asarray(linear_sum_assignment(np.linalg.norm(ends[:, None] - places[None], axis=2))[1], dtype=np.intp)


def draw_scale_bar(axes: Axes, shot: Shot, unit: float) -> None:
    """Draw a bar of a round length [m] in the lower right corner, as a scale for lengths across the line of sight."""
    raw = 0.16 * shot.box.width / shot.camera.scale
    power = 10.0 ** np.floor(np.log10(raw))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= raw * (1 + 1e-9))
    right, y = shot.box.left + shot.box.width - 18 * unit, shot.box.top + shot.box.height - 18 * unit
    left = right - length * shot.camera.scale
    axes.plot([left, left, right, right], [y - 5 * unit, y, y, y - 5 * unit], color=INK, lw=1.1 * unit, zorder=9)
    text = f"{length:g} m" if length >= 0.1 else f"{1000 * length:g} mm"
    write(axes, (left + right) / 2, y - 8 * unit, text, 10 * unit, va="baseline")
