"""Bodies of one shape in one place are told at once: every two of them would overlap all over (Z11)."""

from __future__ import annotations

import numpy as np
import pytest
from placed import FLOOR, at

import holdfast as hf


def test_copies_are_named() -> None:
    boxes = [hf.Body(f"b{k}", hf.Box((0.1, 0.1, 0.1)), 1.0, pose=at(z=0.05)) for k in range(3000)]
    with pytest.raises(
        hf.errors.SceneError, match=r"'b0', 'b1', .* and 2,995 more: are 3,000 bodies of one shape in one place"
    ):
        hf.assemble(hf.Scene([FLOOR, *boxes], 0.5))


def test_copies_of_compounds_and_of_a_fixed_body_are_named() -> None:
    tin = hf.Compound([hf.Part(hf.Cylinder(0.05, 0.1), at(z=0.05 + 0.02 * k)) for k in range(5)])
    again = hf.Compound([hf.Part(hf.Cylinder(0.05, 0.1), at(z=0.05 + 0.02 * k)) for k in range(5)])
    with pytest.raises(hf.errors.SceneError, match="'shelf', 'tin': are 2 bodies of one shape in one place"):
        hf.assemble(hf.Scene([FLOOR, hf.Body("shelf", tin, fixed=True), hf.Body("tin", again, 1.0)], 0.5))


def test_others_may_lie_in_one_place() -> None:
    """Fixed copies, copies that never touch, and meshes in the coordinates of the world."""
    box = hf.Box((0.1, 0.1, 0.1))
    walls = [hf.Body(f"w{k}", box, fixed=True, pose=at(z=-1.0)) for k in range(2)]
    ghosts = [hf.Body(f"g{k}", box, 1.0, pose=at(z=0.05)) for k in range(2)]
    meshes = [
        hf.Body(f"m{k}", hf.Mesh(box.surface.vertices + np.array([1 + k, 0, 0.05]), box.surface.faces), 1.0)
        for k in range(2)
    ]
    scene = hf.Scene([FLOOR, *walls, *ghosts, *meshes], 0.5, excluded=[("g0", "g1")])
    assert len(hf.assemble(scene).movable) == 4
