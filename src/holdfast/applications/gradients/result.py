"""Derivatives of answers, with both one-sided values at kinks."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, checked_number, frozen
from holdfast.base.public import Of, PublicValue, Record, Summary, column, number
from holdfast.base.values import Table
from holdfast.queries.result import SHOWN
from holdfast.queries.uncertain import Pair


class Slopes(Record, kw_only=True):
    """Derivatives of n answers, in their unit (newtons for pushes) per unit of what they are derived by.

    ``pose`` maps bodies to (n, 6): by translation [1/m], then rotation [1/rad] about the body's origin, world axes.
    ``friction`` maps the two bodies of each interface to (n,), and ``mass`` movable bodies to (n,) [1/kg], with the
    centre of mass in place. ``point`` (n, 3) [1/m] is by the point of a push and ``direction`` (n, 3) by its unit
    direction [1/rad]; both are 0 for answers that are not about pushes.
    """

    pose: Table[str, Float]
    friction: Table[Pair, Float]
    mass: Table[str, Float]
    point: Float = column("n 3")
    direction: Float = column("n 3")


class Kink(Record, kw_only=True):
    """A kink of the answer in one ``row``: it grows with ``by`` (in words) otherwise ``before`` than ``after``."""

    row: int
    by: str
    before: float
    after: float


class Derivatives(PublicValue):
    """The derivatives of n answers ``force`` (n,) by poses, friction, masses and pushes; see ``Slopes``.

    A push moves and turns with its body; the loads of a load factor and standing loads stay in place, and accelerations
    keep their direction in the world. Contacts follow the bodies as ``assemble`` finds them: a face that opens or
    overlaps by less than the gap still touches, halfway between the two bodies.

    At a kink the answer changes otherwise on either side: ``before`` and ``after`` are its slopes below and above the
    value of the parameter. ``pose`` and so on are then the smaller of both, and 0 if they have different signs, so that
    no step along them promises what only one side gives. Elsewhere all three are the same. ``kinks`` lists all kinks.

    ``known`` (n,) tells which rows have derivatives: those that are finite and greater than 0; others are 0.
    ``from_multipliers`` (n,) tells which of them come from the multipliers of one solve, exact up to the accuracy of
    the solver; the others are differences of answers, good to about 1e-3.
    """

    engine: str
    force: Float = column("n")
    known: Bool = column("n")
    from_multipliers: Bool = column("n")
    slopes: Slopes
    before: Slopes
    after: Slopes
    kinks: tuple[Kink, ...]
    notes: tuple[str, ...]

    pose = Of[Table[str, Float]]("slopes.pose", "The derivatives (n, 6) by the pose of each body.")
    friction = Of[Table[Pair, Float]](
        "slopes.friction", "The derivatives (n,) by the coefficient of friction of each pair of bodies."
    )
    mass = Of[Table[str, Float]]("slopes.mass", "The derivatives (n,) [1/kg] by the mass of each movable body.")
    point = Of[Float]("slopes.point", "The derivatives (n, 3) [1/m] by the point of the push.")
    direction = Of[Float]("slopes.direction", "The derivatives (n, 3) by the unit direction of the push.")

    def soft_weights(self, width: float) -> tuple[float, Float]:
        """Return a smooth least force, and the weights (n,) that turn derivatives of rows into its derivative.

        It is -width log Σ exp(-force / width) over the known rows: at most their least force, and by at most width
        log(n) less. ``width`` is in the unit of the answers. All weights are 0 if no row is known, and it is then inf.
        """
        width = checked_number(width, "soft_weights: width", above=0)
        weights = np.zeros(len(self.force))
        if not self.known.any():
            return np.inf, frozen(weights)
        least = float(self.force[self.known].min())
        weights[self.known] = np.exp(-(self.force[self.known] - least) / width)
        return least - width * float(np.log(weights.sum())), frozen(weights / weights.sum())

    def summary(self) -> Summary:
        """Summarise by which pose the least answer changes most."""
        headline = f"{len(self.force):,} answers, {int(self.known.sum()):,} with derivatives, {len(self.kinks):,} kinks"
        rows = []
        if self.known.any():
            row = int(np.argmin(np.where(self.known, self.force, np.inf)))
            headline += f"; the least, {number(float(self.force[row]))}, grows"
            order = sorted(self.pose.items(), key=lambda item: -float(np.abs(item[1][row]).max()))
            rows = [[name, *(f"{value:.4g}" for value in slopes[row])] for name, slopes in order[:SHOWN]]
        heads = ("with the pose of", *(f"along {axis}" for axis in "xyz"), *(f"about {axis}" for axis in "xyz"))
        return Summary(headline, (("engine", self.engine),), heads, rows, self.notes)
