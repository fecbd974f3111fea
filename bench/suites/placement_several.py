"""``place_all`` on trays and pallets beside two rules of the packing literature, which know nothing of what stands.

``highest support`` puts each object, the largest base first, where most of its face is supported, ``bottom-left``
where it is lowest and then farthest into one corner. All of them choose among the same level places, and the rules are
those that ``place_all`` tries too, but for what stands and for wider distances (``placement/several.py``).
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

import holdfast as hf
from bench.suite import Case, Row
from bench.suites.placement_random import MU, thing
from holdfast.applications.placement.comparing import Clock, rated
from holdfast.applications.placement.planner import Planner, planner
from holdfast.applications.placement.result import Candidate
from holdfast.applications.placement.several import POINTS, RULES, Placing, Rule, base_area
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.scene.body import Body
from holdfast.scene.shipped.blocks import at

BUDGET = 300.0  # [s] wall-clock limit of one call of place_all
TRAYS = (10, 15, 20)  # objects on a tray
BOXES = 30  # number of boxes on a pallet
KINDS = ((0.4, 0.3, 0.2), (0.3, 0.2, 0.2), (0.4, 0.2, 0.2), (0.3, 0.3, 0.25))  # [m] nominal sides of the boxes
SLIT = 0.004  # [m] distance between objects
APART = {"tray": 0.005, "pallet": 0.002}  # [m] distance between objects


def cases() -> Mapping[str, Case]:
    """Trays of several numbers of objects, and a pallet, by place_all and by each rule."""
    kinds = [("tray", count) for count in TRAYS] + [("pallet", BOXES)]
    methods = ("place_all", *RULES)
    return {
        f"{kind} of {count}, {method}": partial(run, kind, count, method) for kind, count in kinds for method in methods
    }


def load(kind: str, count: int) -> tuple[hf.Scene, list[Body]]:
    """The empty tray or pallet, and what is to be put on it."""
    rng = np.random.default_rng(count)
    if kind == "tray":
        ground = hf.Body("tray", hf.Box((0.5, 0.35, 0.02)), pose=at(0, 0, -0.01), fixed=True)
        return hf.Scene([ground], MU, name=kind), [thing(rng, f"thing{k:02d}") for k in range(count)]
    ground = hf.Body("pallet", hf.Box((1.2, 0.8, 0.14)), pose=at(0, 0, -0.07), fixed=True)
    sizes = [np.array(KINDS[rng.integers(len(KINDS))]) - SLIT for _ in range(count)]
    boxes = [
        hf.Body(f"box{k:02d}", hf.Box(size), mass=float(size.prod() * rng.uniform(100, 400)))
        for k, size in enumerate(sizes)
    ]
    return hf.Scene([ground], 0.4, name=kind), boxes


def run(kind: str, count: int, method: str) -> list[Row]:
    """Place everything by one method, and judge every state again from its scene."""
    scene, bodies = load(kind, count)
    ground = scene.bodies[0].name
    hf.place_all(scene, bodies[:2], where=hf.Where(apart=APART[kind]))  # compiles
    start, begun = time.perf_counter(), time.process_time()
    if method == "place_all":
        p = hf.place_all(
            scene,
            bodies,
            where=hf.Where(stack=kind == "pallet", apart=APART[kind]),
            approach=hf.sets.Approach(orientations="upright" if kind == "pallet" else None),
            search=hf.Search(seconds=BUDGET),
        )
        poses = [(step.body, step.pose) for step in p.steps]
    else:
        poses = by_rule(hf.assemble(scene), bodies, kind, RULES[method])
    seconds, worked = time.perf_counter() - start, time.process_time() - begun
    named = {body.name: body for body in bodies}
    standing, least = 0, list[float]()
    for k in range(len(poses)):
        state = hf.Scene([*scene.bodies, *(named[name].moved(pose) for name, pose in poses[: k + 1])], scene.friction)
        after = hf.assemble(state)
        standing += hf.stability(after).status is hf.Status.STABLE
        least.append(least_push(after, poses[k][0], ground))
    return [
        {
            "case": f"{kind} of {count}, {method}",
            "objects": count,
            "placed": len(poses),
            "states that stand": standing,
            "least push of all states N": min(least, default=0.0),
            "median over states N": float(np.median(least)) if least else 0.0,
            "time s": seconds,
            "processor time s": worked,
        }
    ]


def by_rule(assembly: Assembly, bodies: Sequence[Body], kind: str, rule: Rule) -> list[tuple[str, Float]]:
    """The poses of all objects that find a place by a rule: nothing overlaps, and whether it stands is not asked."""
    stack, ground = kind == "pallet", assembly.bodies[0].name

    def planner_of(now: Assembly, body: Body) -> Planner:
        supports = [ground, *(b.name for b in now.movable)] if stack else [ground]
        return planner(
            now,
            body,
            where=hf.Where(supports=supports),
            approach=hf.sets.Approach(orientations="upright" if stack else None),
        )

    placing = Placing(planner_of, assembly, (ground,), stack, APART[kind], 0)
    poses = []
    for body in sorted(bodies, key=base_area, reverse=True):
        asked = placing.planner(assembly, body)
        found = placing.places(asked, APART[kind])
        best = min(face.face for face in found) if found else 0
        for spot in sorted((spot for spot in found if spot.face == best), key=rule):
            fault, placed, contacts = asked.checks.fits(spot.pose)
            if not fault:
                assembly = asked.checks.with_object(placed, contacts)
                poses.append((body.name, spot.pose))
                break
    return poses


def least_push(after: Assembly, name: str, ground: str) -> float:
    """The least push [N] on what was placed last and on what it rests on; 0 where that does not stand."""
    if hf.stability(after).status is not hf.Status.STABLE:
        return 0.0
    body = after.scene.body(name)
    asked = planner(after.without([name]), body, where=hf.Where(supports=[ground]))
    found = rated(asked.checks, asked.faces, Candidate(body.pose, *_NONE, ""), after, Clock.started(None), POINTS)
    return found.rating.least or 0.0


_NONE = (np.empty((0, 3)), np.empty((0, 3)))
