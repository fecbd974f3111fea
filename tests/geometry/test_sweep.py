"""How far bodies move along a straight line until they touch: closed forms, and overlapping volumes."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from holdfast.base.rigid import pose_from
from holdfast.geometry.surface import Surface
from holdfast.geometry.sweep import Swept, first_hit, hit_distance
from holdfast.scene.body import Body
from holdfast.scene.shapes import Box, Cylinder, Sphere
from holdfast.scene.shipped.blocks import prism

X, Y, Z = np.eye(3)


def box(size: tuple[float, float, float], centre: tuple[float, float, float], turn: tuple = (1, 0, 0, 0)) -> Surface:
    pose = pose_from(np.array(centre, dtype=float), np.array(turn, dtype=float))
    return Body("box", Box(np.array(size)), pose=pose, fixed=True).surface_world


CUBE = box((1, 1, 1), (0, 0, 0))


@pytest.mark.parametrize(
    ("still", "direction", "expected"),
    [
        (box((1, 1, 1), (0, 0, 3)), Z, 2.0),
        (box((1, 1, 1), (0, 0, 3)), -Z, np.inf),
        (box((1, 1, 1), (0.9, 0, 3)), Z, 2.0),  # a part of the faces, by edges that cross
        (box((1, 1, 1), (1.1, 0, 3)), Z, np.inf),
        (box((1, 1, 1), (0, 0, 1)), Z, 0.0),  # lies on it
        (box((1, 1, 1), (0, 0, -1)), Z, np.inf),  # rests on that
        (box((1, 1, 1), (1, 0, 0)), Z, np.inf),  # slides along it
        (box((1, 1, 1), (1, 0, 3)), Z, np.inf),  # passes flush
        (box((1, 1, 1), (1, 1, 1)), Z, np.inf),  # touches it at a corner
        (box((3, 4, 1), (0, 0, 3)), X + Z, np.inf),  # just past its edge
        (box((3.1, 4, 1), (0, 0, 3)), X + Z, 2 * np.sqrt(2)),
        (box((1, 1, 1), (3, 3, 0)), X + Y, 2 * np.sqrt(2)),  # edge first
    ],
)
def test_boxes(still: Surface, direction: np.ndarray, expected: float) -> None:
    assert first_hit(CUBE, still, direction) == pytest.approx(expected, abs=1e-12)


def test_edges_that_cross() -> None:
    """Two bars with an edge towards each other, at right angles: only the edges meet."""
    diagonal = np.array([np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0])  # 45 degrees about x
    below = box((4, 1, 1), (0, 0, 0), tuple(diagonal))
    above = box((1, 4, 1), (0, 0, 5), (np.cos(np.pi / 8), 0, np.sin(np.pi / 8), 0))
    assert first_hit(below, above, Z) == pytest.approx(5 - np.sqrt(2), abs=1e-12)


def test_a_vertex_meets_a_slanted_face() -> None:
    roof = prism("roof", np.array([[-2.0, 2.0], [2.0, 4.0], [2.0, 5.0], [-2.0, 5.0]]), 4.0, 1, fixed=True).surface_world
    assert first_hit(CUBE, roof, Z) == pytest.approx((3 - 0.25) - 0.5, abs=1e-12)  # at x = -1/2
    assert first_hit(CUBE, roof, Z - X) == pytest.approx(np.sqrt(2) * (3 - 0.25 - 0.5) / 1.5, abs=1e-12)


def test_a_drawer_slides_out_and_not_up() -> None:
    """Flush in its slot on all sides but +y."""
    walls = [
        box((3, 2, 1), (0, 0, -1)), box((3, 2, 1), (0, 0, 1)), box((1, 2, 1), (-1, 0, 0)), box((1, 2, 1), (1, 0, 0)),
        box((1, 1, 1), (0, -1, 0)),
    ]  # fmt: skip
    assert [first_hit(CUBE, wall, Z) for wall in walls] == [np.inf, 0, np.inf, np.inf, np.inf]
    assert [first_hit(CUBE, wall, X) for wall in walls] == [np.inf, np.inf, np.inf, 0, np.inf]
    assert all(np.isinf(first_hit(CUBE, wall, Y)) for wall in walls)
    assert first_hit(CUBE, walls[-1], -Y) == 0


def test_what_lies_into_each_other_by_less_than_the_tolerance_slides_on() -> None:
    beside, above = box((1, 1, 1), (1 - 1e-3, 0, 2)), box((1, 1, 1), (0, 0, 1 - 1e-3))
    assert first_hit(CUBE, beside, Z) == pytest.approx(1.0)
    assert np.isinf(first_hit(CUBE, beside, Z, 1.01e-3))
    assert first_hit(CUBE, beside, Z, 0.9e-3) == pytest.approx(1.0)
    assert first_hit(CUBE, above, Z, 2e-3) == 0.0
    assert np.isinf(first_hit(above, CUBE, Z, 2e-3))  # it leaves what it is pressed into


def test_fine_triangles_stop_what_none_of_them_would_stop_alone() -> None:
    """A plate of triangles smaller than the tolerance is still a plate."""
    n = 21
    u = np.linspace(-0.5, 0.5, n)
    x, y = (g.ravel() for g in np.meshgrid(u, u, indexing="ij"))
    k = np.arange(n * n).reshape(n, n)
    a, b, c, d = (g.ravel() for g in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    faces = np.vstack([np.column_stack([a, c, b]), np.column_stack([a, d, c])])  # looks down
    sheet = Surface(np.column_stack([x, y, np.full(n * n, 2.0)]), faces)
    assert first_hit(CUBE, sheet, Z, 0.2) == pytest.approx(1.5)
    strip = Surface(sheet.vertices * (0.15, 1, 1), faces)
    assert np.isinf(first_hit(CUBE, strip, Z, 0.2))
    assert first_hit(CUBE, strip, Z, 0.1) == pytest.approx(1.5)


def test_a_ring_is_lifted_off_its_post() -> None:
    post, ring = Cylinder(0.1, 1.0), Cylinder(0.2, 0.1).surface
    hole = Cylinder(0.12, 0.3).surface
    cut = solid(ring) - solid(hole)
    read = cut.to_mesh64()
    ring = Surface(np.array(read.vert_properties[:, :3]), np.array(read.tri_verts, dtype=np.int64))
    assert np.isinf(first_hit(ring, post.surface, Z))
    assert first_hit(ring, post.surface, X) == pytest.approx(0.02, rel=0.05)


def test_where_the_inside_is_not_known_only_what_lies_ahead_counts() -> None:
    open_box = Surface(CUBE.vertices, CUBE.faces, oriented=False)
    above, under = box((1, 1, 1), (0, 0, 3)), box((1, 1, 1), (0, 0, -1))
    assert first_hit(open_box, above, Z) == pytest.approx(2.0)
    assert np.isinf(first_hit(open_box, under, Z))


def solid(surface: Surface) -> manifold3d.Manifold:
    return manifold3d.Manifold(manifold3d.Mesh64(surface.vertices.copy(), surface.faces.astype(np.uint64)))


def shapes(rng: np.random.Generator) -> Surface:
    """A random shape in a random pose; the third kind is not convex."""
    quaternion = rng.normal(size=4)
    kind = rng.integers(4)
    size = rng.uniform(0.5, 1.5, 3)
    if kind == 3:
        ell = np.array([[0, 0], [1, 0], [1, 0.3], [0.3, 0.3], [0.3, 1], [0, 1]]) * size[0]
        shape: object = prism("ell", ell, size[1], 1, fixed=True).shape
    else:
        shape = (Box(size), Cylinder(size[0] / 2, size[1]), Sphere(size[0] / 2))[kind]
    pose = pose_from(rng.uniform(-0.5, 0.5, 3), quaternion)
    return Body("b", shape, pose=pose, fixed=True).surface_world  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(30))
def test_volumes_overlap_behind_the_hit_and_not_before(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b, d = shapes(rng), shapes(rng), rng.normal(size=3)
    d /= np.linalg.norm(d)
    b = Surface(b.vertices + 4 * d + 0.4 * rng.normal(size=3), b.faces)
    hit = first_hit(a, b, d)
    one, other = solid(a), solid(b)

    def shared(t: float) -> float:
        return (one.translate(tuple(t * d)) ^ other).volume()

    if np.isinf(hit):
        assert max(shared(t) for t in np.linspace(0, 8, 81)) == 0
        return
    assert max(shared(t) for t in np.linspace(0, hit - 1e-6, 20)) <= 1e-12
    assert shared(hit + 1e-2) > 0
    assert hit_distance(Swept(b, -d), Swept(a, -d)) == pytest.approx(hit, abs=1e-9)  # the other one comes to meet it


def test_moved_together_nothing_changes() -> None:
    rng = np.random.default_rng(5)
    a, b = shapes(rng), shapes(rng)
    b = Surface(b.vertices + 3 * Z, b.faces)
    turn = pose_from(np.array([1.0, -2, 3]), rng.normal(size=4))
    moved = [Surface(s.vertices @ turn[:3, :3].T + turn[:3, 3], s.faces) for s in (a, b)]
    assert first_hit(*moved, turn[:3, :3] @ Z) == pytest.approx(first_hit(a, b, Z), abs=1e-9)
