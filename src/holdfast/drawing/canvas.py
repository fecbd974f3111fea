"""Pages of pixels with texts on them: titles, numbers on discs, names of bodies, and the world's axes."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.errors import PNG_INSTALL, PNG_NEEDS, HoldfastError
from holdfast.base.text import one_line
from holdfast.drawing.camera import View
from holdfast.drawing.colours import FRAME, GREY, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text

FONT: Final = "DejaVu Sans"  # font of all texts
LETTERS: Final = 13.0  # height of a name's letters [px] at the design size
LONGEST: Final = 24  # largest number of characters of a name in a picture
AXIS: Final = 30.0  # length of the world's axes [px] at the design size
_DPI: Final = 100  # resolution of figures [pixels per inch]
_POINTS_PER_PIXEL: Final = 0.72  # font size [points] of a letter height of one pixel
_MOST: Final = 40  # largest number of names in a panel
_ON_BODY: Final = 0.5  # a name is written only if this share of it lies on what is seen of its body
_HALO: Final = 2.6  # width of the white rim of letters [px] at the design size


class PageBox(NamedTuple):
    """A rectangle of the page [px]."""

    left: int
    top: int
    width: int
    height: int

    def of(self, page: Float) -> Float:
        """Return the part of a page image (H, W, 3) in this rectangle, to be written to."""
        return page[self.top : self.top + self.height, self.left : self.left + self.width]


def write(axes: Axes, x: float, y: float, text: str, points: float, **style: Any) -> Text:  # noqa: ANN401
    """Write a text without formulas, in ink and centred unless ``style`` says otherwise."""
    usual: dict[str, Any] = {"color": INK, "ha": "center", "zorder": 9, "fontfamily": FONT, "parse_math": False}
    return axes.text(x, y, text, fontsize=points, **usual | style)


class Writer:
    """A page of ``width`` by ``height`` pixels with an ``image`` (height, width, 3), in 0..1, beneath lines of text.

    ``axes`` are over the whole page, in pixels from its upper left corner. ``unit`` is the size of a pixel of the
    design; letter heights (``pixels``) are at the design size.
    """

    def __init__(self, width: int, height: int, unit: float = 1.0) -> None:
        try:
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure
        except ImportError as error:
            raise HoldfastError(f"{PNG_NEEDS}; remedy: {PNG_INSTALL}") from error
        self.unit = unit
        self.image = np.ones((height, width, 3))
        self.figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI, facecolor="white")
        self._canvas = FigureCanvasAgg(self.figure)
        whole: dict[str, Any] = {"xlim": (0, width), "ylim": (height, 0), "facecolor": "none"}
        self.axes: Axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0), **whole)
        self.axes.set_axis_off()
        self.axes.set_autoscale_on(False)

    def png(self) -> bytes:
        """Return the page as the bytes of a PNG file."""
        self.figure.figimage(np.rint(self.image * 255.0).astype(np.uint8), zorder=-1)
        stream = BytesIO()
        self._canvas.print_png(stream)
        return stream.getvalue()

    def box(self, left: float, top: float, width: float, height: float, **options: Any) -> Any:  # noqa: ANN401
        """Return further axes at a place of the page: left and top edge, width and height [px]."""
        h, w, _ = self.image.shape
        return self.figure.add_axes((left / w, 1 - (top + height) / h, width / w, height / h), **options)

    def framed(self, box: PageBox) -> None:
        """Draw the frame of a panel."""
        self.swatch(*box, fill=False, edgecolor=FRAME, lw=0.8, zorder=1)

    def swatch(self, x: float, y: float, width: float, height: float, **look: Any) -> None:  # noqa: ANN401
        """Draw a rectangle with its upper left corner at (x, y); ``lw`` is at the design size."""
        from matplotlib.patches import Rectangle

        look = {"zorder": 9} | look | {"lw": look.get("lw", 1.0) * self.unit}
        self.axes.add_patch(Rectangle((x, y), width, height, **look))

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
        """Write one line of text with its baseline at row y."""
        points, weight = pixels * self.unit * _POINTS_PER_PIXEL, "bold" if bold else "normal"
        return write(self.axes, x, y, one_line(text), points, color=colour, ha=align, va="baseline", fontweight=weight)

    def put_clipped(self, x: float, y: float, text: str, pixels: float, room: float, **style: Any) -> None:  # noqa: ANN401
        """Write one line of text, shortened to ``room`` [px], in a ``style`` as for ``put``."""
        self.put(x, y, self.clipped(text, pixels, room, bold=style.get("bold", False)), pixels, **style)

    def head(
        self,
        title: str,
        subtitle: str,
        left: int = 60,
        rows: tuple[int, int] = (50, 80),
        letters: tuple[int, int] = (27, 16),
    ) -> None:
        """Write the title and the subtitle of the page at these ``rows`` [px], in letters of these heights."""
        room = self.image.shape[1] - 2 * left
        self.put_clipped(left, rows[0], title, letters[0], room, bold=True)
        self.put_clipped(left, rows[1], subtitle, letters[1], room, colour=GREY)

    def width(self, text: str, pixels: float, bold: bool = False) -> float:
        """Return the width of a line [px]."""
        from matplotlib.font_manager import FontProperties

        weight = "bold" if bold else "normal"
        font = FontProperties(family=FONT, size=pixels * self.unit * _POINTS_PER_PIXEL, weight=weight)
        return float(self._canvas.get_renderer().get_text_width_height_descent(one_line(text), font, False)[0])

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


def badge(axes: Axes, x: float, y: float, text: str, unit: float) -> None:
    """Draw a white number on a dark disc centred at page pixel (x, y)."""
    axes.plot([x], [y], "o", ms=16.5 * unit, mfc=INK, mec="white", mew=1.2 * unit, zorder=7)
    style = {"color": "white", "fontweight": "bold", "va": "center_baseline", "zorder": 8}
    write(axes, x, y + 0.5 * unit, text, 9.4 * unit, **style)


def halo(unit: float) -> list[Any]:
    """Return the path effects of letters with a white rim."""
    from matplotlib.patheffects import Normal, Stroke

    return [Stroke(linewidth=_HALO * unit, foreground="white", alpha=0.85), Normal()]


def room_of_axes(box: PageBox, unit: float) -> tuple[Float, float]:
    """Return the middle (2,) and the radius [px] of the disc that the world's axes and their letters take."""
    middle = np.array([box.left + 1.6 * AXIS * unit, box.top + box.height - 1.6 * AXIS * unit])
    return middle, (AXIS + 15.0) * unit


def draw_axes(axes: Axes, box: PageBox, view: View, unit: float) -> None:
    """Draw the directions of the world's axes as this view sees them in the lower left corner of a panel."""
    x, y = room_of_axes(box, unit)[0]
    ends = view.flat(np.eye(3)) * AXIS * unit * np.array([1.0, -1.0])
    for letter, (right, down) in zip("xyz", ends, strict=True):
        axes.plot([x, x + right], [y, y + down], color=INK, lw=1.3 * unit, zorder=9, gid=f"axis {letter}")
        reach = max(float(np.hypot(right, down)), 1e-9)
        past = 1.0 + 9.0 * unit / max(reach, 9.0 * unit)
        style = {"va": "center", "path_effects": halo(unit), "gid": f"letter {letter}"}
        write(axes, x + past * right, y + past * down, letter, 10 * unit, **style)


class NamePlace(NamedTuple):
    """A name and the pixel of the panel, row and column, that its middle is written at."""

    name: str
    row: int
    column: int


def name_places(seen: Int, sizes: Sequence[tuple[str, int, int]], taken: Bool) -> tuple[NamePlace, ...]:
    """Choose the places of names without overlaps, for the largest visible bodies first.

    ``seen`` (H, W) is the number of the body at each pixel, -1 for none; ``sizes`` are the name, width and height [px]
    of the text for each body. Nothing is written over ``taken`` (H, W). A name is placed where most of it lies on its
    body, near the body's middle; if less than half would, it is left out.
    """
    from scipy.ndimage import uniform_filter  # only here, as it takes long to import

    taken = taken.copy()
    places = []
    areas = np.bincount(seen[seen >= 0], minlength=len(sizes))
    for body in np.argsort(-areas, kind="stable")[:_MOST]:
        name, wide, high = sizes[body]
        if not name or not areas[body] or wide >= seen.shape[1] or high >= seen.shape[0]:
            continue
        visible = seen == body
        cover = uniform_filter(visible.astype(np.float32), (high, wide), mode="constant")
        free = uniform_filter(taken.astype(np.float32), (high, wide), mode="constant", cval=1.0) < 1e-6
        rows, columns = np.nonzero(visible & free)
        if not len(rows):
            continue
        middle = np.argwhere(visible).mean(axis=0)
        off = np.hypot(rows - middle[0], columns - middle[1]) / np.sqrt(areas[body])
        best = int(np.argmax(cover[rows, columns] - 0.1 * off))
        row, column = int(rows[best]), int(columns[best])
        if cover[row, column] < _ON_BODY:
            continue
        places.append(NamePlace(name, row, column))
        block(taken, row, column, wide, high)
    return tuple(places)


def block(taken: Bool, row: float, column: float, wide: int, high: int) -> None:
    """Mark a rectangle around a pixel as taken, in place."""
    top, left = max(0, round(row) - high // 2), max(0, round(column) - wide // 2)
    taken[top : top + high, left : left + wide] = True


def draw_names(writer: Writer, box: PageBox, seen: Int, names: Sequence[str], taken: Bool) -> None:
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
