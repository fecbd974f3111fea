"""What was made firmer stays where it is in MuJoCo, with its real shapes; nothing is nearer to an edge or to others."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.baselines.drop import drop
from bench.suites.firmer import loose_on, tray

pytest.importorskip("mujoco", reason="the drop test needs MuJoCo")


@pytest.mark.referee
@pytest.mark.parametrize("seed", range(10))
def test_two_things_of_a_tray_stay_where_they_are_firmer(seed: int) -> None:
    scene = tray(seed)
    for name in ("upper", loose_on(scene)[0]):
        found = hf.firmer(scene, name)
        assert found.after >= found.before * (1 - 1e-6)
        assert all(found[-1].least[body] >= first * (1 - 1e-6) for body, first in found[0].least.items())
        assert drop(found.assembly, name).stands
        where = found.assembly.scene.body(name).surface_world.vertices
        if name != "upper":
            assert (np.abs(where[:, :2]).max(0) <= (0.225, 0.16)).all()
