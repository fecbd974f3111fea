"""Where a body can be pushed: closed forms of a cube, neighbours, what is in the way, and the tool."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.pushing.safe_pushes import reached
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor

G, MU = 9.81, 0.6
X = (1.0, 0.0, 0.0)


def row(count: int, gap: float, mu: float = 0.3) -> hf.Scene:
    """Cubes of 0.1 m and 1 kg in a row along x, ``gap`` [m] apart."""
    cubes = [box(f"c{k}", (0.1, 0.1, 0.1), 1, (k * (0.1 + gap), 0, 0.05)) for k in range(count)]
    return hf.Scene([floor(), *cubes], mu)


def effects(found: hf.answers.SafePushes, along: tuple[float, ...]) -> set[hf.answers.Effect]:
    """What the pushes in one direction do."""
    return set(found.effect[(found.directions @ np.array(along) > 0.99)])


def test_a_cube_slides_when_pushed_low_and_tips_when_pushed_high() -> None:
    """It slides at mu m g where it is pushed lower than b / (2 mu), and tips higher up; pressed down, it stays."""
    found = hf.safe_pushes(shipped_scene("cube"), "cube", 9.0, doubt=0.1, spacing=0.02)
    height, side = found.points[:, 2], np.abs(found.directions[:, 2]) < 0.5
    middle = side & (np.abs(found.points[:, :2]).min(1) < 0.011)
    tips = 0.05 / (MU * 0.9)
    assert set(found.effect[middle & (height < 0.05 / (MU * 1.1) - 0.011)]) == {hf.answers.Effect.ALONE}
    assert hf.answers.Effect.ALONE not in set(found.effect[side & (height > tips)])
    assert all("would move on" in why for why in found.reason[middle & (height > tips)])
    assert effects(found, (0, 0, -1)) == {hf.answers.Effect.NOTHING}
    assert set(found.to_dict()["effect"]) <= {"nothing", "alone", "others", "unknown"}


@pytest.mark.parametrize(
    ("share", "effect"),
    [(0.85, hf.answers.Effect.UNKNOWN), (0.75, hf.answers.Effect.NOTHING), (1.6, hf.answers.Effect.ALONE)],
)
def test_the_doubt_of_friction_lies_between_nothing_and_the_body(share: float, effect: hf.answers.Effect) -> None:
    """Through the middle plane, low, it slides between 0.8 and 1.2 mu m g, as friction may be off by a fifth."""
    cube = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.3)
    found = hf.safe_pushes(cube, "cube", share * 0.3 * G, directions=X, spacing=0.034)
    middle = np.abs(found.points - (-0.05, 0, 0.05)).max(1) < 1e-6
    assert found.effect[middle].tolist() == [effect]
    if effect is hf.answers.Effect.NOTHING:  # it is not asked how much more would move it
        assert (found.lower[middle], found.upper[middle]) == (found.force, np.inf)
    else:
        assert found.lower[middle] == pytest.approx(0.8 * 0.3 * G, rel=0.03)
        assert found.upper[middle] == pytest.approx(1.2 * 0.3 * G, rel=1e-6)


def test_a_neighbour_behind_is_pushed_along_and_one_beside_is_not() -> None:
    found = hf.safe_pushes(row(2, 0.0), "c0", 12.0, directions=[X, (-1, 0, 0), (0, 1, 0)], doubt=0.1)
    assert effects(found, X) <= {hf.answers.Effect.OTHERS, hf.answers.Effect.UNKNOWN}
    assert "c1" in " ".join(found.reason[found.are(hf.answers.Effect.OTHERS)])
    free = hf.safe_pushes(row(2, 0.0), "c1", 12.0, directions=X, doubt=0.1)
    assert len(free.effect) == 0  # c0 covers the face that would have to be pushed


def test_what_the_body_would_run_into_is_told() -> None:
    """A gap of 3 mm: pushed by 5 mm the first cube touches the second; pushed by 2 mm it does not."""
    far, near = (
        hf.safe_pushes(row(2, 0.003), "c0", 12.0, directions=X, spacing=0.1, tool=hf.sets.Tool(travel=way), doubt=0.1)
        for way in (0.005, 0.0015)
    )
    assert set(far.effect) == {hf.answers.Effect.UNKNOWN}
    assert all("c1" in why or "overlap" in why for why in far.reason)
    assert set(near.effect) == {hf.answers.Effect.ALONE}


@pytest.mark.parametrize("end", [-1, 1])
def test_a_bar_pushed_at_one_end_turns_into_what_stands_before_that_end_alone(end: int) -> None:
    """The pushed end goes ahead and the other one back, wherever the bar lies: a block is 3 mm before one end."""
    block = hf.Body("block", hf.Box((0.03, 0.03, 0.04)), pose=at(0.3 + end * 0.077, 0.038, 0.02), fixed=True)
    scene = hf.Scene([floor(), box("bar", (0.2, 0.04, 0.04), 1, (0.3, 0, 0.02)), block], 0.3)
    found = hf.safe_pushes(scene, "bar", 2.4, directions=(0, 1, 0), spacing=0.05, doubt=0.1)
    before, other = (int(np.argmin(np.abs(found.points[:, 0] - 0.3 - side * 0.075))) for side in (end, -end))
    assert found.effect[[before, other]].tolist() == [hf.answers.Effect.UNKNOWN, hf.answers.Effect.ALONE]
    assert "bar and block overlap" in found.reason[before]


def test_what_rests_on_the_body_goes_with_it_and_what_it_rests_on_may() -> None:
    stack = shipped_scene("stack")
    assert not hf.safe_pushes(stack, "cube2", 15.0, spacing=0.05).alone.any()
    assert hf.safe_pushes(stack, "cube3", 9.0, spacing=0.034).alone.any()
    assert not hf.safe_pushes(stack, "cube1", 30.0, spacing=0.05).alone.any()


def test_what_does_not_stand_has_no_safe_push() -> None:
    found = hf.safe_pushes(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.5), "cube", 1.0)
    assert set(found.effect) == {hf.answers.Effect.UNKNOWN}
    assert all("whether it stands" in why for why in found.reason)


def test_a_ball_that_would_roll_on_is_never_safe_to_push() -> None:
    ball = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0, 0, 0.04))
    found = hf.safe_pushes(hf.Scene([floor(), ball], 0.5), "orange", 1.0, directions=X, spacing=0.04)
    assert set(found.effect) == {hf.answers.Effect.UNKNOWN}
    assert "only balanced" in found.reason[0]


def test_given_contacts_cannot_be_moved() -> None:
    assembly = hf.assemble(shipped_scene("cube"))
    given = hf.assemble(shipped_scene("cube"), interfaces=assembly.interfaces)
    found = hf.safe_pushes(given, "cube", 9.0, directions=X)
    assert not found.alone.any()
    assert any("contacts were given" in why for why in found.reason)


@pytest.mark.parametrize(("radius", "free"), [(0.0, True), (0.009, True), (0.012, False)])
def test_a_tool_fits_into_a_slot_as_wide_as_itself(radius: float, free: bool) -> None:
    """A wall of which a tool that pushes along y at the middle of the face keeps 10 mm away."""
    wall = hf.Body("wall", hf.Box((0.02, 0.3, 0.3)), pose=at(0.0205, -0.21, 0.15), fixed=True)
    assembly = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), wall], 0.5))
    point, normal = np.array([[0.0, -0.05, 0.05]]), np.array([[0.0, -1.0, 0.0]])
    assert reached(assembly, "cube", point, normal, -normal, radius)[0] == free


def test_a_tool_does_not_reach_through_the_body_itself() -> None:
    """The inner face of a frame: from inside a rod as long as a tool comes through the opposite bar."""
    along, across = hf.Box((0.02, 0.2, 0.1)), hf.Box((0.2, 0.02, 0.1))
    bars = [(along, -0.09, 0), (along, 0.09, 0), (across, 0, 0.09), (across, 0, -0.09)]
    frame = hf.Compound([hf.Part(bar, at(x, y, 0)) for bar, x, y in bars])
    assembly = hf.assemble(hf.Scene([floor(), hf.Body("frame", frame, mass=1, pose=at(0, 0, 0.05))], 0.5))
    inner, outer = np.array([[0.08, 0.0, 0.05]]), np.array([[-0.1, 0.0, 0.05]])
    assert not reached(assembly, "frame", inner, np.array([[-1.0, 0, 0]]), np.array([X]), 0.0)[0]
    assert reached(assembly, "frame", outer, np.array([[-1.0, 0, 0]]), np.array([X]), 0.0)[0]


@pytest.mark.parametrize(("degrees", "pushed"), [(29.9, True), (30.1, False), (45, False), (-29.9, True)])
def test_no_push_is_further_than_30_degrees_from_the_normal(degrees: float, pushed: bool) -> None:
    """At a larger angle the tool might slip."""
    way = (np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0)
    found = hf.safe_pushes(shipped_scene("cube"), "cube", 1.0, directions=way, spacing=0.1)
    assert bool(len(found.points)) is pushed


def test_pushes_that_no_tool_reaches_are_counted() -> None:
    ceiling = hf.Body("ceiling", hf.Box((1, 1, 0.02)), pose=at(0, 0, 0.14), fixed=True)
    scene = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), ceiling], 0.5)
    found = hf.safe_pushes(scene, "cube", 3.0, directions=[X, (0, 0, -1)], tool=hf.sets.Tool(radius=0.005))
    assert effects(found, (0, 0, -1)) == set()
    assert found.unreached > 0
    assert found.tool_radius == 0.005


def test_what_cannot_be_asked_is_refused() -> None:
    with pytest.raises(hf.errors.SceneError, match="the body is fixed"):
        hf.safe_pushes(shipped_scene("cube"), "floor", 1.0)
    with pytest.raises(hf.HoldfastError, match="does not claim that it holds"):
        hf.safe_pushes(shipped_scene("cube"), "cube", 1.0, engine="limit")
    with pytest.raises(hf.errors.SceneError, match="doubt: is 1; needs a finite number >= 0 and < 1"):
        hf.safe_pushes(shipped_scene("cube"), "cube", 1.0, doubt=1)
