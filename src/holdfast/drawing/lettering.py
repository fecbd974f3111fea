"""Names of bodies and of the world's axes, written over a rendered panel where there is room for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from holdfast.base.text import one_line
from holdfast.drawing.camera import View
from holdfast.drawing.layout import Box
from holdfast.drawing.marks import AXIS, FONT, INK, room_of_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from holdfast.drawing.footer import Writer

LETTERS: Final = 13.0  # height of a name's letters [px] at the design size
LONGEST: Final = 24  # largest number of characters of a name in a picture
_MOST: Final = 40  # largest number of names in a panel
_ON_BODY: Final = 0.5  # a name is written only if this share of it lies on what is seen of its body
_HALO: Final = 2.6  # width of the white rim of letters [px] at the design size


class NamePlace(NamedTuple):
    """A name and the pixel of the panel, row and column, that its middle is written at."""

    name: str
    row: int
    column: int


def name_places(
    seen: NDArray[np.int64], sizes: Sequence[tuple[str, int, int]], taken: NDArray[np.bool_]
) -> tuple[NamePlace, ...]:
    """Choose the places of names without overlaps, for the largest visible bodies first.

    ``seen`` (H, W) is the number of the body at each pixel, -1 for none; ``sizes`` are the name, width and height [px]
    of the text for each body. Nothing is written over ``taken`` (H, W). A name is placed where most of it lies on its
    body, near the body's middle; if less than half would, it is left out.
    """
    taken = taken.copy()
    found = []
    areas = np.bincount(seen[seen >= 0], minlength=len(sizes))
    for body in np.argsort(-areas, kind="stable")[:_MOST]:
        name, wide, high = sizes[body]
        if not name or not areas[body] or wide >= seen.shape[1] or high >= seen.shape[0]:
            continue
        own = seen == body
        cover = uniform_filter(own.astype(np.float32), (high, wide), mode="constant")
        free = uniform_filter(taken.astype(np.float32), (high, wide), mode="constant", cval=1.0) < 1e-6
        rows, columns = np.nonzero(own & free)
        if not len(rows):
            continue
        middle = np.argwhere(own).mean(axis=0)
        off = np.hypot(rows - middle[0], columns - middle[1]) / np.sqrt(areas[body])
        best = int(np.argmax(cover[rows, columns] - 0.1 * off))
        row, column = int(rows[best]), int(columns[best])
        if cover[row, column] < _ON_BODY:
            continue
        found.append(NamePlace(name, row, column))
        block(taken, row, column, wide, high)
    return tuple(found)


def block(taken: NDArray[np.bool_], row: float, column: float, wide: int, high: int) -> None:
    """Mark a rectangle around a pixel as taken, in place."""
    top, left = max(0, round(row) - high // 2), max(0, round(column) - wide // 2)
    taken[top : top + high, left : left + wide] = True


def draw_names(
    writer: Writer, box: Box, seen: NDArray[np.int64], names: Sequence[str], taken: NDArray[np.bool_]
) -> None:
    """Write the names of the bodies with these numbers into a panel at ``box`` of the page."""
    unit = writer.unit
    texts = [one_line(name, LONGEST) for name in names]
    high = round(1.5 * LETTERS * unit)
    sizes = [(text, round(writer.width(text, LETTERS) + 8 * unit), high) for text in texts]
    for place in name_places(seen, sizes, taken):
        x, y = box.left + place.column, box.top + place.row
        text = writer.put(x, y + 0.36 * LETTERS * unit, place.name, LETTERS, align="center")
        text.set_path_effects(halo(unit))
        text.set_gid("name")


def draw_axes(axes: Axes, box: Box, view: View, unit: float) -> None:
    """Draw the directions of the world's axes as this view sees them in the lower left corner of a panel."""
    x, y = room_of_axes(box, unit)[0]
    ends = view.flat(np.eye(3)) * AXIS * unit * np.array([1.0, -1.0])
    for letter, (right, down) in zip("xyz", ends, strict=True):
        axes.plot([x, x + right], [y, y + down], color=INK, lw=1.3 * unit, zorder=9, gid=f"axis {letter}")
        reach = max(float(np.hypot(right, down)), 1e-9)
        past = 1.0 + 9.0 * unit / max(reach, 9.0 * unit)
        axes.text(
            x + past * right, y + past * down, letter, color=INK, fontsize=10 * unit, fontfamily=FONT, ha="center",
            va="center", zorder=9, parse_math=False, path_effects=halo(unit), gid=f"letter {letter}",
        )  # fmt: skip


def halo(unit: float) -> list[Any]:
    """Return the path effects of letters with a white rim."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=_HALO * unit, foreground="white", alpha=0.85), Normal()]
