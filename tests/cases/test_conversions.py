"""Scenes of robot simulators in every format that is written: masses, poses and friction as they were."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shared

import holdfast as hf

ROBOTS = shared.FOLDER / "robots"
SOURCES = sorted(path for kind in ("*.xml", "*.urdf", "*.sdf", "*.usda") for path in ROBOTS.rglob(kind))
EXTRAS = {".xml": ("mujoco", "mujoco"), ".usda": ("pxr", "usd")}


def needed(suffix: str) -> None:
    if suffix in EXTRAS:
        module, extra = EXTRAS[suffix]
        pytest.importorskip(module, reason=f"needs pip install 'holdfast-robotics[{extra}]'")


def frictions(scene: hf.Scene) -> dict[tuple[str, str], list[float]]:
    """The friction of every pair that may touch, of all parts of each body."""
    found = {}
    for a, b in itertools.combinations(scene.bodies, 2):
        if not (a.fixed and b.fixed) and tuple(sorted((a.name, b.name))) not in scene.excluded:
            parts = itertools.product(dict.fromkeys(a.materials), dict.fromkeys(b.materials))
            found[a.name, b.name] = [scene.friction.between(a.name, b.name, {a.name: x, b.name: y}) for x, y in parts]
    return found


@shared.needed
@pytest.mark.parametrize("target", [".yaml", ".json", ".xml", ".glb", ".gltf"])
@pytest.mark.parametrize("source", SOURCES or [Path("absent")], ids=lambda path: path.name)
def test_a_scene_is_the_same_in_every_format(source: Path, target: str, tmp_path: Path) -> None:
    needed(source.suffix)
    needed(target)
    options: dict[str, Any] = {"floor": True} if source.suffix == ".urdf" else {}
    scene = hf.load_scene(source, **options)
    hf.save_scene(scene, tmp_path / f"scene{target}")
    again = hf.load_scene(tmp_path / f"scene{target}")
    assert [(b.name, b.fixed) for b in again.bodies] == [(b.name, b.fixed) for b in scene.bodies]
    assert (again.gravity.tolist(), again.excluded) == (scene.gravity.tolist(), scene.excluded)
    for old, new in zip(scene.bodies, again.bodies, strict=True):
        np.testing.assert_allclose(new.pose, old.pose, rtol=0, atol=1e-9)
        if old.fixed:
            continue
        assert new.mass == pytest.approx(old.mass, rel=1e-9)
        np.testing.assert_allclose(new.com_body, old.com_body, rtol=0, atol=1e-9)
        np.testing.assert_allclose(new.inertia_com, old.inertia_com, rtol=0, atol=1e-9 * np.abs(old.inertia_com).max())
        np.testing.assert_allclose(np.array(new.box), np.array(old.box), rtol=0, atol=1e-6)  # meshes: single precision
    before, after = frictions(scene), frictions(again)
    assert before.keys() == after.keys()
    for pair, values in before.items():
        assert sorted(set(after[pair])) == pytest.approx(sorted(set(values)), abs=1e-9), pair
