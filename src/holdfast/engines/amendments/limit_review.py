"""Answers of load paths that deserve doubt, compared with limit analysis, which proves above which load bodies move."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.elastic.outcome import PathOutcome
from holdfast.engines.amendments.amendment import Amendment, Asked
from holdfast.engines.answers import Answers, only_balanced
from holdfast.engines.compliant.beginnings import PATIENCE, SMALL, path_from
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.load_bearing import HUGE, rests_alone
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.verdict import Status

SLIGHT = 1e-4  # a push of this share of a body's weight cannot be told from none
CONTRADICTION = 0.05  # share by which a peak may lie above the proved bound before it counts as wrong
ENDLESS = 1e3  # a lower bound above this many weights of the group leaves it to limit analysis whether there is an end
# A path that ends below this share of the pushed body's weight may have ended only because it began at a kink
TOO_SOON = 0.01


class _Row(NamedTuple):
    """One answer, with the names that the columns of a table have."""

    status: Status
    force: float
    lower: float
    mechanism: Mechanism | None


ENDLESS_ROW = _Row(Status.INFINITE, np.inf, np.inf, None)
UNDECIDED_ROW = _Row(Status.UNDECIDED, 0.0, 0.0, None)


class _Asked(NamedTuple):
    """One ``load`` (6J,): its ``size`` relative to all weights, and to its ``own`` body's; whether that is ``held``.

    ``gained`` tells whether a motion that no contact resists gains power from it, ``bounded`` whether a lower bound is
    wanted.
    """

    load: Float
    size: float
    own: float
    held: bool
    gained: bool
    bounded: bool


class _Proved(NamedTuple):
    """What limit analysis proves of one load: its ``top``, or that it is ``endless``, and the mechanism."""

    top: float
    endless: bool
    mechanism: Mechanism | None


@dataclass(frozen=True, eq=False)
class LimitReview(Amendment):
    """Compares answers with limit analysis where they deserve doubt.

    Answers to loads of bodies that a regularisation spring keeps in their places, as it has to keep those that are only
    balanced, are all compared; of others those that are undecided, that have no lower bound, that exceed HUGE times the
    weight, or that are too small to be told from none.
    """

    name: ClassVar[str] = "limit analysis"
    why: ClassVar[str] = "limit analysis proves when something moves at the latest, and which loads have no end"

    def applies(self, asked: Asked) -> bool:
        """Say that answers have to be looked at."""
        return True

    def amend(self, found: Answers, asked: Asked) -> Answers:
        """Return the answers ``found``, mended where limit analysis proves more.

        - A push becomes 0 if it gains power in a motion that no contact resists (balanced.py), or if limit analysis
          proves that one too small to be told from none moves something. One of a body that is held whose path ended at
          its beginning, below TOO_SOON of the body's weight, is followed anew from where the kink at rest is left
          (beginnings.py); it is undecided if that ends at the beginning, too.
        - An undecided answer becomes 0 where limit analysis proves that the least push moves something.
        - An answer above the proved bound by more than CONTRADICTION is undecided; one that is less far above it is
          lowered to it.
        - A peak above HUGE times the weight is infinite if contact forces balance the load alone, with friction, by
          both methods. So is a peak whose lower bound, which the finer grid confirms, is above ENDLESS times the
          weight, if limit analysis finds forces that balance the load alone: there the weight is nothing but a
          disturbance of the balance, of the size of those that a path is lost by. If nothing of this is found, such a
          peak without a lower bound is, where limit analysis finds no end, infinite if the finer grid finds none
          either, and undecided otherwise. An undecided answer is infinite if its path was lost above HUGE times the
          weight that counts beside its load and one of the two searches for rest succeeds, or if it has no end, on the
          finer grid neither, where every body is held.
        """
        W = asked.W
        size, own, held = self._sizes(W), self._own(W), self.grid.loads_held(W)
        neutral = self.state.neutral
        gained = np.zeros(len(size), dtype=bool) if neutral is None else neutral.gained(W)
        doubtful = np.flatnonzero(gained | self._doubtful(found, size, own, held, bounded=asked.bounded))
        if not len(doubtful) or not self.grid.certain.verdict().equilibrium_exists:
            return found
        certain = self.grid.certain.load_factor(W[:, doubtful])
        upper = np.array(found.upper)
        known: dict[str, Any] = {name: np.array(getattr(found, name)) for name in _Row._fields}
        upper[doubtful] = top = np.minimum(upper[doubtful], certain.upper)
        for k, row in enumerate(doubtful.tolist()):
            endless = certain.status[k] is Status.INFINITE
            proved = _Proved(float(top[k]), endless, certain.mechanism[k])
            numbers, flags = (float(size[row]), float(own[row])), (bool(held[row]), bool(gained[row]))
            one = _Asked(W[:, row], *numbers, *flags, asked.bounded)
            mended = self._mended(_Row._make(column[row] for column in known.values()), one, proved)
            for column, value in zip(known.values(), mended, strict=True):
                column[row] = value
        return replace(found, **known, upper=upper, notes=(*found.notes, *self._notes))

    def _mended(self, row: _Row, asked: _Asked, proved: _Proved) -> _Row:
        """Return one answer, mended as ``amend`` says."""
        if asked.gained or proved.top * asked.own <= SLIGHT:
            return _Row(Status.FINITE, 0.0, 0.0, proved.mechanism if row.mechanism is None else row.mechanism)
        if asked.held and row.force * asked.own <= TOO_SOON:
            row = self._begun_anew(row, asked, proved)
            row = UNDECIDED_ROW if row.force * asked.own <= SLIGHT else row
        if row.status is Status.UNDECIDED:
            return ENDLESS_ROW if proved.endless and self._endless_behind(asked.load, asked.size) else row
        if row.force > (1 + CONTRADICTION) * proved.top:
            return UNDECIDED_ROW
        confirmed = not asked.held and row.lower * asked.size > ENDLESS  # a regularisation spring may have helped
        if proved.endless and (confirmed or self._endless(asked.load, float(row.force))):
            return ENDLESS_ROW
        if proved.endless and asked.bounded and row.lower <= 0 and row.force * asked.size > HUGE:
            finer = self.grid.finer.paths(asked.load[:, None]).outcome[0]
            return ENDLESS_ROW if finer == PathOutcome.ENDLESS else UNDECIDED_ROW
        force = min(row.force, proved.top)
        return row._replace(force=force, lower=min(row.lower, force))

    def _begun_anew(self, row: _Row, asked: _Asked, proved: _Proved) -> _Row:
        """Return the answer of a path that begins where the body that is held has left the kink at rest, if it is more.

        It is infinite if the path has no end, or a peak that no weight counts beside, on the finer grid neither. What
        contradicts limit analysis is left.
        """
        load, start = self.grid.loads(asked.load[:, None])[0], SMALL / asked.own
        peak, motion = path_from(self.grid, load, start)
        if peak * asked.size > ENDLESS:
            endless = proved.endless and path_from(self.grid.finer, load, start)[0] * asked.size > ENDLESS
            return ENDLESS_ROW if endless else row
        if not row.force < peak <= (1 + CONTRADICTION) * proved.top:
            return row
        return row._replace(status=Status.FINITE, force=peak, mechanism=self.grid.mechanisms(motion[None])[0])

    def _sizes(self, W: Float) -> Float:
        """Return the largest component (n,) of each column of W (6J, n), relative to the weight and the size."""
        return np.asarray(np.abs(self.grid.loads(W)).max(axis=1, initial=0.0))

    def _own(self, W: Float) -> Float:
        """Return the largest component (n,) of each column of W (6J, n), each body's in its own weight and size."""
        assembly = self.grid.assembly
        return np.asarray(np.abs(W * assembly.equation_scale[:, None]).max(0, initial=0.0) / self.grid.unit)

    def _doubtful(self, found: Answers, size: Float, own: Float, held: Bool, *, bounded: bool) -> Bool:
        finite = found.status == Status.FINITE
        force = np.where(finite, found.force, 0.0)
        doubt = held | (found.status == Status.UNDECIDED) | (finite & ((force * size > HUGE) | (force * own <= SLIGHT)))
        if bounded:
            doubt |= finite & (found.lower <= 0)
        return np.asarray((size > 0) & doubt)

    def _endless_behind(self, column: Float, size: float) -> bool:
        """Tell whether the path of one load (6J,) was lost although it has no end."""
        reached = float(self.grid.paths(column[:, None]).peak[0])
        beside = self.grid.load_bearing.weight(self.grid.loads(column[:, None])[0])
        if HUGE * beside < reached * size < np.inf and self._endless(column, reached):
            return True
        return all(self._endless_held(grid, column, size) for grid in (self.grid, self.grid.finer))

    def _endless_held(self, grid: Grid, column: Float, size: float) -> bool:
        """Tell whether the path of one load (6J,) has no end where springs keep every body in its place.

        Where bodies lie on whole multiples of their size, some of them come to be only balanced on the way.
        """
        found = grid.with_hold.paths(column[:, None])
        return bool(found.outcome[0] == PathOutcome.ENDLESS or found.peak[0] * size > ENDLESS)

    def _endless(self, column: Float, peak: float) -> bool:
        """Tell whether elastic contacts balance one load (6J,) without any weight, or its ``peak`` is infinite."""
        if not np.isfinite(peak):
            return True
        load = self.grid.loads(column[:, None])[0]
        if self.grid.load_bearing.balance(load):
            return True
        return rests_alone(self.grid.with_hold.system.under(load / np.abs(load).max()), PATIENCE)

    @property
    def _notes(self) -> tuple[str, ...]:
        neutral = self.state.neutral
        names = () if neutral is None else neutral.named(self.grid.assembly)
        return (only_balanced(names),) if names else ()
