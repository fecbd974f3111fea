"""Move one of 50 bodies and ask one push: an edited assembly beside assembling and asking afresh, by every engine."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import TypeVar

import numpy as np

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.validation.benchmarks.suite import Case, Row, Suite

T = TypeVar("T")
ENGINES = ("graph", "limit", "compliant")
REPEATS = 15
APART = 0.3  # [m] between places on the table


def table(count: int) -> hf.Scene:
    """Unlike things on a table: tins, oranges, single boxes and stacks of three, ``count`` bodies in all."""
    side = int(np.ceil(np.sqrt(count)))
    top = hf.Box((APART * side + 1, APART * side + 1, 0.1))
    bodies = [hf.Body("table", top, pose=_at(APART * side / 2, APART * side / 2, -0.05), fixed=True)]
    place = 0
    while len(bodies) <= count:
        x, y = APART * (place % side), APART * (place // side)
        bodies += _things(place, x, y)[: count + 1 - len(bodies)]
        place += 1
    return hf.Scene(bodies, 0.5)


def _things(place: int, x: float, y: float) -> list[hf.Body]:
    if place % 5 == 0:
        return [hf.Body(f"tin{place}", hf.Cylinder(0.05, 0.12), mass=0.4, pose=_at(x, y, 0.06))]
    if place % 5 == 1:
        return [hf.Body(f"orange{place}", hf.Sphere(0.04), mass=0.2, pose=_at(x, y, 0.04))]
    high = 1 if place % 5 == 2 else 3
    box = hf.Box((0.2, 0.15, 0.1))
    return [hf.Body(f"box{place}_{z}", box, mass=1.0, pose=_at(x + 0.01 * z, y, 0.05 + 0.1 * z)) for z in range(high)]


def pallet(across: int, deep: int, high: int) -> hf.Scene:
    """A dense pallet: one group, all of which has to be solved anew whichever box moves."""
    bodies = [hf.Body("floor", hf.Box((10, 10, 0.1)), pose=_at(0, 0, -0.05), fixed=True)]
    box = hf.Box((0.3, 0.2, 0.15))
    for z in range(high):
        for y in range(deep):
            for x in range(across):
                pose = _at(0.3 * x + 0.1 * (z % 2), 0.2 * y, 0.075 + 0.15 * z)
                bodies.append(hf.Body(f"box{x}_{y}_{z}", box, mass=5.0, pose=pose))
    return hf.Scene(bodies, 0.5)


def _at(x: float, y: float, z: float) -> Float:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def cases() -> Mapping[str, Case]:
    things = {
        f"50 things, {engine}": partial(_measured, "50 things", table(50), "box3_2", engine) for engine in ENGINES
    }
    dense = {"pallet of 50, limit": partial(_measured, "pallet of 50", pallet(5, 5, 2), "box0_0_1", "limit")}
    return things | dense


def _measured(label: str, scene: hf.Scene, name: str, engine: str) -> list[Row]:
    """Processor times, edited and afresh in turn, each time with the body elsewhere; then the same question again."""
    assembly = hf.assemble(scene)
    body = scene.body(name)
    side = body.com_world - [(body.box[1][0] - body.box[0][0]) / 2, 0, 0]

    def shifted(k: int) -> tuple[Float, Float]:
        step = -np.array([4e-3 + 1e-5 * k, 2e-3, 0])  # away from its neighbours
        pose = np.array(body.pose)
        pose[:3, 3] += step
        return pose, side + step

    def ask(edited: hf.Assembly, point: Float) -> hf.Robustness:
        return hf.robustness(edited, name, point, (1.0, 0.0, 0.0), engine=engine)

    times: dict[str, list[float]] = {"edited s": [], "afresh s": [], "moved s": [], "again s": []}
    for k in range(REPEATS + 1):
        pose, point = shifted(k)
        moved = _timed(times["moved s"], partial(assembly.moved, {name: pose}))
        found = _timed(times["edited s"], partial(ask, moved, point))
        times["edited s"][-1] += times["moved s"][-1]
        _timed(times["again s"], partial(ask, moved, point))
        fresh = _timed(times["afresh s"], partial(_afresh, ask, scene.moved({name: pose}), point))
        assert found.force.tobytes() == fresh.force.tobytes(), "an edit changed an answer"
    row: Row = {"case": f"{label}, {engine}", "bodies": len(scene.movable), "groups": len(assembly.groups)}
    row |= {key: float(np.median(taken[1:])) for key, taken in times.items()}  # the first one warms up
    ratios = np.array(times["edited s"][1:]) / np.array(times["afresh s"][1:])
    return [row | {"edited / afresh": float(np.median(ratios))}]


def _afresh(ask: Callable[[hf.Assembly, Float], hf.Robustness], scene: hf.Scene, point: Float) -> hf.Robustness:
    return ask(hf.assemble(scene), point)


def _timed(times: list[float], ask: Callable[[], T]) -> T:
    start = time.process_time()
    found = ask()
    times.append(time.process_time() - start)
    return found


SUITE = Suite("edits", __doc__, cases)
