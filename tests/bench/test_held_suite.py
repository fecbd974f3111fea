"""What holds, in both codes, beside closed forms; and piles in closed geometry."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.piles import PILES
from bench.scenes.random_pushes import Push
from bench.suites import held
from holdfast import Cylinder, Sphere
from holdfast.scene.shipped import shipped_scene

SLIDES, TIPS = 0.6 * 9.81, 9.81 * 0.05 / 0.09  # [N]: a cube of 1 kg and 0.1 m, pushed low, and at 0.09 m
CODES = {"mujoco": held.by_mujoco, "dem": held.by_elements}


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize(("height", "right"), [(0.01, SLIDES), (0.09, TIPS)])
def test_a_cube_slides_and_tips_where_the_closed_form_says(code: str, height: float, right: float) -> None:
    if code == "mujoco":
        pytest.importorskip("mujoco", reason="the referee needs MuJoCo: pip install -e '.[bench]'")
    push = Push("cube", np.array([-0.05, 0, height]), np.array([1.0, 0, 0]))
    found = CODES[code](hf.assemble(shipped_scene("cube")), push, 1.1 * right)
    assert 0.94 * right < found[f"holds_{code}"] < 1.01 * right
    assert 0.99 * right < found[f"moves_{code}"] < 1.06 * right


@pytest.mark.parametrize("number", range(2 * len(PILES)))
def test_bodies_of_a_pile_touch_and_do_not_overlap(number: int) -> None:
    assembly = held.pile(number)
    assert not assembly.overlaps
    spots = [
        (body.com_world, body.shape.radius) for body in assembly.movable if isinstance(body.shape, Cylinder | Sphere)
    ]
    assert len(spots) == len(assembly.movable)
    across = np.array([1, 0, 1]) if isinstance(assembly.movable[0].shape, Cylinder) else np.ones(3)
    air = [np.linalg.norm(across * (a - b)) - r - s for (a, r), (b, s) in itertools.combinations(spots, 2)]
    assert min(air) > -1e-9
    assert sum(gap < 1e-9 for gap in air) >= len(spots) - 1


def test_a_bound_above_what_both_codes_see_move_is_named() -> None:
    seen = {"holds_mujoco": 1.0, "moves_mujoco": 1.1, "holds_dem": 0.9, "moves_dem": 1.2} | dict.fromkeys(
        (f"slid {far:g}" for far in held.SLID), 0.5
    )
    row = {"case": "jam_7", "family": "cradle", "force": 2.0, "lower": 1.19} | seen
    assert "`lower` of jam_7" not in held.written([row])
    assert "`lower` of jam_7" in held.written([row | {"lower now": 1.3}])
