"""Round bodies and compounds on plane faces: what is known in closed form is what a search among triangles finds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float
from holdfast.contacts.detect import find_patches
from holdfast.contacts.interface import Patch
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Tolerances
from holdfast.contacts.without_triangles import of_cuboids, of_round
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound, Part
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder, Sphere

GAP = 2e-4


def pose(rng: np.random.Generator) -> Float:
    """The axes of the world, or others, at any place."""
    found = np.eye(4)
    if rng.random() < 0.6:
        found[:3, :3] = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
    found[:3, 3] = rng.normal(size=3)
    return found


def compared(a: Body, b: Body) -> bool | None:
    """Whether the patches of a pair are known without triangles, and there are some; checks that they are the same."""
    tolerances = Tolerances(GAP, 1.0).between(a, b)
    (known,) = of_cuboids([(a, b)], [tolerances])
    known = of_round(a, b, tolerances) if known is None else known
    if known is None:
        return None
    searched = find_patches(a, b, SearchMesh.of(a), SearchMesh.of(b), tolerances)
    assert len(known) == len(searched)
    for one, other in zip(known, searched, strict=True):
        assert (one.kind, one.holes, one.breadth, one.inset) == (other.kind, other.holes, other.breadth, other.inset)
        assert one.separation is not None
        assert other.separation is not None
        np.testing.assert_allclose(one.separation, other.separation, rtol=0, atol=1e-12)
        np.testing.assert_allclose(one.normal, other.normal, rtol=0, atol=1e-12)
        assert apart(one, other) < 1e-9
    return len(known) > 0


def apart(one: Patch, other: Patch) -> float:
    """How far corners are apart; an outline may begin at any of them, a line may not."""
    turns = range(len(one.polygon) if one.kind == "face" else 1)
    return min(float(np.abs(np.roll(one.polygon, k, axis=0) - other.polygon).max()) for k in turns)


def test_a_round_body_lies_on_a_face_where_its_triangles_do() -> None:
    """Balls, capsules and ellipsoids, upright, lying and a little tilted, at, over and in a face, also at its edges."""
    rng, seen = np.random.default_rng(3), list[bool | None]()
    for k in range(150):
        radius = rng.uniform(0.01, 0.08)
        shape = (Sphere(radius), Capsule(radius, rng.uniform(0.02, 0.3)), Ellipsoid(rng.uniform(0.01, 0.08, 3)))[k % 3]
        size, base = np.array([*rng.uniform(0.05, 0.6, 2), rng.uniform(0.05, 0.6)]), pose(rng)
        block = Body("block", Box(size), pose=base, fixed=True)
        if rng.random() < 0.3:
            block, size[2] = Body("block", HalfSpace(), pose=base, fixed=True), 0.0
        lean = rng.choice([np.pi / 2, 0.0, rng.uniform(0, 3)]) + rng.choice([0, 1e-3, 0.02]) * rng.normal()
        placed = np.eye(4)
        placed[:3, :3] = Rotation.from_euler("zyx", [rng.uniform(0, 7), lean, 0]).as_matrix()
        up = placed[2, :3]
        if isinstance(shape, Ellipsoid):
            high = float(np.linalg.norm(up * shape.radii))
        else:
            high = radius + abs(up[2]) * (shape.length / 2 if isinstance(shape, Capsule) else 0.0)
        off = rng.choice([0.0, 1e-5 * rng.normal(), 1e-2 * rng.normal(), rng.uniform(-2, 3) * GAP])
        placed[:3, 3] = [*(rng.uniform(-0.6, 0.6, 2) * size[:2]), size[2] / 2 + high + off]
        body = Body("round", shape, mass=1.0, pose=base @ placed)
        seen += [compared(body, block), compared(block, body)]
    assert seen.count(True) > 60
    assert seen.count(False) > 3, "only the tessellation is within the gap"
    assert seen.count(None) > 60


def test_a_cylinder_stands_on_an_end_where_its_triangles_do() -> None:
    """On boxes, under boxes and on other cylinders, in the middle and over the edge, in one plane and not quite."""
    rng, seen = np.random.default_rng(4), list[bool | None]()

    def shape() -> tuple[Box | Cylinder, float, float]:
        if rng.random() < 0.65:
            radius, height = rng.uniform(0.02, 0.1), rng.uniform(0.01, 0.3)
            return Cylinder(radius, height, int(rng.choice([16, 48, 64, 100]))), height, radius
        size = rng.uniform(0.02, 0.5, 3)
        return Box(size), size[2], size[0] / 2

    for _ in range(60):
        base, placed = pose(rng), np.eye(4)
        (lower, high, wide), (upper, rise, broad) = shape(), shape()
        placed[:3, :3] = Rotation.from_euler("z", rng.uniform(0, 7)).as_matrix()
        off = rng.choice([0, 0, 0, 1e-5]) * rng.normal()
        beside = rng.choice([0, 0.2, 0.5]) * (wide + broad) * rng.normal(size=2)
        placed[:3, 3] = [*beside, (high + rise) / 2 + off]
        turn = np.diag([1.0, -1.0, -1.0, 1.0]) if rng.random() < 0.3 else np.eye(4)
        one = Body("one", lower, pose=base, fixed=True)
        two = Body("two", upper, mass=1.0, pose=base @ placed @ turn)
        seen += [compared(one, two), compared(two, one)]
    assert [seen.count(each) > 20 for each in (True, None)] == [True, True]


def test_of_a_compound_the_box_that_is_near_counts() -> None:
    """Compounds of two or three boxes and tins, some aslant, on boxes and on each other."""
    rng, seen = np.random.default_rng(0), list[bool | None]()

    def compound() -> Compound:
        parts = []
        for _ in range(rng.integers(2, 4)):
            size, place = rng.choice([0.02, 0.05, 0.1, 0.2], 3), np.eye(4)
            place[:3, 3] = rng.choice([-0.1, -0.05, 0, 0.05, 0.1], 3)
            if rng.random() < 0.2:
                place[:3, :3] = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
            parts.append(Part(Box(size) if rng.random() < 0.8 else Cylinder(size[0] / 2, size[1]), place))
        return Compound(parts)

    for _ in range(80):
        upper = compound()
        lower = compound() if rng.random() < 0.4 else Box(rng.choice([0.05, 0.1, 0.3, 1.2], 3))
        base, placed = pose(rng), np.eye(4)
        top, bottom = lower.surface.vertices[:, 2].max(), upper.surface.vertices[:, 2].min()
        placed[:3, 3] = [*rng.choice([0, 0.05, -0.1, 0.2], 2), top - bottom + rng.choice([0, 0, 1e-5, 0.1])]
        one, two = Body("one", lower, pose=base, fixed=True), Body("two", upper, mass=1.0, pose=base @ placed)
        seen += [compared(one, two), compared(two, one)]
    assert [seen.count(each) > 5 for each in (True, False, None)] == [True, True, True]


@pytest.mark.parametrize("thin", [1e-4, 0.05])
def test_what_is_thinner_than_the_gap_is_searched(thin: float) -> None:
    """A coin in a gap has a far side that is near, too."""
    coin = Body("coin", Cylinder(0.02, thin), mass=1.0, position=(0, 0, thin / 2))
    ground = Body("ground", HalfSpace(), fixed=True)
    found = of_round(ground, coin, Tolerances(GAP, 1.0).between(ground, coin))
    assert (found is None) == (thin < GAP)
