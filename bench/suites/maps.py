"""Certified maps of ``limit`` beside the same engine's fastest single query (one program, re-used) on every point."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import trimesh

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.base.arrays import Float
from holdfast.engines.limit.proof import LoadProgram, SolvedLoad
from holdfast.engines.limit_engine import Limit
from holdfast.queries.request import push_columns
from holdfast.scene.shipped import shipped_scene

CASES = (("cube", "cube"), ("stack", "cube3"), ("table", "slab"), ("table", "leg_left"))
POINTS = 6000
GAP = 0.01
SAMPLE = 600  # single queries timed; each point costs the same
CHECKED = 200
RUNS = 3


def cases() -> Mapping[str, Case]:
    boxes: dict[str, Case] = {f"{scene}: {body}": partial(_box, scene, body) for scene, body in CASES}
    return boxes | {f"{name}, 5,120 faces": partial(_round, name) for name in ROUND}


def _box(scene: str, body: str) -> list[Row]:
    assembly = hf.assemble(shipped_scene(scene))
    surface = assembly.scene.body(body).surface_world
    area = trimesh.Trimesh(surface.vertices, surface.faces).area
    return [_row(f"{scene}: {body}", assembly, body, float(np.sqrt(area / POINTS / 1.12)))]


def _round(name: str) -> list[Row]:
    return [_row(f"{name}, 5,120 faces", ROUND[name](), "body", 0.0035)]


def _row(name: str, assembly: hf.answers.Assembly, body: str, spacing: float) -> Row:
    hf.robustness_map(assembly, [body], spacing=4 * spacing, engine="limit")
    original, solves = LoadProgram.maximise, [0]

    def counted(program: LoadProgram, load: Float, around: float | None = None) -> SolvedLoad:
        solves[0] += 1
        return original(program, load, around)

    LoadProgram.maximise = counted  # type: ignore[method-assign,assignment]
    seconds = []
    for _ in range(RUNS):
        solves[0] = 0
        start = time.perf_counter()
        result = hf.robustness_map(assembly, [body], spacing=spacing, engine="limit", accuracy=GAP)
        seconds.append(time.perf_counter() - start)
    LoadProgram.maximise = original  # type: ignore[method-assign]
    count = len(result.force)
    state = Limit().prepare(assembly)
    picked = np.random.default_rng(0).choice(count, min(SAMPLE, count), replace=False)
    columns = push_columns(assembly, assembly.index[body], result.points[picked], -result.normals[picked])
    start = time.perf_counter()
    exact = np.array([state.solve(column).factor for column in columns.T])
    single = (time.perf_counter() - start) / len(picked)
    low, high = result.lower[picked][:CHECKED] * (1 - 1e-6), result.upper[picked][:CHECKED] * (1 + 1e-6)
    finite = np.isfinite(result.upper)
    median = float(np.median(seconds))
    return {
        "case": name,
        "points": count,
        "map s": median,
        "solves": solves[0],
        "solves a point": solves[0] / count,
        "µs a point": 1e6 * median / count,
        "single query µs": 1e6 * single,
        "times less": single * count / median,
        "outside of 200": int(((exact[:CHECKED] < low) | (exact[:CHECKED] > high)).sum()),
        "largest gap": float((1 - result.lower[finite] / result.upper[finite]).max()),
    }


def _standing(
    mesh: trimesh.Trimesh, height: float, interfaces: list[hf.answers.Interface] | None
) -> hf.answers.Assembly:
    pose = np.eye(4)
    pose[2, 3] = height
    floor = shipped_scene("cube").body("floor")
    scene = hf.Scene([floor, hf.Body("body", mesh, mass=1, pose=pose)], 0.5)
    return hf.assemble(scene, interfaces=interfaces)


def _cylinder() -> hf.answers.Assembly:
    mesh = trimesh.creation.cylinder(0.05, 0.2, sections=80)
    while len(mesh.faces) < 5000:
        mesh = mesh.subdivide()
    return _standing(mesh, 0.1, None)


def _sphere() -> hf.answers.Assembly:
    """A ball with a worn foot: detection finds no flat contact on a sphere, so it is given."""
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    foot = 0.02 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(32)])
    return _standing(
        trimesh.creation.icosphere(4, 0.05), 0.05, [hf.answers.Interface(("floor", "body"), foot, (0, 0, 1))]
    )


ROUND: Mapping[str, Callable[[], hf.answers.Assembly]] = {"cylinder": _cylinder, "sphere": _sphere}
SUITE = Suite("maps", __doc__, cases)
