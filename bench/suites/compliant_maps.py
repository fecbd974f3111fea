"""Maps of ``compliant`` beside a path for every point and as many single ``limit`` solves, and how far they are off."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.contract import Within
from holdfast.engines.limit.engine import Limit
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

SCENES = {  # spacings [m] for about 1,000 points
    "cube": 0.0073,
    "stack": 0.0118,
    "table": 0.0233,
    "tall_table": 0.03,
    "slope_two": 0.0108,
    "wall2x2": 0.02,
    "v_groove": 0.0085,
    "arch": 0.022,
}
GAP = 0.01
CHECKED = 200
RUNS = 5


def cases() -> Mapping[str, Case]:
    return {name: partial(_map, name, spacing) for name, spacing in SCENES.items()}


def _seconds(work: Callable[[], object]) -> tuple[float, float]:
    """Wall and CPU time of the run that took the least: other users of the machine only add to it."""
    spent = []
    for _ in range(RUNS):
        wall, own = time.perf_counter(), time.process_time()
        work()
        spent.append((time.perf_counter() - wall, time.process_time() - own))
    return min(spent)


def _map(scene: str, spacing: float) -> list[Row]:
    assembly = hf.assemble(shipped_scene(scene))
    result = hf.robustness_map(assembly, None, spacing=spacing, engine="compliant", accuracy=GAP)
    columns = [
        push_columns(assembly, assembly.index[name], result.points[here], -result.normals[here])
        for name in dict.fromkeys(result.body)
        for here in [result.body == name]
    ]
    state, limit = Compliant().prepare(assembly), Limit().prepare(assembly)
    own = state.load_factor(np.hstack(columns))  # every point along its own path
    limit.solve(columns[0][:, 0])
    adaptive = _seconds(lambda: state.load_factor(np.hstack(columns), Within(GAP)))
    single = _seconds(lambda: state.load_factor(np.hstack(columns)))
    other = _seconds(lambda: [limit.solve(column) for W in columns for column in W.T])
    decided = np.array([status is hf.Status.FINITE for status in own.status])
    between = ~result.solved & decided
    off = np.zeros(len(result.force))
    off[between] = np.abs(own.force[between] / result.force[between] - 1)
    some = np.random.default_rng(0).permutation(np.flatnonzero(between))[:CHECKED]
    endless = np.array([status is hf.Status.INFINITE for status in own.status])
    return [
        {
            "case": scene,
            "points": len(off),
            "map s": adaptive[0],
            "paths s": single[0],
            "limit s": other[0],
            "map / limit": adaptive[0] / other[0],
            "paths / limit": single[0] / other[0],
            "map / limit, CPU": adaptive[1] / other[1],
            "solved %": 100 * float(result.solved.mean()),
            "mean error % of 200": 100 * float(off[some].mean()) if len(some) else 0.0,
            "worst error % of 200": 100 * float(off[some].max(initial=0)),
            "worst error % of all": 100 * float(off.max()),
            "interpolated": int((~result.solved).sum()),
            "beyond stated": int((off > result.error)[between].sum()),
            "lower above own path": int((result.lower > own.force)[between].sum()),
            "endless without path": int((~result.solved & endless).sum()),
            "own path undecided": int((~result.solved & ~decided & ~endless).sum()),
        }
    ]


SUITE = Suite("compliant_maps", __doc__ or "", cases)
