"""What may be taken out, how to build up, where to push: the answers beside MuJoCo, on scenes, pallets and a tower."""

from __future__ import annotations

import time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping
from functools import cache, partial

import numpy as np

import holdfast as hf
from bench.baselines import mujoco
from bench.baselines.handled import MOVED, pushed, rests_without
from bench.baselines.search import grid_nodes
from bench.checkout import CASES
from bench.scenes.real_pallets import pallet, pallets
from bench.scenes.shelf import shelf
from bench.suite import Case, Row, Suite
from bench.suites.settle import noisy
from holdfast.applications.disassembly.removal import Answer
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.base.errors import HoldfastError, HoldfastWarning
from holdfast.scene.shipped import shipped_scene

SETTLED = CASES / "settled"
SHIPPED = ("cube", "stack", "table", "tall_table", "wall2x2", "slope", "slope_two", "cantilever", "arch", "v_groove")
PALLETS = (0, 2, 6)  # small ones that stand
NODES = 9  # contact nodes of an interface in MuJoCo
PUSHES = 4  # simulated pushes of each effect on a body
BODIES = 4  # bodies of an assembly that are pushed
MORE = 1.6  # a push of so many times the least that moves something
ROLLING = {"shelf of eight": ("orange", "pen")}  # MuJoCo lets them roll off untouched: it is asked without them
NOISE = (1.5, 0.5)  # [mm, deg] standard deviations of the perceived poses
STILL = 0.1  # share of the way of the pushed body that others may go along

Make = Callable[[], hf.Scene]


def cases() -> Mapping[str, Case]:
    """Three cases a scene: removals, the order of building, and pushes."""
    scenes: dict[str, Make] = {name: partial(shipped_scene, name) for name in SHIPPED}
    scenes |= {f"pallet {k}": partial(pallet, boxes) for k, boxes in enumerate(pallets()) if k in PALLETS}
    scenes["shelf of eight"] = shelf
    if (SETTLED / "jenga12.json").is_file():
        scenes["jenga12"] = partial(hf.load_scene, SETTLED / "jenga12.json")
        scenes["leaning, seen"] = partial(_seen_and_settled, "leaning")
    asked = {"removals": _removals, "building": _building, "pushes": _pushes}
    return {f"{name}: {what}": partial(ask, name, make) for name, make in scenes.items() for what, ask in asked.items()}


@cache
def _seen_and_settled(name: str) -> hf.Scene:
    """A scan whose poses were seen with noise of NOISE, come to rest."""
    found = hf.settle(noisy(hf.load_scene(SETTLED / f"{name}.json"), *NOISE, seed=0))
    return found.scene


def _assembled(scene: hf.Scene) -> hf.answers.Assembly:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HoldfastWarning)
        return hf.assemble(scene)


def _refereed(name: str, assembly: hf.answers.Assembly) -> hf.answers.Assembly:
    """The assembly that MuJoCo is asked about: without what it does not hold even if nobody touches anything."""
    gone = [body for body in ROLLING.get(name, ()) if body in assembly.index]
    return assembly.without(gone) if gone else assembly


def _nodes(assembly: hf.answers.Assembly) -> ContactNodes:
    """Contact nodes for MuJoCo: grids where all contacts are rectangles, and what engines take where they are not."""
    try:
        return grid_nodes(assembly, 3)
    except HoldfastError:
        return contact_nodes(assembly, NODES, "quadrature")


def _removals(name: str, make: Make) -> list[Row]:
    """How many bodies may be taken out, and what MuJoCo sees of each: ``unsafe safe`` must be 0."""
    assembly = _assembled(make())
    spent, seen = 0.0, Counter[tuple[str, bool | None]]()
    seen_by = _refereed(name, assembly)
    for body in assembly.movable:
        start = time.process_time()
        found = hf.can_remove(assembly, body.name)
        spent += time.process_time() - start
        if found.blockers and not found.moving:
            seen["blocked", None] += 1
            continue
        rests = rests_without(seen_by, body.name, NODES) if body.name in seen_by.index else None
        seen[str(found.answer), rests] += 1
    safe, unsafe = str(Answer.SAFE), str(Answer.UNSAFE)
    return [
        {
            "case": f"{name}: removals",
            "bodies": len(assembly.movable),
            "safe": sum(n for (answer, _), n in seen.items() if answer == safe),
            "safe, all rest": seen[safe, True],
            "unsafe safe": seen[safe, False],
            "unsafe, something falls": seen[unsafe, False],
            "unsafe, all rest": seen[unsafe, True],
            "blocked alone": seen["blocked", None],
            "undecided": sum(n for (answer, _), n in seen.items() if answer == str(Answer.UNDECIDED)),
            "an answer s": spent / len(assembly.movable),
        }
    ]


def _building(name: str, make: Make) -> list[Row]:
    """The order, whether MuJoCo lets every state rest, and the least push of all states."""
    assembly = _assembled(make())
    start = time.process_time()
    found = hf.build_order(assembly)
    spent = time.process_time() - start
    rests = Counter[bool | None]()
    for k in range(len(found.order)):
        state = _refereed(name, assembly.without(list(found.order[k + 1 :])))
        rests[mujoco.holds(state, None, _nodes(state)).holds] += 1
    least = found.least
    return [
        {
            "case": f"{name}: building",
            "bodies": len(assembly.movable),
            "steps": len(found.order),
            "reached": str(found.reached),
            "states that rest": rests[True],
            "unsafe safe": rests[False],
            "least push N": float("nan") if least is None or least.weakest is None else least.weakest.force,
            "after": "" if least is None else least.body,
            "an answer s": spent,
        }
    ]


def _pushes(name: str, make: Make) -> list[Row]:
    """Pushes on some bodies, each with a force somewhat above the least: what is called safe is simulated."""
    assembly = _assembled(make())
    seen_by = _refereed(name, assembly)
    world = mujoco.World(seen_by, _nodes(seen_by))
    rng = np.random.default_rng(0)
    spent, count, seen = 0.0, Counter[str](), Counter[str]()
    bodies = rng.permutation([body.name for body in seen_by.movable])[:BODIES].tolist()
    for body in bodies:
        force = 0.5 * MORE * float(np.linalg.norm(assembly.weight_wrench().reshape(-1, 6)[assembly.index[body], :3]))
        start = time.process_time()
        try:
            found = hf.safe_pushes(assembly, body, force)
        except HoldfastError:
            continue
        spent += time.process_time() - start
        count.update(str(effect) for effect in found.effect)
        for effect in (hf.answers.Effect.ALONE, hf.answers.Effect.NOTHING, hf.answers.Effect.OTHERS):
            among = found.are(effect).nonzero()[0]
            for k in rng.permutation(among)[:PUSHES].tolist():
                gone = pushed(world, body, found.points[k], found.directions[k], force)
                seen[f"{effect}: {_seen(effect, gone.own, gone.others)}"] += 1
    return [
        {
            "case": f"{name}: pushes",
            "bodies": len(bodies),
            "pushes": count.total(),
            **{str(effect): count[str(effect)] for effect in hf.answers.Effect},
            "simulated": seen.total(),
            "alone, so seen": seen["alone: so"],
            "nothing, so seen": seen["nothing: so"],
            "others, so seen": seen["others: so"],
            "others, not seen": seen["others: not"],
            "unsafe safe": seen["alone: not"] + seen["nothing: not"],
            "an answer s": spent / max(len(bodies), 1),
        }
    ]


def _seen(effect: hf.answers.Effect, own: float, others: float) -> str:
    """Whether the ways [m] of the pushed body and of the others are as the effect says."""
    if effect is hf.answers.Effect.NOTHING:
        return "so" if max(own, others) <= MOVED else "not"
    if effect is hf.answers.Effect.ALONE:
        return "so" if own > MOVED and others <= STILL * own else "not"
    return "so" if others > STILL * own else "not"


SUITE = Suite("questions", __doc__, cases)
