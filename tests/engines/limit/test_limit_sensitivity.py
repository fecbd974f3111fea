"""Derivatives against central differences on rebuilt scenes, and the worst case of a box of values against samples."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.queries.push import sensitivity
from holdfast.queries.uncertainty import worst_case
from holdfast.scene.shipped import shipped_scene

G = 9.81
PUSHES: list[tuple[str, str, list[float], list[float]]] = [
    ("cube", "cube", [-0.05, 0.045, 0.02], [1, 0, 0]),  # slides and turns
    ("cube", "cube", [-0.05, 0.0, 0.098], [1, 0.02, 0]),  # topples
    ("stack", "cube3", [-0.05, 0.03, 0.23], [1, 0.1, -0.2]),
    ("stack", "cube2", [-0.05, 0.013, 0.16], [1, 0.05, 0.1]),
    ("table", "slab", [-0.25, 0.02, 0.225], [1, 0.03, 0.0]),  # sways
    ("table", "slab", [0.2, -0.1, 0.225], [0.02, 1, 0]),
    ("table", "slab", [-0.24, 0.01, 0.25], [0.0, 0, -1]),  # tips about a leg
    ("table", "leg_left", [-0.2, 0.03, 0.1], [1, 0, 0]),
]


def scene_with(
    name: str,
    mu: dict[Any, float] | None = None,
    mass: dict[str, float] | None = None,
    com: dict[str, Any] | None = None,
) -> hf.Scene:
    """A shipped scene with changed values; com is an offset in the world (the bodies here stand upright)."""
    scene = shipped_scene(name)
    bodies = []
    for body in scene.bodies:
        if not body.fixed:
            shift = np.zeros(3) if com is None else np.asarray(com.get(body.name, np.zeros(3)))
            body = replace(body, mass=body.mass + (mass or {}).get(body.name, 0.0), com=body.com_body + shift)
        bodies.append(body)
    pairs = {tuple(sorted(p)): v for p, v in (mu or {}).items()}
    return hf.Scene(bodies, hf.Friction(default=scene.friction.default, pairs=pairs))


def pushed(scene: hf.Scene, body: str, point: Any, direction: Any) -> float:
    return float(hf.robustness(hf.assemble(scene), body, point, direction, engine="limit").force[0])


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


@pytest.mark.parametrize("seed", range(3))
def test_nothing_in_the_box_is_weaker_than_the_worst_case(seed: int) -> None:
    name, body, point, direction = PUSHES[5]
    assembly = hf.assemble(shipped_scene(name))
    half = {"slab": np.array([0.02, 0.01, 0.01]), "leg_left": np.array([0.004, 0.0, 0.02])}
    mass = {"slab": (1.8, 2.4), "leg_right": (0.8, 1.1)}
    found = worst_case(assembly, body, point, direction, mu_range=0.1, mass_range=mass, com_range=half, exists=True)
    assert found.corners == 4 * 4 * 2
    rng = np.random.default_rng(seed)
    for _ in range(15):
        mu = {i.bodies: rng.uniform(0.45, 0.55) for i in assembly.interfaces}
        change = {n: rng.uniform(*mass[n]) - assembly.mass[assembly.index[n]] for n in mass}
        com = {n: rng.uniform(-1, 1, 3) * half[n] for n in half}
        assert pushed(scene_with(name, mu, change, com), body, point, direction) >= found.force[0] * (1 - 1e-6)
    (masses,), (coms,) = found.masses, found.coms
    change = {n: m - assembly.mass[assembly.index[n]] for n, m in masses.items()}
    shift = {n: np.array(c) - assembly.com[assembly.index[n]] for n, c in coms.items()}
    at_worst = pushed(scene_with(name, found.mu, change, shift), body, point, direction)
    assert at_worst == pytest.approx(found.force[0], rel=1e-6), "the corner named is the worst"
