"""Engine ``compliant``: the peak of the load path on elastic contacts with Coulomb friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float, checked_number, checked_whole
from holdfast.base.public import Record
from holdfast.base.ranges import STIFFNESS
from holdfast.elastic.system import RestOutcome
from holdfast.engines.answers import balanced_in_verdict
from holdfast.engines.compliant.balanced import Neutral, neutral_at
from holdfast.engines.compliant.compliant_state import CLAIM, NAME, CompliantState, RestingState, Unpushable
from holdfast.engines.compliant.elastic_model import WHAT, Springs, Stiffness, check_stiffness
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.refinement import REFINEMENTS, Refined
from holdfast.engines.compliant.rest_verdict import at_rest, not_at_rest, overruled
from holdfast.engines.imperfect import RandomFaces
from holdfast.engines.rest import find_rest
from holdfast.engines.trees.forest import forest_of
from holdfast.engines.trees.tree_state import FIRM
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.friction import checked_pairs

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

        The arguments are those of ``Engine.prepare``. Answers for which the nodes are too coarse are re-solved on finer
        grids. Raises SceneError for an unknown name in ``stiffness``.
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
