"""Saved benchmark results as the figures read them, and the ways in which a figure is printed."""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from holdfast.base.errors import HoldfastError


class UnknownResultError(HoldfastError):
    """A figure asks for a file, a case or a column that was not saved."""


class Saved:
    """The rows of one benchmark suite by case; of several suites, whose names are joined by a plus sign, all rows."""

    def __init__(self, folder: Path, suites: str) -> None:
        self.rows: list[dict[str, Any]] = []
        self.paths = " and ".join(str(folder / f"{suite}.json") for suite in suites.split("+"))
        for suite in suites.split("+"):
            path = folder / f"{suite}.json"
            if not path.exists():
                raise UnknownResultError(f"{path} does not exist; run `python -m bench run {suite} --save`")
            self.rows += json.loads(path.read_text(encoding="utf-8"))["rows"]
        self._by_case = {row["case"]: row for row in self.rows}

    def row(self, case: str) -> dict[str, Any]:
        """All columns of a case."""
        if case not in self._by_case:
            raise UnknownResultError(f"{self.paths} has no case {case!r}{_hint(case, self._by_case)}")
        return self._by_case[case]

    def value(self, case: str, column: str) -> float:
        """One number; infinity is saved as the text "inf"."""
        row = self.row(case)
        if column not in row:
            raise UnknownResultError(f"{self.paths}, case {case!r}, has no column {column!r}{_hint(column, row)}")
        return float(row[column])

    def values(self, cases: Iterable[str], column: str) -> list[float]:
        """One number for each case."""
        return [self.value(case, column) for case in cases]


def _hint(word: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(word, list(known), n=1)
    return f"; did you mean {near[0]!r}?" if near else ""


def rounded(value: float, digits: int = 2) -> str:
    """The number to ``digits`` significant digits, without an exponent and with commas between thousands."""
    if not math.isfinite(value):
        return "inf"
    if value == 0:
        return "0"
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    text = f"{round(value, decimals):,.{max(decimals, 0)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def whole(value: float) -> str:
    """The number without decimals, with commas between thousands."""
    return f"{value:,.0f}"


def significant(value: float, digits: int = 2) -> str:
    """To ``digits`` significant digits, or to whole numbers where that says more: 0.015, 9.5, 287, 3,067."""
    return whole(value) if abs(value) >= 10**digits else rounded(value, digits)


def listed(texts: Sequence[str]) -> str:
    """A list as it stands in a sentence: "21, 40 and 41"."""
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"


def span(texts: Sequence[str]) -> str:
    """A range as it stands in a sentence: "4 to 9"; a single number where both ends print alike."""
    return texts[0] if texts[0] == texts[-1] else f"{texts[0]} to {texts[-1]}"


def mean(values: Sequence[float]) -> float:
    """The arithmetic mean."""
    return sum(values) / len(values)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]], numbers_from: int = 1) -> str:
    """A Markdown table whose columns from ``numbers_from`` on are aligned to the right."""
    rule = ["---" if k < numbers_from else "--:" for k in range(len(heads))]
    lines = [f"| {' | '.join(cells)} |" for cells in ([*heads], *([*row] for row in rows))]
    return "\n".join([lines[0], f"|{'|'.join(rule)}|", *lines[1:]])
