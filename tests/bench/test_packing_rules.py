"""The rules of the packing literature: a box, a tower that hangs over, a bridge."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.baselines.packing_rules import base_support_limits, support_polygon_limits
from holdfast.scene.shipped.blocks import box, floor

G, MU = 9.81, 0.5
WAYS = np.array([(1.0, 0, 0), (-1, 0, 0), (0, 1, 0), (0.6, 0.8, 0)])


def stack(*boxes: hf.Body) -> hf.answers.Assembly:
    return hf.assemble(hf.Scene([floor(3, 3), *boxes], MU))


def test_one_box_slips_or_topples() -> None:
    low = stack(box("low", (0.4, 0.2, 0.1), 1, (0, 0, 0.05)))
    tall = stack(box("tall", (0.2, 0.1, 0.8), 1, (0, 0, 0.4)))
    assert support_polygon_limits(low, WAYS) == pytest.approx(MU * G)
    assert support_polygon_limits(tall, WAYS) == pytest.approx(G * np.array([0.1, 0.1, 0.05, 0.05 / 0.8]) / 0.4)
    for assembly in (low, tall):
        assert base_support_limits(assembly, WAYS) == pytest.approx(MU * G)


def test_what_hangs_over_topples_backwards_sooner() -> None:
    """Thrown towards -x by an acceleration along +x; the support ends 0.02 m from the centre on that side."""
    lower, upper = box("lower", (0.2, 0.2, 0.1), 1, (0, 0, 0.05)), box("upper", (0.2, 0.2, 0.2), 1, (-0.08, 0, 0.2))
    assembly = stack(lower, upper)
    found = support_polygon_limits(assembly, WAYS[:2])
    assert found == pytest.approx([G * 0.02 / 0.1, MU * G])
    assert (base_support_limits(assembly, WAYS) == 0).all()
    assert base_support_limits(assembly, WAYS, share=0.5) == pytest.approx(MU * G)
    over = stack(lower, upper.moved(box("upper", (0.2, 0.2, 0.2), 1, (-0.12, 0, 0.2)).pose))
    assert (support_polygon_limits(over, WAYS) == 0).all()


def test_what_lies_on_two_stands_on_all_between() -> None:
    legs = [box(f"leg{k}", (0.1, 0.1, 0.1), 1, (x, 0, 0.05)) for k, x in ((0, -0.2), (1, 0.2))]
    bridge = stack(*legs, box("plank", (0.5, 0.1, 0.02), 1, (0, 0, 0.11)))
    assert support_polygon_limits(bridge, WAYS) == pytest.approx(MU * G)
    assert (base_support_limits(bridge, WAYS) == 0).all()
