"""How a mechanism is shown: rigid motions that begin as its twists do, and the contacts that part."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.engines.mechanism import Mechanism
from holdfast.live.steps import moved_by, parting
from holdfast.scene.shipped.blocks import box, floor

SIDE = np.array([1.0, 0.0, 0.0])


def pushed(height: float) -> Mechanism:
    """A cube of b = 0.1 m with friction 1 tips if it is pushed higher than b / (2 mu), its middle."""
    scene = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05))], friction=1.0)
    found = hf.robustness(scene, "cube", [-0.05, 0.0, height], SIDE, engine="graph").mechanism[0]
    assert found is not None
    return found


@pytest.mark.parametrize("height", [0.02, 0.09])
def test_a_body_begins_to_move_with_its_twist(height: float) -> None:
    """The velocity of any point, by differences, is v + w x (p - com); afterwards the body is still rigid."""
    mechanism = pushed(height)
    ((com, twist),) = zip(mechanism.kinematics.com, mechanism.own, strict=True)
    points = np.random.default_rng(2).normal(size=(5, 3))
    tiny = 1e-6
    place = moved_by(mechanism, tiny)["cube"]
    velocity = (points @ place[:3, :3].T + place[:3, 3] - points) / tiny
    np.testing.assert_allclose(velocity, twist[:3] + np.cross(twist[3:], points - com), rtol=1e-4, atol=1e-4)
    far = moved_by(mechanism, 0.3)["cube"]
    np.testing.assert_allclose(far[:3, :3].T @ far[:3, :3], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(far[:3, :3] @ com + far[:3, 3], com + 0.3 * twist[:3], atol=1e-12)
    np.testing.assert_array_equal(moved_by(mechanism, 0.0)["cube"], np.eye(4))


def test_a_low_push_slides_all_contacts() -> None:
    low = parting(pushed(0.02))
    assert len(low.sliding) > 0
    assert len(low.opening) == 0


def test_a_high_push_opens_the_contacts_on_its_side() -> None:
    """The cube turns about its far lower edge: what is nearer to the push rises, and the edge stays."""
    mechanism = pushed(0.09)
    high = parting(mechanism)
    assert len(high.opening) > 0
    assert high.opening[:, 0].max() < 0.05 - 1e-6
    moved = moved_by(mechanism, 0.05)["cube"]
    near, edge = np.array([-0.05, 0.0, 0.0]), np.array([0.05, 0.0, 0.0])
    assert (moved[:3, :3] @ near + moved[:3, 3])[2] > 0.001
    assert abs((moved[:3, :3] @ edge + moved[:3, 3])[2]) < 2e-3


def test_bodies_that_rest_are_not_moved() -> None:
    scene = hf.Scene(
        [floor(), box("a", (0.1, 0.1, 0.1), 1.0, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1.0, (0.3, 0, 0.05))],
        friction=0.5,
    )
    found = hf.robustness(scene, "a", [-0.05, 0.0, 0.02], SIDE, engine="graph").mechanism[0]
    assert moved_by(found, 0.1).keys() == {"a"}
