"""The smallest robustness over intervals of friction and boxes of masses and centres of mass: exact, not sampled."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Objects, objects
from holdfast.base.public import Summary, number
from holdfast.base.values import Table
from holdfast.engines.capabilities import WORST_CASES
from holdfast.queries.intervals import (
    ComRange,
    MassRange,
    MuRange,
    Pair,
    com_boxes,
    friction_intervals,
    mass_intervals,
    with_friction,
)
from holdfast.queries.push import robustness
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    Load,
    body_number,
    checked_assembly,
    engine_of,
    push_columns,
    total_wrench,
)
from holdfast.queries.result import Forces, least
from holdfast.scene.scene import Scene


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class WorstCase(Forces):
    """The smallest R at each of n points over all that is uncertain.

    ``force`` (n,) [N] with bounds ``lower``, ``upper`` and ``status`` (n,) as in Robustness: UNSTABLE where a corner
    does not stand, UNDECIDED (force 0) where a corner was not settled. ``nominal`` (n,) [N] is R without uncertainty,
    whose ``verdict`` is told. ``mu`` are the coefficients it is taken at; ``masses`` [kg] and ``coms`` (world [m]) (n,)
    hold, by uncertain body, the corner where each point is weakest. ``corners`` were tried. ``guarantee`` says what was
    proved.
    """

    body: str
    nominal: Float
    mu: Table[Pair, float]
    masses: Objects
    coms: Objects
    corners: int
    guarantee: str

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        names = ("force", "lower", "upper", "status", "moving", "mode", "nominal", "mu", "masses", "coms")
        whole = {"body": self.body, "corners": self.corners, "guarantee": self.guarantee}
        return self.about() | whole | self.columns(*names)

    def summary(self) -> Summary:
        """The weakest points."""
        headline = f"{len(self.force):,} pushes on {self.body} at {self.corners:,} corners: {least(self.force, 'N')}"
        return self.table(headline, objects([f"nominal {number(value, 'N')}" for value in self.nominal]))


def worst_case(
    assembly: Assembly | Scene,
    body: str,
    points: ArrayLike,
    directions: ArrayLike,
    *,
    friction: MuRange | None = None,
    mass: MassRange | None = None,
    com: ComRange | None = None,
    standing: Iterable[Load] = (),
) -> WorstCase:
    """The smallest R(p, e) by engine ``limit`` over intervals of friction and boxes of masses and centres of mass.

    ``friction``: a relative width (0.2: ± 20 %) or (low, high) for all touching pairs, or a dict of (low, high) by the
    two bodies' names. ``mass``: a relative width for all movable bodies, or a dict of (low, high) [kg] by body.
    ``com``: a half width [m] for all movable bodies, or a dict of half widths (3,) [m] by body: a box along the world
    axes around the centre of mass. What is not named is taken as known. Poses, contacts and points stay as they are.

    Exact, not sampled: the lower end of every μ, and of masses and centres of mass all corners (``guarantee`` says
    why), at one set-up each. Their number doubles with every uncertain value (shifts along gravity do not count); more
    than 4,096 raise HoldfastError.
    """
    assembly = checked_assembly(assembly)
    where = f"worst case of {body!r}"
    loads = list(standing)
    nominal = robustness(assembly, body, points, directions, standing=loads, engine=CERTAIN_ENGINE)
    low = {pair: ends[0] for pair, ends in friction_intervals(assembly, friction, where).items()}
    rough = assembly if friction is None else with_friction(assembly, low)
    masses, coms = mass_intervals(rough, mass, where), com_boxes(rough, com, where)
    columns = push_columns(rough, body_number(rough, body), nominal.points, nominal.directions)
    method = WORST_CASES.of(engine_of(CERTAIN_ENGINE), engine=CERTAIN_ENGINE, where=where)
    found = method.weakest(rough, total_wrench(rough, loads), columns, masses=masses, coms=coms, where=where)
    told = nominal.answers
    return WorstCase(
        answers=replace(found.answers, verdict=told.verdict, notes=told.notes),
        body=body,
        nominal=nominal.force,
        mu=Table(low),
        masses=objects([Table(found.corners[k].masses) for k in found.corner]),
        coms=objects([Table(found.corners[k].coms) for k in found.corner]),
        corners=len(found.corners),
        guarantee=found.guarantee,
    )
