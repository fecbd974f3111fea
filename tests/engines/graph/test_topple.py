"""Toppling axes, torques and robustness (eq. 23-27, Algorithm 1)."""

import numpy as np
import pytest
from engine_scenes import X, Y, Z, block, cube_scene, floor
from graph_scenes import apply, push, random_motion, square

from holdfast import Body, Friction, Graph, Mesh, Scene, assemble
from holdfast.engines.graph.engine import GraphState
from holdfast.engines.graph.topple import all_parallel, friction_axis, toppling_axes
from holdfast.native import core
from holdfast.scene.shipped import shipped_scene


def test_cube_pushed_along_the_diagonal_turns_about_an_edge_not_a_corner() -> None:
    """About the edge at x = 0.05 only the push's x component counts."""
    got = push(assemble(cube_scene(mu=2)), "cube", (-0.05, -0.05, 0.1), (1, 1, 0))
    assert got == pytest.approx(9.81 * 0.05 / (0.1 / np.sqrt(2)))


def test_overhanging_plate_turns_about_either_side_of_its_support() -> None:
    """A 1 kg plate of 0.3 m, its centre at x = 0.03, on a column from x = -0.05 to 0.05."""
    column = block("column", (0.1, 0.1, 0.1), (0, 0, 0.05), fixed=True)
    assembly = assemble(Scene([column, block("plate", (0.3, 0.1, 0.02), (0.03, 0, 0.11))], 0.6))
    assert push(assembly, "plate", (0.17, 0, 0.12), -Z) == pytest.approx(9.81 * 0.02 / 0.12)
    assert push(assembly, "plate", (-0.11, 0, 0.12), -Z) == pytest.approx(9.81 * 0.08 / 0.06)
    assert push(assembly, "plate", (0.17, 0, 0.12), Z) == pytest.approx(9.81 * 0.08 / 0.22)  # lifts about x = -0.05
    assert push(assembly, "plate", (-0.11, 0, 0.12), Z) == pytest.approx(9.81 * 0.02 / 0.16)
    assert push(assembly, "plate", (0.04, 0, 0.12), -Z) == np.inf


def test_a_wall_blocks_turning_towards_it() -> None:
    wall = block("wall", (0.1, 0.4, 0.4), (0.1, 0, 0.2), fixed=True)
    smooth = Friction(default=0.6, pairs={("cube", "wall"): 0.0})
    assembly = assemble(Scene([floor(), wall, *cube_scene().movable], smooth))
    assert push(assembly, "cube", (-0.05, 0, 0.09), X) == np.inf
    assert push(assembly, "cube", (0, 0.05, 0.1), -Y) == pytest.approx(4.905)
    assert push(assembly, "cube", (0.05, 0, 0.1), -X) == pytest.approx(4.905)


def torque_about(origin: np.ndarray, axis: np.ndarray, points: np.ndarray, **change: object) -> tuple[float, float]:
    """Torques of both senses for contacts with 10 N each on a floor under a moving body b, mu 0.5."""
    n = len(points)
    given = {
        "flat": np.array([False]),
        "frames": np.tile(np.array([Z, X, Y]), (n, 1, 1)),
        "forces": np.tile([10.0, 0, 0], (n, 1)),
        "mu": np.full(n, 0.5),
        "moving_is_a": np.zeros(n, dtype=bool),
        **change,
    }
    order = ("flat", "points", "frames", "forces", "mu", "moving_is_a")
    arrays = [{**given, "points": points}[key] for key in order]
    torque = core.axis_torques(origin[None], axis[None], *arrays, 0.1)
    return float(torque[0]), float(torque[1])


def test_a_node_on_the_axis_contributes_nothing() -> None:
    points = square()
    # turning by +a about +y moves the points at x < 0.05 up; the two at x = 0.05 stay
    assert torque_about(points[1], Y, points) == pytest.approx((2 * 10 * 0.1, np.inf))
    assert torque_about(points[1], Y, points[1:3]) == (0, 0)
    centre = np.vstack([square(), [[0, 0, 0]]])
    lever = 0.05 * np.sqrt(2)
    assert torque_about(np.zeros(3), Z, centre) == pytest.approx((4 * 5 * lever, 4 * 5 * lever))
    unbounded = np.array([[1e9, 0, 0]])
    assert torque_about(np.zeros(3), Z, np.zeros((1, 3)), forces=unbounded, mu=np.array([np.inf])) == (0, 0)


def test_friction_in_use_counts_with_its_sign_about_an_axis_across_the_contacts() -> None:
    """1 N of the 5 N at (0.1, 0) already pushes the moving body along +y."""
    node = np.array([[0.1, 0, 0]])
    forces = np.array([[10.0, 0, 1.0]])
    positive, negative = torque_about(np.zeros(3), Z, node, forces=forces)
    assert (positive, negative) == pytest.approx((0.6, 0.4))  # a turn by +z moves the node to +y, against friction


def test_the_moving_side_may_be_either_body() -> None:
    """The same contacts with bodies a and b exchanged: frames reverse, components stay."""
    points, forces = square(), np.random.default_rng(1).uniform(0.5, 3, (4, 3)) + np.array([10.0, 0, 0])
    for axis in (Y, X, Z, np.array([0.6, 0.8, 0])):
        b_moves = torque_about(points[0], axis, points, forces=forces)
        frames = np.tile(-np.array([Z, X, Y]), (4, 1, 1))
        a_moves = torque_about(points[0], axis, points, forces=forces, frames=frames, moving_is_a=np.ones(4, bool))
        assert a_moves == pytest.approx(b_moves)


def test_slanted_axes_between_a_foot_and_the_top_of_the_other_leg() -> None:
    """Cut {slab, left leg}: contacts at z = 0 on the left, at z = 0.2 on the right, one slanted hull."""
    left, right = square() * (0.5, 2, 1) - 0.175 * X, square(0.2) * (0.5, 2, 1) + 0.175 * X
    origins, axes = toppling_axes(np.vstack([left, right]), 0.5)
    slanted = (np.abs(axes[:, 2]) > 0.1) & (np.abs(axes[:, 0]) > 0.1)
    slopes = sorted(np.round(np.abs(axes[slanted, 2] / axes[slanted, 0]), 6))
    assert slopes == pytest.approx([0.2 / 0.35] * 4, abs=1e-6)  # from an inner to an outer edge
    assert np.abs(axes[slanted, 1]).max() < 1e-12
    assert set(np.round(origins[slanted, 1], 9)) == {-0.1, 0.1}


def test_the_friction_axis_needs_parallel_normals() -> None:
    assert all_parallel(np.array([Z, -Z, Z]), 1.0)
    assert not all_parallel(np.array([Z, X]), 1.0)
    assert not all_parallel(np.array([Z, np.array([0, np.sin(0.03), np.cos(0.03)])]), 1.0)
    groove = Graph().prepare(assemble(shipped_scene("v_groove")))
    spins = groove.toppling.axes_of(1).twists[:, 3:]
    assert "slip" not in {mode for mode, spin in zip(modes(groove), spins, strict=True) if spin[1] == 0}
    cube = Graph().prepare(assemble(cube_scene()))
    assert sorted(modes(cube)) == ["slip", "slip", "topple", "topple", "topple", "topple"]


def modes(state: GraphState) -> list[str]:
    """What contacts do as the first body turns about each of its axes."""
    turns, number = state.toppling, state.toppling.G.cuts.index(1)
    return [state.turning(turns.twists(number, k)).mode for k in range(len(turns.axes[number].torque))]


def test_the_centre_of_friction_weighs_by_friction() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0]])
    normals = np.array([Z, Z])
    origin, axis = friction_axis(points, normals, np.array([0.2, 0.6]), np.array([10.0, 10]))
    np.testing.assert_allclose(origin, [[0.75, 0, 0]])
    np.testing.assert_allclose(axis, [Z])
    np.testing.assert_allclose(friction_axis(points, normals, np.ones(2), np.zeros(2))[0], [[0.5, 0, 0]])


def subdivided_square(n: int) -> np.ndarray:
    u = np.linspace(-0.05, 0.05, n)
    return np.stack(np.meshgrid(u, u, [0.0]), -1).reshape(-1, 3)


@pytest.mark.parametrize(
    ("points", "axes"),
    [
        (square(), 4),
        (subdivided_square(5), 4),
        (np.vstack([square(), square(0.1)]), 12),
        (np.vstack([subdivided_square(5), subdivided_square(5) + 0.1 * Z]), 12),
        (np.vstack([square(), [[0, 0, 0.1]]]), 8),
        (square()[:3], 3),
        (square()[:2], 1),
        (np.linspace(0, 1, 5)[:, None] * X, 1),
        (np.zeros((3, 3)), 3),
    ],
    ids=["square", "grid", "cube", "grids", "pyramid", "triangle", "segment", "line", "point"],
)
def test_hull_edges_on_one_line_or_in_one_plane_count_once(points: np.ndarray, axes: int) -> None:
    motion = random_motion(4)
    for corners in (points, apply(motion, points)):
        assert len(toppling_axes(corners, 0.2)[0]) == axes


def test_a_box_on_an_l_shaped_or_split_floor_has_the_edges_of_one_hull() -> None:
    def boxes_under(*tiles: tuple[float, float]) -> int:
        fixed = [block(f"tile{k}", (0.1, 0.1, 0.05), (x, y, -0.025), fixed=True) for k, (x, y) in enumerate(tiles)]
        state = Graph().prepare(assemble(Scene([*fixed, block("box", (0.2, 0.2, 0.1), (0, 0, 0.05))], 0.6)))
        return modes(state).count("topple")

    four = ((-0.05, -0.05), (0.05, -0.05), (-0.05, 0.05), (0.05, 0.05))
    assert boxes_under(*four) == 4  # each edge blocks one of its senses
    assert boxes_under(*four[:3]) == 5  # the L's hull cuts its inner corner


@pytest.mark.parametrize("cells", [4, 6, 7, 9])
def test_a_cube_on_a_subdivided_floor_has_four_edges(cells: int) -> None:
    subdivided = Mesh(subdivided_square(cells + 1) * 4, _grid_faces(cells + 1))
    state = Graph().prepare(assemble(Scene([Body("floor", subdivided, fixed=True), *cube_scene().movable], 0.6)))
    assert modes(state).count("topple") == 4


def _grid_faces(n: int) -> np.ndarray:
    quads = [
        (n * i + j, n * i + j + 1, n * (i + 1) + j + 1, n * (i + 1) + j) for i in range(n - 1) for j in range(n - 1)
    ]
    return np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def test_a_tall_box_on_a_tilted_plane_has_less_to_lose_downhill() -> None:
    """Gravity leans by tan 0.2 along x: a 1 kg box 0.1 x 0.1 x 0.2 pushed at its top, mu 1; W is the normal weight."""
    gravity = 9.81 * np.array([0.2, 0, -1])
    assembly = assemble(Scene([floor(), block("box", (0.1, 0.1, 0.2), (0, 0, 0.1))], 1.0, gravity))
    assert push(assembly, "box", (-0.05, 0, 0.2), X) == pytest.approx(9.81 * (0.05 - 0.02) / 0.2, rel=1e-5)
    assert push(assembly, "box", (0.05, 0, 0.2), -X) == pytest.approx(9.81 * (0.05 + 0.02) / 0.2, rel=1e-5)
