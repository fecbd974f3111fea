"""The table of answers that every engine returns and every result holds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import field, replace
from enum import StrEnum, auto
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Int, Objects, frozen, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Record, at_most, column, number
from holdfast.base.text import listed
from holdfast.base.values import altered
from holdfast.engines.mechanism import NAMED, Mechanism
from holdfast.engines.verdict import Status, Verdict

ABOVE = "limit analysis proves that something moves above this"
COLUMNS = ("force", "lower", "upper", "status", "mechanism")
SIGNIFICANT = 6  # forces are ranked after rounding to about this many significant digits
MOST_REASONS = 3  # the most reasons in one line of text


@archived
class Claim(StrEnum):
    """What an engine's answer promises."""

    EXISTS = auto()  # an equilibrium exists up to the answer, and none exists above it
    HOLDS = auto()  # elastic contacts with Coulomb friction stay at rest up to the answer
    ESTIMATED = auto()  # the method of Nadeau & Kelly: neither a lower nor an upper bound

    @property
    def words(self) -> str:
        """What the engine answers with, for people; "holds" is said of numbers alone."""
        return {
            Claim.EXISTS: "an equilibrium exists",
            Claim.HOLDS: "contacts at rest",
            Claim.ESTIMATED: "an estimate",
        }[self]


@archived
class Bound(StrEnum):
    """How a bound of the true answer is known."""

    PROVED = auto()  # by exact arithmetic, whatever a solver or rounding did; on trees, by a bound of the whole way
    ESTIMATED = auto()  # it follows from an estimate of all errors, with a margin
    NONE = auto()  # the value is not a bound of the true answer


ONLY_BALANCED = "only balanced"  # in the note on bodies that the least push moves

WEAKEST_FIRST = (Bound.NONE, Bound.ESTIMATED, Bound.PROVED)


class Undecided(Record, kw_only=True, ask=".count, which is 0 where every answer is known"):
    """How many of ``rows`` answers are not known, with the ``reasons`` in words; without such answers, none."""

    count: int
    rows: int
    reasons: tuple[str, ...]

    plain = "count share reasons"

    @property
    def share(self) -> float:
        """The share of the answers that are not known, from 0 to 1."""
        return self.count / self.rows if self.rows else 0.0

    @property
    def brief(self) -> str:
        """The count and the share in words, or nothing if every answer is known."""
        return self._counted("")

    @property
    def text(self) -> str:
        """The count, the share and the reasons in words, or nothing if every answer is known."""
        return self.text_on("")

    def text_on(self, rows: str) -> str:
        """Return ``text`` as a sentence on the ``rows``, in the plural: "points of the map"."""
        more = [f"and {len(self.reasons) - MOST_REASONS} more reasons"] if len(self.reasons) > MOST_REASONS else []
        return f"{self._counted(rows)}: {'; '.join([*self.reasons[:MOST_REASONS], *more])}" if self.count else ""

    def _counted(self, rows: str) -> str:
        of = f"{rows} {'is' if self.count == 1 else 'are'} " if rows else ""
        return f"{self.count:,} of {self.rows:,} {of}undecided ({100 * self.share:.3g} %)" if self.count else ""


class Step(Record):
    """``force`` and ``lower`` (n,) of all rows after one step towards their answers.

    ``name`` says what the step looks at, and ``why`` what it does to an answer and for which reason. ``found`` has a
    text for each row, or none at all.
    """

    name: str
    why: str
    force: Float = column("n")
    lower: Float = column("n")
    found: tuple[str, ...] = ()

    def rows(self, which: Any) -> Step:  # noqa: ANN401 - whatever takes rows of an array
        """Return the step of some rows."""
        found = tuple(objects(self.found)[which]) if self.found else ()
        return replace(self, force=self.force[which], lower=self.lower[which], found=found)


class Answers(Record, kw_only=True):
    """A table that gives, for each of n loads, the largest force before something moves, its bounds and the mechanism.

    The columns are read-only and have length n:

    - ``force``: the largest factor by which the load may be multiplied. It is in newtons for loads of 1 N, and in m/s²
      for the inertial loads of an acceleration of 1 m/s².
    - ``lower`` and ``upper``: bounds of the true factor, ``lower <= force <= upper``. ``lower_bound`` and
      ``upper_bound`` say how far they can be trusted.
    - ``status``: FINITE (force 0: what carries the load is only balanced, so the least load moves it); INFINITE (force
      inf: no multiple of the load moves anything); UNSTABLE (force 0: it moves even without the load); or UNDECIDED
      (force 0, which is no answer: the answer is not known). ``undecided`` says how many rows are, and why.
    - ``mechanism``: how bodies begin to move, or None where nothing gives way. ``moving`` gives the names of the
      moving bodies, or of the one that is crushed; ``mode`` is "slip", "topple", "mixed", "roll", "crush" or "none".

    The other fields hold for the whole table: the name of the ``engine``; its ``claim``; how ``lower_bound`` and
    ``upper_bound`` are known; ``notes`` on the simplifications made; and the ``verdict`` on the assembly under its
    weight and the standing loads alone. ``steps`` tell how the engine came to ``force`` and ``lower``, and do not count
    in comparisons. A single row without a bound has lower 0 or upper inf, which is always true.
    Columns of different lengths raise HoldfastError.
    """

    force: Float = column("n")
    lower: Float = column("n")
    upper: Float = column("n")
    status: Objects = column("n", of=Status)
    mechanism: Objects = column("n", of=Mechanism | None)
    engine: str
    claim: Claim
    lower_bound: Bound
    upper_bound: Bound
    notes: tuple[str, ...]
    verdict: Verdict
    steps: tuple[Step, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        lengths = {name: len(getattr(self, name)) for name in COLUMNS}
        if len(set(lengths.values())) > 1:
            each = ", ".join(f"{name} {length}" for name, length in lengths.items())
            raise HoldfastError(message("answers", f"columns differ in length: {each}", "an engine gives equal ones"))

    @classmethod
    def of(
        cls,
        *,
        engine: str,
        claim: Claim,
        verdict: Verdict,
        force: Float,
        status: Sequence[Status],
        mechanism: Sequence[Mechanism | None],
        lower: Float | None = None,
        upper: Float | None = None,
        lower_bound: Bound = Bound.NONE,
        upper_bound: Bound = Bound.NONE,
        notes: Sequence[str] = (),
        steps: Sequence[Step] = (),
    ) -> Answers:
        """Build a table from what an engine found.

        If ``lower`` or ``upper`` is not given, it is filled with 0 or inf. A bound that rounding has put on the wrong
        side of ``force`` is moved to it.
        """
        count = len(force)
        return cls(
            force=force,
            lower=np.zeros(count) if lower is None else np.minimum(lower, force),
            upper=np.full(count, np.inf) if upper is None else np.maximum(upper, force),
            status=objects(status),
            mechanism=objects(mechanism),
            engine=engine,
            claim=claim,
            lower_bound=lower_bound,
            upper_bound=upper_bound,
            notes=tuple(notes),
            verdict=verdict,
            steps=tuple(steps),
        )

    @classmethod
    def not_standing(cls, count: int, *, verdict: Verdict, **known: Any) -> Answers:  # noqa: ANN401 - those of ``of``
        """Build a table of ``count`` rows with force 0, for an assembly that does not stand or may not stand.

        The status is UNSTABLE if the verdict is, else UNDECIDED. ``known`` are further arguments of ``of``.
        """
        status = Status.UNSTABLE if verdict.status is Status.UNSTABLE else Status.UNDECIDED
        upper = np.zeros(count) if status is Status.UNSTABLE else np.full(count, np.inf)
        mechanism = [verdict.mechanism] * count
        return cls.of(
            verdict=verdict, force=np.zeros(count), upper=upper, status=[status] * count, mechanism=mechanism, **known
        )

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the rows that were read from a file cannot be answers."""
        if not ((self.lower <= self.force) & (self.force <= self.upper)).all():
            raise HoldfastError(message("answers", "a force lies outside its bounds", "needs lower <= force <= upper"))

    def __len__(self) -> int:
        return len(self.force)

    @cached_property
    def moving(self) -> Objects:
        """(n,) tuples of the names of the bodies that begin to move; empty where nothing gives way."""
        return objects([() if m is None else m.moving for m in self.mechanism])

    @cached_property
    def mode(self) -> Objects:
        """(n,) "slip", "topple", "mixed", "roll", "crush", or "none" where nothing gives way."""
        return objects(["none" if m is None else m.mode for m in self.mechanism])

    @cached_property
    def decided(self) -> Bool:
        """(n,) whether the answer is known; False where the status is UNDECIDED."""
        return np.asarray(frozen(np.array([status is not Status.UNDECIDED for status in self.status], dtype=bool)))

    @cached_property
    def ranking(self) -> Int:
        """(n,) the numbers of the rows from weak to strong, with undecided rows last: their force 0 is no answer.

        Forces that differ only by rounding keep the order of the rows.
        """
        with np.errstate(divide="ignore"):
            magnitude = np.floor(np.log10(self.force)) - SIGNIFICANT
        unit = np.where(np.isfinite(magnitude), 10.0 ** np.where(np.isfinite(magnitude), magnitude, 0), 1.0)
        return np.asarray(frozen(np.lexsort((np.round(self.force / unit) * unit, ~self.decided))))

    @property
    def holding(self) -> int | None:
        """The number of the row with the least ``lower``, which is promised of all rows; None if nothing is promised.

        An undecided row promises 0.
        """
        return int(np.argmin(self.lower)) if len(self) and self.lower_bound is not Bound.NONE else None

    @property
    def undecided(self) -> Undecided:
        """How many rows are undecided, and why.

        The reasons are that of the verdict, if it is undecided, and all notes that say "undecided"; what a note repeats
        with the name of a body stands there alone. If there is none, the engine did not find what the loads move.
        """
        count = int((~self.decided).sum())
        known = [self.verdict.reason] if self.verdict.status is Status.UNDECIDED else []
        known += [note for note in self.notes if "undecided" in note]
        unknown = f"engine {self.engine} found neither that the load is held nor what it moves"
        named = [text for text in known if not any(text in other and text != other for other in known)]
        reasons = tuple(dict.fromkeys(named or [unknown])) if count else ()
        return Undecided(count=count, rows=len(self), reasons=reasons)

    def rows(self, which: Int | Bool | slice) -> Answers:
        """Return the table with these rows only, given as numbers, as a mask (n,) or as a slice."""
        steps = tuple(step.rows(which) for step in self.steps)
        return replace(self, **{name: getattr(self, name)[which] for name in COLUMNS}, steps=steps)

    def after(self, name: str, why: str) -> Answers:
        """Return this table with one more step, which led to what it holds."""
        return altered(self, steps=(*self.steps, Step(name, why, self.force, self.lower)))

    def explained(self, row: int, unit: str) -> str:
        """Say in lines of text how the answer of a ``row``, in a ``unit``, came about: what each step made of it."""
        surely = f", lower {at_most(self.lower[row], unit)} ({self.lower_bound})"
        known = "" if self.lower_bound is Bound.NONE else surely
        lines = [f"{self.status[row]}: force {number(self.force[row], unit)}{known}, by engine {self.engine}"]
        force, lower = np.nan, 0.0
        for step in self.steps:
            changes = [f"force {number(step.force[row], unit)}"] if step.force[row] != force else []
            changes += [f"lower {at_most(step.lower[row], unit)}"] if step.lower[row] != lower else []
            force, lower = step.force[row], step.lower[row]
            lines.append(f"- {step.name}: {', '.join(changes) if changes else 'no change'}")
            lines += [f"  {step.why}"] if changes else []
            lines += [f"  {step.found[row]}"] if step.found and step.found[row] else []
        return "\n".join([*lines, f"verdict: {self.verdict.status}: {self.verdict.reason}"])

    def times(self, size: Float) -> Answers:
        """Return this table for loads ``size`` (n,) times as small: each factor becomes ``size`` times as large."""
        steps = tuple(replace(step, force=step.force * size, lower=step.lower * size) for step in self.steps)
        return replace(self, force=self.force * size, lower=self.lower * size, upper=self.upper * size, steps=steps)

    def bounded_by(self, other: Answers) -> Answers:
        """Return this table with the smaller upper bound of the two tables in every row.

        ``upper_bound`` is then that of ``other``. A force above its upper bound is lowered to it. Raises HoldfastError
        if the tables differ in length.
        """
        if len(other) != len(self):
            raise HoldfastError(message("answers", f"{len(other)} bounds for {len(self)} rows", "bound every row"))
        upper = np.minimum(self.upper, other.upper)
        force, lower = np.minimum(self.force, upper), np.minimum(self.lower, upper)
        return replace(self, force=force, lower=lower, upper=upper, upper_bound=other.upper_bound).after(
            "bound by limit analysis", ABOVE
        )


def only_balanced(names: Sequence[str]) -> str:
    """Return the note on bodies that are only balanced, as a ball is."""
    return f"{ONLY_BALANCED} (the slightest push moves it): {listed(names, NAMED)}"


def balanced_in_verdict(names: Sequence[str]) -> str:
    """Return what the reason of a verdict ends with where these bodies are only balanced, nothing where none is."""
    if not names:
        return ""
    only = f"{ONLY_BALANCED}, as on an edge, a corner or a round side: {listed(names, NAMED)}"
    return f"; {only} (the slightest push moves it)"


def joined(parts: Sequence[Answers]) -> Answers:
    """Join tables that answer for the same assembly into one, with the rows of all parts in order.

    ``verdict``, ``engine`` and ``claim`` are those of the first part. ``notes`` are those of all parts, and
    ``lower_bound`` and ``upper_bound`` are the weakest of all parts. Raises HoldfastError if there are no parts.
    """
    if not parts:
        raise HoldfastError(message("answers", "there are none to join", "give at least one table"))
    columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS}
    return replace(
        parts[0],
        **columns,
        notes=joined_notes([part.notes for part in parts]),
        steps=_joined_steps([part.steps for part in parts]),
        lower_bound=weakest_bound([part.lower_bound for part in parts]),
        upper_bound=weakest_bound([part.upper_bound for part in parts]),
    )


def _joined_steps(parts: Sequence[tuple[Step, ...]]) -> tuple[Step, ...]:
    """Join the steps of several tables, none if the tables did not take the same ones."""
    if len({tuple(step.name for step in steps) for steps in parts}) > 1:
        return ()
    return tuple(
        Step(
            *(same[0].name, same[0].why),
            np.concatenate([s.force for s in same]),
            np.concatenate([s.lower for s in same]),
            sum((s.found for s in same), ()) if all(s.found for s in same) else (),
        )
        for same in zip(*parts, strict=True)
    )


def joined_notes(notes: Iterable[Sequence[str]]) -> tuple[str, ...]:
    """Return all notes in order, each of them once."""
    return tuple(dict.fromkeys(note for several in notes for note in several))


def weakest_bound(bounds: Sequence[Bound]) -> Bound:
    """Return how the least well known of some bounds is known; a table without rows has none."""
    return min(bounds, key=WEAKEST_FIRST.index, default=Bound.NONE)
