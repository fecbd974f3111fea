"""Properties of contacts between random convex polyhedra placed face to face."""

from __future__ import annotations

import numpy as np
from contact_truth import (
    UP,
    Case,
    Solid,
    Truth,
    agree,
    apart,
    common,
    frame,
    hull_of,
    level,
    motion,
    outward,
    shoelace,
)
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import holdfast as hf
from holdfast.base.arrays import Float

FEW = settings(max_examples=40, deadline=None, derandomize=True)
seeds = st.integers(0, 10**6)
offsets = st.tuples(st.floats(-0.06, 0.06), st.floats(-0.06, 0.06))


def polyhedron(seed: int, side: int) -> tuple[Float, hf.Mesh]:
    """A random convex polyhedron above (side 1) or below (-1) z = 0 with a face in it, and that face (k, 2)."""
    rng = np.random.default_rng(seed)
    base = hull_of(rng.uniform(0.3, 1) * 0.1 * rng.uniform(-1, 1, (rng.integers(3, 9), 2)))
    away = np.column_stack([rng.uniform(-0.1, 0.1, (8, 2)), rng.uniform(0.04, 0.15, 8)])
    points = np.vstack([level(base, 0), away])
    shape = ConvexHull(points)
    used, faces = np.unique(shape.simplices, return_inverse=True)
    faces = faces.reshape(-1, 3)
    corners = points[used]
    a, b, c = (corners[faces[:, k]] for k in range(3))
    inside = np.einsum("ij,ij->i", np.cross(b - a, c - a), shape.equations[:, :3]) < 0
    faces[inside] = faces[inside][:, ::-1]
    return base, outward(corners * [1, 1, side], faces)


def face_to_face(one: int, two: int, shift: tuple[float, float], turn: float) -> Case:
    """Two of them with their faces in z = 0, the upper one shifted and turned."""
    below, lower = polyhedron(one, -1)
    above, upper = polyhedron(two, 1)
    c, s = np.cos(turn), np.sin(turn)
    pose = frame(*shift)
    pose[:2, :2] = [[c, -s], [s, c]]
    outline = above @ pose[:2, :2].T + shift
    overlap = common(below, outline)
    assume(len(overlap) > 2)
    area = shoelace(overlap)
    # far from a sliver: what is 3 mm wide may be called one
    assume(area > 3e-3 * np.ptp(overlap, axis=0).max() and area > 1e-4)
    solids = (Solid("below", lower, fixed=True), Solid("above", upper, pose))
    return Case(solids, {("below", "above"): (Truth(level(overlap, 0), UP, area),)})


pairs = st.builds(face_to_face, seeds, seeds, offsets, st.floats(0, 2 * np.pi))


def only(case: Case, *, reverse: bool = False) -> tuple[hf.answers.Interface, hf.answers.Patch]:
    (interface,) = hf.assemble(case.scene(reverse=reverse)).interfaces
    (patch,) = interface.patches
    return interface, patch


@FEW
@given(pairs)
def test_the_patch_is_the_intersection_of_the_faces(case: Case) -> None:
    ((truth,),) = case.truth.values()
    interface, patch = only(case)
    assert interface.bodies == ("below", "above")
    assert interface.status == "touching"
    np.testing.assert_allclose(patch.normal, truth.normal, atol=1e-9)
    assert apart(patch.hull, truth.hull) < 1e-8
    assert abs(patch.area - truth.area) < 1e-8 * truth.area
    assert np.linalg.norm(patch.centroid - middle(truth.hull)) < 1e-8
    assert not {"sliver", "occluded"} & set(interface.flags)


def middle(corners: Float) -> Float:
    """Centroid of a convex polygon in a horizontal plane, by triangles about its first corner."""
    a, b, c = corners[0], corners[1:-1], corners[2:]
    weight = np.cross(b - a, c - a)[:, 2]
    return np.asarray(weight @ (a + b + c) / (3 * weight.sum()))


@FEW
@given(pairs)
def test_swapping_the_bodies_mirrors_the_interface(case: Case) -> None:
    """Action is reaction: the same polygon, the opposite normal."""
    forth, ours = only(case)
    back, theirs = only(case, reverse=True)
    assert back.bodies == forth.bodies[::-1]
    np.testing.assert_allclose(theirs.normal, -ours.normal, atol=1e-12)
    assert apart(theirs.polygon, ours.polygon) < 1e-9
    assert abs(theirs.area - ours.area) < 1e-9 * ours.area
    for patch in (ours, theirs):
        turning = np.cross(patch.polygon, np.roll(patch.polygon, -1, axis=0)).sum(0)
        assert turning @ patch.normal > 0


@FEW
@given(pairs, seeds, st.sampled_from([1e-3, 1.0, 1e3]))
def test_motion_and_scale_carry_the_interface_along(case: Case, seed: int, scale: float) -> None:
    there = case.placed(motion(seed), scale)
    agree(hf.assemble(there.scene(), allow_large=True).interfaces, there, 1e-8 * scale, 1e-8)


@FEW
@given(pairs, st.floats(-0.9e-3, 0.9e-3))
def test_a_gap_or_penetration_within_the_tolerance_keeps_the_patch(case: Case, lift: float) -> None:
    """The polygon stays, half way between the faces, and the bodies are said to touch."""
    lower, upper = case.solids
    raised = Case((lower, Solid("above", upper.shape, frame(z=lift) @ upper.pose)), case.truth)
    (interface,) = hf.assemble(raised.scene(), gap=1e-3).interfaces
    assert interface.status == "touching"
    largest = max(interface.patches, key=lambda p: p.area)
    ((truth,),) = case.truth.values()
    assert apart(largest.hull, truth.hull + lift / 2 * UP) < 1e-8
    assert len(interface.patches) == 1
