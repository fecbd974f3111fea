"""Groups: no answer about one body depends on an unrelated one, to the last bit, by every engine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from placed import at

import holdfast as hf
from holdfast.assembly.one_group import part_of
from holdfast.engines.answers import Answers
from holdfast.engines.groups import prepared
from holdfast.engines.joint_answers import SmallestAnswers
from holdfast.engines.verdict import Verdict
from holdfast.queries.request import ENGINES

GAP = 1e-4
ENGINES_TESTED = ("graph", "limit", "compliant")


FLOOR = hf.Body("floor", hf.Box((6, 6, 0.1)), pose=at(0, 0, -0.05), fixed=True)


def cube(name: str, x: float, y: float, z: float = 0.05, **options: Any) -> hf.Body:
    return hf.Body(name, hf.Box((0.1, 0.1, 0.1)), pose=at(x, y, z), **{"mass": 1.0, **options})


STACK = (cube("low", 0, 0), cube("high", 0.02, 0.01, 0.15, mass=0.4))
STRANGERS = {
    "a ball": (hf.Body("ball", hf.Sphere(0.05), mass=0.5, pose=at(1, 0, 0.05)),),
    "a body in the air": (cube("air", -1, 0, 0.5),),
    "two bodies in the air": (cube("air", -1, 0, 0.5), cube("on air", -1, 0, 0.6)),
    "a falling body": (cube("edge", 0, 1), cube("falls", 0.08, 1, 0.15)),
    "a heavy block": (hf.Body("block", hf.Box((0.5, 0.5, 0.5)), mass=300.0, pose=at(0, -1, 0.25)),),
}
POINTS = np.array([[-0.05, 0.0, 0.05], [0.05, 0.02, 0.06], [0.01, -0.05, 0.02]])
DIRECTIONS = np.array([[1.0, 0, 0], [-1.0, 0.2, 0.3], [0.1, 1.0, -0.4]])


def scene(bodies: tuple[hf.Body, ...]) -> hf.Scene:
    return hf.Scene([FLOOR, *bodies], 0.5)


def assert_same_rows(one: Any, other: Any, names: tuple[str, ...] = ()) -> None:
    for name in ("force", "lower", "upper"):
        assert getattr(one.answers, name).tobytes() == getattr(other.answers, name).tobytes(), name
    for name in ("status", "moving", "mode", *names):
        assert getattr(one.answers, name).tolist() == getattr(other.answers, name).tolist(), name
    texts = [[None if m is None else m.text for m in each.answers.mechanism] for each in (one, other)]
    assert texts[0] == texts[1]
    assert one.verdict.status is other.verdict.status
    assert one.verdict.reason == other.verdict.reason
    assert one.notes == other.notes


@pytest.mark.parametrize("engine", ENGINES_TESTED)
@pytest.mark.parametrize("stranger", STRANGERS)
@pytest.mark.parametrize("first", [False, True])
def test_a_stranger_changes_no_bit_of_a_push(engine: str, stranger: str, first: bool) -> None:
    bodies = (*STRANGERS[stranger], *STACK) if first else (*STACK, *STRANGERS[stranger])
    alone = hf.robustness(hf.assemble(scene(STACK), gap=GAP), "low", POINTS, DIRECTIONS, engine=engine)
    beside = hf.robustness(hf.assemble(scene(bodies), gap=GAP), "low", POINTS, DIRECTIONS, engine=engine)
    assert (alone.force > 0).all()
    assert_same_rows(alone, beside)


@pytest.mark.parametrize("engine", ENGINES_TESTED)
def test_the_map_covers_every_group_that_stands(engine: str) -> None:
    alone = hf.robustness_map(hf.assemble(scene(STACK), gap=GAP), spacing=0.05, engine=engine)
    strangers = (*STRANGERS["a falling body"], *STRANGERS["a body in the air"])
    mixed = hf.robustness_map(hf.assemble(scene((*strangers, *STACK)), gap=GAP), spacing=0.05, engine=engine)
    rows = np.isin(mixed.body.astype(str), ("low", "high"))
    assert mixed.force[rows].tobytes() == alone.force.tobytes()
    assert mixed.lower[rows].tobytes() == alone.lower.tobytes()
    assert set(mixed.status[~rows]) == {hf.Status.UNSTABLE}
    assert mixed.verdict.status is hf.Status.UNSTABLE
    told = " ".join(mixed.notes)
    assert "air: does not stand: unsupported" in told
    assert "edge, falls: does not stand" in told
    assert "low" not in told


@settings(max_examples=15, deadline=None)
@given(
    st.sampled_from(ENGINES_TESTED), st.lists(st.sampled_from(sorted(STRANGERS)), unique=True, max_size=3), st.data()
)
def test_any_order_of_bodies_gives_the_same_answers(engine: str, strangers: list[str], data: st.DataObject) -> None:
    others = {body.name: body for name in strangers for body in STRANGERS[name]}
    bodies = data.draw(st.permutations([*STACK, *others.values()]))
    alone = hf.robustness(hf.assemble(scene(STACK), gap=GAP), "high", (-0.03, 0.01, 0.15), (1, 0, 0), engine=engine)
    mixed = hf.robustness(
        hf.assemble(scene(tuple(bodies)), gap=GAP), "high", (-0.03, 0.01, 0.15), (1, 0, 0), engine=engine
    )
    assert mixed.force == pytest.approx(alone.force, rel=1e-9)
    assert mixed.moving.tolist() == alone.moving.tolist()


def test_stability_judges_every_group() -> None:
    bodies = (*STRANGERS["a ball"], *STRANGERS["two bodies in the air"], *STACK)
    found = hf.stability(hf.assemble(scene(bodies), gap=GAP))
    assert found.status is hf.Status.UNSTABLE
    assert [(g.bodies, g.verdict.status.value) for g in found.groups] == [
        (("ball",), "stable"),
        (("air", "on air"), "unstable"),
        (("low", "high"), "stable"),
    ]
    assert found.moving == ("air", "on air")
    assert "unsupported: air, on air" in found.reason
    assert "2 of 3 groups do not depend on this" in found.reason
    assert found.mechanism.twists.shape == (5, 6)
    assert (found.mechanism.twists[[0, 3, 4]] == 0).all()
    assert (found.mechanism.twists[1:3, 2] < 0).all()


@pytest.mark.parametrize("engine", ENGINES_TESTED)
def test_contact_forces_of_groups_are_those_of_the_whole(engine: str) -> None:
    """In the order of the interfaces, on their second bodies: together with gravity they balance every body."""
    bodies = (cube("right", 1, 0), *reversed(STACK), cube("left", -1, 0.3))  # the upper one first: contacts are flipped
    assembly = hf.assemble(scene(bodies), gap=GAP)
    assert any(part_of(assembly, group).flipped.any() for group in assembly.groups)
    forces = hf.stability(assembly, engine=engine).forces
    assert (np.diff(forces.interface) >= 0).all()
    total = {body.name: np.array([0, 0, -9.81 * (body.mass or 0)]) for body in bodies}
    for number, interface in enumerate(assembly.interfaces):
        here = forces.force[forces.interface == number].sum(0)
        for name, sign in zip(interface.bodies, (-1, 1), strict=True):
            if name in total:
                total[name] = total[name] + sign * here
            outward = forces.normal[forces.interface == number]
            assert np.allclose(outward, interface.patches[0].normal)
    for name, left in total.items():
        assert np.abs(left).max() < 1e-6 * 9.81, name


@pytest.mark.parametrize("first", [1, -1])
def test_a_load_on_several_groups_is_carried_as_far_as_by_the_weakest(first: int) -> None:
    """Two cubes that slip at 4.905 and 2.4525 N, both pulled by 1 N: the second one goes first."""
    assembly = hf.assemble(scene((cube("one", 0, 0), cube("two", 1, 0, mass=0.5))[::first]), gap=GAP)
    loads = [hf.Load(name, (x, 0, 0.0), force=(1, 0, 0)) for name, x in (("one", 0), ("two", 1))]
    for engine in ENGINES_TESTED:
        found = hf.load_factor(assembly, loads, engine=engine)
        assert found.factor == pytest.approx(0.5 * 0.5 * 9.81, rel=1e-5)
        assert found.moving == ("two",)
        alone = hf.load_factor(assembly, loads[1:], engine=engine)
        assert (found.lower, found.upper) == (alone.lower, alone.upper)


@pytest.mark.parametrize("engine", ENGINES_TESTED)
@pytest.mark.parametrize("stranger", ["a heavy block", "a body in the air", "a falling body"])
def test_rows_on_one_group_are_the_same_beside_rows_on_another(engine: str, stranger: str) -> None:
    """Loads that all act on one group are answered by its own table, others by the smallest of several."""
    assembly = hf.assemble(scene((*STACK, *STRANGERS[stranger])), gap=GAP)
    other = STRANGERS[stranger][-1].name
    W = np.zeros((6 * len(assembly.movable), 4))
    W[6 * assembly.index["high"] : 6 * assembly.index["high"] + 3, :3] = DIRECTIONS.T
    W[6 * assembly.index[other], 3] = 1.0
    groups = prepared(ENGINES[engine](), assembly)
    alone, beside, falls = groups.load_factor(W[:, :3]), groups.load_factor(W), groups.load_factor(W[:, 3:])
    for name in ("force", "lower", "upper"):
        assert getattr(beside, name).tobytes() == getattr(alone, name).tobytes() + getattr(falls, name).tobytes(), name
    assert [*alone.status, *falls.status] == beside.status.tolist()
    assert [None if m is None else m.text for m in (*alone.mechanism, *falls.mechanism)] == [
        None if m is None else m.text for m in beside.mechanism
    ]
    assert alone.verdict.status is hf.Status.STABLE
    assert falls.verdict.status is (hf.Status.STABLE if stranger == "a heavy block" else hf.Status.UNSTABLE)
    assert any("does not stand" in note for note in falls.notes) == (stranger != "a heavy block")
    assert {*alone.notes, *falls.notes} == {*beside.notes}


def test_an_undecided_group_leaves_the_smallest_open_but_not_below_what_gives_way_at_once() -> None:
    def rows(*rows: tuple[hf.Status, float, float]) -> Answers:
        status, force, upper = zip(*rows, strict=True)
        verdict = Verdict(status=hf.Status.STABLE, reason="")
        known = {"engine": "toy", "claim": hf.answers.Claim.HOLDS, "verdict": verdict, "mechanism": [None] * len(rows)}
        return Answers.of(force=np.array(force), status=status, upper=np.array(upper), **known)

    table = SmallestAnswers(4)
    finite, undecided, unstable = hf.Status.FINITE, hf.Status.UNDECIDED, hf.Status.UNSTABLE
    table.add(np.arange(4), rows((finite, 3.0, 4.0), (finite, 0.0, 0.0), (finite, 3.0, 4.0), (undecided, 0.0, np.inf)))
    table.add(np.arange(3), rows((undecided, 0.0, 9.0), (undecided, 0.0, 9.0), (unstable, 0.0, 0.0)))
    found = table.answers(hf.Limit(), Verdict(status=hf.Status.STABLE, reason=""), ())
    assert found.status.tolist() == [undecided, finite, unstable, undecided]
    assert found.force.tolist() == [0, 0, 0, 0]
    assert found.upper.tolist() == [4.0, 0.0, 0.0, np.inf]


@pytest.mark.parametrize("order", [1, -1])
def test_of_groups_that_all_hold_the_least_of_each_bound_counts(order: int) -> None:
    """The force 3 of one group, the bound 2 of another, whichever is asked first, and known as the worst of them."""
    known = {"engine": "toy", "claim": hf.answers.Claim.HOLDS, "verdict": Verdict(status=hf.Status.STABLE, reason="")}
    kinds = hf.answers.Bound.PROVED, hf.answers.Bound.ESTIMATED
    table = SmallestAnswers(2)
    for force, lower, upper, kind in (((3.0, 5.0), 2.9, 4.0, kinds[0]), ((5.0, np.inf), 2.0, np.inf, kinds[1]))[
        ::order
    ]:
        status = [hf.Status.FINITE if np.isfinite(f) else hf.Status.INFINITE for f in force]
        bounds = {"lower": np.full(2, lower), "upper": np.maximum(upper, force), "lower_bound": kind}
        rows = Answers.of(force=np.array(force), status=status, mechanism=[None] * 2, **bounds, **known)
        table.add(np.arange(2), rows)
    found = table.answers(hf.Limit(), known["verdict"], ())
    assert (found.force.tolist(), found.lower.tolist()) == ([3.0, 5.0], [2.0, 2.0])
    assert found.upper.tolist() == [4.0, 5.0]
    assert found.lower_bound is hf.answers.Bound.ESTIMATED


def test_a_group_that_falls_or_is_unknown_decides_the_smallest() -> None:
    both = [hf.Load("low", (0, 0, 0.05), force=(1, 0, 0)), hf.Load("air", (-1, 0, 0.5), force=(1, 0, 0))]
    found = hf.load_factor(hf.assemble(scene((*STACK, *STRANGERS["a body in the air"])), gap=GAP), both)
    assert (found.factor, found.status, found.moving) == (0.0, hf.Status.UNSTABLE, ("air",))


def test_the_part_is_in_canonical_order_whatever_the_names() -> None:
    """Names and order of the bodies differ, contacts seen from either side: the parts are alike to the last digit."""
    names = {"low": "z", "high": "a"}
    other = tuple(hf.Body(names[b.name], b.shape, mass=b.mass, pose=b.pose) for b in reversed(STACK))
    one, two = (hf.assemble(scene(bodies), gap=GAP) for bodies in (STACK, other))
    parts = [part_of(assembly, assembly.groups[0]) for assembly in (one, two)]
    assert [b.name for b in parts[0].assembly.movable] == ["low", "high"]
    assert [b.name for b in parts[1].assembly.movable] == ["z", "a"]
    for mine, yours in zip(parts[0].assembly.interfaces, parts[1].assembly.interfaces, strict=True):
        assert mine.bodies == tuple({"z": "low", "a": "high"}.get(name, name) for name in yours.bodies)
        assert np.allclose(mine.patches[0].normal, yours.patches[0].normal, atol=0)


def test_wrenches_and_derivatives_of_one_group_do_not_see_another() -> None:
    alone = hf.assemble(scene(STACK), gap=GAP)
    beside = hf.assemble(scene((*STRANGERS["a body in the air"], *STACK)), gap=GAP)
    ask = ("low", POINTS[0], DIRECTIONS[0])
    one, two = hf.sets.sensitivity(alone, *ask), hf.sets.sensitivity(beside, *ask)
    assert one.force == two.force
    assert two.d_mass["air"] == 0
    assert dict(one.d_mass) == {name: value for name, value in two.d_mass.items() if name != "air"}
    assert dict(one.d_mu) == dict(two.d_mu)
    worst = [hf.sets.worst_case(a, *ask, mu_range=0.2, mass_range=0.1) for a in (alone, beside)]
    assert worst[0].force.tobytes() == worst[1].force.tobytes()
    assert worst[0].corners == worst[1].corners == 9
    with pytest.raises(hf.HoldfastError, match="the assembly is unstable"):
        hf.sets.sustainable_accelerations(beside)


def test_a_moment_alone_is_not_taken_for_none() -> None:
    """A cube twisted about the vertical: the torsion of its square face, between the least and the greatest arm."""
    assembly = hf.assemble(scene((cube("cube", 0, 0),)), gap=GAP)
    found = hf.load_factor(assembly, [hf.Load("cube", moment=(0, 0, 1))], engine="compliant")
    assert 0.5 * 9.81 * 0.03 < found.factor < 0.5 * 9.81 * 0.05 * np.sqrt(2)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_a_light_body_in_a_heavy_group_is_not_taken_for_loose(engine: str) -> None:
    """A block of 10 t with a ball and a crumb of 10 g on it: the crumb slides at μ m g."""
    heavy = hf.Body("block", hf.Box((0.5, 0.5, 0.5)), mass=1e4, pose=at(0, 0, 0.25))
    ball = hf.Body("ball", hf.Sphere(0.05), mass=0.5, pose=at(0.1, 0, 0.55))
    crumb = hf.Body("crumb", hf.Box((0.02, 0.02, 0.02)), mass=0.01, pose=at(-0.1, 0, 0.51))
    assembly = hf.assemble(scene((heavy, ball, crumb)), gap=1e-5)
    found = hf.robustness(assembly, "crumb", (-0.11, 0, 0.502), (1, 0, 0), engine=engine)
    assert found.force[0] == pytest.approx(0.5 * 0.01 * 9.81, rel=0.01)
    rolling = hf.robustness(assembly, "ball", (0.05, 0, 0.55), (1, 0, 0), engine=engine)
    assert rolling.force[0] < 1e-3 * 0.5 * 9.81
