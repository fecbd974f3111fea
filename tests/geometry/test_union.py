"""Unions of closed surfaces: volumes, the solid that each triangle comes from, and solids that are there many times."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.base.arrays import Float, Int
from holdfast.geometry.solid import united
from holdfast.geometry.triangles import areas_of

Solid = tuple[Float, Int]


def cube(x: float) -> Solid:
    surface = hf.Box((1, 1, 1)).surface
    return surface.vertices + np.array([x, 0, 0]), surface.faces


def test_solids_that_are_there_many_times_count_once_in_the_union_and_each_in_what_is_shared() -> None:
    """Two cubes that overlap by a half, the first one 500 times: as many coincident surfaces would take minutes."""
    pair, many = united([cube(0), cube(0.5)]), united([cube(0)] * 500 + [cube(0.5)] * 2)
    assert pair is not None
    assert many is not None
    assert pair.shared == pytest.approx(0.5)
    assert many.shared == pytest.approx(500 + 2 - 1.5)
    for found, second in ((pair, 1), (many, 500)):
        areas = areas_of(found.vertices, found.faces)
        assert areas.sum() == pytest.approx(2 * (1 + 1.5 + 1.5))
        assert set(found.part.tolist()) == {0, second}
        assert found.vertices[found.faces[found.part == 0]][:, :, 0].max() < 0.5 + 1e-9
        assert np.ptp(found.vertices[:, 0]) == pytest.approx(1.5)
