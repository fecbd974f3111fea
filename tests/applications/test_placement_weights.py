"""How weights bias where an object is placed: chances by place, against their formula."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.placement.support import SupportPoints, support_points
from holdfast.base.arrays import Float
from holdfast.scene.shipped.blocks import at, prism

ANYWHERE = np.array([[-np.inf] * 3, [np.inf] * 3])
UP = np.array([0, 0, 1.0])
PITCH = np.radians(30)


def roof(pitch: float = PITCH) -> hf.answers.RobustnessMap:
    """A fixed block with a flat top and a side that slopes down at a ``pitch``; no push moves it."""
    fall = 0.2 * np.tan(PITCH)
    outline = np.array([(-0.2, 0), (0.2, 0), (0.2, 0.3 - fall), (0.2 - fall / np.tan(pitch), 0.3), (-0.2, 0.3)])
    block = prism("block", outline, 0.2, 1, fixed=True)
    other = hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1, pose=at(5, 0, 0))
    return hf.robustness_map(hf.assemble(hf.Scene([block, other], 0.5)), ["block"], spacing=0.05, engine="limit")


def chances(points: SupportPoints) -> tuple[Float, Float]:
    """Chances per area on the slope and on the flat top."""
    density = points.chance / points.area
    flat = points.normals[:, 2] > 0.999
    return density[~flat], density[flat]


@pytest.mark.parametrize("level", [0.0, 1.0, 4.0])
def test_a_slope_is_chosen_less_by_its_cosine_to_the_power_of_level(level: float) -> None:
    slope, flat = chances(support_points([roof()], 2.0, UP, hf.sets.Weights(level=level), ANYWHERE))
    assert len(slope) > 5
    assert len(flat) > 5
    assert flat == pytest.approx(np.full(len(flat), flat[0]), rel=1e-9)
    assert slope == pytest.approx(np.full(len(slope), flat[0] * np.cos(PITCH) ** level), rel=1e-9)


@pytest.mark.parametrize(("degrees", "chosen"), [(60, True), (78, True), (79, False), (85, False)])
def test_what_is_steeper_than_arccos_0_2_carries_nothing(degrees: float, chosen: bool) -> None:
    found = support_points([roof(np.radians(degrees))], 2.0, UP, hf.sets.Weights(), ANYWHERE)
    assert (found.normals[:, 2] < 0.999).any() == chosen


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_a_weak_place_is_chosen_less_by_its_robustness_to_the_power_of_the_weight(exponent: float) -> None:
    """A plank tips over the edge of its base: chance per area ∝ (R / (R + weight))^exponent."""
    base = hf.Body("base", hf.Box((0.1, 0.1, 0.1)), fixed=True)
    plank = hf.Body("plank", hf.Box((0.3, 0.1, 0.02)), mass=1, pose=at(0, 0, 0.06))
    m = hf.robustness_map(hf.assemble(hf.Scene([base, plank], 0.5)), ["plank"], spacing=0.03, engine="limit")
    weight = 3.0
    found = support_points([m], weight, UP, hf.sets.Weights(robustness=exponent, level=0), ANYWHERE)
    expected = np.array([1.0 if np.isinf(f) else f / (f + weight) for f in found.force]) ** exponent
    ratio = found.chance / found.area / expected
    assert np.isinf(found.force).any()
    assert np.isfinite(found.force).any()
    assert ratio == pytest.approx(np.full(len(ratio), ratio[0]), rel=1e-9)
    assert found.chance.sum() == pytest.approx(1)
