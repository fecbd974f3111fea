"""No grey scraps beside what stands on a body: what shows of a covered cell takes the answer of its neighbour."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.geometry.triangles import areas_of
from holdfast.report.map_picture import picture_of, rims_of
from holdfast.scene.shipped.blocks import at


def can_on_a_book() -> hf.RobustnessMap:
    """A can of 33 mm radius on a loose book, at a spacing that fits neither."""
    bodies = [
        hf.Body("floor", hf.Box((1, 1, 0.1)), pose=at(0, 0, -0.05), fixed=True),
        hf.Body("book", hf.Box((0.3, 0.2, 0.04)), mass=1, pose=at(0, 0, 0.02)),
        hf.Body("can", hf.Cylinder(0.033, 0.1), mass=0.3, pose=at(0.04, 0.01, 0.09)),
    ]
    return hf.robustness_map(hf.Scene(bodies, 0.5), spacing=0.02)


@pytest.fixture(scope="module")
def found() -> hf.RobustnessMap:
    return can_on_a_book()


def test_nothing_grey_lies_beyond_the_can(found: hf.RobustnessMap) -> None:
    covered = rims_of(found, "book").covered
    corners = covered.vertices[covered.triangles]
    upper = corners[corners[:, :, 2].min(1) > 0.039]
    assert len(upper)  # most of the foot is covered
    assert np.hypot(upper[..., 0] - 0.04, upper[..., 1] - 0.01).max() <= 0.033 + 1e-9
    raw = found.hidden["book"]
    assert (
        np.hypot(*(raw.vertices[raw.triangles][..., :2] - [0.04, 0.01])[raw.normals[raw.cell, 2] > 0.9].T).max() > 0.036
    )


def test_every_triangle_is_drawn_once(found: hf.RobustnessMap) -> None:
    picture = picture_of(found)
    for body, area in (
        ("book", 2 * (0.06 + 0.012 + 0.008)),
        ("can", found.assembly.scene.body("can").surface_world.area),
    ):
        parts = [part for part in (*picture.heat, *picture.solids) if part.name == body]
        assert sum(areas_of(part.vertices, part.triangles).sum() for part in parts) == pytest.approx(area)


def test_a_rim_shows_the_answer_of_a_cell_that_faces_the_same_way(found: hf.RobustnessMap) -> None:
    rims, cells = rims_of(found, "book"), found.cells["book"]
    assert len(rims.triangles)
    middle = cells.vertices[rims.triangles].mean(1)
    assert (cells.normals[rims.beside, 2] > 0.9).all()
    assert np.linalg.norm(cells.points[rims.beside] - middle, axis=1).max() < 2 * 0.02


def test_the_underside_stays_covered(found: hf.RobustnessMap) -> None:
    covered = rims_of(found, "book").covered
    assert areas_of(covered.vertices, covered.triangles)[
        covered.normals[covered.cell, 2] < -0.9
    ].sum() == pytest.approx(0.06)
