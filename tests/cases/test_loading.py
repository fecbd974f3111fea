"""Published and settled scenes load with the bodies, masses and friction that their files give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shared

import holdfast as hf
from holdfast.scene.formats.published import triangulated


@shared.needed
@pytest.mark.parametrize("path", shared.paths("published"))
def test_published_scenes_load(path: Path) -> None:
    data, scene = shared.contents(path), hf.load_scene(path)
    assert [b.name for b in scene.bodies] == [str(block["name"]) for block in data["blocks"]]
    assert [b.fixed for b in scene.bodies] == [block["fixed"] for block in data["blocks"]]
    assert [b.mass for b in scene.movable] == [block["mass"] for block in data["blocks"] if not block["fixed"]]
    assert scene.gravity.tolist() == data["gravity"]
    a, b = scene.bodies[:2]
    assert scene.mu(a.name, b.name) == data["friction"]
    assert all(body.shape.is_closed for body in scene.movable)


@shared.needed
@pytest.mark.parametrize("path", shared.paths("settled"))
def test_settled_scenes_load(path: Path) -> None:
    data, scene = shared.contents(path), hf.load_scene(path)
    objects = {str(item["name"]): item for item in data["objects"]}
    assert [b.name for b in scene.bodies] == list(objects)
    assert scene.gravity.tolist() == data["units"]["gravity"]
    for body in scene.bodies:
        item = objects[body.name]
        assert body.fixed == item["fixed"]
        np.testing.assert_allclose(body.pose, item["pose"], atol=1e-8)
        assert body.shape.scale == tuple(item["scale"])
        if not body.fixed:
            assert body.mass == item["mass"]
            assert item["com"] is None or body.com.tolist() == item["com"]
    first, *others = objects.values()
    for other in others:
        expected = max(first["friction"], other["friction"])
        assert scene.mu(str(first["name"]), str(other["name"])) == expected


OUTLINES = {  # counter-clockwise
    "square": ([(0, 0), (1, 0), (1, 1), (0, 1)], 1.0),
    "ell": ([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 3.0),
    "star": ([(0, 2), (-0.4, 0.4), (-2, 0), (-0.4, -0.4), (0, -2), (0.4, -0.4), (2, 0), (0.4, 0.4)], 3.2),
    "comb": ([(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], 11.0),
    "collinear": ([(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)], 2.0),
}


@pytest.mark.parametrize("turn", [0, 3])
@pytest.mark.parametrize("name", OUTLINES)
def test_faces_that_are_not_convex_are_triangulated_as_they_are(name: str, turn: int) -> None:
    outline, area = OUTLINES[name]
    flat = np.roll(np.array(outline, dtype=float), turn, axis=0)
    rotation = np.linalg.qr(np.random.default_rng(turn).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    vertices = np.column_stack([flat, np.zeros(len(flat))]) @ rotation.T + 5
    triangles = vertices[triangulated(vertices, np.arange(len(flat)))]
    vectors = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]) / 2
    assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(area, rel=1e-12)
    np.testing.assert_allclose(vectors.sum(0), area * rotation[:, 2], rtol=1e-9, atol=1e-12)
