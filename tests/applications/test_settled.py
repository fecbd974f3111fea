"""hf.settle: noisy scenes come to rest, falling ones are told, and nothing depends on what it should not."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.suites.settle import apart, noisy
from bench.truth.falling import falling_scenes
from holdfast.contacts.overlap import find_overlaps
from holdfast.contacts.tolerances import Tolerances
from holdfast.settling.moved_surfaces import rotation_of

pytestmark = pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")

FALLING = falling_scenes()
QUICK = (0, 4, 8, 10, 14, 17)
TURN = np.eye(4)
TURN[:3, :3] = rotation_of(np.array([0.4, -0.7, 1.1]))
TURN[:3, 3] = 0.3, -0.2, 0.5


def at(x: float, y: float, z: float, turn: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = rotation_of(np.array(turn, dtype=float))
    pose[:3, 3] = x, y, z
    return pose


def floor() -> hf.Body:
    return hf.Body("floor", hf.Box((2, 2, 0.1)), pose=at(0, 0, -0.05), fixed=True)


def box(name: str, pose: np.ndarray) -> hf.Body:
    return hf.Body(name, hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=pose)


@pytest.mark.parametrize("name", ["stack", "table", "wall2x2", "slope_two", "arch"])
def test_noisy_scenes_come_to_rest(name: str) -> None:
    true = hf.shipped_scene(name)
    start = noisy(true, 1.5, 0.5, 1)
    result = hf.settle(start)
    assert result.status is hf.Status.STABLE
    assert hf.stability(hf.assemble(result.scene)).status is hf.Status.STABLE
    assert max((o.depth for o in find_overlaps(result.scene, Tolerances(1e-5, 1.0))), default=0.0) <= 5e-5
    assert np.median(apart(result.scene, true)) < 2 * np.median(apart(start, true))
    assert np.array_equal(result.moved, apart(result.scene, start))


def test_walls_inside_each_other_part_on_the_side_of_the_whole_bodies() -> None:
    """The coaster's floor is inside that of the tray, the covers of books inside each other."""
    result = hf.settle(noisy(hf.shipped_scene("tabletop"), 3.0, 1.0, 12))
    assert result.status is hf.Status.STABLE
    assert max((o.depth for o in find_overlaps(result.scene, Tolerances(1e-5, 1.0))), default=0.0) <= 5e-5
    assert hf.settle(result.scene).moved.max() <= 1e-6


def test_what_stands_with_overlaps_left_is_undecided_unless_a_gap_allows_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """A box pressed between two fixed walls, 0.1 mm into either, which is within the tolerance of its contacts."""
    monkeypatch.setattr("holdfast.settling.motion.STEPS", 3)
    walls = [
        hf.Body(n, hf.Box((0.05, 0.2, 0.2)), pose=at(x, 0, 0.1), fixed=True) for n, x in (("l", -0.075), ("r", 0.075))
    ]
    pressed = hf.Scene([floor(), *walls, hf.Body("a", hf.Box((0.1002, 0.1, 0.1)), mass=1.0, pose=at(0, 0, 0.05))], 0.5)
    assert not hf.assemble(pressed).overlaps
    result = hf.settle(pressed)
    assert result.status is hf.Status.UNDECIDED
    assert "overlaps are left: 'l' and 'a' by 0." in result.reason
    assert hf.settle(pressed, gap=0.001).status is hf.Status.STABLE


def test_a_body_rests_on_what_is_below_it() -> None:
    """Not on what stands on it, nor on what only stands beside it."""
    bodies = [box("low", at(0, 0, 0.052)), box("high", at(-0.01, 0, 0.154)), box("beside", at(0.1, 0, 0.051))]
    result = hf.settle(hf.Scene([floor(), *bodies], 0.5))
    reasons = dict(zip(result.names, result.reasons, strict=True))
    assert reasons["low"].endswith("rests on floor")
    assert reasons["high"].endswith("rests on low")
    assert reasons["beside"].endswith("rests on floor")


@pytest.mark.parametrize(
    "number", [pytest.param(k, marks=() if k in QUICK else pytest.mark.slow) for k in range(len(FALLING))]
)
def test_what_falls_is_told_with_body_and_direction(number: int) -> None:
    scene, _ = FALLING[number]
    result = hf.settle(scene)
    assert result.status is hf.Status.UNSTABLE
    assert result.fell
    assert result.fell[0].direction[2] < 0
    if scene.name.startswith("tower"):  # over the edge at x = 0, towards +x
        assert result.fell[0].direction[0] > 0
    else:  # the foot slides away from the wall at x = 0
        assert result.fell[0].direction[0] < 0


def test_a_tower_on_the_safe_side_of_the_edge_stays() -> None:
    scene = FALLING[4][0]
    back = {body.name: body.pose - at(0.01, 0, 0) + np.eye(4) for body in scene.movable}
    result = hf.settle(scene.moved(back))
    assert result.status is hf.Status.STABLE
    assert result.moved.max() < 1e-9


@pytest.mark.parametrize("height", [1e-4, 3e-3, 9e-3, -1e-3, -6e-3])
def test_gaps_and_overlaps_are_closed(height: float) -> None:
    result = hf.settle(hf.Scene([floor(), box("a", at(0, 0, 0.05 + height))], 0.5))
    assert result.status is hf.Status.STABLE
    assert result.scene.body("a").pose[:3, 3] == pytest.approx([0, 0, 0.05], abs=1e-5)
    assert result.moved == pytest.approx([abs(height)], abs=1e-5)
    assert ("sank" if height > 0 else "pushed") in result.reasons[0]


def test_overlaps_deeper_than_the_reach_are_refused_by_name() -> None:
    result = hf.settle(hf.Scene([floor(), box("a", at(0, 0, 0.03)), box("b", at(0.5, 0, 0.051))], 0.5), travel=0.01)
    assert result.status is hf.Status.UNDECIDED
    assert "'a'" in result.reason
    assert "20 mm" in result.reason
    assert result.moved == pytest.approx([0, 1e-3], abs=1e-5)
    assert "floor" in result.reasons[0]


@pytest.mark.parametrize("sunk", [0.012, 0.058, 0.1])
@pytest.mark.parametrize("travel", [0.01, 0.03, 0.07])
def test_a_thin_body_is_not_at_rest_within_a_travel_that_its_way_out_is_beyond(sunk: float, travel: float) -> None:
    """A domino that has sunk upright needs to rise by as much, though it is only 8 mm thick."""
    domino = hf.Body("domino", hf.Box((0.008, 0.024, 0.116)), mass=0.1, pose=at(0, 0, 0.058 - sunk))
    result = hf.settle(hf.Scene([floor(), domino], 0.5), travel=travel)
    assert result.status is (hf.Status.STABLE if sunk < travel else hf.Status.UNDECIDED)
    assert result.moved == pytest.approx([sunk if sunk < travel else 0], abs=1e-5)
    assert (f"overlap by {1e3 * sunk:.3g} mm, deeper than the travel" in result.reason) == (sunk > travel)


def test_ways_out_that_add_up_to_more_than_the_travel_are_undecided() -> None:
    """Five blocks, each 4 mm inside the next and all against a wall: each way out is short, that of the last is not."""
    blocks = [box(f"b{k}", at(0.096 * k, 0, 0.05)) for k in range(1, 6)]
    wall = hf.Body("wall", hf.Box((0.1, 0.1, 0.2)), pose=at(0, 0, 0.1), fixed=True)
    scene = hf.Scene([floor(), wall, *blocks], 0.5)
    result = hf.settle(scene, travel=0.01)
    assert result.status is hf.Status.UNDECIDED
    assert "overlaps end only beyond the travel of 10 mm" in result.reason
    assert "b5" in result.reason
    assert "b1" not in result.reason
    assert not result.fell
    enough = hf.settle(scene, travel=0.03)
    assert enough.status is hf.Status.STABLE
    assert enough.moved == pytest.approx([4e-3 * k for k in range(1, 6)], abs=1e-4)


@pytest.mark.parametrize("name", ["stack", "table", "wall2x2"])
@pytest.mark.parametrize("travel", [1e-3, 3e-3, 0.01])
def test_nothing_that_is_at_rest_within_the_travel_has_gone_further(name: str, travel: float) -> None:
    for seed in range(3):
        result = hf.settle(noisy(hf.shipped_scene(name), 2.0, 0.5, seed), travel=travel)
        if result.status is hf.Status.STABLE:
            assert result.moved.max() <= travel * (1 + 1e-9)


def test_a_scene_at_rest_stays() -> None:
    assert hf.settle(hf.shipped_scene("table")).moved.max() == 0


@pytest.mark.parametrize(
    ("name", "millimetres", "seed"),
    [("wall2x2", 1.5, 2), ("v_groove", 1.5, 2), ("table", 1.5, 16), ("arch", 3.0, 1), ("arch", 3.0, 17)],
)
def test_settling_twice_moves_nothing(name: str, millimetres: float, seed: int) -> None:
    """Steps that bring bodies that balance closer to where they do have moved the last three from where they rest."""
    once = hf.settle(noisy(hf.shipped_scene(name), millimetres, millimetres / 3, seed))
    assert once.status is hf.Status.STABLE
    assert once.moved.max() > 1e-4
    assert hf.settle(once.scene).moved.max() <= 1e-6


def test_an_orange_and_an_egg_are_only_balanced() -> None:
    egg = hf.Body("egg", hf.Ellipsoid((0.03, 0.022, 0.022)), mass=0.06, pose=at(0.2, 0, 0.0235, (0, 0.02, 0)))
    orange = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(0, 0, 0.043))
    result = hf.settle(hf.Scene([floor(), orange, egg], 0.5))
    assert result.status is hf.Status.STABLE
    assert "only balanced" in result.reason
    assert result.scene.body("orange").pose[2, 3] == pytest.approx(0.04, abs=1e-5)
    assert result.scene.body("egg").pose[2, 3] == pytest.approx(0.022, abs=1e-5)


def test_what_cannot_touch_a_body_does_not_change_a_digit_of_it() -> None:
    noise = noisy(hf.shipped_scene("stack"), 1.5, 0.5, 3)
    alone = hf.settle(noise)
    other = hf.settle(noise.with_body(box("z", at(0.6, 0.5, 0.052, (0.01, 0, 0)))))
    for body in alone.scene.movable:
        assert np.array_equal(body.pose, other.scene.body(body.name).pose)


@pytest.mark.parametrize(
    ("name", "length", "mass"), [("stack", 10.0, 1.0), ("stack", 0.1, 1.0), ("stack", 1.0, 1e3), ("table", 0.1, 1e3)]
)
def test_the_units_of_length_and_mass_do_not_matter(name: str, length: float, mass: float) -> None:
    """A scene ten times as large within ten times the reach moves ten times as far; the masses' unit moves nothing."""
    noise = noisy(hf.shipped_scene(name), 1.5, 0.5, 4)
    other = hf.settle(in_units(noise, length, mass), travel=0.03 * length)
    here = hf.settle(noise)
    assert here.moved.max() > 1e-3
    assert other.moved == pytest.approx(length * here.moved, abs=1e-6 * length)
    assert other.turned_degrees == pytest.approx(here.turned_degrees, abs=1e-3)
    assert other.status is here.status is hf.Status.STABLE


def in_units(scene: hf.Scene, length: float, mass: float) -> hf.Scene:
    bodies = []
    for body in scene.bodies:
        pose = body.pose.copy()
        pose[:3, 3] *= length
        size = length * np.ptp(body.shape.surface.vertices, axis=0)
        heavy = None if body.mass is None else mass * body.mass
        bodies.append(hf.Body(body.name, hf.Box(size), mass=heavy, pose=pose, fixed=body.fixed))
    return hf.Scene(bodies, scene.friction)


@pytest.mark.parametrize(("name", "seed", "turn", "order"), [("table", 0, np.eye(4), -1), ("stack", 5, TURN, 1)])
def test_neither_the_order_of_bodies_nor_the_axes_matter(name: str, seed: int, turn: np.ndarray, order: int) -> None:
    noise = noisy(hf.shipped_scene(name), 1.5, 0.5, seed)
    bodies = [body.moved(turn @ body.pose) for body in noise.bodies[::order]]
    found = hf.settle(noise).scene
    again = hf.settle(hf.Scene(bodies, noise.friction, turn[:3, :3] @ noise.gravity)).scene
    back = again.moved({body.name: np.linalg.inv(turn) @ body.pose for body in again.movable})
    assert apart(found, back).max() < 1e-4


def test_fixed_bodies_stay_and_excluded_pairs_do_not_touch() -> None:
    scene = hf.Scene([floor(), box("a", at(0, 0, 0.049))], 0.5, excluded=[("a", "floor")])
    result = hf.settle(scene)
    assert result.status is hf.Status.UNSTABLE
    assert result.fell[0].direction == pytest.approx([0, 0, -1], abs=1e-6)
    assert result.scene.body("floor") == scene.body("floor")


@pytest.mark.parametrize("seed", range(6))
def test_a_wedge_between_walls_sinks_to_the_floor(seed: int) -> None:
    """Friction alone holds three of these by self-stress, which `stability` does not take for standing."""
    result = hf.settle(noisy(hf.shipped_scene("wedged_floor"), 1.5, 0.5, seed))
    assert result.status is hf.Status.STABLE


def test_a_body_that_only_friction_between_walls_holds_is_not_let_down() -> None:
    """Without friction it would fall: the answer is that of the motion with friction."""
    result = hf.settle(hf.shipped_scene("wedged"))
    assert result.status is hf.Status.UNSTABLE
    assert not result.fell
    assert result.moved.max() < 1e-6


def test_only_bodies_that_move_are_said_to(monkeypatch: pytest.MonkeyPatch) -> None:
    """The box beside the ball that rolls, within the reach of it, stays where it is."""
    monkeypatch.setattr("holdfast.settling.motion.STEPS", 8)
    ball = hf.Body("ball", hf.Sphere(0.04), mass=0.2, pose=at(0.1, 0, 0.04))
    result = hf.settle(hf.Scene([floor(), box("still", at(0, 0, 0.05)), ball], 0.5, gravity=(0.5, 0, -9.8)))
    assert result.status is hf.Status.UNDECIDED
    assert result.reason.startswith("ball: the bodies still move")


def test_so_are_bodies_that_cost_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """The scene reached is given, and what stands beside them is settled."""
    monkeypatch.setattr("holdfast.settling.motion.EFFORT", -1)
    result = hf.settle(hf.Scene([floor(), box("a", at(0, 0, 0.07)), box("b", at(0.5, 0, 0.05))], 0.5))
    assert result.status is hf.Status.UNDECIDED
    assert "a: the bodies still move after programs with a million contacts" in result.reason
    assert 0 < result.moved[0] < 0.02
    assert result.moved[1] == 0


def test_a_body_with_room_on_both_sides_falls_between_walls() -> None:
    """The cones of friction alone would let it down by 2 * 0.02 / 0.5 mm a step at most, until the steps end."""
    walls = [hf.Body(n, hf.Box((0.1, 0.1, 0.6)), pose=at(x, 0, 0), fixed=True) for n, x in (("l", -0.1), ("r", 0.1))]
    block = hf.Body("a", hf.Box((0.09996, 0.1, 0.1)), mass=1.0)
    result = hf.settle(hf.Scene([*walls, block], 0.5))
    assert [fall.body for fall in result.fell] == ["a"]
    assert result.fell[0].direction == pytest.approx([0, 0, -1], abs=1e-2)
    assert result.steps < 60


@pytest.mark.parametrize("hover", [0.5e-3, 2e-3, 10e-3])
def test_a_body_that_falls_onto_a_rough_slope_stays_where_it_lands(hover: float) -> None:
    """Straight down, at most: a fall along the normal is what the cones of friction alone would make of it."""
    slope = np.radians(20)
    turn = at(0, 0, 0, (0, slope, 0))
    ramp = hf.Body("ramp", hf.Box((1, 1, 0.1)), pose=turn @ at(0, 0, -0.05), fixed=True)
    above = turn @ at(0, 0, 0.05)
    above[2, 3] += hover / np.cos(slope)  # along the vertical, so that it lands where it began
    result = hf.settle(hf.Scene([ramp, box("a", above)], 0.5))
    assert result.status is hf.Status.STABLE
    downhill = np.array([np.cos(slope), 0, -np.sin(slope)])
    slid = (result.scene.body("a").com_world - (turn @ at(0, 0, 0.05))[:3, 3]) @ downhill
    assert -1.05 * hover * np.tan(slope) <= slid <= 1e-3


@pytest.mark.parametrize(("most", "status"), [(8, hf.Status.STABLE), (4, hf.Status.UNSTABLE)])
def test_what_turns_further_than_it_may_has_fallen(most: float, status: hf.Status) -> None:
    """A cube on one of its edges, 6 degrees from lying flat, may turn by 8 degrees, or by 4."""
    turn = np.radians(6)
    leaning = box("a", at(0, 0, 0.05 * (np.cos(turn) + np.sin(turn)), (0, turn, 0)))
    result = hf.settle(hf.Scene([floor(), leaning], 0.5), turn_degrees=most, travel=0.05)
    assert result.status is status
    assert result.turned_degrees[0] == pytest.approx(6, abs=1e-3) or most < result.turned_degrees[0] < most + 1


def test_upright_bodies_are_turned_first() -> None:
    leaning = hf.Body("post", hf.Box((0.02, 0.02, 0.3)), mass=1.0, pose=at(0, 0, 0.151, (0.1, 0, 0)))
    scene = hf.Scene([floor(), leaning], 0.5)
    assert hf.settle(scene).status is not hf.Status.STABLE
    result = hf.settle(scene, upright="post")
    assert result.status is hf.Status.STABLE
    assert result.scene.body("post").pose[2, 2] == pytest.approx(1, abs=1e-9)
    with pytest.raises(hf.HoldfastError, match="degrees from upright"):
        hf.settle(scene, upright=["post"], turn_degrees=3)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"known": ["nobody"]}, "nobody"),
        ({"pose_sigma": {"nobody": 1e-3}}, "nobody"),
        ({"upright": "floor"}, "fixed"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, object], told: str) -> None:
    with pytest.raises(hf.HoldfastError, match=told):
        hf.settle(hf.Scene([floor(), box("a", at(0, 0, 0.05))], 0.5), **options)  # type: ignore[arg-type]
    with pytest.raises(hf.HoldfastError, match="needs a Scene"):
        hf.settle("table")  # type: ignore[arg-type]
