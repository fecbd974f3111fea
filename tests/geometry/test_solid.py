"""Which surfaces are handed to manifold3d: only those in which each edge has two faces that run along it both ways."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.base.arrays import Float, Int
from holdfast.base.borders.supervisor import Limits, Supervisor
from holdfast.base.borders.worker import DONE
from holdfast.geometry.solid import closed_solid

SHAPES = (
    trimesh.creation.box((2, 2, 2)),
    trimesh.creation.icosphere(1),
    trimesh.creation.cylinder(1, 2, sections=8),
    trimesh.creation.annulus(0.5, 1, 1, sections=8),
)
DEADLY = [[5, 7, 1], [0, 3, 2], [6, 5, 4], [1, 3, 0], [3, 7, 2], [2, 7, 6], [6, 4, 2]]  # ends manifold3d 3.5.4
CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@pytest.mark.parametrize("shape", SHAPES)
def test_closed_surfaces_are_solids_of_their_volume(shape: trimesh.Trimesh) -> None:
    solid = closed_solid(shape.vertices, shape.faces)
    assert solid is not None
    corners = shape.vertices[shape.faces]
    assert solid.volume() == pytest.approx(np.linalg.det(corners).sum() / 6)  # of tetrahedra to the origin


@pytest.mark.parametrize("shape", SHAPES)
def test_a_face_too_few_too_many_or_turned_makes_no_solid(shape: trimesh.Trimesh) -> None:
    faces = np.array(shape.faces)
    turned, needle = faces.copy(), faces.copy()
    turned[3] = turned[3, ::-1]
    needle[3, 1] = needle[3, 0]
    for wrong in (faces[1:], np.vstack([faces, faces[:1]]), turned, needle, faces[:0]):
        assert closed_solid(shape.vertices, wrong) is None


def torn(seed: int) -> tuple[Float, Int]:
    """A mesh with holes, repeated, turned, random or inside-out faces, or with corners at one place."""
    rng = np.random.default_rng(seed)
    shape = SHAPES[rng.integers(len(SHAPES))]
    vertices, faces = np.array(shape.vertices), np.array(shape.faces)
    some = rng.random(len(faces)) < rng.uniform(0.1, 0.9)
    match seed % 6:
        case 0:
            faces = faces[some] if some.sum() > 3 else faces[:4]
        case 1:
            faces[some] = faces[some, ::-1]
        case 2:
            faces = np.vstack([faces, faces[some]])
        case 3:
            faces = rng.integers(0, len(vertices), size=(len(faces), 3))
        case 4:
            faces = faces[:, ::-1]
        case _:
            faces = np.where(faces == faces[0, 0], faces[0, 1], faces)
    return vertices, faces


def used(given: tuple[Float, Int], tell: object) -> list[str]:
    """Use a mesh as a body, a support, a hull and a part of a compound; return what went wrong and was told."""
    mesh, box = hf.Mesh(*given), hf.Box((1, 1, 1))
    floor = hf.Body("floor", hf.Box((9, 9, 1)), position=(0, 0, -0.5), fixed=True)
    both = hf.Compound([hf.Part(mesh), hf.Part(box, pose=hf.pose(0.5, 0, 0.5))])
    told = []
    for pair in (
        (floor, hf.Body("b", mesh, mass=1, com=(0, 0, 0), position=(0, 0, 0.9))),
        (hf.Body("s", mesh, fixed=True), hf.Body("b", box, mass=1, position=(0, 0, 1.5))),
        (floor, hf.Body("b", both, mass=1, com=(0, 0, 0), position=(0, 0, 1))),
    ):
        try:
            hf.stability(hf.Scene(pair, 0.5), engine="limit")
        except hf.HoldfastError as error:
            told.append(str(error))
    return told


def test_no_mesh_ends_the_process() -> None:
    with Supervisor("test_solid:used", limits=Limits(120, 3000), folders=[str(Path(__file__).parent)]) as supervisor:
        for number, given in enumerate([(CORNERS, np.array(DEADLY)), *map(torn, range(60))]):
            reply = supervisor.ask(given)
            assert reply.outcome == DONE, f"{number}: {reply.problem}"
