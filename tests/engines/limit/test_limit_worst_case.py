"""The worst case of a box of uncertain values against sampling."""

from __future__ import annotations

import numpy as np
import pytest
from changed_scenes import PUSHES, pushed, scene_with

import holdfast as hf
from holdfast.queries.worst_case import worst_case
from holdfast.scene.shipped import shipped_scene


@pytest.mark.parametrize("seed", range(3))
def test_nothing_in_the_box_is_weaker_than_the_worst_case(seed: int) -> None:
    name, body, point, direction = PUSHES[5]
    assembly = hf.assemble(shipped_scene(name))
    half = {"slab": np.array([0.02, 0.01, 0.01]), "leg_left": np.array([0.004, 0.0, 0.02])}
    mass = {"slab": (1.8, 2.4), "leg_right": (0.8, 1.1)}
    found = worst_case(assembly, body, point, direction, mu_range=0.1, mass_range=mass, com_range=half, exists=True)
    assert found.corners == 4 * 4 * 2
    rng = np.random.default_rng(seed)
    for _ in range(15):
        mu = {i.bodies: rng.uniform(0.45, 0.55) for i in assembly.interfaces}
        change = {n: rng.uniform(*mass[n]) - assembly.mass[assembly.index[n]] for n in mass}
        com = {n: rng.uniform(-1, 1, 3) * half[n] for n in half}
        assert pushed(scene_with(name, mu, change, com), body, point, direction) >= found.force[0] * (1 - 1e-6)
    (masses,), (coms,) = found.masses, found.coms
    change = {n: m - assembly.mass[assembly.index[n]] for n, m in masses.items()}
    shift = {n: np.array(c) - assembly.com[assembly.index[n]] for n, c in coms.items()}
    at_worst = pushed(scene_with(name, found.mu, change, shift), body, point, direction)
    assert at_worst == pytest.approx(found.force[0], rel=1e-6), "the corner named is the worst"
