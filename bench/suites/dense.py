"""Dense pallets, in columns and staggered: pushes on 300 boxes and the map of a top box of 60, by two engines."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeVar

import numpy as np

import holdfast as hf
from bench.scenes.random_pushes import random_pushes
from bench.suite import Case, Row, Suite, table
from holdfast.scene.shipped.blocks import at

T = TypeVar("T")
SIZE = np.array([0.3, 0.2, 0.15])  # [m] sides of a box
SHIFTS = {"columns": (0.0, 0.0, 0.0), "staggered": (0.1, 0.05, 0.0)}  # [m] shift of every other layer
MASS, SPREAD = 5.0, 0.2  # mass of a box [kg], and the largest relative difference of masses
MU = 0.5
MANY, FEW = (10, 6, 5), (5, 4, 3)  # boxes along x, y and z
PUSHES = 16
SEED = 7
SPACING = 0.03  # [m] spacing of the map
SLANT = 30.0  # [°] largest angle from the normal


def pallet(counts: tuple[int, int, int], arrangement: str) -> hf.Scene:
    """Boxes that touch each other on all sides; all sides touch without force."""
    rng = np.random.default_rng(SEED)
    bodies = [hf.Body("floor", hf.Box((20, 20, 0.1)), pose=at(0, 0, -0.05), fixed=True)]
    for i, j, k in np.ndindex(*counts):
        middle = SIZE * (i, j, k + 0.5) + np.multiply(SHIFTS[arrangement], k % 2)
        mass = MASS * rng.uniform(1 - SPREAD, 1 + SPREAD)
        bodies.append(hf.Body(f"b{i}_{j}_{k}", hf.Box(SIZE), mass=mass, pose=at(*middle)))
    return hf.Scene(bodies, MU)


def cases() -> Mapping[str, Case]:
    of_pushes = {f"pushes on 300 boxes, {name}": partial(_pushes, name) for name in SHIFTS}
    return of_pushes | {f"map of a top box of 60, {name}": partial(_map, name) for name in SHIFTS}


def _timed(ask: Callable[[], T]) -> tuple[float, T]:
    start = time.perf_counter()
    found = ask()
    return time.perf_counter() - start, found


def _pushes(arrangement: str) -> list[Row]:
    """One row a push on what is exposed, by public calls on a prepared assembly: what it takes each engine."""
    assembly = hf.assemble(pallet(MANY, arrangement))
    first, *asked = random_pushes(assembly, np.random.default_rng(SEED), PUSHES + 1, slant=SLANT)
    rows = []
    for engine in ("limit", "compliant"):  # warm-up: the first answer includes one-time costs
        hf.robustness(assembly, *first, engine=engine)
    for number, push in enumerate(asked):
        row: Row = {"case": f"{arrangement}, push {number} on {push.body}"}
        spent: dict[str, float] = {}
        for engine in ("limit", "compliant"):
            spent[engine], found = _timed(partial(hf.robustness, assembly, *push, engine=engine))
            row |= {f"{engine} s": spent[engine], f"{engine} N": float(found.force[0])}
        rows.append(row | {"compliant / limit": spent["compliant"] / spent["limit"]})
    return rows


def _map(arrangement: str) -> list[Row]:
    """The whole map of a box in the middle of the topmost layer."""
    assembly = hf.assemble(pallet(FEW, arrangement))
    name = f"b{FEW[0] // 2}_{FEW[1] // 2}_{FEW[2] - 1}"
    row: Row = {"case": f"{arrangement}, map of {name}"}
    spent: dict[str, float] = {}
    for engine in ("limit", "compliant"):
        ask = partial(hf.robustness_map, assembly, [name], spacing=SPACING, engine=engine)
        ask()
        spent[engine], found = _timed(ask)
        row |= {f"{engine} s": spent[engine]}
    undecided = int((found.status == hf.Status.UNDECIDED).sum())
    row |= {"points": len(found.force), "endless": int(np.isinf(found.force).sum()), "undecided": undecided}
    return [row | {"compliant / limit": spent["compliant"] / spent["limit"]}]


def written(rows: list[Row]) -> str:
    """What every case takes in the median, and all maps."""
    lines: list[Row] = []
    for name in SHIFTS:
        mine = [row for row in rows if row["case"].startswith(f"{name}, push")]
        if not mine:
            continue
        line: Row = {"case": f"{len(mine)} pushes on 300 boxes, {name}, median"}
        for key in ("limit s", "compliant s", "compliant / limit"):
            line[key] = float(np.median([row[key] for row in mine]))
        lines.append(line)
    return table(lines) + "\n\n" + table([row for row in rows if "points" in row])


SUITE = Suite("dense", __doc__, cases, written=written)
