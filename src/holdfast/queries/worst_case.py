"""Compute the smallest robustness over intervals of friction and mass and boxes of centres of mass, exactly."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Objects, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.kinds import check_kinds, fits, shaped
from holdfast.base.public import Summary
from holdfast.base.values import Table
from holdfast.engines.bearing import unchecked_limits
from holdfast.engines.capabilities import WORST_CASES
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.queries.intervals import (
    ComRange,
    MassRange,
    MuRange,
    Pair,
    com_boxes,
    friction_intervals,
    mass_intervals,
    width_notes,
)
from holdfast.queries.push import robustness
from holdfast.queries.request import (
    CERTAIN_ENGINE,
    Load,
    body_number,
    checked_assembly,
    checked_loads,
    engine_of,
    push_columns,
    total_wrench,
)
from holdfast.queries.result import Forces, amount, least
from holdfast.scene.scene import Scene


@archived
@shaped(answers="n", nominal="n", nominal_status="n", masses="n", coms="n")
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class WorstCase(Forces):
    """The smallest R at each of n points over all values of the uncertain quantities.

    ``force`` (n,) [N] has the bounds ``lower`` and ``upper`` and a ``status`` (n,) as in Robustness. The status is
    UNSTABLE where the assembly does not stand at some corner of the uncertain region. It is UNDECIDED where the answer
    at a corner is; the force 0 is no answer then. ``nominal`` (n,) [N] is R without uncertainty, with
    ``nominal_status`` (n,) and ``verdict``.

    ``mu`` holds the friction coefficients of the worst case, by pair of bodies. ``masses`` (n,) and ``coms`` (n,) hold
    for each point the masses [kg] and centres of mass [m, world frame] at the corner where it is weakest, by the name
    of the uncertain body. ``corners`` is the number of corners that were solved, and ``guarantee`` says in words what
    was proved.
    """

    body: str
    nominal: Float
    nominal_status: Objects
    mu: Table[Pair, float]
    masses: Objects
    coms: Objects
    corners: int
    guarantee: str

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the values that were read from a file have the wrong types."""
        for name, wanted in (("masses", Mapping[str, float]), ("coms", Mapping[str, tuple[float, float, float]])):
            if not all(fits(item, wanted) for item in getattr(self, name)):
                problem = "are not by the names of bodies"
                raise HoldfastError(message(f"worst case: {name}", problem, "needs those that an answer's save wrote"))
        check_kinds(self.nominal_status, Status, "nominal_status")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        names = (
            "force",
            "lower",
            "upper",
            "status",
            "moving",
            "mode",
            "nominal",
            "nominal_status",
            "mu",
            "masses",
            "coms",
        )
        whole = {"body": self.body, "corners": self.corners, "guarantee": self.guarantee}
        return self.about() | whole | self.columns(*names)

    def summary(self) -> Summary:
        """Summarise the answer by its weakest points."""
        headline = f"{len(self.force):,} pushes on {self.body} at {self.corners:,} corners: {least(self.answers, 'N')}"
        nominal = zip(self.nominal_status, self.nominal, strict=True)
        return self.table(headline, objects([f"nominal {amount(status, value, 'N')}" for status, value in nominal]))


def worst_case(
    assembly: Assembly | Scene,
    body: str,
    points: ArrayLike,
    directions: ArrayLike,
    *,
    mu_range: MuRange | None = None,
    mass_range: MassRange | None = None,
    com_range: ComRange | None = None,
    standing: Iterable[Load] = (),
) -> WorstCase:
    """Compute the smallest R(p, e) by engine ``limit`` over uncertain friction, masses and centres of mass.

    ``mu_range`` is a relative width (0.2 means ± 20 %) or an interval (low, high) for all touching pairs, or a dict of
    intervals by the names of the two bodies. ``mass_range`` is a relative width for all movable bodies, or a dict of
    intervals (low, high) [kg] by body name. ``com_range`` is a half width [m] for all movable bodies, or a dict of half
    widths (3,) [m] by body name; the box lies along the world axes around the centre of mass. Anything that is not
    named is taken as known. Poses, contacts and points are held in place. ``points``, ``directions`` and ``standing``
    have the same meaning as in ``robustness``.

    The answer is exact: it uses the lower end of every μ and all corners of the masses and centres of mass;
    ``guarantee`` says why this suffices. The number of corners, and with it the time, doubles with every uncertain
    value, except for shifts of a centre of mass along gravity. Raises HoldfastError if there are more than 4,096
    corners, and SceneError for ``mu_range`` where faces have a cohesion: pulled, they hold less with more friction.
    """
    assembly = checked_assembly(assembly)
    where = f"worst case of {body!r}"
    if mu_range is not None and assembly.scene.friction.cohesion:  # a pair that is pulled holds less with more friction
        refuse_joined(assembly, f"{where}: mu_range", "leave out cohesion or mu_range: a tension alone is taken")
    loads = checked_loads(standing)
    nominal = robustness(assembly, body, points, directions, standing=loads, engine=CERTAIN_ENGINE)
    low = {pair: ends[0] for pair, ends in friction_intervals(assembly, mu_range, where).items()}
    rough = assembly if mu_range is None else assembly.with_friction(low)
    near = next((group for group in rough.groups if body in group), ())  # other groups do not affect the answer
    masses = {name: ends for name, ends in mass_intervals(rough, mass_range, where).items() if name in near}
    coms = {name: half for name, half in com_boxes(rough, com_range, where).items() if name in near}
    columns = push_columns(rough, body_number(rough, body), nominal.points, nominal.directions)
    engine = engine_of(CERTAIN_ENGINE)
    found = WORST_CASES.of(engine, engine=CERTAIN_ENGINE, where=where).weakest(
        rough,
        total_wrench(rough, loads),
        columns,
        masses=masses,
        coms=coms,
        prepare=lambda load: prepared(engine, rough, load),
        where=where,
    )
    notes = (
        *nominal.notes,
        *width_notes(assembly, mu_range),
        *unchecked_limits(assembly.bodies),
    )  # the corners do not ask who is crushed
    return WorstCase(
        answers=replace(found.answers, verdict=nominal.verdict, notes=notes),
        body=body,
        nominal=nominal.force,
        nominal_status=nominal.status,
        mu=Table(low),
        masses=objects([Table(found.corners[k].masses) for k in found.corner]),
        coms=objects([Table(found.corners[k].coms) for k in found.corner]),
        corners=len(found.corners),
        guarantee=found.guarantee,
    )
