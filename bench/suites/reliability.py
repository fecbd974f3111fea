"""How often engine ``compliant`` decides, over random pushes on shipped and on settled scenes, beside ``limit``."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path

import numpy as np

import holdfast as hf
from bench.checkout import CASES
from bench.suite import Case, Row, Suite, table
from holdfast.base.arrays import Float
from holdfast.geometry.cells import Cells, surface_cells
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene, shipped_scenes

SETTLED: Mapping[str, Mapping[str, float]] = {
    "jenga12": {"gap": 5e-4},
    "lack_table": {"gap": 1e-3},
    "leaning": {"gap": 3e-3},
    "beam_frame": {"gap": 3e-3},
    "kitchen_place": {"gap": 3e-3, "angle_degrees": 3},
    "masonry_wall": {},
}
PER_SCENE = 77  # 1,001 over the thirteen that stand of fourteen shipped scenes
PER_SETTLED = 50
SEED = 77


def random_pushes(assembly: hf.answers.Assembly, count: int, seed: int) -> Float:
    """Load columns of random directions, inward, at random points of random movable bodies."""

    @cache
    def cells_of(number: int) -> Cells:
        surface = assembly.movable[number].surface_world
        return surface_cells(surface, float(np.ptp(surface.vertices, axis=0).max()) / 8)

    rng = np.random.default_rng(seed)
    columns = []
    for _ in range(count):
        number = int(rng.integers(len(assembly.movable)))
        cells = cells_of(number)
        k = int(rng.integers(len(cells.points)))
        direction = rng.normal(size=3)
        direction *= -np.sign(direction @ cells.normals[k]) / np.linalg.norm(direction)
        columns.append(push_columns(assembly, number, cells.points[k][None], direction[None])[:, 0])
    return np.array(columns).T


def one(case: str, assembly: hf.answers.Assembly, count: int) -> Row:
    W = random_pushes(assembly, count, SEED)
    start = time.perf_counter()
    state = hf.Compliant().prepare(assembly)
    ready = time.perf_counter() - start
    if state.verdict().status is not hf.Status.STABLE:
        return {"case": case, "verdict": str(state.verdict().status), "pushes": 0}
    start = time.perf_counter()
    found = state.load_factor(W)
    spent = time.perf_counter() - start
    certain = hf.Limit().prepare(assembly).load_factor(W)
    finite = np.isfinite(found.force) & np.isfinite(certain.force) & (certain.force > 0)
    ratio = found.force[finite] / certain.force[finite]
    return {
        "case": case,
        "verdict": str(state.verdict().status),
        "pushes": count,
        "undecided": sum(status is hf.Status.UNDECIDED for status in found.status),
        "above limit": int((found.force > certain.upper * (1 + 1e-6)).sum()),
        "median of compliant over limit": float(np.median(ratio)) if len(ratio) else None,
        "least": float(ratio.min()) if len(ratio) else None,
        "verdict s": ready,
        "push s": spent / count,
    }


def shipped(name: str) -> list[Row]:
    return [one(name, hf.assemble(shipped_scene(name)), PER_SCENE)]


def settled_file(name: str) -> Path | None:
    """The file of a settled scene, which lies beside the checkout; None where it is absent."""
    path = CASES / "settled" / f"{name}.json"
    return path if path.exists() else None


def settled(name: str, path: Path) -> list[Row]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)  # scans overlap by fractions of a millimetre
        scene = hf.load_scene(path)
        assembly = hf.assemble(scene, gap=SETTLED[name].get("gap"), angle_degrees=SETTLED[name].get("angle_degrees"))
        return [one(f"settled {name}", assembly, PER_SETTLED)]


def cases() -> Mapping[str, Case]:
    found: dict[str, Case] = {name: partial(shipped, name) for name in shipped_scenes()}
    for name in SETTLED:
        path = settled_file(name)
        if path is not None:
            found[f"settled {name}"] = partial(settled, name, path)
    return found


def written(rows: list[Row]) -> str:
    asked, undecided = (sum(row.get(key, 0) for row in rows) for key in ("pushes", "undecided"))
    return f"{table(rows)}\n\n{undecided} of {asked} pushes undecided."


SUITE = Suite("reliability", __doc__, cases, written=written)
