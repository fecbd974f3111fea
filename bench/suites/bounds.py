"""Bounds of engine `limit`: ill-conditioned scenes against 50 digits, the width on sane scenes, and the cost."""

from __future__ import annotations

import time
from collections.abc import Mapping
from decimal import Decimal
from functools import partial

import numpy as np

from bench.scenes.ill_conditioned import FAMILIES, queries
from bench.scenes.random_pushes import columns, random_pushes
from bench.suite import Case, Row, Suite, table
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import Float
from holdfast.engines.limit.limit_state import LimitState
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box
from holdfast.scene.shipped import shipped_scene

QUERIES = 250  # number of queries of each ill-conditioned family
NARROW = 1e-6  # relative width below which bounds count as a number
SEED = 5
PUSHES = 24  # number of pushes on each scene whose cost is measured
RUNS = 9
SCENES = ("cube", "stack", "table", "arch", "wall2x2", "tabletop")
LAYERS, SIDE = 3, 3  # layers of the pallet and boxes along a side: 27 boxes


def ill_conditioned(family: str) -> list[Row]:
    """Compare the bounds of random queries of a family with the truth."""
    rng = np.random.default_rng([SEED, list(FAMILIES).index(family)])
    outside = undecided = estimated = 0
    widths = []
    state = None
    for query in queries(family, rng, QUERIES):
        if state is None or state.assembly is not query.assembly:
            state = Limit().prepare(query.assembly)
        found = state.load_factor(query.load[:, None])
        lower, upper = Decimal(float(found.lower[0])), Decimal(float(found.upper[0]))
        outside += not lower <= query.truth <= upper
        undecided += found.status[0] is Status.UNDECIDED
        estimated += found.lower_bound != "proved" or found.upper_bound != "proved"
        widths.append(float((upper - lower) / query.truth))
    row: Row = {"case": f"ill-conditioned: {family}", "queries": len(widths), "truth outside": outside}
    row |= {"undecided": undecided, "estimated": estimated, "narrow": int((np.array(widths) <= NARROW).sum())}
    return [row | {"median width": float(np.median(widths))}]


def pallet() -> Assembly:
    """27 boxes of different masses in three layers, the upper ones shifted against the lower ones."""
    rng = np.random.default_rng(SEED)
    bodies = [Body("floor", Box((10, 10, 0.1)), pose=_at((0, 0, -0.05)), fixed=True)]
    for layer in range(LAYERS):
        for k in range(SIDE * SIDE):
            place = np.array([0.4 * (k % SIDE) + 0.1 * layer, 0.3 * (k // SIDE) + 0.05 * layer, 0.1 + 0.2 * layer])
            body = Body(f"box{layer}{k}", Box((0.4, 0.3, 0.2)), mass=float(rng.uniform(2, 30)), pose=_at(place))
            bodies.append(body)
    return assemble(Scene(bodies, 0.4))


def _at(place: tuple[float, float, float] | Float) -> Float:
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose


def cost(name: str) -> list[Row]:
    """Measure the processor time of proofs beside that of the solves, for many pushes together and for each alone."""
    assembly = pallet() if name == "pallet" else assemble(shipped_scene(name))
    state = Limit().prepare(assembly)
    W = columns(assembly, random_pushes(assembly, np.random.default_rng(SEED), PUSHES, slant=60))
    answers = state.load_factor(W)
    times = np.array([_times(state, W) for _ in range(RUNS)])
    finite = answers.status == Status.FINITE
    width = (answers.upper - answers.lower)[finite] / answers.upper[finite]
    return [
        {
            "case": f"cost: {name}",
            "bodies": len(assembly.movable),
            "finite": int(finite.sum()),
            "median width": float(np.median(width)),
            "widest": float(width.max()),
            "solve s": float(np.median(times[:, 0]) / PUSHES),
            "proof / solve": float(np.median(times[:, 1] / times[:, 0])),
            "proof / solve, alone": float(np.median(times[:, 2] / times[:, 0])),
        }
    ]


def _times(state: LimitState, W: Float) -> tuple[float, float, float]:
    """Processor times [s] of all solves, of their proofs together, and of their proofs one by one."""
    proofs = state.proofs
    start = time.process_time()
    solved = [proofs.program.maximise(load) for load in W.T]
    after = time.process_time()
    proofs.judged(solved, W)
    together = time.process_time()
    for k, one in enumerate(solved):
        proofs.judged([one], W[:, k : k + 1])
    return after - start, together - after, time.process_time() - together


def cases() -> Mapping[str, Case]:
    hard = {f"ill-conditioned: {family}": partial(ill_conditioned, family) for family in FAMILIES}
    return hard | {f"cost: {name}": partial(cost, name) for name in (*SCENES, "pallet")}


def written(rows: list[Row]) -> str:
    """Return one table for the ill-conditioned queries and one for the cost."""
    hard = [row for row in rows if row["case"].startswith("ill")]
    return "\n\n".join([table(hard), table([row for row in rows if row not in hard])])


SUITE = Suite("bounds", __doc__, cases, written=written)
