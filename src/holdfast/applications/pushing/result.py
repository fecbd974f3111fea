"""The result of ``safe_pushes``: where a body can be pushed, and what each push does."""

from __future__ import annotations

from collections import Counter
from enum import StrEnum, auto

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Objects
from holdfast.base.errors import HoldfastError, message, no_truth
from holdfast.base.public import PublicValue, Summary, column, number
from holdfast.engines.answers import Claim
from holdfast.queries.result import places_of, vector_text

SHOWN = 6  # largest number of rows of each effect in a summary


@archived
class Effect(StrEnum):
    """What a push certainly moves: NOTHING, the pushed body ALONE, or OTHERS too; UNKNOWN if that is not certain."""

    NOTHING = auto()
    ALONE = auto()
    OTHERS = auto()
    UNKNOWN = auto()

    def __bool__(self) -> bool:
        raise no_truth(self, f"compare it: effect == {self.value!r}")


class SafePushes(PublicValue):
    """What pushes of up to ``force`` [N] on ``body`` do, at n points that the tool can reach.

    ``points`` (n, 3) [m] and the unit ``directions`` (n, 3) are in the world frame. ``effect`` (n,) holds an Effect for
    each push, with the ``reason`` (n,) in words: NOTHING moves at any force up to this one; the body moves ALONE, by
    ``travel`` [m], when it is pushed slowly by a tool that yields at this force; OTHERS move too; or it is UNKNOWN.
    NOTHING and ALONE hold for the given friction and for friction that differs by the share ``doubt``, at the contacts
    of the body and at all others.

    For all these cases of friction, nothing moves at ``lower`` (n,) [N], by the engine's bound, and something certainly
    moves at ``upper`` (n,) [N], by limit analysis. ``unreached`` is the number of pushes that were skipped because the
    tool, of radius ``tool_radius`` [m], would touch another body.
    """

    body: str
    engine: str
    claim: Claim
    force: float
    points: Float = column("n 3")
    directions: Float = column("n 3")
    effect: Objects = column("n", of=Effect)
    reason: Objects = column("n", of=str)
    lower: Float = column("n")
    upper: Float = column("n")
    unreached: int
    tool_radius: float
    travel: float
    doubt: float
    notes: tuple[str, ...]

    plain = (
        "body engine claim force points directions effect reason lower upper unreached tool_radius travel doubt notes"
    )

    @property
    def nothing(self) -> Bool:
        """Which pushes (n,) move nothing."""
        return self.are(Effect.NOTHING)

    @property
    def alone(self) -> Bool:
        """Which pushes (n,) move the body and no other one."""
        return self.are(Effect.ALONE)

    def are(self, effect: Effect) -> Bool:
        """Return which pushes (n,) have this effect."""
        found: Bool = self.effect == effect
        found.setflags(write=False)
        return found

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the columns that were read from a file are not those of pushes."""
        if (self.lower[self.nothing] < self.force).any() or (self.upper[self.alone] > self.force).any():
            problem = "the bounds of a push contradict its effect"
            raise HoldfastError(message("pushes: effect", problem, "needs what was saved"))

    def summary(self) -> Summary:
        """Summarise the answer by the number of pushes with each effect, and some examples."""
        count = Counter(self.effect.tolist())
        counts = f"{count[Effect.ALONE]} move it alone, {count[Effect.NOTHING]} nothing"
        headline = f"{len(self.effect)} pushes of {number(self.force, 'N')} on {self.body}: {counts}"
        facts = [("engine", f"{self.engine} ({self.claim.words})")]
        facts += [(f"{effect}", f"{count[effect]}") for effect in Effect]
        facts += [("not reached by the tool", f"{self.unreached}")]
        places = places_of(self.points)
        rows = [
            [str(effect), places[k], vector_text(self.directions[k], ".2f"), self.reason[k]]
            for effect in Effect
            for k in self.are(effect).nonzero()[0][:SHOWN].tolist()
        ]
        return Summary(headline, facts, ("moves", "at", "along", "why"), rows, self.notes)
