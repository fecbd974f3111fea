"""Several objects one after the other: everything stands after each step, and the answer is a value."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest

import holdfast as hf
from bench.suites.placement_several import APART, by_rule, least_push, load
from holdfast.applications.placement.conditions import with_own
from holdfast.applications.placement.level_places import LevelPlace
from holdfast.applications.placement.result import PlacedObject
from holdfast.applications.placement.several import RULES, Try, bottom_left, highest_support
from holdfast.scene.shipped.blocks import at, box, floor

TRAY = hf.Scene([hf.Body("tray", hf.Box((0.3, 0.2, 0.02)), pose=at(0, 0, -0.01), fixed=True)], 0.5, name="tray")
THINGS = (
    hf.Body("cup", hf.Cylinder(0.03, 0.09), mass=0.2),
    hf.Body("tin", hf.Cylinder(0.04, 0.05), mass=0.4),
    hf.Body("box", hf.Box((0.06, 0.05, 0.04)), mass=0.1),
    hf.Body("book", hf.Box((0.09, 0.06, 0.02)), mass=0.3),
)


@cache
def laid() -> hf.answers.Placements:
    return hf.place_all(TRAY, THINGS, search=hf.Search(solves=25), engine="graph")


def states(p: hf.answers.Placements) -> list[hf.Scene]:
    """The scenes after the steps, from the poses alone."""
    fixed = [body for body in p.assembly.bodies if body.name not in p.poses]
    placed = [p.assembly.scene.body(step.body).moved(step.pose) for step in p.steps]
    return [hf.Scene([*fixed, *placed[: k + 1]], p.assembly.scene.friction) for k in range(len(placed))]


def test_everything_stands_after_each_step() -> None:
    p = laid()
    assert p.status is hf.Status.STABLE
    assert sorted(p.order) == sorted(thing.name for thing in THINGS)
    assert p.left == ()
    for scene in states(p):
        again = hf.assemble(scene)
        assert not again.overlaps
        assert hf.stability(again).status is hf.Status.STABLE


def test_objects_keep_their_distance_from_each_other_and_from_the_edges() -> None:
    p = laid()
    boxes = {b.name: b.surface_world.vertices for b in p.assembly.movable}
    for one, other in combinations(boxes.values(), 2):
        apart = np.maximum(one.min(0) - other.max(0), other.min(0) - one.max(0))[:2].max()
        assert apart >= p.apart - 1e-6
    for vertices in boxes.values():
        assert (np.abs(vertices[:, :2]) <= np.array([0.15, 0.1]) - p.apart + 1e-6).all()
    assert p.apart >= 0.005


def test_cups_stand_upright_and_the_forces_are_those_of_the_states() -> None:
    p = laid()
    assert p.poses["cup"][2, 2] == pytest.approx(1)
    assert p.least == min(step.least for step in p.steps)
    assert p.weakest.least == p.least
    step, scene = p.steps[-1], states(p)[-1]
    full = hf.robustness_map(hf.assemble(scene), [step.body], engine="graph", spacing=0.02)
    assert step.own >= full.force.min() - 1e-9, "a coarse map is no lower than a fine one by much"
    assert step.own <= 2 * full.force.min()


def test_boxes_are_stacked_layer_by_layer() -> None:
    """Eight boxes of half the size of the base each way: two layers of four."""
    base = hf.Scene([hf.Body("base", hf.Box((0.2, 0.2, 0.02)), pose=at(0, 0, -0.01), fixed=True)], 0.5)
    boxes = [hf.Body(f"b{k}", hf.Box((0.098, 0.098, 0.05)), mass=1) for k in range(8)]
    upright, search = hf.sets.Approach(orientations="upright"), hf.Search(solves=25)
    p = hf.place_all(base, boxes, hf.Where(stack=True, apart=0.002), upright, search, engine="graph")
    assert p.left == ()
    heights = [step.pose[2, 3] for step in p.steps]
    assert heights == pytest.approx(np.repeat([0.025, 0.075], 4).tolist(), abs=1e-4)
    assert p.steps[-1].rests_on[0] == "base"
    alone = hf.place_all(base, boxes[:5], hf.Where(apart=0.002), upright, hf.Search(solves=3), engine="graph")
    assert 2 <= len(alone.order) <= 4, "without stacking one layer is all"
    assert len(alone.left) == 5 - len(alone.order)
    for step in alone.steps:
        low, high = boxes[0].moved(step.pose).box
        assert step.pose[2, 3] == pytest.approx(0.025, abs=1e-4)
        assert np.abs([low[:2], high[:2]]).max() <= 0.1 + 2e-4, "over the edge of the base"
    assert alone.status is hf.Status.UNDECIDED
    assert "no place found for" in alone.reason


def test_the_same_call_gives_the_same_answer_and_the_poses_of_the_objects_do_not_matter() -> None:
    elsewhere = [body.moved(at(1, 2, 3)) for body in THINGS]
    again = hf.place_all(TRAY, elsewhere, search=hf.Search(solves=25), engine="graph")
    assert again.order == laid().order
    assert all((again.poses[name] == pose).all() for name, pose in laid().poses.items())


def test_friction_of_objects_that_are_not_there_yet() -> None:
    friction = hf.Friction(default=0.5, pairs={("cup", "tray"): 0.3, ("cup", "tin"): 0.1})
    p = hf.place_all(TRAY, THINGS[:2], search=hf.Search(solves=25), engine="graph", friction=friction)
    assert p.left == ()
    assert p.assembly.scene.mu("cup", "tray") == 0.3
    with pytest.raises(hf.errors.SceneError, match="unknown name"):
        hf.place_all(TRAY, THINGS[:1], engine="graph", friction=friction)


def test_one_number_is_the_friction_of_all_objects_that_the_scene_does_not_pair() -> None:
    p = hf.place_all(TRAY, THINGS[:2], search=hf.Search(solves=25), engine="graph", friction=0.4)
    assert p.left == ()
    assert {p.assembly.scene.mu(*pair) for pair in combinations(("cup", "tin", "tray"), 2)} == {0.4}
    known = hf.Friction(default=0.5, pairs={("tin", "cup"): 0.1})
    for objects in (THINGS[:2], THINGS[1::-1]):
        table = with_own(known, [*TRAY.bodies, *objects], objects, 0.4)
        assert dict(table.pairs) == {("cup", "tin"): 0.1, ("cup", "tray"): 0.4, ("tin", "tray"): 0.4}


def test_a_scene_that_does_not_stand_is_refused() -> None:
    over = box("over", (0.1, 0.1, 0.1), 1, (0.18, 0, 0.05))
    p = hf.place_all(hf.Scene([floor(0.3, 0.3), over], 0.5), THINGS[:1])
    assert p.status is hf.Status.UNSTABLE
    assert p.steps == ()
    assert p.left == ("cup",)
    assert "does not stand" in p.reason


def test_no_time_at_all_is_told() -> None:
    p = hf.place_all(TRAY, THINGS, search=hf.Search(seconds=1e-9), engine="graph")
    assert p.status is hf.Status.UNDECIDED
    assert "the time was used up" in p.reason
    assert p.tries <= 1, "no further try is begun"


@pytest.mark.parametrize(("kind", "count"), [pytest.param("tray", 5, marks=pytest.mark.slow), ("pallet", 6)])
def test_it_is_no_weaker_than_the_rules_that_know_nothing_of_forces(kind: str, count: int) -> None:
    """Their plans are made and judged by the benchmark: nothing overlaps, and whether it stands is not asked."""
    scene, bodies = load(kind, count)
    stack, ground = kind == "pallet", scene.bodies[0].name
    where = hf.Where(stack=stack, apart=APART[kind])
    approach = hf.sets.Approach(orientations="upright" if stack else None)
    p = hf.place_all(scene, bodies, where, approach, hf.Search(solves=25))
    assert p.left == ()
    named = {body.name: body for body in bodies}
    for rule in RULES.values():
        poses = by_rule(hf.assemble(scene), bodies, kind, rule)
        placed = [named[name].moved(pose) for name, pose in poses]
        least = [
            least_push(hf.assemble(hf.Scene([*scene.bodies, *placed[: k + 1]], scene.friction)), body.name, ground)
            for k, body in enumerate(placed)
        ]
        assert len(poses) == count
        assert p.least >= 0.999 * min(least), "tries that differ by less than a thousandth count as equal"


def test_most_objects_come_first_then_the_weakest_step_then_room_then_the_other_steps() -> None:
    def key(apart: float, *least: float) -> tuple:
        steps = [PlacedObject(f"b{k}", np.eye(4), force, np.inf, ("tray",)) for k, force in enumerate(least)]
        return Try(tuple(steps), hf.assemble(TRAY), (), apart).key

    assert key(0.005, 1, 1, 1) > key(0.04, 2, 2)
    assert key(0.005, 1.1, 2) > key(0.04, 3, 1)
    assert key(0.04, 1.00001, 2) > key(0.005, 3, 1), "the last digits of a solver are no reason"
    assert key(0.04, 3, 1) > key(0.04, 2, 1)
    assert key(0.04, 0, 1, 3) > key(0.04, 3, 0.9, 0), "one that any push moves"


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_a_ball_that_is_touched_does_not_make_the_push_on_others_nothing(engine: str) -> None:
    """A box beside an orange, on a shelf that leaves no other place: it tips at m g b / h, or slides at mu m g."""
    shelf = hf.Body("shelf", hf.Box((0.19, 0.1, 0.02)), pose=at(0, 0, -0.01), fixed=True)
    orange = hf.Body("orange", hf.Sphere(0.04), mass=0.2, pose=at(-0.055, 0, 0.04))
    found = hf.place_all(
        hf.Scene([shelf, orange], 0.5),
        [box("box", (0.1, 0.1, 0.12), 1, (0, 0, 0))],
        hf.Where(apart=0.0),
        search=hf.Search(seconds=60),
        engine=engine,
    )
    (step,) = found.steps
    assert "orange" in step.rests_on, "they touch"
    assert found.least == step.own
    assert 0.6 * 9.81 * 0.05 / 0.12 < found.least < 0.5 * 9.81


def test_what_is_only_balanced_is_named_and_left_out() -> None:
    def step(name: str, own: float | None, beneath: float | None) -> PlacedObject:
        return PlacedObject(name, np.eye(4), own, beneath, ("tray",))

    def least(*steps: PlacedObject) -> tuple[float, str]:
        found = replace(laid(), steps=steps)
        return found.least, str(found.summary())

    assert step("ball", 0.0, np.inf).least is None
    assert step("ball", 0.0, 2.0).least == 2.0
    force, words = least(step("box", 3.0, np.inf), step("ball", 0.0, np.inf))
    assert force == 3.0
    assert "ball: the slightest push moves it" in words
    assert least(step("box", 3.0, np.inf), step("ball", 0.0, 2.0))[0] == 2.0, "what it lies on counts"
    assert least(step("ball", 0.0, np.inf))[0] == 0.0
    assert least(step("box", None, None))[0] == 0.0


def test_rules_rank_places_by_support_or_by_height() -> None:
    def place(height: float, x: float, y: float, support: float) -> LevelPlace:
        return LevelPlace(np.eye(4), height, np.array([x, y]), support, 0)

    jutting, left, right, high = place(0, 0, 0, 0.8), place(0, 0, 2, 1), place(0, 1, 1, 1), place(0.1, 0, 0, 1)
    assert sorted([jutting, left, right, high], key=highest_support) == [left, right, high, jutting]
    assert sorted([jutting, left, right, high], key=bottom_left) == [jutting, right, left, high]
    assert min(place(0, 0, 0, 0.8), turned := place(0, 0, 0, 0.9), key=bottom_left) is turned, "two turns in one corner"


@pytest.mark.parametrize(
    "where",
    [hf.Where(box=[(0.02, -0.1), (0.15, 0.1)]), hf.Where(keep_out=[((-0.15, -0.1, 0), (-0.005, 0.1, 0.3))])],
)
def test_places_that_were_not_asked_for_do_not_use_up_those_that_are_looked_at(where: hf.Where) -> None:
    """Every place on the left of the tray is refused, and there are more of these than are looked at."""
    p = hf.place_all(TRAY, THINGS, where, search=hf.Search(solves=25), engine="graph")
    assert p.left == ()
    assert p.apart > 0.005, "the random search is asked at the least distance alone"
    assert all(np.abs(pose[2, :3]).max() == pytest.approx(1) for pose in p.poses.values()), "all of them stand level"
    assert all(pose[0, 3] > 0 for pose in p.poses.values())


@pytest.mark.parametrize(
    ("objects", "asked", "words"),
    [
        ("cup", dict, "list of bodies"),
        ([THINGS[0], THINGS[0]], dict, "two bodies are named"),
        ([hf.Body("tray", hf.Box((1, 1, 1)), mass=1)], dict, "two bodies are named"),
        (THINGS, lambda: {"where": hf.Where(supports=["tra"])}, "did you mean 'tray'"),
        (THINGS, lambda: {"search": hf.Search(candidates=3)}, "candidates, which are for one object"),
        (THINGS, lambda: {"approach": hf.sets.Approach(gripper=[[0, 0, 0], [0, 1, 1]])}, "low < high"),
        (THINGS, lambda: {"approach": hf.sets.Approach(orientations="up")}, "upright"),
    ],
)
def test_bad_arguments_say_what_is_wrong(objects, asked, words: str) -> None:
    with pytest.raises(hf.HoldfastError, match=words):
        hf.place_all(TRAY, objects, engine="graph", **asked())
