"""The closed forms that the method meets, and its known errors, pinned as what they are."""

import numpy as np
import pytest
from graph_scenes import X, Y, Z, block, cube_scene, floor, push

from holdfast import Scene, Status, assemble, robustness, stability
from holdfast.answers import Claim
from holdfast.scene.shipped import shipped_scene


@pytest.mark.parametrize("mu", [0.2, 0.6, 1.5])
@pytest.mark.parametrize("height", [0.01, 0.04, 0.1])
@pytest.mark.parametrize("mass", [0.1, 3.0])
def test_centred_push_on_a_cube(mu: float, height: float, mass: float) -> None:
    expected = min(mu * mass * 9.81, mass * 9.81 * 0.1 / (2 * height))
    got = robustness(assemble(cube_scene(mu, mass=mass)), "cube", (-0.05, 0, height), X, engine="graph")
    assert got.force[0] == pytest.approx(expected)
    assert got.claim is Claim.ESTIMATED
    assert got.mode[0] == ("slip" if mu < 0.05 / height else "topple")


def test_straight_pull_up_and_press_down() -> None:
    assembly = assemble(cube_scene())
    assert push(assembly, "cube", (0, 0, 0.1), Z) == pytest.approx(9.81)
    assert push(assembly, "cube", (0.03, 0, 0.1), Z) == pytest.approx(9.81 * 0.05 / 0.08)
    for x, y in ((0, 0), (0.049, 0), (-0.03, 0.049)):
        assert push(assembly, "cube", (x, y, 0.1), -Z) == np.inf


@pytest.mark.parametrize("height", [0.05, 0.1, 0.4])
@pytest.mark.parametrize("mu", [0.4, 0.9])
def test_incline_slips_at_mu_and_topples_at_base_over_height(height: float, mu: float) -> None:
    critical = min(mu, 0.1 / height)
    for ratio, status in ((0.999, Status.STABLE), (1.001, Status.UNSTABLE)):
        lean = 9.81 * np.array([0, ratio * critical, -1])
        scene = Scene([floor(), block("box", (0.1, 0.1, height), (0, 0, height / 2))], mu, lean)
        assert stability(assemble(scene), engine="graph").status is status


def test_a_box_that_slides_down_an_incline_is_told_to_slip() -> None:
    """The certificate of the cone program opens the contact by mu times the slip; that is not toppling."""
    scene = Scene([floor(), block("box", (0.1, 0.1, 0.02), (0, 0, 0.01))], 0.4, 9.81 * np.array([0, 0.41, -1]))
    mechanism = stability(assemble(scene), engine="graph").mechanism
    assert mechanism is not None
    assert mechanism.mode == "slip"


def test_slab_of_the_table_pressed_on_its_overhang() -> None:
    """About the outer edge of the leg, x = -0.2: slab 2 kg at 0.2 m over 0.04 m."""
    table = assemble(shipped_scene("table"))
    assert push(table, "slab", (-0.24, 0, 0.25), -Z) == pytest.approx(98.1)
    assert push(table, "slab", (0.24, 0.05, 0.25), -Z) == pytest.approx(98.1)
    assert push(table, "slab", (0.19, 0, 0.25), -Z) == np.inf


def test_known_error_legs_that_rack_are_missed() -> None:
    """The table sways at 7.3575 N; the method turns sets of bodies as one, finds nothing before the slab slips."""
    assert push(assemble(shipped_scene("table")), "slab", (-0.25, 0, 0.225), X) == pytest.approx(9.81)


def test_known_error_slip_and_twist_do_not_share_friction() -> None:
    """Off-centre push on a cube: 3.544 N by the full limit surface under linear pressure."""
    got = push(assemble(cube_scene()), "cube", (-0.05, 0.045, 0.02), X)
    lever = 0.1 / 6 * (np.sqrt(2) + np.log(1 + np.sqrt(2)))  # mean distance to the centre of a square
    assert got == pytest.approx(0.6 * 9.81 * lever / 0.045, rel=1e-6)
    assert got == pytest.approx(5.004, abs=1e-3)


def test_known_error_off_centre_at_the_end_of_the_table() -> None:
    """Slab pushed along y at its end: 6.227 N by limit analysis."""
    assert push(assemble(shipped_scene("table")), "slab", (0.2, -0.1, 0.225), Y) == pytest.approx(9.03, abs=0.1)
