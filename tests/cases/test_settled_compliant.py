"""Scenes that were at rest in a physics engine stand on elastic contacts, and no push exceeds limit analysis."""

from __future__ import annotations

import numpy as np
import pytest
from shared import FOLDER, needed

import holdfast as hf
from bench.suites.reliability import SETTLED, random_pushes

# the engine that settled them used convex parts: the meshes show gaps, which these tolerances allow for
AT_REST: dict[str, dict[str, float]] = {**SETTLED, "masonry_crossvault": {}}
PUSHED = ("beam_frame", "lack_table", "leaning")

pytestmark = [needed, pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")]


def settled(name: str, **tolerances: float) -> hf.answers.Assembly:
    return hf.assemble(hf.load_scene(FOLDER / "settled" / f"{name}.json"), **tolerances)


@pytest.mark.parametrize("name", AT_REST)
def test_what_was_at_rest_stands(name: str) -> None:
    result = hf.stability(settled(name, **AT_REST[name]))
    assert result.status is hf.Status.STABLE, result.reason
    assert result.residual <= 1e-8


def test_the_tilted_bowl_has_support_on_one_side_only() -> None:
    """Within 3 mm b1 touches b0 on one side of its rim: what held the convex parts up is missing on the meshes."""
    assembly = settled("dishes", gap=3e-3)
    result = hf.stability(assembly)
    assert result.status is hf.Status.UNDECIDED
    assert "would rest there" in result.reason
    assert result.moving == ("b1",)
    (rim,) = (i for i in assembly.interfaces if set(i.bodies) == {"b0", "b1"})
    outward = np.array([p.centroid - assembly.scene.body("b0").com_world for p in rim.patches])[:, :2]
    middle = outward.mean(0) / np.linalg.norm(outward.mean(0))
    assert (outward @ middle > 0).all()
    assert "ambiguous_gap" in rim.flags
    assert hf.stability(settled("dishes", gap=5e-3)).status is hf.Status.STABLE


@pytest.mark.parametrize("name", PUSHED)
def test_no_push_exceeds_limit_analysis(name: str) -> None:
    """A path that throws a body far out once balanced it by rounding: 4 % too much on one of these."""
    assembly = settled(name, **AT_REST[name])
    W = random_pushes(assembly, 50, 77)
    found, certain = hf.Compliant().prepare(assembly).load_factor(W), hf.Limit().prepare(assembly).load_factor(W)
    decided = np.array([status is not hf.Status.UNDECIDED for status in found.status])
    assert decided.mean() > 0.95
    assert (found.force <= certain.upper * (1 + 1e-6)).all()
