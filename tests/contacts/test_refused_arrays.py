"""The compiled core refuses arrays whose sizes or indices do not fit, instead of reading or writing outside them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

import holdfast as hf
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.native import core

MESH = SearchMesh.of(hf.Body("box", hf.Box((1, 1, 1)), mass=1.0))
LIMITS = (0.1, 0.1, 0.1, 0.1, 1e-9, 1e-6)
NONE, ONE = np.zeros((0, 3)), np.array([[0, 0]])
POINTS, TRIANGLES = np.ones((1, 3)), np.ones((1, 3, 3))
CORNERS, ORDER = np.ones((3, 2)), np.arange(3)


def patches(corner: Sequence[int] = (0, 4), ring: Sequence[int] = (0, 1)) -> tuple[object, ...]:
    return np.ones((4, 3)), np.array(corner), np.array(ring), POINTS, np.zeros(1, dtype=bool)


def faces(face: Sequence[int] = (0, 1), ring: Sequence[int] = (0, 1)) -> tuple[object, ...]:
    return np.ones((4, 3)), np.array([0, 4]), np.array(ring), POINTS, np.ones(1), np.ones(1), np.array(face)


def beds(beyond: Sequence[int] = (0,), edge: Sequence[int] = (0, 1)) -> tuple[object, ...]:
    plane = np.ones((1, 5)), np.ones((1, 3)), np.ones((1, 2)), np.ones((1, 3, 3)), np.ones((1, 3))
    return np.array(edge), np.array([0, 1]), *plane, np.array([0, 1]), np.array(beyond)


def cover(stops: Sequence[int] = (3,), rings: Sequence[int] = (1,)) -> core.Cover:
    frames = np.ones((len(rings), 2, 3))
    return core.Cover(np.ones((3, 3)), np.array(stops), np.array(rings), np.ones((len(rings), 3)), frames, 0.1)


REFUSED: dict[str, Callable[[], object]] = {
    "patches with rings that no corner belongs to": lambda: cover(stops=(3, 5)),
    "more patches than rings": lambda: cover(rings=(1, 2)),
    "features without normals": lambda: cover().covered(np.ones((1, 2, 3)), NONE, np.ones(1)),
    "a line of one end": lambda: cover().left(POINTS, np.ones(3), 0.9, 0.0),
    "no corners": lambda: core.rectangle_axes(np.zeros((0, 2))),
    "an unknown point of a hull": lambda: core.corner_numbers(CORNERS, np.array([3])),
    "pieces that end before they begin": lambda: core.outlines_of(CORNERS, np.array([3, 2]), 0.0),
    "a cell below the first": lambda: core.cut_by_grid(np.ones((1, 3, 2)), np.ones(2), 5, np.array([[-1, 0]]), ONE),
    "an unknown triangle": lambda: core.nearest_of_pairs(POINTS, TRIANGLES, np.array([[0, 1]])),
    "an unknown vertex": lambda: core.winding_numbers(POINTS, POINTS, np.array([[0, 0, -1]])),
    "a result too short": lambda: core.mark_hits(POINTS, POINTS, TRIANGLES, 1.0, np.zeros(0, bool)),
    "no points along the axes": lambda: core.hull_gauge(np.ones((1, 1)), np.ones(1), np.ones((1, 1)), 1e-14),
    "an unknown face": lambda: core.touching_features(MESH, MESH, np.array([[0, 12]]), LIMITS),
    "an unknown edge": lambda: core.touching_features(MESH._replace(of_face=MESH.of_face + 99), MESH, ONE, LIMITS),
    "unknown neighbours": lambda: core.touching_features(MESH._replace(starts=99 * MESH.starts), MESH, ONE, LIMITS),
    "fewer vertices": lambda: core.touching_features(MESH._replace(vertices=NONE), MESH, ONE, LIMITS),
    "a face below the first": lambda: core.clip_faces(MESH, MESH, np.array([[-1, 0]]), 1.0, 1.0, 0.0, 0.0),
    "no box": lambda: core.near_faces(MESH._replace(box=NONE), MESH, 0.1, -1, -1, False),
    "an unknown cuboid": lambda: core.cuboid_contacts(np.ones((1, 5, 3)), np.array([[0, 1]]), POINTS, 1e-9, 1e-6),
    "fewer limits than pairs": lambda: core.cuboid_contacts(np.ones((1, 5, 3)), ONE, NONE, 1e-9, 1e-6),
    "a mark too few": lambda: core.near_bodies(np.ones((1, 2, 3)), np.ones(1, bool), np.ones(0, bool), 0.1),
    "rings of nine corners": lambda: core.measures_of(np.ones((1, 9, 2))),
    "boxes along a fourth axis": lambda: core.near_boxes(NONE, NONE, NONE, NONE, 3, 1.0),
    "an unknown corner": lambda: core.placed(NONE, np.array([[0, 0, 0]]), np.eye(4)),
    "no points of a hull": lambda: core.convex_hull(np.zeros((0, 2)), 0.0),
    "a ring that ends beyond the corners": lambda: core.canonical(patches(corner=[0, 5]), np.zeros(3), np.eye(3)),
    "a patch without rings": lambda: core.canonical(patches(ring=[0, 0]), np.zeros(3), np.eye(3)),
    "a grid of three nodes": lambda: core.grids_over(np.ones((4, 3)), np.array([0, 4]), POINTS, np.array([3])),
    "faces that begin too late": lambda: core.grids_over(np.ones((4, 3)), np.array([1, 4]), POINTS, np.array([9])),
    "a contact with an unknown body": lambda: core.cuts_of(1, np.array([[0, 1]])),
    "a contact without faces": lambda: core.beds_of(faces(face=[0, 0])),
    "a face without rings": lambda: core.beds_of(faces(ring=[0, 0])),
    "a bed with an unknown body beyond": lambda: core.carried_by(beds(beyond=[1]), POINTS, np.ones((1, 6))),
    "a bed of too many edges": lambda: core.carried_by(beds(edge=[0, 9]), POINTS, np.ones((1, 6))),
    "a sheet on an unknown body": lambda: core.order_fronts(1, np.array([1]), np.array([0]), np.array([[0]])),
    "ranks of too few bodies": lambda: core.order_fronts(2, np.array([1]), np.array([0]), np.array([[0]])),
    "a node on an unknown body": lambda: core.node_wrenches(POINTS, TRIANGLES, ORDER[:1], ORDER[1:2], POINTS, POINTS),
    "fewer results than points": lambda: core.mark_unexplained(np.ones((3, 7)), 1.0, np.zeros(2, bool)),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_does_not_fit_is_refused(what: str) -> None:
    with pytest.raises(ValueError, match=r"^expected "):
        REFUSED[what]()


def test_what_is_not_a_number_harms_nothing() -> None:
    nothing = np.full((50, 3), np.nan)
    faces = (np.full((50, 3, 3), np.nan), nothing, nothing)
    assert not len(core.shared_parts(faces, faces, 0.0)[2])
    lost = MESH._replace(low=np.full_like(MESH.low, np.nan), high=np.full_like(MESH.high, np.nan))
    assert not len(core.near_faces(lost, MESH, 0.1, -1, -1, False))
    assert len(core.convex_hull(np.full((50, 2), np.nan), 0.0)) <= 100
    core.canonical((nothing, np.array([0, 20, 50]), np.array([0, 2]), POINTS, np.zeros(1, bool)), POINTS[0], np.eye(3))
    sides, _, points = core.grids_over(nothing, np.array([0, 50]), POINTS, np.array([9]))
    assert not sides.any()
    assert not len(points)
