"""Table I in small: each method meets the truth it is made for, and the figures count what they say."""

from __future__ import annotations

import numpy as np
import pytest

from bench.scenes.pushes import on_boxes
from bench.suites import table1
from holdfast.scene.shipped import shipped_scene


def test_pushes_lie_on_the_boxes_and_point_outward() -> None:
    scene = shipped_scene("table")
    for body, points, normals in on_boxes(scene, ("slab", "leg_left"), 200, 3):
        surface = scene.body(body).surface_world.vertices
        low, high = surface.min(0), surface.max(0)
        face = np.where(normals > 0, high, low)[np.abs(normals) > 0]
        np.testing.assert_allclose(points[np.abs(normals) > 0], face, atol=1e-12)
        assert ((points >= low - 1e-12) & (points <= high + 1e-12)).all()


@pytest.mark.parametrize(
    ("method", "truth", "limit"),
    [("graph", "decoupled", 1e-6), ("isolated", "decoupled", 1e-6), ("compliant", "coupled", 1.0)],
)
def test_each_method_meets_its_truth_on_the_cube(method: str, truth: str, limit: float) -> None:
    _, answers = table1.run_once("cube", table1.METHODS[method], table1.OWN[0], 4, 60)
    figures = table1.compared(answers, table1.truths(truth, "cube", 60, 4))
    assert figures["error %"] < limit
    assert figures["kind agrees %"] == 100


def test_graph_is_optimistic_against_the_coupled_truth() -> None:
    _, answers = table1.run_once("cube", table1.METHODS["graph"], table1.OWN[0], 4, 60)
    figures = table1.compared(answers, table1.truths("coupled", "cube", 60, 4))
    assert figures["error %"] > 15
    assert figures["optimistic %"] > 50


def test_what_is_counted() -> None:
    answers = np.array([1.1, 2.0, np.inf, 4.0, np.nan, np.inf])
    true = np.array([1.0, 2.0, 3.0, np.inf, 5.0, np.inf])
    figures = table1.compared(answers, true)
    assert figures["error %"] == pytest.approx(5)  # of the two that are finite on both sides
    assert figures["kind agrees %"] == pytest.approx(60)
    assert figures["optimistic %"] == pytest.approx(100 * 2 / 3)
    assert figures["worst optimistic %"] == np.inf
    assert figures["undecided %"] == pytest.approx(100 / 6)


def test_the_papers_points_differ_by_seed() -> None:
    graph = table1.METHODS["limit"]
    one, two = (table1.run_once("cube", graph, table1.PAPER[0], seed, 20)[1] for seed in (1, 2))
    again = table1.run_once("cube", graph, table1.PAPER[0], 1, 20)[1]
    np.testing.assert_array_equal(one, again)
    assert not np.allclose(one, two)
