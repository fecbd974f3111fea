"""What a validator is told of a scene: severities by tolerance, remedies that are proved, pushes, notes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from broken_stages import crates, ladder, pile

import holdfast as hf
from holdfast.base.errors import HoldfastError
from holdfast.batches.scene_findings import SceneFinding, ScenePolicy, findings_of_scene

GAP = np.sqrt(3) * 1e-4  # [m] a thousandth of the diagonal of a crate: its tolerance with the floor


def told(scene: hf.Scene, **policy: float) -> list[SceneFinding]:
    return [one for one in findings_of_scene(scene, ScenePolicy(**policy)) if one.severity != "info"]


@pytest.mark.parametrize("lift", [1.0, -1.0])
@pytest.mark.parametrize(("share", "severity"), [(0.9, None), (1.5, "warning"), (2.5, "failure")])
def test_hovering_and_overlapping_are_judged_by_the_tolerance(lift: float, share: float, severity: str | None) -> None:
    found = told(crates((0, lift * share * GAP)))
    word = "hovers" if lift > 0 else "overlap"
    assert [one.severity for one in found if word in one.text and "undecided" not in one.text] == [severity] * bool(
        severity
    )
    assert bool(found) == bool(severity)
    assert not told(crates((0, lift * share * GAP)), tolerance=3 * GAP)


def test_of_two_bodies_that_overlap_both_are_told() -> None:
    scene = crates((0, 0), (0, 0.098))
    assert {one.body for one in told(scene) if "overlap" in one.text} == {"crate0", "crate1"}


def test_a_remedy_moves_what_touches_and_leaves_the_rest() -> None:
    """Two crates hover by 5 mm, one on the other; a third one hangs within the tolerance."""
    found = told(crates((0, 0.005), (0, 0.105), (1, 0.5 * GAP)))
    for one in found:
        assert one.remedy.keys() == {"crate0", "crate1"}
        assert "moves 1 more" in one.how
        np.testing.assert_allclose([one.remedy[f"crate{k}"][2, 3] for k in (0, 1)], [0.05, 0.15], atol=1e-6)
        for pose in one.remedy.values():
            np.testing.assert_array_equal(pose[:3, :3], np.eye(3))  # without the noise of a motion


def test_what_falls_has_no_remedy_and_others_keep_theirs() -> None:
    """A crate over an edge falls wherever it goes; one that hovers elsewhere comes to rest."""
    found = {one.body: one for one in told(crates((0, 0), (0.06, 0.1), (1, 0.004)))}
    assert not found["crate1"].remedy
    assert "no remedy within 30 mm: crate1 falls" in found["crate1"].text
    assert found["crate2"].remedy.keys() == {"crate2"}


def test_remedies_go_no_further_than_the_travel() -> None:
    scene = crates((0, 0.11))
    assert not any(one.remedy for one in told(scene))
    assert all(one.remedy for one in told(scene, travel=0.12))


def test_a_push_is_told_at_the_body_that_yields_to_it() -> None:
    """A cube of 1 kg slips at mu m g = 4.9 N, along a face pushed in its middle; near an edge it turns before."""
    scene = crates((0, 0), (1, 0))
    assert told(scene, min_force=1.0) == []
    found = told(scene, min_force=4.91)
    assert [(one.severity, one.body) for one in found] == [("failure", "crate0"), ("failure", "crate1")]
    assert not any(one.remedy for one in found)  # of what stands


@pytest.mark.parametrize("seed", range(4))
def test_random_piles_pass_until_the_top_goes_over_the_edge(seed: int) -> None:
    """The least side is 0.1 m and the centres are within 0.02 m: at 0.03 m the top stands, at 0.1 m it cannot."""
    assert told(pile(seed, shift=0.02)) == []
    assert [(one.severity, one.body) for one in told(pile(seed, shift=0.1))] == [("failure", "box5")]


def test_a_ladder_stands_by_friction_alone() -> None:
    assert told(ladder(0.3)) == []
    assert [one.severity for one in told(ladder(0.2))] == ["failure"]


def test_a_ball_is_told_to_be_balanced_and_passes() -> None:
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1, pose=hf.pose(z=0.05))
    scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), ball], 0.5)
    found = findings_of_scene(replace(scene, notes=("units guessed",)), ScenePolicy())
    assert {one.severity for one in found} == {"info"}
    assert found[0].body == "ball"
    assert "units guessed" in {one.text for one in found}


def test_a_policy_out_of_range_is_an_error() -> None:
    with pytest.raises(HoldfastError, match="gap: is -1"):
        findings_of_scene(crates((0, 0)), ScenePolicy(tolerance=-1.0))
