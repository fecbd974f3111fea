"""What the groups of an assembly say as one: the worst verdict with the evidence of all, the smallest of the answers.

Forces that rounding alone tells from none are none: the body is only balanced.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float, Int, Objects
from holdfast.base.text import listed
from holdfast.engines.answers import (
    ONLY_BALANCED,
    Answers,
    balanced_in_verdict,
    joined_notes,
    only_balanced,
    weakest_bound,
)
from holdfast.engines.contract import Engine
from holdfast.engines.mechanism import Kinematics, Mechanism
from holdfast.engines.verdict import Certificate, ContactForces, GroupVerdict, Status, Verdict

WORST_FIRST = (Status.UNSTABLE, Status.UNDECIDED, Status.STABLE)


def joint(groups: Sequence[GroupVerdict]) -> Verdict:
    """Join the verdicts on some groups: the worst status, the reasons that lead to it and the evidence of all groups.

    An empty sequence gives STABLE: nothing is there that could move.
    """
    verdicts = [group.verdict for group in groups]
    if len(verdicts) == 1:
        return verdicts[0]
    status = min((v.status for v in verdicts), key=WORST_FIRST.index, default=Status.STABLE)
    exists = [v.equilibrium_exists for v in verdicts]
    found = Verdict(
        status=status,
        reason=_reason(groups, status),
        equilibrium_exists=False if False in exists else None if None in exists else True,
        mechanism=_all_motions([v.mechanism for v in verdicts if v.status is status]),
        certificate=_all_proofs([v.certificate for v in verdicts if v.status is status]),
        balanced=tuple(name for v in verdicts for name in v.balanced),
    )
    return found.with_evidence(
        lambda: _all_forces([v.forces for v in verdicts]),
        lambda: max((v.residual for v in verdicts), default=0.0),
        lambda: next((known for known in (True, None) if known in [v.self_stress for v in verdicts]), False),
    )


def _reason(groups: Sequence[GroupVerdict], status: Status) -> str:
    """Give the reason of every group with this status; groups with the same reason share it.

    What is only balanced, of all groups, comes after the reasons.
    """
    if not groups:
        return "nothing that is asked about can move"
    by_reason: dict[str, list[str]] = {}
    concerned = [group for group in groups if group.verdict.status is status]
    for group in concerned:
        reason = group.verdict.reason.removesuffix(balanced_in_verdict(group.verdict.balanced))
        by_reason.setdefault(reason, []).extend(group.bodies)
    balanced = balanced_in_verdict([name for group in concerned for name in group.verdict.balanced])
    others = len(groups) - len(concerned)
    if len(by_reason) == 1 and not others:
        return next(iter(by_reason)) + balanced
    parts = [f"{listed(names)}: {reason}" for reason, names in by_reason.items()]
    if others:
        parts.append(f"{others} of {len(groups)} groups do not depend on this")
    return "; ".join(parts) + balanced


def _all_forces(forces: Sequence[ContactForces | None]) -> ContactForces | None:
    """Join the contact forces of groups, ordered by interface; None if those of one group are not known."""
    known = [f for f in forces if f is not None]
    if not known or len(known) < len(forces):
        return None
    interface = np.concatenate([f.interface for f in known])
    order = np.argsort(interface, kind="stable")
    columns = {
        name: np.concatenate([getattr(f, name) for f in known])[order]
        for name in ("points", "normal", "force", "usage")
    }
    return ContactForces(interface=interface[order], **columns)


def _all_motions(motions: Sequence[Mechanism | None]) -> Mechanism | None:
    """Join the motions of groups that move independently of each other."""
    known = [motion for motion in motions if motion is not None]
    if len(known) < 2:
        return known[0] if known else None
    kinematics = Kinematics.joined([motion.kinematics for motion in known])
    modes = {motion.mode for motion in known} - {"none"}
    modes = modes - {"roll"} or modes
    return Mechanism(
        moving=tuple(name for motion in known for name in motion.moving),
        own=np.vstack([motion.own for motion in known]),
        mode=known[0].mode if not modes else modes.pop() if len(modes) == 1 else "mixed",
        dual=known[0].dual,
        kinematics=kinematics,
    )


def _all_proofs(proofs: Sequence[Certificate | None]) -> Certificate | None:
    """Join the proofs that groups fall: the power of all, and the worst violation."""
    known = [proof for proof in proofs if proof is not None]
    if not known or len(known) < len(proofs):
        return None
    return Certificate(sum(proof.power for proof in known), max(proof.violation for proof in known))


NO_FORCE = 1e-8  # share of the weight of the pushed body below which a force is a rounding error of none


def without_negligible(found: Answers, W: Float, assembly: Assembly) -> Answers:
    """Return the answers with 0 for forces on one group that rounding alone tells from 0, and a note that says so.

    Engines ``limit`` and ``graph`` need it: of a plank balanced on an edge they tell 1e-18 N and 1e-15 N.
    Forces are compared with the own weight of the bodies that are pushed: a light body may rest on a heavy one.
    """
    own = np.abs(W * assembly.equation_scale[:, None]).max(0, initial=0.0) / assembly.weight
    finite = found.status == Status.FINITE
    slight = finite & (np.where(finite, found.force, 0.0) * own <= NO_FORCE)
    if not slight.any():
        return found
    force, lower = np.where(slight, 0.0, found.force), np.where(slight, 0.0, found.lower)
    names = tuple(dict.fromkeys(name for moving in found.moving[slight] for name in moving))
    noted = any(ONLY_BALANCED in note for note in found.notes)
    notes = found.notes if noted or not names else (*found.notes, only_balanced(names))
    return replace(found, force=force, lower=lower, notes=notes).after(
        "only balanced", "rounding alone tells the force from none"
    )


class SmallestAnswers:
    """Collects the smallest of the answers that several groups give to each of ``count`` load columns."""

    def __init__(self, count: int) -> None:
        self.force, self.lower, self.upper = (np.full(count, np.inf) for _ in range(3))
        self.status = np.array([Status.INFINITE] * count, dtype=object)  # np.full would make plain texts of them
        self.mechanism = np.full(count, None, dtype=object)
        self.answered = np.zeros(count, dtype=bool)
        self.parts: list[Answers] = []

    def add(self, columns: Int, found: Answers) -> None:
        """Take the rows of ``found``, one for each of the ``columns``, where they are smaller.

        A row that is undecided has force 0 and so leaves the smallest open, unless another group gives way without any
        load.
        """
        self.parts.append(found)
        mine, other = _settled(self.status[columns], self.force[columns]), _settled(found.status, found.force)
        taken = ~self.answered[columns] | (~mine & (other | (found.force < self.force[columns])))
        self.answered[columns] = True
        self.lower[columns] = np.minimum(self.lower[columns], found.lower)
        self.upper[columns] = np.minimum(self.upper[columns], found.upper)
        at = columns[taken]
        for name in ("force", "status", "mechanism"):
            getattr(self, name)[at] = getattr(found, name)[taken]

    def answers(self, engine: Engine, verdict: Verdict, reasons: Sequence[str]) -> Answers:
        """Return what was collected as one table."""
        bounds = [weakest_bound([getattr(p, name) for p in self.parts]) for name in ("lower_bound", "upper_bound")]
        return Answers.of(
            engine=engine.name,
            claim=engine.claim,
            verdict=verdict,
            force=self.force,
            status=self.status.tolist(),
            mechanism=self.mechanism.tolist(),
            lower=self.lower,
            upper=self.upper,
            lower_bound=bounds[0],
            upper_bound=bounds[1],
            notes=joined_notes([*(part.notes for part in self.parts), reasons]),
        )


def _settled(status: Objects, force: Float) -> Bool:
    """Return for which rows (n,) no answer of another group can change anything: something moves without any load."""
    return np.asarray((status == Status.UNSTABLE) | ((status == Status.FINITE) & (force == 0)))
