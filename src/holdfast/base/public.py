"""What every value that users are handed can do: be saved, become plain data, show itself at a glance."""

from __future__ import annotations

import html
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from holdfast.base.archive import save, to_dict
from holdfast.base.values import LONGEST, Value, cut, items_of, seal

MOST_ROWS = 12  # of a summary
LONGEST_CELL = 160  # characters
LARGEST_PAGE = 9_000  # characters


@dataclass(frozen=True)
class Summary:
    """An answer at a glance: a ``headline``, ``facts`` (name, text), a table of ``rows`` under ``heads``, ``notes``."""

    headline: str
    facts: Sequence[tuple[str, str]] = ()
    heads: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()


class PublicValue(Value):
    """A value that answers a question of a user: declare ``eq=False, repr=False`` with its frozen dataclass."""

    def __post_init__(self) -> None:
        seal(self)

    def summary(self) -> Summary:
        """The answer at a glance."""
        return Summary(", ".join(name for name, _ in items_of(self)))

    def to_dict(self) -> dict[str, Any]:
        """Plain data that every JSON writer takes: arrays are lists, infinity is the text "inf"."""
        return {name: to_dict(item) for name, item in items_of(self)}

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the answer to a .json or .npz file without loss; ``holdfast.load_answer`` reads it back."""
        save(self, path)

    def __repr__(self) -> str:
        headline = "".join(c if c.isprintable() else " " for c in self.summary().headline)
        return f"{type(self).__name__}({cut(headline, LONGEST)})"

    def _repr_html_(self) -> str:
        """For notebooks: headline, facts, a few rows and notes, as a small page without scripts."""
        return as_html(type(self).__name__, self.summary())


def as_html(kind: str, summary: Summary) -> str:
    """A small page: every text is escaped and cut to a sensible length, rows are left out where it would grow large."""
    head = f"<b>{html.escape(kind)}</b> {html.escape(cut(summary.headline, 2 * LONGEST_CELL))}"
    left = LARGEST_PAGE - len(head)
    tables = []
    for heads, rows in (
        ((), summary.facts),
        (summary.heads, summary.rows),
        ((), [[f"note: {note}"] for note in summary.notes]),
    ):
        written = []
        for row in ([heads] if heads and rows else []) + list(rows[:MOST_ROWS]):
            text = f"<tr>{''.join(map(_cell, row))}</tr>"
            if len(text) > left:
                break
            left -= len(text)
            written.append(text)
        if len(rows) > MOST_ROWS:
            written.append(f"<tr>{_cell(f'... and {len(rows) - MOST_ROWS:,} more')}</tr>")
        tables.append(f"<table>{''.join(written)}</table>" if written else "")
    return f"<div><p>{head}</p>{''.join(tables)}</div>"


def _cell(text: str) -> str:
    return f'<td style="text-align:left">{html.escape(cut(text, LONGEST_CELL))}</td>'


def number(value: float, unit: str = "") -> str:
    """A number for people: four digits, ∞ for infinity."""
    text = "∞" if value == float("inf") else f"{value:.4g}"
    return f"{text} {unit}".rstrip()
