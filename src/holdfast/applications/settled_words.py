"""Describe in words what happened to each body when a scene was brought to rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.text import listed, quoted
from holdfast.contacts.overlap import Overlap
from holdfast.engines.verdict import Status
from holdfast.queries.stability import Stability
from holdfast.settling.motion import TOUCH, End, Motion, MotionLimits

LEAST = 1e-6  # [m] smaller motions count as none
STILL_GOING = 0.1  # share of the largest motion of the last step, below which a body counts as dragged along
UPWARD = 0.01  # cosine of the largest angle between up and the normal of a contact that carries weight


@dataclass(frozen=True, eq=False)
class Fate:
    """What happened to a group: (name, direction (3,), distance [m]) of bodies that ``left``, and ``words`` for all."""

    left: tuple[tuple[str, Float, float], ...]
    words: Mapping[str, str]


def fate_of(group: Sequence[str], motion: Motion, limits: MotionLimits, up: Float) -> Fate:
    """Describe what happened to the bodies of a group, in the order of the motion; ``up`` (3,) points upwards."""
    left, words = [], {}
    for k, name in enumerate(group):
        posed = motion.bodies[k]
        way = float(np.linalg.norm(posed.moved))
        if k in motion.left and motion.end is End.LEFT:
            going = motion.going[k] if np.linalg.norm(motion.going[k]) > 0 else posed.moved
            direction = going / max(float(np.linalg.norm(going)), 1e-300)
            left.append((name, direction, way))
            x, y, z = direction + 0.0
            how = f"after {1e3 * way:.3g} mm and {posed.turned:.3g} degrees"
            words[name] = f"falls: goes beyond the travel {how}, moving along ({x:.2f}, {y:.2f}, {z:.2f})"
        elif motion.end is End.LEFT:
            words[name] = "not brought to rest: a body that it may touch falls"
        elif k in motion.left:
            words[name] = f"moved {1e3 * way:.3g} mm, beyond the travel, to end overlaps"
        elif motion.end is not End.REST:
            words[name] = f"moved {1e3 * way:.3g} mm: {motion.end.value}"
        else:
            words[name] = _why(motion, k, way, limits, up)
    return Fate(tuple(left), words)


def moving(group: Sequence[str], motion: Motion) -> list[str]:
    """Return the names of the bodies of a group that still moved in the last step, or of all if none did."""
    ways = np.linalg.norm(motion.going, axis=1)
    return [name for name, way in zip(group, ways, strict=True) if way >= STILL_GOING * float(ways.max())]


def _why(motion: Motion, k: int, way: float, limits: MotionLimits, up: Float) -> str:
    """Say why a body that came to rest has moved."""
    touched = np.abs(motion.contacts.gaps) <= TOUCH * limits.reach
    ends, normals = motion.contacts.ends[touched], motion.contacts.normals[touched]
    mine = np.flatnonzero((ends == k).any(1))
    others = np.where(ends[mine, 0] == k, ends[mine, 1], ends[mine, 0])
    upward = np.where(ends[mine, 1] == k, 1.0, -1.0) * (normals[mine] @ up)
    below = others[upward > UPWARD]
    leant = np.unique(below if len(below) else others).tolist()  # on those that press it upwards, or on all it touches
    where = listed([motion.bodies[other].start.name for other in leant]) or "nothing"
    if way < LEAST and motion.bodies[k].turned < 1e-3:
        return f"was at rest on {where}"
    pushed = float(np.linalg.norm(motion.pushed[k]))
    sunk = float(np.linalg.norm(motion.bodies[k].moved - motion.pushed[k]))
    parts = [f"pushed {1e3 * pushed:.2g} mm out of an overlap"] if pushed > LEAST else []
    parts += [f"sank {1e3 * sunk:.2g} mm"] if sunk > LEAST else []
    return " and ".join(parts or ["turned"]) + f"; rests on {where}"


def status_and_reason(
    verdict: Stability | None,
    fell: Sequence[str],
    deep: Sequence[Overlap],
    far: Sequence[str],
    faults: Sequence[str],
    unfinished: Sequence[str],
    limits: MotionLimits,
) -> tuple[Status, str]:
    """Return the status of a scene brought to rest and the reason for it."""
    travel = f"the travel of {1e3 * limits.reach:.3g} mm"
    if fell:
        return (
            Status.UNSTABLE,
            f"{listed(fell)}: went beyond {travel} or turned by more than {limits.turn:.3g} degrees",
        )
    if deep:
        worst = max(deep, key=lambda o: o.depth)
        a, b = map(quoted, worst.bodies)
        return (
            Status.UNDECIDED,
            f"{a} and {b} overlap by {1e3 * worst.depth:.3g} mm, deeper than {travel}: correct the poses",
        )
    if far:
        return Status.UNDECIDED, f"{listed(far)}: overlaps end only beyond {travel}: correct the poses"
    if verdict is None:
        return Status.STABLE, "nothing can move"
    if faults and verdict.status is Status.STABLE:
        return Status.UNDECIDED, f"overlaps are left: {'; '.join(faults[:3])}"
    if verdict.status is Status.STABLE:
        return Status.STABLE, f"at rest within {travel}; {verdict.reason}"
    if unfinished:
        return (
            Status.UNDECIDED,
            f"{'; '.join(unfinished)}: settle the resulting scene once more, or correct the poses",
        )
    return verdict.status, verdict.reason
