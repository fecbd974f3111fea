"""Engine ``compliant``: the peak of the load path on elastic contacts with Coulomb friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.archive import archived
from holdfast.base.arrays import Float, checked_number
from holdfast.base.errors import HoldfastError, message
from holdfast.base.values import Value
from holdfast.elastic.outcome import RestOutcome
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.compliant.model import Springs, Stiffness
from holdfast.engines.compliant.refinement import REFINEMENTS, Refined
from holdfast.engines.compliant.state import CLAIM, NAME, CompliantState, Standing, Unpushable
from holdfast.engines.compliant.verdict import judged
from holdfast.engines.rest import find_rest
from holdfast.engines.verdict import Status

FEWEST = 2  # nodes along a side


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Compliant(Value):
    """Elastic contacts without adhesion, Coulomb friction without dilatancy: what comes to rest, and up to which load.

    ``nodes`` along each side of a square patch (others have as many in all); ``stiffness_ratio`` tangential over normal
    stiffness; ``stiffness`` [N/m³] per area: None or a number for equal contacts (it drops out), or one for each pair
    of names, where pairs that are not named have 1.
    """

    nodes: int = 7
    stiffness_ratio: float = 1.0
    stiffness: Stiffness = None

    name = NAME
    claim = CLAIM

    def __post_init__(self) -> None:
        if not isinstance(self.nodes, int | np.integer) or self.nodes < FEWEST:
            problem = f"nodes = {self.nodes!r}"
            raise HoldfastError(message("Compliant", problem, f"needs a whole number of at least {FEWEST}"))
        checked_number(self.stiffness_ratio, "Compliant: stiffness_ratio", above=0)
        named = self.stiffness if hasattr(self.stiffness, "values") else {("", ""): self.stiffness or 1.0}
        for pair, value in named.items():  # type: ignore[union-attr]
            checked_number(value, f"Compliant: stiffness of {pair}" if pair[0] else "Compliant: stiffness", above=0)

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> CompliantState:
        """Let the assembly come to rest: all load paths start there."""
        wrench = assembly.weight_wrench(acceleration)
        wrench = wrench if standing is None else wrench + standing
        return self.on(assembly, wrench, refinements=REFINEMENTS)

    def on(
        self, assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None, *, refinements: int = 0
    ) -> CompliantState:
        """The state under ``wrench`` (6J,) [N, N m], on ``nodes`` of one's own choice if given.

        Answers for which these are too coarse are re-solved on finer grids, at most ``refinements`` times.
        """
        if not assembly.movable or assembly.hanging:
            return Unpushable(find_rest(assembly, wrench).verdict)
        grid = Grid.of(assembly, wrench, Springs(self.nodes, self.stiffness_ratio, self.stiffness), nodes)
        verdict = judged(assembly, grid.nodes, wrench, grid.system.model, grid.unit, grid.settled)
        if verdict.status is Status.STABLE and grid.settled.outcome is RestOutcome.RESTS:
            return Standing(verdict, Refined(grid, refinements))
        return Unpushable(verdict)
