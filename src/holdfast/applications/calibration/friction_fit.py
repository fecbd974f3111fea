"""Fit friction coefficients to measured pushes: the most likely values, and their profile likelihood intervals.

The model: ln(measured force) = ln(predicted force) + s e, where e is a standard normal deviate and s the scatter. A
push that moved nothing says only that its force lies below that: it counts with Φ((ln predicted - ln force) / s).

Coefficients and forces are given by their logarithms. The predicted force is scanned along one coefficient at a time,
and its changes along several are added. That is exact where a push depends on one coefficient, and where the friction
of several pairs adds up at the same pressure. It is an approximation where the weakest of several pairs decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, minimize, minimize_scalar
from scipy.special import log_ndtr
from scipy.stats import chi2, norm, t

from holdfast.base.arrays import Bool, Float

STEPS = np.concatenate([-0.05 * 2.0 ** np.arange(5, -1, -1), [0.0], 0.05 * 2.0 ** np.arange(6)])  # of ln mu: a scan
LEAST_SCATTER, MOST_SCATTER = 1e-3, 3.0  # the accuracy of predicted forces, and a factor of twenty
LEAST_SHARE = 1e-9  # of the force where the scans cross: sums of changes may fall below 0
EQUAL = 1e-3  # difference of log-likelihoods that says nothing: of two such places, the nearer one is taken


@dataclass(frozen=True, eq=False)
class Fit:
    """Pushes beside the scans of their predicted forces along K coefficients.

    ``base`` (n,) are logarithms of the predicted forces where the scans cross, and ``scans`` those along each of them,
    (m, n) at the ``steps`` (m,) of each from there. ``force`` (n,) are logarithms of the measured forces, and ``moved``
    (n,) says which of them moved something. ``given`` is the scatter, or None to estimate it; then ``freedom`` must be
    positive.
    """

    base: Float
    steps: tuple[Float, ...]
    scans: tuple[Float, ...]
    force: Float
    moved: Bool
    given: float | None

    @cached_property
    def _along(self) -> list[PchipInterpolator]:
        return [PchipInterpolator(*scan) for scan in zip(self.steps, self.scans, strict=True)]

    @property
    def freedom(self) -> int:
        """The number of degrees of freedom from which the scatter is estimated."""
        return int(self.moved.sum()) - len(self.scans)

    def predicted(self, x: Float) -> Float:
        """Return the logarithms (n,) of the predicted forces for coefficients ``x`` (K,), 0 where the scans cross."""
        if not len(x):
            return self.base
        ratios = [np.exp(along(at) - self.base) for along, at in zip(self._along, x, strict=True)]
        return np.asarray(self.base + np.log(np.maximum(1 + sum(ratio - 1 for ratio in ratios), LEAST_SHARE)))

    def scatter(self, off: Float) -> float:
        """Return the most likely scatter if the forces are predicted ``off`` (n,) above the measured ones."""
        if self.given is not None:
            return self.given
        if self.moved.all():
            return float(np.clip(np.sqrt(np.mean(off**2)), LEAST_SCATTER, MOST_SCATTER))
        ends = tuple(np.log([LEAST_SCATTER, MOST_SCATTER]))
        return float(np.exp(minimize_scalar(lambda u: -self._log(off, np.exp(u)), bounds=ends).x))

    def _log(self, off: Float, s: float) -> float:
        held = log_ndtr(off[~self.moved] / s).sum()
        return float(held - (0.5 * (off[self.moved] / s) ** 2 + np.log(s)).sum())

    def log_likelihood(self, x: Float) -> float:
        """Return the logarithm of the likelihood of coefficients ``x`` (K,), up to a constant."""
        off = self.predicted(x) - self.force
        return self._log(off, self.scatter(off))

    def best(self, fixed: int | None = None, at: float = 0.0, start: Float | None = None) -> Float:
        """Return the most likely coefficients (K,), with that number ``fixed`` held ``at`` a value.

        First they are looked for along the scans, from ``start``, since the likelihood may have flat parts: the nearest
        of equally likely places along any one, then along each. Then they are sought all together.
        """
        x = np.zeros(len(self.scans)) if start is None else start.copy()
        free = [k for k in range(len(x)) if k != fixed]
        if fixed is not None:
            x[fixed] = at
        if not free:
            return x
        for ways in (free, *([k] for k in free if len(free) > 1)):
            trials = np.array([x, *(self._with(x, k, step) for k in ways for step in self.steps[k])])
            found = np.array([self.log_likelihood(trial) for trial in trials])
            likely = trials[found >= found.max() - EQUAL]
            x = likely[np.argmin(np.abs(likely - x).sum(1))]

        def whole(part: Float) -> Float:
            return self._with(x, free, part)

        def loss(part: Float) -> float:
            return -self.log_likelihood(whole(part))

        def descent(part: Float) -> Float:
            # by the scatter the derivative is 0, or the scatter is known
            x = whole(part)
            off = self.predicted(x) - self.force
            s = self.scatter(off)
            z = off / s
            with np.errstate(over="ignore"):
                held = np.exp(norm.logpdf(z) - log_ndtr(z))
            slope = np.where(self.moved, z, -held) / s
            share = np.exp(self.base - self.predicted(x))
            ways = zip(self._along, x, strict=True)
            each = [(np.exp(along(at) - self.base) * share * along(at, 1)) @ slope for along, at in ways]
            return np.array(each)[free]

        ends = [(float(STEPS[0]), float(STEPS[-1]))] * len(free)
        sought = minimize(loss, x[free], jac=descent, bounds=ends, method="L-BFGS-B")
        return whole(sought.x) if -sought.fun > self.log_likelihood(x) else x

    @staticmethod
    def _with(x: Float, k: int | list[int], value: float | Float) -> Float:
        other = x.copy()
        other[k] = value
        return other

    def among(self, kept: Sequence[int]) -> Fit:
        """Return the fit of these coefficients alone."""
        return replace(self, steps=tuple(self.steps[k] for k in kept), scans=tuple(self.scans[k] for k in kept))

    def with_step(self, k: int, step: float, forces: Float) -> Fit:
        """Return the fit with one more step in the scan of coefficient ``k``, where the forces are ``forces`` (n,)."""
        row = int(np.searchsorted(self.steps[k], step))
        forces = np.where(np.isfinite(forces), forces, self._along[k](step))
        steps, scans = list(self.steps), list(self.scans)
        steps[k], scans[k] = np.insert(steps[k], row, step), np.insert(scans[k], row, forces, axis=0)
        return replace(self, steps=tuple(steps), scans=tuple(scans))

    def interval(self, k: int, best: Float, confidence: float) -> tuple[float, float]:
        """Return the ends of the interval of coefficient ``k`` about the ``best``, -inf or inf if a scan ends in it.

        It holds every value that the data do not exclude: where twice the loss of likelihood, with all other
        coefficients and the scatter as likely as can be, is below the quantile of its distribution. With an estimated
        scatter, this is the quantile for which the interval of a single mean is that of Student's t.
        """
        top, allowed = self.log_likelihood(best), self.allowed(confidence)

        def excess(at: float) -> float:
            return 2 * (top - self.log_likelihood(self.best(k, at, best))) - allowed

        ends = []
        for side in (-1, 1):
            steps = self.steps[k]
            places = side * np.sort(side * np.append(steps[side * steps > side * best[k]], best[k]))
            inside = [excess(at) <= 0 for at in places]
            last = max(number for number, is_in in enumerate(inside) if is_in or number == 0)
            if last == len(places) - 1:
                ends.append(side * np.inf)
            else:
                ends.append(float(brentq(excess, places[last], places[last + 1], xtol=1e-6)))
        return ends[0], ends[1]

    def allowed(self, confidence: float) -> float:
        """Return the largest loss of twice the log-likelihood within an interval of this ``confidence``."""
        if self.given is not None:
            return float(chi2.ppf(confidence, 1))
        count = int(self.moved.sum())
        return float(count * np.log1p(t.ppf((1 + confidence) / 2, self.freedom) ** 2 / self.freedom))

    def further(self, x: Float, confidence: float) -> float:
        """Return how far, at this ``confidence``, the logarithm of a further push may be from the predicted one."""
        s = self.scatter(self.predicted(x) - self.force)
        if self.given is not None:
            return float(norm.ppf((1 + confidence) / 2)) * s
        unbiased = s * np.sqrt(self.moved.sum() / self.freedom)
        return float(t.ppf((1 + confidence) / 2, self.freedom) * unbiased)

    def misfit(self, x: Float) -> Float:
        """Return how far each push (n,) is from its prediction, as squared deviates; one that held may be 0."""
        off = self.predicted(x) - self.force
        z = off / self.scatter(off)
        return np.where(self.moved, z**2, np.maximum(-2 * log_ndtr(z) - 2 * np.log(2), 0))


def contradicted(misfit: Float, unknowns: int, doubt: float) -> bool:
    """Tell whether pushes with this ``misfit`` (n,) would occur with a probability below ``doubt``."""
    return bool(misfit.sum() > chi2.isf(doubt, max(len(misfit) - unknowns, 1)))
