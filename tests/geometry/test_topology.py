"""Edges and flat regions of triangle surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import holdfast as hf
from holdfast.geometry.surface import Surface
from holdfast.geometry.triangles import Edges

SOLIDS = {
    "box": hf.Box((0.1, 0.2, 0.3)),
    "cylinder": hf.Cylinder(0.05, 0.2, segments=12),
    "sphere": hf.Sphere(0.1, subdivisions=2),
}


def brute(faces: np.ndarray) -> dict[tuple[int, int], list[int]]:
    """The faces beside every edge, in order."""
    beside: dict[tuple[int, int], list[int]] = {}
    for number, face in enumerate(faces.tolist()):
        for k in range(3):
            low, high = sorted((face[k], face[(k + 1) % 3]))
            beside.setdefault((low, high), []).append(number)
    return dict(sorted(beside.items()))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.permutations(range(6)).map(lambda p: p[:3]), min_size=1, max_size=20))
def test_edges_are_those_found_one_by_one(rows: list[list[int]]) -> None:
    faces = np.array(rows, dtype=np.int64)
    edges, expected = Edges.of(faces, 6), brute(faces)
    assert [tuple(end) for end in edges.ends.tolist()] == list(expected)
    assert edges.shared.tolist() == [len(numbers) for numbers in expected.values()]
    for e, numbers in enumerate(expected.values()):
        sides = edges.sides[edges.first[e] : edges.first[e] + edges.shared[e]]
        assert (sides // 3).tolist() == numbers
        assert (edges.of_face.ravel()[sides] == e).all()


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_close_as_euler_says(name: str) -> None:
    surface = SOLIDS[name].surface
    topology = surface.topology
    assert topology.closed
    assert len(surface.vertices) - len(topology.edges) + len(surface.faces) == 2
    assert (np.diff(topology.starts) == np.bincount(topology.edges.ravel())).all()


def test_edges_of_a_box_stick_out_by_a_right_angle_and_its_diagonals_do_not() -> None:
    bend = SOLIDS["box"].surface.topology.bend
    assert sorted(np.round(np.degrees(bend), 9).tolist()) == [0] * 6 + [90] * 12


def test_the_rim_of_a_sheet_bends_without_end() -> None:
    sheet = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
    assert not sheet.topology.closed
    assert np.isinf(sheet.topology.bend).sum() == 4
    assert sheet.topology.regions(1e-9).tolist() == [0, 0]


def test_regions_end_where_the_surface_bends_by_more() -> None:
    """A prism of 12 sides: its faces meet at 30 degrees, and its ends at 90."""
    topology = SOLIDS["cylinder"].surface.topology
    assert topology.regions(np.radians(1)).max() + 1 == 14
    assert topology.regions(np.radians(31)).max() + 1 == 3
    assert topology.regions(np.radians(91)).max() + 1 == 1
