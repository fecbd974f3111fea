"""Balls, capsules and cylinders on each other: where they touch, and what a pile of lying ones withstands."""

from __future__ import annotations

import numpy as np
import pytest
from placed import FLOOR, at, lying
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.contacts.round_bodies import PlacedRod, RoundLimits, meeting

NEAR = RoundLimits(
    gap=1e-4, depth=1e-4, cos_twist=float(np.cos(np.radians(1))), cos_side=float(np.cos(np.radians(1))), seen=0.0
)


def between(one: hf.Body, two: hf.Body, gap: float = 1e-4) -> tuple[hf.answers.Patch, ...]:
    aside = hf.Body("aside", hf.Box((0.1, 0.1, 0.1)), pose=at(9, 9, 9), fixed=True)
    found = hf.assemble(hf.Scene([one, two, aside], 0.5), gap=gap).interfaces
    return found[0].patches if found else ()


@pytest.mark.parametrize("seed", range(12))
def test_two_capsules_touch_where_a_search_finds_their_axes_nearest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = Rotation.random(2, random_state=seed).as_matrix()
    radii, halves = rng.uniform(0.02, 0.05, 2), rng.uniform(0.02, 0.2, 2)
    centre = rng.uniform(-0.1, 0.1, 3)

    def arm(shares: Float) -> Float:
        return np.asarray(centre + shares[1] * halves[1] * turns[1][:, 2] - shares[0] * halves[0] * turns[0][:, 2])

    starts = [(s, t) for s in (-0.9, 0.1, 0.9) for t in (-0.9, 0.1, 0.9)]
    best = min(
        (minimize(lambda x: float(arm(x) @ arm(x)), start, bounds=[(-1, 1)] * 2, tol=1e-16) for start in starts),
        key=lambda found: float(found.fun),
    )
    way = arm(best.x) / np.linalg.norm(arm(best.x))
    shift = way * (radii.sum() - np.linalg.norm(arm(best.x)))  # now they touch exactly
    bodies = [
        hf.Body("one", hf.Capsule(radii[0], 2 * halves[0]), mass=1, pose=at(0, 0, 0, turns[0])),
        hf.Body("two", hf.Capsule(radii[1], 2 * halves[1]), mass=1, pose=at(*(centre + shift), turns[1])),
    ]
    (patch,) = between(*bodies)
    place = best.x[0] * halves[0] * turns[0][:, 2] + radii[0] * way
    assert patch.kind == "point"
    assert patch.normal == pytest.approx(way, abs=1e-6)
    assert patch.polygon[0] == pytest.approx(place, abs=2e-6)
    (other,) = between(*bodies[::-1])
    assert other.normal == pytest.approx(-patch.normal, abs=1e-12)
    assert other.polygon == pytest.approx(patch.polygon, abs=1e-12)


@pytest.mark.parametrize("upper", [hf.Sphere(0.03), hf.Capsule(0.03, 0.1), hf.Cylinder(0.03, 0.1)])
@pytest.mark.parametrize("lower", [hf.Sphere(0.05), hf.Capsule(0.05, 0.3), hf.Cylinder(0.05, 0.3)])
@pytest.mark.parametrize("apart", [5e-5, -5e-5, 3e-4])
def test_crossed_round_bodies_touch_at_one_point_by_their_true_surfaces(
    lower: hf.Shape, upper: hf.Shape, apart: float
) -> None:
    one = hf.Body("one", lower, mass=1, pose=at(0, 0, 0, lying(13)))
    two = hf.Body("two", upper, mass=1, pose=at(0, 0.02, 0.08 + apart, lying(101, yaw=90)))
    if isinstance(lower, hf.Sphere):
        two = two.moved(at(0, 0, 0.08 + apart, two.pose[:3, :3]))
    found = between(one, two)
    assert len(found) == (apart < 1e-4)
    for patch in found:
        assert patch.kind == "point"
        assert patch.separation == pytest.approx((apart, apart), abs=1e-12)
        assert patch.polygon[0] == pytest.approx((0, two.pose[1, 3], 0.05 + apart / 2), abs=1e-9)
        assert patch.normal == pytest.approx((0, 0, 1), abs=1e-12)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("roll", [0.0, 1.0, 2.8125, 40.7])
def test_parallel_cylinders_touch_along_what_lies_side_by_side(roll: float, order: int) -> None:
    one = hf.Body("one", hf.Cylinder(0.05, 0.3), mass=1, pose=at(0, 0, 0, lying(roll)))
    two = hf.Body("two", hf.Cylinder(0.03, 0.2), mass=1, pose=at(0, 0.2, 0.08, lying(-3 * roll)))
    (line,) = between(*(one, two)[::order])
    assert line.kind == "line"
    assert np.sort(line.polygon[:, 1]) == pytest.approx((0.1, 0.15), abs=1e-9)
    assert line.polygon[:, [0, 2]] == pytest.approx(np.array([(0, 0.05), (0, 0.05)]), abs=1e-9)
    assert line.normal == pytest.approx((0, 0, order), abs=1e-12)


def test_a_cylinder_that_stands_on_another_does_not_touch_with_its_side() -> None:
    """Its end lies on the other's side: a face on a curved surface, which is found on the tessellation."""
    axis, upright = np.array([0.0, 0.15, 0.0]), np.array([0.0, 0.0, 0.05])
    one, two = PlacedRod(np.zeros(3), axis, 0.05, flat=True), PlacedRod(np.array([0, 0, 0.1]), upright, 0.03, flat=True)
    assert meeting(one, two, NEAR) is None
    capped = two._replace(centre=np.array([0, 0, 0.13]), flat=False)  # as a capsule it touches by its cap
    found = meeting(one, capped, NEAR)
    assert found is not None
    assert found.heights == pytest.approx([0.0], abs=1e-12)
    low = hf.Body("low", hf.Cylinder(0.05, 0.3), mass=1, pose=at(0, 0, 0, lying(0)))
    assert between(low, hf.Body("up", hf.Cylinder(0.03, 0.1), mass=1, pose=at(0, 0, 0.1)))


def test_axes_that_meet_have_no_direction_between_them() -> None:
    one = PlacedRod(np.zeros(3), np.array([0.0, 0.1, 0.0]), 0.05, flat=False)
    assert meeting(one, one._replace(half=np.array([0.1, 0.0, 0.0])), NEAR._replace(depth=1.0)) is None


def test_the_gap_between_two_round_bodies_bends_as_both_do() -> None:
    """Balls: 1/r + 1/s; crossed cylinders: each across its axis; lines: across."""
    x, y = np.array([0.1, 0.0, 0.0]), np.array([0.0, 0.1, 0.0])
    over = np.array([0, 0, 0.08])
    for half, other, expected in ((0 * x, 0 * y, 1 / 0.05 + 1 / 0.03), (x, y, 1 / 0.05), (x, x, 1 / 0.05 + 1 / 0.03)):
        found = meeting(PlacedRod(np.zeros(3), half, 0.05, flat=False), PlacedRod(over, other, 0.03, flat=False), NEAR)
        assert found is not None
        assert found.bend == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_a_pile_of_three_lying_cylinders_is_that_of_three_capsules_however_they_are_rolled(engine: str) -> None:
    """Found on 64 facets it withstood up to 11 % more, depending on how they were rolled."""
    r, high = 0.04, 0.04 + np.sqrt(3) * 0.04
    walls = [
        hf.Body(f"wall {x:+.2f}", hf.Box((0.02, 0.2, 0.1)), fixed=True, pose=at(x, 0, 0.05)) for x in (-0.09, 0.09)
    ]
    force = []
    for shape, rolls in (
        (hf.Capsule(r, 0.12), (0, 0, 0)),
        (hf.Cylinder(r, 0.12), (0, 0, 0)),
        (hf.Cylinder(r, 0.12), (0.1, 4.9, 5.5)),
        (hf.Cylinder(r, 0.12), (3.8, 1.6, 0.3)),
    ):
        places = ((-r, r), (r, r), (0.0, high))
        logs = [
            hf.Body(f"log {k}", shape, mass=1, pose=at(x, 0, z, lying(roll)))
            for k, ((x, z), roll) in enumerate(zip(places, rolls, strict=True))
        ]
        assembly = hf.assemble(hf.Scene([FLOOR, *walls, *logs], 0.5))
        assert {patch.kind for each in assembly.interfaces for patch in each.patches} == {"line"}
        at_top = hf.robustness(
            assembly, "log 2", [(0, 0, high + r), (r, 0, high)], [(1, 0, 0), (-1, 0, 0)], engine=engine
        )
        force.append(at_top.force)
    assert np.array(force) == pytest.approx(np.tile(force[0], (4, 1)), rel=1e-4)


def test_the_rims_of_two_cylinders_end_to_end_are_no_sides() -> None:
    """However deep an overlap may be: their axes lie 1 cm apart, the sides 9 cm into each other."""
    half = np.array([0.0, 0.0, 0.05])
    one, two = PlacedRod(-half, half, 0.05, flat=True), PlacedRod(np.array([0.01, 0, 0.05]), half, 0.04, flat=True)
    assert meeting(one, two, NEAR._replace(depth=np.inf)) is None


def test_cylinders_that_cross_at_a_small_angle_touch_at_a_point_however_wide_the_gap() -> None:
    """At the ends the surfaces are only 0.06 mm apart, but the normals there differ by 4 degrees."""
    half = np.array([0.0, 0.06, 0.0])
    turn = Rotation.from_euler("z", 3, degrees=True).as_matrix()
    one, two = (
        PlacedRod(np.zeros(3), half, 0.05, flat=True),
        PlacedRod(np.array([0, 0, 0.08]), turn @ half, 0.03, flat=True),
    )
    point = meeting(one, two, NEAR._replace(gap=1e-3))
    assert point is not None
    assert point.ends == pytest.approx(np.full((2, 1, 3), (0, 0, 0.05)), abs=1e-12)
    line = meeting(one, two, NEAR._replace(gap=1e-3, cos_twist=float(np.cos(np.radians(5)))))
    assert line is not None
    assert line.ends.shape == (2, 2, 3)
