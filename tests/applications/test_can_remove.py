"""May one body be taken out now: closed cases, who moves otherwise, and the same answers as in an order."""

from __future__ import annotations

import pytest

import holdfast as hf
from holdfast.applications.disassembly.removal import Answer
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor


def test_the_top_of_a_stack_may_go_and_what_bears_may_not() -> None:
    assembly = hf.assemble(shipped_scene("stack"))
    assert hf.can_remove(assembly, "cube3").safe
    middle = hf.can_remove(assembly, "cube2")
    assert (middle.answer, middle.moving, middle.blockers) == (Answer.UNSAFE, ("cube3",), (("cube3", 0.0),))
    assert hf.can_remove(assembly, "cube2", lift=(1, 0, 0)).moving == ("cube3",)


def test_all_that_falls_is_named_though_it_falls_apart() -> None:
    """Two cubes on one slab touch each other nowhere: without the slab both fall, and of neither the other is told."""
    cubes = [box(name, (0.1, 0.1, 0.1), 1, (x, 0, 0.15)) for name, x in (("left", -0.15), ("right", 0.15))]
    slab = box("slab", (0.5, 0.2, 0.1), 5, (0, 0, 0.05))
    found = hf.can_remove(hf.Scene([floor(), slab, *cubes], 0.5), "slab", lift=(0, 1, 0))
    assert (found.answer, set(found.moving), found.blockers) == (Answer.UNSAFE, {"left", "right"}, ())
    assert "without it left, right would move" in found.reason


def test_the_way_out_alone_may_forbid_it() -> None:
    lid = hf.Body("lid", hf.Box((0.3, 0.3, 0.02)), pose=at(0, 0, 0.41), fixed=True)
    scene = hf.Scene([floor(), lid, box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5)
    found = hf.can_remove(scene, "cube")
    assert (found.answer, found.moving) == (Answer.UNSAFE, ())
    assert found.blockers == (("lid", pytest.approx(0.3)),)
    assert hf.can_remove(scene, "cube", lift=(1, 0, 0)).safe


def test_what_falls_as_it_is_may_not_be_touched_but_others_may() -> None:
    ball = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0.3, 0, 0.05))
    tilted = box("tower", (0.02, 0.02, 0.1), 0.1, (-0.3, 0, 0.25))
    scene = hf.Scene([floor(), ball, tilted, box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5)
    found = hf.can_remove(scene, "tower")
    assert (found.answer, found.moving) == (Answer.UNSAFE, ("tower",))
    assert "does not stand as it is" in found.reason
    assert hf.can_remove(scene, "cube").safe


def test_what_is_not_known_is_undecided() -> None:
    assert hf.can_remove(shipped_scene("wedged_floor"), "cube", engine="limit").answer is Answer.UNDECIDED
    assert hf.can_remove(shipped_scene("wedged_floor"), "cube").safe
    whole = hf.can_remove(shipped_scene("wedged"), "cube", engine="limit")
    assert whole.answer is Answer.UNDECIDED
    assert whole.reason.startswith("whether it stands as it is: ")


@pytest.mark.parametrize("name", ["cantilever", "table"])
def test_the_answers_are_those_of_the_first_step_of_an_order(name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    for removal in hf.disassembly_order(assembly).answers(0):
        assert hf.can_remove(assembly, removal.body) == removal


def test_a_fixed_or_unknown_body_is_refused() -> None:
    for name, words in (("floor", "removal of 'floor': the body is fixed"), ("cub", "unknown|no body")):
        with pytest.raises(hf.errors.SceneError, match=words):
            hf.can_remove(shipped_scene("cube"), name)
