"""Numbers from outside: sane ranges, no texts for numbers, directions of any length (findings D10, D16, U6)."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from placed import at

import holdfast as hf
from holdfast.base.arrays import (
    checked,
    checked_direction,
    checked_directions,
    checked_name,
    checked_number,
    checked_rows,
    checked_sizes,
    checked_whole,
    unit,
)
from holdfast.base.errors import HoldfastError, SceneError
from holdfast.base.ranges import LENGTH, MASS, PLACE

BOX = hf.Box((0.1, 0.1, 0.1))
FLOOR = hf.Body("floor", hf.Box((1, 1, 0.1)), fixed=True)


def scene(**changes: Any) -> hf.Scene:
    return hf.Scene([FLOOR, hf.Body("cube", BOX, mass=1)], **{"friction": 0.5} | changes)


BEYOND: dict[str, tuple[Callable[[], object], str]] = {
    "box 1e100": (lambda: hf.Box((1e100, 1, 1)), r"Box: size.*1e\+100.*from 1e-06 to 1e\+06 m"),
    "box 1e-300": (lambda: hf.Box((1e-300, 1, 1)), r"Box: size.*1e-300.*from 1e-06"),
    "sphere": (lambda: hf.Sphere(1e100), r"Sphere: radius: is 1e\+100; .*units"),
    "cylinder": (lambda: hf.Cylinder(1, 1e-7), r"Cylinder: height: is 1e-07; .*units"),
    "mesh far": (lambda: hf.Mesh(np.eye(3) * 1e7, [[0, 1, 2]]), r"vertices: .*10000000\.0 at index \(0, 0\)"),
    "mesh small": (lambda: hf.Mesh(np.eye(3) * 1e-7, [[0, 1, 2]]), r"is 1e-07 m across"),
    "noise": (lambda: hf.Mesh(np.eye(3), [[0, 1, 2]], noise=1e9), r"noise: is 1e\+09"),
    "mass 1e300": (lambda: hf.Body("b", BOX, mass=1e300), r"body 'b': mass: is 1e\+300; .* kg"),
    "mass 1e-300": (lambda: hf.Body("b", BOX, mass=1e-300), r"mass: is 1e-300"),
    "density": (lambda: hf.Body("b", BOX, density=1e300), r"density: is 1e\+300"),
    "mass by density": (lambda: hf.Body("b", hf.Box((1e6, 1e6, 1e6)), density=1e3), r"mass: is 1e\+21"),
    "com": (lambda: hf.Body("b", BOX, mass=1, com=(0, 0, 1e9)), r"com: .*1000000000\.0 at index \(2,\)"),
    "inertia": (lambda: hf.Body("b", BOX, mass=1, inertia=np.eye(3) * 1e200), r"inertia: .*1e\+200"),
    "place": (lambda: hf.Body("b", BOX, mass=1, pose=at(-1e7)), r"pose: is at .*-10000000\.0"),
    "rotation": (lambda: hf.Body("b", BOX, mass=1, pose=np.diag([1e200, 1, 1, 1])), r"pose: is not rigid"),
    "gravity": (lambda: scene(gravity=(0, 0, -1e300)), r"gravity: .*-1e\+300"),
    "little gravity": (lambda: scene(gravity=(0, 0, -1e-300)), r"gravity: is 1e-300"),
    "friction": (lambda: hf.Friction(1e300), r"default: is 1e\+300"),
    "pair": (lambda: hf.Friction(0.5, {("a", "b"): 1e300}), r"'a'.*is 1e\+300"),
    "value": (lambda: hf.Friction(0.5, {}, {"a": 1e300}, "max"), r"'a': is 1e\+300"),
    "gap": (lambda: hf.assemble(scene(), gap=1e300), r"gap: is 1e\+300"),
    "sigma": (lambda: hf.assemble(scene(), pose_sigma=1e300), r"pose_sigma: is 1e\+300"),
    "spacing": (lambda: hf.robustness_map(scene(), spacing=1e-300), r"spacing: is 1e-300"),
    "wide spacing": (lambda: hf.robustness_map(scene(), spacing=1e300), r"spacing: is 1e\+300"),
    "point": (lambda: hf.robustness(scene(), "cube", (1e200, 0, 0), (1, 0, 0)), r"points: .*1e\+200"),
    "load": (lambda: hf.Load("cube", (0, 0, 0), (1e200, 0, 0)), r"force: .*1e\+200"),
    "nodes": (lambda: hf.Compliant(nodes=100_000), r"nodes: is 100000; needs a whole number of at most 100"),
    "graph nodes": (lambda: hf.Graph(nodes=10**9), r"nodes: is 1000000000"),
    "sides": (lambda: hf.Limit("inscribed", 10**9), r"sides: is 1000000000"),
    "directions": (lambda: scene().horizontal_directions(10**9), r"count: is 1000000000"),
    "tilt": (lambda: scene().tilted((1e300, 0, 0)), r"tilt_degrees: .*1e\+300"),
    "turning": (
        lambda: hf.sets.inertial_loads(scene(), angular_velocity=(1e200, 0, 0)), r"angular velocity: .*1e\+200"
    ),
    "seed": (lambda: hf.Search(seed=-1), r"seed: is -1; "),
}  # fmt: skip


@pytest.mark.parametrize("name", BEYOND)
def test_d16_numbers_out_of_all_range_are_refused(name: str) -> None:
    call, match = BEYOND[name]
    with pytest.raises(HoldfastError, match=match) as caught:
        call()
    assert "; " in str(caught.value)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("given", "largest"),
    [
        (lambda x: hf.Friction(x), 1e9),
        (lambda x: hf.Friction(0.5, {("a", "b"): x}), 1e9),
        (lambda x: hf.Body("b", BOX, mass=x), 1e9),
        (lambda x: hf.Body("b", BOX, mass=1, pose=at(x)), 1e6),
        (lambda x: hf.Load("cube", (0, 0, 0), (x, 0, 0)), 1e15),
        (lambda x: scene(gravity=(0, 0, -x)), 1e6),
    ],
    ids=["friction", "pair", "mass", "place", "force", "gravity"],
)
def test_what_users_give_ends_where_double_precision_has_room(given: Callable[[float], object], largest: float) -> None:
    given(largest)
    with pytest.raises(HoldfastError):
        given(largest * 1.001)


@pytest.mark.parametrize("value", [1e-6, 1e6])
def test_the_ends_of_a_range_belong_to_it(value: float) -> None:
    assert hf.Sphere(value).radius == value
    assert checked_number(value, "x", above=0, within=LENGTH) == value


@pytest.mark.parametrize("value", [1e-6 * (1 - 1e-9), 1e6 * (1 + 1e-9)])
def test_what_is_just_outside_does_not(value: float) -> None:
    with pytest.raises(HoldfastError):
        hf.Sphere(value)
    with pytest.raises(HoldfastError):
        checked_sizes([value] * 3, (3,), "x", LENGTH)


@pytest.mark.parametrize(
    "value", ["3", b"3", True, np.True_, None, [3], np.array([3.0]), 1j, np.datetime64("2020"), "x", {}, 10**400]
)
def test_u6_what_only_reads_like_a_number_is_refused(value: object) -> None:
    with pytest.raises(SceneError, match=r"x: got .*; needs a finite number"):
        checked_number(value, "x")
    with pytest.raises(SceneError):
        checked([value, value, value], (3,), "x")


@pytest.mark.parametrize("value", [3, 3.0, np.float32(3), np.int64(3), np.array(3.0), Fraction(3), Decimal(3)])
def test_every_kind_of_number_is_taken(value: object) -> None:
    assert checked_number(value, "x", above=0, within=MASS) == 3.0
    assert checked([value, value], (2,), "x", within=PLACE).tolist() == [3.0, 3.0]


@pytest.mark.parametrize("value", [3, np.int64(3), np.uint8(3)])
def test_whole_numbers(value: object) -> None:
    assert checked_whole(value, "x", 3, 3) == 3


@pytest.mark.parametrize("value", [2, 4, 3.0, True, "3", None, np.float64(3), 10**30])
def test_what_is_no_whole_number_in_the_range(value: object) -> None:
    with pytest.raises(SceneError, match=r"x: is .*; needs a whole number of at (least|most) 3"):
        checked_whole(value, "x", 3, 3)


def test_d10_a_direction_of_any_length_counts() -> None:
    """A cube of 1 kg with μ 0.5 slides at 4.905 N, whatever the length of the vector that says where to."""
    cube = hf.Body("cube", BOX, mass=1, pose=at(0))
    low = hf.Body(
        "floor", hf.Box((1, 1, 0.1)), fixed=True, pose=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.1], [0, 0, 0, 1]]
    )
    assembly = hf.assemble(hf.Scene([low, cube], 0.5))
    ways = [(-1e300, 0, 0), (-1, 0, 0), (-1e-300, 0, 0), (-5e-324, 0, 0), (-1.7e308, 0, 0)]
    for engine in ("limit", "graph"):
        found = hf.robustness(assembly, "cube", (0.05, 0, -0.04), ways, engine=engine)
        assert found.force == pytest.approx([4.905] * len(ways), rel=1e-6)
        assert engine == "graph" or found.upper == pytest.approx([4.905] * len(ways), rel=1e-6)
        np.testing.assert_array_equal(found.directions, [(-1.0, 0.0, 0.0)] * len(ways))


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=3, max_size=3).filter(any))
def test_d10_unit_vectors_neither_overflow_nor_vanish(vector: list[float]) -> None:
    way = checked_direction(vector, "x")
    assert np.linalg.norm(way) == pytest.approx(1.0, abs=1e-12)
    assert (np.sign(way)[np.abs(way) > 1e-300] == np.sign(vector)[np.abs(way) > 1e-300]).all()


def test_units_of_ordinary_vectors_are_what_they_were() -> None:
    vectors = np.random.default_rng(0).normal(size=(100, 3))
    np.testing.assert_array_equal(unit(vectors), vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


@pytest.mark.parametrize(("value", "single"), [((1, 2, 3), True), ([(1, 2, 3)], False)])
def test_one_row_is_told_from_a_list_of_one(value: object, single: bool) -> None:
    rows, alone = checked_rows(value, 3, "x")
    assert rows.tolist() == [[1, 2, 3]]
    assert alone == single


@pytest.mark.parametrize("value", [[(1, 2, 3), (1, 2)], [np.zeros((2, 3)), np.zeros((2, 4))], "abc", None])
def test_what_is_no_array_has_no_rows(value: object) -> None:
    with pytest.raises(SceneError, match=r"x: got .*; needs numbers of shape \(n, 3\)"):
        checked_rows(value, 3, "x")


def test_a_zero_among_directions_is_refused() -> None:
    with pytest.raises(SceneError, match="x: a direction is zero; needs"):
        checked_directions([(1, 0, 0), (0, 0, 0)], "x")


@pytest.mark.parametrize(
    ("name", "match"),
    [
        ("", "is ''; needs a non-empty text"),
        (" \n", "needs a non-empty text"),
        (7, "is 7; needs a non-empty text"),
        ("x" * 501, "has 501 characters; needs at most 500"),
        ("a\ud800", r"is 'a\\ud800'; needs a text without lone surrogates"),
    ],
)
def test_d15_d6_names_that_are_refused(name: Any, match: str) -> None:
    with pytest.raises(SceneError, match=match):
        checked_name(name, "x")
    with pytest.raises(SceneError, match=match):
        hf.Body(name, BOX, mass=1)
    if name:
        with pytest.raises(SceneError, match=match):
            hf.Body("b", BOX, mass=1, material=name)
        with pytest.raises(SceneError, match=match):
            scene(name=name)
