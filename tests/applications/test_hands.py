"""Orders in which hands hold bodies: which, how strongly, and what falsework stands in for hands that lack."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.voussoirs import arch_of
from holdfast.answers import Assembly
from holdfast.applications.disassembly.hands import Hands, held_still
from holdfast.applications.disassembly.least_hold import HandHold, least_holds
from holdfast.applications.disassembly.removal import Answer, Removals, pressing_on
from holdfast.scene.shipped.blocks import arch

G = 9.81


def stands(assembly: Assembly, holds: tuple[HandHold, ...], share: float) -> bool:
    """Whether everything stands with hands of this share of their strength, by engine ``limit``."""
    hands = []
    for hold in holds:
        frame = hf.pose(*assembly.com[assembly.index[hold.body]])
        force, moment = (share * float(np.linalg.norm(each)) for each in (hold.force, hold.moment))
        hands.append(hf.Hold(hold.body, frame, force, moment))
    return hf.stability(assembly.with_holds(*hands), engine=hf.Limit()).equilibrium_exists is True


@pytest.fixture(scope="module")
def voussoirs() -> Assembly:
    """The arch of 13 voussoirs."""
    return hf.assemble(arch_of(13))


@pytest.mark.parametrize("engine", ["compliant", "limit"])
def test_an_arch_of_13_voussoirs_is_built_with_two_hands(voussoirs: Assembly, engine: str) -> None:
    """Each state stands with hands of the strengths that its step names, and of hardly less it does not."""
    order = hf.build_order(voussoirs, hands=2, engine=engine)
    assert order.reached
    assert not order.falsework
    assert max(len(step.holds) for step in order.steps) == 2
    for number, step in enumerate(order.steps):
        state = voussoirs.without(order.order[number:])
        assert not state.movable or stands(state, step.holds, 1 + 1e-4)
        assert not step.holds or not stands(state, step.holds, 0.98)


@pytest.mark.parametrize(("name", "prop"), [("shipped", "v2"), ("13", "v5")])
def test_one_hand_and_one_prop_build_an_arch(voussoirs: Assembly, name: str, prop: str) -> None:
    assembly = hf.assemble(arch()) if name == "shipped" else voussoirs
    order = hf.build_order(assembly, hands=1)
    assert not order.reached
    assert order.falsework == (prop,)
    assert order.first == order.stuck == ()
    assert {hold.body for step in order.steps for hold in step.holds if hold.prop} == {prop}
    assert all(sum(not hold.prop for hold in step.holds) <= 1 for step in order.steps)
    assert "falsework" in order.to_dict()
    assert prop in order.summary().facts[1][1]


def test_hands_that_let_go_leave_what_the_next_ones_and_the_gripper_hold(voussoirs: Assembly) -> None:
    order = hf.build_order(voussoirs, hands=2, engine="limit")
    for number in range(len(order.steps) - 1):
        state = voussoirs.without(order.order[number + 1 :])
        now, then = ({hold.body for hold in order.steps[k].holds} for k in (number, number + 1))
        held = frozenset((now & then) | {order.order[number]})
        rest = held_still(state, held)
        assert not rest.movable or hf.stability(rest, engine="limit").stable


def test_hands_change_their_hold_only_where_all_stands_without_them() -> None:
    """A plank tips off its support unless one of two light bodies on its other end is held; a cube stands aside."""
    bodies = [
        hf.Body("ground", hf.HalfSpace(), fixed=True),
        hf.Body("support", hf.Box((0.1, 0.2, 0.1)), fixed=True, position=(0, 0, 0.05)),
        hf.Body("plank", hf.Box((0.6, 0.2, 0.02)), mass=1.0, position=(0.1, 0, 0.11)),
        hf.Body("a", hf.Box((0.04, 0.04, 0.04)), mass=0.05, position=(-0.15, 0.05, 0.14)),
        hf.Body("b", hf.Box((0.04, 0.04, 0.04)), mass=0.05, position=(-0.15, -0.05, 0.14)),
        hf.Body("aside", hf.Box((0.1, 0.1, 0.1)), mass=1.0, position=(2, 0, 0.05)),
    ]
    asked = Hands(Removals(hf.assemble(hf.Scene(bodies, 0.5)), hf.Limit(), np.array([0.0, 0, 1])))
    a, b, all_ = frozenset("a"), frozenset("b"), frozenset({"plank", "a", "b", "aside"})
    for before, after, safe in ((a, a, True), (b, b, True), (a, a | b, True), (a | b, b, True), (a, b, False)):
        found = asked.removal("aside", all_, before, after).answer
        assert (found is Answer.SAFE) is safe, f"{set(before)} then {set(after)}"


def test_an_arch_is_taken_apart_with_two_hands() -> None:
    order = hf.disassembly_order(arch(), hands=2)
    assert order.reached
    assert order.order[0] == "v3"
    assert {hold.body for hold in order.steps[0].holds} == {"v2", "v4"}
    assert not hf.disassembly_order(arch(), hands=1).reached
    assert hf.disassembly_order(arch(), hands=1).falsework == ("v2",)
    assert hf.disassembly_order(arch(), hands=2, goal="v3").order == ("v3",)


def test_can_remove_says_what_to_hold() -> None:
    plain, one, two = (hf.can_remove(arch(), "v3", hands=hands) for hands in (0, 1, 2))
    assert plain == one
    assert not plain.holds
    assert not two.safe
    assert {hold.body for hold in two.holds} == {"v2", "v4"}
    assert "it may with hands" in two.reason
    assert stands(hf.assemble(arch()).without("v3"), two.holds, 1 + 1e-4)


def test_hands_that_are_not_needed_change_nothing() -> None:
    wall = hf.shipped_scene("wall2x2")
    assert hf.build_order(wall, hands=2, pushes=0).steps == hf.build_order(wall, pushes=0).steps
    assert hf.disassembly_order(wall, hands=1).steps == hf.disassembly_order(wall).steps


def overhanging(out: float) -> Assembly:
    """A plank of 2 kg and 0.4 m whose centre is ``out`` beyond the edge of a fixed table."""
    bodies = [
        hf.Body("table", hf.Box((1, 1, 0.1)), fixed=True, position=(-0.5, 0, -0.05)),
        hf.Body("plank", hf.Box((0.4, 0.1, 0.02)), mass=2.0, position=(out, 0, 0.01)),
    ]
    return hf.assemble(hf.Scene(bodies, 0.5))


def test_the_least_hold_of_a_plank_over_an_edge_is_a_moment() -> None:
    """min |F| + |M| / size with M = (m g - F) e: all of it a moment, as the edge is nearer than the plank is long."""
    (hold,) = least_holds(overhanging(0.05), ["plank"]) or ()
    assert np.linalg.norm(hold.force) == pytest.approx(0, abs=1e-6)
    assert np.linalg.norm(hold.moment) == pytest.approx(2 * G * 0.05, rel=1e-6)
    (hold,) = least_holds(overhanging(-0.05), ["plank"]) or ()
    assert not hold.force.any()
    assert not hold.moment.any()


def test_the_least_hold_of_a_body_in_the_air_is_its_weight() -> None:
    scene = hf.Scene(
        [
            hf.Body("floor", hf.Box((1, 1, 0.1)), fixed=True, position=(0, 0, -0.05)),
            hf.Body("cup", hf.Box((0.1, 0.1, 0.1)), mass=0.3, position=(0, 0, 1)),
        ],
        0.5,
    )
    (hold,) = least_holds(hf.assemble(scene), ["cup"]) or ()
    assert hold.force == pytest.approx([0, 0, 0.3 * G], rel=1e-6)
    assert "2.94 N" in hold.text


def test_what_a_body_presses_on_its_neighbours_is_its_weight() -> None:
    """The topmost of three cubes, off the middle of the one below by 2 cm, presses it down there, and nothing else."""
    places = [(0, 0, 0.05), (0, 0, 0.15), (0, 0.02, 0.25)]
    cubes = [hf.Body(f"c{k}", hf.Box((0.1,) * 3), mass=1.0 + k, position=at) for k, at in enumerate(places)]
    whole = hf.assemble(hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), *cubes], 0.5))
    forces = hf.stability(whole).forces
    assert forces is not None
    load = pressing_on(whole.without({"c2"}), "c2", whole, forces)
    np.testing.assert_allclose(load, [*[0.0] * 6, 0, 0, -3 * 9.81, -3 * 9.81 * 0.02, 0, 0], atol=1e-8)
