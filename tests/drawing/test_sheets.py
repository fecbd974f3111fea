"""Sheets of panels show what they are about: a body that others hide shines through, and nothing is cut off."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from holdfast.base.arrays import Float
from holdfast.drawing.panel_sheets import PointsPanel, StateFrame, StateSequence, sheet_png, write_sequence
from holdfast.drawing.picture import HeatSurface, Picture, Solid

matplotlib_image = pytest.importorskip("matplotlib.image")
UP = np.array([0.0, 0.0, 1.0])


def box(make: Callable[..., HeatSurface], name: str, low: Float, high: Float) -> Solid:
    surface = make(name, low, high, lambda points: points[:, 2])
    return Solid(name, surface.vertices, surface.triangles, False)


def orange(image: Float) -> int:
    """How many pixels are more red than blue, as a tint of orange over grey is."""
    return int((image[..., 0] > image[..., 2] + 0.05).sum())


def test_a_body_that_others_hide_shines_through(heat_box: Callable[..., HeatSurface], tmp_path: Path) -> None:
    small = box(heat_box, "small", np.array([-0.02, -0.02, 0.02]), np.array([0.02, 0.02, 0.06]))
    large = box(heat_box, "large", np.array([-0.1, -0.1, 0.0]), np.array([0.1, 0.1, 0.1]))
    counts = []
    for next_body in ("small", ""):
        sequence = StateSequence("", "", (StateFrame((small, large), next_body, ""),), np.array([1.0, 0, 0]), UP)
        write_sequence(sequence, tmp_path / "s.png")
        image = matplotlib_image.imread(tmp_path / "s.png")
        counts.append(orange(image[92:, :, :3]))
    assert counts[0] > 500 > 50 > counts[1]


def test_a_faint_picture_is_not_cut_off(heat_box: Callable[..., HeatSurface]) -> None:
    low, high = np.array([-0.1, -0.1, 0.0]), np.array([0.1, 0.1, 0.2])
    here = Picture("", "", (), (box(heat_box, "crate", low, high),))
    above = Picture("", "", (), (box(heat_box, "crate", low + 0.1 * UP, high + 0.1 * UP),))
    image = matplotlib_image.imread(BytesIO(sheet_png([[PointsPanel("", here, ghost=above)]], "", "")))
    rows, columns = np.nonzero(image[126:576, 26:626, 0] > image[126:576, 26:626, 2] + 0.05)
    assert len(rows) > 1000
    assert 20 < rows.min() < rows.max() < 430
    assert 20 < columns.min() < columns.max() < 580
