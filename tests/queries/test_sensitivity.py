"""Derivatives of a push in closed form, and where there are none."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.queries.push import sensitivity
from holdfast.scene.shipped.blocks import box, cube, floor

G = 9.81
X = np.array([1.0, 0, 0])


def test_a_sliding_cube_in_closed_form() -> None:
    """R = mu m g: dR/dmu = m g, dR/dm = mu g, and nothing else matters."""
    found = sensitivity(hf.assemble(cube()), "cube", [-0.05, 0, 0.02], X)
    assert found.force == pytest.approx(0.6 * G)
    assert found.d_mu == {("floor", "cube"): pytest.approx(G, rel=1e-6)}
    assert found.d_mass["cube"] == pytest.approx(0.6 * G, rel=1e-6)
    np.testing.assert_allclose(found.d_com["cube"], 0, atol=1e-4)
    np.testing.assert_allclose(found.d_point, 0, atol=1e-4)
    assert found.moving == ("cube",)


def test_a_toppling_cube_in_closed_form() -> None:
    """R = m g (L/2 + c) / h: by mass, by the centre of mass along the push, by the height of the push."""
    h = 0.09
    found = sensitivity(hf.assemble(hf.Scene(cube().bodies, 2.0)), "cube", [-0.05, 0, h], X)
    r = G * 0.05 / h
    assert found.force == pytest.approx(r)
    assert found.d_mu[("floor", "cube")] == pytest.approx(0, abs=1e-5)
    assert found.d_mass["cube"] == pytest.approx(r, rel=1e-5)
    np.testing.assert_allclose(found.d_com["cube"], [-G / h, 0, 0], atol=1e-3)
    np.testing.assert_allclose(found.d_point, [0, 0, -r / h], atol=1e-3)


def test_standing_loads_keep_their_place() -> None:
    loads = [hf.Load("cube", (0, 0, 0.1), force=(0, 0, -5))]
    found = sensitivity(hf.assemble(cube()), "cube", [-0.05, 0, 0.02], X, standing=loads)
    assert found.force == pytest.approx(0.6 * (G + 5))
    assert found.d_mu[("floor", "cube")] == pytest.approx(G + 5, rel=1e-6)
    assert found.d_mass["cube"] == pytest.approx(0.6 * G, rel=1e-6)


def test_there_is_no_derivative_of_nothing() -> None:
    with pytest.raises(hf.HoldfastError, match="the push is infinite"):
        sensitivity(hf.assemble(cube()), "cube", [0, 0, 0.1], [0, 0, -1])
    falling = hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.5))], 0.6))
    with pytest.raises(hf.HoldfastError, match="the assembly is unstable"):
        sensitivity(falling, "cube", [0, 0, 0.55], X)
    with pytest.raises(hf.errors.SceneError, match="direction: is zero"):
        sensitivity(hf.assemble(cube()), "cube", [0, 0, 0.1], [0, 0, 0])
