"""Brick walls under a horizontal acceleration: Ferris and Tin-Loi 2001."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.experiments.source import ENGINES, Source, block, level_acceleration, row
from bench.suite import Case, Row

EVEN: list[list[float]] = [[0.5, 1, 1, 1, 1, 0.5], [1, 1, 1, 1, 1]]
ROWS: dict[str, list[float]] = {
    "E": [1, 1, 1, 1],
    "U": [0.5, 1, 1, 1, 0.5],
    "u": [0.5, 1, -1, 1, 0.5],
    "e": [1, 0.5, -1, 0.5, 1],
}
WALLS = {"1": EVEN * 3, "2": EVEN * 5, "3": [ROWS[letter] for letter in "EUEueueuEUE"]}  # gaps are negative
ASSOCIATED = {"1": "0.64286", "2": "0.58000", "3": "0.40369"}
NON_ASSOCIATED = {"1": "0.63982", "2": "0.56262", "3": "0.35582"}
BRICK = np.array([0.4, 0.4, 0.175])  # [m]
WHY = (
    "without dilatancy many load factors fulfil all conditions; the printed one is the least that an optimiser found,"
    " that of `compliant` where a load path from rest ends"
)


def wall(name: str) -> hf.Scene:
    """One of the three walls."""
    length, depth, height = BRICK
    bricks = [hf.Body("ground", hf.HalfSpace(), fixed=True)]
    for level, shares in enumerate(WALLS[name]):
        begins = np.concatenate([[0.0], np.cumsum(np.abs(shares))])
        for k, share in enumerate(shares):
            if share > 0:
                at = (length * (begins[k] + begins[k + 1]) / 2, 0.0, height * (level + 0.5))
                bricks.append(block(f"{level}_{k}", (share * length, depth, height), at))
    return hf.Scene(bricks, friction=0.65)


def _moves(name: str) -> list[Row]:
    found = {engine: level_acceleration(wall(name), engine) for engine in ENGINES}
    why = "" if name == "3" else WHY
    return [
        row(f"wall {name}, associated", ASSOCIATED[name], "limit", "", **found),
        row(f"wall {name}, non-associated", NON_ASSOCIATED[name], "compliant", why, **found),
    ]


def cases() -> Mapping[str, Case]:
    """One case a wall."""
    return {f"wall {name}": partial(_moves, name) for name in WALLS}


SOURCE = Source(
    "brick walls",
    "M. C. Ferris, F. Tin-Loi, Limit analysis of frictional block assemblies as a mathematical program with"
    " complementarity constraints, Int. J. Mech. Sci. 43 (2001) 209-224",
    "the horizontal acceleration, in g, at which three walls of bricks move, computed with and without dilatancy",
    "bricks of 0.4 x 0.4 x 0.175 m, friction 0.65 everywhere",
    cases,
)
