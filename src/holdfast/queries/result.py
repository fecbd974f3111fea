"""Results: each holds one table of answers and shows its columns under the public names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from holdfast.base.archive import to_dict
from holdfast.base.arrays import Bool, Float, Int, Objects, objects
from holdfast.base.public import PublicValue, Summary, number
from holdfast.engines.answers import Answers, Bound, Claim
from holdfast.engines.mechanism import Mechanism, Mode
from holdfast.engines.verdict import Status, Verdict

SHOWN = 8  # rows of a summary
NAMED = 4  # bodies in a cell


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Result(PublicValue):
    """A result that holds ``answers``; what is said of the whole table is here."""

    answers: Answers

    @property
    def engine(self) -> str:
        """The engine's name."""
        return self.answers.engine

    @property
    def claim(self) -> Claim:
        """What the engine promises."""
        return self.answers.claim

    @property
    def lower_bound(self) -> Bound:
        """How ``lower`` is known."""
        return self.answers.lower_bound

    @property
    def upper_bound(self) -> Bound:
        """How ``upper`` is known."""
        return self.answers.upper_bound

    @property
    def notes(self) -> tuple[str, ...]:
        """Simplifications that the answer rests on."""
        return self.answers.notes

    @property
    def verdict(self) -> Verdict:
        """Whether the assembly stands under the standing loads alone."""
        return self.answers.verdict

    def about(self) -> dict[str, Any]:
        """Plain data: what is said of the whole table."""
        return {
            "engine": self.engine,
            "claim": self.claim.value,
            "verdict": {"status": self.verdict.status.value, "reason": self.verdict.reason},
            "lower_bound": self.lower_bound.value,
            "upper_bound": self.upper_bound.value,
            "notes": list(self.notes),
        }

    def facts(self) -> list[tuple[str, str]]:
        """For a summary: what is said of the whole table."""
        return [
            ("engine", f"{self.engine} ({self.claim})"),
            ("verdict", f"{self.verdict.status}: {self.verdict.reason}"),
            ("lower bound", KNOWN_HOW[self.lower_bound]),
            ("upper bound", KNOWN_HOW[self.upper_bound]),
        ]


KNOWN_HOW = {Bound.PROVED: "proved", Bound.ESTIMATED: "estimated", Bound.NONE: "none"}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Columns(Result):
    """A result of n rows."""

    @property
    def status(self) -> Objects:
        """(n,) FINITE, INFINITE, UNSTABLE or UNDECIDED."""
        return self.answers.status

    @property
    def lower(self) -> Float:
        """(n,) below the true answer, as far as the engine can promise."""
        return self.answers.lower

    @property
    def upper(self) -> Float:
        """(n,) above the true answer, as far as the engine can promise."""
        return self.answers.upper

    @property
    def moving(self) -> Objects:
        """(n,) names of the bodies that begin to move."""
        return self.answers.moving

    @property
    def mode(self) -> Objects:
        """(n,) "slip", "topple", "mixed" or "none"."""
        return self.answers.mode

    @property
    def mechanism(self) -> Objects:
        """(n,) a Mechanism each, or None."""
        return self.answers.mechanism

    @property
    def solved(self) -> Bool:
        """(n,) false where the answer was carried over from neighbouring loads."""
        return self.answers.solved

    @property
    def error(self) -> Float:
        """(n,) the stated relative error where it was, 0 elsewhere."""
        return self.answers.error

    def columns(self, *names: str) -> dict[str, Any]:
        """Plain data of these attributes."""
        return {name: to_dict(getattr(self, name)) for name in names}

    def weakest_rows(self, unit: str, places: Objects | None = None) -> list[list[str]]:
        """For a summary: the rows with the smallest answers, ``places`` (n,) saying where each is."""
        answers = self.answers
        order: Int = np.argsort(answers.force, kind="stable")[:SHOWN]
        return [
            [
                "" if places is None else str(places[k]),
                number(answers.force[k], unit),
                f"{number(answers.lower[k])} to {number(answers.upper[k])}",
                str(answers.status[k]),
                gives_way(answers.mode[k], answers.moving[k]),
            ]
            for k in order.tolist()
        ]


ROW_HEADS = ("where", "answer", "between", "status", "what gives way")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Forces(Columns):
    """A result of n forces."""

    @property
    def force(self) -> Float:
        """(n,) [N]."""
        return self.answers.force

    def table(self, headline: str, places: Objects | None = None) -> Summary:
        """The weakest rows under a headline."""
        rows = self.weakest_rows("N", places)
        return Summary(headline, self.facts(), ROW_HEADS, rows, self.notes)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Single(Result):
    """A result of one row, shown as single values."""

    @property
    def status(self) -> Status:
        """FINITE, INFINITE, UNSTABLE or UNDECIDED."""
        status: Status = self.answers.status[0]
        return status

    @property
    def lower(self) -> float:
        """Below the true answer, as far as the engine can promise."""
        return float(self.answers.lower[0])

    @property
    def upper(self) -> float:
        """Above the true answer, as far as the engine can promise."""
        return float(self.answers.upper[0])

    @property
    def moving(self) -> tuple[str, ...]:
        """Names of the bodies that begin to move."""
        moving: tuple[str, ...] = self.answers.moving[0]
        return moving

    @property
    def mode(self) -> Mode:
        """What contacts do: "slip", "topple", "mixed" or "none"."""
        mode: Mode = self.answers.mode[0]
        return mode

    @property
    def mechanism(self) -> Mechanism | None:
        """How bodies begin to move, None where nothing gives way."""
        mechanism: Mechanism | None = self.answers.mechanism[0]
        return mechanism

    @property
    def solved(self) -> bool:
        """False where the answer was carried over from neighbouring loads."""
        return bool(self.answers.solved[0])

    @property
    def error(self) -> float:
        """The stated relative error where it was, else 0."""
        return float(self.answers.error[0])

    def values(self, *names: str) -> dict[str, Any]:
        """Plain data of these attributes."""
        return {name: to_dict(getattr(self, name)) for name in names}


def gives_way(mode: str, moving: tuple[str, ...]) -> str:
    """What moves, in a few words."""
    more = f" and {len(moving) - NAMED} more" if len(moving) > NAMED else ""
    return f"{mode}: {', '.join(moving[:NAMED])}{more}" if moving else "nothing"


def told(verdict: Verdict) -> str:
    """The verdict in two words."""
    return {Status.STABLE: "it stands", Status.UNSTABLE: "it does not stand"}.get(verdict.status, "undecided")


def least(values: Float, unit: str) -> str:
    """The smallest of some values, in words."""
    return f"the least {number(float(np.min(values)), unit)}" if len(values) else "none"


def places_of(points: Float, bodies: Objects | None = None) -> Objects:
    """(n,) texts that say where points (n, 3) are."""
    names = [""] * len(points) if bodies is None else [f"{name} " for name in bodies]
    places = ("(" + ", ".join(f"{v + 0.0:.3f}" for v in point) + ") m" for point in points)
    return objects([name + place for name, place in zip(names, places, strict=True)])
