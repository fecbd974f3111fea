"""What two runs of one scene have in common."""

from __future__ import annotations

from pathlib import Path

import holdfast as hf
from holdfast.batches.tables import TABLES, Row


def reproducible(table: str, row: Row) -> Row:
    """Return a row without the columns in which two runs of one scene may differ."""
    differing = {column.name for column in TABLES[table] if not column.reproducible}
    return {name: value for name, value in row.items() if name not in differing}


def rows(out: Path) -> dict[str, list[Row]]:
    """All rows of all tables of a folder, as far as two runs give the same."""
    found = hf.read_batch(out)
    return {name: [reproducible(name, row) for row in found.rows(name)] for name in TABLES}
