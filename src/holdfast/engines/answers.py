"""The one table that every engine answers with and every result holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum, auto
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Int, Objects, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.values import Value, seal
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.verdict import Status, Verdict

COLUMNS = ("force", "lower", "upper", "status", "mechanism", "solved", "error")


@archived
class Claim(StrEnum):
    """What an engine's answer promises."""

    EXISTS = auto()  # an equilibrium exists up to the answer, none does above it
    HOLDS = auto()  # elastic contacts with Coulomb friction rest up to the answer
    ESTIMATED = auto()  # the method of Nadeau & Kelly: neither a lower nor an upper bound


@archived
class Bound(StrEnum):
    """How a bound of the true answer is known."""

    PROVED = auto()  # by a certificate that was checked, widened by what the check left over
    ESTIMATED = auto()  # by an estimate of all errors, with a margin
    NONE = auto()  # it is no bound of the true answer


WEAKEST_FIRST = (Bound.NONE, Bound.ESTIMATED, Bound.PROVED)


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Answers(Value):
    """For each of n loads: the largest ``force`` before something moves, with bounds, and what gives way.

    Columns, all of length n and read-only:

    ``force`` is the factor by which a load may be multiplied: newtons for loads of 1 N, m/s² for those of an
    acceleration of 1 m/s². ``lower <= force <= upper`` bound the true factor as far as the engine can promise;
    ``status`` is FINITE, INFINITE (force inf: no such load moves anything), UNSTABLE (force 0: it does not stand
    anyway) or UNDECIDED (force 0: not known). ``mechanism`` tells how bodies begin to move (None where nothing gives
    way), ``moving`` which (names), ``mode`` in what way ("slip", "topple", "mixed", "none"). Where ``solved`` is false
    the answer was carried over from neighbouring loads; ``error`` is how far the force may then be off, relative (0
    where solved).

    For the whole table: the name of the ``engine``, its ``claim``, how ``lower_bound`` and ``upper_bound`` are known (a
    single row without a bound has lower 0 or upper inf, which is true in any case), ``notes`` on simplifications, and
    the ``verdict`` on the assembly under the standing loads alone.
    """

    force: Float
    lower: Float
    upper: Float
    status: Objects
    mechanism: Objects
    solved: Bool
    error: Float
    engine: str
    claim: Claim
    lower_bound: Bound
    upper_bound: Bound
    notes: tuple[str, ...]
    verdict: Verdict

    def __post_init__(self) -> None:
        seal(self)
        lengths = {name: len(getattr(self, name)) for name in COLUMNS}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} {length}" for name, length in lengths.items())
            raise HoldfastError(message("answers", f"columns differ in length: {told}", "an engine gives equal ones"))

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
        solved: Bool | None = None,
        error: Float | None = None,
        lower_bound: Bound = Bound.NONE,
        upper_bound: Bound = Bound.NONE,
        notes: Sequence[str] = (),
    ) -> Answers:
        """A table from what an engine found; without bounds they are 0 and inf, and all rows are solved unless told."""
        count = len(force)
        return cls(
            force=force,
            lower=np.zeros(count) if lower is None else lower,
            upper=np.full(count, np.inf) if upper is None else upper,
            status=objects(status),
            mechanism=objects(mechanism),
            solved=np.ones(count, dtype=bool) if solved is None else solved,
            error=np.zeros(count) if error is None else error,
            engine=engine,
            claim=claim,
            lower_bound=lower_bound,
            upper_bound=upper_bound,
            notes=tuple(notes),
            verdict=verdict,
        )

    @classmethod
    def not_standing(cls, count: int, *, verdict: Verdict, **known: Any) -> Answers:  # noqa: ANN401 - those of ``of``
        """Force 0 in ``count`` rows: the assembly does not stand, or it is not known whether it does."""
        status = Status.UNSTABLE if verdict.status is Status.UNSTABLE else Status.UNDECIDED
        upper = np.zeros(count) if status is Status.UNSTABLE else np.full(count, np.inf)
        told = [verdict.mechanism] * count
        return cls.of(
            verdict=verdict, force=np.zeros(count), upper=upper, status=[status] * count, mechanism=told, **known
        )

    def __len__(self) -> int:
        return len(self.force)

    @cached_property
    def moving(self) -> Objects:
        """(n,) names of the bodies that begin to move."""
        return objects([() if m is None else m.moving for m in self.mechanism])

    @cached_property
    def mode(self) -> Objects:
        """(n,) "slip", "topple", "mixed", or "none" where nothing gives way."""
        return objects(["none" if m is None else m.mode for m in self.mechanism])

    def rows(self, which: Int | Bool | slice) -> Answers:
        """Some rows of the table."""
        return replace(self, **{name: getattr(self, name)[which] for name in COLUMNS})

    def bounded_by(self, other: Answers) -> Answers:
        """The same with the upper bounds of ``other`` where those are lower, known as those are."""
        if len(other) != len(self):
            raise HoldfastError(message("answers", f"{len(other)} bounds for {len(self)} rows", "bound every row"))
        return replace(self, upper=np.minimum(self.upper, other.upper), upper_bound=other.upper_bound)


def joined(parts: Sequence[Answers]) -> Answers:
    """The rows of all parts, in their order; they answer for one assembly, whose verdict and notes are the first's."""
    if not parts:
        raise HoldfastError(message("answers", "there are none to join", "give at least one table"))
    columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS}
    return replace(
        parts[0],
        **columns,
        lower_bound=min((part.lower_bound for part in parts), key=WEAKEST_FIRST.index),
        upper_bound=min((part.upper_bound for part in parts), key=WEAKEST_FIRST.index),
    )
