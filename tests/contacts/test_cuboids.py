"""Contacts of cuboids in closed form are those that the search through triangles finds."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from holdfast.base.arrays import Float
from holdfast.contacts.detect import find_patches
from holdfast.contacts.interface import Patch
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Tolerances
from holdfast.contacts.without_triangles import Cuboids, patches_of
from holdfast.native import core
from holdfast.scene.body import Body
from holdfast.scene.shapes import Box

GAP = 1e-4
UNMOVED = np.eye(4)


def box(size: Float, at: Float, yaw: float, world: Float, name: str) -> Body:
    pose = trimesh.transformations.rotation_matrix(yaw, (0, 0, 1))
    pose[:3, 3] = at
    return Body(name, Box(size), mass=1.0, pose=world @ pose)


def directly(a: Body, b: Body, gap: float = GAP) -> tuple[Patch, ...] | None:
    assert a.cuboid is not None
    assert b.cuboid is not None
    own, size = Tolerances(gap, 1.0).between(a, b), min(a.size, b.size)
    return patches_of([Cuboids(a.cuboid, b.cuboid, own.gap, size, 1e-6 * size)])[0]


def through_triangles(a: Body, b: Body, gap: float = GAP) -> tuple[Patch, ...]:
    return find_patches(a, b, SearchMesh.of(a), SearchMesh.of(b), Tolerances(gap, 1.0).between(a, b))


def assert_same(one: Patch, other: Patch) -> None:
    """The same corners in the same sense, whichever is the first one."""
    assert len(one.polygon) == len(other.polygon)
    apart = [np.abs(np.roll(one.polygon, k, axis=0) - other.polygon).max() for k in range(len(one.polygon))]
    assert min(apart) < 1e-12
    np.testing.assert_allclose(one.normal, other.normal, atol=1e-12)
    assert one.separation is not None
    np.testing.assert_allclose(one.separation, other.separation, atol=1e-12)


def anywhere(rng: np.random.Generator) -> Float:
    world: Float = trimesh.transformations.random_rotation_matrix(rng.random(3))
    world[:3, 3] = rng.normal(size=3)
    return world


def pair(rng: np.random.Generator) -> tuple[Body, Body]:
    """Two boxes one on the other or side by side, flush or not quite, straight or turned about the upright axis."""
    low, high = rng.choice([0.05, 0.1, 0.2, 0.31], (2, 3))
    reach = (low + high) / 2
    at = np.array([rng.choice([0.0, 0.3, 1.0, -1.0, 0.9999, 1 + 1e-9, 1.004]) * reach[k] for k in range(3)])
    at[2] = reach[2] + rng.choice([0.0, 0.0, 0.0, 5e-5, -5e-5, 2e-4, -2e-3])
    world = anywhere(rng)
    yaw = rng.choice([0.0, 0.0, np.pi / 2, 0.4, 2e-3])
    names = rng.permutation(["one", "two"])
    return box(low, np.zeros(3), 0.0, world, names[0]), box(high, at, yaw, world, names[1])


def test_what_is_told_at_once_is_what_triangles_tell() -> None:
    """Boxes flush, beside each other, corner to corner, a little apart and a little into each other."""
    rng = np.random.default_rng(17)
    told = {"apart": 0, "flush": 0, "left to triangles": 0}
    for _ in range(600):
        a, b = pair(rng)
        found = directly(a, b)
        if found is None:
            told["left to triangles"] += 1
            continue
        told["flush" if found else "apart"] += 1
        expected = through_triangles(a, b)
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert_same(one, other)
    assert min(told.values()) > 60, told


@pytest.mark.parametrize("thickness", [5e-5, 1.5e-4])
def test_a_sheet_thinner_than_the_gap_is_left_to_triangles(thickness: float) -> None:
    """Its far face is within the gap, too."""
    a = box(np.full(3, 0.1), np.zeros(3), 0.0, UNMOVED, "a")
    b = box(np.array([0.1, 0.1, thickness]), np.array([0, 0, 0.05 + thickness / 2]), 0.0, UNMOVED, "b")
    assert a.cuboid is not None
    assert b.cuboid is not None
    (found,) = patches_of([Cuboids(a.cuboid, b.cuboid, GAP, 0.1, 1e-7)])
    assert (found is None) == (thickness < GAP)


@pytest.mark.parametrize("seed", range(10))
def test_bodies_near_each_other_are_those_whose_boxes_are(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = rng.uniform(0, 1, (40, 3))
    boxes = np.stack([low, low + rng.uniform(0.02, 0.2, (40, 3)) * np.where(np.arange(40) < 3, 9, 1)[:, None]], axis=1)
    fixed, asked, gap = rng.random(40) < 0.3, rng.random(40) < 0.7, 0.05
    overlap = np.minimum(boxes[:, None, 1], boxes[:, 1]) - np.maximum(boxes[:, None, 0], boxes[:, 0])
    near = (overlap.min(2) >= -gap) & ~(fixed[:, None] & fixed) & (asked[:, None] | asked)
    expected = np.argwhere(np.triu(near, 1))
    pairs, shared = core.near_bodies(boxes, fixed, asked, gap)
    np.testing.assert_array_equal(pairs, expected)
    np.testing.assert_array_equal(shared, overlap.min(2)[tuple(expected.T)])
    assert len(pairs) > 20
