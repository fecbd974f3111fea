"""A planner's constraint beside single solves of ``limit``: never above, how close, its gradient, calls a second."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.scenes.real_pallets import pallet, pallets
from bench.suite import Case, Row, Suite
from holdfast.base.arrays import Float
from holdfast.base.rigid import wrench_at
from holdfast.engines.groups import prepared
from holdfast.engines.limit_engine import Limit
from holdfast.geometry.cells import surface_cells
from holdfast.queries.sets import wrench_columns
from holdfast.scene.shipped import shipped_scene

BODIES = (
    ("cube", "cube"),
    ("stack", "cube2"),
    ("table", "slab"),
    ("table", "leg_left"),
    ("wall2x2", "b0_0"),
    ("arch", "v3"),
    ("cantilever", "B"),
    ("slope_two", "cube1"),
    ("tabletop", "mug"),
)
PALLETS = (0, 10, 22)  # numbers of pallets, ordered by their boxes; the top box of each is pushed
WRENCHES = 10_000
FEWER = 1_000  # wrenches on assemblies of more bodies than MANY
MANY = 8
STEP = 1e-7  # share of a wrench by which it is changed for a difference
ONCE = 1_000  # calls with a single wrench


def cases() -> Mapping[str, Case]:
    """One case a body."""
    made: dict[str, Case] = {f"{name}: {body}": partial(_shipped, name, body) for name, body in BODIES}
    found = list(enumerate(pallets()))
    return made | {
        f"pallet {k} of {len(boxes)}": partial(_pallet, k, pallet(boxes)) for k, boxes in found if k in PALLETS
    }


def _shipped(name: str, body: str) -> list[Row]:
    return [_row(f"{name}: {body}", hf.assemble(shipped_scene(name)), body)]


def _pallet(number: int, scene: hf.Scene) -> list[Row]:
    assembly = hf.assemble(scene)
    top = assembly.movable[int(assembly.com[:, 2].argmax())].name
    return [_row(f"pallet {number}: {top}", assembly, top)]


def _row(case: str, assembly: hf.answers.Assembly, body: str) -> Row:
    start = time.process_time()
    found = hf.sets.constraint(assembly, body, exists=True)
    built = time.process_time() - start
    count = WRENCHES if len(assembly.movable) <= MANY else FEWER
    wrenches = drawn(assembly, body, found, count)
    start = time.process_time()
    value = np.asarray(found.value(wrenches))
    many = time.process_time() - start
    start = time.process_time()
    for wrench in wrenches[:ONCE]:
        found.value(wrench)
    single = (time.process_time() - start) / min(ONCE, count)
    W = wrench_columns(assembly, body, case) @ wrenches.T
    start = time.process_time()
    answers = prepared(Limit(), assembly).load_factor(W)
    solved = (time.process_time() - start) / count
    finite = np.isfinite(answers.upper) & answers.decided & (answers.force * np.abs(wrenches / found.box).max(1) <= 1)
    short = 1 - value[finite] / answers.force[finite]
    return {
        "case": case,
        "bodies": len(assembly.movable),
        "wrenches": count,
        "within the box": int(finite.sum()),
        "above": int((value > answers.upper * (1 + 1e-12)).sum()),
        "median short %": 100 * float(np.median(short)),
        "90 % short %": 100 * float(np.quantile(short, 0.9)),
        "worst short %": 100 * float(short.max()),
        "gradient off": _gradient(found, wrenches[:300]),
        "known": len(found.price),
        "solves": found.solves,
        "built s": built,
        "calls a second": count / many,
        "single calls a second": 1 / single,
        "a solve ms": 1e3 * solved,
        "calls in a solve": solved * count / many,
    }


def drawn(assembly: hf.answers.Assembly, body: str, found: hf.answers.Constraint, count: int) -> Float:
    """Wrenches (n, 6): half anywhere, in units of what the body takes along the axes, half pushes on its surface."""
    rng = np.random.default_rng(1)
    largest = np.minimum(np.asarray(found.value(np.eye(6))), found.box)
    cells = surface_cells(assembly.scene.body(body).surface_world, assembly.scene.body(body).size / 20)
    chosen = rng.integers(len(cells.points), size=count // 2)
    tilted = -cells.normals[chosen] + 0.3 * rng.normal(size=(len(chosen), 3))
    pushes = wrench_at(tilted, cells.points[chosen], found.com)
    return np.vstack([rng.normal(size=(count - len(pushes), 6)) * largest, pushes])


def _gradient(found: hf.answers.Constraint, wrenches: Float) -> float:
    """The median relative difference between the gradient and a difference of values, along random directions."""
    rng = np.random.default_rng(2)
    towards = rng.normal(size=wrenches.shape) * np.abs(wrenches).max(1, keepdims=True)
    change = np.asarray(found.value(wrenches + STEP * towards)) - np.asarray(found.value(wrenches - STEP * towards))
    along = 2 * STEP * (found.gradient(wrenches) * towards).sum(1)
    return float(np.median(np.abs(change - along) / np.maximum(np.abs(along), 1e-300)))


SUITE = Suite("constraint", __doc__, cases)
