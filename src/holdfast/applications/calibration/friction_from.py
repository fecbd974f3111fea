"""Find coefficients of friction from measured pushes, by inverting ``robustness``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from holdfast.applications.calibration.friction_fit import LEAST_SCATTER, MOST_SCATTER, STEPS, Fit, contradicted
from holdfast.applications.calibration.measured_friction import MeasuredFriction
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.on_surface import check_on_surface
from holdfast.base import arrays
from holdfast.base.arrays import Bool, Float, objects
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.progress import report
from holdfast.base.public import number
from holdfast.base.ranges import FORCE, PLACE
from holdfast.base.text import listed, quoted
from holdfast.base.values import Table
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.queries import request
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load
from holdfast.queries.uncertain import Pair
from holdfast.scene.scene import Scene

BEGIN = 0.3  # coefficient where scans begin, whatever the file says: they reach from 0.06 to 1.5, all dry materials
ROUNDS = 8  # scans of all coefficients, each from where the last one found the most likely ones
ARRIVED = STEPS[STEPS > 0][0]  # step of ln mu below which a scan is not repeated: the finest one of it
CLOSE, MOST_ENDS = 2e-3, 8  # of ln mu, to which ends of intervals are sharp, and the most scans towards them
DEPENDS = 1e-3  # relative change of a force along a scan below which it does not depend on the coefficient
WIDE = 0.3  # scatter beyond twice what real pushes had (docs/howto/friction.md), where a note tells of it
UNLIKELY = 1e-3  # probability below which pushes contradict each other
NAMED = 3  # the most pairs that a note names
REACH = 1e12  # largest and smallest force, in weights of the assembly, where nothing, or anything at all, moves it
WHERE = "friction_from"
FORM = "pushes as (body, point, direction, force) or (body, point, direction, force, moved)"


@dataclass(frozen=True, eq=False)
class _Pushes:
    """Checked pushes on ``bodies`` (n,): ``points`` [m] and ``directions`` (n, 3), ``force`` [N] and ``moved`` (n,)."""

    bodies: list[str]
    points: Float
    directions: Float
    force: Float
    moved: Bool


def friction_from(
    assembly: Assembly | Scene,
    measured: Iterable[Sequence[Any]],
    *,
    scatter: float | None = None,
    confidence: float = 0.95,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
) -> MeasuredFriction:
    """Find the coefficients of friction with which ``robustness`` predicts measured pushes, and their intervals.

    ``measured`` are tuples (body, point, direction, force) or (body, point, direction, force, moved): the point (3,)
    [m] and the direction (3,) are in the world frame, and ``force`` [N] is the one at which something began to move.
    If ``moved`` is False, nothing moved at this force. ``standing`` loads act throughout.

    **Model.** The logarithm of a measured force is normally distributed about that of the predicted one, with a
    standard deviation ``scatter`` (0.1 is about 10 %). It is the same for all pushes, which are independent. A push
    that moved nothing is a one-sided observation: it counts with the probability that the force needed is larger.
    Without ``scatter``, it is estimated from the pushes that moved something, of which there must be more than pairs
    that they depend on. Intervals are those of the profile likelihood at the stated ``confidence``: they hold every
    coefficient that is not excluded whatever the others are. With an estimated scatter they are those of Student's t.

    **Unknowns.** Each pair of touching bodies has a coefficient of its own; pairs of the same two materials share one.
    ``robustness`` is solved on a grid of each coefficient, up and down by a factor of five from the most likely ones,
    so it need not grow with friction; an interval that reaches an end of its grid is open there. The search begins at
    0.3 for every pair, so that intervals do not depend on the coefficients of the scene. Where a push depends
    on several coefficients their effects are added up, and a note says so. Pairs that no push depends on are
    ``undetermined``: a push that topples a body says at most that friction is not lower. If no coefficients explain the
    pushes within a given scatter, the answer is undecided.

    Raises SceneError if there are no pushes, or if one is malformed or on a fixed or unknown body. Raises HoldfastError
    if the scatter cannot be estimated. See docs/howto/friction.md.
    """
    given = request.checked_assembly(assembly)
    pushes = _checked(given, measured)
    if scatter is not None:
        scatter = arrays.checked_number(scatter, f"{WHERE}: scatter", minimum=LEAST_SCATTER)
        if scatter > MOST_SCATTER:
            raise HoldfastError(message(f"{WHERE}: scatter", f"is {scatter:g}", f"needs at most {MOST_SCATTER:g}"))
    elif not pushes.moved.any():
        _refuse_scatter(0, 1)
    confidence = arrays.checked_number(confidence, f"{WHERE}: confidence", above=0, below=1)
    method = request.engine_of(engine)
    forces = _Forces(given, method, request.total_wrench(given, standing), pushes)
    pairs = _unknowns(given, pushes.bodies)
    at, fit, used, notes = _settled(forces, pairs, scatter)
    depends = [k for k, scan in enumerate(fit.scans) if (np.ptp(scan, axis=0) > DEPENDS).any()]
    fit = fit.among(depends)
    if scatter is None and used.any() and fit.freedom < 1:
        _refuse_scatter(int(fit.moved.sum()), len(depends))
    best = fit.best()
    undecided = _undecided(fit, best, pushes, used, given.weight)
    several = int((np.sum([np.ptp(scan, axis=0) > DEPENDS for scan in fit.scans], axis=0) > 1).sum())
    if several:
        notes = (*notes, f"{several} pushes depend on several coefficients, whose effects are added up")
    known: dict[int, tuple[float, float, float]] = {}
    if not undecided:
        fit, best, ends = _intervals(
            fit, best, lambda place, step: forces.beside(pairs, at, depends[place], step)[used], confidence
        )
        known = {k: (best[n], *ends[n]) for n, k in enumerate(depends) if np.isfinite(ends[n]).any()}
        undecided = "" if known else "the pushes exclude no coefficient of friction"
    notes = (*notes, *_plateaus([pairs[k][0] for k, (_, *ends) in known.items() if not np.isfinite(ends).all()]))
    off = fit.predicted(best) - fit.force
    spread = fit.scatter(off) if used.any() else scatter or 0.0
    if scatter is None and not undecided and spread > WIDE:
        notes = (*notes, f"the pushes scatter by {spread:.0%}, {_worst(fit, best, pushes, used)} most of all")
    predicted = np.zeros(len(pushes.force))
    predicted[used] = np.exp(fit.predicted(best))
    return MeasuredFriction(
        **_tables(given, pairs, at, known, 0.0 if undecided else fit.further(best, confidence)),
        undecided=undecided,
        scatter=spread,
        scatter_estimated=scatter is None,
        confidence=confidence,
        bodies=objects(pushes.bodies),
        points=pushes.points,
        directions=pushes.directions,
        force=pushes.force,
        moved=pushes.moved,
        predicted=predicted,
        engine=method.name,
        notes=notes,
    )


def _plateaus(several: Sequence[Pair]) -> list[str]:
    """Return a note on pairs whose interval is open, where ``mu`` is no more likely than its neighbours, if any."""
    named = listed([" and ".join(pair) for pair in several], NAMED)
    note = f"of {named} the interval alone says something: it is open, and mu any of its likely values"
    return [note] if several else []


def _checked(assembly: Assembly, measured: Iterable[Sequence[Any]]) -> _Pushes:
    """Return checked pushes; raise SceneError for the first that is malformed, or if there are none."""
    rows = arrays.checked_items(measured, f"{WHERE}: measured", FORM)
    if not rows:
        raise SceneError(message(f"{WHERE}: measured", "is empty", "needs at least one push"))
    found = []
    for k, row in enumerate(rows):
        where = f"{WHERE}: push {k}"
        if not isinstance(row, tuple | list) or len(row) not in (4, 5):
            raise SceneError(message(where, f"is {quoted(row, 80)}", f"needs {FORM}"))
        body, point, direction, force, moved = (*row, True)[:5]
        name = arrays.checked_name(body, f"{where}: body")
        if request.body_number(assembly, name) == FIXED:
            raise SceneError(message(where, f"{quoted(name)} is fixed", "name movable bodies"))
        place = arrays.checked(point, (3,), f"{where}: point", within=PLACE)
        check_on_surface(assembly, name, place[None], where)
        way = arrays.checked_direction(direction, f"{where}: direction")
        size = arrays.checked_number(force, f"{where}: force", above=0, within=FORCE)
        found.append((name, place, way, size, arrays.checked_truth(moved, f"{where}: moved")))
    bodies, points, directions, forces, moves = zip(*found, strict=True)
    return _Pushes(list(bodies), np.array(points), np.array(directions), np.array(forces), np.array(moves))


def _unknowns(assembly: Assembly, bodies: Iterable[str]) -> list[list[Pair]]:
    """Return the pairs of bodies that share a coefficient, those that a push on one of ``bodies`` may depend on.

    Pairs of the same two materials share one; a body without a material is its own.
    """
    reached = {name for group in assembly.groups if not set(bodies).isdisjoint(group) for name in group}
    shared: dict[frozenset[str], list[Pair]] = {}
    for pair in _pairs(assembly):
        if not reached.isdisjoint(pair):
            kinds = [body.material or body.name for body in map(assembly.scene.body, pair)]
            shared.setdefault(frozenset(kinds), []).append(pair)
    return list(shared.values())


@dataclass(frozen=True, eq=False)
class _Forces:
    """Predicts the forces of ``pushes`` on an assembly with other coefficients of friction."""

    assembly: Assembly
    engine: Engine
    standing: Float
    pushes: _Pushes

    def log(self, mu: dict[Pair, float]) -> Float:
        """Return the logarithms (n,) of the forces at which something moves; NaN where that is undecided."""
        a, pushes = self.assembly.with_friction(mu), self.pushes
        ones = zip(pushes.bodies, pushes.points, pushes.directions, strict=True)
        W = np.hstack([request.push_columns(a, a.index[name], p[None], e[None]) for name, p, e in ones])
        found = prepared(self.engine, a, self.standing).load_factor(W)
        force = np.log(np.clip(found.force / a.weight, 1 / REACH, REACH)) + np.log(a.weight)
        return np.where(found.decided, force, np.nan)

    def beside(self, pairs: Sequence[Sequence[Pair]], at: Float, k: int, step: float) -> Float:
        """Return the logarithms (n,) of the forces at coefficients exp(``at``) (K,), with a step of the k-th."""
        x = at + step * (np.arange(len(at)) == k)
        return self.log({pair: float(np.exp(value)) for one, value in zip(pairs, x, strict=True) for pair in one})

    def scanned(self, pairs: Sequence[Sequence[Pair]], at: Float) -> tuple[Float, Float]:
        """Return the logarithms of the forces (n,) at coefficients exp(``at``) (K,), and along scans of each of them.

        The scans are (K, steps, n). A force that is undecided along a scan is taken from its neighbours there.
        """
        base = self.beside(pairs, at, 0, 0.0)
        scans = np.zeros((len(pairs), len(STEPS), len(base)))
        for k in range(len(pairs)):
            for row, step in enumerate(STEPS):
                scans[k, row] = base if step == 0 else self.beside(pairs, at, k, step)
            for column in scans[k].T:
                known = np.isfinite(column)
                if known.any():
                    column[~known] = np.interp(STEPS[~known], STEPS[known], column[known])
        return base, scans


def _settled(
    forces: _Forces, pairs: Sequence[Sequence[Pair]], scatter: float | None
) -> tuple[Float, Fit, Bool, tuple[str, ...]]:
    """Scan until the scans cross at the most likely coefficients.

    Returns the logarithms (K,) at which they cross, the fit, which pushes (n,) are in it, and notes.
    """
    at = np.full(len(pairs), np.log(BEGIN))
    pushes, notes = forces.pushes, list(forces.assembly.scene.notes)
    for count in range(ROUNDS):
        report("friction", count, ROUNDS)
        base, scans = forces.scanned(pairs, at)
        used = np.isfinite(base)
        fit = Fit(
            base[used],
            (STEPS,) * len(pairs),
            tuple(scans[:, :, used]),
            np.log(pushes.force[used]),
            pushes.moved[used],
            scatter,
        )
        step = fit.best() if used.any() else np.zeros(len(pairs))
        if (np.abs(step) <= ARRIVED).all():
            break
        at = at + step
    else:
        notes.append("the most likely coefficients were still changing when the search for them ended")
    report("friction", ROUNDS, ROUNDS)
    if not used.all():
        notes.append(f"{int((~used).sum())} pushes do not count, because the force that they take is undecided")
    return at, fit, used, tuple(notes)


def _intervals(
    fit: Fit, best: Float, predict: Callable[[int, float], Float], confidence: float
) -> tuple[Fit, Float, list[tuple[float, float]]]:
    """Return the interval of each coefficient, the most likely ones, and the fit with more steps where intervals end.

    Between the steps of a scan, which are wide far from its middle, a force that no longer grows has a kink. So the
    forces at the ends are predicted, ``predict(coefficient, step)``, until the ends no longer move.
    """
    for count in range(MOST_ENDS + 1):
        found = [fit.interval(place, best, confidence) for place in range(len(fit.scans))]
        ends = [(place, end) for place, both in enumerate(found) for end in both]
        coarse = [(place, end) for place, end in ends if CLOSE < np.abs(fit.steps[place] - end).min() < np.inf]
        if not coarse or count == MOST_ENDS:
            break
        for place, end in coarse:
            fit = fit.with_step(place, end, predict(place, end))
        best = fit.best()
    return fit, best, found


def _undecided(fit: Fit, best: Float, pushes: _Pushes, used: Bool, weight: float) -> str:
    """Say why nothing can be said at all: "" if something can. ``weight`` [N] is the scale of forces."""
    if not used.any():
        return "the force that each push takes is undecided"
    if (fit.predicted(best) <= np.log(weight / REACH) + ARRIVED).all():
        return "it does not stand even without a push, or is only balanced"
    if not len(best):
        return "no push depends on a coefficient of friction"
    misfit, found = fit.misfit(best), fit.scatter(fit.predicted(best) - fit.force)
    if found < MOST_SCATTER and (fit.given is None or not contradicted(misfit, len(best), UNLIKELY)):
        return ""
    return f"no coefficients explain the pushes within a scatter of {found:.3g}: {_worst(fit, best, pushes, used)}"


def _worst(fit: Fit, best: Float, pushes: _Pushes, used: Bool) -> str:
    """Describe the push that is furthest from its prediction."""
    worst = int(np.argmax(fit.misfit(best)))
    k = int(np.flatnonzero(used)[worst])
    did = "moved" if pushes.moved[k] else "held"
    needs = number(float(np.exp(fit.predicted(best)[worst])), "N")
    return f"push {k} on {pushes.bodies[k]} {did} at {number(float(pushes.force[k]), 'N')}, predicted {needs}"


def _tables(
    assembly: Assembly,
    pairs: Sequence[Sequence[Pair]],
    at: Float,
    known: dict[int, tuple[float, float, float]],
    further: float,
) -> dict[str, Any]:
    """Return the tables of coefficients by pair.

    ``known`` holds what was found of each of the ``pairs``, by number: the logarithms of the most likely value and of
    both ends, from ``at`` (K,). A further push scatters by ``further`` about its prediction.
    """
    own = dict(zip((tuple(sorted(i.bodies)) for i in assembly.interfaces), assembly.mu, strict=True))
    mu, intervals, wider = {}, {}, {}
    for k, (best, low, high) in known.items():
        ends = [best - np.hypot(best - low, further), best + np.hypot(high - best, further)]
        for pair in pairs[k]:
            mu[pair] = float(np.exp(at[k] + best))
            intervals[pair] = (float(np.exp(at[k] + low)), float(np.exp(at[k] + high)))
            least, most = (float(np.exp(at[k] + end)) for end in ends)
            wider[pair] = (least, most if np.isfinite(most) else max(least, own[pair]))
    return {
        "mu": Table(mu),
        "intervals": Table(intervals),
        "mu_range": Table(wider),
        "undetermined": tuple(pair for pair in _pairs(assembly) if pair not in mu),
    }


def _pairs(assembly: Assembly) -> list[Pair]:
    """Return all pairs of touching bodies, the names of each in alphabetical order."""
    return list(dict.fromkeys((min(i.bodies), max(i.bodies)) for i in assembly.interfaces))


def _refuse_scatter(moved: int, unknowns: int) -> NoReturn:
    problem = f"cannot be estimated from {moved} pushes that moved something and {unknowns} coefficients"
    raise HoldfastError(message(f"{WHERE}: scatter", problem, "give more pushes, or scatter=, such as 0.15"))
