"""Decide whether a load holds while its carrier moves."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.carrying.profile import STANDARDS, Profile
from holdfast.applications.carrying.result import Carried, moved
from holdfast.applications.transport import inertial_wrenches
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import HoldfastError, message, nearest_of
from holdfast.base.progress import reported
from holdfast.base.ranges import COORDINATES
from holdfast.base.text import quoted
from holdfast.engines.answers import Answers, joined
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.engines.verdict import Status
from holdfast.queries.push import load_factors
from holdfast.queries.request import (
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    checked_assembly,
    checked_loads,
    engine_of,
    pressed_by,
    total_wrench,
)
from holdfast.scene.scene import Scene

ProfileChoice: TypeAlias = Profile | str | os.PathLike[str] | ArrayLike

DIGITS = 14  # decimals to which accelerations are compared; the times of one ramp differ by rounding only
ONSET = 1e-3  # share of a step of the profile to which the onset of motion is located
WITH_GRAVITY = 0.1  # [g] by which a mean upward acceleration may miss g and still be gravity: slopes, drifting sensors
STAGE = "the motion of the carrier"
WHEN = "when something moves"


def carry(
    assembly: Assembly | Scene,
    profile: ProfileChoice,
    *,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
    bounds: bool = False,
    imperfect: Imperfect | None = None,
) -> Carried:
    """Decide whether what stands on a carrier holds while the carrier moves, and which body moves first and when.

    ``profile`` is a Profile, a table (n, 4), (n, 7) or (n, 10) (see ``Profile.from_table``), the path of a CSV file, or
    the name of a standard one (``Profile.standards()``), for a vehicle that drives along the x axis of the scene.
    The ``standing`` loads, such as those of straps, act throughout and are not multiplied. ``bounds`` and ``imperfect``
    have the same meaning as in ``robustness``.

    Every time is judged on its own, from rest, by the inertial loads at that time (``transport.py``) and by gravity in
    the axes of the turned carrier. This is quasi-static: there is no bouncing or rocking, and no earlier slip.

    Raises HoldfastError for a profile that cannot be read.
    """
    given = checked_assembly(assembly)
    motion = checked_profile(profile, given)
    question = _Question(given, standing, engine_of(engine), bounds, imperfect)
    answers = question.over(motion, motion.gravity(given.scene.gravity))
    answers = replace(answers, notes=(*answers.notes, *_doubts(motion, given.scene.gravity)))
    time: float = np.inf
    first: tuple[str, ...] = ()
    if moved(answers).any():
        time, first = question.onset(motion, answers)
    return Carried(answers=answers, assembly=given, profile=motion, time=time, first=first)


def checked_profile(profile: ProfileChoice, assembly: Assembly) -> Profile:
    """Return the profile that the argument of ``carry`` stands for."""
    if isinstance(profile, Profile):
        return profile
    if isinstance(profile, str) and (profile in STANDARDS or not os.path.exists(profile)):
        if profile not in STANDARDS:
            raise unknown_profile(profile)
        up = assembly.scene.up
        heading = (1, 0, 0) if abs(up[0]) < 0.9 else (0, 1, 0)
        return Profile.named(profile, heading=heading, up=up)
    if isinstance(profile, str | os.PathLike):
        return Profile.from_file(profile)
    return Profile.from_table(profile)


def unknown_profile(name: str) -> HoldfastError:
    """Return the error for a name that is neither a file nor a standard profile."""
    problem = "there is no such file, and no standard profile of this name"
    return HoldfastError(message(f"profile {quoted(name)}", problem, nearest_of(name, STANDARDS)))


def _doubts(motion: Profile, gravity: Float) -> tuple[str, ...]:
    """Return a note if the accelerations of a motion seem to contain gravity (3,) [m/s²], as an accelerometer has it.

    A carrier does not accelerate upwards by g on average: it would be 5 m higher after a second.
    """
    usual = float(np.linalg.norm(gravity))
    upwards = motion.acceleration @ -gravity / usual
    span = motion.time[-1] - motion.time[0]
    mean = float(np.trapezoid(upwards, motion.time) / span) if span > 0 else float(upwards[0])
    if abs(mean - usual) > WITH_GRAVITY * usual:
        return ()
    what = f"the carrier accelerates upwards by {mean:.4g} m/s² on average"
    return (f"{what}: do these accelerations contain gravity? Take it off, a carrier at rest has 0",)


class _Question:
    """A query of any motion: the assembly, its standing loads and the options of the answer."""

    def __init__(
        self,
        assembly: Assembly,
        standing: Iterable[Load],
        method: Engine,
        bounds: bool,
        imperfect: Imperfect | None,
    ) -> None:
        self.assembly, self.method, self.bounds, self.imperfect = assembly, method, bounds, imperfect
        standing = checked_loads(standing)
        self.standing, self.pressed = total_wrench(assembly, standing), pressed_by(assembly, standing)

    def over(self, motion: Profile, gravity: Float) -> Answers:
        """Return the answers for the n times of a motion, at which gravity is ``gravity`` (n, 3) [m/s²]."""
        usual = self.assembly.scene.gravity
        shifted = np.linalg.norm(gravity - usual, axis=1) > COORDINATES * np.linalg.norm(usual)
        gravity = np.where(shifted[:, None], gravity, usual)
        # Where the carrier does not turn, loads are proportional to accelerations: times whose accelerations differ by
        # a factor, such as those of one ramp, need one answer
        accelerations = np.hstack([motion.acceleration, motion.angular_acceleration])
        largest = np.abs(accelerations).max(1)
        scale = np.where(motion.angular_velocity.any(1) | (largest == 0), 1.0, largest)
        moves = np.hstack([accelerations / scale[:, None], motion.angular_velocity, gravity]).round(DIGITS)
        _, rows, number = np.unique(moves + 0.0, axis=0, return_index=True, return_inverse=True)
        number = number.ravel()
        parts, order, doubts = [], [], np.full(len(rows), "", dtype=object)
        fields, of = np.unique(gravity[rows], axis=0, return_inverse=True)
        begin = of.ravel()[0]  # joined answers have the verdict of the first part: that at the first time
        for k in reported(STAGE, [begin, *(k for k in range(len(fields)) if k != begin)]):
            mine = np.flatnonzero(of.ravel() == k)
            parts.append(self._asked(motion, rows[mine], scale[rows[mine]], fields[k]))
            order.append(mine)
            if parts[-1].verdict.status is Status.UNDECIDED:
                when = f"{motion.time[rows[mine[0]]]:.4g} s"
                doubts[mine] = f"undecided as the carrier stands at {when}: {parts[-1].verdict.reason}"
        place = np.empty(len(rows), dtype=np.int64)
        place[np.concatenate(order)] = np.arange(len(rows))
        found = joined(parts).rows(place[number])
        divided = {name: getattr(found, name) / scale for name in ("force", "lower", "upper")}
        answers = replace(found, **divided)
        reasons = doubts[number]
        unknown = np.array([bool(doubt) for doubt in reasons]) & ~moved(answers)
        status = answers.status.copy()
        status[unknown] = Status.UNDECIDED
        force, lower = (np.where(unknown, 0.0, values) for values in (answers.force, answers.lower))
        notes = dict.fromkeys((*answers.notes, *(d for d in reasons[unknown] if answers.verdict.reason not in d)))
        return replace(answers, force=force, lower=lower, status=status, notes=tuple(notes))

    def _asked(self, motion: Profile, rows: Int, scale: Float, gravity: Float) -> Answers:
        """Return the answers for times at which gravity (3,) is the same, with loads divided by ``scale`` (n,).

        Their verdict covers all bodies, also those without inertial loads.
        """
        here = self.assembly
        if (gravity != here.scene.gravity).any():
            here = replace(here, scene=replace(here.scene, gravity=gravity))
        chosen = (values[rows] for values in (motion.acceleration, motion.angular_acceleration))
        a, alpha = (values / scale[:, None] for values in chosen)
        W = inertial_wrenches(here, a, alpha, motion.angular_velocity[rows], motion.pivot)
        pressed = self.pressed, np.zeros((len(here.bodies), len(rows)))
        found = load_factors(
            self.method, here, W, self.standing, bounds=self.bounds, imperfect=self.imperfect, pressed=pressed
        )
        verdict = prepared(self.method, here, self.standing).verdict()
        if verdict.status is not Status.UNSTABLE:
            return replace(found, verdict=verdict)
        names = ("engine", "claim", "lower_bound", "upper_bound", "notes")
        return Answers.not_standing(len(rows), verdict=verdict, **{name: getattr(found, name) for name in names})

    def onset(self, motion: Profile, answers: Answers) -> tuple[float, tuple[str, ...]]:
        """Return the time [s] at which something first begins to move, and the names of the bodies that move.

        It is found by bisection between the first time at which something is known to move and the time before.
        """
        k = int(np.argmax(moved(answers)))
        late, names = float(motion.time[k]), answers.moving[k]
        early = float(motion.time[k - 1]) if k else late
        for _ in reported(WHEN, range(math.ceil(math.log2(1 / ONSET)) if k else 0)):
            middle = (early + late) / 2
            until = motion.at([*motion.time[:k], middle])
            found = self.over(until.at([middle]), until.gravity(self.assembly.scene.gravity)[-1:])
            if moved(found)[0]:
                late, names = middle, found.moving[0]
            else:
                early = middle
        return late, names
