"""Real pallets of 5 to 108 boxes in 8 level accelerations: a load path of ``compliant`` over a solve of ``limit``."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

import holdfast as hf
from bench.scenes.real_pallets import MU, pallet, pallets
from bench.suite import Case, Row, Suite, table
from holdfast.assembly.assembly import body_forces
from holdfast.base.arrays import Float
from holdfast.engines.contract import Engine
from holdfast.engines.groups import Groups, prepared

WAYS = 8  # level directions, evenly spaced
EVERY = "HOLDFAST_CARGO_EVERY"  # environment variable: n takes only every n-th pallet, ordered by number of boxes
SOLVES = 3  # solves of each engine and acceleration, of which the fastest counts


def cases() -> Mapping[str, Case]:
    """One case a pallet."""
    every = int(os.environ.get(EVERY, "1"))
    chosen = list(enumerate(pallets()))[::every]
    return {f"{number}: {len(boxes)} boxes": partial(_pallet, number, boxes) for number, boxes in chosen}


def _timed(ask: Callable[[], Any]) -> tuple[float, Any]:
    start = time.process_time()
    found = ask()
    return time.process_time() - start, found


def _prepared(assembly: hf.answers.Assembly, engine: Engine, W: Float) -> tuple[float, Groups]:
    """What the first answer costs, and the state that gives the others."""

    def ask() -> Groups:
        state = prepared(engine, assembly)
        state.load_factor(W[:, :1])
        return state

    return _timed(ask)


def _pallet(number: int, boxes: list[dict[str, Any]]) -> list[Row]:
    """One row an acceleration: processor time of one more answer of a prepared state, of either engine."""
    assembly = hf.assemble(pallet(boxes))
    angles = 2 * np.pi * np.arange(WAYS) / WAYS
    ways = np.stack([np.cos(angles), np.sin(angles), np.zeros(WAYS)], 1)
    W = np.column_stack([body_forces(-assembly.mass[:, None] * way) for way in ways])
    first, states = {}, {}
    for name, engine in (("limit", hf.Limit()), ("compliant", hf.Compliant())):
        first[name], states[name] = _prepared(assembly, engine, W)
    verdict = states["compliant"].verdict().status
    about: Row = {"pallet": number, "boxes": len(boxes), "verdict": str(verdict)}
    about |= {f"{name} first s": spent for name, spent in first.items()}
    if verdict is not hf.Status.STABLE:
        return [{"case": f"{number}: {len(boxes)} boxes"} | about]
    rows: list[Row] = []
    for k in range(WAYS):
        best, force = dict.fromkeys(states, np.inf), dict.fromkeys(states, 0.0)
        for _ in range(SOLVES):
            for name, state in states.items():
                spent, found = _timed(partial(state.load_factor, W[:, k : k + 1]))
                best[name], force[name] = min(best[name], spent), float(found.force[0])
        row: Row = {"case": f"{number}: {len(boxes)} boxes, {360 * k // WAYS}°"} | about
        row |= {f"{name} s": spent for name, spent in best.items()}
        row |= {f"{name} m/s²": value for name, value in force.items()}
        rows.append(row | {"compliant / limit": best["compliant"] / best["limit"]})
    return rows


def written(rows: list[Row]) -> str:
    """A table of pallets, and the ratio over all accelerations."""
    asked = [row for row in rows if "compliant / limit" in row]
    ratio = np.array([row["compliant / limit"] for row in asked])
    lines: dict[int, Row] = {}
    for row in asked:
        mine = [other for other in asked if other["pallet"] == row["pallet"]]
        each = {name: float(np.median([other[f"{name} s"] for other in mine])) for name in ("limit", "compliant")}
        ratios = [other["compliant / limit"] for other in mine]
        line: Row = {"pallet": row["pallet"], "boxes": row["boxes"]}
        line |= {f"{name} first s": row[f"{name} first s"] for name in each}
        line |= {f"median {name} s": spent for name, spent in each.items()}
        lines[row["pallet"]] = line | {"median ratio": float(np.median(ratios)), "worst ratio": max(ratios)}
    standing, all_ = len(lines), len({row["pallet"] for row in rows})
    summary = (
        f"{standing} of {all_} pallets stand (μ {MU}). One more acceleration by a prepared state, processor time of "
        f"`compliant` over that of `limit`: median {np.median(ratio):.1f}, 90 % {np.percentile(ratio, 90):.1f}, "
        f"worst {ratio.max():.1f}."
    )
    return f"{table(list(lines.values()))}\n\n{summary}"


SUITE = Suite("cargo", __doc__, cases, written=written)
