"""Orders in which assemblies come apart: exact ones, and the fewest removals by brute force over all orders."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.disassembly.removal import Answer
from holdfast.base.rigid import pose_from
from holdfast.engines.limit_engine import comes_loose
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import at, box, floor, prism, wall

X, Y, Z = np.eye(3)


@cache
def shipped(name: str) -> hf.answers.Assembly:
    return hf.assemble(shipped_scene(name))


def still(name: str, size: tuple[float, float, float], centre: tuple[float, float, float]) -> hf.Body:
    return hf.Body(name, hf.Box(np.array(size)), pose=at(*centre), fixed=True)


# ---- exact orders


def test_a_stack_comes_apart_from_the_top() -> None:
    d = hf.disassembly_order(shipped("stack"))
    assert d.order == ("cube3", "cube2", "cube1")
    assert d.assembly_order == ("cube1", "cube2", "cube3")
    assert d.reached
    assert d.proven
    assert d.blocked == {}
    assert d.remaining == ()
    assert (d.engine, d.claim) == ("compliant", hf.answers.Claim.HOLDS)
    now = {r.body: r for r in d.answers()}
    assert [now[f"cube{k}"].answer for k in (1, 2, 3)] == [Answer.UNSAFE, Answer.UNSAFE, Answer.SAFE]
    assert now["cube2"].blockers == (("cube3", 0.0),)
    assert now["cube1"].blockers == (("cube2", 0.0), ("cube3", pytest.approx(0.1)))
    assert now["cube2"].moving == ("cube3",)
    assert "blocked: cube3" in now["cube2"].reason
    assert "cube3 would move" in now["cube2"].reason


def test_a_table_loses_its_slab_first_then_either_leg() -> None:
    d = hf.disassembly_order(shipped("table"))
    assert d.order[0] == "slab"
    after = {r.body: r.answer for r in d.answers(1)}
    assert after == {"leg_left": Answer.SAFE, "leg_right": Answer.SAFE}
    assert hf.disassembly_order(shipped("table"), goal="leg_left").order == ("slab", "leg_left")
    assert hf.disassembly_order(shipped("table"), goal=["leg_right"]).order == ("slab", "leg_right")


@pytest.mark.parametrize("engine", ["compliant", "limit", "graph"])
def test_no_voussoir_of_an_arch_is_safe_first(engine: str) -> None:
    d = hf.disassembly_order(shipped("arch"), engine=engine)
    assert d.order == ()
    assert not d.reached
    assert d.proven
    assert set(d.blocked) == {f"v{k}" for k in range(1, 6)}
    assert "would move" in d.blocked["v3"]
    assert "blocked: v2" in d.blocked["v1"]


def test_the_papers_table_calls_three_voussoirs_removable() -> None:
    """Why it does not decide: R at the centre of mass upward is the weight, and the arch falls without them."""
    d = hf.disassembly_order(shipped("arch"), engine="graph")
    rows = {row.body: row for row in d.paper_table()}
    assert {name for name, row in rows.items() if row.removable} >= {"v3"}
    assert rows["v3"].weight == pytest.approx(9.81 * shipped("arch").scene.body("v3").mass)


@pytest.mark.parametrize("engine", ["compliant", "limit", "graph"])
def test_the_counterweight_stays_until_the_load_is_gone(engine: str) -> None:
    """Fig. 16."""
    d = hf.disassembly_order(shipped("cantilever"), engine=engine)
    assert d.order == ("C", "D", "B", "A")
    now = {r.body: r for r in d.answers()}
    assert now["D"].answer is Answer.UNSAFE
    assert set(now["D"].moving) == {"B", "C"}
    assert hf.disassembly_order(shipped("cantilever"), engine=engine, goal="D").order == ("C", "D")


def test_the_papers_table_of_fig_16() -> None:
    d = hf.disassembly_order(shipped("cantilever"))
    first = {row.body: row for row in d.paper_table()}
    assert first["C"].removable
    assert first["C"].force == pytest.approx(0.5 * 9.81, rel=1e-4)
    assert not first["D"].removable
    assert [row.body for row in d.paper_table(3)] == ["A"]
    with pytest.raises(hf.HoldfastError, match="step: is 5; needs a whole number of at most 4"):
        d.paper_table(5)


def drawer(load: bool = False) -> hf.Scene:
    """A drawer flush in a slot that is open towards -y."""
    bodies = [
        still("bottom", (0.3, 0.3, 0.02), (0, 0, -0.01)),
        still("top", (0.3, 0.3, 0.02), (0, 0, 0.11)),
        still("left", (0.05, 0.3, 0.1), (-0.125, 0, 0.05)),
        still("right", (0.05, 0.3, 0.1), (0.125, 0, 0.05)),
        still("back", (0.3, 0.02, 0.1), (0, 0.16, 0.05)),
        box("drawer", (0.2, 0.3, 0.1), 2, (0, 0, 0.05)),
    ]
    return hf.Scene(bodies, 0.4, name="drawer")


def test_a_drawer_leaves_its_slot_sideways_only() -> None:
    assembly = hf.assemble(drawer())
    up = hf.disassembly_order(assembly)
    assert up.order == ()
    assert up.blocked == {"drawer": "its way out along (0, 0, 1) is blocked: top"}
    assert hf.disassembly_order(assembly, lift=(0, -2, 0)).order == ("drawer",)
    for lift, wall_ in ((Y, "back"), (X, "right"), (-X, "left"), (-Z, "bottom")):
        assert wall_ in hf.disassembly_order(assembly, lift=lift).blocked["drawer"]


def test_pulled_from_under_a_lintel_it_takes_nothing_along() -> None:
    """Two posts carry a lintel; a light block between them is pulled out; one that bears the lintel is not."""
    posts = [box("post1", (0.1, 0.1, 0.2), 2, (-0.3, 0, 0.1)), box("post2", (0.1, 0.1, 0.2), 2, (0.3, 0, 0.1))]
    lintel = box("lintel", (0.8, 0.1, 0.05), 5, (0, 0, 0.225))
    low = box("low", (0.1, 0.1, 0.19), 1, (0, 0, 0.095))
    d = hf.disassembly_order(hf.assemble(hf.Scene([floor(), *posts, lintel, low], 0.5)), lift=(0, 1, 0), goal="low")
    assert d.order == ("low",)
    prop = box("prop", (0.1, 0.1, 0.2), 1, (0.1, 0, 0.1))
    short = hf.Scene([floor(), posts[0], prop, lintel], 0.5)
    d = hf.disassembly_order(hf.assemble(short), lift=(0, 1, 0), goal="prop")
    assert d.order == ("lintel", "prop")  # sideways, the lintel is free to go as well
    assert "lintel" in {r.body: r for r in d.answers()}["prop"].moving


# ---- wedges and clamps


def test_between_two_walls_nothing_clamps_a_light_touch() -> None:
    assembly = shipped("wedged_floor")
    assert not comes_loose(assembly, "cube", Z)  # on paper the walls could
    d = hf.disassembly_order(assembly)
    assert d.order == ("cube",)
    assert d.steps[0].lift == pytest.approx(1.0, abs=1e-6)
    told = hf.disassembly_order(assembly, engine="limit")
    assert told.order == ()
    assert "could clamp" in told.blocked["cube"]
    assert not told.proven


def vice(mu: float, mass: float = 1.0) -> hf.Scene:
    """A block between two wedges of 4 kg that smooth ramps of 1:2 drive against it."""
    left = np.array([[-0.25, 0.15], [-0.05, 0.05], [-0.05, 0.25], [-0.25, 0.25]])
    ramp = np.array([[-0.25, 0.0], [-0.06, 0.0], [-0.06, 0.055], [-0.25, 0.15]])
    flip = np.array([-1, 1])
    bodies = [
        floor(),
        prism("ramp1", ramp, 0.1, 1, fixed=True),
        prism("ramp2", (ramp * flip)[::-1], 0.1, 1, fixed=True),
        prism("wedge1", left, 0.1, 1, mass=4.0),
        prism("wedge2", (left * flip)[::-1], 0.1, 1, mass=4.0),
        box("block", (0.1, 0.1, 0.25), mass, (0, 0, 0.125)),
    ]
    smooth = {(f"ramp{k}", f"wedge{k}"): 0.0 for k in (1, 2)}
    return hf.Scene(bodies, hf.Friction(mu, smooth), name="vice")


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_vice_holds_a_block_beyond_its_weight(mu: float) -> None:
    """Its wedges press by N = M g tan / (1 + mu tan) as it slips up; without it they slide in."""
    d = hf.disassembly_order(hf.assemble(vice(mu)))
    block = {r.body: r for r in d.answers()}["block"]
    assert block.answer is Answer.UNSAFE
    assert set(block.moving) & {"wedge1", "wedge2"}
    part = frozenset({"block", "wedge1", "wedge2"})
    removals = d.removals
    assert not comes_loose(removals.reduced(part), "block", Z)
    off = removals._comes_off("block", part)
    assert off.lift == pytest.approx(1 + 2 * mu * 4 * 0.5 / (1 + mu * 0.5), rel=5e-3)


# ---- searching


@cache
def small_wall(courses: int, bricks: int) -> hf.answers.Assembly:
    return hf.assemble(wall(courses, bricks, 0.25, "wall"))


def stands(scene: hf.Scene, names: frozenset[str]) -> bool:
    """From scratch."""
    kept = [body for body in scene.bodies if body.fixed or body.name in names]
    return hf.stability(hf.assemble(hf.Scene(kept, scene.friction, scene.gravity), gap=1e-4)).status is hf.Status.STABLE


def brute_force(scene: hf.Scene, goal: str) -> int:
    """The fewest removals by looking at all sets of bodies in order of their size; exits: no brick above overlaps."""
    names = [body.name for body in scene.movable]
    x, z = ({b.name: b.pose[k, 3] for b in scene.movable} for k in (0, 2))
    memory: dict[frozenset[str], bool] = {}

    def ok(left: frozenset[str]) -> bool:
        if left not in memory:
            memory[left] = stands(scene, left)
        return memory[left]

    def free(name: str, left: frozenset[str]) -> bool:
        return not any(z[o] > z[name] + 0.01 and abs(x[o] - x[name]) < 0.199 for o in left)

    states = {frozenset(names)}
    for count in itertools.count(1):
        states = {s - {n} for s in states for n in s if free(n, s) and ok(s - {n})}
        if any(goal not in s for s in states):
            return count
        assert states
    raise AssertionError


@pytest.mark.parametrize("goal", ["b0_0", "b0_1", "b1_1", "b2_0"])
def test_the_fewest_removals_on_a_wall(goal: str) -> None:
    assembly = small_wall(3, 2)
    d = hf.disassembly_order(assembly, goal=goal)
    assert d.reached
    assert d.proven
    assert d.order[-1] == goal
    assert len(d.order) == d.fewest == brute_force(assembly.scene, goal)


def seesaw() -> hf.Scene:
    """A plank across a column with equal weights on both ends: neither may go alone, unless a prop bears the plank."""
    return hf.Scene(
        [
            floor(),
            box("column", (0.1, 0.1, 0.2), 2, (0, 0, 0.1)),
            box("plank", (0.6, 0.1, 0.02), 1, (0, 0, 0.21)),
            box("load", (0.1, 0.1, 0.1), 2, (-0.2, 0, 0.27)),
            box("weight", (0.05, 0.05, 0.05), 1.2, (0.24, 0, 0.245)),
        ],
        0.6,
    )


def test_what_would_fall_is_taken_first_although_it_is_in_nobodys_way() -> None:
    """The load goes only after... nothing helps: without it the weight tips the plank, and the other way round."""
    d = hf.disassembly_order(hf.assemble(seesaw()), goal="load")
    assert not d.reached
    assert d.fewest == np.inf
    assert d.proven
    assert set(d.blocked) == {"column", "plank", "load", "weight"}
    assert "would move" in d.blocked["load"]


def falsework() -> hf.Scene:
    """The seesaw with a prop that bears its plank beside the column, and can itself be pulled out sideways."""
    scene = seesaw()
    prop = box("prop", (0.04, 0.1, 0.2), 1, (0.2, 0, 0.1))
    return hf.Scene([prop, *scene.bodies], 0.6)


def test_backing_up_where_the_first_choice_leads_nowhere() -> None:
    """Taking the prop out first is safe and leaves the seesaw stuck; the search has to come back from there."""
    assembly = hf.assemble(falsework())
    up = hf.disassembly_order(assembly)
    assert up.reached
    sideways = hf.disassembly_order(assembly, lift=(0, 1, 0))
    assert sideways.reached
    assert sideways.answers()[0].answer is Answer.SAFE  # the prop, which is tried first
    assert sideways.order.index("prop") > sideways.order.index("load")
    assert not hf.disassembly_order(assembly.without(["prop"]), lift=(0, 1, 0)).reached


def test_a_budget_ends_the_search_and_says_so() -> None:
    d = hf.disassembly_order(hf.assemble(seesaw()), goal="load", solves=0)
    assert not d.proven
    assert d.fewest < np.inf


def test_separate_stacks_are_judged_apart() -> None:
    two = [
        box(f"{side}{k}", (0.1, 0.1, 0.1), 1, (x, 0, 0.05 + 0.1 * k))
        for side, x in (("l", -0.2), ("r", 0.2))
        for k in range(3)
    ]
    d = hf.disassembly_order(hf.assemble(hf.Scene([floor(), *two], 0.6)))
    assert d.reached
    assert d.removals.checks == 6, "once for each body of each stack"


@pytest.mark.parametrize(("lift", "order"), [((0, 0, 1), "bac"), ((0.5, 0, 1), "cba")])
def test_what_is_farthest_along_the_lift_goes_first(lift: tuple[float, float, float], order: str) -> None:
    """Centres at (x, z) = (-1, 0.1), (0, 0.2) and (1, 0.05): along (0.5, 0, 1) they are at -0.4, 0.2 and 0.55."""
    blocks = [
        box(name, (0.1, 0.1, 2 * z), 1, (x, 0, z)) for name, x, z in (("a", -1, 0.1), ("b", 0, 0.2), ("c", 1, 0.05))
    ]
    assert "".join(hf.disassembly_order(hf.Scene([floor(4), *blocks], 0.6), lift=lift).order) == order


# ---- invariances


def test_the_order_of_bodies_and_the_frame_change_nothing() -> None:
    scene = shipped_scene("cantilever")
    turn = pose_from(np.array([0.3, -1, 2]), np.array([0.8, 0.1, -0.5, 0.3]))
    bodies = [hf.Body(b.name, b.shape, mass=b.mass, pose=turn @ b.pose, fixed=b.fixed) for b in reversed(scene.bodies)]
    moved = hf.Scene(bodies, scene.friction, turn[:3, :3] @ scene.gravity)
    d = hf.disassembly_order(hf.assemble(moved), lift=turn[:3, :3] @ Z)
    assert d.order == ("C", "D", "B", "A")


# ---- bad input


def test_what_does_not_stand_or_may_not_is_refused_with_the_verdict() -> None:
    with pytest.raises(hf.errors.UnstableError, match=r"does not stand.*cube slides.*only what stands"):
        hf.disassembly_order(shipped("wedged"))
    with pytest.raises(hf.errors.SolverError, match=r"undecided.*for certain"):
        hf.disassembly_order(shipped("wedged"), engine="limit")


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"goal": "cube9"}, "did you mean"),
        ({"goal": "floor"}, "'floor' is fixed"),
        ({"goal": ()}, "is empty"),
        ({"goal": 3}, "goal: got 3; needs"),
    ],
)
def test_bad_requests(options: dict[str, object], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.disassembly_order(shipped("stack"), **options)


@pytest.mark.parametrize("budget", [0, 1, 3])
def test_a_search_for_all_asks_no_more_than_its_budget(budget: int) -> None:
    """It ends in the middle of a step, too, and then proves nothing."""
    scene = hf.shipped_scene("tabletop")
    found = hf.disassembly_order(scene, engine="limit", solves=budget)
    assert found.removals.checks <= budget
    assert not found.reached
    assert not found.proven
