"""Answers of load paths that deserve doubt, compared with limit analysis, which proves above which load bodies move."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.elastic.outcome import PathOutcome, RestOutcome
from holdfast.elastic.progress import CARRIED
from holdfast.elastic.stepper import carried
from holdfast.engines.answers import Answers, only_balanced
from holdfast.engines.compliant.carriers import HUGE, rests_alone
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.contract import EXACT, Accuracy, ForcesOnly, Within
from holdfast.engines.verdict import Status

SLIGHT = 1e-4  # push, relative to the pushed body's weight, below which a body that is only balanced gives way to any
CONTRADICTION = 0.05  # share by which a peak may lie above the proved bound before it counts as wrong
ENDLESS = 1e3  # lower bound, relative to the group's weight, above which limit analysis decides whether there is an end
BEYOND = 30.0  # times a peak: bodies that rest under such a load do not move at the peak
TENTH = 0.1  # of the load at which a path ended, where the hold tells whether contacts resist at all
CLEARLY = 0.5  # of its share of what ends a path, above which the hold carries the load as it did from the beginning
PATIENCE = 200  # steps of Newton's method after which rest under such a load is not sought any longer


@dataclass(frozen=True, eq=False)
class Review:
    """Compares answers on one grid with limit analysis where they deserve doubt.

    ``loose`` names the bodies that are only balanced. Answers to loads of bodies that a faint hold keeps in their
    places, as it has to keep those, are all compared; of others those that are undecided, that have no lower bound,
    that exceed HUGE times the weight, or that are too small to be told from none.
    """

    grid: Grid
    loose: tuple[str, ...]

    def of(self, found: Answers, W: Float, accuracy: Accuracy) -> Answers:
        """Return the answers ``found`` for columns W (6J, n), mended where limit analysis proves more.

        - A push that moves a body which is only balanced, and that is too small to be told from none, becomes 0: of a
          body that is held that of either method, of others that of limit analysis. So does one that only the faint
          hold resists, from the beginning.
        - An undecided answer becomes 0 where limit analysis proves that the least push moves something.
        - An answer above the proved bound by more than CONTRADICTION is undecided; one that is less far above it is
          lowered to it.
        - A peak above HUGE times the weight is infinite if contact forces balance the load alone, with friction, by
          both methods, or if elastic contacts come to rest under BEYOND times the peak: the path has left its branch.
          So is a peak whose lower bound, which the finer grid confirms, is above ENDLESS times the weight, if limit
          analysis finds forces that balance the load alone: there the weight is nothing but a disturbance of the
          balance, of the size of those that a path is lost by. If nothing of this is found, such a peak without a lower
          bound is undecided where limit analysis finds no end. An undecided answer is infinite if its path was lost
          above HUGE times the weight that counts beside its load and one of the two searches for rest succeeds, or if
          it has no end, on the finer grid neither, where every body is held.
        """
        size, own, held = self._sizes(W), self._own(W), self.grid.loads_held(W)
        bounded = not isinstance(accuracy, ForcesOnly)
        doubtful = np.flatnonzero(self._doubtful(found, size, own, held, accuracy))
        if not len(doubtful) or not self.grid.certain.verdict().equilibrium_exists:
            return found
        wanted = accuracy if isinstance(accuracy, Within) else EXACT
        certain = self.grid.certain.anew().load_factor(W[:, doubtful], wanted)
        force, lower, upper = (np.array(column) for column in (found.force, found.lower, found.upper))
        status, mechanism = np.array(found.status), np.array(found.mechanism)
        upper[doubtful] = top = np.minimum(upper[doubtful], certain.upper)
        for k, row in enumerate(doubtful.tolist()):
            unknown, infinite = status[row] is Status.UNDECIDED, certain.status[k] is Status.INFINITE
            confirmed = not held[row] and lower[row] * size[row] > ENDLESS  # a faint hold may have helped
            slight = min(top[k], np.inf if unknown or not held[row] else force[row]) * own[row] <= SLIGHT
            if slight or (held[row] and self._gives_way(W[:, row], force[row], own[row])):
                status[row], force[row], lower[row] = Status.FINITE, 0.0, 0.0
                mechanism[row] = certain.mechanism[k] if mechanism[row] is None else mechanism[row]
            elif unknown:
                if infinite and self._endless_behind(W[:, row], size[row]):
                    status[row], force[row], lower[row], mechanism[row] = Status.INFINITE, np.inf, np.inf, None
            elif force[row] > (1 + CONTRADICTION) * top[k]:
                status[row], force[row], lower[row], mechanism[row] = Status.UNDECIDED, 0.0, 0.0, None
            elif infinite and (confirmed or self._endless(W[:, row], float(force[row]))):
                status[row], force[row], lower[row], mechanism[row] = Status.INFINITE, np.inf, np.inf, None
            elif infinite and bounded and lower[row] <= 0 and force[row] * size[row] > HUGE:
                status[row], force[row], lower[row], mechanism[row] = Status.UNDECIDED, 0.0, 0.0, None
            else:
                force[row] = min(force[row], top[k])
                if held[row]:  # the hold may have carried some
                    lower[row] = max(lower[row] - CARRIED / size[row], 0.0)
                lower[row] = min(lower[row], force[row])
        return replace(
            found,
            force=force,
            lower=lower,
            upper=upper,
            status=status,
            mechanism=mechanism,
            notes=(*found.notes, *self._notes),
        )

    def _sizes(self, W: Float) -> Float:
        """Return the largest component (n,) of each column of W (6J, n), relative to the weight and the size."""
        return np.asarray(np.abs(self.grid.loads(W)).max(axis=1, initial=0.0))

    def _own(self, W: Float) -> Float:
        """Return the largest component (n,) of each column of W (6J, n), each body's in its own weight and size."""
        assembly = self.grid.assembly
        return np.asarray(np.abs(W * assembly.equation_scale[:, None]).max(0, initial=0.0) / self.grid.unit)

    def _doubtful(self, found: Answers, size: Float, own: Float, held: Bool, accuracy: Accuracy) -> Bool:
        finite = found.status == Status.FINITE
        force = np.where(finite, found.force, 0.0)
        doubt = held | (found.status == Status.UNDECIDED) | (finite & ((force * size > HUGE) | (force * own <= SLIGHT)))
        if not isinstance(accuracy, ForcesOnly):
            doubt |= finite & (found.lower <= 0)
        return np.asarray((size > 0) & doubt)

    def _gives_way(self, column: Float, force: float, own: float) -> bool:
        """Tell whether the faint hold alone keeps a body from being moved by any share of a ``force`` along a load.

        Its path ended where the hold carried CARRIED of a weight. Where contacts resist, the hold carries next to
        nothing of a tenth of that force; where they do not, it carries a tenth as much from the beginning, however
        little that is of the force: of a press on a box beside the edge that it is balanced on, contacts carry all but
        the moment about the edge.
        """
        if not 0 < force * own <= 1:
            return False
        system, rest = self.grid.system, self.grid.settled.q
        wrench = system.model.wrench + TENTH * force * self.grid.loads(column[:, None])[0]
        end = system.under(wrench).come_to_rest(near=rest, most=PATIENCE)
        more = carried(system.model, end.q) - carried(system.model, rest)
        return end.outcome is RestOutcome.RESTS and more > CLEARLY * TENTH * CARRIED

    def _endless_behind(self, column: Float, size: float) -> bool:
        """Tell whether the path of one load (6J,) was lost although it has no end."""
        reached = float(self.grid.paths(column[:, None]).peak[0])
        beside = self.grid.carriers.weight(self.grid.loads(column[:, None])[0])
        if HUGE * beside < reached * size < np.inf and self._endless(column, reached):
            return True
        return all(self._endless_held(grid, column, size) for grid in (self.grid, self.grid.finer))

    def _endless_held(self, grid: Grid, column: Float, size: float) -> bool:
        """Tell whether the path of one load (6J,) has no end where a faint hold keeps every body in its place.

        Where bodies lie on whole multiples of their size, some of them come to be only balanced on the way.
        """
        found = grid.with_hold.paths(column[:, None])
        return bool(found.outcome[0] == PathOutcome.ENDLESS or found.peak[0] * size > ENDLESS)

    def _endless(self, column: Float, peak: float) -> bool:
        """Tell whether elastic contacts balance one load (6J,) without any weight, or BEYOND times its ``peak``."""
        if not np.isfinite(peak):
            return True
        load = self.grid.loads(column[:, None])[0]
        if self.grid.carriers.balance(load):
            return True
        if rests_alone(self.grid.with_hold.system.under(load / np.abs(load).max()), PATIENCE):
            return True
        if self.grid.hold is not None:  # the faint hold would carry too much
            return False
        far = self.grid.system.under(self.grid.system.model.wrench + BEYOND * peak * load)
        return far.come_to_rest(near=self.grid.settled.q, most=PATIENCE).outcome is RestOutcome.RESTS

    @property
    def _notes(self) -> tuple[str, ...]:
        return (only_balanced(self.loose),) if self.loose else ()
