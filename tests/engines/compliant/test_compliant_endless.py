"""Answers without an end are told so by the finer grid, too, where the usual nodes may have passed over one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from compliant_scenes import watch_paths
from engine_scenes import block, shipped

import holdfast as hf
from holdfast.elastic.system import PathOutcome, PathResult
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.refinement import Bounded
from holdfast.queries.request import push_columns

SIZE = np.array([0.3, 0.2, 0.15])
Change = Callable[[PathResult], PathResult]


def as_it_is(paths: PathResult) -> PathResult:
    return paths


def sharp(paths: PathResult) -> PathResult:
    return paths._replace(sharpest=np.full(len(paths.peak), 0.71))


def dipped(paths: PathResult) -> PathResult:
    return paths._replace(first=np.full(len(paths.peak), 3.0))


def lost(paths: PathResult) -> PathResult:
    return paths._replace(outcome=np.full(len(paths.peak), PathOutcome.LOST))


def ending(paths: PathResult) -> PathResult:
    peak = np.full(len(paths.peak), 5.0)
    return paths._replace(outcome=np.full(len(peak), PathOutcome.PEAK), peak=peak, first=peak)


def asked(monkeypatch: pytest.MonkeyPatch, here: Change, there: Change) -> tuple[Bounded, list[int]]:
    """A press on a cube, which has no end, with what ``here`` and ``there``, on more nodes, make of its path.

    Also returns the nodes of the grids whose paths were followed.
    """

    def change(grid: Grid, found: PathResult) -> PathResult:
        assert (found.outcome == PathOutcome.ENDLESS).all()
        return here(found) if grid.springs.nodes == 7 else there(found)

    assembly, seen = shipped("cube"), watch_paths(monkeypatch, change)
    top = np.add(assembly.movable[0].com_world, (0.01, 0.02, 0.05))
    W = push_columns(assembly, 0, top[None], np.array([[0.0, 0.0, -1.0]]))
    return hf.Compliant().prepare(assembly).refined.answers(W), seen


def test_a_smooth_path_of_few_bodies_is_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    found, seen = asked(monkeypatch, as_it_is, ending)
    assert seen == [7]
    assert found.lower[0] == np.inf


@pytest.mark.parametrize("here", [sharp, dipped])
def test_a_doubtful_one_takes_the_end_that_more_nodes_find(monkeypatch: pytest.MonkeyPatch, here: Change) -> None:
    found, seen = asked(monkeypatch, here, ending)
    assert seen[:2] == [7, 14]
    assert found.paths.outcome[0] == PathOutcome.PEAK
    assert found.paths.peak[0] == 5.0
    assert found.lower[0] <= 5.0


def test_what_the_load_dipped_from_bounds_it_unless_more_nodes_know_nothing_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert asked(monkeypatch, dipped, as_it_is)[0].lower[0] == np.inf
    monkeypatch.undo()
    for there in (dipped, lost):
        found, _ = asked(monkeypatch, dipped, there)
        monkeypatch.undo()
        assert found.paths.outcome[0] == PathOutcome.ENDLESS
        assert found.lower[0] == pytest.approx(0.998 * 3.0, rel=1e-4)


def pallet(equal: bool) -> hf.answers.Assembly:
    """Sixty boxes, every other layer shifted, with the same mass or different ones."""
    rng, places = np.random.default_rng(0), [np.array([i, j, k]) for k in range(3) for j in range(4) for i in range(5)]
    bodies = [block("floor", (20, 20, 0.1), (0, 0, -0.05), fixed=True)]
    for at in places:
        mass = 5.0 * rng.uniform(0.8, 1.2)
        middle = SIZE * np.add(at, (0, 0, 0.5)) + np.array([0.1, 0.05, 0.0]) * (at[2] % 2)
        bodies.append(block("b{}_{}_{}".format(*at), SIZE, middle, 5.0 if equal else mass))
    return hf.assemble(hf.Scene(bodies, 0.5))


@pytest.mark.parametrize("equal", [False, True])
def test_a_press_on_an_edge_of_a_pallet_ends_as_on_most_grids(equal: bool) -> None:
    """Of 5, 8, 10, 14 and 20 nodes a side all end at 1,700 to 1,830 N; the paths on 7 nodes pass over that."""
    push = ("b0_2_0", (-0.05625, 0.35, 0.15), (-0.066, -0.071, -0.995))
    found = hf.robustness(pallet(equal), *push)
    assert 1600 < found.force[0] < 1900
    assert found.lower[0] <= 1775 * 0.98


def test_among_many_bodies_more_nodes_are_asked_whether_a_press_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    assembly, seen = pallet(True), watch_paths(monkeypatch)
    refined = hf.Compliant().prepare(assembly).refined
    number = assembly.index["b2_2_2"]
    top = np.add(assembly.movable[number].com_world, (0.0, 0.0, SIZE[2] / 2))
    W = push_columns(assembly, number, top[None], np.array([[0.0, 0.0, -1.0]]))
    assert refined.answers(W).lower[0] == np.inf
    assert seen == [7, 14]
