"""The result of ``carry``: whether a load holds while its carrier moves, and what moves first and when."""

from __future__ import annotations

from typing import Any

import numpy as np

from holdfast.applications.carrying.profile import Profile
from holdfast.applications.transport import speed_within
from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import to_dict
from holdfast.base.arrays import Bool, Float, frozen, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Of, Pictured, Summary, number
from holdfast.base.text import listed
from holdfast.engines.answers import Answers, Claim
from holdfast.engines.verdict import Status
from holdfast.queries.result import NAMED, ROW, Columns, gives_way, verdict_words

WORDS = {Status.STABLE: "holds", Status.UNSTABLE: "gives way", Status.UNDECIDED: "undecided"}


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
        why = self.undecided.text or f"factor {number(self.factor[k])}, known to be at least {number(self.lower[k])}"
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
            facts.append((what, f"{number(self.time_scale())} times the speed"))
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
    """Return for each row (n,) whether something moves by the engine's own claim: the factor is below 1."""
    return frozen(np.asarray(answers.decided & (answers.force < 1)))
