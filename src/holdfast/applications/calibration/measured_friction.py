"""The answer of ``friction_from``: what measured pushes say about coefficients of friction."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Objects
from holdfast.base.public import PublicValue, Summary, column, number
from holdfast.base.text import listed
from holdfast.base.values import Table
from holdfast.queries.result import SHOWN
from holdfast.queries.uncertain import Pair


class MeasuredFriction(PublicValue):
    """What n measured pushes say about the coefficients of friction of pairs of bodies, by the names of the two.

    ``mu`` holds the most likely coefficients, and ``intervals`` their intervals (low, high) at the stated
    ``confidence``; low is 0, or high is inf, where the pushes set no such end. There the interval alone says something:
    many coefficients may be equally likely, of which ``mu`` is one, and a note says so. ``undetermined`` are the pairs
    of which the pushes say nothing: they are in no other table. If nothing is known at all, ``undecided`` says why;
    otherwise it is "".

    ``mu_range`` holds wider intervals, for ``worst_case`` and ``Uncertain``: within them lies, at the same confidence,
    what one further push shows, as friction differs from place to place and from push to push. Where the pushes set no
    upper end, the coefficient of the scene is taken as one, or the lower end if that is larger.

    ``scatter`` is the standard deviation of ln(measured force / predicted force), as given or, if
    ``scatter_estimated``, as found. ``bodies``, ``points`` (n, 3) [m], ``directions`` (n, 3), ``force`` (n,) [N] and
    ``moved`` (n,) are the pushes, in the world frame, and ``predicted`` (n,) [N] are the forces at which something
    moves with ``mu``: 0 where that is not known.
    """

    mu: Table[Pair, float]
    intervals: Table[Pair, tuple[float, float]]
    mu_range: Table[Pair, tuple[float, float]]
    undetermined: tuple[Pair, ...]
    undecided: str
    scatter: float
    scatter_estimated: bool
    confidence: float
    bodies: Objects = column("n", of=str)
    points: Float = column("n 3")
    directions: Float = column("n 3")
    force: Float = column("n")
    moved: Bool = column("n")
    predicted: Float = column("n")
    engine: str
    notes: tuple[str, ...]

    @property
    def worst(self) -> list[int]:
        """The numbers of the pushes whose forces are furthest from the predicted ones, at most eight, worst first."""
        known = self.predicted > 0
        off = np.log(np.where(known, self.predicted, 1) / np.where(known, self.force, 1))
        off = np.where(self.moved, np.abs(off), np.maximum(-off, 0))
        return [int(k) for k in np.argsort(-off, kind="stable")[:SHOWN]]

    def summary(self) -> Summary:
        """Summarise the answer by its pairs, those that are known best first."""
        count = f"{len(self.force):,} pushes, {int(self.moved.sum()):,} of which moved something"
        pairs = f"friction of {len(self.mu)} of {len(self.mu) + len(self.undetermined)} pairs"
        head = f"{count}: {self.undecided or pairs}"
        found = "estimated" if self.scatter_estimated else "given"
        facts = [("scatter", f"{self.scatter:.1%} ({found})"), ("engine", self.engine)]
        if self.undetermined:
            facts.append(("not determined", listed([" and ".join(pair) for pair in self.undetermined], SHOWN)))
        heads = ("pair", "mu", f"{self.confidence:.0%} interval", "a further push shows")
        narrow = sorted(self.mu, key=lambda pair: self.intervals[pair][1] - self.intervals[pair][0])
        rows = [
            [" and ".join(pair), number(self.mu[pair]), _between(self.intervals[pair]), _between(self.mu_range[pair])]
            for pair in narrow[:SHOWN]
        ]
        return Summary(head, facts, heads, rows, self.notes)


def _between(ends: tuple[float, float]) -> str:
    return f"{number(ends[0])} to {number(ends[1])}"
