"""How good a stable pose is, by a coarse map of the assembly with the object in place."""

from __future__ import annotations

from typing import Literal, NamedTuple

from holdfast.queries.map import RobustnessMap


class Rating(NamedTuple):
    """The least push [N] over all decided points of a map and over those on the object; None if none is decided.

    Ratings compare by ``key``: the larger it is, the better is the pose.
    """

    least: float | None
    own: float | None

    @classmethod
    def of(cls, found: RobustnessMap, body: str, column: Literal["force", "lower"] = "force") -> Rating:
        """Rate a pose by one column of its map; ``body`` is the name of the object."""
        return cls(least_push(found, column=column), least_push(found, body, column))

    @property
    def key(self) -> tuple[float, ...]:
        """What decides: a pose of whose object nothing is known is below every pose of whose object something is."""
        least, own = self.least, self.own
        return float(own is not None), -1.0 if least is None else round(least, 9), -1.0 if own is None else own


def least_push(
    found: RobustnessMap, body: str | None = None, column: Literal["force", "lower"] = "force"
) -> float | None:
    """Return the least push [N] of a map, or of one body in it, over its decided points; None if there is none."""
    known = found.answers.decided if body is None else found.answers.decided & (found.body == body)
    values = found.force if column == "force" else found.lower
    return float(values[known].min()) if known.any() else None
