"""Simulators and the paper's optimisation beside the engines on a few pushes, and polygon cones by two solvers."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from itertools import groupby

import numpy as np
from scipy import sparse
from scipy.optimize import Bounds, LinearConstraint, milp

import holdfast as hf
from bench.baselines import Answers, optimised, simulated
from bench.suite import Case, Row, Suite, table
from holdfast.base.arrays import Float
from holdfast.engines.forces import FrictionCone, force_program, scaled_wrench
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import wall

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
DOWN = (0.0, 0.0, -1.0)

# name, body, point [m], direction; pushes on one body must be adjacent
PUSHES = {
    "cube": (
        ("low", "cube", (-0.05, 0, 0.02), X),
        ("at the top", "cube", (-0.05, 0, 0.1), X),
        ("off centre", "cube", (-0.05, 0.04, 0.03), X),
        ("lifted", "cube", (0, 0, 0.1), Z),
        ("pressed", "cube", (0.02, 0.01, 0.1), DOWN),
    ),
    "stack": (
        ("top cube", "cube3", (-0.05, 0, 0.29), X),
        ("top cube, off centre", "cube3", (-0.05, 0.04, 0.22), X),
        ("middle cube", "cube2", (-0.05, 0, 0.11), X),
        ("bottom cube, off centre", "cube1", (0.03, -0.05, 0.03), Y),
        ("pressed", "cube3", (0.02, 0.01, 0.3), DOWN),
    ),
    "table": (
        ("sways", "slab", (-0.25, 0, 0.225), X),
        ("long side, at the end", "slab", (0.22, -0.1, 0.225), Y),
        ("lifted at the end", "slab", (0.25, 0, 0.225), Z),
        ("pressed at the end", "slab", (0.25, 0, 0.25), DOWN),
        ("leg", "leg_left", (-0.2, 0.06, 0.05), X),
    ),
}
SIDES = (4, 8)
WALLS = ((2, 2), (4, 4), (8, 3), (9, 5))  # courses and bricks
QUERIES = 12  # pushes a wall, drawn at random

Method = Callable[[hf.answers.Assembly, str, Float, Float], hf.answers.Robustness | Answers]


def methods() -> dict[str, Method]:
    """Every method under its name in the tables."""
    found: dict[str, Method] = {"compliant": partial(hf.robustness, engine="compliant")}
    found["limit"] = partial(hf.robustness, engine="limit")
    found |= {f"limit, {n} sides": partial(hf.robustness, engine=hf.Limit("inscribed", n)) for n in SIDES}
    found |= {f"IPOPT, {n} sides": partial(optimised, sides=n) for n in SIDES}
    found["PyBullet, printed"] = partial(simulated, engine="pybullet", protocol="printed")
    found["PyBullet, held"] = partial(simulated, engine="pybullet")
    found["LMGC90, held"] = partial(simulated, engine="lmgc90")
    found["MuJoCo, held"] = partial(simulated, engine="mujoco")
    return found


def cases() -> Mapping[str, Case]:
    """One case a scene and method, one a wall."""
    found = {
        f"{scene}, {name}": partial(_pushed, scene, name, method)
        for scene in PUSHES
        for name, method in methods().items()
    }
    return found | {f"wall of {c} x {b}": partial(_polygons, c, b) for c, b in WALLS}


def _pushed(scene: str, name: str, method: Method) -> list[Row]:
    """The forces of one method, and its time a push with what is set up once a body."""
    assembly = hf.assemble(shipped_scene(scene))
    first = PUSHES[scene][0]
    if not name.startswith(("LMGC90", "MuJoCo")):  # compiled and loaded before the clock starts
        method(assembly, first[1], np.array(first[2]), np.array(first[3]))
    rows: list[Row] = []
    for body, group in groupby(PUSHES[scene], key=lambda push: push[1]):
        pushes = list(group)
        begin = time.perf_counter()
        found = method(assembly, body, np.array([p[2] for p in pushes]), np.array([p[3] for p in pushes]))
        each = (time.perf_counter() - begin) / len(pushes)
        for push, force, status in zip(pushes, found.force, found.status, strict=True):
            case = f"{scene}, {push[0]}, {name}"
            row: Row = {"case": case, "scene": scene, "push": push[0], "method": name}
            rows.append(row | {"force": force, "status": str(status), "push s": each})
    return rows


def _polygons(courses: int, bricks: int) -> list[Row]:
    """Polygon cones of one wall by Clarabel (engine ``limit``) and by HiGHS, on the same program."""
    assembly = hf.assemble(wall(courses, bricks, 0.25, "wall"))
    random = np.random.default_rng(20261121)
    rows: list[Row] = []
    for sides in SIDES:
        state = hf.Limit("inscribed", sides).prepare(assembly)
        base = force_program(assembly, state.rest.nodes, state.wrench, FrictionCone("inscribed", sides))
        equations = len(state.wrench)
        cost = np.append(np.zeros(base.A.shape[1]), -1.0)
        low = np.append(base.b[:equations], np.full(len(base.b) - equations, -np.inf))
        times, apart = np.zeros(2), 0.0
        state.solve(state.wrench)
        for _ in range(QUERIES):
            number = int(random.integers(len(assembly.movable)))
            along = random.normal(size=(1, 3)) * (1, 1, 0)
            load = push_columns(assembly, number, assembly.com[number][None], along / np.linalg.norm(along))[:, 0]
            begin = time.perf_counter()
            ours = state.solve(load).factor
            between = time.perf_counter()
            column = sparse.csr_matrix(
                np.r_[scaled_wrench(assembly, state.rest.nodes, load), np.zeros(len(base.b) - equations)][:, None]
            )
            whole = sparse.csr_matrix(sparse.hstack([base.A, column]))
            found = milp(cost, bounds=Bounds(-np.inf, np.inf), constraints=LinearConstraint(whole, low, base.b))
            times += (between - begin, time.perf_counter() - between)
            theirs = -found.fun if found.status == 0 else np.inf
            apart = max(apart, 0.0 if ours == theirs else abs(theirs / ours - 1))
        case = f"wall of {courses} x {bricks}, {sides} sides"
        row: Row = {"case": case, "bodies": courses * bricks, "Clarabel s": times[0] / QUERIES}
        rows.append(row | {"HiGHS s": times[1] / QUERIES, "apart": apart})
    return rows


def written(rows: list[Row]) -> str:
    """Forces, times, and the two solvers."""
    pushed = [row for row in rows if "method" in row]
    forces: dict[str, Row] = {}
    times: dict[str, dict[str, list[float]]] = {}
    for row in pushed:
        line = forces.setdefault(f"{row['scene']}, {row['push']}", {"push": f"{row['scene']}, {row['push']}"})
        line[row["method"]] = float(row["force"]) if row["status"] in ("finite", "infinite") else row["status"]
        times.setdefault(row["method"], {}).setdefault(row["scene"], []).append(row["push s"])
    seconds = [{"method": m} | {s: float(np.mean(values)) for s, values in t.items()} for m, t in times.items()]
    solvers = [row for row in rows if "method" not in row]
    return "\n\n".join(
        (
            "Forces [N]; inf: nothing moved, or no bound.",
            table(list(forces.values())),
            "Seconds a push, five pushes together.",
            table(seconds),
            "Polygon cones by two solvers, seconds a push, and the largest relative difference of their answers.",
            table(solvers),
        )
    )


SUITE = Suite("baselines", __doc__, cases, written=written)
