"""How an answer came about: every step from the raw answer to what is returned, in the order of the amendments."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at, box, floor


@pytest.fixture(scope="module")
def jammed() -> hf.answers.RobustnessMap:
    """A wedge in a groove: its bodies press each other without any load, so that ``lower`` is well below ``force``."""
    return hf.robustness_map(hf.assemble(hf.shipped_scene("wedged_floor")), ["cube"], spacing=0.08)


def test_the_last_step_is_the_answer(jammed: hf.answers.RobustnessMap) -> None:
    last = jammed.answers.steps[-1]
    np.testing.assert_array_equal(last.force, jammed.answers.force)
    np.testing.assert_array_equal(last.lower, jammed.answers.lower)


def test_steps_come_in_the_order_of_the_amendments(jammed: hf.answers.RobustnessMap) -> None:
    names = [step.name for step in jammed.answers.steps]
    assert names[:2] == ["load path on the first grid", "finer grids"]
    known = ["limit analysis", "stiffness", "sliding far", "contacts that are open at rest"]
    asked = [name for name in names if name in known]
    assert asked == sorted(asked, key=known.index)


def test_no_amendment_raises_lower(jammed: hf.answers.RobustnessMap) -> None:
    """What is found after the finer grids corrects or doubts: the bound of a finite answer only falls."""
    steps = jammed.answers.steps[1:]
    finite = np.isfinite(jammed.answers.force)
    for one, next_one in itertools.pairwise(steps):
        assert (next_one.lower <= one.lower)[finite].all()


def test_the_explanation_names_what_lowers_the_bound(jammed: hf.answers.RobustnessMap) -> None:
    text = jammed.explain()
    assert "stiffness: lower" in text
    assert text.startswith("finite: force")
    assert "verdict: stable" in text


def explained(*bodies: hf.Body, friction: float = 0.5) -> str:
    return hf.stability(hf.assemble(hf.Scene([floor(4, 4), *bodies], friction))).explain()


def test_a_verdict_says_what_was_looked_at_and_what_decided() -> None:
    posts = [box(name, (0.1, 0.1, 0.1), 1, (x, 0, 0.05)) for name, x in (("one", -0.1), ("two", 0.1))]
    lines = explained(*posts, box("upper", (0.3, 0.1, 0.1), 1, (0, 0, 0.15))).splitlines()
    assert lines[0] == "stable, by engine compliant (contacts at rest)"
    assert lines[1] == "one, two, upper:"
    assert lines[2].startswith("- elastic contacts on 7 nodes a side: every body comes to rest")
    assert lines[3].startswith("- less friction, and more nodes where it is near its limit: rest does not lean")
    assert lines[4].startswith("so it is stable: ")


def test_a_stack_is_settled_by_equilibrium_alone() -> None:
    cubes = [box(name, (0.1, 0.1, 0.1), 1, (0, 0, z)) for name, z in (("cube", 0.05), ("upper", 0.15))]
    lines = explained(*cubes).splitlines()
    assert lines[2].startswith("- contacts on the way to the support: every contact on the way to the support presses")
    assert lines[3].startswith("so it is stable: every contact on the way")


def test_a_push_on_a_tree_names_the_contact_that_gives_way() -> None:
    """A cube of 1 kg pushed level at its foot slides at μ m g = 4.905 N; it then presses with all of its weight."""
    cube = box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))
    told = hf.robustness(hf.Scene([floor(), cube], 0.5), "cube", (-0.05, 0, 0), (1, 0, 0)).explain()
    assert "force 4.905 N, lower 4.904 N (proved)" in told
    assert "floor-cube gives way: just before, it presses with 9.81 N, centred at (0, 0, 0), and uses 100 %" in told


def test_every_group_has_steps_of_its_own() -> None:
    cube, hovers = (box(name, (0.1, 0.1, 0.1), 1, (x, 0, z)) for name, x, z in (("cube", 0, 0.05), ("high", 1, 0.5)))
    text = explained(cube, hovers)
    assert text.startswith("unstable, ")
    stands, falls = text.split("\nhigh:")
    assert "so it is stable" in stands
    assert "so it is unstable" in falls


def test_a_ball_is_asked_of_limit_analysis_too() -> None:
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1, pose=at(0, 0, 0.05))
    assert "- limit analysis, as some motions meet no resistance: " in explained(ball)


def test_overlaps_come_last_and_decide() -> None:
    cubes = [box(f"c{k}", (0.1, 0.1, 0.1), 1, (0.09 * k, 0, 0.05)) for k in range(2)]
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        text = explained(*cubes)
    *_, last, so = text.splitlines()
    assert last.startswith("- bodies that overlap: ")
    assert so.startswith("so it is undecided: ")
