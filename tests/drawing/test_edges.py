"""Feature edges do not depend on how a surface is cut."""

from __future__ import annotations

import numpy as np
import pytest

from holdfast.drawing.edges import feature_edges
from holdfast.drawing.picture import HeatSurface, Picture, Solid, movable


def edge_length(*parts: HeatSurface | Solid) -> float:
    heat = tuple(part for part in parts if isinstance(part, HeatSurface))
    solids = tuple(part for part in parts if isinstance(part, Solid))
    segments = feature_edges(movable(Picture("", "", heat, solids), None))
    return float(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum())


def test_edges_are_where_the_surface_bends_or_ends() -> None:
    """A sheet of two triangles, folded along its diagonal, anywhere: its four rims and the fold between them."""
    corners = np.array([[0.3, -0.2, 0.5], [1.3, -0.1, 0.6], [1.1, 0.9, 0.2], [0.2, 0.8, 1.4]])
    folded = Solid("sheet", corners, np.array([[0, 1, 2], [0, 2, 3]]), fixed=False)
    segments = feature_edges(movable(Picture("", "", (), (folded,)), None))
    drawn = sorted(sorted(each) for each in np.round(segments, 9).tolist())
    ends = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)]
    assert drawn == sorted(sorted(corners[list(pair)].tolist()) for pair in ends)


@pytest.mark.parametrize("cut", [10.0, 0.5, 0.13])
def test_a_box_has_its_twelve_edges_however_fine_its_cells(heat_box, cut: float) -> None:
    box = heat_box("a", (0.0, 0.0, 0.0), (1.0, 2.0, 3.0), lambda p: p[:, 0] + 1.0, cut)
    assert edge_length(box) == pytest.approx(24.0)


def test_faces_cut_differently_on_both_sides_of_an_edge_still_make_one_edge() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [2, 1, 0], [0, 0, -1], [2, 0, -1.0]])
    top = [[0, 1, 3], [1, 4, 3], [1, 2, 4]]
    side = [[0, 5, 6], [0, 6, 2]]
    bent = Solid("l", vertices, np.array(top + side), fixed=False)
    assert edge_length(bent) == pytest.approx(2 * (2 + 1 + 1) + 2)


def test_a_flat_face_with_unmatched_cuts_has_no_inner_edge() -> None:
    vertices = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0], [1, 2, 0], [2, 2, 0.0]])
    flat = Solid(
        "f", vertices, np.array([[0, 1, 2], [0, 2, 3], [3, 4, 6], [3, 6, 5], [4, 2, 7], [4, 7, 6]]), fixed=False
    )
    assert edge_length(flat) == pytest.approx(8.0)


def test_two_touching_bodies_keep_their_own_edges(heat_box) -> None:
    boxes = [heat_box(str(k), (0.0, 0.0, k), (1.0, 1.0, k + 1.0), lambda p: p[:, 0] + 1.0, 1.0) for k in range(2)]
    assert edge_length(*boxes) == pytest.approx(24.0)


def test_slivers_between_cells_draw_no_edge() -> None:
    """Triangles without width, as cells have where their corners nearly coincide, say nothing of bends."""
    vertices = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 0], [1, 1 + 1e-12, 0], [2, 2, 1e-13]])
    faces = [[0, 1, 4], [1, 2, 4], [2, 3, 5], [3, 0, 4], [3, 4, 5], [2, 5, 4], [1, 2, 6]]
    assert edge_length(Solid("f", vertices, np.array(faces), fixed=False)) == pytest.approx(8.0)
    assert edge_length(Solid("nothing", vertices, np.array([[4, 5, 4], [2, 6, 2]]), fixed=False)) == 0
