"""What predicted_and_measured.md says of measured and printed numbers, held against the saved results."""

from __future__ import annotations

import math

import pytest

from bench.checkout import RESULTS
from bench.experiments.source import least, row, same
from bench.figures.saved_rows import Saved


@pytest.fixture(scope="module")
def saved() -> Saved:
    return Saved(RESULTS, "experiments")


def test_every_printed_number_agrees_to_its_last_digit_or_the_difference_is_explained(saved: Saved) -> None:
    printed = [one for one in saved.rows if "printed" in one]
    assert len(printed) > 35
    for one in printed:
        assert same(one["printed"], one[one["meant"]]) is not bool(one["why"]), one["case"]


def test_no_verdict_is_stable_on_the_wrong_side(saved: Saved) -> None:
    asked = [one for one in saved.rows if "falls to %" in one]
    assert len(asked) > 20
    for one in asked:
        assert float(one["falls to %"]) < 0 < float(one["stands from %"]), one["case"]


def test_the_margins_that_the_pages_recommend_covered_the_pushes(saved: Saved) -> None:
    def above(margin: str) -> float:
        return saved.value(f"margin: {margin}", "all, above %")

    assert above("0.8 compliant") == above("5 % quantile, friction within 20%") == 100
    assert above("μ m g") < above("graph") < above("limit") < above("compliant") <= above("lower")
    assert saved.value("pushes, R²", "compliant") > 0.7 > 0 > saved.value("pushes, R²", "μ m g")


def test_only_summary_numbers_of_the_pushes_are_saved(saved: Saved) -> None:
    """The logs from which the rows were taken are under the GPL."""
    groups = [one for one in saved.rows if one["case"].startswith(("pushes", "margin", "whole face", "feet"))]
    assert groups
    assert not [one for one in groups if any(isinstance(value, list) for value in one.values())]
    assert min(one.get("pushes", 50) for one in groups) >= 5, "a group of fewer would be a row"


def test_what_disagrees_needs_a_reason_and_what_agrees_has_none() -> None:
    assert row("try", "0.785", "limit", "", limit=0.7854)["agrees"]
    assert not row("try", "0.785", "limit", "coarse", limit=0.786)["agrees"]
    for why, value in (("", 0.786), ("coarse", 0.7854)):
        with pytest.raises(ValueError, match=r"0\.785 beside"):
            row("try", "0.785", "limit", why, limit=value)
    assert same("stands", "stands")
    assert not same("stands", "undecided")


@pytest.mark.parametrize(("falls", "stands"), [(0.0, 4.0), (4.0, 0.0)])
def test_the_value_from_which_on_it_holds_is_found_from_either_side(falls: float, stands: float) -> None:
    found = least(lambda value: (value > math.pi) == (stands > falls), falls, stands, 1e-6)
    assert found == pytest.approx(math.pi, abs=1e-6)
