"""Whether a body comes loose for certain, where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.engines.limit.loose import comes_loose
from holdfast.scene.shipped.blocks import at, box, floor

Z = np.array([0, 0, 1.0])


@pytest.mark.parametrize(("mu", "loose"), [(0.9, True), (1.1, False)])
def test_beside_one_neighbour_nothing_clamps_below_friction_1(mu: float, *, loose: bool) -> None:
    """A block on a floor and against a wall: its wall holds it down by friction only if μ² >= 1."""
    wall = hf.Body("wall", hf.Box(np.array([0.1, 0.5, 0.5])), pose=at(-0.05, 0, 0.25), fixed=True)
    assembly = hf.assemble(hf.Scene([floor(), wall, box("cube", (0.1, 0.1, 0.1), 1, (0.05, 0, 0.05))], mu))
    assert comes_loose(assembly, "cube", Z) is loose
    assert hf.Limit("inscribed", 4).comes_loose(assembly, "cube", Z) is loose, "over the exact cone in any case"


def test_a_body_without_contacts_is_loose() -> None:
    assembly = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.6))
    assert comes_loose(assembly, "cube", Z)
