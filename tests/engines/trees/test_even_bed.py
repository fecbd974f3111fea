"""An even bed: pressures and limits of friction known in closed form, and any of them beside sums over cells."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize

from holdfast.engines.trees.forest import Bed
from holdfast.native import core

MU = 0.4


def bed(*rings: np.ndarray, mu: float | tuple[float, ...] = MU) -> Bed:
    """The bed of rings (n, 2), outlines counter-clockwise and holes clockwise, with a coefficient for each or all."""
    each = mu if isinstance(mu, tuple) else (mu,) * len(rings)
    edges = [np.column_stack([r, np.roll(r, -1, axis=0), np.full(len(r), m)]) for r, m in zip(rings, each, strict=True)]
    every = np.vstack(rings)
    size = np.array([np.linalg.norm(every, axis=1).max(), 0.0 if isinstance(mu, tuple) else mu])
    return Bed(np.ascontiguousarray(np.vstack(edges)), np.zeros((0, 3)), size)


def rectangle(a: float, b: float, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    return np.array([[x, y], [x, y], [x, y], [x, y]]) + np.array([[-a, -b], [a, -b], [a, b], [-a, b]]) / 2


def circle(radius: float, corners: int = 720) -> np.ndarray:
    angles = np.arange(corners) * 2 * np.pi / corners
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def pressure(faces: Bed, normal: float, x: float, y: float) -> np.ndarray:
    """The three numbers of the pressure with the resultant ``normal`` at (x, y)."""
    found = core.find_pressure(faces, normal * np.array([1, x, y]))
    assert found is not None
    return found


def share(faces: Bed, carried: tuple[float, ...]) -> float:
    """The share of friction that N, x, y of its centre, and a force and a torque about the origin use."""
    normal, x, y, *tangential = carried
    found = core.share_used(faces, np.array([normal, normal * x, normal * y, *tangential], dtype=np.float64))
    assert found is not None
    assert found[1] < 1e-8
    return found[0]


@pytest.mark.parametrize("e", [0.0, 0.005, -0.015])
def test_in_the_kern_pressure_is_linear(e: float) -> None:
    """Navier: p = N/A (1 ± 6 e/b) at the edges across which the centre is off by e."""
    a, b, n = 0.1, 0.06, 7.0
    p = pressure(bed(rectangle(a, b)), n, e, 0.0)
    assert_allclose([p @ [1, a / 2, 0], p @ [1, -a / 2, 0]], n / (a * b) * np.array([1 + 6 * e / a, 1 - 6 * e / a]))
    assert p[2] == pytest.approx(0, abs=1e-9 * n / (a * b * b))


@pytest.mark.parametrize("e", [0.02, 0.035, 0.049])
def test_beyond_the_kern_a_triangle_presses(e: float) -> None:
    """It is 3 (a/2 - e) long, and at its edge presses 2 N over its area."""
    a, b, n = 0.1, 0.06, 7.0
    p = pressure(bed(rectangle(a, b)), n, 0.0 + e, 0.0)
    long = 3 * (a / 2 - e)
    assert_allclose([p @ [1, a / 2, 0], p @ [1, a / 2 - long, 0]], [2 * n / (long * b), 0], atol=1e-6 * n / (a * b))


def test_at_the_kern_of_a_ring_one_point_lifts() -> None:
    """The kern of a ring of radii R and r reaches (R² + r²) / (4 R)."""
    outer, inner = 0.05, 0.04
    e = (outer**2 + inner**2) / (4 * outer)
    p = pressure(bed(circle(outer), circle(inner)[::-1]), 1.0, e, 0.0)
    assert abs(p @ [1, -outer, 0]) < 1e-4 * (p @ [1, outer, 0])


def test_two_feet_share_as_levers_do() -> None:
    """Narrow feet at ± l carry N (1 ± e/l) / 2."""
    foot, off, e = 1e-4, 0.1, 0.03
    p = pressure(bed(rectangle(foot, foot, off, 0), rectangle(foot, foot, -off, 0)), 1.0, e, 0.0)
    assert_allclose([p @ [1, off, 0], p @ [1, -off, 0]], np.array([1 + e / off, 1 - e / off]) / 2 / foot**2, rtol=1e-4)


def test_a_force_at_the_centre_of_pressure_meets_mu_n() -> None:
    """Sliding all together uses all friction at once, wherever the centre is and whatever has lifted."""
    for x, y in ((0, 0), (0.03, 0.01), (0.045, -0.02)):
        f = np.array([0.6, -0.8])
        assert share(bed(rectangle(0.1, 0.06)), (5.0, x, y, *f, x * f[1] - y * f[0])) == pytest.approx(1 / (MU * 5))


def test_torsion_of_known_shapes() -> None:
    """Disc 2/3 μ N R, ring of next to no width μ N R, rod μ N L/4, square μ N a (√2 + asinh 1) / 6."""
    known = [
        (bed(circle(0.05)), 2 / 3 * 0.05),
        (bed(circle(0.05), circle(0.04999)[::-1]), 0.05),
        (bed(rectangle(0.2, 1e-5)), 0.05),
        (bed(rectangle(0.1, 0.1)), 0.1 * (np.sqrt(2) + np.arcsinh(1)) / 6),
    ]
    for faces, arm in known:
        assert share(faces, (3.0, 0, 0, 0, 0, 1.0)) == pytest.approx(1 / (MU * 3 * arm), rel=3e-4)


def test_two_feet_with_a_force_and_a_torque() -> None:
    """Each foot carries half of the force, and the torque over their distance across: the norm is μ N/2."""
    off, f, t = 0.1, 0.3, 0.02
    feet = bed(rectangle(1e-4, 1e-4, off, 0), rectangle(1e-4, 1e-4, -off, 0))
    along = share(feet, (2.0, 0, 0, f, 0, t))  # each carries f/2 along and t/(2 off) across
    assert along == pytest.approx(np.hypot(f / 2, t / (2 * off)) / (MU * 1.0), rel=1e-3)


def test_faces_have_friction_of_their_own() -> None:
    """Two feet press alike, one of them without friction: the other carries a force that acts on it alone."""
    feet = bed(rectangle(1e-4, 1e-4, 0.1, 0), rectangle(1e-4, 1e-4, -0.1, 0), mu=(0.5, 1e-9))
    force = 0.2
    assert share(feet, (2.0, 0, 0, 0, force, 0.1 * force)) == pytest.approx(force / 0.5, rel=1e-3)


def test_what_is_used_between_two_loads_is_bounded() -> None:
    """On a disc of radius r, torsion meets 2/3 μ N r, of which the bound knows μ N r sqrt(3/8); force adds up."""
    r, n = 0.05, 10.0
    disc, squares = bed(circle(r)), n**2 / (np.pi * r**2)
    twisted, pulled = np.array([n, 0, 0, 0, 0, 0.1]), np.array([n, 0, 0, 3.0, 0, 0.1])
    bound = 0.1 / (MU * n * r * np.sqrt(3 / 8))
    assert core.most_between(disc, twisted, twisted, 0.0, 0.0, squares) == pytest.approx(bound)
    assert share(disc, (n, 0, 0, 0, 0, 0.1)) == pytest.approx(0.1 / (MU * n * r * 2 / 3), rel=1e-4)
    assert core.most_between(disc, twisted, pulled, 0.0, 1.0, squares) == pytest.approx(bound + 3 / (MU * n))
    there, back = np.array([n, 0, n * 0.01, 2, 0, -0.02]), np.array([n, 0, -n * 0.01, -2, 0, -0.02])
    for end in (there, back):  # nothing turns it at the ends, but 0.02 N m half way
        assert end[5] + end[2] * end[3] / n == pytest.approx(0)
    middle = core.most_between(disc, there, back, 0.0, 1.0, squares)
    assert middle == pytest.approx(0.02 / (MU * n * r * np.sqrt(3 / 8)) + 2 / (MU * n))


@pytest.mark.parametrize("seed", range(4))
def test_what_is_used_between_is_below_the_bound(seed: int) -> None:
    """Of rectangles of any shape whose resultant goes from one place to another, pressed in part or not."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0.02, 0.4, 2)
    faces = bed(rectangle(a, b))
    ends = np.array([[1, *(rng.uniform(-0.45, 0.45, 2) * (a, b)), *rng.normal(size=2) * 0.1, 0.02 * a] for _ in "ab"])
    squares = max(float(pressure(faces, *end[:3]) @ end[:3]) for end in ends)
    bound = core.most_between(faces, ends[0], ends[1], 0.0, 1.0, squares)
    for at in np.linspace(0, 1, 9):
        carried = (1 - at) * ends[0] + at * ends[1]
        assert share(faces, tuple(carried)) < bound


def test_friction_that_runs_out_and_comes_back_is_not_passed_over() -> None:
    """A rectangle whose friction runs out on the way to tipping, though there is enough at rest and near the edge."""
    a, b, mu, tips, middle = 0.56, 0.54, 0.47, 0.5651, 0.4492
    faces = bed(rectangle(a, b), mu=mu)
    hull = np.array([[a / 2, 1, 0], [a / 2, -1, 0], [b / 2, 0, 1], [b / 2, 0, -1]])
    faces = Bed(faces.edges, hull, faces.size)
    rest = np.array([1.0, 0.031, -0.071, -0.172, -0.259, 0.001])
    load = np.array([1.53, 0.62, -0.51, 0.39, 0.42, 0.13])
    used = []
    for at in (0.0, middle, tips - (tips - 0.1) / 16, tips - (tips - 0.1) / 256):
        n, nx, ny, *tangential = (1 - at) * rest + at * load
        used.append(share(faces, (n, nx / n, ny / n, *tangential)))
    assert used[1] > 1.1
    assert max(used[0], *used[2:]) < 0.95
    out, _ = core.first_exits(faces, rest, load[None], np.ones(1))
    assert 0 < out[0, 1] <= out[0, 0] < middle


def cells(rings: tuple[np.ndarray, ...], across: int = 400) -> tuple[np.ndarray, np.ndarray, float]:
    """Middles (2, n) of cells inside an odd number of the rings, and their area."""
    every = np.vstack(rings)
    low, high = every.min(0), every.max(0)
    step = (high - low).max() / across
    x, y = np.meshgrid(np.arange(low[0] + step / 2, high[0], step), np.arange(low[1] + step / 2, high[1], step))
    x, y = x.ravel(), y.ravel()
    inside = np.zeros(len(x), dtype=bool)
    for ring in rings:
        for (ax, ay), (bx, by) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            with np.errstate(divide="ignore", invalid="ignore"):
                inside ^= ((ay > y) != (by > y)) & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return x[inside], y[inside], step**2


@pytest.mark.parametrize("seed", range(12))
def test_any_of_them_beside_sums_over_cells(seed: int) -> None:
    """Pressure and friction of other shapes, in part lifted, beside a general minimizer of sums over 160,000 cells."""
    rng = np.random.default_rng(seed)
    shapes = [
        (rectangle(0.12, 0.05),),
        (circle(0.07, 24), 0.6 * circle(0.07, 24)[::-1]),
        tuple(rectangle(0.03, 0.02, 0.05 * i, 0.04 * j) for i in (-1, 1) for j in (-1, 1)),
        (np.array([[-0.08, -0.1], [0.12, -0.1], [0.12, -0.05], [-0.03, -0.05], [-0.03, 0.2], [-0.08, 0.2]]),),
    ]
    rings = shapes[seed % 4]
    every = np.vstack(rings)
    x, y = 0.5 * rng.dirichlet(np.ones(len(every))) @ every + 0.25 * every[rng.integers(len(every))]
    tangential = rng.normal(size=3) * [1, 1, 0.05]
    p = pressure(bed(*rings), 1.0, x, y)
    X, Y, area = cells(rings)
    pressed = np.maximum(p @ np.array([np.ones_like(X), X, Y]), 0) * area
    reach = np.abs(every).max()
    assert_allclose([pressed.sum(), pressed @ X / reach, pressed @ Y / reach], [1, x / reach, y / reach], atol=0.01)
    pressed /= pressed.sum()
    t = tangential / [1, 1, reach]
    across = np.linalg.svd(t[None])[2][1:]

    def power(z: np.ndarray) -> float:
        m = (t / (t @ t) + z @ across) / [1, 1, reach]
        return float(MU * (pressed * np.hypot(m[0] - m[2] * Y, m[1] + m[2] * X)).sum())

    least = min(minimize(power, start, method="BFGS").fun for start in ([0, 0], [3, -3]))
    assert share(bed(*rings), (1.0, x, y, *tangential)) == pytest.approx(1 / least, rel=4e-3)
