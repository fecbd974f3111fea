"""Closed forms that every engine meets, the nodes of engine ``compliant`` to half a per cent."""

from __future__ import annotations

import numpy as np
import pytest
from engine_scenes import G0, Array, X, Y, Z, cube, shipped

from holdfast import Load, Status, load_factor, robustness, stability
from holdfast.answers import Claim

CLOSE = {"graph": 1e-6, "limit": 1e-6, "compliant": 5e-3}
CLAIMS = {"graph": Claim.ESTIMATED, "limit": Claim.EXISTS, "compliant": Claim.HOLDS}
every = pytest.mark.parametrize("engine", CLOSE)


def near(value: float, engine: str) -> object:
    return pytest.approx(value, rel=CLOSE[engine])


@every
@pytest.mark.parametrize("mu", [0.2, 0.6, 1.5])
@pytest.mark.parametrize("height", [0.01, 0.04, 0.1])
@pytest.mark.parametrize("mass", [0.1, 3.0])
def test_centred_push_on_a_cube(mu: float, height: float, mass: float, engine: str) -> None:
    got = robustness(cube(mu, mass), "cube", (-0.05, 0, height), X, engine=engine)
    assert got.force[0] == near(min(mu * mass * G0, mass * G0 * 0.1 / (2 * height)), engine)
    assert got.claim is CLAIMS[engine]
    assert got.status[0] is Status.FINITE
    assert got.moving[0] == ("cube",)
    assert got.mode[0] == ("slip" if mu < 0.05 / height else "topple")
    assert got.lower[0] <= got.force[0] <= got.upper[0]
    assert got.lower[0] >= (0 if engine == "graph" else 0.99 * got.force[0])


@every
@pytest.mark.parametrize("mass", [0.01, 300.0])
def test_pull_up_and_press_down(mass: float, engine: str) -> None:
    points = [(0, 0, 0.1), (0.03, 0, 0.1), (0, 0, 0.1), (0.049, 0, 0.1), (-0.03, 0.049, 0.1)]
    got = robustness(cube(mass=mass), "cube", points, [Z, Z, -Z, -Z, -Z], engine=engine)
    assert got.force[:2] == near(np.array([mass * G0, mass * G0 * 0.05 / 0.08]), engine)
    assert np.isinf([got.force[2:], got.upper[2:]]).all()
    assert engine == "graph" or np.isinf(got.lower[2:]).all()
    assert set(got.status[2:]) == {Status.INFINITE}
    assert got.mechanism[2:].tolist() == [None] * 3


@every
@pytest.mark.parametrize("share", [0.5, 0.99, 1.01, 2.0])
def test_oblique_press_is_endless_within_the_friction_cone_only(share: float, engine: str) -> None:
    """In the middle of the floor face, where the push has no moment about the contact."""
    got = robustness(cube(0.6), "cube", (0, 0, 0), (share * 0.6, 0, -1), engine=engine).force[0]
    slides = 0.6 * G0 * np.hypot(share * 0.6, 1) / (0.6 * (share - 1)) if share > 1 else np.inf
    assert got == near(slides, engine)


@every
@pytest.mark.parametrize("height", [0.05, 0.1, 0.4])
@pytest.mark.parametrize("mu", [0.4, 0.9])
def test_incline_slips_at_mu_and_topples_at_base_over_height(height: float, mu: float, engine: str) -> None:
    critical = min(mu, 0.1 / height)
    off = 1e-3 if engine == "compliant" else 1e-4
    for ratio, status in ((1 - off, Status.STABLE), (1 + off, Status.UNSTABLE)):
        tilted = cube(mu, gravity=G0 * np.array([0, ratio * critical, -1]), height=height)
        result = stability(tilted, engine=engine)
        assert result.status is status
    assert result.mechanism is not None
    assert result.mechanism.mode == ("slip" if mu < 0.1 / height else "topple")


@every
@pytest.mark.parametrize("height", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("direction", [X, -X, Y])
def test_a_box_that_is_carried_or_stands_on_a_support_that_accelerates(
    height: float, direction: Array, engine: str
) -> None:
    assembly = cube(0.6, 2.5, height=height)
    (body,) = assembly.movable
    critical = min(0.6 * G0, G0 * 0.1 / height)
    load = [Load("cube", body.com_world, -body.mass * direction)]
    assert load_factor(assembly, load, engine=engine).factor == near(critical, engine)
    for share, status in ((0.99, Status.FINITE), (1.01, Status.UNSTABLE)):
        turn = [Load("cube", moment=Z)]
        shaken = load_factor(assembly, turn, acceleration=share * critical * direction, engine=engine)
        assert shaken.status is status


@every
def test_a_table_pressed_on_its_overhang(engine: str) -> None:
    """About the outer edge of the leg, x = -0.2: slab 2 kg at 0.2 m over 0.04 m."""
    points = [(-0.24, 0, 0.25), (0.24, 0.05, 0.25), (0.19, 0, 0.25)]
    got = robustness(shipped("table"), "slab", points, -Z, engine=engine).force
    assert got[:2] == near(np.array([98.1, 98.1]), engine)
    assert got[2] == np.inf
