"""Bricks beyond the edge of a table: the harmonic stack, and the diamonds of Paterson and Zwick 2009."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import holdfast as hf
from bench.experiments.source import ENGINES, Source, block, row, stands, threshold
from bench.suite import Case, Row

COUNTS = (2, 3, 5, 10, 20, 30)
DIAMONDS = {2: "stands", 3: "stands", 4: "stands", 5: "falls", 6: "falls"}
TRIANGLES = {2: "stands", 3: "falls"}


def harmonic(count: int, scale: float) -> hf.Scene:
    """Blocks of length 1, of which the k-th from the top overhangs the one below by ``scale`` / (2 k)."""
    bodies, x = [block("table", (1, 1, 1), (-0.5, 0, -0.5), fixed=True)], -0.5
    for level in range(count):
        x += scale / (2 * (count - level))
        bodies.append(block(f"b{level}", (1, 1, 0.2), (x, 0, 0.1 + 0.2 * level)))
    return hf.Scene(bodies, friction=0.5)


def bricks(counts: list[int]) -> hf.Scene:
    """Rows of unit bricks without friction, centred, from a table as wide as one brick up."""
    bodies = [block("table", (1, 1, 1), (0, 0, -0.5), fixed=True)]
    for level, count in enumerate(counts):
        places = [(k - (count - 1) / 2, 0, 0.25 + 0.5 * level) for k in range(count)]
        bodies += [block(f"{level}_{k}", (1, 1, 0.5), at) for k, at in enumerate(places)]
    return hf.Scene(bodies, friction=0.0)


def diamond(most: int) -> hf.Scene:
    """Rows of 1, 2, ... ``most``, ... 2, 1 bricks."""
    return bricks([*range(1, most + 1), *range(most - 1, 0, -1)])


def triangle(rows: int) -> hf.Scene:
    """Rows of 1, 2, ... bricks, the widest on top."""
    return bricks([*range(1, rows + 1)])


def _harmonic(count: int) -> list[Row]:
    found = threshold(f"harmonic stack of {count}", "1.0000", partial(harmonic, count), (1.1, 0.9))
    return [found | {"blocks": count, "reach": sum(1 / (2 * k) for k in range(1, count + 1))}]


def _rows(case: str, scene: hf.Scene, printed: str) -> list[Row]:
    return [row(case, printed, "limit", "", **{engine: stands(scene, engine) for engine in ENGINES})]


def cases() -> Mapping[str, Case]:
    """One case a stack."""
    found: dict[str, Case] = {f"harmonic {count}": partial(_harmonic, count) for count in COUNTS}
    for most, printed in DIAMONDS.items():
        found[f"diamond {most}"] = partial(_rows, f"diamond, widest row {most}", diamond(most), printed)
    for rows, printed in TRIANGLES.items():
        found[f"triangle {rows}"] = partial(_rows, f"inverted triangle of {rows} rows", triangle(rows), printed)
    return found


SOURCE = Source(
    "overhangs",
    "the harmonic stack of textbooks; M. Paterson, U. Zwick, Overhang, American Mathematical Monthly 116 (2009) 19-44",
    "the share of the harmonic overhang up to which a stack stands; which diamonds and inverted triangles balance",
    "equal bricks; no friction among diamonds and triangles",
    cases,
)
