"""The verdicts on the groups of an assembly as one: the worst, with the evidence of all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holdfast.base.text import listed
from holdfast.engines.answers import balanced_in_verdict
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
    found = Verdict(
        status=status,
        reason=_reason(groups, status),
        equilibrium_exists=_all_of([v.equilibrium_exists for v in verdicts]),
        mechanism=_all_motions([v.mechanism for v in verdicts if v.status is status]),
        certificate=_all_proofs([v.certificate for v in verdicts if v.status is status]),
        balanced=tuple(name for v in verdicts for name in v.balanced),
    )
    return found.with_evidence(
        lambda: _all_forces([v.forces for v in verdicts]),
        lambda: max((v.residual for v in verdicts), default=0.0),
        lambda: _any_of([v.self_stress for v in verdicts]),
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


def _all_of(known: Sequence[bool | None]) -> bool | None:
    return False if False in known else None if None in known else True


def _any_of(known: Sequence[bool | None]) -> bool | None:
    return True if True in known else None if None in known else False


def _all_forces(forces: Sequence[ContactForces | None]) -> ContactForces | None:
    """Join the contact forces of groups, ordered by interface; None if those of one group are not known."""
    known = [f for f in forces if f is not None]
    if not known or len(known) < len(forces):
        return None
    interface = np.concatenate([f.interface for f in known])
    order = np.argsort(interface, kind="stable")
    columns = {name: np.concatenate([getattr(f, name) for f in known])[order] for name in _FORCE_COLUMNS}
    return ContactForces(interface=interface[order], **columns)


_FORCE_COLUMNS = ("points", "normal", "force", "usage")


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
