"""Whatever was edited and asked before, an edited assembly and its answers equal fresh ones, bit for bit."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from edit_scenes import ENGINES, SHARED, anew, answers, pallet, same_contacts, turned

import holdfast as hf
from bench.scenes.shelf import shelf
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box

pytestmark = pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")


def settled(name: str) -> hf.Scene:
    return hf.load_scene(SHARED / "settled" / f"{name}.json")


needed = pytest.mark.skipif(not SHARED.is_dir(), reason=f"needs the case files in {SHARED}")
SCENES: dict[str, Callable[[], hf.Scene]] = {
    "shelf": shelf,
    "tabletop": partial(shipped_scene, "tabletop"),
    "pallet": pallet,
    "scans": partial(settled, "dishes"),
}


def edited(assembly: hf.answers.Assembly, rng: np.random.Generator, step: int) -> hf.answers.Assembly:
    """Move one or two bodies a little, far, or back; take one away; or put one on top of another."""
    bodies = [body for body in assembly.bodies if not isinstance(body.shape, hf.HalfSpace)]
    movable = [body for body in bodies if not body.fixed]
    kind = rng.integers(4)
    if kind == 0 and len(movable) > 3:
        return assembly.without(movable[int(rng.integers(len(movable)))].name)
    if kind == 1:
        under = movable[int(rng.integers(len(movable)))]
        place = (*under.com_world[:2], under.box[1][2] + 0.02)
        return assembly.with_body(box(f"new {step}", (0.05, 0.04, 0.04), 0.1, place))
    chosen = rng.choice(len(bodies), size=int(rng.integers(1, 3)), replace=False)
    poses = {}
    for k in chosen.tolist():
        pose = turned(bodies[k].pose, float(rng.uniform(-2, 2)))
        pose[:3, 3] += rng.uniform(-5e-3, 5e-3, 3) * (1, 1, 0.05) if rng.random() < 0.7 else (3.0, 0.0, 0.0)
        poses[bodies[k].name] = pose
    return assembly.moved(poses)


FAST = ["shelf", "tabletop", pytest.param("pallet", marks=needed)]
SLOW = [pytest.param("scans", marks=[needed, pytest.mark.slow])]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", [*FAST, *SLOW])
def test_contacts_after_random_edits_are_those_of_a_fresh_search(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    assembly = hf.assemble(SCENES[name](), **({"pose_sigma": (0.002, 0.5)} if seed == 2 else {}))
    for step in range(4):
        assembly = edited(assembly, rng, step)
        assert same_contacts(assembly, anew(assembly)), step


@pytest.mark.parametrize(
    ("name", "engine"),
    [
        *itertools.product(["shelf", "tabletop"], ENGINES),
        *(
            pytest.param(*pair, marks=[needed, pytest.mark.slow])
            for pair in itertools.product(["pallet", "scans"], ENGINES[1:])
        ),
    ],
)
def test_answers_after_random_edits_are_those_of_a_fresh_assembly(name: str, engine: str) -> None:
    rng = np.random.default_rng(7)
    assembly = hf.assemble(SCENES[name]())
    for step in range(3):
        names = [body.name for body in assembly.movable][:3]
        answers(assembly, engine, names)  # what edits may take over
        assembly = edited(assembly, rng, step)
        names = [body.name for body in assembly.movable][-3:]
        assert answers(assembly, engine, names) == answers(anew(assembly), engine, names), step


@pytest.mark.parametrize("level", [0.4, 0.7])
@pytest.mark.parametrize("sheet_first", [True, False])
@pytest.mark.parametrize("box_first", [True, False])
def test_a_sheet_hides_and_bares_what_two_bodies_share_though_one_of_them_touches_it_nowhere(
    level: float, sheet_first: bool, box_first: bool
) -> None:
    """Floor and sheet are fixed, so nobody asks how they touch; the box is 1.9 mm above the floor.

    The sheet lies ``level`` of the way down from the box, and hides half of the floor from it.
    """
    gap, above, thick = 2e-3, 1.9e-3, 2e-4
    floor = hf.Body("floor", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True)
    box = hf.Body("box", hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=at(0, 0, above + 0.05))
    top = above * (1 - level)
    sheet = hf.Body("sheet", hf.Box((0.1, 0.2, thick)), pose=at(0.05, 0, top - thick / 2), fixed=True)
    pair = [box, floor] if box_first else [floor, box]
    assembly = hf.assemble(hf.Scene([sheet, *pair] if sheet_first else [*pair, sheet], 0.5), gap=gap)

    def seen(now: hf.answers.Assembly) -> float:
        return sum(i.area for i in now.interfaces if set(i.bodies) == {"floor", "box"})

    assert seen(assembly) == pytest.approx(0.005)
    away = assembly.moved({"sheet": at(0.3, 0, top - thick / 2)})
    assert seen(away) == pytest.approx(0.01)
    assert same_contacts(away, anew(away))
    back = away.moved({"sheet": at(0.05, 0, top - thick / 2)})
    assert same_contacts(back, assembly)
    assert seen(assembly.without("sheet")) == pytest.approx(0.01)


def test_what_did_not_change_stays_the_same_object() -> None:
    whole = hf.assemble(shelf())
    pose = np.array(whole.scene.body("orange").pose)
    pose[0, 3] += 0.01
    moved = whole.moved({"orange": pose})
    before = {i.bodies: i for i in whole.interfaces}
    changed = [i.bodies for i in moved.interfaces if before.get(i.bodies) is not i]
    assert changed == [("board", "orange")]
    assert all(one is other for one, other in zip(moved.bodies, whole.bodies, strict=True) if one.name != "orange")


def test_a_half_space_that_is_seen_no_further_stays_the_same_body() -> None:
    scene = shelf()
    near = scene.moved({"orange": at(-0.45, 0, 0.07)})
    assert near.body("ground") is scene.body("ground")
    assert scene.moved({"orange": at(-40, 0, 0.07)}).body("ground") is not scene.body("ground")


def test_a_sheet_that_is_pulled_out_uncovers_what_it_hid_and_hides_it_again() -> None:
    """A foil within the gap between two blocks: alone they come within the gap of each other."""
    foil = hf.Body("foil", hf.Box((0.2, 0.2, 4e-5)), mass=0.01, pose=at(0, 0, 0.1 + 2e-5))
    bodies = [hf.Body("floor", hf.Box((2, 2, 0.1)), pose=at(0, 0, -0.05), fixed=True)]
    bodies += [box("low", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), foil, box("high", (0.1, 0.1, 0.1), 1, (0, 0, 0.15 + 4e-5))]
    whole = hf.assemble(hf.Scene(bodies, 0.5), gap=1e-4)
    assert ("low", "high") in whole.occluded
    gone = whole.without("foil")
    assert ("low", "high") in {i.bodies for i in gone.interfaces}
    assert same_contacts(gone, anew(gone))
    aside = whole.moved({"foil": at(0.6, 0, 2e-5)})
    assert ("low", "high") in {i.bodies for i in aside.interfaces}
    assert same_contacts(aside, anew(aside))
    half = aside.moved({"foil": at(0.11, 0, 0.1 + 2e-5)})
    assert any("occluded" in i.flags for i in half.interfaces if i.bodies == ("low", "high"))
    assert same_contacts(half, anew(half))
    assert same_contacts(half.moved({"foil": foil.pose}), whole)
