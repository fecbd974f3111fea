"""Base class of the answers that hold n answers in each of several samples: their statuses, bounds and quantiles."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Bool, Float, Int, Objects, checked, checked_number, frozen
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Summary, column, number
from holdfast.engines.verdict import Status
from holdfast.queries.result import SHOWN, Result, amount


class Sampled(Result):
    """A result with n answers in each of ``samples`` samples of the uncertain quantities.

    ``answers`` holds the rows of all samples, one sample after another, without mechanisms. A subclass says what an
    answer is, and in which unit.
    """

    unit: ClassVar[str] = ""
    place: ClassVar[str] = ""  # title of the column that says which of the n answers a row is about

    nominal: Float = column("n")
    nominal_status: Objects = column("n", of=Status)
    stands: float
    undecided: float
    samples: int
    seed: int

    @property
    def status(self) -> Objects:
        """The status (samples, n) of each answer: FINITE, INFINITE, UNSTABLE or UNDECIDED."""
        return self.answers.status.reshape(self.samples, -1)

    @property
    def lower(self) -> Float:
        """The lower bounds (samples, n) of the true answers, as far as the engine can promise them."""
        return self.answers.lower.reshape(self.samples, -1)

    @property
    def upper(self) -> Float:
        """The upper bounds (samples, n) of the true answers, as far as the engine can promise them."""
        return self.answers.upper.reshape(self.samples, -1)

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the samples that were read from a file do not make up the answers."""
        if len(self.answers) != max(self.samples, 0) * len(self.nominal) or self.samples < 1:
            problem = f"{len(self.answers)} answers for {self.samples} samples of {len(self.nominal)}"
            raise HoldfastError(message("answer under uncertainty", problem, "needs one for each"))

    def weakest(self, headline: str, places: Objects) -> Summary:
        """Summarise the answer by quantiles of the rows with the smallest medians; ``places`` (n,) are their names."""
        unit = self.unit
        low, middle = self.quantile(0.05), self.median
        known_low, known_middle = self.known(0.05), self.known(0.5)
        rows = [
            [
                places[k],
                amount(self.nominal_status[k], self.nominal[k], unit),
                number(middle[k], unit) if known_middle[k] else "?",
                number(low[k], unit) if known_low[k] else "?",
            ]
            for k in np.lexsort((middle, ~known_middle))[:SHOWN].tolist()
        ]
        whole = f"{headline}: {self.stands:.0%} stand"
        whole = "; ".join([whole, *filter(None, [self.answers.undecided.text])])
        return Summary(whole, self.facts(), (self.place, "nominal", "median", "5 % quantile"), rows, self.notes)

    def __float__(self) -> float:
        """Raise HoldfastError: there is an answer in each sample."""
        problem = f"it holds the answers of {self.samples:,} samples"
        raise HoldfastError(message(f"float() of {type(self).__name__}", problem, "ask .median or .quantile(0.05)"))

    def quantile(self, q: ArrayLike) -> Float:
        """Return the answer (n,) that at least a share 1 - ``q`` of the samples reach; ``q`` = 0 gives the smallest.

        Several shares ``q`` (k,) give answers (k, n).

        It is always the answer of one of the samples and is never interpolated. Samples that do not stand count as 0,
        and so do undecided ones, because nothing is certain there; ``known(q)`` is False where the quantile is such a
        0. Raises HoldfastError if ``q`` is not between 0 and 1.
        """
        return frozen(np.sort(self._values, axis=0)[self._rank(q)])

    def known(self, q: ArrayLike) -> Bool:
        """Return for each of the n answers whether ``quantile(q)`` is one; several shares ``q`` (k,) give (k, n).

        It is False where the quantile falls on an undecided sample, whose 0 is no answer. Raises HoldfastError if ``q``
        is not between 0 and 1.
        """
        decided = self.answers.decided.reshape(self.samples, -1)
        zeros = (decided & (self._values == 0)).sum(axis=0)  # decided zeros count as smaller than undecided ones
        rank = self._rank(q)[..., None]
        return np.asarray((rank < zeros) | (rank >= zeros + (~decided).sum(axis=0)))

    @property
    def median(self) -> Float:
        """The median answer (n,), that is the quantile for q = 0.5."""
        return self.quantile(0.5)

    @property
    def _values(self) -> Float:
        """The answers (samples, n)."""
        return self.answers.force.reshape(self.samples, -1)

    def _rank(self, q: ArrayLike) -> Int:
        """Return the ranks () or (k,) of the samples whose answers are the quantiles; rank 0 is the smallest answer."""
        where = "quantile: q"
        several = isinstance(q, list | tuple) or (isinstance(q, np.ndarray) and q.ndim > 0)
        shares = checked(q, (None,), where) if several else np.asarray(checked_number(q, where))
        wrong = shares[(shares < 0) | (shares > 1)]
        if wrong.size:
            raise HoldfastError(message(where, f"is {wrong[0]:g}", "needs shares from 0 to 1"))
        return np.asarray(shares * (self.samples - 1), dtype=np.int64)
