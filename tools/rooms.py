"""Draw the rooms of the package, floor by floor, and what they import: the picture of docs/architecture.md.

    python tools/rooms.py [FILE]

writes docs/images/rooms.svg, or FILE. Rooms and words are those of the map on that page, arrows come from the imports
of today. A room that is also reached by way of another has no arrow, so that the few that are drawn say all.
"""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

from matplotlib import rcParams
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path as Curve

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "holdfast"
SIDE = {"elastic": -1, "drawing": -1, "settling": 1, "conic": 1, "agents": 1}  # columns of rooms beside the stair
WIDE, HIGH, ACROSS = 3.5, 0.66, 4.6  # width and height of a box, distance of columns; floors are 1 apart
TINTS = {2: "#e9edf2", 5: "#dbe8f6", 8: "#dcefe0", 10: "#fbeccd", 14: "#f6dede"}  # up to this floor


def rooms() -> dict[str, tuple[int, str]]:
    """Return the floor of each room and what it holds, from the map on the page, whose floors a test proves."""
    page, floor, found = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8"), 0, {}
    for number, name, words in re.findall(r"^ {4} *(\d*) +(\w+)/ +(.*)$", page, re.MULTILINE):
        floor = int(number or floor)
        if (PACKAGE / name).is_dir():
            found[name] = floor, re.split(r"[:;]", words)[0]
    return found


def imports(names: set[str]) -> dict[str, set[str]]:
    """Return the rooms that each room imports, without those that it imports by way of another."""
    direct: dict[str, set[str]] = {name: set() for name in names}
    for name in names:
        for path in (PACKAGE / name).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("holdfast."):
                    direct[name] |= {str(node.module).split(".")[1]} & (names - {name})

    def below(name: str) -> set[str]:
        return direct[name].union(*map(below, direct[name]))

    return {name: direct[name].difference(*map(below, direct[name])) for name in names}


def draw(path: Path) -> None:
    """Write the picture to a file, whose suffix says the kind."""
    rcParams["svg.hashsalt"] = "rooms"
    figure = Figure(figsize=(11.2, 11.6), facecolor="white")
    axes = figure.add_axes((0, 0, 1, 1), frameon=False, xticks=(), yticks=(), xlim=(-7, 7), ylim=(-0.6, 14.6))
    found = rooms()
    place = {name: (ACROSS * SIDE.get(name, 0), floor) for name, (floor, _) in found.items()}
    for name, others in sorted(imports({*place}).items()):
        for x, y, u, v in ((*place[name], *place[other]) for other in sorted(others)):
            to = (u > x) - (u < x)  # 0: straight down, from one box to the next of its column
            a, b = (x + to * WIDE / 2, y - 0.13), (u - to * WIDE / 2, v + 0.13)
            a, b = (a, b) if to else ((x, y - HIGH / 2), (u, v + HIGH / 2))
            out = (to * 0.9, 0 if to else (b[1] - a[1]) / 3)  # how far the ends go straight
            middle = [(a[0] + out[0], a[1] + out[1]), (b[0] - out[0], b[1] - out[1])]
            curve = Curve([a, *middle, b], [Curve.MOVETO, Curve.CURVE4, Curve.CURVE4, Curve.CURVE4])
            axes.add_patch(FancyArrowPatch(path=curve, arrowstyle="-|>", mutation_scale=12, color="#5b6b7f", lw=1.3))
    for name, (floor, words) in found.items():
        x, y = place[name]
        tint = next(colour for most, colour in TINTS.items() if floor <= most)
        corner, style = (x - WIDE / 2, y - HIGH / 2), "round,pad=0,rounding_size=0.12"
        axes.add_patch(FancyBboxPatch(corner, WIDE, HIGH, style, fc=tint, ec="#5b6b7f", lw=0.8))
        axes.text(x, y + 0.13, name, ha="center", va="center", fontsize=13, fontweight="bold", color="#1d2733")
        axes.text(x, y - 0.16, words, ha="center", va="center", fontsize=8.5, color="#3a4656")
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if sys.argv[1:] else ROOT / "docs" / "images" / "rooms.svg")
