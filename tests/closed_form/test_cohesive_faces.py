"""Cohesion beyond friction times tension, by engine limit: sliding, twisting, lifting, and between two bodies."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf

G, MU, SIDE, MASS = 9.81, 0.5, 0.1, 1.0
AREA, WEIGHT = SIDE**2, MASS * G
MEAN_ARM = SIDE * (np.sqrt(2) + np.log(1 + np.sqrt(2))) / 6  # of a square about its centre


def plate(cohesion: float, mu: float = MU, tension: float = 0.0, degrees: float = 0.0) -> hf.Scene:
    """A plate on a plane that leans by some degrees."""
    turn = np.radians(degrees)
    normal = np.array([np.sin(turn), 0, np.cos(turn)])
    plane = hf.Body("plane", hf.Box((1, 1, 0.1)), position=-0.05 * normal, rpy_degrees=(0, degrees, 0), fixed=True)
    body = hf.Body("plate", hf.Box((SIDE, SIDE, 0.01)), MASS, position=0.005 * normal, rpy_degrees=(0, degrees, 0))
    pair = ("plane", "plate")
    return hf.Scene([plane, body], hf.Friction(mu, tension={pair: tension}, cohesion={pair: cohesion}))


def pushed(scene: hf.Scene, *push: object) -> tuple[float, float, float]:
    found = hf.robustness(scene, *push, engine="limit", bounds=True)
    return float(found), float(found.lower[0]), float(found.upper[0])


@pytest.mark.parametrize("mu", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("cohesion", [10.0, 800.0, 1e6])
def test_a_plate_slides_at_friction_and_cohesion_together(mu: float, cohesion: float) -> None:
    by_hand = mu * WEIGHT + cohesion * AREA
    force, lower, upper = pushed(plate(cohesion, mu), "plate", (-0.05, 0, 1e-9), (1, 0, 0))
    assert force == pytest.approx(by_hand, rel=1e-6)
    assert lower == pytest.approx(by_hand, rel=1e-5)
    assert upper == pytest.approx(by_hand, rel=1e-5)


def test_cohesion_alone_holds_no_pull() -> None:
    assert pushed(plate(1e3), "plate", (0, 0, 0.01), (0, 0, 1))[0] == pytest.approx(WEIGHT, rel=1e-6)


def test_a_slope_holds_by_cohesion() -> None:
    needed = WEIGHT * (np.sin(np.radians(60)) - MU * np.cos(np.radians(60))) / AREA
    for share, stands in ((1.001, True), (0.999, False)):
        assert hf.stability(plate(share * needed, degrees=60), engine="limit").stable is stands


def test_torsion_counts_at_the_middles_of_sixteen_parts() -> None:
    """Cautious: 2.1 % less than what cohesion holds against turning all over a square."""
    scene, c = plate(800.0, mu=0.0), (np.arange(4) - 1.5) / 4 * SIDE
    twist = hf.load_factor(scene, [hf.Load("plate", (0, 0, 0.005), (0, 0, 0), moment=(0, 0, 1))], engine="limit")
    on_parts = 800.0 * AREA * float(np.hypot(*np.meshgrid(c, c)).mean())
    assert float(twist) == pytest.approx(on_parts, rel=1e-6)
    assert 0.975 * 800.0 * AREA * MEAN_ARM < float(twist) < 800.0 * AREA * MEAN_ARM


def test_tension_and_cohesion_are_capped_each_by_its_own() -> None:
    """A plate that is pulled: friction is what μ (f_n) and cohesion leave, and it comes off at its tension."""
    ceiling = hf.Body("ceiling", hf.Box((1, 1, 0.1)), position=(0, 0, 0.05), fixed=True)
    body = hf.Body("body", hf.Box((SIDE, SIDE, 0.1)), MASS, position=(0, 0, -0.05))
    pair = ("body", "ceiling")
    table = hf.Friction(MU, tension={pair: 3 * WEIGHT / AREA}, cohesion={pair: 4 * WEIGHT / AREA})
    scene = hf.Scene([ceiling, body], table)
    assert pushed(scene, "body", (-0.05, 0, -1e-9), (1, 0, 0))[0] == pytest.approx((4 - MU) * WEIGHT, rel=1e-6)
    assert pushed(scene, "body", (0, 0, -0.1), (0, 0, -1))[0] == pytest.approx(2 * WEIGHT, rel=1e-6)


@pytest.mark.parametrize("cohesion", [500.0, 5e3])
def test_cohesion_between_two_bodies_that_can_move(cohesion: float) -> None:
    """The upper one slides off the lower one, or takes it along on the floor."""
    boxes = [hf.Body(f"box{k}", hf.Box((0.1, 0.1, 0.05)), 1.0 + k, position=(0, 0, 0.025 + 0.05 * k)) for k in (0, 1)]
    pair = ("box0", "box1")
    table = hf.Friction(MU, pairs={pair: 0.1}, cohesion={pair: cohesion})
    scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), *boxes], table)
    off, along = 0.1 * 2 * G + cohesion * AREA, MU * 3 * G
    found = hf.robustness(scene, "box1", (-0.05, 0, 0.051), (1, 0, 0), engine="limit", bounds=True)
    assert float(found) == pytest.approx(min(off, along), rel=1e-6)
    assert set(found.moving[0]) == ({"box1"} if off < along else {"box0", "box1"})
    limits = hf.transport_limits(scene, [(1, 0, 0)], engine="limit")
    assert limits.acceleration[0] == pytest.approx(min(0.1 * G + cohesion * AREA / 2, MU * G), rel=1e-6)


def test_more_friction_holds_less_where_a_cohesion_closes_the_cone() -> None:
    """Pulled off at cohesion / μ: the lower end of μ is not the worst, so worst_case takes no range of it."""
    hung = hf.Body("hung", hf.Box((SIDE, SIDE, 0.01)), 0.5, position=(0, 0, -0.005))
    above = hf.Body("above", hf.Box((1, 1, 0.1)), position=(0, 0, 0.05), fixed=True)
    pair, push = ("above", "hung"), ((0, 0, -0.01), (0, 0, -1))
    scene = hf.Scene([above, hung], hf.Friction(0.2, tension={pair: 1e5}, cohesion={pair: 1e3}))
    weak = hf.assemble(scene).with_friction({pair: 0.8})
    for found, mu in ((scene, 0.2), (weak, 0.8)):
        assert pushed(found, "hung", *push)[0] == pytest.approx(1e3 * AREA / mu - 0.5 * G, rel=1e-6)
    with pytest.raises(hf.HoldfastError, match="mu_range"):
        hf.sets.worst_case(scene, "hung", *push, mu_range=(0.2, 0.8))
    masses = hf.sets.worst_case(scene, "hung", *push, mass_range={"hung": (0.4, 0.6)})
    assert float(masses.lower[0]) == pytest.approx(1e3 * AREA / 0.2 - 0.6 * G, rel=1e-6)
