"""Bodies that lie flat on each other need no search for edges and corners: the patches are the same without it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from holdfast.base.arrays import Float
from holdfast.contacts import detect
from holdfast.contacts.detect import find_patches
from holdfast.contacts.flush import lie_flat
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Tolerances
from holdfast.scene.body import Body
from holdfast.scene.shapes import Box, Cylinder, Mesh


def body(
    shape: Box | Cylinder | Mesh, at: tuple[float, float, float], turn: Float | None = None, name: str = "one"
) -> Body:
    pose = np.eye(4)
    pose[:3, 3] = at
    pose = pose if turn is None else turn @ pose
    return Body(name, shape, mass=1.0, pose=pose)


def frustum(bottom: float, top: float, height: float) -> Mesh:
    """A square pyramid with its top cut off, centred; edges ``bottom`` and ``top``."""
    corners = [(x, y, z) for z in (-1, 1) for x in (-1, 1) for y in (-1, 1)]
    size = {-1: bottom / 2, 1: top / 2}
    hull = trimesh.convex.convex_hull([(x * size[z], y * size[z], z * height / 2) for x, y, z in corners])
    return Mesh(hull.vertices, hull.faces)


def compared(a: Body, b: Body, monkeypatch: pytest.MonkeyPatch, gap: float = 1e-4) -> bool:
    """Whether edges and corners of a pair are not searched for; checks that the patches are the same if they are."""
    meshes = SearchMesh.of(a), SearchMesh.of(b)
    tolerances = Tolerances(gap, 1.0).between(a, b)
    answers: list[bool] = []

    def noted(*args: Any, **options: Any) -> bool:
        answers.append(lie_flat(*args, **options))
        return answers[-1]

    with monkeypatch.context() as patch:
        patch.setattr(detect, "lie_flat", noted)
        found = find_patches(a, b, *meshes, tolerances)
        patch.setattr(detect, "lie_flat", lambda *_, **__: False)
        whole = find_patches(a, b, *meshes, tolerances)
    assert len(found) == len(whole)
    for one, other in zip(found, whole, strict=True):
        np.testing.assert_array_equal(one.polygon, other.polygon)
        np.testing.assert_array_equal(one.normal, other.normal)
    return answers[-1:] == [True]


def turned(rng: np.random.Generator) -> Float:
    result: Float = trimesh.transformations.random_rotation_matrix(rng.random(3))
    result[:3, 3] = rng.normal(size=3)
    return result


def test_stacked_boxes_in_any_place_and_pose(monkeypatch: pytest.MonkeyPatch) -> None:
    """Flush sides, shared corners and edges that only just overlap among them."""
    rng = np.random.default_rng(4)
    short = 0
    for _ in range(60):
        low, high = rng.choice([0.05, 0.1, 0.2], 3), rng.choice([0.05, 0.1, 0.2], 3)
        reach = (low + high) / 2
        shift = rng.choice([0.0, 0.5, 1.0, -1.0, 0.99, 1.01, float(rng.random())], 2) * np.abs(low - high)[:2] / 2
        if rng.random() < 0.3:
            shift = reach[:2] * rng.choice([1.0, -1.0, 0.999999, 0.5], 2)
        turn = turned(rng)
        one = body(Box(tuple(low)), (0, 0, -low[2] / 2), turn)
        two = body(Box(tuple(high)), (*shift, high[2] / 2), turn, "two")
        short += compared(one, two, monkeypatch)
    assert short > 30


def test_what_is_not_square_or_not_level_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    floor = body(Box((1, 1, 0.1)), (0, 0, -0.05))
    assert compared(floor, body(Box((0.1, 0.1, 0.1)), (0, 0, 0.05), name="b"), monkeypatch)
    tilted = trimesh.transformations.rotation_matrix(np.radians(0.3), (0, 1, 0))
    for shape, height, turn in (
        (frustum(0.1, 0.05, 0.1), 0.05, None),
        (frustum(0.05, 0.1, 0.1), 0.05, None),
        (Box((0.1, 0.1, 0.1)), 0.05, tilted),
        (Box((0.1, 0.1, 0.1)), 0.05 + 5e-5, None),
        (Box((0.1, 0.1, 0.1)), 0.05 - 5e-5, None),
    ):
        assert not compared(floor, body(shape, (0, 0, height), turn, "b"), monkeypatch)


@pytest.mark.parametrize("segments", [5, 24, 400])
def test_stacked_tins_of_any_width(segments: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their sides are smooth edges that stand upright on the plane, whether one rim lies over the other or inside."""
    under = body(Cylinder(0.05, 0.1, segments), (0, 0, -0.05))
    for radius, aside in ((0.05, 0.0), (0.03, 0.0), (0.07, 0.01), (0.05, 0.02), (0.05, 1e-5)):
        assert compared(under, body(Cylinder(radius, 0.06, segments), (aside, 0, 0.03), name="b"), monkeypatch)


def test_a_tin_that_widens_upwards_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    """The smooth edges of its side lean over the floor; so do those of a tin that stands askew."""
    floor = body(Box((1, 1, 0.1)), (0, 0, -0.05))
    tin = Cylinder(0.05, 0.1, 24).surface
    wider = np.array(tin.vertices) * np.where(tin.vertices[:, 2:] > 0, [1.2, 1.2, 1.0], 1.0)
    assert not compared(floor, body(Mesh(wider, tin.faces), (0, 0, 0.05), name="b"), monkeypatch)
    askew = np.array(tin.vertices) + np.where(tin.vertices[:, 2:] > 0, [0.01, 0, 0], 0.0)
    assert not compared(floor, body(Mesh(askew, tin.faces), (0, 0, 0.05), name="b"), monkeypatch)


def test_a_prong_in_the_plane_is_searched_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """One body is a box and, beside it, a pyramid that stands on its point: that corner is no face's."""
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    prong = trimesh.convex.convex_hull([(0.1, 0, -0.05), (0.08, 0.02, 0.05), (0.12, 0.02, 0.05), (0.1, -0.02, 0.05)])
    both = trimesh.util.concatenate([box, prong])
    floor = body(Box((1, 1, 0.1)), (0, 0, -0.05))
    mesh = Body("b", Mesh(both.vertices, both.faces), mass=1.0, pose=body(Box((1, 1, 1)), (0, 0, 0.05)).pose)
    assert not compared(floor, mesh, monkeypatch)
    kinds = [
        len(p.polygon)
        for p in find_patches(floor, mesh, SearchMesh.of(floor), SearchMesh.of(mesh), Tolerances(1e-4, 1.0))
    ]
    assert sorted(kinds) == [1, 4]


def test_small_feet_beside_a_large_face_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tin with a box beside it in one mesh: of both ends in the plane, only the tin's counts as large."""
    tin = Cylinder(0.05, 0.1, 400).surface
    block = trimesh.creation.box((0.02, 0.02, 0.1))
    block.apply_translation((0.08, 0, 0))
    both = trimesh.util.concatenate([trimesh.Trimesh(tin.vertices, tin.faces), block])
    under = body(Cylinder(0.2, 0.1, 400), (0, 0, -0.05))
    over = body(Mesh(both.vertices, both.faces), (0, 0, 0.05), name="b")
    assert compared(under, over, monkeypatch)
    patches = find_patches(under, over, SearchMesh.of(under), SearchMesh.of(over), Tolerances(1e-4, 1.0))
    disc = 200 * 0.05**2 * np.sin(2 * np.pi / 400)
    assert sorted(patch.area for patch in patches) == pytest.approx([4e-4, disc], rel=1e-9)
