"""Noisy scenes brought to rest: how many stand, what is left, how far from the true poses, and MuJoCo beside it."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.baselines.mujoco_settling import settled_by_mujoco
from bench.checkout import CASES
from bench.suite import Case, Row, Suite
from bench.truth.falling import falling_scenes
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, HoldfastWarning
from holdfast.contacts.overlap import find_overlaps
from holdfast.contacts.tolerances import Tolerances
from holdfast.engines.verdict import Status
from holdfast.scene.scene import Scene
from holdfast.settling.moved_surfaces import rotation_of

NOISE = ((1.5, 0.5), (3.0, 1.0))  # standard deviations [mm], [deg]
SEEDS = 20
SLOW = ("bonded_wall", "dishes", "lack_table", "leaning", "masonry_wall")  # one to three seconds each
FEWER = dict.fromkeys(SLOW, 10) | {"kitchen_place": 6, "masonry_crossvault": 3}
LEAST = 1e-5  # [m] smaller overlaps are not listed


def noisy(scene: Scene, millimetres: float, degrees: float, seed: int) -> Scene:
    """Return the scene with normal noise on the position and the rotation of each movable body."""
    rng, poses = np.random.default_rng(seed), {}
    for body in scene.movable:
        turn = rotation_of(np.radians(degrees) * rng.normal(size=3))
        pose: Float = body.pose.copy()
        pose[:3, :3] = turn @ pose[:3, :3]
        arm = turn @ (body.pose[:3, 3] - body.com_world)
        pose[:3, 3] = body.com_world + arm + 1e-3 * millimetres * rng.normal(size=3)
        poses[body.name] = pose
    return scene.moved(poses)


def apart(one: Scene, other: Scene) -> Float:
    """Return the distances (J,) [m] of the centres of mass of the movable bodies of two scenes."""
    return np.array([np.linalg.norm(b.com_world - other.body(b.name).com_world) for b in one.movable])


def deepest(scene: Scene) -> float:
    """Return the depth of the deepest overlap [m]."""
    return max((o.depth for o in find_overlaps(scene, Tolerances(LEAST, 1.0))), default=0.0)


def _timed(ask: Callable[[], Scene]) -> tuple[Scene, float]:
    begin = time.process_time()
    found = ask()
    return found, time.process_time() - begin


def from_noise(make: Callable[[], Scene], name: str, millimetres: float, degrees: float) -> list[Row]:
    """Settle the scene from noisy poses, with holdfast and with MuJoCo."""
    true, seeds = make(), FEWER.get(name, SEEDS)
    hf.settle(true)  # compiled and cached from here on
    stable, theirs, seconds, their_seconds, left, off, their_off, noise, moved, their_moved = ([] for _ in range(10))
    again = []
    for seed in range(seeds):
        start = noisy(true, millimetres, degrees, seed)
        begin = time.process_time()
        result = hf.settle(start)
        seconds.append(time.process_time() - begin)
        stable.append(result.status is Status.STABLE)
        if stable[-1]:
            left.append(deepest(result.scene))
            again.append(float(hf.settle(result.scene).moved.max()))
        off.append(float(np.median(apart(result.scene, true))))
        noise.append(float(np.median(apart(start, true))))
        moved.append(float(np.median(result.moved)))
        try:
            simulated, spent = _timed(partial(settled_by_mujoco, start))
        except (HoldfastError, ValueError):  # meshes that MuJoCo does not take
            continue
        their_seconds.append(spent)
        their_off.append(float(np.median(apart(simulated, true))))
        their_moved.append(float(np.median(apart(simulated, start))))
        theirs.append(bool(apart(simulated, true).max() < 0.01 + 3e-3 * millimetres))
    rows: Row = {
        "case": f"{name}, {millimetres:g} mm {degrees:g} deg",
        "seeds": seeds,
        "truth": str(hf.stability(true).status),
        "stable %": 100 * float(np.mean(stable)),
        "overlap left mm": 1e3 * max(left, default=0.0),
        "noise mm": 1e3 * float(np.median(noise)),
        "off true mm": 1e3 * float(np.median(off)),
        "moved mm": 1e3 * float(np.median(moved)),
        "settle s": float(np.median(seconds)),
        "moved again mm": 1e3 * max(again, default=0.0),
    }
    if their_seconds:
        rows |= {
            "mujoco near true %": 100 * float(np.mean(theirs)),
            "mujoco off true mm": 1e3 * float(np.median(their_off)),
            "mujoco moved mm": 1e3 * float(np.median(their_moved)),
            "mujoco s": float(np.median(their_seconds)),
            "mujoco over settle": float(np.median(their_seconds)) / float(np.median(seconds)),
        }
    return [rows]


def at_rest(make: Callable[[], Scene], name: str) -> list[Row]:
    """Settle a scene as it is given, and once more what comes out."""
    scene = make()
    hf.settle(scene)
    begin = time.process_time()
    result = hf.settle(scene)
    seconds = time.process_time() - begin
    again = hf.settle(result.scene)
    return [
        {
            "case": f"{name}, as given",
            "seeds": 1,
            "stable %": 100.0 * (result.status is Status.STABLE),
            "overlap left mm": 1e3 * deepest(result.scene),
            "moved mm": 1e3 * float(result.moved.max()),
            "settle s": seconds,
            "moved again mm": 1e3 * float(again.moved.max()),
            "said": result.reason[:120],
        }
    ]


def falls(number: int) -> list[Row]:
    """Settle a scene that falls."""
    scene, named = falling_scenes()[number]
    result = hf.settle(scene)
    fell = {fall.body: fall for fall in result.fell}
    reported = result.status is Status.UNSTABLE and bool(fell)
    direction = fell[named].direction if named in fell else next(iter(fell.values())).direction if fell else np.zeros(3)
    return [
        {
            "case": f"falls: {scene.name}",
            "seeds": 1,
            "told %": 100.0 * reported,
            "fell": ", ".join(fell),
            "down": float(-direction[2]),
        }
    ]


def _quiet(ask: Callable[..., list[Row]], *arguments: object) -> list[Row]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HoldfastWarning)
        return ask(*arguments)


def cases() -> Mapping[str, Case]:
    """Scenes as given and with noise, then those that fall."""
    scenes: dict[str, Callable[[], Scene]] = {n: partial(hf.shipped_scene, n) for n in hf.sets.shipped_scenes()}
    scenes |= {path.stem: partial(hf.load_scene, path) for path in sorted((CASES / "settled").glob("*.json"))}
    found: dict[str, Case] = {}
    for number, (scene, _) in enumerate(falling_scenes()):
        found[f"falls: {scene.name}"] = partial(_quiet, falls, number)
    for name, make in scenes.items():
        found[f"{name}, as given"] = partial(_quiet, at_rest, make, name)
    for name, make in scenes.items():
        for mm, degrees in NOISE:
            found[f"{name}, {mm:g} mm {degrees:g} deg"] = partial(_quiet, from_noise, make, name, mm, degrees)
    return found


SUITE = Suite("settle", __doc__ or "", cases)
