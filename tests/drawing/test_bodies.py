"""Bodies become what a picture draws."""

from __future__ import annotations

import numpy as np

import holdfast as hf
from holdfast.report.map_picture import bare_picture, solids_of
from holdfast.scene.shipped.blocks import box, floor

UP = np.array([0.6, 0.0, 0.8])


def tilted() -> hf.Scene:
    cube = box("cube", (0.1, 0.1, 0.1), 1.0, (0.2, 0.0, 0.05))
    return hf.Scene(
        [floor(), cube, box("other", (0.1, 0.1, 0.1), 1.0, (0.5, 0.0, 0.05))], friction=0.5, gravity=-9.81 * UP
    )


def test_a_body_is_drawn_where_it_is() -> None:
    ground, cube, _ = solids_of(tilted().bodies)
    assert (ground.name, ground.fixed, cube.name, cube.fixed) == ("floor", True, "cube", False)
    np.testing.assert_allclose(cube.vertices.min(axis=0), [0.15, -0.05, 0.0], atol=1e-12)
    np.testing.assert_allclose(cube.vertices.max(axis=0), [0.25, 0.05, 0.1], atol=1e-12)
    corners = cube.vertices[cube.triangles]
    out = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", out, corners[:, 0] - [0.2, 0.0, 0.05]) > 0).all()


def test_one_body_can_be_left_out_and_up_is_against_gravity() -> None:
    assert [solid.name for solid in bare_picture(tilted()).solids] == ["floor", "cube", "other"]
    without = bare_picture(tilted(), without="cube")
    assert [solid.name for solid in without.solids] == ["floor", "other"]
    np.testing.assert_allclose(without.up, UP, atol=1e-12)
