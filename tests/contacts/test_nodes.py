"""Nodes that stand for a patch: corners first, and weights that integrate over it."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest
import shapely
from scipy.integrate import dblquad

import holdfast as hf
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.patch_nodes import Sampling, interface_nodes

UP = np.array([0.0, 0, 1])
SHAPES = {
    "square": [(0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1)],
    "strip": [(0, 0), (0.5, 0), (0.5, 0.02), (0, 0.02)],
    "triangle": [(0, 0), (0.2, 0), (0.05, 0.1)],
    "ell": [(0, 0), (0.2, 0), (0.2, 0.1), (0.1, 0.1), (0.1, 0.2), (0, 0.2)],
    "disc": [(0.1 * np.cos(t), 0.1 * np.sin(t)) for t in 2 * np.pi * np.arange(40) / 40],
    "tilted": [(0.3, 0.1), (0.6, 0.4), (0.5, 0.5), (0.2, 0.2)],
}


def interface(name: str) -> hf.answers.Interface:
    return hf.answers.Interface(("a", "b"), [(x, y, 0) for x, y in SHAPES[name]], UP)


def ring(inner: float) -> hf.answers.Interface:
    t = 2 * np.pi * np.arange(32) / 32
    circle = np.column_stack([np.cos(t), np.sin(t), 0 * t])
    return hf.answers.Interface(("a", "b"), patches=[Patch(0.1 * circle, UP, (0.1 * inner * circle[::-1],))])


@pytest.mark.parametrize("count", [5, 7, 20, 60])
@pytest.mark.parametrize("name", SHAPES)
def test_there_are_as_many_nodes_as_asked_and_they_lie_in_the_patch(name: str, count: int) -> None:
    ((points, weights),) = interface_nodes(interface(name), count, "hull")
    assert len(points) == len(weights) == count
    assert len(np.unique(points.round(9), axis=0)) == count
    polygon = shapely.Polygon(SHAPES[name]).buffer(1e-9)
    assert shapely.contains_xy(polygon, points[:, 0], points[:, 1]).all()
    np.testing.assert_allclose(points[:, 2], 0, atol=1e-15)


@pytest.mark.parametrize("sampling", ["hull", "quadrature", "corners"])
@pytest.mark.parametrize("name", SHAPES)
def test_weights_are_positive_and_sum_to_the_area(name: str, sampling: str) -> None:
    ((_, weights),) = interface_nodes(interface(name), 20, sampling)
    assert (weights > 0).all()
    assert weights.sum() == pytest.approx(shapely.Polygon(SHAPES[name]).area, rel=1e-9)


@pytest.mark.parametrize("sampling", ["hull", "quadrature", "corners"])
@pytest.mark.parametrize("name", ["square", "strip", "triangle", "ell", "tilted"])
def test_hull_corners_are_nodes(name: str, sampling: str) -> None:
    ((points, _),) = interface_nodes(interface(name), 20, sampling)
    (patch,) = interface(name).patches
    assert np.linalg.norm(patch.hull[:, None] - points, axis=2).min(1).max() < 1e-9


EXACTLY = [
    *((name, "hull", count) for name in ("square", "strip", "tilted") for count in (12, 20, 40)),
    *((name, "quadrature", count) for name in ("square", "tilted") for count in (49, 100)),
]


@pytest.mark.parametrize(("name", "sampling", "count"), EXACTLY)
def test_rectangles_are_integrated_exactly(name: str, sampling: Sampling, count: int) -> None:
    """First and second moments, and the mean distance to the centroid."""
    ((points, weights),) = interface_nodes(interface(name), count, sampling)
    corners = np.array(SHAPES[name])
    centre = corners.mean(0)
    u, v = corners[1] - corners[0], corners[3] - corners[0]
    area = abs(u[0] * v[1] - u[1] * v[0])
    arms = points[:, :2] - centre
    scale = area * np.hypot(*u)
    np.testing.assert_allclose(weights @ arms, 0, atol=1e-9 * scale)
    second = area * (np.outer(u, u) + np.outer(v, v)) / 12
    np.testing.assert_allclose(np.einsum("i,ij,ik->jk", weights, arms, arms), second, atol=1e-9 * scale * np.hypot(*u))
    a, b = np.hypot(*u), np.hypot(*v)
    distance = 4 * dblquad(lambda y, x: np.hypot(x, y), 0, a / 2, 0, b / 2, epsrel=1e-11)[0]
    assert weights @ np.linalg.norm(arms, axis=1) == pytest.approx(distance, rel=1e-7)


@pytest.mark.parametrize("name", ["square", "strip", "tilted"])
@pytest.mark.parametrize("first", range(4))
def test_nodes_of_a_rectangle_are_those_of_a_patch_that_is_nearly_one(name: str, first: int) -> None:
    """Rectangles share nodes and areas that are worked out once; all other patches have theirs sampled anew."""
    corners = np.roll([(x, y, 0.0) for x, y in SHAPES[name]], first, axis=0)
    nearly = corners.copy()
    nearly[2] += 2e-11 * (corners[2] - corners[0])
    found = [interface_nodes(hf.answers.Interface(("a", "b"), ring, UP), 20, "hull")[0] for ring in (corners, nearly)]
    np.testing.assert_allclose(found[0][0], found[1][0], atol=1e-9)
    np.testing.assert_allclose(found[0][1], found[1][1], rtol=1e-6)


def test_a_hair_has_no_more_nodes_than_twice_what_was_asked() -> None:
    """A patch 4 m long and 17 nm wide had 200,000 of them: as many along it as squares would take."""
    corners = [(0, 0, 0), (4, 0, 0), (4, 1.7e-8, 0), (0, 1.5e-8, 0)]
    ((points, weights),) = interface_nodes(hf.answers.Interface(("a", "b"), corners, UP), 49, "quadrature")
    assert len(points) <= 2 * 49
    assert weights.sum() == pytest.approx(6.4e-8, rel=1e-6)


def test_holes_hold_no_nodes() -> None:
    ((points, weights),) = interface_nodes(ring(0.6), 20, "hull")
    outer = 32 / 2 * np.sin(2 * np.pi / 32) * 0.01
    assert np.linalg.norm(points, axis=1).min() > 0.06 * np.cos(np.pi / 32) - 1e-9
    assert weights.sum() == pytest.approx(outer * (1 - 0.36), rel=1e-9)


def test_patches_share_the_nodes_by_area() -> None:
    pieces = [
        hf.answers.Interface(("a", "b"), np.array([(0, 0, 0), (x, 0, 0), (x, 1, 0), (0, 1, 0)]), UP) for x in (3.0, 1.0)
    ]
    both = hf.answers.Interface(("a", "b"), patches=[p.patches[0] for p in pieces])
    found = interface_nodes(both, 20, "hull")
    assert [len(points) for points, _ in found] == [15, 5]
    assert [weights.sum() for _, weights in found] == pytest.approx([3, 1])


def test_the_papers_nodes_are_spread_seeded_and_weigh_the_same() -> None:
    """Twenty points by farthest-of-ten keep a distance that points thrown at random do not."""
    ((points, weights),) = interface_nodes(interface("square"), 20, "paper", seed=3)
    ((again, _),) = interface_nodes(interface("square"), 20, "paper", seed=3)
    ((other, _),) = interface_nodes(interface("square"), 20, "paper", seed=4)
    assert np.array_equal(points, again)
    assert not np.allclose(points, other)
    assert weights == pytest.approx(interface("square").area / 20)
    side = np.sqrt(interface("square").area)
    apart = np.linalg.norm(points[:, None] - points, axis=2)[~np.eye(20, dtype=bool)]
    assert apart.min() > 0.1 * side


@pytest.mark.parametrize("side", [7, 14, 28])
def test_a_grid_has_nodes_along_straight_edges_and_at_the_corners_of_a_rim(side: int) -> None:
    """On an edge of a hexagon neighbours are a step apart; of a rim's corners all are nodes, or half of the nodes."""
    t = 2 * np.pi * np.arange(6) / 6
    corners = 0.1 * np.column_stack([np.cos(t), np.sin(t), 0 * t])
    ((points, _),) = interface_nodes(hf.answers.Interface(("a", "b"), corners, UP), side**2, "quadrature")
    assert np.linalg.norm(points[:, None] - corners, axis=2).min(0).max() < 1e-12
    for one, other in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (other - one) / 0.1
        across = np.cross(UP, along)
        on_edge = np.sort((points - one)[np.abs((points - one) @ across) < 1e-9] @ along)
        assert np.diff(on_edge).max() < 1.3 * 0.2 / (side - 1)
    ((points, _),) = interface_nodes(interface("disc"), side**2, "quadrature")
    rim = np.array(SHAPES["disc"])
    corner = np.linalg.norm(rim[:, None] - points[:, :2], axis=2).min(1) < 1e-9
    assert corner.sum() == min(40, side**2 // 2)


def test_nodes_are_kept_with_their_interface_and_go_with_it() -> None:
    square = interface("square")
    assert interface_nodes(square, 9, "hull") is interface_nodes(square, 9, "hull")
    gone = weakref.ref(square)
    del square
    gc.collect()
    assert gone() is None


def test_nodes_of_a_line_lie_on_it_whichever_end_comes_first() -> None:
    """A line that leans a little against the plane of its patch: its other end is not moved into the plane."""
    ends = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 1e-5]])
    for polygon in (ends, ends[::-1]):
        interface = Interface(("a", "b"), patches=[Patch(polygon, np.array([0.0, 0.0, 1.0]), breadth=1e-4)])
        ((points, _),) = interface_nodes(interface, 5, "corners")
        np.testing.assert_allclose(points[:, 2], 1e-4 * points[:, 0], atol=1e-18)
