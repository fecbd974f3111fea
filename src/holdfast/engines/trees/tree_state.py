"""Answers of bodies that hang on their support by plane contacts, one behind the other; an engine answers the rest.

The bodies that trees leave open, such as a ball on a shelf, are an assembly of their own on those that stand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.values import altered
from holdfast.engines.answers import Answers, Bound, Claim, Step, joined
from holdfast.engines.contract import EXACT, Accuracy, Engine, Loadable, Slope, State, fresh, held_by
from holdfast.engines.mechanism import Kinematics, Mechanism, Mode, describe_all
from holdfast.engines.rest import corner_nodes, find_rest
from holdfast.engines.trees.forest import Exit, Forest, forest_of
from holdfast.engines.trees.slope import slope_of
from holdfast.engines.verdict import ContactForces, Look, Status, Verdict


def left_over(forest: Forest) -> tuple[Assembly, Int] | None:
    """Return the bodies that are not ``forest.decided``, on decided ones that are fixed, and their numbers (K,).

    None unless all their contacts are bridges. Then equilibrium alone says what each of them carries, so that whether
    they rest does not depend on how soft those are that stand beneath them.
    """
    whole, open_ = forest.assembly, np.flatnonzero(~forest.decided)
    of_open = set(open_.tolist())
    contacts = [k for k, ends in enumerate(whole.ends) if not of_open.isdisjoint(ends)]
    if whole.scene.holds or not set(forest.cuts.interfaces.tolist()).issuperset(contacts):
        return None
    names = {whole.movable[k].name for k in of_open}
    touched = {name for k in contacts for name in whole.interfaces[k].bodies}
    bodies = tuple(
        body if body.fixed or body.name in names else altered(body, fixed=True)
        for body in whole.bodies
        if body.name in touched
    )
    fixed = {k for k in range(FIXED, len(whole.movable)) if k not in of_open}
    interfaces = tuple(
        whole.interfaces[k].flipped() if whole.ends[k][1] in fixed else whole.interfaces[k] for k in contacts
    )
    scene = altered(whole.scene, bodies=bodies, excluded=())
    part = Assembly(scene, interfaces, whole.tolerances, detected=False, absent=whole.known_names)
    part.__dict__["axes"] = whole.axes
    return part, open_


RESTS = "every contact on the way to the support presses and has friction to spare"
NAME = "contacts on the way to the support"
FIRM = Verdict(
    status=Status.STABLE, reason=RESTS, equilibrium_exists=True, self_stress=False, steps=(Look(NAME, RESTS),)
)
MOST_TOLD = 30  # rows of one answer of which it is said what gives way; who asks for more reads none
WHY = "equilibrium alone says what each carries; an even bed says what it can"


def with_trees(engine: Engine, assembly: Assembly, standing: Float | None, acceleration: Float | None) -> State:
    """Prepare ``engine``, whose place trees take where they decide and it ``takes_trees``; see ``Engine.prepare``."""

    def make() -> State:
        return engine.prepare(assembly, standing, acceleration)

    if not getattr(engine, "takes_trees", False) or assembly.hanging:
        return make()
    wrench = assembly.weight_wrench(acceleration)
    forest = forest_of(assembly, wrench if standing is None else wrench + standing)

    def judge() -> Verdict | None:
        found = left_over(forest)
        if found is None:
            return None
        part, members = found
        own = None if standing is None else standing.reshape(-1, 6)[members].ravel()
        return engine.prepare(part, own, acceleration).verdict()

    return TreeState(forest, engine.name, engine.claim, make, judge) if forest.decided.any() else make()


@dataclass(frozen=True, eq=False)
class TreeState:
    """An assembly in which plane contacts that are bridges (forest.py) decide what some loads move.

    ``make`` prepares the engine that answers for the other loads. ``judge`` asks it whether the bodies stand that are
    not ``forest.decided``, on the others; its verdict is None if that depends on these, too.
    """

    forest: Forest
    engine: str
    claim: Claim
    make: Callable[[], State]
    judge: Callable[[], Verdict | None]

    @cached_property
    def behind(self) -> State:
        """The state of the engine that answers for loads that no tree decides, prepared when it is first asked."""
        return self.make()

    def fresh(self) -> TreeState:
        """Return the same state as it was before it was asked anything."""
        other = TreeState(self.forest, self.engine, self.claim, self.make, self.judge)
        if "behind" in self.__dict__:
            other.__dict__["behind"] = fresh(self.behind)
        return other

    @cached_property
    def _decided(self) -> Verdict:
        verdict = FIRM if self.forest.decided.all() else self.judge()
        if verdict is None or verdict.status is not Status.STABLE:
            return self.behind.verdict()
        return verdict.with_evidence(
            lambda: self._balanced.forces, lambda: self._balanced.residual, lambda: self._balanced.self_stress
        )

    @cached_property
    def _balanced(self) -> Verdict:
        """A verdict with forces: those on elastic contacts or, where these do not come to rest, any in balance."""
        found = self.behind.verdict()
        if found.status is Status.STABLE:
            return found
        return find_rest(self.forest.assembly, self.forest.wrench).verdict

    def verdict(self) -> Verdict:
        """Say whether the assembly stands under its weight and the standing loads."""
        return self._decided

    @property
    def notes(self) -> tuple[str, ...]:
        """No notes but those of the engine, if it was asked."""
        return self.behind.notes if "behind" in self.__dict__ else ()

    def _by_trees(self, W: Float) -> Bool:
        """Tell which columns of W (6J, n) load only bodies that trees decide."""
        loaded = (W.reshape(-1, 6, W.shape[1]) != 0).any(axis=1)
        return np.asarray(~loaded[~self.forest.decided].any(axis=0))

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the largest factor of each column of W (6J, n) before something moves: exactly, where trees decide."""
        verdict = self.verdict()
        if verdict.status is not Status.STABLE:
            return Answers.not_standing(W.shape[1], engine=self.engine, claim=self.claim, verdict=verdict)
        mine = np.flatnonzero(self._by_trees(W))
        found = self.forest.exits(W[:, mine])
        known = np.isfinite(found.lower) | np.isinf(found.factor)
        mine, found = mine[known], found.rows(known)
        others = np.setdiff1d(np.arange(W.shape[1]), mine)
        parts = [self._answers(found, verdict, W[:, mine])] if len(mine) or not len(others) else []
        parts += [self.behind.load_factor(W[:, others], accuracy)] if len(others) else []
        whole = joined(parts) if len(parts) > 1 else parts[0]
        return whole if not len(mine) or not len(others) else whole.rows(np.argsort(np.concatenate([mine, others])))

    def _answers(self, found: Exit, verdict: Verdict, W: Float) -> Answers:
        finite = np.isfinite(found.factor)
        said = self.forest.told(found, W) if len(finite) <= MOST_TOLD else ()
        return Answers.of(
            engine=self.engine,
            claim=self.claim,
            verdict=verdict,
            force=found.factor,
            lower=found.lower,
            status=[Status.FINITE if one else Status.INFINITE for one in finite],
            mechanism=self._mechanisms(found),
            lower_bound=Bound.PROVED,
            steps=(Step(NAME, WHY, found.factor, found.lower, said),),
        )

    @cached_property
    def _kinematics(self) -> Kinematics:
        return Kinematics.of(self.forest.assembly, corner_nodes(self.forest.assembly))

    def _mechanisms(self, found: Exit) -> list[Mechanism | None]:
        """Return how what is behind the contact that gives way begins to move; None where none does."""
        com, result = self.forest.assembly.com, list[Mechanism | None]([None] * len(found.factor))
        for number in np.unique(found.bridge[found.bridge >= 0]).tolist():
            bridge, rows = self.forest.bridges[number], np.flatnonzero(found.bridge == number)
            twists = np.zeros((len(rows), len(com), 6))
            turn = found.twist[rows, None, 3:]
            twists[:, bridge.beyond, :3] = found.twist[rows, None, :3] + np.cross(turn, com[bridge.beyond])
            twists[:, bridge.beyond, 3:] = turn
            twists[np.ix_(np.flatnonzero(found.slides[rows]), self.forest.left_behind(bridge))] = 0
            modes: list[Mode] = ["slip" if found.slides[row] else "topple" for row in rows.tolist()]
            for row, one in zip(rows.tolist(), describe_all(self._kinematics, twists, modes, dual=False), strict=True):
                result[row] = one
        return result

    def held(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n), certainly move nothing; False where that is not known."""
        held, mine = np.zeros(W.shape[1], dtype=bool), self._by_trees(W)
        if self.verdict().status is not Status.STABLE:
            return held
        held[mine] = self.forest.exits(W[:, mine]).lower > 1
        held[~mine] = held_by(self.behind, W[:, ~mine])
        return held

    def slope(self, load: Float) -> Slope | None:
        """Return the derivatives of the largest factor of ``load`` (6J,), None where no tree decides it."""
        return slope_of(self.forest, load) if self._by_trees(load[:, None])[0] else None

    def forces_under(self, load: Float) -> ContactForces | None:
        """Return the contact forces under ``load`` (6J,), or None if the engine does not know them."""
        return self.behind.forces_under(load) if isinstance(self.behind, Loadable) else None
