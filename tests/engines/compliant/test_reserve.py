"""What friction a state of rest has in reserve, and what becomes of it on more nodes."""

from __future__ import annotations

import numpy as np
import pytest
from compliant_scenes import STANDING
from engine_scenes import G0, block, cube, floor, shipped

from holdfast import Compliant, Scene, Status, assemble, stability
from holdfast.engines.compliant import rest_verdict
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid


@pytest.mark.parametrize("name", STANDING)
def test_what_stands_far_from_its_limit_is_not_asked_on_more_nodes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Grid, "finer", property(lambda _: pytest.fail("a finer grid was made")))
    assert Compliant().prepare(shipped(name)).verdict().status is Status.STABLE


def slope(share: float, blocks: int, tilt: float) -> Scene:
    """Slabs on each other on a slope, with ``share`` times the friction that just holds them."""
    angle = np.radians(tilt)
    slabs = [block(f"slab{k}", (0.2, 0.2, 0.05), (0, 0, 0.05 * k + 0.025), 1 + k) for k in range(blocks)]
    return Scene([floor(), *slabs], share * np.tan(angle), G0 * np.array([np.sin(angle), 0, -np.cos(angle)]))


@pytest.mark.parametrize("tilt", [10, 25, 40])
@pytest.mark.parametrize("blocks", [1, 3])
@pytest.mark.parametrize("engine", ["limit", "compliant"])
def test_slabs_on_a_slope_are_decided_next_to_their_limit(tilt: float, blocks: int, engine: str) -> None:
    for share, status in ((1.001, Status.STABLE), (0.999, Status.UNSTABLE)):
        assert stability(assemble(slope(share, blocks, tilt)), engine=engine).status is status


@pytest.mark.parametrize("lean", [0.499, 0.501])
def test_a_block_that_all_but_tips_is_decided(lean: float) -> None:
    assembly = cube(0.6, gravity=(G0 * lean, 0, -G0), height=0.2)
    assert stability(assembly).status is (Status.STABLE if lean < 0.5 else Status.UNSTABLE)


@pytest.mark.parametrize("spare", [0.003, 0.03])
def test_the_reserve_of_a_slab_on_a_slope_is_its_friction_beyond_the_slope(spare: float) -> None:
    assembly = assemble(slope(1 / (1 - spare), 1, 25))
    for nodes in (5, 7, 14):
        grid = Grid.of(assembly, assembly.weight_wrench(), Springs(nodes))
        found = rest_verdict._friction_in_reserve(grid)
        assert spare <= found <= 1.051 * spare
