"""Engine ``graph``: R = min(R_slip, R_top) (eq. 13)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.arrays import Bool, Float, Int, checked_number, checked_truth, checked_whole
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import report
from holdfast.base.public import Record
from holdfast.base.ranges import MANY, MOST_SEED
from holdfast.base.rigid import cross, rotation_about, shift_twist
from holdfast.base.text import listed
from holdfast.contacts.patch_nodes import Sampling
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.contract import EXACT, Accuracy
from holdfast.engines.graph import topple
from holdfast.engines.graph.cuts import feasible_cuts
from holdfast.engines.mechanism import NAMED, Kinematics, Mechanism, describe, modes_of, relative_velocity
from holdfast.engines.rest import Rest, find_rest
from holdfast.engines.verdict import Status, Verdict
from holdfast.native import core

NO_MOMENT = 1e-5  # smallest lever arm of a load, relative to the assembly's size; poses are not known more accurately


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
class _CutAxes:
    """One feasible cut and the k axes about which it can turn. An axis counts once for each sense of rotation.

    ``members`` are the numbers of its bodies. ``twists`` (k, 6) are the unit-rate rotations of the whole cut, taken at
    the assembly's centre. ``torque`` (k,) [N m] is the torque with which contacts resist each of them.
    """

    members: Int
    twists: Float
    torque: Float


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
        slip, slip_side = self._slip(wrenches)
        top, which = self._topple(wrenches)
        factor = np.minimum(slip, top)
        mechanisms = _Mechanisms(self, wrenches, slip <= top, slip_side, which)
        finite = np.isfinite(factor)
        causes = [mechanisms.of(k) if finite[k] else None for k in range(count)]
        status = [Status.FINITE if f else Status.INFINITE for f in finite]
        return Answers.of(force=factor, status=status, mechanism=causes, **known)

    @cached_property
    def kinematics(self) -> Kinematics:
        """The bodies and contact nodes that all mechanisms of this state share."""
        return Kinematics.of(self.assembly, self.rest.nodes)

    @cached_property
    def _immobile(self) -> Bool:
        limit = self.engine.immobile_above
        return np.asarray(self.assembly.mass > (np.inf if limit is None else limit))

    @cached_property
    def _graph(self) -> tuple[Int, Int]:
        """The node numbers of the first and the second body of each interface.

        Fixed bodies and immobile bodies are node J.
        """
        count = len(self.assembly.movable)
        number = np.where(self._immobile, count, np.arange(count))
        ends = np.array(self.assembly.ends, dtype=np.int64).reshape(-1, 2)
        mapped = np.where(ends == FIXED, count, number[np.maximum(ends, 0)]) if count else ends
        return np.ascontiguousarray(mapped[:, 0]), np.ascontiguousarray(mapped[:, 1])

    @property
    def _nodes(self) -> ContactNodes:
        return self.rest.nodes

    @cached_property
    def _cuts(self) -> list[int]:
        """The feasible cuts, as bit masks over the J movable bodies. Immobile bodies are in none of them."""
        count = len(self.assembly.movable)
        if self.engine.isolated:
            return [1 << k for k in range(count) if not self._immobile[k]]
        mobile = np.flatnonzero(~self._immobile)
        compact = np.full(count + 1, len(mobile))
        compact[mobile] = np.arange(len(mobile))
        tails, heads = self._graph
        edges = [(int(compact[a]), int(compact[b])) for a, b in zip(tails, heads, strict=True)]
        cuts = feasible_cuts(len(mobile) + 1, edges, limit=self.engine.max_cuts)
        if len(mobile) == count:
            return cuts
        return [sum(1 << int(mobile[k]) for k in range(len(mobile)) if cut >> k & 1) for cut in cuts]

    def _slip(self, wrenches: Float) -> tuple[Float, Bool]:
        """Return R_slip (n,) and which bodies slide (n, J), for wrenches (n, J, 6)."""
        forces = wrenches[:, :, :3]
        size = np.linalg.norm(forces, axis=2)
        loaded = size > 0
        total = size.sum(1)
        direction = np.divide(forces.sum(1), total[:, None], out=np.zeros((len(total), 3)), where=total[:, None] > 0)
        if (np.abs(np.linalg.norm(direction, axis=1) - 1)[total > 0] > 1e-9).any():
            problem = "a load combines forces of different directions, for which its slip rule is not defined"
            raise HoldfastError(message("engine graph", problem, "use engine 'limit' or 'compliant' for it"))
        single = (loaded.sum(1) == 1) & (not self.engine.isolated)
        strength = np.full(len(total), np.inf)
        side = np.zeros(loaded.shape, dtype=bool)
        if single.any():
            source = np.argmax(loaded, axis=1)
            strength[single], side[single] = self._flows(source[single], direction[single])
        for k in np.flatnonzero((total > 0) & ~single):
            strength[k], side[k] = self._cut_slip(size[k] / total[k], direction[k])
        return np.divide(strength, total, out=np.full(len(total), np.inf), where=total > 0), side

    def _flows(self, source: Int, direction: Float) -> tuple[Float, Bool]:
        """Return R_slip (n,) and which bodies slide (n, J), for n pushes on one body each.

        Push k acts on body ``source[k]`` along ``direction[k]`` (3,). One maximum flow is computed for each different
        pair of body and direction.
        """
        keys = np.column_stack([source, np.round(direction, 9) + 0.0])
        _, first, back = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        count = len(self.assembly.movable)
        tails, heads = self._graph
        nodes = self._nodes
        side = np.zeros((len(first), count + 1), dtype=bool)
        strength = core.slip_many(
            self.rest.forces, nodes.axes, nodes.mu, nodes.interface, tails, heads, count + 1,
            np.where(self._immobile, count, np.arange(count))[source[first]],
            np.ascontiguousarray(direction[first]), side,
        )  # fmt: skip
        back = back.reshape(-1)
        return np.asarray(strength[back]), np.asarray(side[back, :-1])

    def _cut_slip(self, share: Float, direction: Float) -> tuple[float, Bool]:
        """Return R_slip and which bodies slide (J,) for a load on several bodies along one direction (Algorithm 3).

        It is the smallest value over all cuts of the capacity that leaves the cut over the load inside it. ``share``
        (J,) is the share of the total force that acts on each body.
        """
        nodes = self._nodes
        inside, leaving = self._leaving
        interfaces = len(self.assembly.interfaces)
        capacity = core.arc_capacities(self.rest.forces, nodes.axes, nodes.mu, nodes.interface, interfaces, direction)
        endless = ~np.isfinite(capacity.ravel())
        out = np.where(leaving @ endless > 0, np.inf, leaving @ np.where(endless, 0.0, capacity.ravel()))
        load = inside @ share
        factor = np.divide(out, load, out=np.full(len(load), np.inf), where=load > 0)
        best = int(np.argmin(factor)) if len(factor) else 0
        if not len(factor) or np.isinf(factor[best]):
            return np.inf, np.zeros(len(share), dtype=bool)
        return float(factor[best]), inside[best] > 0

    @cached_property
    def _leaving(self) -> tuple[Float, Float]:
        """The bodies of every cut (cuts, J), and the arcs that leave it (cuts, 2 x interfaces), as 0 and 1."""
        tails, heads = self._graph
        count = len(self.assembly.movable)
        inside = np.array([_bits(mask, count + 1) for mask in self._cuts]).reshape(-1, count + 1)
        a, b = inside[:, tails], inside[:, heads]
        leaving = np.stack([a & ~b, ~a & b], axis=2).reshape(len(inside), -1)
        return inside[:, :-1].astype(float), leaving.astype(float)

    def _topple(self, wrenches: Float) -> tuple[Float, Int]:
        """Return R_top (n,) and the cut and axis that limit it (n, 2), for wrenches (n, J, 6) (eq. 27, Algorithm 1)."""
        count = len(wrenches)
        best = np.full(count, np.inf)
        which = np.full((count, 2), -1)
        scale = np.linalg.norm(wrenches[:, :, :3], axis=2).sum(1) * self.assembly.size
        threshold = NO_MOMENT * (scale + np.linalg.norm(wrenches[:, :, 3:], axis=2).sum(1))
        loaded = (wrenches != 0).any((0, 2))
        central = wrenches.copy()
        central[:, :, 3:] += cross(self.assembly.com - self._centre, wrenches[:, :, :3])
        for number, cut in enumerate(self._cut_axes):
            members = cut.members[loaded[cut.members]]
            if not len(cut.torque) or not len(members):
                continue
            power = cut.twists @ central[:, members].sum(1).T
            factor = np.divide(cut.torque[:, None], power, out=np.full(power.shape, np.inf), where=power > threshold)
            axis = np.argmin(factor, axis=0)
            lowest = factor[axis, np.arange(count)]
            better = lowest < best
            best[better] = lowest[better]
            which[better, 0], which[better, 1] = number, axis[better]
        return best, which

    @cached_property
    def _centre(self) -> Float:
        """The reference point (3,) [m] of the twists of all cuts, in the world frame."""
        return np.asarray(self.assembly.com.mean(0)) if len(self.assembly.com) else np.zeros(3)

    @cached_property
    def _cut_axes(self) -> list[_CutAxes]:
        cuts = self._cuts
        result = []
        for number, mask in enumerate(cuts):
            result.append(self._axes_of(mask))
            if number % 50 == 0:
                report("toppling axes of all cuts", number, len(cuts))
        report("toppling axes of all cuts", len(cuts), len(cuts))
        return result

    @cached_property
    def _corners(self) -> tuple[Float, ...]:
        """The hull corners of each interface's patches: toppling axes run along polygon edges, not between nodes."""
        return tuple(np.vstack([patch.hull for patch in i.patches]) for i in self.assembly.interfaces)

    def _axes_of(self, mask: int) -> _CutAxes:
        assembly, nodes = self.assembly, self._nodes
        inside = np.append(_bits(mask, len(assembly.movable)), False)
        tails, heads = self._graph
        severed = inside[tails] != inside[heads]
        members = np.flatnonzero(inside[:-1])
        spans = nodes.spans
        cut = np.concatenate([np.arange(spans[i], spans[i + 1]) for i in np.flatnonzero(severed)])
        corners = np.vstack([self._corners[i] for i in np.flatnonzero(severed)])
        size = float(np.linalg.norm(np.ptp(corners, axis=0)))
        origins, axes = topple.toppling_axes(corners, size)
        flat = np.zeros(len(axes), dtype=bool)
        points, forces = nodes.points[cut], self.rest.forces[cut]
        if topple.all_parallel(nodes.normals[cut], assembly.tolerances.angle):
            centre, axis = topple.friction_axis(points, nodes.normals[cut], nodes.mu[cut], forces[:, 0])
            origins, axes, flat = np.vstack([origins, centre]), np.vstack([axes, axis]), np.append(flat, True)
        moving_is_a = inside[tails][nodes.interface[cut]]
        torque = core.axis_torques(
            origins, axes, flat, points, np.ascontiguousarray(nodes.axes[cut]), forces, nodes.mu[cut], moving_is_a, size
        )
        free = np.flatnonzero(np.isfinite(torque))  # nodes that all lie on the axis neither slide nor open, nor resist
        senses = np.where(free % 2 == 0, 1.0, -1.0)[:, None] * axes[free // 2]
        twists = rotation_about(senses, origins[free // 2], self._centre)
        return _CutAxes(members, twists, torque[free])

    def turning(self, cut: _CutAxes, axis: int) -> Mechanism:
        """Return the mechanism in which a cut turns about one of its axes."""
        assembly, nodes = self.assembly, self._nodes
        twists = np.zeros((len(assembly.movable), 6))
        for body in cut.members:
            twists[body] = shift_twist(cut.twists[axis], self._centre, assembly.com[body])
        velocity = relative_velocity(nodes, assembly.com, twists)
        mode = modes_of(assembly, nodes, twists[None], velocity[None], dual=False)[0]
        return describe(self.kinematics, twists, mode, dual=False)


class _Mechanisms:
    """The mechanisms that limit load columns. Columns with the same mechanism share one object."""

    def __init__(self, state: GraphState, wrenches: Float, slips: Bool, side: Bool, which: Int) -> None:
        self._state, self._wrenches, self._slips, self._side, self._which = state, wrenches, slips, side, which
        self._known: dict[object, Mechanism] = {}

    def of(self, column: int) -> Mechanism:
        """Return the mechanism that limits one column."""
        if self._slips[column]:
            force = self._wrenches[column, :, :3].sum(0)
            direction = force / np.linalg.norm(force)
            key: object = (self._side[column].tobytes(), tuple(np.round(direction, 9)))
        else:
            key = tuple(self._which[column])
        if key not in self._known:
            self._known[key] = self._sliding(column, direction) if self._slips[column] else self._turning(column)
        return self._known[key]

    def _sliding(self, column: int, direction: Float) -> Mechanism:
        twists = np.zeros((len(self._state.assembly.movable), 6))
        twists[self._side[column], :3] = direction
        return describe(self._state.kinematics, twists, "slip", dual=False)

    def _turning(self, column: int) -> Mechanism:
        number, axis = self._which[column]
        return self._state.turning(self._state._cut_axes[number], axis)


def _bits(mask: int, count: int) -> Bool:
    return np.array([mask >> k & 1 for k in range(count)], dtype=bool)
