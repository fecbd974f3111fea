"""Pushes, motions and orders end where a body would bear more than it may: closed forms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from placed import FLOOR

import holdfast as hf
from holdfast.live.steps import moved_by
from holdfast.sets import box_compression_strength

G = 9.81
ENGINES = ("compliant", "limit", "graph")


def tower(count: int = 4, **limits: float) -> hf.Scene:
    """Boxes of 0.4 x 0.3 x 0.3 m and 10 kg on each other."""
    boxes = [
        hf.Body(f"box{k}", hf.Box((0.4, 0.3, 0.3)), 10.0, position=(0, 0, 0.15 + 0.3 * k), **limits)
        for k in range(count)
    ]
    return hf.Scene([FLOOR, *boxes], 0.5)


def bridge(load: float = 0.0, **limits: float) -> hf.Scene:
    """A beam of 10 kg, with a block of ``load`` on it if there is any, on posts at its ends and its middle."""
    posts = [
        hf.Body(f"post{k}", hf.Box((0.1, 0.1, 0.3)), 1.0, position=(x, 0, 0.15), **limits)
        for k, x in enumerate((-0.45, 0, 0.45))
    ]
    beam = hf.Body("beam", hf.Box((1.0, 0.1, 0.1)), 10.0, position=(0, 0, 0.35))
    block = [hf.Body("block", hf.Box((0.1, 0.1, 0.1)), load, position=(0, 0, 0.45))] if load else []
    return hf.Scene([FLOOR, *posts, beam, *block], 0.5)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_tower_that_goes_up_bears_more_by_its_acceleration(engine: str) -> None:
    found = hf.transport_limits(tower(top_load=400.0), [(0, 0, 1), (1, 0, 0)], engine=engine)
    assert found.acceleration == pytest.approx([400 / 30 - G, G * 0.2 / 0.6], rel=1e-6)
    assert found.mode.tolist() == ["crush", "topple"]
    assert found.moving[0] == ("box0",)
    assert found.mechanism[0].text == "box0 bears as much as it may"
    assert found.lower[0] <= found.acceleration[0]
    if engine != "graph":
        assert found.lower[0] == pytest.approx(400 / 30 - G, rel=1e-5)
        assert found.lower_bound is not hf.answers.Bound.PROVED


@pytest.mark.parametrize("engine", ENGINES)
def test_a_push_from_above_ends_where_the_lowest_box_is_crushed(engine: str) -> None:
    found = hf.robustness(tower(top_load=400.0), "box3", (0, 0, 1.2), (0, 0, -1), engine=engine)
    assert float(found) == pytest.approx(400 - 30 * G, rel=1e-6)
    assert found.moving[0] == ("box0",)
    factor = hf.load_factor(tower(pressure=5e3), [hf.Load("box3", (0, 0, 1.2), (0, 0, -10))], engine=engine)
    assert factor.factor == pytest.approx((5e3 * 0.12 - 40 * G) / 10, rel=1e-6)  # the floor presses box0
    assert factor.mode == "crush"
    steep = hf.robustness(tower(top_load=400.0), "box3", (0, 0, 1.2), (0, -3, -4), engine=engine)
    assert steep.force[0] < 105.7 / 0.8  # it topples before


@pytest.mark.parametrize(("engine", "accuracy"), [("compliant", 1e-3), ("graph", 1e-3)])
def test_a_slab_that_is_pushed_off_centre_crushes_the_nearer_carton(engine: str, accuracy: float) -> None:
    """On equal springs under pads of width w at ±d, a force at x presses a pad by 1/2 + x / (2 d (1 + w² / 12 d²))."""
    cartons = [
        hf.Body(f"carton{k}", hf.Box((0.1, 0.3, 0.3)), 2.0, position=(x, 0, 0.15), top_load=100.0)
        for k, x in enumerate((-0.45, 0.45))
    ]
    slab = hf.Body("slab", hf.Box((1.0, 0.3, 0.05)), 5.0, position=(0, 0, 0.325))
    found = hf.robustness(hf.Scene([FLOOR, *cartons, slab], 0.5), "slab", (0.2, 0, 0.35), (0, 0, -1), engine=engine)
    share = 0.5 + 0.2 / (0.9 * (1 + 0.1**2 / (12 * 0.45**2)))
    assert float(found) == pytest.approx((100 - 2.5 * G) / share, rel=accuracy)
    assert found.moving[0] == ("carton1",)


def test_nothing_may_be_pressed_on_glass() -> None:
    glass = hf.Body("glass", hf.Box((0.4, 0.3, 0.3)), 10.0, position=(0, 0, 0.15), top_load=0.0)
    alone = hf.robustness(hf.Scene([FLOOR, glass], 0.5), "glass", (0, 0, 0.3), [(0, 0, -1), (0, 0, 1)])
    assert alone.force == pytest.approx([0, 10 * G], abs=1e-3)  # a millionth of the weight is none


@pytest.mark.parametrize("engine", ["compliant", "limit"])
def test_a_shelf_that_is_fixed_is_crushed_by_what_is_pressed_on_it_or_its_load(engine: str) -> None:
    shelf = hf.Body("shelf", hf.Box((1, 0.4, 0.02)), position=(0, 0, -0.01), fixed=True, top_load=100.0)
    mugs = [hf.Body(f"mug{k}", hf.Box((0.1, 0.1, 0.1)), 4.0, position=(0.3 * k, 0, 0.05)) for k in range(2)]
    scene = hf.Scene([shelf, *mugs], 0.5)
    for body, point in (("mug0", (0, 0, 0.1)), ("shelf", (-0.3, 0, 0))):
        found = hf.robustness(scene, body, point, (0, 0, -1), engine=engine)
        assert float(found) == pytest.approx(100 - 8 * G, rel=1e-6), body
        assert found.moving[0] == ("shelf",)


def test_an_empty_carton_is_crushed_by_many_times_its_weight() -> None:
    """Beyond about a hundred times the weight forces are not known: a straight line leads on, lower ends before."""
    carton = hf.Body("carton", hf.Box((0.4, 0.3, 0.3)), 0.4, position=(0, 0, 0.15), top_load=2460.0)
    lid = hf.Body("lid", hf.Box((0.4, 0.3, 0.01)), 0.1, position=(0, 0, 0.305))
    found = hf.robustness(hf.Scene([FLOOR, carton, lid], 0.5), "lid", (0, 0, 0.31), (0, 0, -1))
    assert found.force[0] == pytest.approx(2460 - 0.1 * G, rel=1e-6)
    assert found.lower[0] <= found.force[0]


@pytest.mark.parametrize("engine", ENGINES)
def test_loads_that_cancel_press_all_the_same(engine: str) -> None:
    loads = [hf.Load("box0", (0, 0, 0.3), (0, 0, -1000)), hf.Load("box0", (0, 0, 0), (0, 0, 1000))]
    verdict = hf.stability(tower(1, top_load=400.0), loads=loads, engine=engine)
    assert verdict.verdict.stable
    assert not verdict.stable
    assert verdict.bearing[0].load == pytest.approx(1000)
    assert verdict.crushed == ("box0",)
    found = hf.load_factor(tower(1, top_load=400.0), loads, engine=engine)
    assert found.factor == pytest.approx(0.4)
    assert found.moving == ("box0",)


def test_what_is_crushed_at_rest_has_no_answer_above_zero(tmp_path: Path) -> None:
    scene = tower(top_load=200.0)
    found = hf.transport_limits(scene, [(1, 0, 0)])
    assert found.acceleration.tolist() == [0]
    assert found.status.tolist() == [hf.Status.UNSTABLE]
    assert not moved_by(found.mechanism[0], 0.1)
    found.save(tmp_path / "limits.json")
    assert hf.load_answer(tmp_path / "limits.json").moving[0] == ("box0",)


def test_a_motion_says_when_and_who_is_crushed() -> None:
    motion = hf.Profile.from_table([[0, 0, 0, 0], [2, 0, 0, 2 * (400 / 30 - G)]])
    found = hf.carry(tower(top_load=400.0), motion)
    assert not found.holds
    assert found.time == pytest.approx(1, abs=2e-3)
    assert found.first == ("box0",)
    assert found.time_scale() == pytest.approx(np.sqrt(0.5), rel=1e-5)


def test_the_margin_of_a_verdict_crushes_nothing() -> None:
    """Where nothing is near its limit it stays the same, but for nodes; a level force on the beam presses a post."""
    assert hf.stability(tower(2, top_load=1e3)).margin == pytest.approx(hf.stability(tower(2)).margin, rel=0.015)
    tight = hf.stability(bridge(top_load=33.0))
    assert tight.stable
    assert tight.margin < 0.9 * hf.stability(bridge()).margin


def test_orders_crush_nothing() -> None:
    """Three posts bear 46 N each of a beam with a block on it, two of them 69 N."""
    scene = bridge(4.0, top_load=60.0)
    without = hf.can_remove(scene, "post1", lift=(0, 1, 0))
    assert not without.safe
    assert "would be crushed" in without.reason
    assert "crushed" not in hf.can_remove(bridge(4.0, top_load=75.0), "post1", lift=(0, 1, 0)).reason
    assert hf.build_order(scene, pushes=0).reached
    with pytest.raises(hf.HoldfastError, match=r"bears 45\.78 N of 40 N on top"):
        hf.disassembly_order(bridge(4.0, top_load=40.0))


def test_answers_that_do_not_ask_who_is_crushed_say_so() -> None:
    note = "who is crushed was not asked here"
    scene = tower(2, top_load=250.0)
    assert note in " ".join(hf.robustness_map(scene, ["box1"], spacing=0.2).notes)
    for exists in (True, False):
        assert note in " ".join(hf.sets.constraint(scene, "box1", exists=exists, solves=20).notes)
    assert note in " ".join(hf.sets.sustainable_accelerations(scene, solves=8).notes)
    push = scene.body("box1").pose[:3, 3] + (0, 0, 0.15), (0.1, 0, -1)
    uncertain = hf.sets.Uncertain(mu_range=0.1, samples=2)
    assert note in " ".join(hf.robustness_under(scene, "box1", *push, uncertain).notes)
    assert note in " ".join(hf.transport_under(scene, (1, 0, 0), uncertain).notes)
    assert note in hf.sets.worst_case(scene, "box1", *push).notes[0]
    for found in (hf.stability(scene), hf.transport_limits(scene, [(1, 0, 0)])):
        assert note not in " ".join(found.notes)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("limits", [{"top_load": 250.0}, {"top_load": 400.0}, {"pressure": 2600.0}, {"top_load": 0.0}])
def test_many_poses_ask_who_is_crushed_as_single_calls_do(engine: str, limits: dict[str, float]) -> None:
    """The topmost of four boxes where it is, beside the others, half off its place, in the air, and in another."""
    assembly = hf.assemble(tower(**limits))
    poses = [hf.pose(*p) for p in ((0, 0, 1.05), (1, 0, 0.15), (0.1, 0.1, 1.05), (0, 0, 1.2), (0, 0, 0.95))]
    tops = np.array([pose[:3, 3] + (0, 0, 0.15) for pose in poses])
    stands = hf.stability_of_poses(assembly, "box3", poses, engine=engine)
    for way in ((0, 0, -1), (1, 0, 0)):
        pushes = hf.robustness_of_poses(assembly, "box3", poses, tops, way, engine=engine)
        for k, pose in enumerate(poses):
            at = assembly.moved({"box3": pose})
            one, push = hf.stability(at, engine=engine), hf.robustness(at, "box3", tops[k], way, engine=engine)
            assert stands.stable[k] == one.stable
            assert one.status is not hf.Status.STABLE or not one.crushed or stands.moving[k] == one.crushed
            for name in ("force", "lower", "upper", "status"):
                assert getattr(pushes, name)[k] == getattr(push, name)[0]
    # by hand: box0 bears the boxes above it, 2 or 3 of 98.1 N each, on 0.12 m²
    load, most = np.array([3, 2, 3]) * 10 * G, limits.get("top_load", limits.get("pressure", 0.0) * 0.12)
    own = 0 if "top_load" in limits else 10 * G  # the floor presses a box, too
    assert (stands.status[:3] == hf.Status.STABLE).tolist() == (load + own <= most).tolist()


def test_what_a_held_body_bears_limits_nothing_and_is_told() -> None:
    hand = hf.Hold("box0", hf.pose(0, 0, 0.3), forces=(0, 0, (-2000, -1000)))
    held = hf.Scene(tower(1, top_load=50.0).bodies, 0.5, holds=[hand])
    found = hf.transport_limits(held, [(0, 0, 1)], engine="limit")
    assert found.mode[0] != "crush"
    assert any("what box0 may bear was not compared" in note for note in found.notes)


def test_the_strength_of_a_carton_is_that_of_mckee() -> None:
    dry = box_compression_strength(5600, 4e-3, 1.4)
    assert dry == pytest.approx(5.87 * 5600 * np.sqrt(1.4 * 4e-3))
    assert box_compression_strength(5600, 4e-3, 1.4, humidity=0.65, days=1) == pytest.approx(dry * 0.8 * 0.63)
    with pytest.raises(hf.HoldfastError, match="humidity"):
        box_compression_strength(5600, 4e-3, 1.4, humidity=80)


def test_a_load_just_within_friction_ends_where_a_post_is_crushed() -> None:
    """Forces are known far below its largest factor alone, and its answer was that factor, 2,976."""
    post = hf.Box((0.1, 0.3, 0.3))
    bodies = [
        hf.Body("left", post, 1.0, position=(-0.45, 0, 0.15), top_load=100.0),
        hf.Body("right", post, 1.0, position=(0.45, 0, 0.15)),
        hf.Body("board", hf.Box((1.0, 0.3, 0.02)), 3.0, position=(0, 0, 0.31)),
        hf.Body("block", hf.Box((0.2, 0.2, 0.2)), 3.0, position=(-0.3, 0, 0.42)),
    ]
    load = hf.Load("left", (-0.45, 0, 0.15), (-1.5, -10.1, -17))
    found = hf.load_factor(hf.Scene([FLOOR, *bodies], 0.6), [load])
    by_hand = (100 - 1.5 * G - 3 * G * 0.75 / 0.9) / 17
    assert (found.mode, found.moving) == ("crush", ("left",))
    assert float(found) == pytest.approx(by_hand, rel=0.05)
    assert found.lower == pytest.approx(float(found), rel=1e-5)
