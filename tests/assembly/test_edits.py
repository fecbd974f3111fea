"""An assembly that was edited equals what contact detection finds in the edited scene, at the same tolerances."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor


@pytest.mark.parametrize(
    ("name", "gone"), [("tabletop", ["bottle"]), ("tabletop", ["tray", "mug"]), ("arch", ["v3"]), ("wall2x2", ["b0_1"])]
)
@pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")
def test_without_equals_a_new_assembly(name: str, gone: list[str]) -> None:
    scene = shipped_scene(name)
    whole = hf.assemble(scene, gap=5e-4)
    kept = [b for b in scene.bodies if b.name not in gone]
    known = {b.name for b in kept} | {b.material for b in kept}
    left = hf.Scene(kept, scene.friction.among(known), scene.gravity, scene.name)
    assert whole.without(gone) == hf.assemble(left, gap=5e-4)
    assert whole.without(*gone) == whole.without(gone)
    assert whole.without(gone).interfaces[0] in whole.interfaces


def test_two_thin_sheets_taken_away_at_once_uncover_what_both_hid() -> None:
    """Neither of the two foils touches both blocks: each is hidden from one of them by the other."""
    foils = [
        hf.Body(f"foil{k}", hf.Box((0.2, 0.2, 4e-5)), mass=0.01, pose=at(0, 0, 0.1 + (2 + 4 * k) * 1e-5))
        for k in (0, 1)
    ]
    low, high = box("low", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box("high", (0.1, 0.1, 0.1), 1, (0, 0, 0.15 + 8e-5))
    with pytest.warns(hf.errors.HoldfastWarning):
        whole = hf.assemble(hf.Scene([floor(), low, *foils, high], 0.5), gap=1e-4)
    assert whole.without("foil0", "foil1") == hf.assemble(hf.Scene([floor(), low, high], 0.5), gap=1e-4)


def test_friction_of_pairs_that_are_gone_is_forgotten() -> None:
    bodies = [floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1, (0, 0, 0.15))]
    table = hf.Friction(0.5, {("a", "b"): 0.3, ("a", "floor"): 0.2}, {"a": 0.1, "b": 0.2}, "min")
    left = hf.assemble(hf.Scene(bodies, table)).without("b")
    assert left.scene.friction == hf.Friction(0.5, {("a", "floor"): 0.2}, {"a": 0.1}, "min")
    assert left.mu == (0.2,)


def test_given_interfaces_stay_given() -> None:
    scene = shipped_scene("stack")
    found = hf.assemble(scene).interfaces
    left = hf.assemble(scene, interfaces=found).without("cube3")
    assert not left.detected
    assert left.interfaces == found[:2]


def test_an_edited_assembly_keeps_a_gap_that_was_given() -> None:
    scene = shipped_scene("stack")
    small = box("small", (0.01, 0.01, 0.01), 1, (0.3, 0, 0.005))
    given, measured = hf.assemble(scene, gap=3e-4), hf.assemble(scene)
    assert given.with_body(small).tolerances == given.tolerances
    assert measured.with_body(small) == hf.assemble(measured.with_body(small).scene)


def test_a_new_overlap_is_told() -> None:
    whole = hf.assemble(shipped_scene("stack"))
    with pytest.warns(hf.errors.HoldfastWarning, match="'cube1'.*overlap|overlap.*'cube1'"):
        whole.moved({"cube1": whole.scene.body("cube2").pose})


@pytest.mark.filterwarnings("error::holdfast.errors.HoldfastWarning")
def test_an_old_overlap_is_not_told_again() -> None:
    scene = hf.Scene(
        [floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.045)), box("b", (0.1, 0.1, 0.1), 1, (0.5, 0, 0.05))], 0.5
    )
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        whole = hf.assemble(scene)
    assert whole.moved({"b": at(0.6, 0, 0.05)}).overlaps == whole.overlaps


def test_given_interfaces_cannot_be_sought_anew() -> None:
    scene = shipped_scene("stack")
    given = hf.assemble(scene, interfaces=hf.assemble(scene).interfaces)
    with pytest.raises(hf.HoldfastError, match=r"Assembly\.moved: its interfaces were given.*; assemble the changed"):
        given.moved({"cube1": at(1, 0, 0)})
    with pytest.raises(hf.HoldfastError, match=r"Assembly\.with_body: its interfaces were given"):
        given.with_body(box("more", (0.1, 0.1, 0.1), 1, (5, 0, 0.05)))


def test_edits_name_the_body_nearest_to_an_unknown_one() -> None:
    whole = hf.assemble(shipped_scene("stack"))
    for edit in (lambda: whole.moved({"cube4": np.eye(4)}), lambda: whole.without("cube4")):
        with pytest.raises(hf.errors.SceneError, match="no body named 'cube4'; did you mean 'cube3'"):
            edit()
    with pytest.raises(hf.errors.SceneError, match="several bodies are named 'cube1'"):
        whole.with_body(whole.scene.body("cube1"))
    with pytest.raises(hf.errors.SceneError, match="moved: got a list; needs a dict"):
        whole.moved(["cube1"])


def test_groups_are_bodies_that_share_contacts_in_the_order_of_the_scene() -> None:
    size = (0.1, 0.1, 0.1)
    places = {"a": (0, 0, 0.05), "x": (0.3, 0, 0.05), "b": (0, 0, 0.15), "y": (0.3, 0, 0.15), "air": (0, 0, 1)}
    scene = hf.Scene([box(name, size, 1, place) for name, place in places.items()] + [floor()], 0.5)
    whole = hf.assemble(scene)
    assert whole.groups == (("a", "b"), ("x", "y"), ("air",))
    assert whole.hanging == (("air",),)
    assert whole.without("b").groups == (("a",), ("x", "y"), ("air",))
    assert whole.moved({"b": at(0.3, 0, 0.25)}).groups == (("a",), ("x", "b", "y"), ("air",))
