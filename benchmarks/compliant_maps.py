"""Maps of ``compliant`` beside one path a point and as many single ``limit`` solves; its single pushes on walls."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import holdfast as hf
from holdfast.arrays import Float
from holdfast.engines.compliant.engine import Compliant, CompliantState, Paths
from holdfast.engines.limit.engine import Limit
from holdfast.robustness.request import push_columns
from holdfast.shipped import shipped_scene
from holdfast.shipped.blocks import wall

SCENES = (("cube", 0.0073), ("stack", 0.0118), ("table", 0.0233))  # spacings [m] for about 1,000 points
WALLS = ((2, 2), (4, 2), (4, 4), (8, 3), (9, 5), (19, 5), (29, 7))
GAP = 0.01
CHECKED = 200
RUNS = 3
HEADS = (
    "points",
    "map s",
    "paths s",
    "limit s",
    "map / limit",
    "paths / limit",
    "paths a point",
    "solves a point",
    "mean error %",
    "worst error %",
    "undecided of 200",
    "beyond stated of 200",
    "query s",
    "limit query s",
)


def measure() -> list[dict[str, Any]]:
    rows = [_map(scene, spacing) for scene, spacing in SCENES] + [_wall(*shape) for shape in WALLS]
    return [{"case": row["case"]} | {head: row.get(head, "") for head in HEADS} for row in rows]


def _seconds(work: Callable[[], object]) -> float:
    spent = []
    for _ in range(RUNS):
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return float(np.median(spent))


def _map(scene: str, spacing: float) -> dict[str, Any]:
    assembly = hf.assemble(shipped_scene(scene))
    result = hf.robustness_map(assembly, None, spacing, engine="compliant", gap=GAP)
    names = list(dict.fromkeys(result.body))
    columns = [
        push_columns(assembly, assembly.index[name], result.points[here], -result.normals[here])
        for name in names
        for here in [result.body == name]
    ]
    state, limit = Compliant().prepare(assembly), Limit().prepare(assembly)
    solves, paths = _counted(state, columns)
    count = len(result.force)
    adaptive = _seconds(lambda: [state.load_factor(W, GAP) for W in columns])
    single = _seconds(lambda: [state.load_factor(W) for W in columns])
    other = _seconds(lambda: [limit.solve(column) for W in columns for column in W.T])
    between = np.flatnonzero(~result.solved & np.isfinite(result.force))
    between = np.random.default_rng(0).permutation(between)[:CHECKED]
    again = state.load_factor(np.hstack(columns)[:, between])
    decided = np.array([status is not hf.Status.UNDECIDED for status in again.status])
    between = between[decided]
    error = np.abs(again.factor[decided] / result.force[between] - 1)
    return {
        "case": scene,
        "points": count,
        "map s": adaptive,
        "paths s": single,
        "limit s": other,
        "map / limit": adaptive / other,
        "paths / limit": single / other,
        "paths a point": paths / count,
        "solves a point": solves / count,
        "mean error %": 100 * float(error.mean()),
        "worst error %": 100 * float(error.max()),
        "undecided of 200": int((~decided).sum()),
        "beyond stated of 200": int((error > result.error[between]).sum()),
    }


def _counted(state: CompliantState, columns: list[Float]) -> tuple[int, int]:
    """Linear systems solved and paths followed for the adaptive maps (without those for the lower estimates)."""
    original, total = CompliantState.paths, np.zeros(2)

    def counted(self: CompliantState, W: Float, *, cuts: bool = False) -> Paths:
        found = original(self, W, cuts=cuts)
        if self is state:
            total[:] += found.solves.sum(), W.shape[1]
        return found

    CompliantState.paths = counted  # type: ignore[method-assign]
    for W in columns:
        state.load_factor(W, GAP)
    CompliantState.paths = original  # type: ignore[method-assign]
    return int(total[0]), int(total[1])


def _wall(courses: int, bricks: int) -> dict[str, Any]:
    assembly = hf.assemble(wall(courses, bricks, 0.25, "wall"))
    body = f"b{courses - 1}_{bricks - 1}"
    at = assembly.scene.body(body).pose[:3, 3]
    push = push_columns(assembly, assembly.index[body], (at - [0, 0.05, 0])[None], np.array([[0.0, 1, 0]]))
    state, limit = Compliant().prepare(assembly), Limit().prepare(assembly)
    state.paths(push), limit.solve(push[:, 0])
    return {
        "case": f"wall {courses} x {bricks}",
        "points": 1,
        "query s": _seconds(lambda: state.paths(push)),
        "limit query s": _seconds(lambda: limit.solve(push[:, 0])),
        "solves a point": int(state.paths(push).solves[0]),
    }
