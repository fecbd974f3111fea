"""What the core says of corners that a surface needs, against the simplification by manifold3d."""

import numpy as np
import pytest
import trimesh

from holdfast.geometry.solid import closed_solid
from holdfast.geometry.surface import Surface
from holdfast.native import core


def may_lose(surface: Surface) -> bool:
    known = surface.topology
    tolerance = 1e-8 * surface.diagonal
    return core.may_lose_corners(surface.vertices, surface.faces, known.edges, known.sides, known.of_face, tolerance)


def simplified(surface: Surface) -> int:
    """The number of triangles that manifold3d leaves."""
    solid = closed_solid(surface.vertices, surface.faces)
    assert solid is not None
    return solid.simplify(1e-8 * surface.diagonal).num_tri()


def of(mesh: trimesh.Trimesh, vertices: np.ndarray | None = None) -> Surface:
    return Surface(np.array(mesh.vertices if vertices is None else vertices), np.array(mesh.faces, dtype=np.int64))


def test_a_surface_of_which_nothing_can_go_is_left_alone() -> None:
    rng = np.random.default_rng(3)
    certain = 0
    for k in range(120):
        scatter = 10.0 ** rng.uniform(-10, -5)
        mesh = trimesh.creation.box().subdivide().subdivide() if k % 2 else trimesh.creation.icosphere(k % 3)
        vertices = mesh.vertices + rng.normal(size=mesh.vertices.shape) * scatter
        surface = of(mesh, vertices * np.array([1, 1, 10.0 ** rng.uniform(-3, 0)]))
        if not may_lose(surface):
            certain += 1
            assert simplified(surface) == len(surface.faces)
    assert certain > 30


@pytest.mark.parametrize("mesh", [trimesh.creation.box().subdivide(), trimesh.creation.cylinder(1, 1, 12).subdivide()])
def test_needless_corners_are_seen(mesh: trimesh.Trimesh) -> None:
    assert may_lose(of(mesh))
    assert simplified(of(mesh)) < len(mesh.faces)


def test_corners_of_a_box_are_needed_but_not_one_on_its_straight_edge() -> None:
    box = trimesh.creation.box()
    assert not may_lose(of(box))
    vertices = np.vstack(
        [box.vertices, (box.vertices[box.edges_unique[0, 0]] + box.vertices[box.edges_unique[0, 1]]) / 2]
    )
    low, high = box.edges_unique[0]
    faces = []
    for face in box.faces.tolist():
        if low in face and high in face:
            faces += [[8 if corner == old else corner for corner in face] for old in (low, high)]
        else:
            faces.append(face)
    assert may_lose(Surface(vertices, np.array(faces, dtype=np.int64)))


def test_a_corner_that_two_cones_share_counts_as_needless() -> None:
    cone = trimesh.creation.cone(1, 1, 7)
    tip = int(np.argmax(cone.vertices[:, 2]))
    other = cone.vertices * [1, 1, -1] + [0, 0, 2 * cone.vertices[tip, 2]]
    faces = np.array(cone.faces)[:, ::-1] + len(cone.vertices)
    faces[faces == tip + len(cone.vertices)] = tip
    both = np.vstack([cone.faces, faces])
    used, numbers = np.unique(both, return_inverse=True)
    assert may_lose(Surface(np.vstack([cone.vertices, other])[used], numbers.reshape(both.shape)))


def test_arrays_that_do_not_fit_are_refused() -> None:
    surface = of(trimesh.creation.icosphere(1))
    known = surface.topology
    with pytest.raises(ValueError, match="edges beside their faces"):
        core.may_lose_corners(
            surface.vertices, surface.faces, known.edges, known.sides[::-1].copy(), known.of_face, 1e-9
        )
    with pytest.raises(ValueError, match="known edge"):
        core.may_lose_corners(
            surface.vertices, surface.faces, known.edges, known.sides, known.of_face + len(known.edges), 1e-9
        )
    elsewhere = np.roll(known.edges, 1, axis=0)
    with pytest.raises(ValueError, match="edges between corners"):
        core.may_lose_corners(surface.vertices, surface.faces, elsewhere, known.sides, known.of_face, 1e-9)
    one_more, beside = np.vstack([known.edges, known.edges[:1]]), np.vstack([known.sides, known.sides[:1]])
    with pytest.raises(ValueError, match="faces of their edges"):
        core.may_lose_corners(surface.vertices, surface.faces, one_more, beside, known.of_face, 1e-9)
    with pytest.raises(ValueError, match="a normal for each face"):
        core.prepared(surface.vertices, surface.faces, surface.normals[:-1], known.edges, known.bend)
    with pytest.raises(ValueError, match="known vertex"):
        core.normals_of(surface.vertices[:-1], surface.faces)
