"""The base class of answers that users receive: they can be saved, turned into plain data, and summarised."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from holdfast.base.archive import save, to_dict
from holdfast.base.painters import glimpse
from holdfast.base.text import escaped, one_line
from holdfast.base.values import LONGEST, Value, items_of, seal

MOST_ROWS = 12  # largest number of rows of each table that a summary shows
LONGEST_CELL = 160  # largest number of characters in a cell of a table
LARGEST_PAGE = 9_000  # largest number of characters of the HTML of a summary


@dataclass(frozen=True)
class Summary:
    """A short summary of an answer.

    It has a ``headline``, ``facts`` as pairs (name, text), a table of ``rows`` with the column titles ``heads``, and
    ``notes``.
    """

    headline: str
    facts: Sequence[tuple[str, str]] = ()
    heads: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()
    notes: Sequence[str] = ()


class PublicValue(Value):
    """Base class of the answers that users receive.

    A subclass is a frozen dataclass declared with ``eq=False, repr=False``. Its arrays are made read-only.
    """

    def __post_init__(self) -> None:
        seal(self)

    def summary(self) -> Summary:
        """Return a short summary of the answer."""
        return Summary(", ".join(name for name, _ in items_of(self)))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data that every JSON writer accepts: arrays become lists, infinity becomes the text "inf"."""
        return {name: to_dict(item) for name, item in items_of(self)}

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the answer to a .json or .npz file without loss. ``holdfast.load_answer`` reads it back.

        Raises HoldfastError for any other suffix or if the file cannot be written.
        """
        save(self, path)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({one_line(self.summary().headline, LONGEST)})"

    def _repr_html_(self) -> str:
        """Return the answer for notebooks: a small picture, headline, facts, a few rows and notes, without scripts."""
        return in_notebook(self, self.summary())


def in_notebook(value: object, summary: Summary) -> str:
    """Return a value as HTML for notebooks: its picture, if it has one, above its summary.

    Text has the colour of the page and pictures have a background of their own, so both are readable on light and dark
    pages.
    """
    return f"<div>{glimpse(value)}{as_html(type(value).__name__, summary)}</div>"


def as_html(kind: str, summary: Summary) -> str:
    """Return a summary as a small piece of HTML.

    Every text is escaped and shortened to a sensible length. Rows are left out if the HTML would become too large.
    """
    head = f"<b>{kind}</b> {escaped(summary.headline, 2 * LONGEST_CELL)}"
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
    return f'<td style="text-align:left">{escaped(text, LONGEST_CELL)}</td>'


def number(value: float, unit: str = "") -> str:
    """Return a number as text for people, with four significant digits, ∞ for infinity, and its unit."""
    text = "∞" if value == float("inf") else f"{value:.4g}"
    return f"{text} {unit}".rstrip()
