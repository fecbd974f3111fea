"""The hand-derived decoupled truth against numbers done by hand; engine ``graph`` agrees with it on random pushes."""

import numpy as np
import pytest
from scipy.integrate import quad

from bench.truth.decoupled import (
    CUBE_LEVER,
    LEG_LEVER,
    SLAB_LEVER,
    distance_integral,
    robustness,
    truth_cube,
    truth_stack,
    truth_table,
)
from holdfast import assemble
from holdfast.base.arrays import Float
from holdfast.scene.shipped import shipped_scene

X, Y, Z = np.eye(3)


@pytest.mark.parametrize(
    ("lever", "box"),
    [
        (CUBE_LEVER, (-0.05, 0.05, -0.05, 0.05)),
        (LEG_LEVER, (0.0, 0.05, 0.0, 0.2)),
        (SLAB_LEVER, (0.15, 0.2, -0.1, 0.1)),
    ],
)
def test_levers_of_friction_are_mean_distances(lever: float, box: tuple[float, float, float, float]) -> None:
    x0, x1, y0, y1 = box

    def column(x: float) -> float:
        return float(quad(lambda y: np.hypot(x, y), y0, y1, points=[0.0], epsabs=1e-12, epsrel=1e-10)[0])

    area = (x1 - x0) * (y1 - y0)
    assert lever == pytest.approx(quad(column, x0, x1, points=[0.0], epsabs=1e-12, epsrel=1e-10)[0] / area, rel=1e-8)


def test_distance_integral_of_the_unit_square() -> None:
    assert distance_integral(1.0, 1.0) == pytest.approx((np.sqrt(2) + np.log(1 + np.sqrt(2))) / 3, rel=1e-14)


@pytest.mark.parametrize(
    ("point", "normal", "force"),
    [
        ((-0.05, 0.0, 0.02), -X, 5.886),  # slip: mu m g
        ((-0.05, 0.0, 0.1), -X, 4.905),  # tip: m g L / (2 z)
        ((-0.05, 0.045, 0.02), -X, 5.0043800),  # torsion: mu m g lever / 0.045
        ((0.01, 0.02, 0.1), Z, np.inf),
        ((0.05, 0.0, 0.0), -Z, 4.905),  # lifted at the middle of an edge
    ],
)
def test_cube_by_hand(point: tuple[float, float, float], normal: Float, force: float) -> None:
    assert truth_cube(point, normal)[0] == pytest.approx(force, rel=1e-7)


@pytest.mark.parametrize(
    ("body", "point", "normal", "force"),
    [
        ("cube3", (-0.05, 0.0, 0.22), -X, 5.886),  # slip of the top cube
        ("cube3", (-0.05, 0.0, 0.3), -X, 4.905),  # any cut tips at 4.905 N here
        ("cube3", (-0.05, 0.0, 0.28), -X, 1.4715 / 0.28),  # the whole pile tips
        ("cube2", (-0.05, 0.0, 0.11), -X, 11.772),  # slip of the upper two
        ("cube1", (-0.05, 0.0, 0.01), -X, 17.658),  # slip of all three
        ("cube1", (-0.05, 0.045, 0.01), -X, 3 * 5.0043800),  # torsion of all three
    ],
)
def test_stack_by_hand(body: str, point: tuple[float, float, float], normal: Float, force: float) -> None:
    assert truth_stack([point], [normal], [body])[0] == pytest.approx(force, rel=1e-7)


@pytest.mark.parametrize(
    ("body", "point", "normal", "force"),
    [
        ("slab", (-0.24, 0.0, 0.25), Z, 98.1),  # pressed on the overhang
        ("slab", (-0.19, 0.0, 0.25), Z, np.inf),
        ("slab", (-0.25, 0.0, 0.225), -X, 9.81),  # slip off both legs
        ("slab", (0.0, -0.1, 0.225), -Y, 9.81),
        ("slab", (0.2, -0.1, 0.225), -Y, 9.0327981),  # torsion: 9.81 * 0.1841549 / 0.2
        ("slab", (0.0, 0.0, 0.2), -Z, 19.62),  # lifted off
        ("slab", (-0.225, 0.05, 0.2), -Z, 19.62 * 0.2 / 0.425),  # tilted about the right end
        ("slab", (-0.05, 0.09, 0.2), -Z, 19.62 * 0.1 / 0.19),  # tilted about a long side
        ("leg_left", (-0.2, 0.0, 0.1), -X, 14.715),  # slip under the leg and at the weaker of two slab joints
        ("leg_left", (-0.2, 0.1, 0.1), -X, 7.8046844),  # torsion about the leg's far upright edge
        ("leg_right", (0.175, -0.1, 0.1), -Y, 14.715),
        ("leg_left", (-0.2, -0.1, 0.2), -Y, 1.03005 / 0.08),  # roll about the slanted line to the far leg
        ("leg_left", (-0.175, 0.0, 0.2), Z, np.inf),
    ],
)
def test_table_by_hand(body: str, point: tuple[float, float, float], normal: Float, force: float) -> None:
    assert truth_table([point], [normal], [body])[0] == pytest.approx(force, rel=1e-7)


def test_the_scene_is_recognised() -> None:
    for name, body in (("cube", "cube"), ("stack", "cube2"), ("table", "leg_left")):
        box = next(b for b in shipped_scene(name).bodies if b.name == body)
        low, high = box.box
        point = np.array([low[0], 0.5 * (low[1] + high[1]), 0.3 * low[2] + 0.7 * high[2]])
        by_name = robustness(name, body, point, X)
        assert np.isfinite(by_name).all()
        np.testing.assert_array_equal(robustness(assemble(shipped_scene(name)), body, point, X), by_name)
