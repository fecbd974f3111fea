"""What a validator says of a scene, body by body: what falls, overlaps, hovers or yields, and how it comes to rest."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np

from holdfast.applications.settled import LEAST, settle
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.assembly.caution import doubts_of_scene
from holdfast.base.arrays import Float
from holdfast.base.borders.worker import ANSWERED
from holdfast.base.errors import HoldfastError, HoldfastWarning
from holdfast.batches.gate import FAILED, PASSED, GateRules, judged
from holdfast.engines.verdict import Status
from holdfast.queries.map import robustness_map
from holdfast.queries.stability import Stability, stability
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

Severity = Literal["failure", "warning", "info"]
TURN = 1e-3  # [deg] smaller rotations count as none, as LEAST does of motions


@dataclass(frozen=True)
class ScenePolicy:
    """What a scene must be.

    Everything stands; nothing overlaps or hovers by more than ``tolerance`` [m], that of each pair of bodies if it is
    None; and no push on a surface below ``min_force`` [N] moves anything, unless that is None. Remedies move bodies by
    at most ``travel`` [m].
    """

    tolerance: float | None = None
    min_force: float | None = None
    travel: float = 0.03


@dataclass(frozen=True)
class SceneFinding:
    """One thing that is wrong, not decided, or worth to know: of a ``body``, or of the whole scene if that is "".

    ``remedy`` are new poses (4, 4) by body, with which the body certainly stands and overlaps nothing, and ``how`` says
    what they change; both are empty where none is known.
    """

    severity: Severity
    text: str
    body: str = ""
    remedy: Mapping[str, Float] = field(default_factory=dict)
    how: str = ""


class Remedies(NamedTuple):
    """The new poses for the group of each body that can be brought to rest, and what ``settle`` says of every body."""

    poses: Mapping[str, Mapping[str, Float]]
    words: Mapping[str, str]
    reason: str


def findings_of_scene(scene: Scene, policy: ScenePolicy) -> list[SceneFinding]:
    """Return all findings about a scene, those of bodies first, then what looks like a mistake, then notes.

    Raises HoldfastError if the scene cannot be assembled, or if the policy is out of range.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HoldfastWarning)  # of overlaps, which are findings
        assembly = assemble(scene, gap=policy.tolerance)
        verdict = stability(assembly)
        found = [*_overlapping(assembly), *_hovering(assembly, verdict), *_not_standing(verdict)]
        if found:
            remedies = _remedies(scene, policy)
            found = [_with_remedy(finding, remedies, policy.travel) for finding in found]
        if policy.min_force is not None:
            found += _yielding(assembly, verdict, policy.min_force)
    found += [
        SceneFinding("info", f"{name} is only balanced: it stands, and the least push moves it", name)
        for name in verdict.balanced
    ]
    doubts = doubts_of_scene(scene, assembly.interfaces, assembly.overlaps)
    for doubt in doubts:
        name = next((body.name for body in scene.movable if doubt.startswith(f"{body.name}: ")), "")
        found.append(SceneFinding("warning", f"looks like a mistake: {doubt}", name))
    notes = dict.fromkeys((*scene.notes, *verdict.notes))
    return found + [SceneFinding("info", note) for note in notes if note not in doubts]


def _overlapping(assembly: Assembly) -> Iterator[SceneFinding]:
    for overlap in assembly.overlaps:
        for name in overlap.bodies:
            if not assembly.scene.body(name).fixed:
                yield SceneFinding("failure" if overlap.severity == "error" else "warning", overlap.text, name)


def _hovering(assembly: Assembly, verdict: Stability) -> Iterator[SceneFinding]:
    """Yield the groups that do not stand and touch nothing fixed, each at its body nearest to others.

    As with overlaps, up to twice the tolerance is a warning.
    """
    fixed = {body.name for body in assembly.fixed}
    for group in verdict.groups:
        own = set(group.bodies)
        if group.status is Status.STABLE or any(own & {*i.bodies} and fixed & {*i.bodies} for i in assembly.interfaces):
            continue
        nearest = assembly.nearest_support(group.bodies)
        if nearest is None:
            continue
        inside, outside, gap = nearest
        allowed = assembly.tolerances.between(assembly.scene.body(inside), assembly.scene.body(outside)).gap
        if gap > allowed:
            text = f"{inside} hovers: it is {1e3 * gap:.4g} mm from {outside}, the nearest, and the tolerance is "
            severity: Severity = "failure" if gap > 2 * allowed else "warning"
            yield SceneFinding(severity, f"{text}{1e3 * allowed:.2g} mm", inside)


def _not_standing(verdict: Stability) -> Iterator[SceneFinding]:
    """Yield every body that falls, and every body of a group about which nothing is certain."""
    for group in verdict.groups:
        if group.status is Status.UNSTABLE:
            motion = group.verdict.mechanism
            for name in group.bodies if motion is None else motion.moving:
                yield SceneFinding("failure", f"{name} does not stand: {group.reason}", name)
        elif group.status is not Status.STABLE:
            for name in group.bodies:
                yield SceneFinding("warning", f"undecided whether {name} stands: {group.reason}", name)


def _yielding(assembly: Assembly, verdict: Stability, wanted: float) -> Iterator[SceneFinding]:
    """Yield the bodies that stand and that a push below ``wanted`` [N] moves, or may move."""
    standing = [name for group in verdict.groups if group.status is Status.STABLE for name in group.bodies]
    if not standing:
        return
    surfaces = robustness_map(assembly, standing)
    answers = surfaces.answers
    for name in standing:
        rows = np.flatnonzero(surfaces.body == name)
        decided = [k for k in rows.tolist() if answers.status[k] is not Status.UNDECIDED]
        least = min(decided, key=lambda k: float(answers.force[k]), default=None)
        row = {
            "outcome": ANSWERED,
            "weakest": None if least is None else float(answers.force[least]),
            "weakest_body": name,
            "weakest_moving": None if least is None else answers.moving[least],
            "weakest_lower": float(answers.lower[rows].min()) if len(rows) else None,
            "undecided": len(rows) - len(decided),
        }
        result, reason = judged(row, GateRules(min_force=wanted))
        if result == FAILED:
            yield SceneFinding("failure", f"{name} yields: {reason}", name)
        elif result != PASSED:
            yield SceneFinding("warning", f"undecided whether {name} withstands pushes: {reason}", name)


def _remedies(scene: Scene, policy: ScenePolicy) -> Remedies:
    """Return how the bodies come to rest, group by group, each proved by asking the scene with the new poses again."""
    try:
        settled = settle(scene, travel=policy.travel, gap=policy.tolerance)
        rested = () if settled.stability is None else settled.stability.groups
        resting = {name for group in rested if group.status is Status.STABLE for name in group.bodies}
        poses = {
            name: _new_pose(scene.body(name), settled.scene.body(name), bool(turn > TURN))
            for name, way, turn in zip(settled.names, settled.moved, settled.turned_degrees, strict=True)
            if name in resting and (way > LEAST or turn > TURN)
        }
        after = assemble(scene.moved(poses), gap=policy.tolerance)
        overlapping = {name for overlap in after.overlaps for name in overlap.bodies}
        stands = [g.bodies for g in stability(after).groups if g.status is Status.STABLE]
    except HoldfastError as error:
        return Remedies({}, {}, str(error))
    groups = [group for group in stands if overlapping.isdisjoint(group)]
    by_body = {name: {n: poses[n] for n in group if n in poses} for group in groups for name in group}
    return Remedies(by_body, dict(zip(settled.names, settled.reasons, strict=True)), settled.reason)


def _new_pose(before: Body, after: Body, turns: bool) -> Float:
    """Return the new pose (4, 4) of a body; unless it turns, only its place changes, without the noise of a motion."""
    if turns:
        return after.pose
    pose = before.pose.copy()
    pose[:3, 3] += after.com_world - before.com_world
    return pose


def _with_remedy(finding: SceneFinding, remedies: Remedies, travel: float) -> SceneFinding:
    """Return a finding with the poses that end it, or with why there are none within ``travel`` [m]."""
    name = finding.body
    why = f"{name} {remedies.words[name]}" if name in remedies.words else remedies.reason
    poses = remedies.poses.get(name, {})
    if not poses:
        return replace(finding, text=f"{finding.text}; no remedy within {1e3 * travel:g} mm: {why}")
    others = len(poses.keys() - {name})
    more = f"; moves {others:,} more that touch" if others else ""
    return replace(finding, remedy=poses, how=f"settle: {why}{more}")
