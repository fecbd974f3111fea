"""Curved bodies, edges and corners against closed forms: as many patches, as wide and as steep as they are."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
import trimesh
from contact_truth import (
    ROOF,
    Case,
    Solid,
    agree,
    block,
    by_pair,
    extruded,
    frame,
    frame_at,
    motion,
    peg,
    revolved,
    spin,
)
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.arrays import Float

# bodies that rest on each other exactly must not be called overlapping; scenes of a kilometre may be remarked upon
pytestmark = [
    pytest.mark.filterwarnings("error::holdfast.errors.HoldfastWarning"),
    pytest.mark.filterwarnings("ignore:.* across:holdfast.errors.HoldfastWarning"),
]


def basin(radius: float, rings: int, sides: int) -> hf.Mesh:
    """A block of 0.14 m with a hemisphere sunk into its top; its lowest point is the origin."""
    angles = np.linspace(0, np.pi / 2, rings + 1)
    inner = [(radius * np.sin(t), radius * (1 - np.cos(t))) for t in angles]
    outer = [(0.07, radius), (0.07, -0.02), (0.0, -0.02)]
    return revolved([(0.0, 0.0), *inner[1:], *outer], sides)


@pytest.mark.parametrize(("radius", "seed"), [(0.04, 0), (0.04, 1), (0.04, 2), (0.049, 3)])
def test_a_ball_in_a_basin_rests_at_the_bottom(radius: float, seed: int) -> None:
    """Two curved surfaces: their normals agree only near the bottom, the nearer the smaller the ball."""
    turn = Rotation.from_quat(np.random.default_rng(seed).normal(size=4))
    ball = Solid("ball", hf.Sphere(radius, 4), frame(z=radius, turn=turn))
    case = Case((Solid("basin", basin(0.05, 24, 64), fixed=True), ball), {})
    (interface,) = hf.assemble(case.scene(), gap=5e-4, angle_degrees=1).interfaces
    points = np.vstack([p.hull for p in interface.patches])
    # the smooth surfaces stay within 1 degree up to t, seen from the ball's centre, where t - asin(r sin(t) / R) = 1;
    # triangles of the two may differ by some 2 degrees more
    angles = np.linspace(0, np.pi / 2, 10_000)
    within = angles[angles - np.arcsin(radius / 0.05 * np.sin(angles)) < np.radians(4)].max()
    assert np.linalg.norm(points[:, :2], axis=1).max() <= radius * np.sin(within) + 0.007
    weights = np.array([max(p.area, 1e-12) for p in interface.patches])
    mean = weights @ np.array([p.normal for p in interface.patches])
    assert mean[2] / np.linalg.norm(mean) > np.cos(np.radians(10))
    for patch in interface.patches:
        inward = np.array([0, 0, 0.05]) - patch.centroid
        assert patch.normal @ inward / np.linalg.norm(inward) > np.cos(np.radians(8))


@pytest.mark.parametrize("degrees", [0.3, 1.0])
def test_a_ball_whose_turn_is_uncertain_touches_on_no_larger_area(degrees: float) -> None:
    """However it is turned, it is the same ball: its faces touch those within 1 degree, as with a gap as wide."""
    ball = Solid("ball", hf.Sphere(0.04, 4), frame(z=0.04))
    scene = Case((Solid("basin", basin(0.05, 24, 64), fixed=True), ball), {}).scene()
    (wide,) = hf.assemble(scene, gap=5e-3, angle_degrees=1).interfaces
    (turned,) = hf.assemble(scene, angle_degrees=1, pose_sigma=(1e-6, degrees)).interfaces
    assert turned.area == pytest.approx(wide.area, rel=1e-6)


POINTED: dict[str, tuple[Float, str]] = {  # corners [m] of what stands on an edge or on a tip at the origin
    "edge": (np.array([[x, y, z] for x in (-0.1, 0.1) for y, z in ((0, 0), (-0.08, 0.1), (0.06, 0.1))]), "line"),
    "tip": (np.array([[0, 0, 0], [0.1, 0.1, 0.15], [-0.1, 0.1, 0.15], [0.1, -0.1, 0.15], [-0.1, -0.1, 0.15]]), "point"),
}


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("lift", [4e-4, -4e-4])
@pytest.mark.parametrize("name", POINTED)
def test_edges_and_tips_touch_halfway_to_the_face(name: str, lift: float, first: bool, turned: bool) -> None:
    corners, kind = POINTED[name]
    hull = trimesh.convex.convex_hull(corners)
    turn = motion(5) if turned else np.eye(4)
    thing = Solid("thing", hf.Mesh(hull.vertices, hull.faces), turn @ frame(z=lift))
    slab = Solid("slab", hf.Box(np.array([1, 1, 0.1])), turn @ frame(z=-0.05), fixed=True)
    scene = Case((thing, slab) if first else (slab, thing), {}).scene()
    (interface,) = hf.assemble(scene, gap=1e-3).interfaces
    (patch,) = interface.patches
    assert patch.kind == kind
    assert patch.separation == pytest.approx((lift, lift), abs=1e-12)
    local = (patch.polygon - turn[:3, 3]) @ turn[:3, :3]
    ends = [[-0.1, 0, lift / 2], [0.1, 0, lift / 2]] if kind == "line" else [[0, 0, lift / 2]]
    np.testing.assert_allclose(local[np.argsort(local[:, 0])], ends, atol=1e-9)
    np.testing.assert_allclose(patch.normal @ turn[:3, :3], [0, 0, -1.0 if first else 1.0], atol=1e-9)


def test_a_loose_peg_touches_all_around_within_the_gap_only() -> None:
    """Half a millimetre of play: 24 facing sides within 1 mm, none within 0.1 mm."""
    loose = peg(5e-4)
    agree(hf.assemble(loose.scene(), gap=1e-3).interfaces, loose, 1e-9, 1e-9)
    tight = Case(loose.solids, {("floor", "peg"): loose.truth["floor", "peg"]})
    agree(hf.assemble(loose.scene(), gap=1e-4).interfaces, tight, 1e-9, 1e-9)


def test_a_loose_peg_pushed_aside_touches_on_that_side() -> None:
    """Pushed against the middle of one facet: that facet only."""
    loose = peg(5e-4)
    play = 5e-4 * np.cos(np.pi / 24)
    towards = np.array([np.cos(np.pi / 24), np.sin(np.pi / 24), 0])
    case = Case((*loose.solids[:2], Solid("peg", loose.solids[2].shape, frame(*(play * towards)))), {})
    found = by_pair(hf.assemble(case.scene(), gap=1e-5).interfaces)
    (patch,) = found[frozenset(("sleeve", "peg"))].patches
    np.testing.assert_allclose(patch.normal, -towards, atol=1e-9)
    assert patch.area == pytest.approx(0.04 * np.sin(np.pi / 24) * 0.05, rel=1e-9)


def corner_up(turn: Rotation, at: tuple[float, float, float], sign: int) -> Float:
    """The pose of a 0.1 m cube whose lowest (sign 1) or highest (-1) corner is ``at``."""
    corners = turn.apply(np.array(list(itertools.product((-0.05, 0.05), repeat=3))))
    corner = corners[np.argmin(sign * corners[:, 2])]
    return frame_at(np.array(at) - corner, turn)


SKEW = Rotation.from_euler("zyx", (20, 35, 40), degrees=True)


def tip_on_tip() -> Case:
    """Two cubes on their corners, one above the other, corner on corner."""
    cube = hf.Box(np.full(3, 0.1))
    below = Solid("below", cube, corner_up(SKEW, (0, 0, 0), -1), fixed=True)
    return Case((below, Solid("above", cube, corner_up(spin(50) * SKEW, (0, 0, 0), 1))), {})


def tip_on_ridge() -> Case:
    """The corner of a cube on the ridge of a roof."""
    below = Solid("below", extruded(ROOF, -0.1, 0.12), fixed=True)
    return Case((below, Solid("above", hf.Box(np.full(3, 0.1)), corner_up(SKEW, (0, 0.03, 0), 1))), {})


def ridge_on_tip() -> Case:
    """The ridge of a roof, upside down, on the corner of a cube."""
    below = Solid("below", hf.Box(np.full(3, 0.1)), corner_up(SKEW, (0, 0, 0), -1), fixed=True)
    return Case((below, Solid("above", extruded(ROOF, -0.1, 0.12), frame(turn=spin(180, "y")))), {})


def ridge_along_ridge() -> Case:
    """Two roofs, ridge along ridge."""
    below = Solid("below", extruded(ROOF, -0.1, 0.12), fixed=True)
    return Case((below, Solid("above", extruded(ROOF, -0.05, 0.2), frame(turn=spin(180, "y")))), {})


def corner_at_corner() -> Case:
    """Upright cubes that share one corner."""
    below = Solid("below", hf.Box(np.full(3, 0.1)), frame(-0.05, -0.05, -0.05), fixed=True)
    return Case((below, block("above", (0.1, 0.1, 0.1), (0.05, 0.05, 0.05))), {})


def edge_at_edge() -> Case:
    """Upright cubes that share one edge, moved along it."""
    below = Solid("below", hf.Box(np.full(3, 0.1)), frame(-0.05, 0.03, -0.05), fixed=True)
    return Case((below, block("above", (0.1, 0.1, 0.1), (0.05, 0, 0.05))), {})


DEGENERATE = [tip_on_tip, tip_on_ridge, ridge_on_tip, ridge_along_ridge, corner_at_corner, edge_at_edge]


@pytest.mark.parametrize("moved", [False, True], ids=["plain", "moved"])
@pytest.mark.parametrize("gap", [None, 2e-3])
@pytest.mark.parametrize("build", DEGENERATE)
def test_corners_on_corners_and_edges_give_nothing_optimistic(
    build: Callable[[], Case], gap: float | None, moved: bool
) -> None:
    """No crash, no area, nothing away from the shared point or line; mirrored in the other order."""
    case = build().placed(motion(6)) if moved else build()
    interfaces = hf.assemble(case.scene(), gap=gap).interfaces
    back = hf.assemble(case.scene(reverse=True), gap=gap).interfaces
    assert [i.bodies for i in interfaces] == [i.bodies[::-1] for i in back]
    for interface in interfaces:
        assert interface.area == 0
        local = np.linalg.inv(motion(6)) if moved else np.eye(4)
        for patch in interface.patches:
            assert patch.kind != "face"
            points = patch.hull @ local[:3, :3].T + local[:3, 3]
            assert np.abs(points[:, [0, 2]]).max() < 2e-3
            assert (np.abs(points[:, 1]) < 0.121).all()


@pytest.mark.parametrize("gap", [None, 2e-3])
@pytest.mark.parametrize("build", [corner_at_corner, edge_at_edge])
def test_upright_cubes_that_share_a_corner_or_an_edge_do_not_touch(
    build: Callable[[], Case], gap: float | None
) -> None:
    """Nothing holds such cubes: no interface, or one that says it is a sliver when the gap allows for one."""
    interfaces = hf.assemble(build().scene(), gap=gap).interfaces
    assert all("sliver" in i.flags for i in interfaces)
    if gap is None:
        assert interfaces == ()
