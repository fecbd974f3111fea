"""Placement on imperfect faces: poses are compared by what the samples leave."""

from __future__ import annotations

import pytest

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor

ASSEMBLY = hf.assemble(hf.Scene([floor(0.3, 0.3), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5))
THING = hf.Body("object", hf.Box((0.03, 0.03, 0.09)), mass=0.2)
WOODEN = hf.Imperfect(5e-5, 2e9, samples=3)


def placed(imperfect: hf.Imperfect | None) -> hf.answers.Placement:
    return hf.plan_placement(
        *(ASSEMBLY, THING),
        where=hf.Where(supports=["cube"]),
        approach=hf.sets.Approach(orientations="any"),
        search=hf.Search(spacing=0.02, seed=9, candidates=3, solves=400),
        imperfect=imperfect,
    )


def test_the_best_pose_is_that_with_the_largest_lower() -> None:
    """The same three poses; the strongest on ideal faces is not the strongest on high places."""
    real, ideal = placed(WOODEN), placed(None)
    forces = {c.pose.tobytes(): c.robustness for c in ideal.candidates}
    assert {c.pose.tobytes(): c.robustness for c in real.candidates} == forces, "forces stay those of ideal faces"
    lowers = [c.lower for c in real.candidates]
    assert lowers == sorted(lowers, reverse=True)
    assert all(c.lower <= c.robustness for c in real.candidates)
    assert all(c.lower is None for c in ideal.candidates)
    assert real.candidates[0].robustness <= (1 + 1e-6) * ideal.candidates[0].robustness
    assert real.candidates[0].pose.tobytes() != ideal.candidates[0].pose.tobytes()


def test_its_map_covers_the_samples() -> None:
    real = placed(WOODEN)
    assert real.assembly is not None
    again = hf.robustness_map(real.assembly, spacing=0.02, imperfect=WOODEN)
    assert real.robustness == again.weakest().force
    assert real.lower == again.lower[again.answers.decided].min() < real.robustness
    assert real.to_dict()["lower"] == real.lower
    assert any("3 samples of faces" in note for note in real.notes)


def test_other_engines_are_refused_before_anything_is_searched() -> None:
    with pytest.raises(hf.HoldfastError, match="compliant"):
        hf.plan_placement(ASSEMBLY, THING, engine="graph", imperfect=WOODEN)
    with pytest.raises(hf.HoldfastError, match="a float"):
        hf.plan_placement(ASSEMBLY, THING, imperfect=5e-5)
