"""The state of the live view without a browser: picking, pushing, editing, and the states of answers."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.errors import SceneError
from holdfast.live.edits import BodyPlace, place_of, pose_of, weighing
from holdfast.live.steps import ShownStep, places, settling, taking_apart
from holdfast.live.window_model import ViewModel
from holdfast.scene.shipped.blocks import box, floor

G, MASS, MU = 9.81, 2.0, 0.3


def cubes() -> hf.answers.Assembly:
    """Two cubes on a floor, 0.3 m apart; friction makes both slide when they are pushed low."""
    bodies = [box(n, (0.1, 0.1, 0.1), MASS, (x, 0.0, 0.05)) for n, x in (("left", 0.0), ("right", 0.3))]
    return hf.assemble(hf.Scene([floor(), *bodies], friction=MU))


@pytest.fixture
def model() -> ViewModel:
    return ViewModel(cubes(), engine="limit")


def low_from_the_left(model: ViewModel) -> None:
    assert model.choose(np.array([-1.0, 0.0, 0.02]), np.array([1.0, 0.0, 0.0]))


def test_a_click_chooses_the_nearest_body_and_pushes_inward(model: ViewModel) -> None:
    low_from_the_left(model)
    assert model.pick is not None
    assert model.pick.body == "left"
    assert model.pick.point == pytest.approx([-0.05, 0, 0.02])
    assert model.pick.normal == pytest.approx([-1, 0, 0])
    assert model.direction == pytest.approx([1, 0, 0])


def test_a_click_on_the_floor_or_beside_everything_chooses_nothing(model: ViewModel) -> None:
    low_from_the_left(model)
    assert not model.choose(np.array([0.15, 0.0, 1.0]), np.array([0.0, 0.0, -1.0]))
    assert model.pick is None
    low_from_the_left(model)
    assert not model.choose(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    assert model.direction is None


def test_the_push_is_what_coulomb_says(model: ViewModel) -> None:
    """Level and low: mu m g. Leaning down by a: mu m g / (cos a - mu sin a); up: / (cos a + mu sin a)."""
    low_from_the_left(model)
    model.ask_push()
    assert model.push is not None
    assert model.push.force[0] == pytest.approx(MU * MASS * G)
    assert model.push.moving[0] == ("left",)
    a = np.deg2rad(20.0)
    found = {}
    for turn in np.arange(0.0, 360.0, 90.0):
        model.aim(turn, 20.0)
        assert model.push is None
        model.ask_push()
        assert model.direction is not None
        found[round(float(model.direction[2]), 6)] = float(model.push.force[0])
    assert found[round(-np.sin(a), 6)] == pytest.approx(MU * MASS * G / (np.cos(a) - MU * np.sin(a)))
    assert found[round(np.sin(a), 6)] == pytest.approx(MU * MASS * G / (np.cos(a) + MU * np.sin(a)))


@pytest.mark.parametrize("turn", [0.0, 40.0, 200.0, 725.0])
def test_a_push_leans_by_the_angle_that_was_set_and_stays_inward(model: ViewModel, turn: float) -> None:
    low_from_the_left(model)
    for tilt in (0.0, 30.0, 90.0):
        model.aim(turn, tilt)
        assert model.direction is not None
        assert np.linalg.norm(model.direction) == pytest.approx(1)
        assert np.degrees(np.arccos(model.direction @ [1.0, 0, 0])) == pytest.approx(min(tilt, 85.0), abs=1e-6)


def test_the_mechanism_is_that_of_the_push_or_of_what_does_not_stand() -> None:
    bodies = [box("steady", (0.1, 0.1, 0.1), 1.0, (0.0, 0, 0.05)), box("over", (0.1, 0.1, 0.1), 1.0, (0.06, 0, 0.15))]
    model = ViewModel(hf.assemble(hf.Scene([floor(), *bodies], friction=0.5)), engine="limit")
    assert model.mechanism is None
    model.ask_verdict()
    assert model.mechanism is not None
    assert "over" in model.mechanism.moving
    standing = ViewModel(cubes(), engine="limit")
    standing.ask_verdict()
    assert standing.mechanism is None
    low_from_the_left(standing)
    standing.ask_push()
    assert standing.mechanism is not None
    assert standing.mechanism.moving == ("left",)


def test_what_is_drawn_elsewhere_is_chosen_where_it_is_drawn(model: ViewModel) -> None:
    """A body that leaves is drawn above its place; a click on it finds the point of the body at rest."""
    up = np.eye(4)
    up[2, 3] = 0.5
    model.show((ShownStep("", frozenset({"right"}), {"left": up}),))
    assert model.choose(np.array([-1.0, 0.0, 0.52]), np.array([1.0, 0.0, 0.0]))
    assert model.pick is not None
    assert model.pick.point == pytest.approx([-0.05, 0, 0.02])
    assert not model.choose(np.array([1.0, 0.0, 0.02]), np.array([-1.0, 0.0, 0.0])), "hidden, and away"


def test_an_edit_forgets_what_was_asked(model: ViewModel) -> None:
    low_from_the_left(model)
    model.ask_push()
    model.ask_verdict()
    while not model.mapped:
        model.ask_map()
    given = model.assembly
    model.edit(weighing(given, "left", 2 * MASS))
    assert (model.map, model.verdict, model.push, model.pick) == (None, None, None, None)
    low_from_the_left(model)
    model.ask_push()
    assert model.push is not None
    assert model.push.force[0] == pytest.approx(2 * MU * MASS * G)
    assert model.given is given


def test_friction_of_one_pair_is_that_pairs_alone(model: ViewModel) -> None:
    model.edit(model.assembly.with_friction({("floor", "left"): 0.1}))
    low_from_the_left(model)
    model.ask_push()
    assert model.push is not None
    assert model.push.force[0] == pytest.approx(0.1 * MASS * G)
    assert model.choose(np.array([1.0, 0.0, 0.02]), np.array([-1.0, 0.0, 0.0]))
    model.ask_push()
    assert model.push.force[0] == pytest.approx(MU * MASS * G)


def test_a_typed_place_moves_a_body_and_its_contacts(model: ViewModel) -> None:
    along = np.array([0.1, 0.0, 0.0])
    before = place_of(model.assembly, "left")
    assert before.turn == pytest.approx([0, 0, 0])
    same = model.assembly.moved({"left": pose_of(before)})
    assert same.scene.body("left").pose == pytest.approx(model.assembly.scene.body("left").pose)
    turned = model.assembly.moved({"left": pose_of(BodyPlace(before.position + along, np.array([0.0, 0.0, 30.0])))})
    after = place_of(turned, "left")
    assert after.position == pytest.approx(before.position + along)
    assert after.turn == pytest.approx([0, 0, 30])
    (interface,) = (i for i in turned.interfaces if "left" in i.bodies)
    assert interface.patches[0].centroid == pytest.approx([0.1, 0, 0], abs=1e-9)
    assert turned.scene.body("left").pose[:2, 0] == pytest.approx([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    apart = model.assembly.moved({"left": pose_of(BodyPlace(before.position + np.array([0, 0, 0.2]), before.turn))})
    assert not any("left" in i.bodies for i in apart.interfaces)


@pytest.mark.parametrize("turn", [(0, 0, 0), (10, 20, 30), (170, -80, -100), (25, 90, 0), (-140, -90, 0), (0, 90, 0)])
def test_the_angles_of_a_body_are_those_that_were_typed(model: ViewModel, turn: tuple[float, float, float]) -> None:
    """Also where rotations about x and z are the same one, without a warning of it."""
    before = place_of(model.assembly, "left").position
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*imbal.*")
        moved = model.assembly.moved(
            {"left": pose_of(BodyPlace(before + np.array([0, 0, 1.0]), np.array(turn, float)))}
        )
        assert place_of(moved, "left").turn == pytest.approx(turn, abs=1e-6)


@pytest.mark.parametrize("mass", [0.0, -1.0, np.nan])
def test_no_mass_is_taken_that_no_body_has(model: ViewModel, mass: float) -> None:
    with pytest.raises(SceneError):
        weighing(model.assembly, "left", mass)


def test_settling_goes_from_the_given_poses_to_rest() -> None:
    given = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.053))], friction=0.5)
    result = hf.settle(given, engine="limit")
    steps = settling(result)
    assert len(steps) == 11
    rest = result.scene.body("cube").pose
    np.testing.assert_allclose(steps[0].moved["cube"] @ rest, given.body("cube").pose, atol=1e-12)
    np.testing.assert_allclose(steps[-1].moved["cube"], np.eye(4), atol=1e-12)
    heights = [(step.moved["cube"] @ rest)[2, 3] for step in steps]
    np.testing.assert_allclose(np.diff(heights), (rest[2, 3] - 0.053) / 10, atol=1e-12)
    assert "stable" in steps[-1].text.lower()


def test_taking_apart_hides_what_is_gone_and_draws_out_what_goes() -> None:
    result = hf.disassembly_order(hf.shipped_scene("stack"), engine="limit")
    steps = taking_apart(result)
    assert result.reached
    assert [sorted(step.hidden) for step in steps] == [sorted(result.order[:k]) for k in range(len(result.order) + 1)]
    for step, name in zip(steps, result.order, strict=False):
        assert step.moved.keys() == {name}
        assert step.moved[name][2, 3] > 0
    assert steps[-1].text == "nothing is left"


def test_places_put_the_body_at_every_candidate() -> None:
    scene = hf.Scene([floor()], friction=0.5)
    found = hf.plan_placement(
        scene, box("cube", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.3)), search=hf.Search(seed=1), engine="limit"
    )
    steps = places(found)
    assert len(steps) == len(found.candidates) >= 1
    assert found.body is not None
    for step, candidate in zip(steps, found.candidates, strict=True):
        np.testing.assert_allclose(step.moved[found.name] @ found.body.pose, candidate.pose, atol=1e-9)
    np.testing.assert_allclose(steps[0].moved[found.name], np.eye(4), atol=1e-9)
