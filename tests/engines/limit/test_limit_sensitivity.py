"""Derivatives of one answer against central differences on rebuilt scenes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from changed_scenes import PUSHES, pushed, scene_with

import holdfast as hf
from holdfast.queries.sensitivity import sensitivity
from holdfast.scene.shipped import shipped_scene

G = 9.81


@pytest.mark.parametrize(("name", "body", "point", "direction"), PUSHES)
def test_derivatives_are_those_of_rebuilt_scenes(name: str, body: str, point: list[float], direction: Any) -> None:
    assembly = hf.assemble(shipped_scene(name))
    found = sensitivity(assembly, body, point, direction)
    size, weight = assembly.size, assembly.weight
    scale = found.force

    def central(step: float, build: Any) -> float:
        up, down = (pushed(*build(sign * step)) for sign in (1, -1))
        return (up - down) / (2 * step)

    def same(derivative: float, difference: float, unit: float) -> None:
        assert derivative == pytest.approx(difference, rel=1e-4, abs=1e-4 * unit)

    assert found.lower <= found.force <= found.upper
    for pair, mu in zip((i.bodies for i in assembly.interfaces), assembly.mu, strict=True):
        slope = central(1e-4, lambda d, pair=pair, mu=mu: (scene_with(name, {pair: mu + d}), body, point, direction))
        same(found.d_mu[pair], slope, scale)
    for b in assembly.movable:
        slope = central(1e-3, lambda d, n=b.name: (scene_with(name, mass={n: d}), body, point, direction))
        same(found.d_mass[b.name], slope, G)
        for k in range(3):
            step = np.eye(3)[k]
            slope = central(
                1e-4 * size, lambda d, n=b.name, e=step: (scene_with(name, com={n: d * e}), body, point, direction)
            )
            same(found.d_com[b.name][k], slope, weight / size)


@pytest.mark.parametrize(("name", "body", "point", "direction"), PUSHES)
def test_the_derivative_by_the_point_is_that_of_the_wrench(name: str, body: str, point: Any, direction: Any) -> None:
    """A point may leave the surface here: the load is a force with a moment."""
    assembly = hf.assemble(shipped_scene(name))
    found = sensitivity(assembly, body, point, direction)
    e = np.asarray(direction) / np.linalg.norm(direction)
    step = 1e-4 * assembly.size
    for k in range(3):
        r = [
            hf.load_factor(
                assembly, [hf.Load(body, np.asarray(point) + s * step * np.eye(3)[k], force=e)], engine="limit"
            )
            for s in (1, -1)
        ]
        slope = (r[0].factor - r[1].factor) / (2 * step)
        assert found.d_point[k] == pytest.approx(slope, rel=1e-4, abs=1e-4 * found.force / assembly.size)
