"""Answers do not depend on what NumPy is told to do about underflows and the like, and no warning of it comes out."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import trimesh
from placed import FLOOR

import holdfast as hf
from holdfast.geometry.triangles import first_hit
from holdfast.sets import gradients

CAPSULE = hf.Capsule(0.05, 0.2)
SCENE = hf.Scene(
    [
        FLOOR,
        hf.Body("box", hf.Box((0.2, 0.2, 0.2)), mass=1, position=(0, 0, 0.1)),
        hf.Body("tin", hf.Cylinder(0.05, 0.1), mass=0.5, position=(0, 0, 0.25)),
        hf.Body("roll", CAPSULE, mass=0.5, position=(0.5, 0, 0.05), rpy_degrees=(0, 90, 0)),
    ],
    0.5,
)
AT, ALONG = (-0.1, 0.1, 0.2), (1, 0.1, 0.05)
ASKED: dict[str, Callable[[], Any]] = {
    "stability": lambda: hf.stability(SCENE, engine="limit").margin,
    "push": lambda: float(hf.robustness(SCENE, "box", AT, ALONG)),
    "push by limit": lambda: float(hf.robustness(SCENE, "box", AT, ALONG, engine="limit")),
    "transport": lambda: hf.transport_limits(SCENE, engine="limit").acceleration,
    "monitor": lambda: hf.Monitor(hf.assemble(SCENE), seconds=60).update(acceleration=(1, 0, 0)).margin,
    "place": lambda: (
        hf.plan_placement(
            SCENE,
            hf.Body("new", hf.Box((0.05,) * 3), mass=0.2),
            where=hf.Where(supports=["box"]),
            search=hf.Search(seed=1, solves=20, candidates=2, confirm=None),
            engine="limit",
        ).stable
    ),
}


@pytest.mark.parametrize("name", ASKED)
def test_answers_are_the_same_under_any_state_of_numpy(name: str) -> None:
    with np.errstate(all="ignore"):
        right = ASKED[name]()
    with np.errstate(all="raise"):
        assert np.array_equal(ASKED[name](), right)


def flat_mesh() -> hf.Mesh:
    box = trimesh.creation.box((1, 1, 1))
    return hf.Mesh(np.array(box.vertices) * [1, 1, 0], box.faces)


def test_a_flat_mesh_is_refused_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        with pytest.raises(hf.errors.GeometryError, match="encloses a volume of 0"):
            _ = flat_mesh().mass_properties
        with pytest.raises(hf.errors.GeometryError, match="encloses a volume of 0"):
            hf.assemble(hf.Scene([FLOOR, hf.Body("b", flat_mesh(), density=100)], 0.5))


def test_slopes_that_jump_to_infinity_come_without_a_warning() -> None:
    """A push down on the middle of a face holds for ever; beside it, along it, it does not."""
    assembly = hf.assemble(SCENE)
    answer = hf.robustness(assembly, "box", [(0, 0, 0.2), (-0.1, 0, 0.1)], [(1, 0, -2), (1, 0, 0)])
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        found = gradients(assembly, answer)
    assert not np.isnan(found.pose["box"]).any()


@pytest.mark.parametrize("size", [1e-300, 1e200, 1e308])
def test_rays_of_any_length_meet_or_miss_without_a_warning(size: float) -> None:
    box = hf.Box((1, 1, 1)).surface
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        first_hit(box.vertices, box.faces, np.array([0.1, 0.2, size]), np.array([0, 0, -size]))
