"""The hand-derived decoupled truth against an evaluator that knows no mechanism, and against numbers done by hand."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from decoupled_bruteforce import (
    CUBE,
    STACK,
    TABLE,
    BruteForce,
    Scene,
    hull_edges,
    minimum_energy,
    random_pushes,
    slip_at_points,
)
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
from holdfast import Scene as SceneOf
from holdfast import assemble
from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError
from holdfast.scene.shipped import shipped_scene

Truth = Callable[[Float, Float, Sequence[str]], Float]

PUSHES = 400  # a scene
MARGIN = 1e-3  # random pushes stay this far off edges and off the line where R jumps to infinity [m]
AGREEMENT = 1e-3  # relative
X, Y, Z = np.eye(3)

SCENES: dict[str, tuple[Scene, Truth]] = {
    "cube": (CUBE, lambda points, normals, body: truth_cube(points, normals)),
    "stack": (STACK, truth_stack),
    "table": (TABLE, truth_table),
}


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> tuple[str, BruteForce]:
    return request.param, BruteForce(SCENES[request.param][0])


def pushes_with_rare_regions(name: str) -> tuple[Float, Float, list[str]]:
    """Random pushes, and on the table more of them where a small region has a mechanism of its own."""
    rng = np.random.default_rng(2411)
    points, normals, body = random_pushes(SCENES[name][0], PUSHES, MARGIN, rng)
    bodies = list(body)
    if name == "table":
        corner = np.column_stack([rng.uniform(-0.199, -0.19, 20), np.full(20, 0.1), rng.uniform(0.185, 0.199, 20)])
        tip = np.column_stack([rng.uniform(0.202, 0.249, 20), rng.uniform(-0.099, 0.099, 20), np.full(20, 0.25)])
        points = np.vstack([points, corner, tip])
        normals = np.vstack([normals, np.tile(Y, (20, 1)), np.tile(Z, (20, 1))])
        bodies += ["leg_left"] * 20 + ["slab"] * 20
        clear = (np.abs(np.abs(points[:, 0]) - 0.2) > MARGIN) | (normals[:, 2] == 0)
        points, normals = points[clear], normals[clear]
        bodies = [b for b, keep in zip(bodies, clear, strict=True) if keep]
    return points, normals, bodies


def test_truth_agrees_with_brute_force(scene: tuple[str, BruteForce]) -> None:
    name, brute_force = scene
    points, normals, body = pushes_with_rare_regions(name)
    truth = SCENES[name][1](points, normals, body)
    brute = np.array([brute_force(b, p, -n) for b, p, n in zip(body, points, normals, strict=True)])
    np.testing.assert_array_equal(np.isfinite(truth), np.isfinite(brute))
    finite = np.isfinite(brute)
    assert 0 < finite.sum() < len(finite)
    np.testing.assert_allclose(truth[finite], brute[finite], rtol=AGREEMENT)


def test_minimum_energy_pressure_is_uniform(scene: tuple[str, BruteForce]) -> None:
    for face in scene[1].interfaces:
        uniform = np.tile(face.forces.mean(axis=0) * Z, (len(face.forces), 1))
        np.testing.assert_allclose(face.forces, uniform, atol=1e-9 * uniform[0, 2])


def test_interface_loads() -> None:
    loads = {(f.lower, f.upper): f.forces[:, 2].sum() for f in [*minimum_energy(STACK, 5), *minimum_energy(TABLE, 5)]}
    expected = {("floor", "cube1"): 29.43, ("cube1", "cube2"): 19.62, ("cube2", "cube3"): 9.81}
    expected |= {("floor", leg): 19.62 for leg in ("leg_left", "leg_right")}
    expected |= {(leg, "slab"): 9.81 for leg in ("leg_left", "leg_right")}
    assert loads == pytest.approx(expected)


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


def test_mirrored_pushes_on_the_table_agree() -> None:
    points, normals, body = random_pushes(TABLE, 200, MARGIN, np.random.default_rng(7))
    other = {"slab": "slab", "leg_left": "leg_right", "leg_right": "leg_left"}
    mirror = np.array([-1.0, 1.0, 1.0])
    mirrored = truth_table(points * mirror, normals * mirror, [other[b] for b in body])
    np.testing.assert_allclose(truth_table(points, normals, body), mirrored, rtol=1e-12)


def test_point_off_its_face_is_refused() -> None:
    with pytest.raises(SceneError, match="not on a face"):
        truth_cube((0.0, 0.0, 0.05), X)


def test_unknown_body_is_refused() -> None:
    with pytest.raises(SceneError, match="'lamp' is not in this scene"):
        truth_table([(0.0, 0.0, 0.25)], [Z], ["lamp"])


@pytest.mark.parametrize(
    ("e", "expected"),
    [
        (X, 0.6),  # along the surface: mu f_n
        (Z, np.inf),  # pressed
        (-Z, 1.0),  # pulled off
        ((X - Z) / np.sqrt(2), np.sqrt(2) * 0.6 / 1.6),  # s/sqrt2 = mu (1 - s/sqrt2)
        ((X + Z) / np.sqrt(2), np.sqrt(2) * 0.6 / 0.4),  # s/sqrt2 = mu (1 + s/sqrt2)
        ((X + 2 * Z) / np.sqrt(5), np.inf),  # inside the cone
    ],
)
def test_brute_force_slip_at_a_point(e: Float, expected: float) -> None:
    assert slip_at_points(Z[None, :], e, Z, 0.6)[0] == pytest.approx(expected)


def test_brute_force_hull_edges() -> None:
    box = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 2)], dtype=float)
    assert len(hull_edges(box)) == 12
    assert len(hull_edges(box[box[:, 2] == 0])) == 4
    legs = np.array([(x, y, 0) for x in (-2, -1.5, 1.5, 2) for y in (-1, 1)], dtype=float)
    assert len(hull_edges(legs)) == 4


def test_brute_force_finds_every_cut_of_the_table() -> None:
    cuts = {axis.moving for axis in BruteForce(TABLE, cells=4).axes}
    assert cuts == {
        frozenset(names)
        for names in (
            ["slab"],
            ["leg_left"],
            ["leg_right"],
            ["slab", "leg_left"],
            ["slab", "leg_right"],
            ["slab", "leg_left", "leg_right"],
        )
    }


def test_the_scene_is_recognised() -> None:
    for name, body in (("cube", "cube"), ("stack", "cube2"), ("table", "leg_left")):
        box = next(b for b in shipped_scene(name).bodies if b.name == body)
        low, high = box.box
        point = np.array([low[0], 0.5 * (low[1] + high[1]), 0.3 * low[2] + 0.7 * high[2]])
        by_name = robustness(name, body, point, X)
        assert np.isfinite(by_name).all()
        np.testing.assert_array_equal(robustness(assemble(shipped_scene(name)), body, point, X), by_name)


def test_other_scenes_are_refused() -> None:
    with pytest.raises(SceneError, match="needs the shipped scene"):
        robustness(assemble(shipped_scene("tall_table")), "slab", (0, 0, 0.65), -Z)
    cubes = shipped_scene("cube")
    with pytest.raises(SceneError, match="needs the shipped scene"):
        robustness(assemble(SceneOf(cubes.bodies, 0.5)), "cube", (0, 0, 0.1), -Z)
    with pytest.raises(SceneError, match="was not worked out"):
        robustness("arch", "keystone", (0, 0, 0.1), -Z)
    with pytest.raises(SceneError, match="not in this scene"):
        robustness("cube", "lamp", (0, 0, 0.1), -Z)
