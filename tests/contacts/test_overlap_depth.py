"""The depth of an overlap is the way out: the least translation that separates two bodies."""

from __future__ import annotations

import itertools
import warnings

import numpy as np
import pytest
import shapely
import trimesh
from placed import FLOOR
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import holdfast as hf
from holdfast.contacts import overlap
from holdfast.contacts.overlap import find_overlaps
from holdfast.contacts.tolerances import Tolerances

SLAB = hf.Body("slab", hf.Box((1, 1, 0.2)), fixed=True)
SIZE = (0.008, 0.024, 0.116)  # a domino: much thinner than it is deep in what it has sunk into


def depth(one: hf.Body, other: hf.Body, least: float = 1e-4) -> float:
    found = find_overlaps(hf.Scene([one, other], 0.5), Tolerances(least, 1.0))
    return found[0].depth if found else 0.0


def box(size: tuple[float, float, float], x: float = 0, y: float = 0, z: float = 0, **turn: float) -> hf.Body:
    return hf.Body("box", hf.Box(size), mass=1.0, pose=hf.pose(x, y, z, **turn))


@pytest.mark.parametrize("sunk", [0.0002, 0.003, 0.02, 0.058, 0.1])
def test_a_domino_is_as_deep_in_the_floor_as_its_foot(sunk: float) -> None:
    """However thin it is, and whatever its mesh."""
    domino = box(SIZE, z=SIZE[2] / 2 - sunk)
    assert depth(FLOOR, domino) == pytest.approx(sunk, rel=1e-6)
    assert depth(hf.Body("floor", hf.Box((2, 2, 1)), fixed=True, position=(0, 0, -0.5)), domino) == pytest.approx(sunk)
    mesh = hf.Body("box", hf.Mesh(domino.surface_world.vertices, domino.surface_world.faces), mass=1.0)
    assert depth(FLOOR, mesh) == pytest.approx(sunk, rel=1e-6)


@pytest.mark.parametrize("degrees", [5, 30, 45, 80])
def test_a_tilted_box_is_as_deep_as_its_lowest_edge(degrees: float) -> None:
    a = np.radians(degrees)
    low = SIZE[2] / 2 * np.cos(a) + SIZE[0] / 2 * np.sin(a)
    assert depth(FLOOR, box(SIZE, z=low - 0.004, pitch=degrees)) == pytest.approx(0.004, rel=1e-6)


def test_a_small_box_inside_a_large_one_has_to_leave_it_whole() -> None:
    assert depth(SLAB, box((0.02, 0.02, 0.02), z=0.05)) == pytest.approx(0.1 - 0.05 + 0.01, rel=1e-6)
    assert depth(SLAB, box((0.02, 0.02, 0.02), x=0.47, z=0)) == pytest.approx(0.5 - 0.47 + 0.01, rel=1e-6)


def test_a_cylinder_in_a_slab_leaves_by_its_radius_and_half_the_slab() -> None:
    lying = hf.Body("rod", hf.Cylinder(0.03, 0.5), mass=1.0, pose=hf.pose(0, 0, 0.02, pitch=90))
    assert depth(SLAB, lying) == pytest.approx(0.1 - 0.02 + 0.03, rel=5e-3)
    through = hf.Body("rod", hf.Cylinder(0.01, 2.0), mass=1.0, position=(0.45, 0, 0))
    assert depth(SLAB, through) == pytest.approx(0.05 + 0.01, rel=5e-3)
    short = hf.Body("rod", hf.Cylinder(0.01, 0.3), mass=1.0)
    assert depth(SLAB, short) == pytest.approx(0.1 + 0.15, rel=1e-6)
    foil = hf.Body("foil", hf.Box((0.4, 0.4, 5e-5)), fixed=True, pose=hf.pose(pitch=20))
    assert depth(foil, short) > 0.14, "pierced, though it is thinner than a gap"


@pytest.mark.parametrize("seed", range(6))
def test_boxes_in_any_pose_are_apart_after_the_least_distance_of_all_differences(seed: int) -> None:
    """Beside the hull of all differences of their corners, and the same in every frame and order."""
    rng = np.random.default_rng(seed)
    turn, sizes = Rotation.random(random_state=seed).as_matrix(), rng.uniform(0.1, 0.6, (2, 3))
    pose, frame = np.eye(4), np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, 0.1 * rng.normal(size=3)
    one, other = hf.Body("a", hf.Box(sizes[0]), fixed=True), hf.Body("b", hf.Box(sizes[1]), mass=1.0, pose=pose)
    differences = [p - q for p, q in itertools.product(one.surface_world.vertices, other.surface_world.vertices)]
    right = -ConvexHull(np.array(differences)).equations[:, 3].max()
    assert right > 0.01
    assert depth(one, other) == pytest.approx(right, rel=1e-6)
    frame[:3, :3], frame[:3, 3] = Rotation.random(random_state=seed + 50).as_matrix(), rng.normal(size=3)
    assert depth(one.moved(frame @ one.pose), other.moved(frame @ other.pose)) == pytest.approx(right, rel=1e-6)
    assert depth(other, one) == pytest.approx(right, rel=1e-6)


def table(**where: object) -> hf.Body:
    legs = [hf.Part(hf.Box((0.05, 0.05, 0.5)), hf.pose(x, y, 0.25)) for x in (-0.4, 0.4) for y in (-0.4, 0.4)]
    return hf.Body("table", hf.Compound([hf.Part(hf.Box((1, 1, 0.05)), hf.pose(z=0.5)), *legs]), **where)  # type: ignore[arg-type]


def bookends() -> hf.Body:
    sides = [hf.Part(hf.Box((0.02, 0.2, 0.3)), hf.pose(x=x, z=0.15)) for x in (-0.06, 0.06)]
    shape = hf.Compound([hf.Part(hf.Box((0.3, 0.2, 0.02)), hf.pose(z=-0.01)), *sides])
    return hf.Body("ends", shape, fixed=True)


def test_of_bodies_that_are_not_convex_each_place_has_its_own_way_out() -> None:
    """A table whose legs have sunk, a book that is too thick for its bookends or sunk between them."""
    assert depth(FLOOR, table(mass=5.0, position=(0, 0, -0.02))) == pytest.approx(0.02, rel=1e-4)
    tilted = 0.02 + 0.425 * np.sin(np.radians(2))
    assert depth(FLOOR, table(mass=5.0, pose=hf.pose(0, 0, -0.02, pitch=2))) == pytest.approx(tilted, rel=1e-3)
    assert depth(bookends(), box((0.102, 0.18, 0.2), z=0.1)) == pytest.approx(0.001, rel=1e-4)
    assert depth(bookends(), box((0.098, 0.18, 0.2), z=0.096)) == pytest.approx(0.004, rel=1e-4)
    assert depth(table(fixed=True), box(SIZE, 0.1, 0.1, 0.525 + SIZE[2] / 2 - 0.02)) == pytest.approx(0.02, rel=1e-4)


@pytest.mark.parametrize("sunk", [1.1e-4, 1.5e-4, 1e-3, 0.01])
def test_bodies_with_flush_sides_are_as_deep_in_each_other_as_others(sunk: float) -> None:
    """All corners of what equal cubes, or equal trestles, share lie on both surfaces, so that none of them is deep."""
    cube = hf.Body("low", hf.Box((0.1, 0.1, 0.1)), fixed=True)
    assert depth(cube, box((0.1, 0.1, 0.1), z=0.1 - sunk)) == pytest.approx(sunk, rel=1e-2)
    shape = hf.Compound([hf.Part(hf.Box((0.5, 0.1, 0.05)), hf.pose(z=z)) for z in (0.0, 0.3)] + [
        hf.Part(hf.Box((0.05, 0.1, 0.25)), hf.pose(x=x, z=0.15)) for x in (-0.2, 0.2)
    ])  # fmt: skip
    high = hf.Body("high", shape, mass=1.0, position=(0, 0, 0.35 - sunk))
    assert depth(hf.Body("low", shape, fixed=True), high) == pytest.approx(sunk, rel=1e-2)


def test_what_is_found_separates_and_less_does_not() -> None:
    """A domino in a table top leaves upwards by its depth; a rod through it needs half of its length."""
    rod = hf.Body("rod", hf.Cylinder(0.01, 0.5), mass=0.1, position=(0.1, 0.1, 0.525))
    found = depth(table(fixed=True), rod)
    assert found == pytest.approx(0.25, rel=1e-4)
    assert depth(table(fixed=True), rod.moved(hf.pose(0.1, 0.1, 0.525 + 1.0001 * found))) == 0
    assert depth(table(fixed=True), rod.moved(hf.pose(0.1, 0.1, 0.525 + 0.99 * found))) > 0


def test_bodies_that_only_touch_or_are_apart_do_not_overlap() -> None:
    assert depth(FLOOR, box(SIZE, z=SIZE[2] / 2)) == 0
    assert depth(bookends(), box((0.1, 0.18, 0.2), z=0.1)) == 0
    assert depth(bookends(), box((0.1001, 0.18, 0.2), z=0.1)) == 0, "less than the gap on either side"
    assert depth(SLAB, box((0.02, 0.02, 0.02), z=0.2)) == 0


def test_one_depth_is_told_everywhere() -> None:
    """By the warning, the overlap, the verdict and settle."""
    scene = hf.Scene([FLOOR, box(SIZE)], 0.5)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assembly = hf.assemble(scene)
    assert "by 58 mm" in str(caught[0].message)
    assert assembly.overlaps[0].depth == pytest.approx(0.058)
    assert "by 58 mm" in hf.stability(assembly).reason
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert "by 58 mm" in hf.settle(scene).reason


def test_the_way_out_of_a_grain_in_a_rock_takes_no_thousand_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """The grain goes up by .1 m and by its own size into the notch; the hull of the rock knows of .3 m only."""
    tried: list[int] = []
    monkeypatch.setattr(overlap, "_shrunk", lambda solid, old=overlap._shrunk: (tried.append(1), old(solid))[1])
    outline = np.array([[0, 0], [2, 0], [2, 1.4], [1.3, 1.4], [1.3, 0.4], [0.7, 0.4], [0.7, 1.4], [0, 1.4]])
    bent = trimesh.creation.extrude_polygon(shapely.Polygon(outline), 1.0)
    rock = hf.Body("rock", hf.Mesh(bent.vertices, bent.faces), fixed=True)
    grain = hf.Body("grain", hf.Box((2e-4, 2e-4, 2e-4)), mass=1.0, position=(1.0, 0.3, 0.5))
    with pytest.warns(hf.errors.HoldfastWarning):
        (found,) = hf.assemble(hf.Scene([rock, grain], 0.5)).overlaps
    assert found.depth == pytest.approx(0.1001, rel=2e-3)
    assert len(tried) < 1500  # 4,500 in equal steps
