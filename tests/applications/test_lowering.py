"""Letting an object down: closed forms of where it stops."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.applications.placement.lowering import Moved, Still, lowered, touching
from holdfast.base.rigid import pose_from, transform
from holdfast.scene.shipped.blocks import about_x, about_y, floor

UP = np.array([0.0, 0.0, 1.0])
NO_TURN = np.eye(4)[0]


def block(name, size, centre, turn=NO_TURN):
    return hf.Body(name, hf.Box(size), pose=pose_from(np.array(centre, float), turn), fixed=True)


def let_down(shape, bodies, start, turn=NO_TURN, mu=0.5, **body):
    moved = Moved(hf.Body("object", shape, mass=1, **body))
    stills = [Still(b, mu, UP) for b in bodies]
    return moved, stills, lowered(moved, pose_from(np.array(start, float), np.array(turn)), stills, UP)


def test_a_cube_lands_flat_where_it_is_let_go() -> None:
    _, _, pose = let_down(hf.Box((0.1, 0.1, 0.1)), [floor()], (0.1, 0.2, 0.4))
    assert pose == pytest.approx(pose_from(np.array([0.1, 0.2, 0.05]), NO_TURN), abs=1e-7)


@pytest.mark.parametrize("angle", [0.1, 0.4, -0.7])
def test_a_tilted_cube_falls_onto_its_nearest_face_about_the_edge_it_stands_on(angle: float) -> None:
    moved, _, pose = let_down(hf.Box((0.1, 0.1, 0.1)), [floor()], (0, 0, 0.4), about_y(angle))
    assert pose[:3, 2] == pytest.approx([0, 0, 1], abs=1e-6)
    assert pose[0, 0] == pytest.approx(1, abs=1e-6)
    # up to the length of the steps, the lowest edge stays where it lands: the centre comes down beside it
    edge = np.sign(angle) * 0.05 * (np.cos(angle) - np.sin(abs(angle)))
    assert pose[:3, 3] == pytest.approx([edge - np.sign(angle) * 0.05, 0, 0.05], abs=1e-3)
    assert moved.size == pytest.approx(0.1 * np.sqrt(3))


def test_a_board_across_two_blocks_takes_the_slope_between_their_edges() -> None:
    """Its lower end lies on the low block's top, 0.1 high; the high block's near edge, (0.05, 0.15), carries it."""
    low, high = block("low", (0.1, 0.1, 0.1), (-0.1, 0, 0.05)), block("high", (0.1, 0.1, 0.15), (0.1, 0, 0.075))
    moved, stills, pose = let_down(hf.Box((0.3, 0.06, 0.02)), [floor(), low, high], (0, 0, 0.3))
    touched = touching(moved, pose, stills, 1e-5)
    assert np.abs(touched.gaps).max() < 1e-6
    left, right = touched.points[touched.points[:, 0] < 0], touched.points[touched.points[:, 0] > 0]
    assert left[:, 2] == pytest.approx(0.1, abs=1e-6)
    assert right[:, [0, 2]] == pytest.approx(np.tile([0.05, 0.15], (len(right), 1)), abs=1e-6)
    end = transform(pose, np.array([[-0.15, 0, -0.01]]))[0]
    assert end[2] == pytest.approx(0.1, abs=1e-6)
    assert -pose[2, 0] / pose[0, 0] == pytest.approx(-0.05 / (0.05 - end[0]), abs=1e-6)


def test_friction_decides_between_resting_and_sliding() -> None:
    """On a slope of 20 degrees, tan 0.364: rests at mu 0.4; at 0.3 it slides off the end."""
    slope = block("slope", (0.4, 0.4, 0.1), (0, 0, 0), about_y(np.radians(20)))
    turn = about_y(np.radians(20))
    for mu, rests in ((0.4, True), (0.3, False)):
        _, _, pose = let_down(hf.Box((0.05, 0.05, 0.03)), [slope], (0, 0, 0.1), turn, mu=mu)
        assert (pose is not None) == rests
    assert pose is None


def test_what_is_not_over_anything_falls() -> None:
    assert let_down(hf.Box((0.1, 0.1, 0.1)), [floor(0.2, 0.2)], (0.5, 0, 0.2))[2] is None
    assert let_down(hf.Box((0.1, 0.1, 0.1)), [floor(0.2, 0.2)], (0.12, 0, 0.2))[2] is None  # tips over the rim


def test_the_centre_of_mass_decides_over_a_rim() -> None:
    """30 mm beyond the rim a centred cube stays; with its centre of mass 40 mm further out it tips off."""
    for com, stays in (((0, 0, 0), True), ((0.04, 0, 0), False)):
        pose = let_down(hf.Box((0.1, 0.1, 0.1)), [floor(0.2, 0.2)], (0.07, 0, 0.2), com=com)[2]
        assert (pose is not None) == stays


def test_a_ball_rests_in_a_groove_and_rolls_off_nothing() -> None:
    walls = [block("a", (0.2, 0.1, 0.1), (0, -0.08, 0)), block("b", (0.2, 0.1, 0.1), (0, 0.08, 0))]
    moved, stills, pose = let_down(hf.Sphere(0.05), walls, (0, 0.01, 0.2))
    assert pose is not None
    assert pose[1, 3] == pytest.approx(0, abs=1e-3)  # a polyhedron, not a ball
    assert pose[2, 3] == pytest.approx(0.05 + np.sqrt(0.05**2 - 0.03**2), abs=1e-3)
    assert len(touching(moved, pose, stills, 1e-5).gaps) >= 3


@pytest.mark.parametrize("seed", range(3))
def test_it_never_ends_inside_and_always_touches(seed: int) -> None:
    rng = np.random.default_rng(seed)
    bodies = [floor()] + [
        block(f"b{k}", rng.uniform(0.05, 0.15, 3), (*rng.uniform(-0.15, 0.15, 2), 0.05), rng.normal(size=4))
        for k in range(3)
    ]
    moved, stills, pose = let_down(hf.Box((0.12, 0.08, 0.04)), bodies, (0, 0, 0.5), rng.normal(size=4))
    if pose is None:
        return
    touched = touching(moved, pose, stills, 1e-3)
    assert touched.gaps.min() > -2e-6
    assert (np.abs(touched.gaps) < 2e-6).sum() >= 3
    lowest = transform(pose, moved.body.shape.surface.vertices)[:, 2].min()
    assert lowest > -2e-6


def test_gravity_sets_what_is_down() -> None:
    """The same along x: a rigid turn of scene, start and gravity turns the answer."""
    turn = pose_from(np.zeros(3), about_x(np.pi / 2))
    ground = floor()
    turned = hf.Body("floor", ground.shape, pose=turn @ ground.pose, fixed=True)
    moved = Moved(hf.Body("object", hf.Box((0.1, 0.06, 0.04)), mass=1))
    start = pose_from(np.array([0, 0, 0.3]), about_y(0.3))
    here = lowered(moved, start, [Still(ground, 0.5, UP)], UP)
    there = lowered(moved, turn @ start, [Still(turned, 0.5, turn[:3, :3] @ UP)], turn[:3, :3] @ UP)
    assert there == pytest.approx(turn @ here, abs=1e-6)


def holed(side: float) -> hf.Mesh:
    """A cube with square tunnels through it along all axes: its faces are large flat ones of many triangles."""
    solid = trimesh.creation.box((side,) * 3)
    for axis in np.eye(3):
        tunnel = trimesh.creation.box(np.where(axis > 0, 2 * side, 0.4 * side))
        solid = trimesh.boolean.difference([solid, tunnel], engine="manifold")
    return hf.Mesh(solid.vertices, solid.faces)


def test_large_flat_faces_meet_where_an_edge_has_one_on_either_side() -> None:
    """Contact detection lets such faces meet as a whole; here their edges and corners count."""
    table = hf.Body("table", holed(0.2), pose=pose_from(np.array([0, 0, -0.1]), NO_TURN), fixed=True)
    moved, _, pose = let_down(holed(0.1), [table], (0.03, 0.045, 0.08), (0.997, 0.06, 0.04, 0.02))
    assert (moved.mesh.facet >= 0).any()
    assert pose[:3, 2] == pytest.approx([0, 0, 1], abs=1e-6)
    assert pose[2, 3] == pytest.approx(0.05, abs=1e-5)
