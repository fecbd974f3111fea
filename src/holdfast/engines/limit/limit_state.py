"""The state of engine ``limit``: max s such that G f + w_g + s w_e = 0, f in the friction cones, one solve a load.

For the dual motion y of a load w, with y·w = 1,

    R = -y·w_g,   u = Gᵀy in the dual cones,   f·u = 0 at the optimum.

Where f and y are unique, the derivative of R is that of the Lagrangian with f and y held (envelope theorem).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from threading import Lock
from typing import Any

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.assembly.strengths import with_pull
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.conic.solve import Outcome
from holdfast.engines.answers import Answers, Bound, Claim, balanced_in_verdict, joined, only_balanced
from holdfast.engines.contract import EXACT, Accuracy, Gradient, LoadHull, LoadSet, Within
from holdfast.engines.forces import EXACT as EXACT_CONE
from holdfast.engines.forces import FrictionCone
from holdfast.engines.limit.balance import DOWN, UP
from holdfast.engines.limit.carrying_proof import proved_rest
from holdfast.engines.limit.certified import FLAT_GROUP, CuttingPlanes, by_body, certify
from holdfast.engines.limit.load_sets import LoadFamily, find_hull, find_set
from holdfast.engines.limit.proof import SOLVED, TOLERANCE, LoadLimit, LoadProgram, LoadProofs
from holdfast.engines.mechanism import Kinematics, Mechanism, describe_all, modes_of, relative_velocity
from holdfast.engines.rest import Rest, corner_nodes, find_rest, undecided
from holdfast.engines.verdict import Status, Verdict

# Tolerance of the solver for derivatives: forces and motions are less accurate than factors
SHARP = TOLERANCE / 10_000
NAME, CLAIM = "limit", Claim.EXISTS
UNPROVED = (
    "lower is an estimate: no contact forces inside all friction cones were found, or there are too many to prove it"
)


@dataclass(frozen=True, eq=False)
class LimitState:
    """Limit analysis over a friction ``cone`` with one program, set up once, for all loads of an assembly.

    ``wrench`` (6J,) is that of weights, standing loads and the pull of tension.

    Several threads may ask one state. Exact answers are the same as from one thread; those ``Within`` a gap depend on
    what was asked before, because bounds draw on all earlier solves, and such calls wait for each other.

    Inside, the F fasteners of holds (hold_nodes.py) stand after the J bodies: ``wrench`` is (6(J + F),), and all that
    is called (6J,) in what this state is made of has as many rows.
    """

    cone: FrictionCone
    assembly: Assembly
    wrench: Float
    rest: Rest
    _certifying: Lock = field(default_factory=Lock, init=False, repr=False)

    def verdict(self) -> Verdict:
        """Whether an equilibrium exists, whether it comes about, and which bodies are only balanced in any."""
        verdict, names = self.rest.verdict, self._only_balanced
        if not names:
            return verdict
        return replace(verdict, reason=verdict.reason + balanced_in_verdict(names), balanced=names)

    @property
    def notes(self) -> tuple[str, ...]:
        """Which polygon stands for the cone, if one does."""
        if self.cone.kind == "exact":
            return ()
        errs = "cautious" if self.cone.kind == "inscribed" else "optimistic"
        return (f"friction cone replaced by an {self.cone.kind} polygon of {self.cone.sides} sides: {errs}",)

    def fresh(self) -> LimitState:
        """The same state, its program set up once for both, with no bounds from earlier solves."""
        other = LimitState(self.cone, self.assembly, self.wrench, self.rest)
        other.__dict__["proofs"] = self.proofs
        return other

    def load_factor(self, W: Float, accuracy: Accuracy = EXACT) -> Answers:
        """Factors for load columns W (6J, n), each by a solve of its own.

        ``Within`` an error, columns that load a single body each are bounded within (upper - lower) / upper <= gap from
        few solves (certified.py); their factor is then the lower bound. Bounds take no further work: ``ForcesOnly`` has
        them, too.

        With the exact cone ``upper`` is proved: gravity over load power of a motion that was mended so that no contact
        force gains on it, and infinite where that is not possible. ``lower`` is proved by contact forces that balance
        exactly (carrying_proof.py), as if bodies that are only balanced stayed so; where such forces are not found, it
        is an estimate, and ``lower_bound`` says so. An inscribed polygon gives no upper bound of the true cone, a
        circumscribed one no lower bound.
        """
        count = W.shape[1]
        if not self.rest.verdict.equilibrium_exists:
            # that nothing balances the weights is proved by the motion with which they fall
            mechanism = self.rest.verdict.mechanism
            falls = self.rest.verdict.status is Status.UNSTABLE and mechanism is not None
            motion = self.rest.fall if mechanism is None or self.rest.fall is not None else mechanism.twists.ravel()
            proved = motion is None or not falls or self.proofs.repair.gaining(motion) is not None
            return Answers.not_standing(count, **self._known(lower=True, upper=proved))
        W = self.rest.nodes.beside(W)
        if not isinstance(accuracy, Within) or not (groups := by_body(W, FLAT_GROUP)):
            return self._table_of(self.proofs.limits(W))
        order = [columns for _, columns in groups]
        parts = [self._within_accuracy(W[:, columns], 6 * body, accuracy.relative) for body, columns in groups]
        alone = np.setdiff1d(np.arange(count), np.concatenate(order))
        if len(alone):
            order.append(alone)
            parts.append(self._table_of(self.proofs.limits(W[:, alone])))
        return joined(parts).rows(np.argsort(np.concatenate(order)))

    def _known(self, *, lower: bool, upper: bool = True) -> dict[str, Any]:
        """What all answers of this state have in common; ``lower`` and ``upper`` say whether those are proved."""
        known = {True: Bound.PROVED, False: Bound.ESTIMATED}
        taken = (
            (only_balanced(self._only_balanced),) if self._only_balanced else ()
        )  # proofs of lower take for granted that they stay
        return {
            "engine": NAME,
            "claim": CLAIM,
            "verdict": self.rest.verdict,
            "lower_bound": Bound.NONE if self.cone.kind == "circumscribed" else known[lower],
            "upper_bound": Bound.NONE if self.cone.kind == "inscribed" else known[upper],
            "notes": (*self.notes, *taken) if lower else (*self.notes, UNPROVED),
        }

    @cached_property
    def _only_balanced(self) -> tuple[str, ...]:
        """The names of the bodies that are only balanced in any equilibrium."""
        if not self.rest.verdict.equilibrium_exists:  # nothing is proved to be carried
            return ()
        loose = self.proofs.loose[: len(self.assembly.movable)]
        return tuple(body.name for body, one in zip(self.assembly.movable, loose, strict=True) if one)

    def _within_accuracy(self, W: Float, first: int, accuracy: float) -> Answers:
        """Return answers within an ``accuracy`` for columns of W that load one body, whose rows begin at ``first``."""
        with self._certifying:
            slope = self.proofs.slope[first : first + 6]
            bounds = certify(W, first, self.proofs.limits, self.planes, accuracy, self.assembly.size / 4, slope)
        with np.errstate(divide="ignore"):
            lower, upper = 1 / bounds.high * DOWN, 1 / bounds.low * UP
        endless = (bounds.endless | (bounds.high == 0)) & ~bounds.undecided  # what endless loads make up has no end
        finite = ~endless & ~bounds.undecided
        kinds = np.array([Status.INFINITE, Status.FINITE, Status.UNDECIDED], dtype=object)
        status = kinds[np.where(bounds.undecided, 2, finite.astype(int))]
        force = np.where(endless, np.inf, lower)
        used = np.unique(bounds.plane[finite & (bounds.plane >= 0)])
        rows = np.array([self.planes.motions[k] for k in used]).reshape(len(used), len(W))
        known = dict(zip((int(k) for k in used), self.mechanisms(rows), strict=True))
        mechanisms = [known.get(int(k)) if f else None for k, f in zip(bounds.plane, finite, strict=True)]
        return Answers.of(
            force=force,
            lower=lower,
            upper=upper,
            status=status.tolist(),
            mechanism=mechanisms,
            **self._known(lower=self.planes.certain),
        )

    def _table_of(self, answers: list[LoadLimit]) -> Answers:
        """Return the table of solved loads."""
        mechanisms: list[Mechanism | None] = [None] * len(answers)
        finite = [k for k, answer in enumerate(answers) if answer.twists is not None]
        twists = np.array([answers[k].twists for k in finite]).reshape(len(finite), len(self.wrench))
        for k, mechanism in zip(finite, self.mechanisms(twists), strict=True):
            mechanisms[k] = mechanism
        factor, lower, upper = np.array([(a.factor, a.lower, a.upper) for a in answers]).reshape(-1, 3).T
        status = [a.status for a in answers]
        known = self._known(lower=all(a.certain for a in answers))
        return Answers.of(force=factor, lower=lower, upper=upper, status=status, mechanism=mechanisms, **known)

    def mechanisms(self, twists: Float) -> list[Mechanism]:
        """The collapse mechanisms of dual twists (k, 6(J + F))."""
        nodes = self.rest.nodes.contacts
        velocities = (self.proofs.equilibrium.gather @ twists.T).T.reshape(len(twists), len(self.rest.nodes), 3)
        twists = self.rest.nodes.moving(twists[:, : 6 * len(self.assembly.movable)])
        modes = modes_of(self.assembly, nodes, twists, velocities[:, : len(nodes)], dual=True)
        return describe_all(self.kinematics, twists, modes, dual=True)

    def solve(self, load: Float) -> LoadLimit:
        """The largest factor of one load (6J,)."""
        return self.proofs.limits(self.rest.nodes.beside(load[:, None]))[0]

    def gradient(self, load: Float, where: str) -> Gradient:
        """Derivatives of the largest factor of one load (6J,), all from one solve."""
        whole = self.rest.nodes.beside(load)
        found = self._sharp.maximise(whole) if load.any() else None
        limit = self.solve(load) if found is None else self.proofs.judged([found], whole[:, None])[0]
        if found is None or limit.twists is None:
            remedy = "there are derivatives only where a finite push moves something"
            raise HoldfastError(message(where, f"the push is {limit.status}", remedy))
        assembly, nodes = self.assembly, self.rest.nodes.contacts
        motion = self.rest.nodes.moving(limit.twists[: len(load)]).reshape(-1, 6)
        forces = found.forces.reshape(-1, 3)[: len(nodes)]
        # |u_t|, the multiplier of the friction limit of a node, times f_n, for every pair of bodies
        slip = np.linalg.norm(relative_velocity(nodes, assembly.com, motion)[:, 1:], axis=1)
        d_mu = dict.fromkeys((interface.bodies for interface in assembly.interfaces), 0.0)
        for k, share in zip(nodes.interface, slip * np.maximum(forces[:, 0], 0), strict=True):
            d_mu[assembly.interfaces[k].bodies] += float(share)
        return Gradient(
            answers=self._table_of([limit]),
            assembly=assembly,
            nodes=nodes,
            forces=nodes.world(forces),
            twists=motion,
            d_mu=d_mu,
            d_mass=-motion[:, :3] @ assembly.scene.gravity,
            d_com=-np.cross(assembly.mass[:, None] * assembly.scene.gravity, motion[:, 3:]),
        )

    def load_set(self, columns: Float, accuracy: float, solves: int | None, where: str) -> LoadSet:
        """The x (d,) in the box |x_k| <= 1 for which ``columns`` @ x is carried, between two polyhedra."""
        return find_set(self._family(columns, where), accuracy, solves)

    def load_hull(self, columns: Float, near: Float, accuracy: float, solves: int, where: str) -> LoadHull:
        """Points of the set of x (d,) for which ``columns`` @ x is carried, whose hull is close to it for most."""
        return find_hull(self._family(columns, where), near, accuracy, solves)

    def _family(self, columns: Float, where: str) -> LoadFamily:
        return LoadFamily(where, self.proofs, self.rest.nodes.beside(columns))

    @cached_property
    def planes(self) -> CuttingPlanes:
        """Bounds that solved loads prove for others; asked for by one thread at a time."""
        return CuttingPlanes(self.proofs.program.scales.motion)

    @cached_property
    def proofs(self) -> LoadProofs:
        """The program, and the proofs of bounds."""
        return LoadProofs(self.assembly, self.rest, self.wrench, self.cone)

    @cached_property
    def _sharp(self) -> LoadProgram:
        """The program to a tolerance at which forces and motions are as accurate as factors usually are."""
        return replace(self.proofs.program, tolerance=SHARP)

    @cached_property
    def kinematics(self) -> Kinematics:
        """What all mechanisms of this state share."""
        return Kinematics.of(self.assembly, self.rest.nodes)


def balanced_under(
    assembly: Assembly, wrench: Float, nodes: ContactNodes | None = None, cone: FrictionCone = EXACT_CONE
) -> LimitState:
    """Return the state under ``wrench`` (6J,) [N, N m], whose verdict says whether an equilibrium exists, no more.

    If ``nodes`` is None, they are all corners of all patches.
    """
    found = find_rest(assembly, wrench, nodes, cone)
    whole = found.nodes.under(with_pull(assembly, wrench))
    return LimitState(cone, assembly, whole, proved_rest(assembly, found, whole, cone))


def factors_on(assembly: Assembly, wrench: Float, loads: Float) -> Float:
    """Return the largest factors (n,) of loads (6J, n) on an assembly under ``wrench`` (6J,), without any proof.

    They are inf for loads that move nothing, and 0 where nothing is known to balance the wrench.
    """
    nodes = corner_nodes(assembly)
    rest = Rest(nodes, np.zeros((len(nodes), 3)), undecided("not asked"))  # a stand-in: no proof is asked for
    program = replace(LoadProofs(assembly, rest, wrench, EXACT_CONE).program, tolerance=SHARP)
    found = [program.maximise(loads[:, k]) for k in range(loads.shape[1])]
    return np.array(
        [one.factor if one.outcome in SOLVED else np.inf if one.outcome is Outcome.UNBOUNDED else 0.0 for one in found]
    )
