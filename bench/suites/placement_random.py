"""Placements on README's shelf and on random shelves and trays: which way up, how far inside, time limits, drops."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.baselines.drop import Drop
from bench.suite import Case, Row
from bench.suites.placements import dropped
from holdfast.applications.resting_poses import StandingFaces
from holdfast.base.arrays import Float
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped.blocks import at

SEEDS = 12  # plans on README's shelf
BEFORE = 0.1205  # [N] median least push that version 0.1 left with these seeds, engines graph and compliant alike
SCENES = 50  # random scenes of each kind
CHUNK = 10  # number of scenes in a case
BUDGETS = (2.0, 4.0, 8.0)  # [s] time limits, used in turn
INSIDE = 0.01  # [m] how far inside the edges the cup ought to stand
LATE = 1.1  # times its budget that a plan may take
MU = 0.5
DROP_SECONDS = 2.0


def cases() -> Mapping[str, Case]:
    """README's shelf, then random scenes in chunks."""
    shelves = {"README's shelf": readme}
    chunks = range(0, SCENES, CHUNK)
    kinds = {"shelves": shelf, "trays": tray}
    return shelves | {f"{name} {k} to {k + CHUNK - 1}": partial(chunk, name, k) for name in kinds for k in chunks}


def readme_scene() -> tuple[hf.Scene, hf.Body]:
    """The shelf of README with a book and a vase, and the cup."""
    board = hf.Body("shelf", hf.Box((0.6, 0.3, 0.02)), pose=at(0, 0, -0.01), material="oak", fixed=True)
    book = hf.Body("book", hf.Box((0.15, 0.21, 0.03)), mass=0.7, pose=at(-0.1, 0, 0.015))
    vase = hf.Body("vase", hf.Cylinder(0.03, 0.2), mass=0.4, pose=at(0.1, 0, 0.1), material="glass")
    friction = hf.Friction(default=0.5, pairs={("glass", "oak"): 0.3})
    cup = hf.Body("cup", hf.Cylinder(0.035, 0.09), mass=0.25)
    return hf.Scene([board, book, vase], friction, name="shelf"), cup


def readme() -> list[Row]:
    """The cup on README's shelf, SEEDS times with the default budget."""
    scene, cup = readme_scene()
    assembly = hf.assemble(scene)
    hf.plan_placement(assembly, cup, where=hf.Where(supports=["shelf"]))  # compiles
    upright, inside, forces, own, drops = 0, list[float](), list[float](), list[float](), 0
    seconds, worked = list[float](), list[float]()
    for seed in range(SEEDS):
        start, begun = time.perf_counter(), time.process_time()
        p = hf.plan_placement(assembly, cup, where=hf.Where(supports=["shelf"]), search=hf.Search(seed=seed))
        seconds.append(time.perf_counter() - start)
        worked.append(time.process_time() - begun)
        assert p.pose is not None
        assert p.assembly is not None
        upright += bool(p.pose[2, 2] > 1 - 1e-6)
        radius = np.abs(p.assembly.scene.body("cup").surface_world.vertices[:, :2]).max(0)
        inside.append(float((np.array([0.3, 0.15]) - radius).min()))
        forces.append(p.robustness)
        own.append(p.rating.own or 0.0 if p.rating is not None else 0.0)
        fall = dropped(p.assembly, "cup", DROP_SECONDS)
        drops += fall is None or fall.stands
    return [
        {
            "case": "README's shelf",
            "plans": SEEDS,
            "upright": upright,
            "inside": sum(edge >= INSIDE for edge in inside),
            "least edge mm": 1e3 * min(inside),
            "median N": float(np.median(forces)),
            "median over 0.1": float(np.median(forces)) / BEFORE,
            "on the cup N": float(np.median(own)),
            "dropped": SEEDS,
            "stay dropped": drops,
            "median s": float(np.median(seconds)),
            "longest s": max(seconds),
            "median processor s": float(np.median(worked)),
            "load": os.getloadavg()[0],
        }
    ]


def chunk(kind: str, first: int) -> list[Row]:
    """Plans in CHUNK random scenes of one kind, each judged again from the scene alone and dropped in MuJoCo.

    The time limit of a plan is in wall-clock time. Other processes can make plans exceed it, so the rows also have the
    processor time and the load of the machine.
    """
    make = {"shelves": shelf, "trays": tray}[kind]
    found, again, rolling, needless = 0, 0, 0, 0
    taken, worked = list[float](), list[float]()  # shares of their budgets, by wall clock and by processor time
    seconds = list[float]()
    drops = list[Drop]()
    for seed in range(first, first + CHUNK):
        scene, body, asked = make(np.random.default_rng(seed))
        assembly = hf.assemble(scene)
        budget = BUDGETS[seed % len(BUDGETS)]
        start, begun = time.perf_counter(), time.process_time()
        p = hf.plan_placement(
            assembly, body, where=hf.Where(supports=asked), search=hf.Search(seed=seed, seconds=budget)
        )
        seconds.append(time.perf_counter() - start)
        taken.append(seconds[-1] / budget)
        worked.append((time.process_time() - begun) / budget)
        if p.assembly is None or p.rating is None:
            continue
        found += 1
        again += hf.stability(hf.assemble(p.assembly.scene)).status is hf.Status.STABLE
        rolling += int(p.rating.rolls)
        needless += bool(p.rating.rolls) and any(
            face.tilt > 0 and not face.rolls for face in StandingFaces(body).faces()
        )
        fall = dropped(p.assembly, body.name, DROP_SECONDS)
        drops += [] if fall is None else [fall]
    return [
        {
            "case": f"{kind} {first} to {first + CHUNK - 1}",
            "plans": CHUNK,
            "placed": found,
            "stand": again,
            "rolling": rolling,
            "rolling needlessly": needless,
            "dropped": len(drops),
            "stay dropped": sum(fall.stands for fall in drops),
            "worst moved mm": 1e3 * max((fall.moved for fall in drops), default=0.0),
            "late": sum(share > LATE for share in taken),
            "worst time over budget": max(taken),
            "late by processor time": sum(share > LATE for share in worked),
            "worst processor time over budget": max(worked),
            "median s": float(np.median(seconds)),
            "longest s": max(seconds),
            "load": os.getloadavg()[0],
        }
    ]


def thing(rng: np.random.Generator, name: str) -> hf.Body:
    """A box, a tin, a nut or a cone-like prism of 3 to 12 cm."""
    mass = float(rng.uniform(0.05, 0.6))
    kind = rng.integers(4)
    if kind == 0:
        return hf.Body(name, hf.Box(rng.uniform(0.03, 0.12, 3)), mass=mass)
    if kind == 1:
        return hf.Body(name, hf.Cylinder(rng.uniform(0.02, 0.05), rng.uniform(0.04, 0.12)), mass=mass)
    if kind == 2:
        return hf.Body(name, hf.Cylinder(rng.uniform(0.02, 0.05), rng.uniform(0.03, 0.08), 6), mass=mass)
    return hf.Body(name, frustum(float(rng.uniform(0.02, 0.04)), float(rng.uniform(0.03, 0.05)), 0.08), mass=mass)


def frustum(bottom: float, top: float, height: float) -> hf.Mesh:
    """A beaker: a cone cut off at both ends, whose side is round."""
    import manifold3d

    mesh = manifold3d.Manifold.cylinder(height, bottom, top, 48, True).to_mesh64()
    return hf.Mesh(mesh.vert_properties[:, :3], mesh.tri_verts)


def strewn(rng: np.random.Generator, ground: float, half: Float, count: int) -> list[hf.Body]:
    """Up to ``count`` things that stand upright on a level ``ground`` [m], within ``half`` (2,) [m], apart."""
    bodies: list[hf.Body] = []
    for _ in range(4 * count):
        body = thing(rng, f"thing{len(bodies)}")
        angle, place = rng.uniform(0, np.pi), rng.uniform(-1, 1, 2) * (half - 0.07)
        turn = np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
        low = float(body.surface_world.vertices[:, 2].min())
        placed = body.moved(pose_from(np.array([*place, ground - low]), turn))
        if all(
            np.linalg.norm(other.pose[:2, 3] - place) > _radius(other) + _radius(placed) + 0.005 for other in bodies
        ):
            bodies.append(placed)
        if len(bodies) == count:
            break
    return bodies


def _radius(body: hf.Body) -> float:
    """The largest distance [m] of a body's vertices from the vertical through its origin."""
    return float(np.linalg.norm(body.surface_world.vertices[:, :2] - body.pose[:2, 3], axis=1).max())


def shelf(rng: np.random.Generator) -> tuple[hf.Scene, hf.Body, list[str]]:
    """A board with one above it and walls at its ends, some things on it, and one more to be put there."""
    half = np.array([rng.uniform(0.25, 0.45), rng.uniform(0.12, 0.2)])
    room = float(rng.uniform(0.2, 0.4))
    board = hf.Body("board", hf.Box((*2 * half, 0.02)), pose=at(0, 0, -0.01), fixed=True)
    above = hf.Body("above", hf.Box((*2 * half, 0.02)), pose=at(0, 0, room + 0.01), fixed=True)
    walls = [
        hf.Body(name, hf.Box((0.02, 2 * half[1], room + 0.02)), pose=at(x, 0, room / 2), fixed=True)
        for name, x in (("left", -half[0] - 0.01), ("right", half[0] + 0.01))
    ]
    things = strewn(rng, 0.0, half, int(rng.integers(1, 6)))
    return hf.Scene([board, above, *walls, *things], MU, name="shelf"), thing(rng, "object"), ["board"]


def tray(rng: np.random.Generator) -> tuple[hf.Scene, hf.Body, list[str]]:
    """A loose tray on a table, which may jut out over its edge, with some things on it, and one more."""
    half = np.array([rng.uniform(0.18, 0.3), rng.uniform(0.14, 0.22)])
    table = hf.Body("table", hf.Box((1.0, 0.6, 0.05)), pose=at(0.4, 0, -0.025), fixed=True)
    base = hf.Body("tray", hf.Box((*2 * half, 0.015)), mass=0.8, pose=at(rng.uniform(0.0, 0.2), 0, 0.0075))
    shift = at(base.pose[0, 3], 0, 0)
    things = [body.moved(shift @ body.pose) for body in strewn(rng, 0.015, half, int(rng.integers(1, 5)))]
    return hf.Scene([table, base, *things], MU, name="tray"), thing(rng, "object"), ["tray"]
