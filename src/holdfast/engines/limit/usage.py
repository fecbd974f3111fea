"""How much of what is carried a load of a family uses, 1/R, between two bounds that take little time.

Some rays are asked beforehand. The hull of what they prove to be carried bounds the usage of every other load from
above, and the motions that limit them bound it from below, both in microseconds. One program for the load itself, whose
solver may be stopped at any time, lowers the upper bound: contact forces that balance exactly prove what it found.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.conic.solve import Outcome
from holdfast.engines.limit.family import SMALLEST, Family, Ray
from holdfast.engines.limit.farthest_load import Corner, Support
from holdfast.engines.limit.interior import TOLERANCE
from holdfast.engines.limit.limit_program import LoadProgram
from holdfast.engines.limit.limit_state import LimitState
from holdfast.engines.limit.load_hull import BATCH, LARGEST, TILT
from holdfast.engines.limit.load_sets import ALIKE
from holdfast.engines.limit.rounding import DOWN, UP, gamma
from holdfast.geometry.hull_gauge import hull_gauge

UNKNOWN = 1 / SMALLEST**2  # stands for a usage of which nothing is known: finite, so that nothing is inf times 0


class Usage:
    """Bounds of the usage of the loads ``columns`` (6J, d) @ x on the assembly of a ``state``.

    The program for one load is solved to TOLERANCE: that takes 11 ms for 40 boxes, where 1e-9 takes 18, and what is
    proved then is 0.4 % more cautious in the median, 3 % at the most. Until some rays are asked, nothing is known but
    what the room of contact forces at rest proves.
    """

    def __init__(self, state: LimitState, columns: Float) -> None:
        proofs, size, columns = state.proofs, columns.shape[1], state.rest.nodes.beside(columns)
        self._state, self._family = state, Family("monitor", proofs, columns)
        self._program = LoadProgram(
            proofs.equilibrium, state.rest.nodes, state.wrench, state.cone, proofs.program.tau, TOLERANCE
        )
        sizes = np.abs(columns)
        paid = np.where(sizes > 0, proofs.slope[:, None], 0.0) * sizes if self.certain else np.inf
        self._known = np.vstack([np.eye(size), -np.eye(size)])
        self._price = np.tile(np.minimum(np.sum(paid, axis=0) * UP, UNKNOWN) * np.ones(size), 2)
        self._rows = np.empty((0, size))
        self._moving: list[tuple[str, ...]] = []

    @property
    def certain(self) -> bool:
        """Whether anything can be proved to be carried."""
        return self._state.proofs.certain

    def explore(self, near: Float, solves: int) -> None:
        """Ask along the axes, and then where bounds are farthest apart among ``near`` (n, d), with some ``solves``.

        Rounds take turns: one asks along such loads, for what limits them; the next for the loads that go farthest
        beyond what is known to be carried around them, as in load_hull.py.
        """
        size, turn, rng = near.shape[1], 0, np.random.default_rng(0)
        box = LARGEST * np.abs(near).max(0)
        support = Support(self._family.proofs.program, self._family.columns * box)
        asked = np.vstack([np.eye(size), -np.eye(size)])[:solves]
        self.ask(asked)
        while len(asked) and (solves := solves - len(asked)) > 0:
            turn += 1
            high, facets = hull_gauge(self._known, self._price, near)
            low = _below(near, self._rows).max(1, initial=0.0)
            worst = np.argsort(low / np.maximum(high, 1e-300))
            asked = _unlike((near if turn % 2 else facets)[worst[(low < high)[worst]]], min(BATCH, solves))
            if turn % 2:
                self.ask(asked)
                continue
            found = [support.farthest(way * (1 + TILT * rng.normal(size=size)) * box) for way in asked]
            corners = [Corner(corner.x * box, corner.forces) for corner in found if corner is not None]
            self._learn(self._family.through(corners))

    def ask(self, directions: Float) -> None:
        """Learn what is carried along ``directions`` (n, d), and which motions limit it."""
        self._learn(self._family.along(list(directions)))

    def _learn(self, rays: list[Ray]) -> None:
        carried = [ray for ray in rays if ray.reach > 0 and self.certain]
        if carried:
            self._known = np.vstack([self._known, *(ray.direction for ray in carried)])
            self._price = np.append(self._price, [1 / ray.reach * UP for ray in carried])
        limited = [ray for ray in rays if ray.row is not None]
        if limited:
            self._rows = np.vstack([self._rows, *(ray.row for ray in limited if ray.row is not None)])
            twists = np.array([ray.twists for ray in limited])
            self._moving += [found.moving for found in self._state.mechanisms(twists)]

    def known(self, x: Float) -> tuple[float, float, tuple[str, ...]]:
        """Return bounds of the usage at x (d,), and the names of the bodies that move first, () if none are known."""
        below = _below(x[None], self._rows)[0]
        best = int(np.argmax(below)) if len(below) else -1
        low, moving = (float(below[best]), self._moving[best]) if best >= 0 and below[best] > 0 else (0.0, ())
        return low, float(hull_gauge(self._known, self._price, x[None])[0][0]), moving

    def solved(self, x: Float, until: float) -> tuple[float, bool]:
        """Return an upper bound of the usage at x (d,) from one program, and whether that was solved in time.

        The solver stops at ``until``, a time of ``time.perf_counter``.
        """
        load = self._family.columns @ x
        if not (self._program.scales.motion * load).any():  # not even after underflow
            return 0.0, True
        proofs = self._family.proofs
        found = self._program.maximise(load, until=until)
        if found.outcome is Outcome.UNBOUNDED:
            limit = proofs.judged([found], load[:, None])[0]
            lower = limit.lower if limit.certain else 0.0
        elif found.factor > 0:
            lower = found.factor * float(proofs.carried(found.forces[:, None], found.factor * load[:, None])[0]) * DOWN
        else:
            lower = 0.0
        return (1 / lower * UP if lower > 0 else np.inf), found.outcome is not Outcome.LIMIT

    def proved(self, x: Float) -> float:
        """Return a lower bound of the usage at x (d,) from a program of its own, which nothing stops."""
        rows = [ray.row for ray in self._family.along([x]) if ray.row is not None]
        return float(_below(x[None], np.array(rows))[0].max()) if rows else 0.0


def _below(x: Float, rows: Float) -> Float:
    """Return lower bounds (n, m) of the usage at x (n, d), one by each of the half-spaces ``rows`` (m, d)."""
    return np.asarray(x @ rows.T - gamma(x.shape[1]) * (np.abs(x) @ np.abs(rows).T))


def _unlike(ways: Float, most: int) -> Float:
    """Return up to ``most`` of these ways (n, d), the first ones, no two of which are ALIKE."""
    chosen = np.empty((0, ways.shape[1]))
    for way in ways:
        length = float(np.linalg.norm(way))
        if len(chosen) >= most:
            break
        if length > 0 and (chosen @ way).max(initial=-1.0) < ALIKE * length:
            chosen = np.vstack([chosen, way / length])
    return chosen
