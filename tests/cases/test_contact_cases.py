"""Contacts of the published and settled cases: every known one is found, and none is made up."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
import shared
import trimesh
from scipy.spatial import cKDTree

import holdfast as hf
from holdfast.base.arrays import Float
from holdfast.base.rigid import pose_from
from holdfast.contacts.contact_search import find_contacts

# the overlaps of these cases are known, and said to be there by their own README
pytestmark = [shared.needed, pytest.mark.filterwarnings("ignore::holdfast.errors.HoldfastWarning")]


# --- published --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Difference:
    """What a published case needs other than the default tolerances, what then still differs, and why.

    ``normal`` [deg]: of each published polygon a ``share`` is covered by patches with normals this close to its own.
    """

    reason: str
    gap: float | None = None
    angle: float | None = None
    area: float = 0.01
    normal: float = 0.5
    share: float = 0.99


DIFFERENT = {
    "cube_curve_short": Difference(
        "Its faces are warped, and the two blocks' triangles are cut along different diagonals: 1 degree loses 30 % of "
        "the area, 3 degrees nothing. Patches that may bend by 5 degrees span several of its faces, up to 8 degrees "
        "from the polygons on them; summed over the patches the difference is gone.",
        angle=5,
        area=1e-5,
        normal=8.0,
        share=0.97,
    ),
    "armadillo": Difference(
        "Corners leave the plane of its faces by up to 16 mm, so that surfaces cut along different diagonals gape and "
        "overlap: 50 mm and 25 degrees take in all. The published normals are not those of the faces, but up to 7.6 "
        "degrees off the mean of the two that touch; seen along them areas differ too.",
        gap=0.05,
        angle=25,
        normal=7.7,
        share=0.98,
    ),
}
NONE = Difference("")


@functools.cache
def ours(path: Path) -> hf.answers.Assembly:
    """The case assembled by our own detection, at the tolerances that it needs; patches as found, none merged."""
    difference = DIFFERENT.get(path.stem, NONE)
    assembly = hf.assemble(hf.load_scene(path), gap=difference.gap, angle_degrees=difference.angle)
    if not any("merged" in interface.flags for interface in assembly.interfaces):
        return assembly
    found = find_contacts(assembly.scene, assembly.tolerances, merge=False)
    return dataclasses.replace(assembly, interfaces=found.interfaces)


def given(path: Path) -> dict[frozenset[str], list[hf.answers.Interface]]:
    """The polygons of a published case by pair, one an interface."""
    found: dict[frozenset[str], list[hf.answers.Interface]] = {}
    for item in shared.contents(path)["interfaces"]:
        interface = hf.answers.Interface(tuple(item["between"]), item["polygon"], item["normal"])
        found.setdefault(frozenset(interface.bodies), []).append(interface)
    return found


def by_pair(assembly: hf.answers.Assembly) -> dict[frozenset[str], hf.answers.Interface]:
    found = {frozenset(i.bodies): i for i in assembly.interfaces}
    assert len(found) == len(assembly.interfaces)
    return found


def degrees(one: Float, two: Float) -> float:
    cosine = one @ two / np.linalg.norm(one) / np.linalg.norm(two)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def covered(polygon: hf.answers.Interface, interface: hf.answers.Interface, within: float, gap: float) -> float:
    """The share of a published polygon that lies on patches with its normal up to ``within`` [deg]."""
    (wanted,) = polygon.patches
    sense = 1 if polygon.bodies == interface.bodies else -1
    shapes = []
    for patch in interface.patches:
        height = (wanted.polygon - patch.polygon[0]) @ patch.normal
        if patch.kind == "face" and degrees(sense * patch.normal, wanted.normal) < within and abs(height).min() < gap:
            outline, *holes = ((ring - wanted.polygon[0]) @ wanted.frame.T for ring in (patch.polygon, *patch.holes))
            shapes.append(shapely.Polygon(outline, holes))
    whole = shapely.Polygon(wanted.rings[0])
    return float(whole.intersection(shapely.union_all(shapes)).area / whole.area)


@pytest.mark.parametrize("path", shared.paths("published"))
def test_every_published_interface_is_found(path: Path) -> None:
    """The same pairs, areas within 1 %, and every polygon of them covered by patches within 0.5 degrees."""
    difference = DIFFERENT.get(path.stem, NONE)
    assembly, published = ours(path), given(path)
    found = by_pair(assembly)
    assert set(found) == set(published)
    for pair, polygons in published.items():
        area = sum(p.area for p in polygons)
        assert found[pair].area == pytest.approx(area, rel=difference.area), pair
        for polygon in polygons:
            share = covered(polygon, found[pair], difference.normal, assembly.tolerances.gap)
            assert share > difference.share, (polygon.bodies, share)


@pytest.mark.parametrize("path", [p for p in shared.paths("published") if p.id not in DIFFERENT])
def test_published_areas_and_normals_agree_to_the_digits_of_the_files(path: Path) -> None:
    found = by_pair(ours(path))
    for pair, polygons in given(path).items():
        assert found[pair].area == pytest.approx(sum(p.area for p in polygons), rel=1e-7)
        assert min(covered(p, found[pair], 1e-3, 1e-6) for p in polygons) > 1 - 1e-5


def case(name: str) -> Path:
    (path,) = (p.values[0] for p in shared.paths("published") if p.id == name)
    return path


def directed(patches: list[hf.answers.Interface] | tuple[hf.answers.Interface, ...], first: str) -> Float:
    """Areas times normals, summed: the same for all surfaces with one rim. Normals away from the body ``first``."""
    return np.asarray(
        sum((p.area * p.normal * (1 if i.bodies[0] == first else -1) for i in patches for p in i.patches), np.zeros(3))
    )


def test_the_warped_cube_presses_alike_where_its_patches_are_merged() -> None:
    path = case("cube_curve_short")
    ((pair, polygons),) = given(path).items()
    first = min(pair)
    (merged,) = hf.assemble(hf.load_scene(path), angle_degrees=5).interfaces
    assert "merged" in merged.flags
    sense = 1 if merged.bodies[0] == first else -1
    found = sense * sum(patch.spots.shares @ patch.spots.normals for patch in merged.patches)
    np.testing.assert_allclose(found, directed(polygons, first), atol=2e-3 * merged.area)


def test_the_warped_cube_agrees_in_sum_and_loses_area_at_one_degree() -> None:
    path = case("cube_curve_short")
    ((pair, polygons),) = given(path).items()
    first = min(pair)
    wanted, found = directed(polygons, first), directed(ours(path).interfaces, first)
    assert degrees(found, wanted) < 1e-3
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(wanted), rel=3e-5)
    scene, area = hf.load_scene(path), sum(p.area for p in polygons)
    (strict,) = hf.assemble(scene).interfaces
    assert strict.area / area == pytest.approx(0.703, abs=0.002)
    assert "ambiguous_gap" in strict.flags
    (loose,) = hf.assemble(scene, angle_degrees=3).interfaces
    assert loose.area == pytest.approx(area, rel=3e-4)


def face_normals(block: dict[str, Any]) -> Float:
    """(F, 3) unit normals of the polygons of a block, by their area vectors."""
    corners = [np.array(block["vertices"])[face] for face in block["faces"]]
    vectors = np.array([np.cross(c - c[0], np.roll(c, -1, axis=0) - c[0]).sum(0) for c in corners])
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def test_the_armadillos_normals_are_nearer_to_its_blocks_than_the_published_ones() -> None:
    """98 % of ours within half a degree of the mean of the two faces that touch, all within 1.6; of theirs 57 %."""
    path = case("armadillo")
    normals = {str(block["name"]): face_normals(block) for block in shared.contents(path)["blocks"]}
    found = by_pair(ours(path))
    off = []
    for pair, (polygon,) in given(path).items():
        a, b = polygon.bodies
        theirs = polygon.patches[0].normal
        mean = normals[a][np.argmax(normals[a] @ theirs)] - normals[b][np.argmin(normals[b] @ theirs)]
        off.append((degrees(directed((found[pair],), a), mean), degrees(theirs, mean)))
    our, their = np.array(off).T
    assert our.max() < 1.6
    assert (our < 0.5).mean() > 0.98
    assert their.max() > 7.5
    assert (their < 0.5).mean() < 0.57


@pytest.mark.parametrize("engine", [pytest.param("graph", marks=pytest.mark.slow), "limit"])
def test_the_armadillo_stands_on_our_interfaces_at_the_tolerance_its_data_needs(engine: str) -> None:
    """Its blocks have warped faces and overlap by up to 30 mm: at 50 mm and 20 degrees all its contacts are found."""
    path = case("armadillo")
    assembly = hf.assemble(hf.load_scene(path), gap=0.05, angle_degrees=20)
    assert set(by_pair(assembly)) == set(given(path))
    assert hf.stability(assembly, engine=engine).equilibrium_exists is True


# --- settled ----------------------------------------------------------------------------------------------------------

FOUND_AT = {  # [m] the smallest round tolerance at which all pairs of a scene are found
    "beam_frame": 1.5e-3,
    "dishes": 2.5e-3,
    "jenga12": 5e-5,
    "kitchen_place": 2.5e-3,
    "lack_table": 5e-4,
    "leaning": 8e-4,
}
FAR = 5e-3  # [m]
SPACING = 1.5e-3  # [m] between the samples of a surface


def settled() -> list[Any]:
    return [p for p in shared.paths("settled") if p.id in (*FOUND_AT, "absent")]


def touching(data: dict[str, Any]) -> set[frozenset[str]]:
    """The pairs that the physics engine had in contact; its fixed world is the table."""
    return {frozenset("table" if n == "world" else n for n in pair) for pair in data["settling"]["pairs"]}


def measured(data: dict[str, Any]) -> dict[frozenset[str], float]:
    """Distances of pairs that its author measured [m], negative where they overlap."""
    return {frozenset(k.split("|")): v * 1e-3 for k, v in data["original_mesh_gap_mm"].items()}


scene_of = functools.cache(hf.load_scene)


def found_in(scene: hf.Scene, gap: float) -> frozenset[frozenset[str]]:
    return frozenset(frozenset(i.bodies) for i in hf.assemble(scene, gap=gap, angle_degrees=1).interfaces)


@functools.cache
def pairs_at(path: Path, gap: float) -> frozenset[frozenset[str]]:
    return found_in(scene_of(path), gap)


def alone(scene: hf.Scene, pair: frozenset[str]) -> hf.Scene:
    """Two of its bodies where they are, and far below them the fixed one that a scene needs."""
    ground = hf.Body(
        "ground", hf.Box((1, 1, 1)), pose=pose_from(np.array([0, 0, -10]), np.array([1, 0, 0, 0])), fixed=True
    )
    return hf.Scene([ground, *(body for body in scene.bodies if body.name in pair)], 0.5)


@pytest.mark.parametrize("path", settled())
def test_all_touching_pairs_of_settled_scenes_are_found(path: Path) -> None:
    """At the scene's own tolerance and at 3 mm for all, within 1 degree; a smaller one of the series misses some."""
    wanted = touching(shared.contents(path))
    assert pairs_at(path, FOUND_AT[path.stem]) >= wanted
    assert pairs_at(path, 3e-3) >= wanted
    if path.stem != "jenga12":
        assert not pairs_at(path, 0.8 * FOUND_AT[path.stem]) >= wanted


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["alone", "in its scene"])
@pytest.mark.parametrize("path", settled())
def test_a_pair_is_found_when_the_tolerance_reaches_its_distance_and_not_before(path: Path, whole: bool) -> None:
    """Its author's distances, to 1 %: jenga12's neighbours in a layer at 0.5 mm among them.

    One bowl in another is found up to 2 % early: beyond a smooth edge heights are over the plane of the face beside it.
    """
    known = measured(shared.contents(path))
    early = {frozenset(("b0", "b1")): 0.98} if path.stem == "dishes" else {}
    for pair, distance in known.items():
        if distance > 1e-5:
            scene = scene_of(path) if whole else alone(scene_of(path), pair)
            assert pair not in found_in(scene, early.get(pair, 0.99) * distance)
            assert pair in found_in(scene, 1.01 * distance)


def samples(mesh: trimesh.Trimesh, low: Float, high: Float) -> Iterator[Float]:
    """Points (n, 3) on the triangles that reach into a box, nowhere further than SPACING apart along an edge."""
    corners = mesh.triangles
    corners = corners[((corners.max(1) >= low) & (corners.min(1) <= high)).all(1)]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(1, initial=0)
    counts = np.ceil(longest / SPACING).astype(int).clip(1)
    for count in np.unique(counts):
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        i, j = i[i + j <= count], j[i + j <= count]
        weights = np.column_stack([i, j, count - i - j]) / count
        for part in np.array_split(corners[counts == count], 1 + len(weights) * (counts == count).sum() // 1_000_000):
            points = (weights @ part).reshape(-1, 3)
            yield points[((points >= low - SPACING) & (points <= high + SPACING)).all(1)]


def sampled_distance(one: trimesh.Trimesh, two: trimesh.Trimesh) -> float:
    """Between samples of two surfaces [m]; infinite where their boxes are FAR apart.

    At most 2 SPACING / sqrt(3) more than the distance: so far from a sample may the nearest point be on either surface.
    """
    low, high = np.maximum(one.bounds[0], two.bounds[0]), np.minimum(one.bounds[1], two.bounds[1])
    if np.linalg.norm((low - high).clip(0)) >= FAR:
        return np.inf
    low, high = np.minimum(low, high) - 2 * FAR, np.maximum(low, high) + 2 * FAR
    a, b = (np.concatenate([np.zeros((0, 3)), *samples(m, low, high)]) for m in (one, two))
    if not len(a) or not len(b):
        return np.inf
    return float(cKDTree(a).query(b, distance_upper_bound=2 * FAR)[0].min())


def placed(path: Path) -> dict[str, trimesh.Trimesh]:
    """The meshes of a settled scene in the world, read without any of our own code."""
    found = {}
    for item in shared.contents(path)["objects"]:
        mesh = trimesh.load_mesh(path.parent / item["mesh"], process=False)
        mesh.vertices = np.array(mesh.vertices) * item["scale"]
        found[str(item["name"])] = mesh.apply_transform(np.array(item["pose"]))
    return found


@pytest.mark.parametrize("path", settled())
def test_nothing_is_found_between_bodies_that_are_five_millimetres_apart(path: Path) -> None:
    """At 3 mm; distances between samples of the surfaces, never less than the true ones, agree with the author's."""
    meshes, known = placed(path), measured(shared.contents(path))
    found = pairs_at(path, 3e-3)
    slack = 2 * SPACING / np.sqrt(3)
    for a, b in itertools.combinations(meshes, 2):
        pair = frozenset((a, b))
        distance = sampled_distance(meshes[a], meshes[b])
        if pair in found:
            assert distance < min(FAR, 3e-3 + slack)
        if pair in known:
            assert max(known[pair], 0) - 1e-6 < distance < max(known[pair], 0) + slack


@pytest.mark.parametrize(("name", "interfaces"), [("masonry_wall", 60), ("masonry_crossvault", 464)])
def test_masonry_as_designed_touches_with_faces(name: str, interfaces: int) -> None:
    """At the default tolerances, whatever the blocks' faces are."""
    (path,) = [p.values[0] for p in shared.paths("settled") if p.id in (name, "absent")]
    assembly = hf.assemble(hf.load_scene(path))
    assert len(assembly.interfaces) == interfaces
    assert {p.kind for i in assembly.interfaces for p in i.patches} == {"face"}
    assert not assembly.overlaps
    assert not assembly.hanging
