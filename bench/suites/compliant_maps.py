"""Maps of ``compliant`` beside as many single ``limit`` solves, and 200 of their points asked alone."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.limit_engine import Limit
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
CHECKED = 200
RUNS = 3


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
    result = hf.robustness_map(assembly, spacing=spacing)
    W = np.hstack(
        [
            push_columns(assembly, assembly.index[name], cells.points, -cells.normals)
            for name, cells in result.cells.items()
        ]
    )
    state, limit = Compliant().prepare(assembly), Limit().prepare(assembly)
    for warm in (state, limit):
        warm.load_factor(W[:, :1])
    together = _seconds(lambda: state.load_factor(W))
    other = _seconds(lambda: [limit.solve(column) for column in W.T])
    some = np.random.default_rng(0).permutation(len(result.force))[:CHECKED]
    alone = [hf.robustness(assembly, result.body[k], result.points[k], -result.normals[k]) for k in some]
    force, lower = (np.array([float(getattr(one, name)[0]) for one in alone]) for name in ("force", "lower"))
    finite = np.isfinite(force) & (force > 0)
    return [
        {
            "case": scene,
            "points": len(result.force),
            "map s": together[0],
            "limit s": other[0],
            "ms a point, CPU": 1e3 * together[1] / len(result.force),
            "map / limit": together[0] / other[0],
            "map / limit, CPU": together[1] / other[1],
            "largest % off alone": 100 * float(np.abs(result.force[some] / force - 1)[finite].max()),
            "lower above alone": int((result.lower[some] > force * (1 + 1e-9)).sum()),
            "other lower alone": int((np.abs(result.lower[some] / lower - 1)[finite & (lower > 0)] > 1e-9).sum()),
        }
    ]


SUITE = Suite("compliant_maps", __doc__ or "", cases)
