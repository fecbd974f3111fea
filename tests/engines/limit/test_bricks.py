"""Random models of bricks that hold by their studs, beside a linear program that knows nothing of holdfast."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.bricks import least_tension, random_bricks, scene_of
from bench.suites.bricks import ABOVE, BELOW, NONE, SIDES, compared


@pytest.mark.parametrize("seed", range(4))
def test_an_equilibrium_exists_from_the_tension_on_that_a_linear_program_finds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert compared(random_bricks(rng, int(rng.integers(5, 16))))["alike"]


def test_engine_compliant_contradicts_no_linear_program() -> None:
    rng, seen = np.random.default_rng(9), 0
    for _ in range(4):
        bricks = random_bricks(rng, 8)
        low, high = (least_tension(bricks, SIDES, inside=inside) for inside in (False, True))
        if low > NONE:
            seen += 1
            assert not hf.stability(scene_of(bricks, BELOW * low)).stable
        assert hf.stability(scene_of(bricks, 3 * ABOVE * high)).stable
    assert seen
