"""Contact detection against closed forms: hulls, areas, tolerances, invariance."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.contacts.interface import Patch
from holdfast.scene.shipped.blocks import at, box, floor, table

SIDE = (0.1, 0.1, 0.1)


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


def test_two_fixed_bodies_have_no_interface() -> None:
    wall = hf.Body("wall", hf.Box((0.1, 1, 0.1)), fixed=True, pose=at(0, 0, 0.05))
    assert hf.assemble(hf.Scene([floor(), wall], 0.5)).interfaces == ()


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


def on_floor(shape: hf.Mesh, floor: hf.Box | hf.Cylinder) -> tuple[Patch, ...]:
    """The patches of a mesh of height 0.1, with the origin in its middle, that stands on a floor of the same height."""
    under = hf.Body("floor", floor, fixed=True, position=(0, 0, -0.05))
    over = hf.Body("thing", shape, mass=1.0, position=(0, 0, 0.05))
    return hf.assemble(hf.Scene([under, over], 0.5), gap=1e-4, angle_degrees=1).interfaces[0].patches


def test_a_prong_in_the_plane_of_a_face_is_found() -> None:
    """One body is a box and, beside it, a pyramid that stands on its point: that corner is no face's."""
    box_ = trimesh.creation.box(SIDE)
    prong = trimesh.convex.convex_hull([(0.1, 0, -0.05), (0.08, 0.02, 0.05), (0.12, 0.02, 0.05), (0.1, -0.02, 0.05)])
    both = trimesh.util.concatenate([box_, prong])
    patches = on_floor(hf.Mesh(both.vertices, both.faces), hf.Box((1, 1, 0.1)))
    assert sorted(patch.kind for patch in patches) == ["face", "point"]


def test_small_feet_beside_a_large_face_are_found() -> None:
    """A tin with a box beside it in one mesh: of both ends in the plane, only the tin's counts as large."""
    tin = hf.Cylinder(0.05, 0.1, 400).surface
    block = trimesh.creation.box((0.02, 0.02, 0.1))
    block.apply_translation((0.08, 0, 0))
    both = trimesh.util.concatenate([trimesh.Trimesh(tin.vertices, tin.faces), block])
    patches = on_floor(hf.Mesh(both.vertices, both.faces), hf.Cylinder(0.2, 0.1, 400))
    disc = 200 * 0.05**2 * np.sin(2 * np.pi / 400)
    assert sorted(patch.area for patch in patches) == pytest.approx([4e-4, disc], rel=1e-9)


@pytest.mark.parametrize("segments", [5, 24, 400])
@pytest.mark.parametrize("share", [1.0, 0.6])
def test_prisms_with_equal_or_inner_rims_touch_on_the_face_that_they_share(segments: int, share: float) -> None:
    """No edge or corner of a side counts beside the face."""
    surface = hf.Cylinder(0.05, 0.1, segments).surface
    mesh = hf.Mesh(surface.vertices * [share, share, 1], surface.faces)
    (face,) = on_floor(mesh, hf.Cylinder(0.05, 0.1, segments))
    area = segments / 2 * (share * 0.05) ** 2 * np.sin(2 * np.pi / segments)
    assert face.area == pytest.approx(area, rel=1e-9)
