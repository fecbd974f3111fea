"""Many small patches merge into few: what they hold up stays the same, and how far they are off is said."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.base.rigid import transform
from holdfast.contacts.contact_search import find_contacts
from holdfast.contacts.interface import Patch
from holdfast.contacts.merging import merged
from holdfast.contacts.patch_nodes import interface_nodes
from holdfast.geometry.polygon import polynomial_moments

UP = np.array([0.0, 0, 1])
GAP = 1e-3


def tilted(centre: np.ndarray, side: float, normal: np.ndarray) -> Patch:
    """A square of this side about a centre."""
    frame = np.linalg.qr(np.column_stack([normal, np.eye(3)[:, :2]]))[0].T[1:]
    frame = frame if np.cross(*frame) @ normal > 0 else frame[::-1]
    ring = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * side / 2
    return Patch(centre + ring @ frame, normal, separation=(-1e-4, 2e-4))


def slivers(seed: int = 3, count: int = 60) -> list[Patch]:
    """Small squares in a plane, of different sizes, with heights and normals that are a little off."""
    rng = np.random.default_rng(seed)
    found = []
    for x, y in rng.uniform(-0.05, 0.05, (count, 2)):
        normal = np.append(rng.normal(0, 1e-3, 2), 1.0)
        centre = np.array([x, y, rng.uniform(-1, 1) * GAP / 10])
        found.append(tilted(centre, rng.uniform(1e-3, 3e-3), normal / np.linalg.norm(normal)))
    return found


def test_an_uneven_support_keeps_area_pressure_centre_second_moments_and_hull() -> None:
    patches = slivers()
    (one,) = merged(patches, GAP, 1.0)
    assert one.spots is not None
    assert not one.spots.bent
    areas = np.array([p.area for p in patches])
    assert one.area == pytest.approx(areas.sum(), rel=1e-12)
    flat = (np.eye(3) - np.outer(one.normal, one.normal)) @ (areas @ [p.centroid for p in patches] / areas.sum())
    np.testing.assert_allclose((np.eye(3) - np.outer(one.normal, one.normal)) @ one.centroid, flat, atol=1e-9)
    exact = np.zeros(6)
    for p in patches:
        ring = (p.polygon - one.polygon[0]) @ one.frame.T
        raw = polynomial_moments([ring])
        exact += raw * p.area / raw[0]
    np.testing.assert_allclose(one.moments, exact, rtol=1e-9)
    corners = np.vstack([p.polygon for p in patches])
    nearest = np.linalg.norm(one.polygon[:, None] - corners, axis=2).min(1)
    assert nearest.max() <= one.spots.residual + 1e-12  # every corner is one of theirs, moved onto the plane
    seen = (corners - one.polygon[0]) @ one.frame.T
    ring = one.rings[0]
    edge = np.roll(ring, -1, axis=0) - ring
    inward = np.column_stack([-edge[:, 1], edge[:, 0]]) / np.linalg.norm(edge, axis=1)[:, None]
    assert ((seen[:, None] - ring) * inward).sum(-1).min() > -1e-9  # and none lies outside


def test_lines_merge_into_a_support_with_their_second_moments() -> None:
    """Beside sums over 2,000 places on each line."""
    rng = np.random.default_rng(7)
    ends = rng.uniform(-0.05, 0.05, (20, 2, 2))
    lines = [Patch(np.column_stack([pair, np.zeros(2)]), UP, breadth=1e-4) for pair in ends]
    (one,) = merged(lines, GAP, 1.0)
    assert one.spots is not None
    steps = (np.arange(2000) + 0.5) / 2000
    exact = np.zeros(6)
    for pair, line in zip(ends, lines, strict=True):
        places = pair[0] + steps[:, None] * (pair[1] - pair[0])
        x, y = ((np.column_stack([places, np.zeros(2000)]) - one.polygon[0]) @ one.frame.T).T
        exact += np.array([np.ones_like(x), x, y, x * x, x * y, y * y]).mean(axis=1) * line.length * 1e-4
    np.testing.assert_allclose(one.moments, exact, rtol=1e-6)


def test_residual_and_spread_are_those_of_the_patches() -> None:
    patches = slivers()
    (one,) = merged(patches, GAP, 1.0)
    assert one.spots is not None
    corners = np.vstack([p.polygon for p in patches])
    assert one.spots.residual == pytest.approx(np.ptp(corners @ one.normal) / 2, rel=0.3)
    assert one.spots.residual <= GAP / 2
    angles = np.degrees(np.arccos([p.normal @ one.normal for p in patches]))
    assert one.spots.spread == pytest.approx(angles.max(), rel=1e-6)
    assert one.separation == (-1e-4, 2e-4)


@pytest.mark.parametrize("sampling", ["hull", "quadrature"])
@pytest.mark.parametrize("count", [20, 49, 400])
def test_nodes_of_an_uneven_support_are_its_spots_with_its_moments(sampling: str, count: int) -> None:
    (one,) = merged(slivers(), GAP, 1.0)
    assert one.spots is not None
    ((points, weights),) = interface_nodes(hf.answers.Interface(("a", "b"), patches=[one]), count, sampling)
    places = np.vstack([one.spots.points, one.polygon])
    assert np.linalg.norm(points[:, None] - places, axis=2).min(1).max() < 1e-9
    x, y = ((points - one.polygon[0]) @ one.frame.T).T
    moments = np.array([np.ones_like(x), x, y, x * x, x * y, y * y]) @ weights
    np.testing.assert_allclose(moments, one.moments, rtol=1e-6)


def test_patches_further_from_the_plane_or_more_inclined_stay_out() -> None:
    high = tilted(np.array([0.0, 0, GAP]), 2e-3, UP)
    steep = np.array([np.sin(np.radians(3)), 0, np.cos(np.radians(3))])
    found = merged([*slivers(), high, tilted(np.zeros(3), 2e-3, steep)], GAP, 1.0)
    assert sorted(p.spots is not None for p in found) == [False, False, True]


def test_few_patches_and_broad_faces_are_left_as_they_are() -> None:
    few = slivers(count=8)
    assert all(a is b for a, b in zip(merged(few, GAP, 1.0), few, strict=True))
    feet = [tilted(np.array([0.1 * x, 0.1 * y, 0.0]), 0.05, UP) for x in range(4) for y in range(5)]
    assert all(a is b for a, b in zip(merged(feet, GAP, 1.0), feet, strict=True))


def cap(angle: float, radius: float, rings: int) -> list[Patch]:
    """Triangles of a spherical bowl, up to an angle from its lowest point, with normals to its centre."""
    theta = np.linspace(0, angle, rings + 1)[1:]
    rows = [np.array([[0.0, 0, -radius]])]
    around = 6 * rings
    for t in theta:
        phi = 2 * np.pi * np.arange(around) / around
        rows.append(
            radius * np.column_stack([np.sin(t) * np.cos(phi), np.sin(t) * np.sin(phi), np.full(around, -np.cos(t))])
        )
    triangles = []
    for k in range(around):
        m = (k + 1) % around
        triangles.append([rows[0][0], rows[1][k], rows[1][m]])
        for lower, upper in itertools.pairwise(rows[1:]):
            triangles += [[lower[k], upper[k], upper[m]], [lower[k], upper[m], lower[m]]]
    found = []
    for corners in np.array(triangles):
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal /= np.linalg.norm(normal)
        assert normal @ corners.mean(0) < 0
        found.append(Patch(corners, normal))
    return found


def test_a_sphere_in_a_bowl_of_its_radius_is_a_band_with_area_centroid_and_resultant_of_the_cap() -> None:
    angle, radius = np.radians(50), 0.1
    patches = cap(angle, radius, 16)
    (one,) = merged(patches, GAP / 10, 1.0)
    spots = one.spots
    assert spots is not None
    assert spots.bent
    assert len(spots.points) <= 128
    area = 2 * np.pi * radius**2 * (1 - np.cos(angle))
    assert one.area == pytest.approx(area, rel=3e-3)
    assert spots.shares.sum() == pytest.approx(one.area, rel=1e-9)
    np.testing.assert_allclose(one.centroid, [0, 0, -radius * (1 + np.cos(angle)) / 2], atol=3e-3 * radius)
    np.testing.assert_allclose(
        spots.shares @ spots.normals, [0, 0, np.pi * (radius * np.sin(angle)) ** 2], atol=3e-3 * area
    )
    np.testing.assert_allclose(spots.shares @ np.cross(spots.points, spots.normals), 0, atol=1e-4 * area * radius)
    on = np.linalg.norm(spots.points, axis=1)
    assert on.max() <= radius * (1 + 1e-9)
    assert on.min() > 0.99 * radius
    inward = (spots.normals * -spots.points).sum(1) / on
    assert inward.min() > np.cos(np.radians(6))
    assert 0 < spots.spread < 25
    for count in (20, 49):
        ((points, weights),) = interface_nodes(hf.answers.Interface(("a", "b"), patches=[one]), count, "quadrature")
        normals = one.normals_at(points)
        assert weights.sum() == pytest.approx(one.area, rel=1e-6)
        np.testing.assert_allclose(weights @ normals, spots.shares @ spots.normals, atol=1e-6 * area)


def test_short_lines_round_a_peg_are_carried_along_their_length_and_not_by_their_middles() -> None:
    radius, length, count = 0.05, 4e-3, 40
    ways = np.array([[np.cos(t), np.sin(t), 0] for t in 2 * np.pi * np.arange(count) / count])
    ends = np.array([[0, 0, -length / 2], [0, 0, length / 2]])
    (one,) = merged([Patch(radius * way + ends, -way, breadth=1e-4) for way in ways], GAP / 10, 1.0)
    assert one.spots is not None
    assert one.spots.bent
    second = one.spots.shares @ one.spots.points[:, 2] ** 2  # a uniform line: length² / 12 of its measure
    assert second == pytest.approx(one.measure * length**2 / 12, rel=0.05)


def wavy(levels: int, pose: np.ndarray | None = None) -> hf.Scene:
    """A plate with waves 2 mm high under it, finely cut, on a flat floor that 9 crests touch."""
    across = 3 * 8 * levels + 1
    grid = np.linspace(0, 0.06, across)
    x, y = (part.ravel() for part in np.meshgrid(grid, grid, indexing="ij"))
    height = 1e-3 * (2 - np.cos(2 * np.pi * (x / 0.02 + 0.5)) - np.cos(2 * np.pi * (y / 0.02 + 0.5))) / 2
    bottom = np.column_stack([x, y, height])
    top = bottom * [1, 1, 0] + [0, 0, 0.02]
    k = np.arange((across - 1) * across).reshape(-1, across)[:, :-1].ravel()
    down = np.vstack([np.column_stack([k, k + 1, k + across]), np.column_stack([k + 1, k + across + 1, k + across])])
    n = across**2
    shell = [down, down[:, ::-1] + n]
    edge = np.arange(across)
    rims = (edge, edge[::-1] * across, (across - 1) * across + edge[::-1], edge * across + across - 1)
    for rim in rims:
        a, b = rim[:-1], rim[1:]
        shell += [np.column_stack([a, b, b + n]), np.column_stack([a, b + n, a + n])]
    solid = trimesh.Trimesh(np.vstack([bottom, top]), np.vstack(shell), process=False)
    trimesh.repair.fix_normals(solid)
    pose = np.eye(4) if pose is None else pose
    plate = hf.Body("plate", hf.Mesh(solid.vertices, solid.faces), mass=1.0, pose=pose)
    base = np.eye(4)
    base[:3, 3] = 0.03, 0.03, -0.05
    floor = hf.Body("floor", hf.Box((0.3, 0.3, 0.1)), pose=pose @ base, fixed=True)
    return hf.Scene([floor, plate], 0.5, gravity=pose[:3, :3] @ [0, 0, -9.81])


def found(scene: hf.Scene) -> hf.answers.Interface:
    (interface,) = hf.assemble(scene, gap=2e-4, angle_degrees=3).interfaces
    return interface


def test_a_wavy_plate_stands_on_its_crests_as_one_uneven_support() -> None:
    interface = found(wavy(2))
    assert "merged" in interface.flags
    (one,) = interface.patches
    np.testing.assert_allclose(one.centroid[:2], [0.03, 0.03], atol=2e-5)
    np.testing.assert_allclose(np.abs(one.normal), UP, atol=1e-4)
    corners = one.hull[:, :2]
    assert corners.min() == pytest.approx(0.01, abs=2e-3)
    assert corners.max() == pytest.approx(0.05, abs=2e-3)
    raw = find_contacts(wavy(2), hf.assemble(wavy(2), gap=2e-4, angle_degrees=3).tolerances, merge=False).interfaces[0]
    assert len(raw.patches) >= 9
    assert interface.area == pytest.approx(raw.area, rel=1e-9)


def tipping(scene: hf.Scene) -> float:
    """The push at the plate's top, along x, that slides or tips it."""
    assembly = hf.assemble(scene, gap=2e-4, angle_degrees=3)
    pose = scene.body("plate").pose
    point, along = transform(pose, np.array([[0.0, 0.03, 0.01]]))[0], pose[:3, 0]
    return hf.robustness(assembly, "plate", point, along, engine="limit").force[0]


def test_merged_contacts_answer_as_the_crests_do_wherever_they_are() -> None:
    here = tipping(wavy(2))
    assert here == pytest.approx(0.5 * 9.81, rel=1e-3)  # it slides
    rng = np.random.default_rng(5)
    pose = np.eye(4)
    pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    pose[:3, 0] *= np.linalg.det(pose[:3, :3])
    pose[:3, 3] = rng.normal(size=3)
    assert tipping(wavy(2, pose)) == pytest.approx(here, rel=1e-3)
    assert tipping(wavy(3)) == pytest.approx(here, rel=5e-3)


def test_a_merged_contact_seen_from_the_other_body_is_the_same() -> None:
    for one in (*merged(slivers(), GAP, 1.0), *merged(cap(0.9, 0.1, 12), GAP / 10, 1.0)):
        other = one.flipped()
        assert one.spots is not None
        assert other.spots is not None
        np.testing.assert_array_equal(other.spots.points, one.spots.points)
        np.testing.assert_array_equal(other.spots.normals, -one.spots.normals)
        np.testing.assert_allclose(other.centroid, one.centroid, atol=1e-12)
        np.testing.assert_array_equal(other.flipped().polygon, one.polygon)


def test_order_of_the_bodies_changes_nothing() -> None:
    scene = wavy(2)
    turned = replace(scene, bodies=scene.bodies[::-1])
    assert tipping(turned) == pytest.approx(tipping(scene), rel=1e-6)
    a, b = found(scene), found(turned)
    assert a.area == pytest.approx(b.area, rel=1e-9)


def test_bent_contacts_have_the_normals_of_their_spots() -> None:
    (one,) = merged(cap(0.9, 0.1, 12), GAP / 10, 1.0)
    base, ball = (hf.Body(n, hf.Sphere(0.1), mass=1.0, fixed=n == "base") for n in ("base", "ball"))
    assembly = hf.assemble(
        hf.Scene([base, ball], 0.5), interfaces=[hf.answers.Interface(("base", "ball"), patches=[one])]
    )
    nodes = contact_nodes(assembly, 49, "quadrature")
    assert np.linalg.matrix_rank(nodes.normals) == 3
    inward = -(nodes.normals * nodes.points).sum(1) / np.linalg.norm(nodes.points, axis=1)
    assert inward.min() > np.cos(np.radians(6))
    corners = contact_nodes(assembly, 49, "corners")
    assert 49 < len(corners) <= 64
