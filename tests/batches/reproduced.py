"""What two runs of one scene have in common."""

from __future__ import annotations

from holdfast.batches.schema import TABLES, Row


def reproducible(table: str, row: Row) -> Row:
    """Return a row without the columns in which two runs of one scene may differ."""
    differing = {column.name for column in TABLES[table] if not column.reproducible}
    return {name: value for name, value in row.items() if name not in differing}
