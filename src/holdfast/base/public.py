"""What answers are made of: records that declare columns; and how these are saved, told, summarised and drawn."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Never, TypeVar, dataclass_transform

from holdfast.base.archive import archived, save, to_dict
from holdfast.base.errors import no_truth
from holdfast.base.painters import glimpse, paint
from holdfast.base.text import escaped, one_line
from holdfast.base.values import LONGEST, Value, items_of, seal

T = TypeVar("T")

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


def column(shape: str, *, of: Any = None, **default: Any) -> Any:  # noqa: ANN401 - of any field
    """Declare a field of a record with its ``shape``: "n 3" is (n, 3) for any n, the same in all columns of a record.

    ``of`` is the annotation of what an array of objects holds. ``default`` may be that of the field.
    """
    return field(metadata={"shape": shape, "of": of}, **default)


@dataclass_transform(eq_default=False, frozen_default=True, field_specifiers=(column, field))
class Record(Value):
    """A value that is declared by its annotations alone: a frozen dataclass that can be saved, under its name.

    Its arrays are made read-only. What is read from a file is checked against annotations and columns. Arguments of the
    class are ``kw_only``, as of a dataclass, and ``ask``: what to ask instead of the truth of a value, an error.
    ``plain`` names what plain data holds, in that order; by default it is all fields.
    """

    plain: ClassVar[str] = ""

    def __init_subclass__(cls, *, kw_only: bool = False, ask: str = "") -> None:
        super().__init_subclass__()
        dataclass(frozen=True, eq=False, repr=False, kw_only=kw_only)(cls)
        archived(cls)
        if ask:

            def refused(value: object) -> bool:
                raise no_truth(value, f"ask {ask}")

            cls.__bool__ = refused  # type: ignore[attr-defined]

    __post_init__ = seal

    def to_dict(self) -> dict[str, Any]:
        """Return plain data that every JSON writer accepts: arrays become lists, infinity becomes the text "inf"."""
        names = self.plain.split() or [name for name, _ in items_of(self)]
        return {name: to_dict(getattr(self, name)) for name in names}


class Of(property, Generic[T]):
    """What a part of a record knows, as an attribute of it: ``engine = Of[str]("answers.engine", "Its name.")``."""

    def __init__(self, path: str, text: str) -> None:
        super().__init__(attrgetter(path))
        self.__doc__ = text

    if TYPE_CHECKING:

        def __get__(self, record: object, owner: type | None = None, /) -> T: ...  # type: ignore[override]

        def __set__(self, record: object, value: Never, /) -> None: ...


@dataclass_transform(eq_default=False, frozen_default=True, kw_only_default=True, field_specifiers=(column, field))
class PublicValue(Record):
    """Base class of the answers that users receive."""

    def __init_subclass__(cls, *, kw_only: bool = True, ask: str = "") -> None:
        super().__init_subclass__(kw_only=kw_only, ask=ask)

    def summary(self) -> Summary:
        """Return a short summary of the answer."""
        return Summary(", ".join(name for name, _ in items_of(self)))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data that every JSON writer accepts: arrays become lists, infinity becomes the text "inf"."""
        return self.about() | super().to_dict()

    def about(self) -> dict[str, Any]:
        """Return what plain data begins with."""
        return {}

    def data(self) -> dict[str, Any]:
        """Return the answer as plain data in the layout ``holdfast-answer/1``, which commands print with ``--json``.

        ``holdfast schema answer`` prints its JSON schema; see docs/howto/json.md.
        """
        from holdfast.base.envelope import enveloped  # which only those need who ask for JSON

        return enveloped(self)

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


class Pictured:
    """An answer that can be drawn."""

    def save_png(self, path: str | os.PathLike[str]) -> None:
        """Draw the answer as a PNG picture; this needs no display."""
        paint(self, path, ".png")


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


def at_most(value: float, unit: str = "") -> str:
    """Return ``number`` of a lower bound: rounded down, so that the text promises no more than the value."""
    return number(float(Context(prec=4, rounding=ROUND_FLOOR).create_decimal_from_float(value)), unit)


def at_least(value: float, unit: str = "") -> str:
    """Return ``number`` of an upper bound: rounded up."""
    return number(float(Context(prec=4, rounding=ROUND_CEILING).create_decimal_from_float(value)), unit)
