"""Decide whether a load holds while its carrier moves."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.carrying.profile import STANDARDS, Profile
from holdfast.applications.transport import inertial_wrenches, speed_within
from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Bool, Float, Int, frozen, objects
from holdfast.base.errors import HoldfastError, message, nearest_of
from holdfast.base.progress import reported
from holdfast.base.public import Of, Pictured, Summary, at_most, number
from holdfast.base.ranges import COORDINATES
from holdfast.base.text import listed, quoted
from holdfast.engines.answers import Answers, Claim, joined
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.engines.verdict import Status
from holdfast.queries import request
from holdfast.queries.push import load_factors
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, Load
from holdfast.queries.result import NAMED, ROW, Columns, gives_way, verdict_words
from holdfast.scene.scene import Scene

WORDS = {Status.STABLE: "holds", Status.UNSTABLE: "gives way", Status.UNDECIDED: "undecided"}
ProfileChoice: TypeAlias = Profile | str | os.PathLike[str] | ArrayLike
DIGITS = 14  # decimals to which accelerations are compared; the times of one ramp differ by rounding only
ONSET = 1e-3  # share of a step of the profile to which the onset of motion is located
WITH_GRAVITY = 0.1  # [g] by which a mean upward acceleration may miss g and still be gravity: slopes, drifting sensors
STAGE = "the motion of the carrier"
WHEN = "when something moves"


class Carried(Pictured, Columns, ask=".holds or .outcome"):
    """Whether a load holds while its carrier moves by ``profile`` at n times.

    ``factor`` (n,) is the largest factor on the inertial loads of each time before something moves: the load holds
    where it is at least 1. ``lower`` and ``upper`` (n,) bound the true factor as far as the engine can promise.
    ``status`` (n,) says what the factor means: FINITE; INFINITE; UNSTABLE (it is 0: the tilted load does not stand even
    without inertia); UNDECIDED (the 0 is no answer). ``moving``, ``mode`` and ``mechanism``, each (n,), say what would
    give way first. ``verdict`` is that at rest, with gravity as at the first time.

    ``outcome`` is STABLE if the load holds at all times, UNSTABLE if something moves at one of them, and UNDECIDED
    otherwise; ``reason`` says why. ``time`` [s] is the onset of motion, to a thousandth of a step of the profile, or
    inf if nothing is known to move; ``first`` holds the names of the bodies that move first. Rows after ``time`` assume
    that nothing has moved before.

    Its picture shows the accelerations and the used share of the load's capacity over time, in colours that say which
    bodies would give way first.
    """

    assembly: Assembly
    profile: Profile
    time: float
    first: tuple[str, ...]

    heads = ("at", "factor")
    plain = f"factor {ROW}"

    factor = Of[Float](
        "answers.force", "The largest factor (n,) on the inertial loads of each time before something moves."
    )

    @property
    def holds(self) -> bool:
        """Whether the load certainly holds at all times: False if that is undecided, and always of engine ``limit``."""
        return self.outcome is Status.STABLE

    @property
    def held(self) -> Bool:
        """Whether (n,) the load is known to hold at each time."""
        return held(self.answers)

    @property
    def moves(self) -> Bool:
        """Whether (n,) something is known to move at each time."""
        return moved(self.answers)

    @property
    def used(self) -> Float:
        """The share (n,) of the load's capacity that the inertial loads of each time use; nan where it is undecided.

        It is 1 / ``lower``, or 1 / ``factor`` for engine ``graph``, which promises no lower bound.
        """
        with np.errstate(divide="ignore"):
            share = 1 / (self.factor if self.claim is Claim.ESTIMATED else self.lower)
        return frozen(np.where(self.answers.decided, share, np.nan))

    @property
    def outcome(self) -> Status:
        """STABLE if it holds at all times, UNSTABLE if something moves at some time, else UNDECIDED."""
        if self.moves.any():
            return Status.UNSTABLE
        return Status.STABLE if self.held.all() else Status.UNDECIDED

    @property
    def reason(self) -> str:
        """Why the outcome is what it is, in words."""
        if self.outcome is Status.UNSTABLE:
            k = int(np.argmax(self.moves))
            return f"at {number(self.time, 's')} {gives_way(self.mode[k], self.first)}"
        if self.outcome is Status.STABLE:
            most = int(np.argmax(self.used))
            used, when = float(self.used[most]), number(float(self.profile.time[most]), "s")
            return f"the motion uses at most {100 * used:.3g} % of what it withstands" + (
                f", at {when}" if used > 0 else ""
            )
        if self.claim is Claim.EXISTS and (self.lower >= 1).all():
            return "an equilibrium exists at all times, which need not hold"
        k = int(np.argmin(self.held))
        why = self.undecided.text or f"factor {number(self.factor[k])}, known to be at least {at_most(self.lower[k])}"
        return f"not known to hold from {number(float(self.profile.time[k]), 's')}: {why}"

    def time_scale(self, *, margin: float = 0.0) -> float:
        """Return the largest factor on the speed of the motion at which the load is known to hold throughout.

        At s times the speed, inertial loads are multiplied by s². A factor below 1 means that the motion must be slowed
        down to it; it is 0 if the load is not known to stand at one of the times. ``margin`` in [0, 1) is the share of
        the load's capacity that remains unused. Of engine ``limit`` it is the factor at which an equilibrium exists
        throughout. Raises HoldfastError if ``margin`` is out of range or the engine promises no lower bound.
        """
        if self.claim is Claim.ESTIMATED:
            problem = f"engine {self.engine!r} promises no lower bound"
            raise HoldfastError(message("time_scale", problem, "ask engine 'compliant' or 'limit'"))
        with np.errstate(divide="ignore"):
            return speed_within(1 / self.lower, margin, "time_scale")

    def where(self, row: int) -> dict[str, Any]:
        """Return the time that a row answers, as plain data."""
        return {"time": to_dict(float(self.profile.time[row]))}

    def about(self) -> dict[str, Any]:
        """Return what applies to all times as plain data, and the motion."""
        scale = None if self.claim is Claim.ESTIMATED else to_dict(self.time_scale())
        about: dict[str, Any] = {"scene": self.assembly.scene.name, "profile": self.profile.name}
        about |= {"source": self.profile.source, "outcome": self.outcome.value, "reason": self.reason}
        about |= {"time": to_dict(self.time), "first": list(self.first), "time_scale": scale}
        motion = ("time", "acceleration", "angular_acceleration", "angular_velocity")
        samples = {"samples": {name: to_dict(getattr(self.profile, name)) for name in motion}}
        return about | super().about() | samples

    def facts(self) -> list[tuple[str, str]]:
        """Return the outcome and what applies to all times as (name, text) pairs."""
        facts = [("outcome", WORDS[self.outcome]), ("why", self.reason)]
        if self.claim is not Claim.ESTIMATED:
            what = "safe speed" if self.claim is Claim.HOLDS else "an equilibrium exists at"
            facts.append((what, f"{at_most(self.time_scale())} times the speed"))
        if self.first:
            facts.append(("moves first", listed(self.first, NAMED)))
        return [*facts, *super().facts()]

    def summary(self) -> Summary:
        """Summarise the outcome by the times with the smallest factors."""
        name, motion = self.assembly.scene.name or "assembly", self.profile.name or "a motion"
        outcome = f"{WORDS[self.outcome]}; {self.reason}; at rest {verdict_words(self.verdict)}"
        times = objects([number(float(t), "s") for t in self.profile.time])
        return self.table(f"{name}, {motion}: {outcome}", times)


def held(answers: Answers) -> Bool:
    """Return for each row (n,) whether the load is known to hold: the promised bound of its factor is at least 1.

    Where an engine promises no more than that an equilibrium exists, it never is.
    """
    promised = answers.force if answers.claim is Claim.ESTIMATED else answers.lower
    return frozen(np.asarray(answers.decided & (promised >= 1) & (answers.claim is not Claim.EXISTS)))


def moved(answers: Answers) -> Bool:
    """Return for each row (n,) whether something moves by the engine's claim: the load factor ``force`` is below 1."""
    return frozen(np.asarray(answers.decided & (answers.force < 1)))


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
    given = request.checked_assembly(assembly)
    motion = checked_profile(profile, given)
    loads = request.checked_loads(standing)
    wrench, pressed = request.total_wrench(given, loads), request.pressed_by(given, loads)
    question = _Question(given, request.engine_of(engine), bounds, imperfect, wrench, pressed)
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


@dataclass(frozen=True, eq=False)
class _Question:
    """A query of any motion, under the ``standing`` wrench (6J,) of loads that press bodies by ``pressed`` (B,) [N]."""

    assembly: Assembly
    method: Engine
    bounds: bool
    imperfect: Imperfect | None
    standing: Float
    pressed: Float

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
