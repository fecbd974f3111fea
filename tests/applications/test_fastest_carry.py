"""The fastest motion along a path: closed forms, curves, corners, and what ``carry`` says of each."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import at, floor

G, MU = 9.81, 0.6
A = MU * G
PHI = np.linspace(0, 4 * np.pi, 200)


def carried(height: float = 0.05, x: float = 0.0, mu: float = MU) -> hf.Scene:
    return hf.Scene([floor(2, 2), hf.Body("tin", hf.Box((0.1, 0.1, height)), mass=2.5, pose=at(x, 0, height / 2))], mu)


def took(ride: hf.answers.Carried) -> float:
    assert ride.holds or (ride.claim is hf.answers.Claim.EXISTS and (ride.lower >= 1).all())
    return float(ride.profile.time[-1])


@pytest.mark.parametrize(("engine", "margin"), [("limit", 0.0), ("compliant", 0.0), ("limit", 0.36)])
def test_a_straight_line_is_half_starting_and_half_braking(engine: str, margin: float) -> None:
    ride = hf.sets.fastest_carry(carried(), [(0, 0, 0), (0.3, 0, 0), (1, 0, 0)], margin=margin, engine=engine)
    assert took(ride) == pytest.approx(2 / np.sqrt(A * (1 - margin)), rel=2e-3)
    assert np.median(ride.used) == pytest.approx(1 - margin, rel=1e-4)
    assert ride.used.max() <= 1 - margin
    velocity, place = ride.profile.course()
    assert place[-1] == pytest.approx([1, 0, 0], abs=2e-4)
    assert velocity[-1] == pytest.approx([0, 0, 0], abs=1e-6)


def test_near_a_rim_it_brakes_less_than_it_starts() -> None:
    """The tin leans 3 cm from its right edge, 5 cm from its left one, and its centre is 15 cm high."""
    start, brake = G * 0.05 / 0.15, G * 0.03 / 0.15
    there = hf.sets.fastest_carry(carried(0.3, 0.97), [(0, 0), (1, 0)], margin=0, engine="limit")
    assert took(there) == pytest.approx(np.sqrt(2 * (1 / start + 1 / brake)), rel=1e-3)
    assert there.profile.acceleration[[0, -1], 0] == pytest.approx([start, -brake], rel=1e-3)


def test_lifted_it_stops_no_faster_than_it_falls() -> None:
    ride = hf.sets.fastest_carry(carried(), [(0, 0, 0), (0, 0, 2)], margin=0, engine="limit")
    assert took(ride) == pytest.approx(np.sqrt(2 * 2 * (1 / (5 * G) + 1 / G)), rel=1e-3)


def test_with_a_limit_of_speed_it_cruises() -> None:
    ride = hf.sets.fastest_carry(carried(), [(0, 0), (1, 0)], margin=0, speed=0.8, engine="limit")
    assert took(ride) == pytest.approx(1 / 0.8 + 0.8 / A, rel=1e-3)
    assert np.linalg.norm(ride.profile.course()[0], axis=1).max() == pytest.approx(0.8, rel=1e-3)


def test_in_a_circle_all_friction_bears_the_way_out() -> None:
    """From rest, (s'² / r)² + s''² = a² gives s'² = a r sin(2 s / r) up to an eighth of a turn; then it is constant."""
    radius = 0.5
    circle = radius * np.column_stack([np.cos(PHI), np.sin(PHI)])
    ride = hf.sets.fastest_carry(carried(), circle, margin=0, engine="limit")
    eighth = 1.3110287771461  # half the integral of 1 / sqrt(sin) over a right angle
    assert took(ride) == pytest.approx((2 * eighth + PHI[-1] - np.pi / 2) * np.sqrt(radius / A), rel=2e-3)
    velocity, place = ride.profile.course()
    assert np.linalg.norm(velocity, axis=1).max() == pytest.approx(np.sqrt(A * radius), rel=1e-3)
    assert np.hypot(place[:, 0] + radius, place[:, 1]) == pytest.approx(radius, abs=5e-4)


def test_it_stops_at_corners() -> None:
    one = hf.sets.fastest_carry(carried(), [(0, 0), (1, 0)], engine="limit")
    corner = hf.sets.fastest_carry(carried(), [(0, 0), (1, 0), (1, 1), (1, 0)], engine="limit")
    assert took(corner) == pytest.approx(3 * took(one), rel=1e-3)
    assert corner.profile.course()[1][-1] == pytest.approx([1, 0, 0], abs=2e-4)


@pytest.mark.parametrize("seed", range(4))
def test_on_a_random_curve_it_holds_at_all_times_and_takes_as_long_backwards(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 50)
    path = np.column_stack([2 * t, 0.2 * rng.normal(size=3) @ np.sin(np.pi * np.outer([1, 2, 3], t))])
    there, back = (hf.sets.fastest_carry(carried(), way, engine="limit") for way in (path, path[::-1]))
    assert took(there) == pytest.approx(took(back), rel=5e-3)
    assert there.profile.course()[1][-1, :2] == pytest.approx(path[-1] - path[0], abs=3e-4)
    between = there.profile.at(np.sort(rng.uniform(0, there.profile.time[-1], 300)))
    assert hf.carry(carried(), between, engine="limit").used.max() < 0.9 * (1 + 1e-3)
    assert np.median(there.used) > 0.85  # nearly all of what it may use, nearly always
    faster = hf.carry(carried(), there.profile.at_speed(1.1), engine="limit")
    assert faster.outcome is hf.Status.UNSTABLE


def tray(*, cleats: bool) -> hf.Scene:
    things = [
        hf.Body(
            f"thing{k}", hf.Box((0.04, 0.08, h)), mass=0.3 + 0.1 * k, position=(0.1 * k - 0.4, 0.02 * (k % 2), h / 2)
        )
        for k, h in enumerate([0.1, 0.13, 0.16, 0.19, 0.1, 0.13, 0.16, 0.12])
    ]
    things.append(hf.Body("orange", hf.Sphere(0.04), mass=0.2, position=(0, -0.3, 0.04)))
    if cleats:
        things += [
            hf.Body(f"cleat{k}", hf.Box((0.02, 0.02, 0.04)), fixed=True, position=(x, y - 0.3, 0.02))
            for k, (x, y) in enumerate([(0.05, 0), (-0.05, 0), (0, 0.05), (0, -0.05)])
        ]
    return hf.Scene([floor(2, 1), *things], 0.5)


def test_an_orange_among_eight_things_has_to_be_held() -> None:
    ride = hf.sets.fastest_carry(tray(cleats=True), [(0, 0), (1, 0), (1, 0.6)])
    assert ride.holds or (ride.claim is hf.answers.Claim.EXISTS and (ride.lower >= 1).all())
    assert ride.used.max() <= 0.9
    with pytest.raises(hf.HoldfastError, match=r"no acceleration along .* is known to be safe: orange would move"):
        hf.sets.fastest_carry(tray(cleats=False), [(0, 0), (1, 0)])


def test_what_does_not_stand_is_not_carried() -> None:
    with pytest.raises(hf.HoldfastError, match="no contact forces balance"):
        hf.sets.fastest_carry(carried(0.3, 1.01), [(0, 0), (1, 0)])


@pytest.mark.parametrize(
    ("waypoints", "told"),
    [
        ([(0, 0)], "two or more points"),
        ([(0, 0), (1, 0), (1, 0)], "point 1 and the next"),
        ([(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1)], "not in one plane"),
        ([(0, 0), (4e-4, -3e-5), (4.5e-3, 6e-4), (4.5, 0.3)], "space them more evenly"),
    ],
)
def test_other_paths_are_refused(waypoints: list[tuple[float, ...]], told: str) -> None:
    with pytest.raises(hf.HoldfastError, match=told):
        hf.sets.fastest_carry(carried(), waypoints)


def test_an_engine_that_promises_nothing_is_refused() -> None:
    with pytest.raises(hf.HoldfastError, match="promises no lower bound"):
        hf.sets.fastest_carry(carried(), [(0, 0), (1, 0)], engine="graph")


def test_a_course_turns_with_its_carrier() -> None:
    """It accelerates forwards at 1 m/s² and then turns left by a right angle at rest in its own axes."""
    t = np.array([0.0, 1.0, 1.001, 2.001, 2.002, 3.002])
    ahead = np.array([[1.0, 0, 0]] * 2 + [[0, 0, 0]] * 2 + [[1, 0, 0]] * 2)
    omega = np.zeros((6, 3))
    omega[2:4, 2] = np.pi / 2
    velocity, place = hf.Profile(t, ahead, angular_velocity=omega).course()
    assert velocity[-1] == pytest.approx([1, 1, 0], abs=5e-3)
    assert place[-1] == pytest.approx([2.5, 0.5, 0], abs=5e-3)
