"""Engine ``graph``: R = min(R_slip, R_top) (eq. 13), by slip.py and topple.py on the graph of cuts.py.

Names are those of the paper. Its Algorithm 2 is a search by simulation (bench/baselines/search.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import contact_nodes
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.arrays import Bool, Float, Int, checked_number, checked_truth, checked_whole
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Record
from holdfast.base.ranges import MANY, MOST_SEED
from holdfast.base.text import listed
from holdfast.contacts.patch_nodes import Sampling
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import EXACT, Accuracy
from holdfast.engines.graph.cuts import InterfaceGraph
from holdfast.engines.graph.slip import Slipping
from holdfast.engines.graph.topple import Toppling
from holdfast.engines.mechanism import NAMED, Kinematics, Mechanism, describe, modes_of, relative_velocity
from holdfast.engines.rest import Rest, find_rest
from holdfast.engines.verdict import Status, Verdict


class Graph(Record):
    """Engine ``graph``: the method of Nadeau & Kelly, R = min(R_slip, R_top) (eq. 13), with its options.

    The contact forces at rest are computed first, then how much each contact can still carry. Answers are estimates:
    they are neither lower nor upper bounds of the true force.

    - ``nodes``: the number of contact nodes of each interface.
    - ``sampling``: how nodes are placed. "hull" takes corners first, then the farthest points; "quadrature" takes a
      grid; "paper" takes the random points of the paper, drawn from ``seed``.
    - ``isolated``: if True, every body is judged alone, with its neighbours taken as fixed (the approximation that the
      paper cites as [16]).
    - ``immobile_above`` [kg]: heavier bodies count as fixed in the graph, but their weight still acts (Sec. VIII-C).
      None means that no body does.
    - ``mass_margin``: the share in [0, 1) by which all masses are reduced (Sec. VIII-C). It reduces every answer by the
      same share if there are no standing loads.
    - ``max_cuts``: the largest number of feasible cuts; more raise SolverError.

    Options out of range raise HoldfastError.

    For example:

    >>> cube = hf.shipped_scene("cube")  # 1 kg, friction 0.6: it slips at 5.886 N
    >>> push = ("cube", (-0.05, 0, 0.05), (1, 0, 0))
    >>> print(f"{hf.robustness(cube, *push, engine=hf.Graph(nodes=8)).force[0]:.3f} N")
    5.886 N
    """

    nodes: int = 20
    isolated: bool = False
    sampling: Sampling = "hull"
    immobile_above: float | None = None
    mass_margin: float = 0.0
    max_cuts: int = 20_000
    seed: int = 0

    name = "graph"
    claim = Claim.ESTIMATED

    def __post_init__(self) -> None:
        checked_truth(self.isolated, "Graph: isolated")
        margin = checked_number(self.mass_margin, "Graph: mass_margin", minimum=0)
        if margin >= 1:
            raise HoldfastError(message("Graph", f"mass_margin = {margin:g}", "needs 0 <= mass_margin < 1"))
        if self.immobile_above is not None:
            checked_number(self.immobile_above, "Graph: immobile_above", above=0)
        checked_whole(self.nodes, "Graph: nodes", 1, 10_000)
        checked_whole(self.max_cuts, "Graph: max_cuts", 1, MANY)
        checked_whole(self.seed, "Graph: seed", 0, MOST_SEED)

    def prepare(
        self, assembly: Assembly, standing: Float | None = None, acceleration: Float | None = None
    ) -> GraphState:
        """Compute the contact forces at rest; cuts and toppling axes are computed when a query needs them.

        The arguments are those of ``Engine.prepare``.
        """
        refuse_joined(assembly, "engine graph", "use engine='limit' or engine='compliant'")
        wrench = (1 - self.mass_margin) * assembly.weight_wrench(acceleration)
        if standing is not None:
            wrench = wrench + standing
        nodes = contact_nodes(assembly, self.nodes, self.sampling, self.seed)
        return GraphState(self, assembly, find_rest(assembly, wrench, nodes))


@dataclass(frozen=True, eq=False)
class GraphState:
    """Engine ``graph`` prepared for one assembly, with its contact forces at rest."""

    engine: Graph
    assembly: Assembly
    rest: Rest

    def verdict(self) -> Verdict:
        """Say whether the assembly stands: it is stable if the force program has a solution (Sec. IV)."""
        return self.rest.verdict

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """The simplifications that the answers rest on, in plain words."""
        notes = []
        if self.engine.isolated:
            notes.append("every body judged alone, its neighbours taken as fixed: optimistic")
        if self._immobile.any():
            names = [body.name for body, still in zip(self.assembly.movable, self._immobile, strict=True) if still]
            notes.append(
                f"taken as immobile (above {self.engine.immobile_above:g} kg): {listed(names, NAMED)}: optimistic"
            )
        if self.engine.mass_margin:
            notes.append(f"all masses taken {self.engine.mass_margin:.0%} smaller")
        return tuple(notes)

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Find the largest factor of each load column of W (6J, n), without bounds.

        The slip rule needs all forces of one column to have the same direction; other columns raise HoldfastError.
        ``accuracy`` is ignored: every load is solved on its own, which does not take long.
        """
        count = W.shape[1]
        verdict = self.rest.verdict
        known: dict[str, Any] = {
            "engine": self.engine.name,
            "claim": self.engine.claim,
            "verdict": verdict,
            "notes": self.notes,
        }
        if verdict.status is not Status.STABLE:
            return Answers.not_standing(count, **known)
        wrenches = W.T.reshape(count, len(self.assembly.movable), 6)
        R_slip, side = self._slipping.robustness(wrenches)
        R_top, which = self.toppling.robustness(wrenches)
        R = np.minimum(R_slip, R_top)  # (13)
        finite = np.flatnonzero(np.isfinite(R))
        mechanisms, status = list[Mechanism | None]([None] * count), [Status.INFINITE] * count
        causes = self._causes(wrenches[finite], (R_slip <= R_top)[finite], side[finite], which[finite])
        for k, mechanism in zip(finite.tolist(), causes, strict=True):
            mechanisms[k], status[k] = mechanism, Status.FINITE
        return Answers.of(force=R, status=status, mechanism=mechanisms, **known)

    @cached_property
    def kinematics(self) -> Kinematics:
        """The bodies and contact nodes that all mechanisms of this state share."""
        return Kinematics.of(self.assembly, self.rest.nodes)

    @cached_property
    def _immobile(self) -> Bool:
        limit = self.engine.immobile_above
        return np.asarray(self.assembly.mass > (np.inf if limit is None else limit))

    @cached_property
    def _graph(self) -> InterfaceGraph:
        """The contact interface graph G."""
        engine, rest = self.engine, self.rest
        return InterfaceGraph(self.assembly, rest.nodes, rest.forces, self._immobile, engine.isolated, engine.max_cuts)

    @cached_property
    def _slipping(self) -> Slipping:
        return Slipping(self._graph)

    @cached_property
    def toppling(self) -> Toppling:
        """What turns of feasible cuts take."""
        return Toppling(self._graph)

    def turning(self, twists: Float) -> Mechanism:
        """Return the mechanism in which a cut turns with these ``twists`` (J, 6)."""
        velocity = relative_velocity(self.rest.nodes, self.assembly.com, twists)
        mode = modes_of(self.assembly, self.rest.nodes, twists[None], velocity[None], dual=False)[0]
        return describe(self.kinematics, twists, mode, dual=False)

    def _causes(self, wrenches: Float, slips: Bool, side: Bool, which: Int) -> Iterator[Mechanism]:
        """Yield the mechanism that limits each of the wrenches (n, J, 6). Those that are the same share one object.

        A column ``slips`` (n,), and then the bodies ``side`` (n, J) slide; or the cut and axis ``which`` (n, 2) turn.
        """
        known: dict[object, Mechanism] = {}
        for wrench, slip, sliding, (number, axis) in zip(wrenches, slips, side, which.tolist(), strict=True):
            key: object = (number, axis)
            if slip:
                force = wrench[:, :3].sum(0)
                direction = force / np.linalg.norm(force)
                key = (sliding.tobytes(), tuple(np.round(direction, 9)))
            if key not in known and slip:
                twists = np.zeros((len(sliding), 6))
                twists[sliding, :3] = direction
                known[key] = describe(self.kinematics, twists, "slip", dual=False)
            elif key not in known:
                known[key] = self.turning(self.toppling.twists(number, axis))
            yield known[key]
