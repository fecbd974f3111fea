"""Engine ``compliant``: the peak of the load path on elastic contacts with Coulomb friction.

An answer comes about in these steps, in this order:

1. *Solve*: the peak of the load path from rest, on the first grid (grid.py).
2. *Correct*: finer grids tell how far that may be off, and take its place (refinement.py).
3. *Doubt*: what paths do not know. ``LimitReview``: limit analysis proves above which load bodies move.
   ``SelfStressed``: where bodies press each other without any load, or are near their limit, ``lower`` covers other
   stiffness and other nodes. ``Sliding``: ``lower`` is what is reached before contacts have slid far. ``OpenContacts``:
   ``lower`` leans on no contact that is open and idle at rest.
4. *Tell*: the table of answers, with what each step made of it.

Of the answers of every engine groups.py makes 0 what rounding alone tells from 0, and doubts/ bounds them over the
presence of contacts that may not exist.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import Event, RLock
from typing import ClassVar, TypeAlias

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float, Int, checked_number, checked_whole
from holdfast.base.progress import begin, free_threads
from holdfast.base.public import Record
from holdfast.base.ranges import STIFFNESS
from holdfast.elastic.system import PathOutcome, PathResult, RestOutcome
from holdfast.engines.answers import Answers, Bound, Claim, Step, balanced_in_verdict
from holdfast.engines.compliant.amendment import Amendment, LimitReview, LoadQuestion, OpenContacts, Sliding
from holdfast.engines.compliant.balanced import Neutral, neutral_at
from holdfast.engines.compliant.elastic_model import WHAT, Springs, Stiffness, check_stiffness
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.load_bearing import HUGE
from holdfast.engines.compliant.refinement import REFINEMENTS, Bounded, Refined
from holdfast.engines.compliant.rest_verdict import at_rest, balanced_forces, not_at_rest, overruled
from holdfast.engines.compliant.self_stressed import SelfStressed
from holdfast.engines.contract import EXACT, Accuracy, ForcesOnly
from holdfast.engines.imperfect import RandomFaces
from holdfast.engines.mechanism import Mechanism
from holdfast.engines.rest import contact_forces, find_rest
from holdfast.engines.trees.forest import forest_of
from holdfast.engines.trees.tree_state import FIRM
from holdfast.engines.verdict import ContactForces, Status, Verdict
from holdfast.scene.friction import checked_pairs

NAME, CLAIM = "compliant", Claim.HOLDS
AMENDMENTS: tuple[type[Amendment], ...] = (LimitReview, SelfStressed, Sliding, OpenContacts)  # in this order
STATUS = {
    PathOutcome.PEAK: Status.FINITE,
    PathOutcome.ENDLESS: Status.INFINITE,
    PathOutcome.LOST: Status.UNDECIDED,
}


@dataclass(frozen=True, eq=False)
class Unpushable:
    """An assembly without a known state of rest on elastic contacts, so that no load path can start."""

    decided: Verdict

    notes: ClassVar[tuple[str, ...]] = ()  # the claim of the engine already states what the answers rest on

    def verdict(self) -> Verdict:
        """Say whether the assembly comes to rest."""
        return self.decided

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Answer for each column of W (6J, n) without a load path.

        All rows have force 0 if the assembly does not stand or may not stand. Otherwise a column is UNDECIDED, or
        INFINITE if it is zero.
        """
        if self.decided.status is not Status.STABLE:
            return Answers.not_standing(W.shape[1], engine=NAME, claim=CLAIM, verdict=self.decided)
        loaded = _loaded(W)
        lost = Bounded.unbounded(PathResult.lost(len(loaded), 0))
        return _answers_of_paths(
            LoadQuestion(W, accuracy, loaded, lost, np.zeros(len(loaded), dtype=bool)), self.decided, []
        )


@dataclass(frozen=True, eq=False)
class RestingState:
    """An assembly at rest on elastic contacts. All load paths start at this state of rest.

    ``neutral`` are the motions that no contact resists, of bodies that are only balanced; None if nothing may have any.
    """

    decided: Verdict
    refined: Refined
    neutral: Neutral | None = None

    notes: ClassVar[tuple[str, ...]] = ()  # as of ``Unpushable``

    _asking: RLock = field(default_factory=RLock, init=False, repr=False)  # searches for rest work in the grids' memory
    _begun: Event = field(default_factory=Event, init=False, repr=False)  # what lower bounds need

    @cached_property
    def grid(self) -> Grid:
        """The grid from which answers are taken unless it is too coarse."""
        return self.refined.grid

    def verdict(self) -> Verdict:
        """Say that the assembly comes to rest, with the contact forces."""
        return self.decided

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the peak of the load path of each column of W (6J, n) [N, N m].

        ``lower`` is the peak minus the estimated discretisation error. Every column is answered as if it were asked
        alone, ``Within`` an error, too: a neighbour's error says nothing certain about its own. With ``ForcesOnly``,
        ``lower`` is 0 and no finer grid is needed. Of several threads that ask, one waits for the other.
        """
        with self._asking:
            loaded, bounds = _loaded(W), not isinstance(accuracy, ForcesOnly)
            if not len(loaded):
                solved = Bounded.unbounded(PathResult.lost(0, len(W)))
            else:
                # lower bounds begin while the first long path is followed, which leaves a processor idle
                if bounds and self.grid.system.long and free_threads() > 1 and not self._begun.is_set():
                    self._begun.set()
                    begin(lambda: (self.grid.finer, self._self_stressed.by_stiffness))
                solved = self.refined.answers(W[:, loaded], bounds=bounds)
            leans = self.grid.leans(W[:, loaded], solved.paths)
            peaks = solved.paths.outcome == PathOutcome.PEAK
            question = LoadQuestion(W, accuracy, loaded, solved, leans)
            answers = _answers_of_paths(question, self.decided, self.grid.mechanisms(solved.paths.motion[peaks]))
            for amendment in self._amendments:
                amended = amendment.amend(answers, question)
                answers = answers if amended is None else amended.after(amendment.name, amendment.why)
            return answers

    @cached_property
    def without_idle(self) -> RestingState | None:
        """The same state without contacts that are open and carry nothing at rest; None if there are none."""
        grid = self.grid
        if not grid.idle or grid.springs.faces is not None:
            return None
        bare = Grid.of(grid.assembly.without_interfaces(grid.idle), grid.wrench, grid.springs, hold=grid.hold)
        return RestingState(self.decided, replace(self.refined, grid=bare), self.neutral)

    def held(self, W: Float) -> Bool:
        """Tell which loads, columns of W (6J, n), certainly move nothing; False where more has to be asked.

        Where a load acts on a body that is only balanced, where bodies are self-stressed, and where loads are so large
        that paths may leave their branch, it takes what ``load_factor`` does: no path that ends at the load tells.
        """
        small = (np.abs(self.grid.loads(W)).max(axis=1, initial=0.0) <= HUGE) & ~self.grid.loads_held(W)
        rows = np.flatnonzero(small & (W != 0).any(axis=0))
        moves_nothing = ~(W != 0).any(axis=0)
        if self.grid.springs.faces is not None or not len(rows):
            return np.asarray(moves_nothing)
        with self._asking:
            if not self._self_stressed.by_stiffness:
                moves_nothing[rows] = self.refined.held(W[:, rows])
                if self.without_idle is not None:
                    moves_nothing &= self.without_idle.held(W)
        return np.asarray(moves_nothing)

    def forces_under(self, load: Float) -> ContactForces | None:
        """Return the contact forces once a ``load`` (6J,) [N, N m] has grown from 0, None if its path ends before."""
        grid = self.grid
        with self._asking:
            path = grid.paths(load[:, None], most=1.0)
            if path.outcome[0] != PathOutcome.REACHED:
                return None
            system = grid.system.under(grid.system.model.wrench + grid.loads(load[:, None])[0])
            back = grid.settled.q + (path.q[0] - grid.settled.q) / path.peak[0]  # the path steps beyond the load
            q = system.rest_near(back)
            found = None if q is None else balanced_forces(grid, q, load)
            found = found or balanced_forces(grid, system.come_to_rest(near=path.q[0]).q, load)
        return None if found is None else contact_forces(grid.assembly, grid.nodes, found[0])

    @cached_property
    def _amendments(self) -> tuple[Amendment, ...]:
        return tuple(kind(self) for kind in AMENDMENTS)

    @cached_property
    def _self_stressed(self) -> SelfStressed:
        return next(one for one in self._amendments if isinstance(one, SelfStressed))


CompliantState: TypeAlias = RestingState | Unpushable


def _loaded(W: Float) -> Int:
    """Return the numbers of the columns of W (6J, n) that are not zero."""
    return np.flatnonzero(np.abs(W).max(axis=0, initial=0) > 0)


def _answers_of_paths(question: LoadQuestion, verdict: Verdict, mechanisms: Iterable[Mechanism]) -> Answers:
    """Return the answers that load paths give, INFINITE to loads of zero; ``mechanisms`` are of paths with a peak."""
    count, loaded, paths = question.W.shape[1], question.loaded, question.solved.paths
    force, lower, raw = np.full((3, count), np.inf)
    force[loaded], lower[loaded], raw[loaded] = paths.factor, question.solved.lower, question.solved.raw
    status, mechanism = [Status.INFINITE] * count, list[Mechanism | None]([None] * count)
    for column, outcome in zip(loaded.tolist(), paths.outcome.tolist(), strict=True):
        status[column] = STATUS[PathOutcome(outcome)]
    for column, one in zip(loaded[paths.outcome == PathOutcome.PEAK].tolist(), mechanisms, strict=True):
        mechanism[column] = one
    lower = np.minimum(lower, force)
    steps = (
        Step("load path on the first grid", "the load at which its path from rest has a peak", raw, np.zeros(count)),
        Step("finer grids", "lower is less by twice the change from one grid to the next and by 0.2 %", force, lower),
    )
    return Answers.of(
        engine=NAME,
        claim=CLAIM,
        verdict=verdict,
        force=force,
        lower=lower,
        status=status,
        mechanism=mechanism,
        lower_bound=Bound.ESTIMATED if question.bounded else Bound.NONE,
        steps=steps,
    )


FEWEST, MOST = 2, 100  # smallest and largest number of nodes along each side of a patch


class Compliant(Record):
    """Engine ``compliant``: elastic contacts without adhesion, with Coulomb friction without dilatancy.

    The engine finds whether the assembly comes to rest, and the peak load up to which it stays at rest.

    - ``nodes``: the number of contact nodes along each side of a square patch, from 2 to 100. Patches of other shapes
      have about as many nodes in all.
    - ``stiffness_ratio``: tangential over normal stiffness, greater than 0.
    - ``stiffness`` [N/m³]: the normal stiffness per area. None or one number gives all contacts the same stiffness,
      which then does not change any answer. A mapping gives pairs of bodies their own; pairs that are not named have
      stiffness 1. Each name of a pair is that of a body or of a material. The stiffness of two bodies is looked up
      first under both of their names, then under the name of one and the material of the other, then under both
      materials, as in the friction table.

    Options out of range raise HoldfastError. ``prepare`` raises SceneError if ``stiffness`` names something that is
    neither a body nor a material of the assembly; bodies that do not touch may be named.

    For example:

    >>> cube = hf.shipped_scene("cube")  # 1 kg, friction 0.6: it slips at 5.886 N
    >>> push = ("cube", (-0.05, 0, 0.05), (1, 0, 0))
    >>> print(f"{hf.robustness(cube, *push, engine=hf.Compliant(nodes=10)).force[0]:.3f} N")
    5.886 N
    """

    nodes: int = 7
    stiffness_ratio: float = 1.0
    stiffness: Stiffness = None

    name = NAME
    claim = CLAIM

    @property
    def takes_trees(self) -> bool:
        """Whether trees may answer in its place: not where some contacts are stiffer than others."""
        return not isinstance(self.stiffness, Mapping)

    def __post_init__(self) -> None:
        checked_whole(self.nodes, "Compliant: nodes", FEWEST, MOST)
        checked_number(self.stiffness_ratio, "Compliant: stiffness_ratio", above=0, within=STIFFNESS)
        if isinstance(self.stiffness, Mapping):
            known: Stiffness = checked_pairs(self.stiffness, WHAT, WHAT, above=0, within=STIFFNESS)
            object.__setattr__(self, "stiffness", known)
        elif self.stiffness is not None:
            object.__setattr__(self, "stiffness", checked_number(self.stiffness, WHAT, above=0, within=STIFFNESS))

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> CompliantState:
        """Find the state of rest, at which all load paths start.

        The arguments are those of ``Engine.prepare``. The state later re-solves answers for which its nodes are
        too coarse, on finer grids. Raises SceneError for an unknown name in the engine's own ``stiffness``.
        """
        return prepared_on(assembly, self.springs, standing, acceleration)

    def firm(self, assembly: Assembly, wrench: Float) -> tuple[Bool, Verdict]:
        """Tell which bodies rest as trees; see ``Judging.firm``."""
        check_stiffness(assembly, self.stiffness)
        rests = np.zeros(len(assembly.movable), dtype=bool)
        if self.takes_trees:
            rests = forest_of(assembly, wrench).decided
        return rests, FIRM

    def on(
        self, assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None, *, refinements: int = 0
    ) -> CompliantState:
        """Find the state of rest under ``wrench`` (6J,) [N, N m], on the given ``nodes`` or, if None, on a grid.

        Answers for which the nodes are too coarse are re-solved on finer grids, at most ``refinements`` times, and so
        is a state of rest near its limit (rest_verdict.py).
        """
        return state_on(assembly, wrench, self.springs, nodes, refinements=refinements)

    @property
    def springs(self) -> Springs:
        """The springs of ideal faces."""
        return Springs(self.nodes, self.stiffness_ratio, self.stiffness)


def prepared_on(
    assembly: Assembly, springs: Springs, standing: Float | None, acceleration: Float | None
) -> CompliantState:
    """Find the state of rest on ``springs``; the other arguments and errors are those of ``Compliant.prepare``."""
    check_stiffness(assembly, springs.stiffness)
    wrench = assembly.weight_wrench(acceleration)
    wrench = wrench if standing is None else wrench + standing
    return state_on(assembly, wrench, springs, refinements=REFINEMENTS)


def state_on(
    assembly: Assembly, wrench: Float, springs: Springs, nodes: ContactNodes | None = None, *, refinements: int = 0
) -> CompliantState:
    """Find the state of rest on ``springs``; the other arguments are those of ``Compliant.on``."""
    if not assembly.movable or assembly.hanging:
        return Unpushable(find_rest(assembly, wrench).verdict.after("chains of contacts to fixed bodies"))
    grid = Grid.of(assembly, wrench, springs, nodes)
    rest = at_rest(grid)
    if rest is None and grid.settled.outcome is not RestOutcome.LOST:
        return Unpushable(not_at_rest(grid).after(_grid_in_words(grid)))
    resting = rest or at_rest(grid.with_hold)
    if resting is None:
        return Unpushable(not_at_rest(grid).after(_grid_in_words(grid)))
    doubtful = resting.unstiff.any() or resting.on_an_edge.any()
    neutral = neutral_at(assembly, wrench) if doubtful else None
    held = resting.unstiff if neutral is None else resting.unstiff | neutral.bodies
    if rest is not None and not held.any():
        return _standing(rest.verdict.after(_grid_in_words(grid)), grid, refinements)
    names = () if neutral is None else neutral.named(assembly)
    found = "they come to rest" if rest is not None else _HELD
    said = resting.verdict.reason + balanced_in_verdict(names)
    verdict = replace(resting.verdict, reason=said, balanced=names).after(_grid_in_words(grid), found)
    certain = find_rest(assembly, wrench).verdict
    if certain.status is Status.UNSTABLE:  # the balance holds to within a tolerance only, and the proof is exact
        return Unpushable(certain.after(_LIMIT, before=verdict))
    verdict = verdict.after(_LIMIT, certain.reason)
    # without a hold some motions have no stiffness, and no path begins; what is said of others must not hang on it
    for bodies in (held, np.ones_like(held)):
        holding = grid.with_hold if bodies.all() else grid.holding(bodies)
        rests = holding.settled.outcome is RestOutcome.RESTS if rest is not None else at_rest(holding) is not None
        if rests:
            return _standing(verdict, holding, refinements, neutral)
    return Unpushable(verdict)


_HELD = "they come to rest only if faint springs keep every body in its place"
_LIMIT = "limit analysis, as some motions meet no resistance"


def _grid_in_words(grid: Grid) -> str:
    """What is looked at on a grid, in words."""
    given = grid.places.given is not None
    return "elastic contacts on " + ("the nodes given" if given else f"{grid.springs.nodes} nodes a side")


def _standing(verdict: Verdict, grid: Grid, refinements: int, neutral: Neutral | None = None) -> CompliantState:
    """Return the state of an assembly that rests on ``grid``, unless that leans on the number of nodes."""
    looks = "less friction, and more nodes where it is near its limit"
    other = overruled(grid, refinements)
    if other is not None:
        return Unpushable(other.after(looks, before=verdict))
    if refinements and grid.springs.faces is None:
        verdict = verdict.after(looks, "rest does not lean on how many nodes there are")
    return RestingState(verdict, Refined(grid, refinements), neutral)


@dataclass(frozen=True, eq=False)
class Rough:
    """The engine on the ``faces`` of one sample: bodies first come to rest on high spots, where load paths begin.

    The stiffness of the faces is multiplied by that which the engine has for pairs of bodies or materials.
    """

    engine: Compliant
    faces: RandomFaces

    name = NAME
    claim = CLAIM

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> CompliantState:
        """Find the state of rest on these faces; the arguments and errors are those of ``Compliant.prepare``."""
        return prepared_on(assembly, replace(self.engine.springs, faces=self.faces), standing, acceleration)
