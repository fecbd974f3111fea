"""Contact detection against closed forms: hulls, areas, tolerances, invariance."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped import shipped_scene, shipped_scenes
from holdfast.scene.shipped.blocks import at, box, floor, table

SIDE = (0.1, 0.1, 0.1)


def turned(scene: hf.Scene, pose: np.ndarray, scale: float = 1.0) -> hf.Scene:
    """The whole scene, gravity included, scaled about the origin and then moved."""
    bodies = []
    for body in scene.bodies:
        moved = body.pose.copy()
        moved[:3, 3] *= scale
        moved = pose @ moved
        surface = body.shape.surface
        shape = hf.Mesh(surface.vertices * scale, surface.faces)
        com = None if body.com is None else body.com * scale
        bodies.append(
            hf.Body(body.name, shape, mass=body.mass, pose=moved, com=com, material=body.material, fixed=body.fixed)
        )
    return hf.Scene(bodies, scene.friction, pose[:3, :3] @ scene.gravity, scene.name)


def motion(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return pose_from(rng.uniform(-2, 2, 3), rng.normal(size=4))


def rectangle(x: tuple[float, float], y: tuple[float, float], z: float) -> np.ndarray:
    return np.array([(u, v, z) for u, v in itertools.product(x, y)])


def square(angle: float, z: float) -> np.ndarray:
    corners = rectangle((-0.05, 0.05), (-0.05, 0.05), z)
    return corners @ Rotation.from_rotvec([0, 0, angle]).as_matrix().T


def octagon(angle: float, z: float) -> np.ndarray:
    """Corners that two equal squares, one turned by ``angle``, have in common."""
    directions = [*np.arange(4) * np.pi / 2, *(np.arange(4) * np.pi / 2 + angle)]
    directions.sort()
    corners = []
    for a, b in itertools.pairwise([*directions, directions[0] + 2 * np.pi]):
        sides = np.array([[np.cos(a), np.sin(a)], [np.cos(b), np.sin(b)]])
        corners.append([*np.linalg.solve(sides, [0.05, 0.05]), z])
    return np.array(corners)


def cubes(*angles: float) -> hf.Scene:
    bodies = [
        hf.Body(
            f"c{k}", hf.Box(SIDE), mass=1, pose=at(0, 0, 0.05 + 0.1 * k, np.array([np.cos(t / 2), 0, 0, np.sin(t / 2)]))
        )
        for k, t in enumerate(angles)
    ]
    return hf.Scene([floor(), *bodies], 0.5)


SLOPE = pose_from(np.zeros(3), np.array([np.cos(np.pi / 18), np.sin(np.pi / 18), 0, 0]))
RING = 2 * np.pi * np.arange(64) / 64


def cases() -> dict[str, tuple[Callable[[], hf.Scene], dict[tuple[str, str], np.ndarray]]]:
    """Scenes and the convex hulls of their interfaces."""
    legs = {
        (a, b): rectangle(x, (-0.1, 0.1), z)
        for side, x in (("left", (-0.2, -0.15)), ("right", (0.15, 0.2)))
        for a, b, z in (("floor", f"leg_{side}", 0.0), ("slab", f"leg_{side}", 0.2))
    }
    disc = np.column_stack([0.04 * np.cos(RING), 0.04 * np.sin(RING), np.zeros(64)])
    return {
        "cube": (lambda: cubes(0), {("floor", "c0"): square(0, 0)}),
        "turned stack": (
            lambda: cubes(0, 0.3, 0.7),
            {("floor", "c0"): square(0, 0), ("c0", "c1"): octagon(0.3, 0.1), ("c1", "c2"): octagon(0.4, 0.2)},
        ),
        "table": (table, legs),
        "overhang": (
            lambda: hf.Scene([floor(), box("a", SIDE, 1, (0, 0, 0.05)), box("b", SIDE, 1, (0.03, -0.02, 0.15))], 0.5),
            {("floor", "a"): square(0, 0), ("a", "b"): rectangle((-0.02, 0.05), (-0.05, 0.03), 0.1)},
        ),
        "slope": (lambda: turned(cubes(0), SLOPE), {("floor", "c0"): square(0, 0) @ SLOPE[:3, :3].T}),
        "cylinder": (
            lambda: hf.Scene([floor(), hf.Body("can", hf.Cylinder(0.04, 0.2), mass=1, pose=at(0, 0, 0.1))], 0.5),
            {("floor", "can"): disc},
        ),
    }


CASES = cases()
TURN = {"turned stack": {("c1", "c2"): 0.3}}


def area_of(hull: np.ndarray) -> float:
    """Of a convex polygon in space, from its corners in any order."""
    centred = hull - hull.mean(0)
    _, _, axes = np.linalg.svd(centred)
    flat = centred @ axes[:2].T
    flat = flat[np.argsort(np.arctan2(flat[:, 1], flat[:, 0]))]
    x, y = flat.T
    return float(abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2)


@pytest.mark.parametrize("name", CASES)
def test_hulls_and_areas_are_the_closed_forms(name: str) -> None:
    build, expected = CASES[name]
    found = {i.bodies: i for i in hf.assemble(build()).interfaces}
    assert set(found) == set(expected)
    for pair, hull in expected.items():
        angle = TURN.get(name, {}).get(pair, 0.0)
        truth = hull @ Rotation.from_rotvec([0, 0, angle]).as_matrix().T if angle else hull
        (patch,) = found[pair].patches
        assert len(patch.hull) == len(truth)
        apart = np.linalg.norm(patch.hull[:, None] - truth, axis=2)
        assert apart.min(1).max() < 1e-9
        assert apart.min(0).max() < 1e-9
        assert found[pair].area == pytest.approx(area_of(truth), rel=1e-9)
        assert found[pair].status == "touching"


@pytest.mark.parametrize("name", shipped_scenes())
def test_normals_point_into_the_second_body(name: str) -> None:
    assembly = hf.assemble(shipped_scene(name))
    for interface in assembly.interfaces:
        second = assembly.scene.body(interface.bodies[1]).surface_world
        solid = trimesh.Trimesh(second.vertices, second.faces, process=False)
        for patch in interface.patches:
            assert np.linalg.norm(patch.normal) == pytest.approx(1)
            x, y = patch.rings[0].T
            assert np.dot(x, np.roll(y, -1)) > np.dot(y, np.roll(x, -1))
        if solid.is_watertight and solid.is_convex:
            depth = solid.center_mass - interface.patches[0].centroid
            assert depth @ interface.patches[0].normal > 0


def test_a_ring_keeps_its_hole() -> None:
    foot = trimesh.creation.annulus(0.03, 0.05, 0.02, sections=48)
    body = hf.Body("bowl", hf.Mesh(foot.vertices, foot.faces), mass=1, pose=at(0, 0, 0.01))
    (interface,) = hf.assemble(hf.Scene([floor(), body], 0.5)).interfaces
    (patch,) = interface.patches
    (hole,) = patch.holes
    polygon = 48 / 2 * np.sin(2 * np.pi / 48)
    assert interface.area == pytest.approx(polygon * (0.05**2 - 0.03**2), rel=1e-9)
    np.testing.assert_allclose(np.linalg.norm(patch.hull[:, :2], axis=1), 0.05, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(hole[:, :2], axis=1), 0.03, atol=1e-9)
    np.testing.assert_allclose(patch.centroid, 0, atol=1e-9)


def test_the_bonded_wall_has_126_interfaces() -> None:
    assembly = hf.assemble(shipped_scene("bonded_wall"))
    assert len(assembly.interfaces) == 126
    areas = np.array([i.area for i in assembly.interfaces])
    allowed = np.array([0.01, 0.005, 0.015, 0.02])
    assert np.abs(areas[:, None] / allowed - 1).min(1).max() < 1e-9


@pytest.mark.parametrize("name", ["cube", "table", "cantilever", "arch", "slope_two", "tabletop"])
def test_interfaces_do_not_depend_on_the_order_of_the_bodies(name: str) -> None:
    scene = shipped_scene(name)
    mirrored = hf.Scene(scene.bodies[::-1], scene.friction, scene.gravity)
    forth = {i.bodies: i for i in hf.assemble(scene).interfaces}
    back = {i.bodies[::-1]: i for i in hf.assemble(mirrored).interfaces}
    assert set(forth) == set(back)
    for pair, interface in forth.items():
        other = back[pair]
        assert len(interface.patches) == len(other.patches)
        assert other.area == pytest.approx(interface.area, rel=1e-9)
        ours, theirs = interface.patches[0], other.patches[0]
        if interface.patches[0].area > 1.01 * (interface.patches[1].area if len(interface.patches) > 1 else 0):
            np.testing.assert_allclose(theirs.normal, -ours.normal, atol=1e-9)
            np.testing.assert_allclose(theirs.centroid, ours.centroid, atol=1e-9)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("name", ["stack", "table", "arch", "slope_two", "bonded_wall", "tabletop"])
def test_interfaces_move_and_grow_with_the_scene(name: str, scale: float) -> None:
    scene = shipped_scene(name)
    pose = motion(len(name))
    here = hf.assemble(scene).interfaces
    there = hf.assemble(turned(scene, pose, scale), allow_large=scale > 1).interfaces
    assert [i.bodies for i in here] == [i.bodies for i in there]
    for ours, theirs in zip(here, there, strict=True):
        assert len(ours.patches) == len(theirs.patches)
        assert theirs.area == pytest.approx(ours.area * scale**2, rel=1e-6)
        if len(ours.patches) == 1:
            np.testing.assert_allclose(theirs.patches[0].normal, pose[:3, :3] @ ours.patches[0].normal, atol=1e-7)
            centroid = pose[:3, :3] @ (scale * ours.patches[0].centroid) + pose[:3, 3]
            np.testing.assert_allclose(theirs.patches[0].centroid, centroid, atol=1e-7 * scale + 1e-12)


@pytest.mark.parametrize("gap", [1e-5, 1e-3])
@pytest.mark.parametrize(("share", "touches"), [(0.9, True), (1.1, False), (-0.9, True)])
def test_bodies_touch_within_the_gap(gap: float, share: float, touches: bool) -> None:
    scene = hf.Scene([floor(), box("cube", SIDE, 1, (0, 0, 0.05 + share * gap))], 0.5)
    assembly = hf.assemble(scene, gap=gap)
    assert len(assembly.interfaces) == touches
    for interface in assembly.interfaces:
        assert interface.area == pytest.approx(0.01, rel=1e-9)
        assert interface.patches[0].centroid[2] == pytest.approx(share * gap / 2, abs=1e-12)


@pytest.mark.parametrize("given", [{"angle_degrees": 1}, {}], ids=["given", "default"])
@pytest.mark.parametrize(("angle", "kind"), [(0.9, "face"), (1.1, "line")])
def test_faces_touch_within_a_degree_and_edges_beyond(angle: float, kind: str, given: dict[str, float]) -> None:
    half = np.radians(angle) / 2
    pose = at(0, 0, 0.05, np.array([np.cos(half), np.sin(half), 0, 0]))
    scene = hf.Scene([floor(), hf.Body("cube", hf.Box(SIDE), mass=1, pose=pose)], 0.5)
    (interface,) = hf.assemble(scene, gap=0.01, **given).interfaces
    assert [patch.kind for patch in interface.patches] == [kind]


def test_pose_sigma_sets_the_gap() -> None:
    assert hf.assemble(table(), pose_sigma=0.001).tolerances.gap == pytest.approx(0.004)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"gap": -1}, r"assemble: gap: is -1; needs"),
        ({"gap": float("nan")}, r"assemble: gap: is nan; needs"),
        ({"angle_degrees": 90}, r"assemble: angle_degrees = 90; needs less than 90"),
        ({"pose_sigma": 0}, r"assemble: pose_sigma: is 0; needs"),
        ({"gap": 1e-3, "pose_sigma": 1e-3}, r"gap = 0\.001 and pose_sigma = 0\.001; give one"),
        ({"interfaces": [3]}, r"interfaces holds a int; needs holdfast\.answers\.Interface"),
    ],
)
def test_tolerances_that_make_no_sense_are_refused(options: dict[str, object], match: str) -> None:
    with pytest.raises(hf.HoldfastError, match=match):
        hf.assemble(table(), **options)


def test_two_fixed_bodies_have_no_interface() -> None:
    wall = hf.Body("wall", hf.Box((0.1, 1, 0.1)), fixed=True, pose=at(0, 0, 0.05))
    assert hf.assemble(hf.Scene([floor(), wall], 0.5)).interfaces == ()


def test_a_deep_overlap_is_called_penetrating() -> None:
    scene = hf.Scene([floor(), box("cube", SIDE, 1, (0, 0, 0.05 - 0.002))], 0.5)
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        assembly = hf.assemble(scene)
    assert [i.status for i in assembly.interfaces] in ([], ["penetrating"])


@pytest.mark.parametrize(("share", "severity"), [(1.5, "warning"), (2.5, "error")])
def test_an_overlap_beyond_the_gap_is_named_and_leaves_the_verdict_open(share: float, severity: str) -> None:
    """No contact is taken deeper than the gap: through a thin wall the far side would count as the near one."""
    scene = hf.Scene([floor(), box("cube", SIDE, 1, (0, 0, 0.05 - share * 1e-3))], 0.5)
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        assembly = hf.assemble(scene, gap=1e-3)
    (overlap,) = assembly.overlaps
    assert overlap.depth == pytest.approx(share * 1e-3, rel=1e-6)
    assert overlap.severity == severity
    assert assembly.interfaces == ()
    assert hf.stability(assembly).status is hf.Status.UNDECIDED


@pytest.mark.parametrize(("sigma", "thin", "gap"), [(1e-3, 0.1, 4e-3), (1e-3, 4e-3, 2e-3)])
def test_the_gap_from_pose_sigma_stays_below_half_the_thickness(sigma: float, thin: float, gap: float) -> None:
    for lift, touches in ((0.99 * gap, True), (1.01 * gap, False)):
        scene = hf.Scene([floor(), box("plate", (0.1, 0.1, thin), 1, (0, 0, thin / 2 + lift))], 0.5)
        assert bool(hf.assemble(scene, pose_sigma=sigma).interfaces) == touches


def test_a_turn_of_the_pose_reaches_further_on_a_longer_body() -> None:
    """4σ of 0.1 degrees moves the ends of a beam of 1 m by 3.5 mm, those of a short one by 0.5 mm."""
    for length, touches in ((1.0, True), (0.15, False)):
        scene = hf.Scene([floor(), box("beam", (length, 0.05, 0.05), 1, (0, 0, 0.025 + 2e-3))], 0.5)
        assert bool(hf.assemble(scene, pose_sigma=(1e-4, 0.1)).interfaces) == touches


@pytest.mark.parametrize("seed", range(6))
def test_no_motion_of_the_wall_loses_a_contact(seed: int) -> None:
    """Clipped pieces meet along edges up to rounding; their union must neither fail nor drop one."""
    scene = shipped_scene("bonded_wall")
    expected = {i.bodies: pytest.approx(i.area, rel=1e-8) for i in hf.assemble(scene).interfaces}
    assert {i.bodies: i.area for i in hf.assemble(turned(scene, motion(seed))).interfaces} == expected
