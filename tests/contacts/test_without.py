"""An assembly without some bodies equals what contact detection finds without them."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.assembly.nodes import contact_nodes
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor


def same(one: hf.Assembly, other: hf.Assembly) -> None:
    assert [b.name for b in one.bodies] == [b.name for b in other.bodies]
    assert [i.bodies for i in one.interfaces] == [i.bodies for i in other.interfaces]
    assert one.occluded == other.occluded
    assert [o.bodies for o in one.overlaps] == [o.bodies for o in other.overlaps]
    a, b = (contact_nodes(assembly, 20, "hull") for assembly in (one, other))
    for name in ("points", "axes", "mu", "weights", "interface", "a", "b"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert one.tolerances == other.tolerances


@pytest.mark.parametrize(
    ("name", "gone"), [("tabletop", ["bottle"]), ("tabletop", ["tray", "mug"]), ("arch", ["v3"]), ("wall2x2", ["b0_1"])]
)
@pytest.mark.filterwarnings("ignore::holdfast.HoldfastWarning")
def test_without_equals_a_new_assembly(name: str, gone: list[str]) -> None:
    scene = shipped_scene(name)
    whole = hf.assemble(scene, gap=5e-4)
    kept = [b for b in scene.bodies if b.name not in gone]
    known = {b.name for b in kept} | {b.material for b in kept}
    left = hf.Scene(kept, scene.friction.among(known))
    same(whole.without(gone), hf.assemble(left, gap=5e-4))
    assert whole.without(gone).interfaces[0] in whole.interfaces


def test_what_a_thin_sheet_kept_apart_touches_without_it() -> None:
    """A foil within the gap between two blocks: alone they come within the gap of each other."""
    foil = hf.Body("foil", hf.Box((0.2, 0.2, 4e-5)), mass=0.01, pose=at(0, 0, 0.1 + 2e-5))
    bodies = [
        floor(),
        box("low", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)),
        foil,
        box("high", (0.1, 0.1, 0.1), 1, (0, 0, 0.15 + 4e-5)),
    ]
    bodies.append(box("aside", (0.1, 0.1, 0.1), 1, (0.3, 0, 0.05)))
    with pytest.warns(hf.HoldfastWarning):
        whole = hf.assemble(hf.Scene(bodies, 0.5), gap=1e-4)
    assert ("low", "high") in whole.occluded
    same(whole.without(["foil"]), hf.assemble(hf.Scene([b for b in bodies if b.name != "foil"], 0.5), gap=1e-4))
    assert ("low", "high") in {i.bodies for i in whole.without(["foil"]).interfaces}
    assert ("low", "high") in whole.without(["aside"]).occluded


def test_friction_of_pairs_that_are_gone_is_forgotten() -> None:
    bodies = [floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1, (0, 0, 0.15))]
    table = hf.Friction(0.5, {("a", "b"): 0.3, ("a", "floor"): 0.2}, {"a": 0.1, "b": 0.2}, "min")
    left = hf.assemble(hf.Scene(bodies, table)).without(["b"])
    assert left.scene.friction == hf.Friction(0.5, {("a", "floor"): 0.2}, {"a": 0.1}, "min")
    assert left.mu == (0.2,)


def test_given_interfaces_stay_given() -> None:
    scene = shipped_scene("stack")
    found = hf.assemble(scene).interfaces
    left = hf.assemble(scene, interfaces=found).without(["cube3"])
    assert not left.detected
    assert left.interfaces == found[:2]


def test_an_unknown_body_is_named() -> None:
    with pytest.raises(hf.SceneError, match="did you mean 'cube3'"):
        hf.assemble(shipped_scene("stack")).without(["cube4"])
