"""Base classes of results. A result holds one table of answers and shows its columns under public names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar, TypeVar

import numpy as np

from holdfast.base.archive import to_dict
from holdfast.base.arrays import Float, Objects, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Of, PublicValue, Summary, at_least, at_most, column, number
from holdfast.base.text import listed
from holdfast.engines.answers import Answers, Bound, Claim, Undecided
from holdfast.engines.mechanism import Mechanism, Mode
from holdfast.engines.verdict import Status, Verdict

T = TypeVar("T")

ROW = "status lower upper moving mode mechanism"  # columns that plain data tells of most answers
SHOWN = 8  # largest number of rows in a summary
NAMED = 4  # largest number of body names in one cell of a summary
ROW_HEADS = ("where", "answer", "between", "status", "what gives way")  # what ``cells`` says of a row


class Result(PublicValue):
    """A result that holds the table ``answers``; this class shows what applies to the whole table."""

    answers: Answers

    engine = Of[str]("answers.engine", "The name of the engine that answered.")
    claim = Of[Claim]("answers.claim", "What the engine promises about its answers.")
    lower_bound = Of[Bound]("answers.lower_bound", "How the bound ``lower`` is known.")
    upper_bound = Of[Bound]("answers.upper_bound", "How the bound ``upper`` is known.")
    notes = Of[tuple[str, ...]](
        "answers.notes",
        "What the reader of the scene's file guessed or left out, and the simplifications of the answer.",
    )
    verdict = Of[Verdict](
        "answers.verdict", "The verdict on whether the assembly stands under the standing loads alone."
    )

    def about(self) -> dict[str, Any]:
        """Return what applies to the whole table as plain data."""
        return {
            "engine": self.engine,
            "claim": self.claim.value,
            "verdict": {"status": self.verdict.status.value, "reason": self.verdict.reason},
            "lower_bound": self.lower_bound.value,
            "upper_bound": self.upper_bound.value,
            "notes": list(self.notes),
            "undecided": self.answers.undecided.to_dict(),
        }

    def facts(self) -> list[tuple[str, str]]:
        """Return what applies to the whole table as (name, text) pairs for a summary."""
        undecided = self.answers.undecided
        return [
            ("engine", f"{self.engine} ({self.claim.words})"),
            ("verdict", f"{self.verdict.status}: {self.verdict.reason}"),
            *([("not known", undecided.text)] if undecided.count else []),
            ("lower bound", self.lower_bound.value),
            ("upper bound", self.upper_bound.value),
        ]


class Columns(Result):
    """A result with n rows, each of which answers one load."""

    unit: ClassVar[str] = ""
    heads: ClassVar[tuple[str, str]] = ("where", "answer")  # of the first columns of the table in a summary

    answers: Answers = column("n")

    status = Of[Objects]("answers.status", "The status (n,) of each answer: FINITE, INFINITE, UNSTABLE or UNDECIDED.")
    undecided = Of[Undecided](
        "answers.undecided", "How many of the n answers are not known (``count``, ``share``), and why (``reasons``)."
    )
    lower = Of[Float]("answers.lower", "The lower bounds (n,) of the true answers, as far as the engine promises them.")
    upper = Of[Float]("answers.upper", "The upper bounds (n,) of the true answers, as far as the engine promises them.")
    moving = Of[Objects]("answers.moving", "The names (n,) of the bodies that begin to move, one tuple for each row.")
    mode = Of[Objects](
        "answers.mode", 'What the contacts do (n,): "slip", "topple", "mixed", "roll", "crush" or "none".'
    )
    mechanism = Of[Objects]("answers.mechanism", "The mechanism (n,) of each row, or None where nothing gives way.")

    def explain(self, row: int | None = None) -> str:
        """Explain in lines of text how one answer came about: the raw answer, then each amendment and its reason.

        By default it is the row with the smallest ``lower``, the bound that holds for all rows. Raises HoldfastError
        if there is no such row.
        """
        if row is None:
            row = self.answers.holding or 0
        if not -len(self.answers) <= row < len(self.answers):
            raise HoldfastError(message("explain", f"there is no row {row}", f"there are {len(self.answers)}"))
        return self.answers.explained(row, self.unit)

    def __float__(self) -> float:
        """Return the answer of a result with one row; raise HoldfastError if it has several or is undecided."""
        return only_answer(self)

    def about(self) -> dict[str, Any]:
        """Return what applies to the whole table as plain data, with the bound that holds for all rows.

        ``holds`` is the smallest ``lower`` with the number of its ``row`` and the load of that row. It is None if the
        engine promises no lower bound. The entry is named ``exists`` if the engine promises no more than that an
        equilibrium exists up to there.
        """
        row = self.answers.holding
        least = None if row is None else {"lower": to_dict(float(self.lower[row])), "row": row} | self.where(row)
        return super().about() | {"exists" if self.claim is Claim.EXISTS else "holds": least}

    def where(self, row: int) -> dict[str, Any]:
        """Return the load that a row answers, as plain data."""
        return {}

    def table(self, headline: str, places: Objects) -> Summary:
        """Return a summary with the rows with the smallest answers; undecided rows come last.

        ``places`` (n,) are texts that say which load each row answers.
        """
        rows = [cells(str(places[k]), self.answers, k, self.unit) for k in self.answers.ranking[:SHOWN].tolist()]
        return Summary(headline, self.facts(), (*self.heads, *ROW_HEADS[2:]), rows, self.notes)


class Forces(Columns):
    """A result whose n rows are forces."""

    unit: ClassVar[str] = "N"

    force = Of[Float]("answers.force", "The largest force (n,) [N] before anything moves.")


class First(Of[T]):
    """The only row of a column of a table of answers."""

    def __init__(self, name: str, text: str) -> None:
        property.__init__(self, lambda result: getattr(result.answers, name).item(0))
        self.__doc__ = text


class Single(Result):
    """A result with one row, whose columns are shown as single values."""

    answers: Answers = column("1")

    status = First[Status]("status", "The status of the answer: FINITE, INFINITE, UNSTABLE or UNDECIDED.")
    lower = First[float]("lower", "The lower bound of the true answer, as far as the engine can promise it.")
    upper = First[float]("upper", "The upper bound of the true answer, as far as the engine can promise it.")
    moving = First[tuple[str, ...]]("moving", "The names of the bodies that begin to move.")
    mode = First[Mode]("mode", 'What the contacts do: "slip", "topple", "mixed", "roll", "crush" or "none".')
    mechanism = First[Mechanism | None](
        "mechanism", "The motion with which the bodies begin to move, or None if nothing gives way."
    )

    def __float__(self) -> float:
        """Return the answer; raise HoldfastError if it is undecided."""
        return only_answer(self)


def only_answer(result: Result) -> float:
    """Return the only answer of a result; raise HoldfastError if there are several, or if it is undecided."""
    where, answers = f"float() of {type(result).__name__}", result.answers
    if len(answers) != 1:
        remedy = "take one of them, as float(answer.lower[0]), or the least one, as answer.lower.min()"
        raise HoldfastError(message(where, f"it holds {len(answers):,} answers", remedy))
    if not answers.decided[0]:
        raise HoldfastError(message(where, "the answer is not known", "ask .status, and .undecided for the reason"))
    return float(answers.force[0])


def cells(place: str, answers: Any, row: int, unit: str) -> list[str]:  # noqa: ANN401 - of any class with columns
    """Return what a table shows of one row of answers, about the load at this ``place``."""
    return [
        place,
        amount(answers.status[row], answers.force[row], unit),
        f"{at_most(answers.lower[row])} to {at_least(answers.upper[row])}",
        str(answers.status[row]),
        gives_way(answers.mode[row], answers.moving[row]),
    ]


def gives_way(mode: str, moving: tuple[str, ...]) -> str:
    """Describe in a few words which bodies move and what the contacts do."""
    return f"{kind_of(mode)}: {listed(moving, NAMED)}" if moving else "nothing"


def kind_of(mode: str) -> str:
    """Return the mode as a noun for what bodies do: those that only holds keep move, though no contact gives way."""
    return "motion" if mode == "none" else mode


def verdict_words(verdict: Verdict) -> str:
    """Describe the verdict in a few words."""
    return {Status.STABLE: "it stands", Status.UNSTABLE: "it does not stand"}.get(verdict.status, "undecided")


def least(answers: Answers, unit: str) -> str:
    """Describe the smallest decided answer, the bound that holds for all rows, and how many rows are undecided."""
    known = answers.force[answers.decided]
    first = "an equilibrium exists up to" if answers.claim is Claim.EXISTS else "the least"
    words = [f"{first} {number(float(np.min(known)), unit)}"] if len(known) else []
    return "; ".join(filter(None, [*words, promised(answers, unit), answers.undecided.text])) or "none"


def promised(answers: Answers, unit: str = "") -> str:
    """Describe the bound that holds for all rows; "" if it is zero, or infinite because no load moves anything."""
    row = answers.holding
    if row is None or not 0 < answers.lower[row] < np.inf:
        return ""
    return holds_up_to(answers, row, unit)


def holds_up_to(answers: Answers, row: int, unit: str = "") -> str:
    """Describe the lower bound of a row and how it is known."""
    what = "have an equilibrium" if answers.claim is Claim.EXISTS else "hold"
    return f"{answers.lower_bound} to {what} up to {at_most(answers.lower[row], unit)}"


def doubted(answers: Answers, row: int) -> bool:
    """Tell whether a row that is INFINITE is promised to hold up to a finite ``lower`` only."""
    return answers.claim is Claim.HOLDS and bool(np.isfinite(answers.lower[row]))


def endless(answers: Answers, row: int, unit: str) -> str:
    """Describe a row that is INFINITE: nothing moves where ``lower`` says so, too, and else what ``lower`` says."""
    if doubted(answers, row):
        return f"no limit found, {holds_up_to(answers, row, unit)} only"
    return "an equilibrium exists" if answers.claim is Claim.EXISTS else "nothing moves"


def amount(status: Status, value: float, unit: str = "") -> str:
    """Return the value of an answer with its unit, or "?" if the answer is undecided."""
    return "?" if status is Status.UNDECIDED else number(value, unit)


def vector_text(values: Iterable[float], form: str = ".3g") -> str:
    """Return a vector as text, such as "(0.1, 0, 0.25)", with its numbers formatted by ``form``."""
    return "(" + ", ".join(f"{value + 0.0:{form}}" for value in values) + ")"


def places_of(points: Float) -> Objects:
    """Return texts (n,) that say where the points (n, 3) [m] are."""
    return objects([f"{vector_text(point, '.3f')} m" for point in points])
