"""Long load paths end close to what limit analysis proves that they do not pass."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from holdfast.assembly.assembly import body_forces
from holdfast.elastic.path import CLOSE
from holdfast.engines.compliant.certain import Certain
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.contract import FORCES_ONLY
from holdfast.engines.groups import prepared
from holdfast.scene.shipped.blocks import wall

WAYS = 4


def columns(assembly: hf.Assembly) -> np.ndarray:
    """Level accelerations of all bodies."""
    angles = 0.3 + 2 * np.pi * np.arange(WAYS) / WAYS
    ways = np.stack([np.cos(angles), np.sin(angles), np.zeros(WAYS)], 1)
    return np.column_stack([body_forces(-assembly.mass[:, None] * way) for way in ways])


@pytest.fixture
def bricks() -> hf.Assembly:
    return hf.assemble(wall(3, 3, 0.25, "wall"))


def test_answers_are_a_thousandth_lower_at_most_and_never_higher(
    bricks: hf.Assembly, monkeypatch: pytest.MonkeyPatch
) -> None:
    W = columns(bricks)
    whole = prepared(hf.Compliant(), bricks).load_factor(W, FORCES_ONLY).force
    monkeypatch.setattr("holdfast.elastic.system.patience", lambda _: 1)
    cut = prepared(hf.Compliant(), bricks).load_factor(W, FORCES_ONLY).force
    most = prepared(hf.Limit(), bricks).load_factor(W).upper
    assert np.isfinite(most).all()
    np.testing.assert_array_less(cut, whole * (1 + 1e-6))
    np.testing.assert_array_less((1 - 2 * CLOSE) * whole, cut)
    assert (cut < most).all()
    assert (cut < whole * (1 - 1e-5)).any(), "no path was cut short: the test would show nothing"


def test_a_ceiling_is_that_of_limit_analysis_once_a_question_and_shared_by_all_grids(
    bricks: hf.Assembly, monkeypatch: pytest.MonkeyPatch
) -> None:
    W = columns(bricks)
    grid = Grid.of(bricks, bricks.weight_wrench(), hf.Compliant().springs)
    assert grid.finer.certain is grid.certain is grid.with_hold.certain
    solved: list[bytes] = []
    proved = Certain._proved
    monkeypatch.setattr(Certain, "_proved", lambda self, w: (solved.append(w.tobytes()), proved(self, w))[1])
    tops = [grid.certain.highest(column) for column in W.T]
    assert [grid.finer.certain.highest(column) for column in W.T] == tops
    assert len(solved) == WAYS
    np.testing.assert_allclose(tops, grid.certain.state.load_factor(W).upper, rtol=1e-9)
    grid.certain.forget()
    assert grid.certain.highest(W[:, 0]) == tops[0]
    assert len(solved) == WAYS + 1


def test_where_nothing_stands_there_is_no_ceiling() -> None:
    bricks = hf.assemble(wall(2, 2, 0.25, "wall"))
    fallen = Certain(bricks, -bricks.weight_wrench())
    assert fallen.highest(columns(bricks)[:, 0]) == np.inf
