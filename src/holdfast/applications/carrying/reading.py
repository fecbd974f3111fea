"""Read motions of a carrier from CSV files."""

from __future__ import annotations

import re

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.text import quoted

COLUMNS = ("t", "ax", "ay", "az", "alphax", "alphay", "alphaz", "omegax", "omegay", "omegaz")
NEEDED = 4  # number of columns that every table must have


def table_of(content: bytes) -> Float:
    """Return the rows of a CSV file with columns in the order of COLUMNS.

    If the first row names the columns, the result has all COLUMNS, with zeros in those that the file lacks. Otherwise
    it has the columns of the file. Raises HoldfastError if a row does not hold numbers, or if the first row names other
    columns.
    """
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise HoldfastError(message("profile", "is not a text", "needs a CSV file")) from None
    numbered = [(k, line.strip()) for k, line in enumerate(lines, 1) if line.strip() and line.strip()[0] != "#"]
    if not numbered:
        raise HoldfastError(message("profile", "has no rows", f"needs rows of {', '.join(COLUMNS[:NEEDED])}"))
    first = _cells(numbered[0][1])
    names = None if _is_number(first[0]) else _names(first)
    body = numbered if names is None else numbered[1:]
    rows = [_numbers(number, line, len(first)) for number, line in body]
    table = np.array(rows).reshape(-1, len(first))
    if names is None:
        return table
    ordered = np.zeros((len(table), len(COLUMNS)))
    ordered[:, [COLUMNS.index(name) for name in names]] = table
    return ordered


def _cells(line: str) -> list[str]:
    """Return the cells of a row, separated by semicolons, commas, tabs or spaces.

    Between semicolons, numbers may have a decimal comma.
    """
    if ";" in line:
        return [cell.strip().replace(",", ".") for cell in line.split(";")]
    return [cell.strip() for cell in line.split(",")] if "," in line else line.split()


def _names(cells: list[str]) -> list[str]:
    """Return the names of the columns, without units in brackets and without anything that is not a letter."""
    names = [re.sub(r"[^a-z]", "", re.sub(r"[\[(].*", "", cell.lower())) for cell in cells]
    names = ["t" if name == "time" else name for name in names]
    unknown = [cell for cell, name in zip(cells, names, strict=True) if name not in COLUMNS]
    if unknown:
        problem = f"has a column {quoted(unknown[0])}"
        raise HoldfastError(message("profile", problem, f"known: {', '.join(COLUMNS)}"))
    missing = [name for name in COLUMNS[:NEEDED] if name not in names]
    if missing or len(set(names)) < len(names):
        problem = f"has no column {missing[0]}" if missing else "names a column twice"
        raise HoldfastError(message("profile", problem, f"needs {', '.join(COLUMNS[:NEEDED])}, each once"))
    return names


def _numbers(number: int, line: str, count: int) -> list[float]:
    cells = _cells(line)
    if len(cells) != count:
        raise HoldfastError(message("profile", f"row {number} has {len(cells)} cells", f"needs {count}"))
    try:
        return [float(cell) for cell in cells]
    except ValueError:
        raise HoldfastError(message("profile", f"row {number} is {quoted(line, 60)}", "needs numbers")) from None


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
