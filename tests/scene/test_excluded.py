"""Pairs of bodies that do not touch, wherever they are: not searched, kept, saved and checked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.assembly.one_group import part_of
from holdfast.contacts.neighbours import neighbours
from holdfast.scene.shipped.blocks import at, box, floor

SIDE = (0.1, 0.1, 0.1)


def stack(**options: Any) -> hf.Scene:
    cubes = [box(f"cube{k}", SIDE, 1, (0, 0, 0.05 + 0.1 * k)) for k in range(3)]
    return hf.Scene([floor(), *cubes], 0.5, **options)


def touching(scene: hf.Scene) -> set[tuple[str, ...]]:
    return {tuple(sorted(interface.bodies)) for interface in hf.assemble(scene).interfaces}


def test_contacts_between_an_excluded_pair_are_not_searched() -> None:
    whole, without = stack(), stack(excluded=[("cube1", "cube0")])
    assert touching(whole) - touching(without) == {("cube0", "cube1")}
    assert touching(without) < touching(whole)
    assert without.excluded == (("cube0", "cube1"),)
    assert ("cube0", "cube1") not in {(a.name, b.name) for a, b in neighbours(without, 0.01)}
    assert hf.stability(without).status is hf.Status.UNSTABLE


def test_an_excluded_pair_may_overlap_without_a_warning(recwarn: pytest.WarningsRecorder) -> None:
    scene = hf.Scene([floor(), box("a", SIDE, 1, (0, 0, 0.05)), box("b", SIDE, 1, (0.05, 0, 0.05))], 0.5)
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        assert hf.assemble(scene).overlaps
    recwarn.clear()
    free = hf.assemble(replace(scene, excluded=[("a", "b")]))
    assert free.overlaps == ()
    assert not [each for each in recwarn if "overlap" in str(each.message)]
    assert hf.stability(free).status is hf.Status.STABLE


def test_groups_keep_their_excluded_pairs() -> None:
    """A group is judged as an assembly of its own, which must not look for what the whole one does not."""
    side = hf.Scene([floor(), box("a", SIDE, 1, (0, 0, 0.05)), box("b", SIDE, 1, (0.1, 0, 0.05))], 0.5)
    answer = hf.robustness(replace(side, excluded=[("a", "b")]), "a", (-0.05, 0, 0.001), (1, 0, 0), engine="limit")
    assert answer.force[0] == pytest.approx(0.5 * 9.81, rel=1e-6)
    arch = hf.assemble(stack(excluded=[("cube2", "cube0"), ("cube2", "floor")]))
    (group,) = arch.groups
    part = part_of(arch, group).assembly
    assert part.scene.excluded == (("cube0", "cube2"), ("cube2", "floor"))
    assert hf.robustness(side, "a", (-0.05, 0, 0.001), (1, 0, 0), engine="limit").force[0] > 0.9 * 9.81


def test_edits_keep_the_pairs_of_the_bodies_that_stay() -> None:
    scene = stack(excluded=[("cube1", "cube0"), ("floor", "cube2")], notes=("read",))
    kept = (("cube0", "cube1"), ("cube2", "floor"))
    assert scene.excluded == kept
    assert scene.moved({"cube2": at(1, 0, 1)}).excluded == kept
    assert scene.with_body(box("cube3", SIDE, 1, (0, 0, 1))).excluded == kept
    assert scene.without("cube0").excluded == kept[1:]
    assert scene.without("cube0", "cube2").excluded == ()
    assert hf.assemble(scene).without("cube2").scene.excluded == kept[:1]
    assert scene.moved({"cube2": at(1, 0, 1)}).notes == ("read",)


def test_a_scene_is_another_with_other_pairs_but_not_with_other_notes() -> None:
    assert stack(excluded=[("cube0", "cube1")]) != stack()
    assert stack(excluded=[("cube0", "cube1")]) == stack(excluded=[("cube1", "cube0"), ("cube0", "cube1")])
    assert stack(notes=["a guess"]) == stack()


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_native_files_hold_the_pairs(tmp_path: Path, suffix: str) -> None:
    scene = stack(excluded=[("cube1", "cube0")])
    hf.save_scene(scene, tmp_path / f"stack{suffix}")
    assert hf.load_scene(tmp_path / f"stack{suffix}") == scene
    hf.save_scene(stack(), tmp_path / f"plain{suffix}")
    assert "excluded" not in (tmp_path / f"plain{suffix}").read_text()


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ([("cube0", "cub1")], r"excluded: pair \('cube0', 'cub1'\): unknown name 'cub1'; did you mean 'cube1'\?"),
        ([("cube0",)], r"excluded: pair \('cube0',\): is no pair; needs two bodies"),
        ([("cube0", "cube0")], r"excluded: pair .*: is of one body"),
        ([("cube0", 1)], r"excluded: pair .*: is no pair"),
        ("cube0", r"excluded: is 'cube0'; needs a list of pairs of bodies"),
        (7, r"excluded: is 7; needs a list of pairs of bodies"),
    ],
)
def test_what_is_no_pair_of_bodies_is_refused(given: Any, match: str) -> None:
    with pytest.raises(hf.errors.SceneError, match=match):
        stack(excluded=given)


def test_friction_may_name_the_materials_of_parts() -> None:
    parts = [hf.Part(hf.Box(SIDE), material="rubber"), hf.Part(hf.Box(SIDE), at(0.1, 0, 0))]
    body = hf.Body("b", hf.Compound(parts), mass=1, pose=at(0, 0, 0.05), material="wood")
    assert body.materials == ("rubber", "wood")
    table = hf.Friction(0.5, {("rubber", "wood"): 0.9})
    scene = hf.Scene([floor(), body], table)
    assert scene.names == {"floor", "b", "rubber", "wood"}
    assert scene.without("b").friction.pairs == {}
    assert np.isclose(scene.mu("floor", "b"), 0.5)
