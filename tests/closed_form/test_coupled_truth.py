"""The coupled truth against closed forms and figures found elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from engine_scenes import G0, X, Y, Z, block, floor

import holdfast as hf
from bench.truth import coupled
from bench.truth.decoupled import CUBE_LEVER
from bench.truth.rectangle import friction, linear_pressure, moments, sustained
from holdfast.scene.shipped import shipped_scene

HALF = np.array([0.7, 0.4])  # [m] of a rectangle for pressure and friction


@pytest.fixture(scope="module")
def cube() -> hf.answers.Assembly:
    return hf.assemble(shipped_scene("cube"))


@pytest.fixture(scope="module")
def stack() -> hf.answers.Assembly:
    return hf.assemble(shipped_scene("stack"))


def truth(assembly: hf.answers.Assembly, body: str, point: object, direction: object) -> float:
    return float(coupled.robustness(assembly, body, point, direction)[0])


def random_pushes(assembly: hf.answers.Assembly, body: str, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points on a box and unit directions into it, a third of them straight, the others aslant."""
    rng = np.random.default_rng(seed)
    half = assembly.scene.body(body).shape.size / 2
    axis, sign = rng.integers(0, 3, count), rng.choice([-1.0, 1.0], count)
    normals = sign[:, None] * np.eye(3)[axis]
    points = np.where(normals != 0, normals * half, rng.uniform(-1, 1, (count, 3)) * half)
    aslant = rng.normal(size=(count, 3)) * (np.arange(count) % 3 > 0)[:, None]
    directions = aslant - normals * (np.abs((aslant * normals).sum(1)) + (aslant * normals).sum(1) + 0.1)[:, None]
    return points + assembly.scene.body(body).com_world, directions / np.linalg.norm(directions, axis=1)[:, None]


# pressure


def test_pressure_in_the_kern_is_linear_over_the_whole_rectangle() -> None:
    x, y = 0.15 * HALF
    z, part, count, at = linear_pressure(HALF, x, y)
    assert count == 4
    np.testing.assert_allclose(at, (x, y))
    corner = part[:4] + at
    expected = (1 + 3 * x * corner[:, 0] / HALF[0] ** 2 + 3 * y * corner[:, 1] / HALF[1] ** 2) / (4 * HALF.prod())
    np.testing.assert_allclose(z[0] + part[:4] @ z[1:], expected, rtol=1e-10)


def test_pressure_beyond_the_kern_is_a_wedge_of_three_times_the_distance() -> None:
    d = 0.2  # from the side x = 0.7
    z, part, count, _ = linear_pressure(HALF, HALF[0] - d, 0.0)
    assert np.ptp(part[:count, 0]) == pytest.approx(3 * d)
    assert (z[0] + part[:count] @ z[1:]).max() == pytest.approx(2 / (3 * d * 2 * HALF[1]))


def test_pressure_in_a_corner_is_a_pyramid_of_four_times_the_distance() -> None:
    d = np.array([0.1, 0.15])
    z, part, count, _ = linear_pressure(HALF, HALF[0] - d[0], -HALF[1] + d[1])
    assert count == 3
    np.testing.assert_allclose(np.ptp(part[:3], axis=0), 4 * d)
    assert (z[0] + part[:3] @ z[1:]).max() == pytest.approx(1 / (4 * d[0] * 4 * d[1] / 6))


def test_pressure_balances_wherever_its_resultant_lies() -> None:
    rng = np.random.default_rng(0)
    kinds = set()
    for _ in range(300):
        x, y = rng.choice([-1, 1], 2) * (1 - 10 ** rng.uniform(-3.9, 0, 2)) * HALF
        z, part, count, at = linear_pressure(HALF, x, y)
        np.testing.assert_allclose(at, (x, y), atol=1e-14)
        np.testing.assert_allclose(moments(part, count) @ z, (1, 0, 0), atol=1e-9)
        assert (z[0] + part[:count] @ z[1:]).min() > -1e-9 * abs(z[0])
        kinds.add(count)
    assert kinds == {3, 4, 5}


# friction


def test_friction_is_that_of_a_dense_grid() -> None:
    z, part, count, at = linear_pressure(HALF, 0.35, 0.18)
    u = (np.arange(1000) + 0.5) / 500 - 1
    x, y = np.meshgrid(u * HALF[0] - at[0], u * HALF[1] - at[1])
    p = np.maximum(z[0] + z[1] * x + z[2] * y, 0) * HALF.prod() / 500**2
    reach = np.linalg.norm(part[:count], axis=1).max()
    for motion in (
        [0, 0, 1],
        [0.1, 0.2, 1],
        [0.3, -0.5, -1],
        [1, 0.5, 0.35],
        [1, 0.5, 0.3],
        [-1, 0.5, 1e-3],
        [0, 1, 0],
    ):
        v = np.array(motion, dtype=float)
        sx, sy = v[0] - v[2] * y, v[1] + v[2] * x
        speed = np.hypot(sx, sy)
        expected = [(p * sx / speed).sum(), (p * sy / speed).sum(), (p * (x * sy - y * sx) / speed).sum()]
        np.testing.assert_allclose(friction(z, part, count, reach, v), expected, atol=3e-6)


def test_pure_slip_and_pure_torsion() -> None:
    half = np.full(2, 0.05)
    z, part, count, _ = linear_pressure(half, 0.0, 0.0)
    assert sustained(z, part, count, np.array([0.6, 0.8, 0.0])) == pytest.approx(1)
    assert sustained(z, part, count, np.array([0.0, 0.0, -1.0])) == pytest.approx(CUBE_LEVER)


# pushes


@pytest.mark.parametrize("height", [0.0, 0.04, 0.08, 0.09, 0.1])
def test_centred_push_on_a_cube(cube: hf.answers.Assembly, height: float) -> None:
    expected = min(0.6 * G0, G0 * 0.1 / (2 * height)) if height else 0.6 * G0
    for e in (X, -X, Y, -Y):
        assert truth(cube, "cube", -0.05 * e + height * Z, e) == pytest.approx(expected, rel=1e-6)


def test_published_figure(cube: hf.answers.Assembly) -> None:
    """3.544 N: full limit surface under linear pressure, found elsewhere with three decimals of its own."""
    assert truth(cube, "cube", (-0.05, 0.045, 0.02), X) == pytest.approx(3.544, rel=1e-3)


@pytest.mark.parametrize(
    ("across", "force"), [(0.01, 5.583), (0.02, 4.973), (0.03, 4.356), (0.03826, 3.911), (0.045, 3.594), (0.05, 3.382)]
)
def test_uniform_pressure_about_all_centres(cube: hf.answers.Assembly, across: float, force: float) -> None:
    """Pushed at the floor the pressure stays uniform: the figures of bench/notes/table1.md."""
    assert truth(cube, "cube", (-0.05, across, 0.0), X) == pytest.approx(force, abs=6e-4)


def test_lifting_and_pressing(cube: hf.answers.Assembly) -> None:
    assert truth(cube, "cube", (0, 0, 0.1), Z) == pytest.approx(G0)
    assert truth(cube, "cube", (0.03, 0.01, 0.1), Z) == pytest.approx(G0 * 0.05 / 0.08)
    for x, y in ((0, 0), (0.049, 0.01), (0.05, -0.05)):  # to the very corner
        assert truth(cube, "cube", (x, y, 0.1), -Z) == np.inf


def test_inside_the_cone_nothing_moves(cube: hf.answers.Assembly) -> None:
    """A push that meets the floor below itself within the friction cone is held at any size; outside it is not."""
    for slope, infinite in ((0.599, True), (0.601, False)):
        e = slope * X - Z
        force = truth(cube, "cube", 0.1 * Z - 0.1 * slope * X, e)  # its line meets the floor in the middle
        assert np.isinf(force) == infinite
        if not infinite:  # s e_x = mu (W + s |e_z|)
            assert force == pytest.approx(0.6 * G0 / (slope - 0.6) * np.linalg.norm(e), rel=1e-6)


def test_cubes_above_only_weigh(cube: hf.answers.Assembly, stack: hf.answers.Assembly) -> None:
    points, directions = random_pushes(cube, "cube", 15, seed=1)
    alone = coupled.robustness(cube, "cube", points, directions)
    np.testing.assert_allclose(coupled.robustness(stack, "cube1", points, directions), 3 * alone, rtol=1e-6)


def test_every_joint_below_a_push_can_give_way(stack: hf.answers.Assembly) -> None:
    assert truth(stack, "cube3", (-0.05, 0, 0.21), X) == pytest.approx(0.6 * G0)  # cube3 slips on cube2
    assert truth(stack, "cube3", (-0.05, 0, 0.28), X) == pytest.approx(1.5 * G0 * 0.1 / 0.28)  # the pile tips


def test_slope() -> None:
    tilt = np.arctan(0.5)
    down = np.array([np.sin(tilt), 0, -np.cos(tilt)])
    bodies = [floor(), block("cube", (0.1, 0.1, 0.1), (0, 0, 0.05))]
    for mu in (0.4, 0.6):
        assembly = hf.assemble(hf.Scene(bodies, mu, gravity=tuple(G0 * down)))
        expected = max(0, mu * G0 * np.cos(tilt) - G0 * np.sin(tilt))  # 0: it does not stand
        assert truth(assembly, "cube", (-0.05, 0, 0), X) == pytest.approx(expected, rel=1e-6)
    uphill = truth(assembly, "cube", (0.05, 0, 0), -X)
    assert uphill == pytest.approx(0.6 * G0 * np.cos(tilt) + G0 * np.sin(tilt), rel=1e-6)


def test_shifted_bricks_of_different_size() -> None:
    """The resultant of the weight off the middle of a smaller rectangle: tipping by hand about its edge."""
    bodies = [
        floor(),
        block("low", (0.3, 0.1, 0.1), (0, 0, 0.05), 2),
        block("high", (0.3, 0.1, 0.1), (0.1, 0, 0.15), 2),
    ]
    assembly = hf.assemble(hf.Scene(bodies, 0.9))
    force = truth(assembly, "high", (0.25, 0, 0.2), -Z)  # about x = 0.15, the end of the lower brick
    assert force == pytest.approx(2 * G0 * 0.05 / 0.1)
