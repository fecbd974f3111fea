"""Balls, capsules and ellipsoids on flat faces: contacts where the smooth surface touches, not where a vertex is."""

from __future__ import annotations

import numpy as np
import pytest
from placed import FLOOR, at
from scipy.spatial.transform import Rotation

import holdfast as hf


def touching(*bodies: hf.Body) -> dict[tuple[str, str], hf.answers.Interface]:
    return {i.bodies: i for i in hf.assemble(hf.Scene([FLOOR, *bodies], 0.5), gap=1e-4).interfaces}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("shape", [hf.Sphere(0.05), hf.Ellipsoid((0.05, 0.1, 0.03)), hf.Capsule(0.03, 0.2)])
def test_a_round_body_turned_at_random_touches_at_its_lowest_point(shape: object, seed: int) -> None:
    """The lowest point is found here by minimising over a fine sample and a step of Newton's method on the sphere."""
    turn = Rotation.random(random_state=seed).as_matrix()
    directions = turn.T @ [0, 0, -1.0]
    if isinstance(shape, hf.Capsule):
        local = shape.radius * directions + [0, 0, np.sign(directions[2]) * shape.length / 2]
    else:
        radii = np.full(3, shape.radius) if isinstance(shape, hf.Sphere) else shape.radii
        local = radii**2 * directions / np.linalg.norm(radii * directions)
    low = turn @ local
    body = hf.Body("it", shape, mass=1, pose=at(0.3, -0.2, -low[2], turn))
    (patch,) = touching(body)["floor", "it"].patches
    assert patch.kind == "point"
    assert np.allclose(patch.polygon[0], (0.3 + low[0], -0.2 + low[1], 0), atol=1e-9)
    assert np.allclose(patch.normal, (0, 0, 1))


def test_a_lying_capsule_touches_along_its_cylinder_and_only_on_the_face() -> None:
    turn = Rotation.from_euler("zy", (20, 90), degrees=True).as_matrix()
    (line,) = touching(hf.Body("rod", hf.Capsule(0.05, 0.2), mass=1, pose=at(0, 0, 0.05, turn)))["floor", "rod"].patches
    ends = line.polygon[np.argsort(line.polygon[:, 0])]
    assert np.allclose(ends, [(-0.1, 0, 0), (0.1, 0, 0)], atol=1e-9)
    box = hf.Body("box", hf.Box((0.2, 0.2, 0.1)), mass=1, pose=at(0, 0, 0.05))
    rod = hf.Body("rod", hf.Capsule(0.05, 0.5), mass=1, pose=at(0.02, 0, 0.15, turn))
    (line,) = touching(box, rod)["box", "rod"].patches
    assert np.allclose(np.sort(line.polygon[:, 0]), (-0.1, 0.1), atol=1e-9)
    assert np.allclose(line.polygon[:, 2], 0.1)


@pytest.mark.parametrize(("height", "touches"), [(5e-5, True), (-5e-5, True), (3e-4, False)])
def test_the_height_of_the_smooth_surface_decides_not_that_of_its_tessellation(height: float, touches: bool) -> None:
    """The tessellated ball of 0.05 m lies up to 0.2 mm inside the true one."""
    ball = hf.Body("ball", hf.Sphere(0.05), mass=1, pose=at(0, 0, 0.05 + height))
    found = touching(ball)
    assert (("floor", "ball") in found) is touches
    if touches:
        (patch,) = found["floor", "ball"].patches
        assert patch.separation == pytest.approx((height, height), abs=1e-12)
        assert patch.polygon[0, 2] == pytest.approx(height / 2, abs=1e-12)


def test_a_ball_in_a_corner_touches_three_faces_from_either_side() -> None:
    for mirror in (1, -1):
        walls = [
            hf.Body("x", hf.Box((0.1, 1, 1)), fixed=True, pose=at(-0.1 * mirror, 0, 0.5)),
            hf.Body("y", hf.Box((1, 0.1, 1)), fixed=True, pose=at(0, -0.1 * mirror, 0.5)),
        ]
        ball = hf.Body("ball", hf.Sphere(0.05), mass=1, pose=at(0, 0, 0.05))
        for bodies in ((*walls, ball), (ball, *walls)):
            found = touching(*bodies)
            points = {frozenset(pair) - {"ball"}: i.patches for pair, i in found.items()}
            assert all(len(patches) == 1 for patches in points.values())
            places = {tuple(np.round(p[0].polygon[0], 9).tolist()) for p in points.values()}
            assert places == {(0.0, 0.0, 0.0), (-0.05 * mirror, 0.0, 0.05), (0.0, -0.05 * mirror, 0.05)}
            for pair, interface in found.items():
                toward = interface.patches[0].normal @ (np.array([0, 0, 0.05]) - interface.patches[0].polygon[0])
                assert (toward > 0) == (pair[1] == "ball")


def test_a_plank_on_two_capsules_tips_about_the_line_where_it_lies() -> None:
    """Pressed down at its ends: R = m g times the lever of the weight over that of the push, about one line each."""
    turn = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    places = {"near": -0.1, "far": 0.3}
    rods = [hf.Body(n, hf.Capsule(0.02, 0.3), fixed=True, pose=at(x, 0, 0.02, turn)) for n, x in places.items()]
    plank = hf.Body("plank", hf.Box((1.0, 0.2, 0.02)), mass=2, pose=at(0, 0, 0.05))
    assembly = hf.assemble(hf.Scene([FLOOR, *rods, plank], 0.5), gap=1e-4)
    found = hf.robustness(assembly, "plank", [(0.5, 0, 0.06), (-0.5, 0, 0.06)], (0, 0, -1), engine="limit")
    assert found.force == pytest.approx([2 * 9.81 * 0.3 / 0.2, 2 * 9.81 * 0.1 / 0.4], rel=1e-6)
