"""The closed forms that the method meets, and its known errors, pinned as what they are."""

import numpy as np
import pytest
from engine_scenes import X, Y, block, cube_scene, floor
from graph_scenes import push

from holdfast import Scene, assemble, stability
from holdfast.scene.shipped import shipped_scene


def test_a_box_that_slides_down_an_incline_is_told_to_slip() -> None:
    """The certificate of the cone program opens the contact by mu times the slip; that is not toppling."""
    scene = Scene([floor(), block("box", (0.1, 0.1, 0.02), (0, 0, 0.01))], 0.4, 9.81 * np.array([0, 0.41, -1]))
    mechanism = stability(assemble(scene), engine="graph").mechanism
    assert mechanism is not None
    assert mechanism.mode == "slip"


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
