"""Derivatives against central differences on rebuilt scenes; the worst case against sampling."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.queries.sensitivity import sensitivity, worst_case
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, cube, floor

G = 9.81
X, Y = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
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
    with pytest.raises(hf.SceneError, match="direction is zero"):
        sensitivity(hf.assemble(cube()), "cube", [0, 0, 0.1], [0, 0, 0])


def test_the_worst_cube_in_closed_form() -> None:
    assembly = hf.assemble(cube())
    points, ways, half = [[-0.05, 0, 0.02], [-0.05, 0, 0.098]], [X, X], {"cube": (0.01, 0, 0.02)}
    found = worst_case(assembly, "cube", points, ways, mu=(0.5, 0.7), mass={"cube": (0.8, 1.1)}, com=half)
    least = 0.8 * G * min(0.5, 1)
    np.testing.assert_allclose(found.force, [least, min(least, 0.8 * G * 0.04 / 0.098)], rtol=1e-6)
    assert (found.force <= found.nominal).all()
    assert (found.lower <= found.force).all()
    assert (found.force <= found.upper).all()
    assert found.corners == 4, "shifts along gravity do not count"
    assert found.masses[1] == {"cube": 0.8}
    assert found.coms[1]["cube"][0] == pytest.approx(0.01)
    assert found.mu == {("floor", "cube"): 0.5}
    assert "exact" in found.guarantee


@pytest.mark.parametrize("seed", range(3))
def test_nothing_in_the_box_is_weaker_than_the_worst_case(seed: int) -> None:
    name, body, point, direction = PUSHES[5]
    assembly = hf.assemble(shipped_scene(name))
    half = {"slab": np.array([0.02, 0.01, 0.01]), "leg_left": np.array([0.004, 0.0, 0.02])}
    mass = {"slab": (1.8, 2.4), "leg_right": (0.8, 1.1)}
    found = worst_case(assembly, body, point, direction, mu=0.1, mass=mass, com=half)
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


def test_a_corner_that_does_not_stand_makes_the_worst_case_zero() -> None:
    found = worst_case(hf.assemble(cube()), "cube", [-0.05, 0, 0.02], X, com={"cube": (0.06, 0, 0)})
    assert found.force[0] == 0
    assert found.status[0] is hf.Status.UNSTABLE
    down = worst_case(hf.assemble(cube()), "cube", [0, 0, 0.1], [0, 0, -1], mu=0.3, mass=0.2)
    assert down.status[0] is hf.Status.INFINITE
    assert np.isinf(down.force[0])


def test_without_uncertainty_it_is_the_query() -> None:
    found = worst_case(hf.assemble(cube()), "cube", [-0.05, 0.045, 0.02], X)
    assert found.force[0] == pytest.approx(found.nominal[0], rel=1e-9)
    assert found.corners == 1


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"mu": {("cube", "table"): (0.1, 0.2)}}, "no contact between"),
        ({"mu": (0.5, 0.4)}, "needs 0 <= low <= high"),
        ({"mu": 1.0}, "relative width"),
        ({"mass": {"floor": (1, 2)}}, "'floor' is fixed"),
        ({"mass": {"cub": (1, 2)}}, "no body named"),
        ({"com": -0.1}, ">= 0"),
        ({"com": {"cube": (0.1, 0, -0.1)}}, "half widths >= 0"),
    ],
)
def test_a_bad_box_is_refused(asked: dict[str, Any], told: str) -> None:
    with pytest.raises(hf.HoldfastError, match=told):
        worst_case(hf.assemble(cube()), "cube", [-0.05, 0, 0.02], X, **asked)


def test_too_many_corners_are_refused_with_a_remedy() -> None:
    with pytest.raises(hf.HoldfastError, match=r"corners; at most 4,096: name the bodies that matter"):
        worst_case(hf.assemble(shipped_scene("arch")), "v3", [0, 0, 0.3], [0, 0, -1], mass=0.1, com=0.01)
