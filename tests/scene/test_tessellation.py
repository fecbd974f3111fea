"""What surfaces of round shapes share with others of the same kind is what they say by themselves."""

from __future__ import annotations

import numpy as np
import pytest

from holdfast.geometry.surface import Surface
from holdfast.scene.round_shapes import Capsule
from holdfast.scene.shapes import Cylinder, Sphere

SHAPES = (
    Sphere(0.04),
    Sphere(0.3, subdivisions=1),
    Cylinder(0.05, 0.12),
    Cylinder(0.3, 0.01, segments=24),
    Cylinder(0.05, 0.1, segments=100),
    Cylinder(0.05, 0.1, segments=5),
    Cylinder(1e-4, 30.0),
    Capsule(0.006, 0.12),
    Capsule(0.3, 0.01, segments=16),
    Capsule(1e-4, 30.0),
)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_edges_and_flat_faces_are_those_of_the_surface_alone(shape: Sphere | Cylinder | Capsule) -> None:
    shared = shape.surface
    alone = Surface(shared.vertices, shared.faces, shared.sagitta)
    for one, other in ((shared, alone), (shared.reduced, alone.reduced)):
        np.testing.assert_array_equal(one.faces, other.faces)
        np.testing.assert_array_equal(one.vertices, other.vertices)
        np.testing.assert_array_equal(one.topology.edges, other.topology.edges)
        np.testing.assert_allclose(one.topology.bend, other.topology.bend, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(one.facets.label, other.facets.label)
        np.testing.assert_array_equal(one.curved, other.curved)
        np.testing.assert_array_equal(one.sharp_edges, other.sharp_edges)


def test_two_sizes_share_how_their_triangles_join() -> None:
    """Sizes that no other test has: a surface that is in use elsewhere may have been reduced before."""
    assert Capsule(0.113, 0.217).surface.topology is Capsule(0.213, 0.217).surface.topology
    assert Cylinder(0.113, 0.217).surface.reduced.topology is Cylinder(0.213, 0.217).surface.reduced.topology
    assert Sphere(0.113).surface.reduced.faces is Sphere(0.213).surface.reduced.faces
