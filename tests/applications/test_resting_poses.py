"""Poses of rest: closed forms of boxes, cylinders and ellipsoids, engine limit, and what is in no frame."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from placed import prism

import holdfast as hf
from holdfast.applications.hull_graph import HullGraph
from holdfast.applications.resting_poses import StandingFaces
from holdfast.report import pose_report

G = 9.81


def test_a_box_rests_on_its_six_faces() -> None:
    sides = np.array([0.1, 0.2, 0.3])
    found = hf.resting_poses(hf.Box(tuple(sides)), mass=2.0, mu=0.4)
    assert len(found) == 6
    for pose in found:
        axis = int(np.argmax(np.abs(pose.pose[2, :3])))
        h, (b, c) = sides[axis] / 2, np.delete(sides, axis) / 2
        assert pose.height == pytest.approx(h)
        assert pose.probability == pytest.approx(np.arcsin(b * c / np.hypot(h, b) / np.hypot(h, c)) / np.pi)
        assert pose.tipping_degrees == pytest.approx(np.degrees(np.arctan(min(b, c) / h)))
        assert pose.least_push == pytest.approx(2 * G * min(0.4, min(b, c) / h))
        assert pose.energy == pytest.approx(2 * G * (np.hypot(h, min(b, c)) - h))
        assert not pose.rolls
        corners = found.body.moved(pose.pose).surface_world.vertices
        assert corners[:, 2].min() == pytest.approx(0, abs=1e-12)
        np.testing.assert_allclose(sorted(np.ptp(pose.support, axis=0)[:2]), sorted((2 * b, 2 * c)), atol=1e-9)
    assert sum(pose.probability for pose in found) == pytest.approx(1)
    assert [pose.probability for pose in found] == sorted((pose.probability for pose in found), reverse=True)


def test_a_cylinder_rolls_on_its_side() -> None:
    side, *ends = hf.resting_poses(hf.Cylinder(0.04, 0.1))
    assert (side.rolls, side.tipping_degrees, side.least_push) == (True, 0, 0)
    assert side.height == pytest.approx(0.04, rel=5e-3)
    assert side.energy == pytest.approx(G * (np.hypot(0.04, 0.05) - 0.04), rel=0.02)
    assert [end.rolls for end in ends] == [False, False]
    for end in ends:
        assert end.probability == pytest.approx((1 - 0.05 / np.hypot(0.04, 0.05)) / 2, rel=0.01)
        assert end.tipping_degrees == pytest.approx(np.degrees(np.arctan(0.04 / 0.05)), rel=5e-3)


def test_the_sheet_says_at_which_tilt_a_cylinder_tips_and_that_it_rolls(monkeypatch: pytest.MonkeyPatch) -> None:
    """On its ends at arctan(r / (h / 2)): 45° of one as high as wide."""
    sheets: list[Any] = []
    monkeypatch.setattr(pose_report, "write_sequence", lambda sheet, path: sheets.append(sheet))
    hf.resting_poses(hf.Cylinder(0.05, 0.1, 32)).save_png("sheet.png")
    side, *ends = (frame.note for frame in sheets[0].frames)
    assert side == "rolls"
    assert ends == ["on 32 corners, tips at 44.9°"] * 2  # across the middle of a side, at 0.05 cos(π / 32)


@pytest.mark.parametrize("sides", [3, 5, 8, 16, 24])
@pytest.mark.parametrize("mu", [0.1, 0.6])
def test_a_prism_rests_on_each_of_its_sides(sides: int, mu: float) -> None:
    """A rod of n sides tips at π / n, with m g tan(π / n), over an edge that is 1 / cos(π / n) times as far."""
    rod, half = trimesh.creation.cylinder(0.05, 0.1, sections=sides), np.pi / sides
    found = hf.resting_poses(hf.Mesh(rod.vertices, rod.faces), mass=0.3, mu=mu)
    on_sides = [pose for pose in found if abs(pose.pose[2, 2]) < 0.5]
    assert (len(found), len(on_sides)) == (sides + 2, sides)
    for pose in on_sides:
        assert not pose.rolls
        assert pose.tipping_degrees == pytest.approx(np.degrees(half))
        assert pose.least_push == pytest.approx(0.3 * G * min(mu, np.tan(half)))
        assert pose.energy == pytest.approx(0.3 * G * 0.05 * (1 - np.cos(half)))
        assert pose.probability == pytest.approx(on_sides[0].probability)


@pytest.mark.parametrize(("sides", "rolls"), [(16, False), (24, False), (32, False), (64, True), (128, True)])
@pytest.mark.parametrize("size", [0.01, 1.0])
def test_a_mesh_is_round_where_no_contact_tells_its_facets_from_a_curve(sides: int, rolls: bool, size: float) -> None:
    """The sagitta r (1 - cos(π / n)) beside a thousandth of the diagonal: of this tin, √12 r."""
    tin = trimesh.creation.cylinder(size, 2 * size, sections=sides)
    assert bool(1 - np.cos(np.pi / sides) <= 1e-3 * np.sqrt(12)) == rolls
    found = hf.resting_poses(hf.Mesh(tin.vertices, tin.faces))
    assert len(found) == (3 if rolls else sides + 2)
    assert sum(pose.rolls for pose in found) == rolls


def _lump(seed: int) -> hf.Mesh:
    hull = trimesh.convex.convex_hull(np.random.default_rng(seed).normal(size=(14, 3)) * (0.03, 0.04, 0.06))
    return hf.Mesh(hull.vertices, hull.faces)


def _tin(sides: int) -> tuple[np.ndarray, np.ndarray]:
    tin = trimesh.creation.cylinder(0.04, 0.1, sections=sides)
    return np.asarray(tin.vertices), np.asarray(tin.faces)


@pytest.mark.parametrize(
    "shape",
    [
        *map(_lump, range(3)),
        hf.Box((0.1, 0.2, 0.3)),
        hf.Cylinder(0.04, 0.1),
        hf.Ellipsoid((0.03, 0.05, 0.08)),
        hf.Mesh(*_tin(48)),
        hf.Mesh(*_tin(12)),
    ],
)
def test_objects_are_placed_on_the_faces_on_which_they_rest(shape: hf.Box) -> None:
    """The faces that a place may use and the poses of rest are the same, with the same tilts."""
    faces = StandingFaces(hf.Body("b", shape, mass=1)).faces()
    found = hf.resting_poses(shape, mass=1)
    stand = sorted((float(np.degrees(face.tilt)), *face.normal) for face in faces if face.tilt > 0 and not face.rolls)
    rest = sorted((pose.tipping_degrees, *(-pose.pose[2, :3])) for pose in found if not pose.rolls)
    np.testing.assert_allclose(stand, rest, atol=1e-6)
    assert any(face.rolls for face in faces) == any(pose.rolls for pose in found)


@pytest.mark.parametrize("seed", range(8))
def test_each_facet_over_which_the_centre_of_mass_lies_is_a_pose(seed: int) -> None:
    """By the margins of the facets alone: no pose is missing that a tilt of 2° does not end, and 1° ends none."""
    shape = _lump(seed)
    mesh = trimesh.Trimesh(shape.vertices, shape.faces)
    centre, firm = mesh.center_mass, []
    for corners, normal in zip(mesh.triangles, mesh.face_normals, strict=True):
        along = np.roll(corners, -1, axis=0) - corners
        inward = np.cross(normal, along / np.linalg.norm(along, axis=1)[:, None])
        inside, high = ((centre - corners) * inward).sum(1).min(), (corners[0] - centre) @ normal
        if np.degrees(np.arctan2(inside, high)) > 2:
            firm.append(normal)
    found = hf.resting_poses(shape)
    assert min(pose.tipping_degrees for pose in found) > 1
    downs = np.array([-pose.pose[2, :3] for pose in found])
    nearest = np.array([np.linalg.norm(np.cross(downs, normal), axis=1)[downs @ normal > 0].min() for normal in firm])
    assert (nearest < 1e-9).all()


def _leaning(degrees: float) -> hf.Mesh:
    """A block 0.1 m high, that leans so far that its centre is within its foot by so many degrees."""
    lean = 0.1 - 0.1 * np.tan(np.radians(degrees))
    return prism(np.array([(0, 0), (0.1, 0), (0.1 + lean, 0.1), (lean, 0.1)]), 0.0, 0.3)


@pytest.mark.parametrize("degrees", [0.2, 0.5, 0.9])
def test_what_a_small_tilt_ends_counts_to_where_the_body_goes(degrees: float) -> None:
    """A block that leans almost too far is like one that leans a little too far, not like one that stands."""
    stands, almost, falls = (hf.resting_poses(_leaning(one)) for one in (1.5, degrees, -degrees))
    assert (len(stands), len(almost), len(falls)) == (6, 4, 4)
    assert sorted(pose.tipping_degrees for pose in stands)[:2] == pytest.approx([1.5, 1.5])
    shares = [[pose.probability for pose in found] for found in (almost, falls)]
    assert shares[0] == pytest.approx(shares[1], abs=2e-3)
    assert sum(shares[0]) == pytest.approx(1)
    # it leaves its slanting side, long √(0.1² + lean²) and so far as 0.01 / that from the other one, for its foot
    lean = 0.1 - 0.1 * np.tan(np.radians(degrees))
    height, edge = 0.005 / np.hypot(0.1, lean), np.hypot(0.1 - lean, 0.1) / 2
    for pose in almost[:2]:
        assert pose.height == pytest.approx(height)
        assert pose.tipping_degrees == pytest.approx(np.degrees(np.arccos(height / edge)))
        assert pose.energy == pytest.approx(G * (edge - height))


def test_a_round_side_stays_though_its_last_facet_is_cut_short() -> None:
    """A small tilt ends its last and lowest facet, not the others: the share of the arc from -42° to 40.5°."""
    r, length = 0.05, 0.3
    others = [(60, r / np.cos(np.radians(0.5)) * np.cos(np.radians(19.5))), (150, 0.9 * r), (240, 0.9 * r)]
    last = (280, r / np.cos(np.radians(2)) * np.cos(np.radians(38)))
    sides = [*((angle, r) for angle in range(-40, 41, 4)), *others, last]
    normals = np.array([(np.cos(np.radians(angle)), np.sin(np.radians(angle))) for angle, _ in sides])
    far = np.array([distance for _, distance in sides])
    corners = [np.linalg.solve(normals[[k - 1, k]], far[[k - 1, k]]) for k in range(len(sides))]
    shape = prism(np.array([(float(x), float(y)) for x, y in corners]), 0.0, length)
    found = hf.resting_poses(shape, com=(*(1e-6 * normals[20]), length / 2))
    (side,) = [pose for pose in found if pose.rolls]
    assert side.probability == pytest.approx(82.5 / 360 * length / np.hypot(2 * r, length), rel=0.01)
    assert len(found) == 1 + len(others) + 1 + 2


@pytest.mark.parametrize("noise", [0.0, 1e-5])
def test_a_fine_mesh_of_an_ellipsoid_rests_where_the_ellipsoid_does(noise: float) -> None:
    """Its triangles are no poses of their own, nor are those of a scan of it: the closed forms of the ellipsoid."""
    ball, (c, b, a) = trimesh.creation.icosphere(subdivisions=5), (0.03, 0.05, 0.08)
    rough = np.random.default_rng(0).normal(size=ball.vertices.shape)
    mesh = trimesh.convex.convex_hull(ball.vertices * (c, b, a) + noise * rough)
    found = hf.resting_poses(hf.Mesh(mesh.vertices, mesh.faces))
    assert len(found) == 2
    for pose in found:
        assert abs(pose.pose[2, 0]) > np.cos(np.radians(2))
        assert pose.probability == pytest.approx(0.5, abs=0.02)
        assert pose.tipping_degrees == pytest.approx(np.degrees(np.arctan((b * b - c * c) / (2 * b * c))), rel=0.05)


def test_a_ball_a_long_ellipsoid_and_a_capsule_roll_everywhere() -> None:
    for shape in (hf.Sphere(0.1), hf.Ellipsoid((0.04, 0.04, 0.08)), hf.Capsule(0.03, 0.1)):
        (pose,) = hf.resting_poses(shape)
        assert (pose.rolls, pose.probability, pose.energy) == (True, pytest.approx(1), np.inf)


@pytest.mark.parametrize("radii", [(0.03, 0.05, 0.08), (0.05, 0.06, 0.07), (0.08, 0.04, 0.05)])
def test_an_ellipsoid_rests_on_its_shortest_axis(radii: tuple[float, float, float]) -> None:
    """It is lifted over its middle axis b, and stands up to a tilt of atan((b² - c²) / (2 b c))."""
    c, b, _ = sorted(radii)
    found = hf.resting_poses(hf.Ellipsoid(radii))
    assert len(found) == 2
    for pose in found:
        np.testing.assert_allclose(np.abs(pose.pose[2, :3]), np.eye(3)[int(np.argmin(radii))], atol=0.02)
        assert pose.probability == pytest.approx(0.5, abs=0.02)
        assert pose.energy == pytest.approx(G * (b - c), rel=0.05)
        assert pose.tipping_degrees == pytest.approx(np.degrees(np.arctan((b * b - c * c) / (2 * b * c))), rel=0.05)


def test_poses_are_in_no_frame() -> None:
    turn = hf.pose(0.2, -0.1, 0.4, roll=20, pitch=-30, yaw=50)
    moved = hf.Compound([hf.Part(part.shape, pose=turn @ part.pose) for part in _bracket().parts])
    one, other = (hf.resting_poses(shape, mass=1.5) for shape in (_bracket(), moved))
    for name in ("probability", "height", "tipping_degrees", "least_push", "energy"):
        mine, others = (sorted(getattr(pose, name) for pose in found) for found in (one, other))
        np.testing.assert_allclose(mine, others, rtol=1e-6)


@pytest.mark.parametrize("shape", [hf.Box((0.1, 0.2, 0.3)), hf.Cylinder(0.04, 0.15)], ids=["box", "cylinder"])
def test_engine_limit_agrees_with_the_least_push(shape: hf.Box) -> None:
    found = hf.resting_poses(shape, mass=2.0, mu=0.4)
    angles = np.radians(np.arange(0, 360, 5))
    ways = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    for k, pose in enumerate(found):
        if not pose.rolls:
            limits = hf.transport_limits(found.scene(k), ways, engine="limit")
            assert limits.verdict.stable
            assert limits.acceleration.min() * 2.0 == pytest.approx(pose.least_push, rel=0.01)


def test_a_ridge_is_the_same_from_both_sides() -> None:
    graph = HullGraph.of(np.random.default_rng(1).normal(size=(40, 3)), np.zeros(3), 1e-6)
    passes = {tuple(pair): k for k, pair in enumerate(graph.ridges.tolist())}
    back = [passes[other, one] for one, other in passes]
    np.testing.assert_allclose(graph.passes[back], graph.passes, rtol=1e-9)
    np.testing.assert_allclose(graph.turns[back], graph.turns, rtol=1e-9)
    own = np.arange(len(graph.rests))
    assert ((graph.margins >= 0) == (graph.rests == own)).all()
    assert (graph.heights[graph.rests] <= graph.heights + 1e-12).all()
    assert graph.solid.sum() == pytest.approx(1)


def test_bad_values_are_refused() -> None:
    with pytest.raises(hf.HoldfastError, match="mass"):
        hf.resting_poses(hf.Box((1, 1, 1)), mass=-1)
    with pytest.raises(hf.HoldfastError, match="mu"):
        hf.resting_poses(hf.Box((1, 1, 1)), mu=float("nan"))
    with pytest.raises(hf.HoldfastError, match="shape"):
        hf.resting_poses("box")  # type: ignore[arg-type]


def _bracket() -> hf.Compound:
    foot = hf.Part(hf.Box((0.2, 0.06, 0.05)), pose=hf.pose(0.1, 0, 0.025))
    return hf.Compound([foot, hf.Part(hf.Box((0.05, 0.06, 0.2)), pose=hf.pose(0.025, 0, 0.1))])


def test_a_flat_shape_and_a_centre_of_mass_outside_are_refused() -> None:
    plate = hf.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    with (
        pytest.warns(hf.errors.HoldfastWarning, match="which side"),
        pytest.raises(hf.errors.GeometryError, match="resting_poses: shape: is flat"),
    ):
        hf.resting_poses(plate, com=(0.5, 0.5, 0))
    for com in (0, 0, 0.3), (0.05, 0, 0):
        with pytest.raises(hf.errors.GeometryError, match="is not inside its convex hull"):
            hf.resting_poses(hf.Box((0.1, 0.2, 0.3)), com=com)
