"""An elastic model with what solves its linear systems: whether it comes to rest, and where its load paths lead."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int, frozen
from holdfast.base.memory import Memory
from holdfast.base.progress import free_threads, in_parallel, report
from holdfast.elastic.model import MOST_DENSE, Elastic
from holdfast.native import core


class PathOutcome(IntEnum):
    """How a load path ends."""

    LOST = 0  # no further point was found before the end was clear
    PEAK = 1  # the load has a largest value
    ENDLESS = 2  # contact forces balance any multiple of the load
    REACHED = 3  # it leads to the load up to which it was to be followed


class RestOutcome(IntEnum):
    """How the search for a state of rest ends."""

    LOST = 0  # neither of the two was found
    RESTS = 1
    DRIFTS = 2  # bodies keep moving at a constant velocity


class StepControl(NamedTuple):
    """How closely a path is followed.

    ``growth``: the largest growth of the step from one point to the next; ``correction``: that of a point that is
    wanted, as a share of the step; ``patience``: points without a new peak after which none is waited for; ``most``
    points of a path.
    """

    growth: float
    correction: float
    patience: int
    most: int


QUICK = StepControl(2.5, 0.2, 80, 600)
BRIEF = QUICK._replace(patience=40)  # where linear systems are expensive
CLOSE = StepControl(1.5, 0.05, 1000, 20_000)  # slow and misses less: the reference for the quick step control


class PathResult(NamedTuple):
    """What k load paths gave, among n = 6J displacements.

    ``outcome`` (k,) of PathOutcome; ``peak`` (k,) the largest s found, inf where the path is endless, that of the last
    point where it was not followed further; ``first`` (k,) the first maximum of s from which it dipped before it rose
    to the peak, the peak if there was none; ``before`` (k,) the largest s, at most the peak, before contacts have slid
    far (SLID); ``sharpest`` (k,) the largest correction of a point after the first, as a share of its step; ``last``
    (k,) s where it ended (residual strength); ``systems`` (k,) linear systems solved; ``q`` (k, n) at the peak, of
    endless paths under the load alone; ``motion`` (k, n) what begins to move above the peak, 0 where the path was lost
    and nothing does; ``plane`` (k, n) across which the peak was found.
    """

    outcome: Int
    peak: Float
    first: Float
    before: Float
    sharpest: Float
    last: Float
    systems: Int
    q: Float
    motion: Float
    plane: Float

    @classmethod
    def lost(cls, count: int, n: int) -> PathResult:
        """``count`` paths of which nothing is known yet."""
        rows: dict[str, tuple[int, ...]] = {"q": (n,), "motion": (n,), "plane": (n,)}
        kinds = {"outcome": np.int64, "systems": np.int64}
        return cls._make(np.zeros((count, *rows.get(name, ())), kinds.get(name, np.float64)) for name in cls._fields)

    @property
    def factor(self) -> Float:
        """(k,) the peak, inf where the path is endless, 0 where it was lost."""
        endless = np.where(self.outcome == PathOutcome.ENDLESS, np.inf, 0.0)
        return np.where(self.outcome == PathOutcome.PEAK, self.peak, endless)

    @property
    def sure(self) -> Float:
        """(k,) the load before which no contact gives way even for a moment: the smaller of ``first`` and ``peak``."""
        return np.minimum(self.first, self.peak)

    def chosen(self, which: Int | Bool | slice) -> PathResult:
        """Some of the paths."""
        return PathResult._make(column[which] for column in self)

    def replaced(self, at: Int, others: PathResult) -> PathResult:
        """The same with ``others`` in the places ``at``."""
        columns = [column.copy() for column in self]
        for column, other in zip(columns, others, strict=True):
            column[at] = other
        return PathResult._make(columns).sealed()

    def sealed(self) -> PathResult:
        """Itself, after which nobody can write to it."""
        for column in self:
            column.setflags(write=False)
        return self


MANY = 100  # number of bodies from which several orders are tried
TRIES, SEED = 8, 0  # number of orders tried, with ties broken at random, and the seed
# Largest number of bodies that all tries together order: the time for one try grows faster than its bodies
MOST_TRIED = 2500
_KNOWN = Memory(20_000)  # sheets of models whose fronts are kept


class EliminationFronts(NamedTuple):
    """The fronts of a model in the order of elimination, children first, and all of its sheets, each in one front.

    Front k holds bodies ``body[first[k]:first[k + 1]]``, of which it eliminates the first ``owned[k]``, the last front
    none; ``onward`` is each body's place in the front that takes what is left, where the bodies are not eliminated
    before. It takes what is left of the fronts ``child[begin[k]:begin[k + 1]]``, of which the last is front k - 1, and
    the sheets ``sheet[since[k]:since[k + 1]]``, whose bodies have the places ``at_a`` and ``at_b`` in it (-1: fixed).
    """

    first: Int
    body: Int
    owned: Int
    onward: Int
    begin: Int
    child: Int
    since: Int
    sheet: Int
    at_a: Int
    at_b: Int

    @classmethod
    def of(cls, count: int, a: Int, b: Int) -> EliminationFronts:
        """Order ``count`` bodies whose sheets are between bodies ``a`` and ``b`` (P,), -1 for fixed ones.

        Of large models several orders are tried (native/ordering.hpp), and that which takes the fewest products counts.
        """
        rng, ranks = np.random.default_rng(SEED), [np.arange(count)]
        tries = min(TRIES, MOST_TRIED // count) if count >= MANY else 0
        ranks += [rng.permutation(count) for _ in range(tries)]
        return cls(*core.order_fronts(count, a, b, np.array(ranks)))


def fronts_of(m: Elastic) -> EliminationFronts:
    """Order the bodies of a model, and say what each front takes; what was found for other nodes is taken again."""
    count = len(m.wrench) // 6
    return _KNOWN.recalled(
        (count, m.a.tobytes(), m.b.tobytes()), len(m.a), lambda: EliminationFronts.of(count, m.a, m.b)
    )


EXACT = 1e-11  # unbalance of a state of rest, each body's in units of its own weight
MOST_STEPS = 6000  # largest number of Newton steps along the motion; half as many while the drag decreases
LEAST_COLUMNS = 3  # smallest number of columns for which a further thread pays off, unless they take long
SHARES = 3  # blocks of columns for each thread, since some blocks take longer than others
MOST_COLUMNS = 64  # largest number of columns in a block, between which the work can be stopped
LONG = 60  # displacements from which a path may keep a user who stops it waiting
STAGE = "load paths"


@dataclass(frozen=True, eq=False)
class RestSearch:
    """The end of the search for rest.

    ``outcome``; displacement ``q`` (6J,) and, where bodies drift, their velocity ``drift`` (6J,); ``steps`` of Newton's
    method and the ``drag`` ε of the last state found.
    """

    outcome: RestOutcome
    q: Float
    drift: Float
    steps: int
    drag: float


@dataclass(frozen=True, eq=False)
class System:
    """A model of n = 6J displacements; ``fronts``, or None for dense elimination."""

    model: Elastic
    fronts: EliminationFronts | None

    @classmethod
    def of(cls, model: Elastic) -> System:
        """By the method that is faster for a model of this size."""
        return cls.dense(model) if len(model.wrench) <= MOST_DENSE else cls.by_fronts(model)

    @classmethod
    def dense(cls, model: Elastic) -> System:
        """By dense elimination."""
        return cls(model, None)

    @classmethod
    def by_fronts(cls, model: Elastic) -> System:
        """By block-sparse elimination."""
        return cls(model, fronts_of(model))

    @property
    def long(self) -> bool:
        """Whether a single path may take longer than a user who stops it waits."""
        return len(self.model.wrench) >= LONG

    def threads(self, count: int) -> int:
        """The number of threads that ``count`` columns are shared among, at least one."""
        return max(min(free_threads(), count if self.long else count // LEAST_COLUMNS), 1)

    @cached_property
    def stuck(self) -> Float:
        """The displacement (n,) under the wrench, if every contact sticks."""
        q = np.zeros(len(self.model.wrench))
        core.bond_all(self.model, core.Work(self.model, self.fronts), self.model.wrench, q, self.fronts)
        return frozen(q)

    def under(self, wrench: Float) -> System:
        """The same under another wrench (n,), in the model's units."""
        return replace(self, model=self.model._replace(wrench=wrench))

    def slippery(self, share: float) -> System:
        """The same with all coefficients of friction times ``share``."""
        return replace(self, model=self.model._replace(mu=share * self.model.mu))

    def come_to_rest(self, near: Float | None = None, most: int = MOST_STEPS, exact: float = EXACT) -> RestSearch:
        """Let bonded contacts come to rest, or not; if given, try first from a displacement ``near`` (n,).

        Every search gives up after ``most`` steps of Newton's method, or half as many. At rest the unbalance is at most
        ``exact``, each body's in units of its own weight.
        """
        n, work = len(self.model.wrench), core.Work(self.model, self.fronts)
        q, drift = np.zeros(n), np.zeros(n)
        if near is not None:
            q[:] = near
            found = core.move(self.model, work, 1.0, q, drift, exact, most, self.fronts)
            if found.outcome != RestOutcome.LOST:
                return RestSearch(RestOutcome(found.outcome), q, drift, found.steps, found.drag)
        q[:] = bonded = self.stuck
        found = core.lessen_drag(self.model, work, 1.0, q, drift, exact, most // 2, self.fronts)
        if found.outcome != RestOutcome.LOST:
            return RestSearch(RestOutcome(found.outcome), q, drift, found.steps, found.drag)
        q[:] = bonded
        moved = core.move(self.model, work, 1.0, q, drift, exact, most, self.fronts)
        return RestSearch(RestOutcome(moved.outcome), q, drift, found.steps + moved.steps, moved.drag)

    def paths(
        self,
        start: Float,
        loads: Float,
        *,
        most: Float | None = None,
        pace: StepControl | None = None,
    ) -> PathResult:
        """Follow the paths of ``loads`` (k, n), none of them zero, from the state of rest ``start`` (n,).

        Loads are in the model's units. If given, no path is followed beyond ``most`` (k,) times its load. ``pace`` says
        how closely they are followed; QUICK or, where systems are dear, BRIEF.
        """
        count, n = loads.shape
        pace = pace or (QUICK if self.fronts is None else BRIEF)
        farthest = np.full(count, np.inf) if most is None else np.ascontiguousarray(most)
        found, stuck, loads = PathResult.lost(count, n), self.stuck, np.ascontiguousarray(loads)

        def run(rows: Int, work: core.Work) -> None:
            stepper = core.Stepper(stuck, pace)
            core.follow_each(self.model, work, stepper, start, loads, found, rows, farthest, self.fronts)

        self._in_threads(count, run)
        return found.sealed()

    def loads_nearby(self, loads: Float, s: Float, q: Float, plane: Float) -> Float:
        """The loads (k,) near points on the paths of another model of the same bodies; -1: none found.

        ``loads`` (k, n); points ``s`` (k,) at ``q`` (k, n), across ``plane`` (k, n) of which the load is sought.
        """
        found, loads, q, plane = np.full(len(s), -1.0), *map(np.ascontiguousarray, (loads, q, plane))

        def run(rows: Int, work: core.Work) -> None:
            core.loads_nearby(self.model, work, loads, s, q, plane, found, rows, self.fronts)

        self._in_threads(len(s), run)
        return found

    def rest_near(self, q: Float) -> Float | None:
        """Return the displacement (n,) of a state of rest near ``q`` (n,), without any motion to it, or None."""
        found = q.copy()
        return found if core.rests_near(self.model, core.Work(self.model, self.fronts), found, self.fronts) else None

    def _in_threads(self, count: int, run: Callable[[Int, core.Work], None]) -> None:
        """Run over ``count`` rows, in threads with memory of their own: machine code holds no lock.

        A single thread is enough for few rows, and none is needed where they do not take long. Those are run in blocks:
        threads that come back to Python for each of them would wait for each other.
        """
        if not count:
            return
        threads = self.threads(count)
        works = [core.Work(self.model, self.fronts) for _ in range(threads)]
        size = 1 if self.long else min(max(count // (SHARES * threads), 1), MOST_COLUMNS)
        blocks = [np.arange(first, min(first + size, count)) for first in range(0, count, size)]

        def work_through(numbers: Iterable[int], work: core.Work) -> None:
            for number in numbers:
                run(blocks[number], work)

        if threads < 2 and not self.long:
            for number in range(len(blocks)):
                report(STAGE, number * size, count)
                run(blocks[number], works[0])
            report(STAGE, count, count)
        else:
            in_parallel(STAGE, work_through, works, len(blocks), count)
