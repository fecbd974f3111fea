"""Where a patch lies: midway between both surfaces, and never taken away by a surface that is not nearer."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import shapely
import trimesh

import holdfast as hf
from holdfast.base.rigid import pose_from
from holdfast.scene.shipped.blocks import about_y, box, floor

APART = 1e-3  # [m] between the faces


# Faces of few triangles meet as triangles, those of many as polygons: two ways to a patch
SHAPES = {"triangles": hf.Box((0.1, 0.1, 0.1)), "polygons": hf.Cylinder(0.05, 0.1)}


def hovering(shape: hf.Box | hf.Cylinder, order: int, angle: float) -> hf.Scene:
    """A body 1 mm above the floor at its centre, turned about y; ``order`` says which body is named first."""
    pose = pose_from(np.array([0, 0, 0.05 + APART]), about_y(angle))
    bodies = [floor(), hf.Body("cube", shape, mass=1, pose=pose)]
    return hf.Scene(bodies[::order], 0.5)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("angle", [0.0, 0.01])
def test_a_patch_of_flat_faces_lies_midway_between_them(shape: str, order: int, angle: float) -> None:
    """Every corner is as far from the floor (z = 0) as from the cube's underside, on the one side and the other."""
    scene = hovering(SHAPES[shape], order, angle)
    found = hf.assemble(scene, gap=3e-3, angle_degrees=5)
    (patch,) = [patch for i in found.interfaces for patch in i.patches]
    turn = scene.body("cube").pose[:3, :3]
    beneath = scene.body("cube").pose[:3, 3] - 0.05 * turn[:, 2]
    above_floor = patch.polygon[:, 2]
    below_cube = (beneath - patch.polygon) @ turn[:, 2]
    assert above_floor == pytest.approx(below_cube, abs=1e-9)
    assert above_floor.mean() == pytest.approx(APART / 2, rel=5e-3)
    assert patch.separation is not None
    assert np.mean(patch.separation) == pytest.approx(APART, rel=5e-3)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("apart", [5e-5, 0.0, -5e-5])
def test_the_separation_of_a_face_with_many_corners_is_positive_where_there_is_a_gap(apart: float, order: int) -> None:
    """An L on a floor: its area is 0.03 m², and the patch lies halfway in the gap or in the overlap."""
    outline = shapely.Polygon([(0, 0), (0.2, 0), (0.2, 0.1), (0.1, 0.1), (0.1, 0.2), (0, 0.2)])
    mesh = trimesh.creation.extrude_polygon(outline, 0.1)
    ell = hf.Body("ell", hf.Mesh(mesh.vertices, mesh.faces), mass=1, position=(0, 0, apart))
    (found,) = hf.assemble(hf.Scene([floor(), ell][::order], 0.5), gap=2e-4).interfaces
    assert found.separation == pytest.approx(apart, abs=1e-12)
    assert found.area == pytest.approx(0.03)
    assert [patch.centroid[2] for patch in found.patches] == pytest.approx([apart / 2], abs=1e-12)


def test_surfaces_at_one_height_do_not_hide_each_other() -> None:
    """Two boxes that stand in each other share a part of the floor: neither is nearer to it, both keep their face."""
    bodies = [floor(), box("a", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)), box("b", (0.1, 0.1, 0.1), 1, (0.06, 0, 0.05))]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", hf.errors.HoldfastWarning)  # that they overlap is said, and not the question
        found = hf.assemble(hf.Scene(bodies, 0.5))
    on_floor = [i for i in found.interfaces if "floor" in i.bodies]
    assert [i.area for i in on_floor] == pytest.approx([0.01, 0.01], rel=1e-9)
    assert not any("occluded" in i.flags for i in on_floor)
