"""What a benchmark suite is: named cases, each of which measures and returns rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, BinaryIO

Row = dict[str, Any]  # JSON values; the first key is "case"; seconds under keys that end in " s"
Case = Callable[[], list[Row]]


@dataclass(frozen=True)
class Suite:
    """A suite by name: ``about`` what it measures; its first line says it in brief.

    ``cases`` gives the measurements by label, none of them begun; an interrupted run resumes after the last one done.
    ``plot`` draws all rows as PNG; ``written`` makes the Markdown text of all rows (a plain table if None).
    """

    name: str
    about: str
    cases: Callable[[], Mapping[str, Case]]
    plot: Callable[[list[Row], BinaryIO], None] | None = None
    written: Callable[[list[Row]], str] | None = None


def table(rows: list[Row]) -> str:
    """Rows as a Markdown table."""
    heads = list(dict.fromkeys(key for row in rows for key in row))
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for row in rows:
        values = [row.get(head, "") for head in heads]
        cells = [f"{v:.3g}" if isinstance(v, float) else str(v) for v in values]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)
