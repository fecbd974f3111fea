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

_STYLE = "text-align:left;padding:2px 12px 2px 0"


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
        return f"{type(self).__name__}({cut(self.summary().headline, LONGEST)})"

    def _repr_html_(self) -> str:
        """For notebooks: headline, facts, a few rows and notes, as a small page without scripts."""
        return as_html(type(self).__name__, self.summary())


def as_html(kind: str, summary: Summary) -> str:
    """HTML of a summary; every text is escaped and cut to a sensible length."""

    def cell(tag: str, text: str) -> str:
        return f'<{tag} style="{_STYLE}">{html.escape(cut(text, LONGEST_CELL))}</{tag}>'

    def table(rows: Sequence[str]) -> str:
        return f"<table>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>" if rows else ""

    facts = [cell("th", name) + cell("td", text) for name, text in summary.facts[:MOST_ROWS]]
    rows = ["".join(cell("td", text) for text in row) for row in summary.rows[:MOST_ROWS]]
    if len(summary.rows) > MOST_ROWS:
        rows.append(cell("td", f"... and {len(summary.rows) - MOST_ROWS} more"))
    heads = ["".join(cell("th", text) for text in summary.heads)] if rows and summary.heads else []
    notes = [cell("td", f"note: {note}") for note in summary.notes[:MOST_ROWS]]
    head = f"<p><b>{html.escape(kind)}</b> {html.escape(cut(summary.headline, 2 * LONGEST_CELL))}</p>"
    return f"<div>{head}{table(facts)}{table(heads + rows)}{table(notes)}</div>"


def number(value: float, unit: str = "") -> str:
    """A number for people: four digits, ∞ for infinity."""
    text = "∞" if value == float("inf") else f"{value:.4g}"
    return f"{text} {unit}".rstrip()
