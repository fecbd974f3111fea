"""Derivatives of answers, from multipliers where the answer is that of limit analysis, and by differences elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from holdfast.applications.gradients.multipliers import KINK, Motions, Multipliers, OtherOptima, add_loads
from holdfast.applications.gradients.parameters import Derived, Parameters
from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.arrays import Bool, Float, Int, checked_number, frozen
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import reported
from holdfast.base.public import Of, PublicValue, Record, Summary, column, number
from holdfast.base.rigid import cross
from holdfast.base.values import Table, altered
from holdfast.engines.contract import GRADIENTS, Engine, Gradient, Sloping, State
from holdfast.engines.groups import Groups, prepared
from holdfast.engines.limit.limit_state import factors_on
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status
from holdfast.queries.push import load_factors
from holdfast.queries.request import CERTAIN_ENGINE, body_numbers, checked_assembly, engine_of, quiet
from holdfast.queries.result import SHOWN
from holdfast.queries.uncertain import Pair
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

WHERE = "gradients"
STEP = 1e-4  # of differences, in usual changes of a parameter: a tenth of the usual gap
TOUCHING = 1e-6  # relative difference of two answers, of which one is never above the other, that have the same slopes
SMOOTH = 1e-3  # difference of both one-sided slopes, in factors per usual change, up to which they are one


class Slopes(Record, kw_only=True):
    """Derivatives of n answers, in their unit (newtons for pushes) per unit of what they are derived by.

    ``pose`` maps bodies to (n, 6): by translation [1/m], then rotation [1/rad] about the body's origin, world axes.
    ``friction`` maps the two bodies of each interface to (n,), and ``mass`` movable bodies to (n,) [1/kg], with the
    centre of mass in place. ``point`` (n, 3) [1/m] is by the point of a push and ``direction`` (n, 3) by its unit
    direction [1/rad]; both are 0 for answers that are not about pushes.
    """

    pose: Table[str, Float]
    friction: Table[Pair, Float]
    mass: Table[str, Float]
    point: Float = column("n 3")
    direction: Float = column("n 3")


class Kink(Record, kw_only=True):
    """A kink of the answer in one ``row``: it grows with ``by`` (in words) otherwise ``before`` than ``after``."""

    row: int
    by: str
    before: float
    after: float


class Derivatives(PublicValue):
    """The derivatives of n answers ``force`` (n,) by poses, friction, masses and pushes; see ``Slopes``.

    A push moves and turns with its body; the loads of a load factor and standing loads stay in place, and accelerations
    keep their direction in the world. Contacts follow the bodies as ``assemble`` finds them: a face that opens or
    overlaps by less than the gap still touches, halfway between the two bodies.

    At a kink the answer has another slope below the value of the parameter, ``before``, than above it, ``after``. The
    slopes ``pose`` and so on are there the one of less magnitude, or 0 if the two differ in sign: so no step along them
    promises what only one side gives. Elsewhere all three are the same. ``kinks`` lists all kinks.

    ``known`` (n,) tells which rows have derivatives: those that are finite and greater than 0; others are 0.
    ``from_multipliers`` (n,) tells which of them come from the multipliers of one solve, exact up to the accuracy of
    the solver; the others are differences of answers, good to about 1e-3.
    """

    engine: str
    force: Float = column("n")
    known: Bool = column("n")
    from_multipliers: Bool = column("n")
    slopes: Slopes
    before: Slopes
    after: Slopes
    kinks: tuple[Kink, ...]
    notes: tuple[str, ...]

    pose = Of[Table[str, Float]]("slopes.pose", "The derivatives (n, 6) by the pose of each body.")
    friction = Of[Table[Pair, Float]](
        "slopes.friction", "The derivatives (n,) by the coefficient of friction of each pair of bodies."
    )
    mass = Of[Table[str, Float]]("slopes.mass", "The derivatives (n,) [1/kg] by the mass of each movable body.")
    point = Of[Float]("slopes.point", "The derivatives (n, 3) [1/m] by the point of the push.")
    direction = Of[Float]("slopes.direction", "The derivatives (n, 3) by the unit direction of the push.")

    def soft_weights(self, width: float) -> tuple[float, Float]:
        """Return a smooth least force, and the weights (n,) that turn derivatives of rows into its derivative.

        It is -width log Σ exp(-force / width) over the known rows: at most their least force, and by at most width
        log(n) less. ``width`` is in the unit of the answers. All weights are 0 if no row is known, and it is then inf.
        """
        width = checked_number(width, "soft_weights: width", above=0)
        weights = np.zeros(len(self.force))
        if not self.known.any():
            return np.inf, frozen(weights)
        least = float(self.force[self.known].min())
        weights[self.known] = np.exp(-(self.force[self.known] - least) / width)
        return least - width * float(np.log(weights.sum())), frozen(weights / weights.sum())

    def summary(self) -> Summary:
        """Summarise by which pose the least answer changes most."""
        headline = f"{len(self.force):,} answers, {int(self.known.sum()):,} with derivatives, {len(self.kinks):,} kinks"
        rows = []
        if self.known.any():
            row = int(np.argmin(np.where(self.known, self.force, np.inf)))
            headline += f"; the least, {number(float(self.force[row]))}, grows"
            order = sorted(self.pose.items(), key=lambda item: -float(np.abs(item[1][row]).max()))
            rows = [[name, *(f"{value:.4g}" for value in slopes[row])] for name, slopes in order[:SHOWN]]
        heads = ("with the pose of", *(f"along {axis}" for axis in "xyz"), *(f"about {axis}" for axis in "xyz"))
        return Summary(headline, (("engine", self.engine),), heads, rows, self.notes)


def gradients(
    assembly: Assembly | Scene,
    answer: Derived,
    *,
    bodies: Iterable[str] | None = None,
) -> Derivatives:
    """Compute the derivatives of every row of an ``answer`` by the poses of bodies, friction, masses and the push.

    ``answer`` is that of ``robustness``, ``load_factor`` or ``transport_limits`` for this ``assembly``. ``bodies``
    limits the derivatives to poses and masses of these bodies, and to their friction; by default all bodies, fixed ones
    too, are derived by.

    The derivatives of engine ``limit`` follow from one solve for each row (multipliers.py). Those of a row of engine
    ``compliant`` in which a plane contact gives way that carries what equilibrium alone decides are closed form
    (engines/trees/tree_state.py), and so are both sides of their kinks. A row of ``compliant`` that comes as far as
    ``limit`` has the same slopes: an answer that is never above another one touches it. All others are differences of
    answers of moved scenes, two for each parameter, and so are both sides of their kinks. A kink is where another set
    of contacts would carry, edges of two bodies are flush, or a contact appears or ends.

    Raises SceneError for scenes with holds, tension or cohesion, and HoldfastError for an answer that is about no load,
    of an engine with options, about another ``assembly`` (moved, say), that ends where a body is crushed, or that was
    saved or copied.
    """
    assembly = checked_assembly(assembly)
    refuse_holds(assembly.scene.holds, WHERE, "ask without holds")
    refuse_joined(assembly, WHERE, "leave out tension and cohesion")
    if not hasattr(answer, "questions"):
        problem = f"got a {type(answer).__name__}"
        raise HoldfastError(message(WHERE, problem, "needs an answer of robustness, load_factor or transport_limits"))
    question = answer.questions[0]
    if (loads := question.loads) is None:
        problem = "the answer is about no load"
        raise HoldfastError(message(WHERE, problem, "ask robustness, load_factor or transport_limits"))
    scene = altered(assembly.scene, gravity=question.assembly.scene.gravity)  # limits of a tilted carrier turn it
    tilted = replace(assembly, scene=scene) if isinstance(answer, TransportLimits) else assembly
    if question.assembly != tilted:
        raise HoldfastError(message(WHERE, "the answer is about another assembly", "give the one that was asked"))
    names = (
        [body.name for body in assembly.bodies] if bodies is None else list(body_numbers(assembly, list(bodies), WHERE))
    )
    parameters = Parameters(answer, question, loads, frozenset(names))
    return _DerivedRows(parameters, engine_of(answer.engine)).all()


@dataclass(frozen=True, eq=False)
class _DerivedRows:
    """All rows of an answer, whose engine is ``method``."""

    parameters: Parameters
    method: Engine

    @cached_property
    def known(self) -> Bool:
        """Which rows (n,) have derivatives."""
        table = self.parameters.answer.answers
        return np.array(
            [s is Status.FINITE and f > 0 for s, f in zip(table.status, table.force, strict=True)], dtype=bool
        )

    @cached_property
    def force(self) -> Float:
        """The answers (n,)."""
        return np.array(self.parameters.answer.answers.force)

    def all(self) -> Derivatives:
        """Return the derivatives of all rows."""
        shape = len(self.force), len(self.parameters.every)
        (before, after), (kinked, sharp) = np.zeros((2, *shape)), np.zeros((2, *shape), dtype=bool)
        from_multipliers = np.zeros(len(self.force), dtype=bool)
        motions: Motions = {}
        for row in reported(WHERE, np.flatnonzero(self.known).tolist()):
            sides = self._of_tree(row)
            if sides is not None:
                from_multipliers[row] = True
                before[row], after[row] = sides
                sharp[row] = np.abs(after[row] - before[row]) > KINK * self.force[row] / self.parameters.units
                continue
            solved = self._solved(row)
            if solved is not None:
                from_multipliers[row] = True
                others = OtherOptima(*solved)
                before[row], kinked[row] = Multipliers(self.parameters, motions, solved[0], row, others).slopes()
                after[row] = before[row]
        unlike = self.known & ~from_multipliers
        if unlike.any():
            question = self.parameters.question
            again = self._answers(question.assembly, self.parameters.loads[:, unlike], question.standing)
            if not np.allclose(again, self.force[unlike], rtol=TOUCHING):
                problem = f"engine {self.method.name!r} as it is by default answers otherwise"
                remedy = "ask by the name of an engine, without options, of bodies without top_load and pressure"
                raise HoldfastError(message(WHERE, problem, remedy))
        differ = kinked | unlike[:, None]
        with quiet():
            for place in reported("differences", np.flatnonzero(differ.any(axis=0)).tolist()):
                rows = differ[:, place]
                step = STEP * float(self.parameters.units[place])
                slopes = []
                for sign in (-1.0, 1.0):
                    assembly, W, standing = self.parameters.changed(place, sign * step, rows)
                    there = self._answers(assembly, W, standing)
                    jump = sign * np.where(there > self.force[rows], np.inf, -np.inf)
                    finite = np.isfinite(there) & (there > 0)
                    slopes.append(np.where(finite, (there - self.force[rows]) / (sign * step), jump))
                before[rows, place], after[rows, place] = slopes
        unit = self.parameters.units / np.where(self.known, self.force, 1.0)[:, None]
        with np.errstate(invalid="ignore"):
            apart = np.abs(after - before) * unit > SMOOTH
        same = differ & ~kinked & ~apart & np.isfinite(before) & np.isfinite(after)
        return self._result(before, after, from_multipliers, sharp | (differ & ~same), same)

    @np.errstate(invalid="ignore")  # what jumps has an infinite slope on one side
    def _result(self, before: Float, after: Float, from_multipliers: Bool, kinks: Bool, same: Bool) -> Derivatives:
        middle = np.where(same, (before + after) / 2, before)
        before, after = np.where(same, middle, before), np.where(same, middle, after)
        least = np.where(np.abs(before) < np.abs(after), before, after)
        value = np.where(kinks, np.where(before * after > 0, least, 0.0), middle)
        count = int((self.known & ~from_multipliers).sum())
        how = f"engine {self.method.name} gives no multipliers there"
        note = f"{count:,} rows are differences of answers, good to about 1e-3: {how}"
        return Derivatives(
            engine=self.method.name,
            force=frozen(self.force),
            known=frozen(self.known),
            from_multipliers=frozen(from_multipliers),
            slopes=self._table(value),
            before=self._table(before),
            after=self._table(after),
            kinks=tuple(
                Kink(
                    row=row,
                    by=str(self.parameters.every[place]),
                    before=float(before[row, place]),
                    after=float(after[row, place]),
                )
                for row, place in np.argwhere(kinks).tolist()
            ),
            notes=(note,) if count else (),
        )

    def _table(self, each: Float) -> Slopes:
        """Return the derivatives (n, P) by what they are derived by."""
        parameters = self.parameters
        found = {
            (kind, one.of): frozen(each[:, first : first + size].copy())
            for kind, size in (("pose", 6), ("friction", 1), ("mass", 1), ("push", 6))
            for first, one in enumerate(parameters.every)
            if one.kind == kind and one.way == 0
        }
        push = next((value for (kind, _), value in found.items() if kind == "push"), np.zeros((len(each), 6)))
        names = [body.name for body in parameters.assembly.bodies if body.name in parameters.named]
        return Slopes(
            pose=Table({name: found["pose", frozenset((name,))] for name in names}),
            friction=Table({pair: found["friction", frozenset(pair)][:, 0] for pair in parameters.pairs}),
            mass=Table({n: found["mass", frozenset((n,))][:, 0] for n in names if ("mass", frozenset((n,))) in found}),
            point=frozen(push[:, :3]),
            direction=frozen(push[:, 3:]),
        )

    @cached_property
    def _groups(self) -> dict[str, Groups]:
        """The groups by the engine of the answer and by limit analysis, which may be one."""
        question, engines = self.parameters.question, (engine_of(CERTAIN_ENGINE), self.method)
        return {one.name: prepared(one, question.assembly, question.standing, question.acceleration) for one in engines}

    def _state(self, engine: str, row: int) -> tuple[State, Float]:
        """Return the state of an engine for a row, and its load there; HoldfastError if no equilibrium is known."""
        load = self.parameters.loads[:, row]
        loaded: Int = np.flatnonzero(load.reshape(-1, 6).any(axis=1))
        state, rows = self._groups[engine].together(loaded.tolist(), WHERE)
        return state, load[rows]

    def _of_tree(self, row: int) -> tuple[Float, Float] | None:
        """Return the one-sided derivatives (P,) before and after of a row that a tree answers; None for others."""
        parameters = self.parameters
        try:
            state, load = self._state(self.method.name, row)
        except HoldfastError:  # among what is loaded there are others of which no equilibrium is known
            return None
        slope = state.slope(load) if isinstance(state, Sloping) else None
        if slope is None or abs(slope.factor - self.force[row]) > TOUCHING * self.force[row]:
            return None
        part = slope.assembly
        twists = np.zeros((len(part.movable), 6))
        twists[slope.beyond] = slope.twist
        twists[:, :3] += cross(twists[:, 3:], part.com)
        total, kinks = np.zeros((2, len(parameters.every)))
        add_loads(total, parameters, row, part, slope.factor, twists)
        parameters.add(total, "friction", slope.pair, slope.by_friction)
        for end, name in enumerate(slope.pair):
            smooth, kink = slope.by_motion(end, parameters.assembly.scene.body(name).pose[:3, 3])
            parameters.add(total, "pose", (name,), smooth)
            parameters.add(kinks, "pose", (name,), kink)
        return total - kinks, total + kinks

    def _solved(self, row: int) -> tuple[Gradient, Float] | None:
        """Return the multipliers of a row and its load (6J,), or None if limit analysis has another answer."""
        try:
            state, load = self._state(CERTAIN_ENGINE, row)
            optimum = GRADIENTS.of(state, engine=CERTAIN_ENGINE, where=WHERE).gradient(load, WHERE)
        except HoldfastError:  # limit analysis knows no equilibrium, or no finite answer
            return None
        touches = abs(float(optimum.answers.force[0]) - self.force[row]) <= TOUCHING * self.force[row]
        return (optimum, load) if touches else None

    def _answers(self, assembly: Assembly, W: Float, standing: Float) -> Float:
        """Return the answers (k,) for loads W (6J, k) on a changed assembly under a standing wrench (6J,)."""
        carried = self.parameters.question.acceleration
        if not isinstance(self.method, Limit):
            return np.asarray(load_factors(self.method, assembly, W, standing, carried, bounds=False).force)
        return factors_on(assembly, assembly.weight_wrench(carried) + standing, W)
