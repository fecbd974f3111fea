"""Read CSV files: manifests and lists of pushes."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from itertools import zip_longest

from holdfast.base.errors import HoldfastError, message

Row = dict[str, str | None]  # values by the names of the columns; None where a line is too short


def csv_rows(content: bytes, where: str) -> Iterator[tuple[int, Row]]:
    """Yield the rows of a CSV file, each with the number of its line; the first row has the column names as keys.

    Raises HoldfastError, with ``where`` and the line in its message, for content that is not UTF-8 or not CSV.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as cause:
        line = content.count(b"\n", 0, cause.start) + 1
        problem = f"has the byte 0x{content[cause.start]:02x}, which is not UTF-8"
        raise HoldfastError(message(f"{where}, line {line}", problem, "save it as UTF-8")) from cause
    lines = csv.reader(io.StringIO(text, newline=""))
    try:
        names = next(lines, [])
        yield 1, dict.fromkeys(names)
        for values in lines:
            if values:
                yield lines.line_num, dict(zip_longest(names, values[: len(names)]))
    except csv.Error as cause:  # for example a field of more than 131,072 characters
        remedy = "shorten the field, or close the quotation mark that begins it"
        raise HoldfastError(message(f"{where}, line {lines.line_num}", f"is no CSV: {cause}", remedy)) from cause
