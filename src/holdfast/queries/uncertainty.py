"""The robustness under uncertain values: in samples of them, with quantiles, and at its smallest over all of them.

At its smallest, what holds is asked at the ends of all ranges: stiff contacts hold neither the more with more friction
nor the less with more weight, so that is no proof. Up to where an equilibrium exists is least at such an end, which is
proved.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import ClassVar

from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.arrays import Float, Objects, objects
from holdfast.base.errors import hinting
from holdfast.base.progress import reported
from holdfast.base.public import Of, Summary, column
from holdfast.base.values import Table
from holdfast.engines.answers import Undecided
from holdfast.engines.bearing import unchecked_limits
from holdfast.engines.contract import WORST_CASES, Corner
from holdfast.engines.groups import prepared
from holdfast.engines.limit_engine import change_at, corners_of, least_of
from holdfast.engines.verdict import Status
from holdfast.queries.push import robustness
from holdfast.queries.request import (
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    body_number,
    checked_assembly,
    checked_loads,
    engine_for,
    engine_of,
    push_columns,
    total_wrench,
)
from holdfast.queries.result import Forces, amount, least, places_of
from holdfast.queries.sampler import Sample, Sampled, sampler
from holdfast.queries.uncertain import (
    ComRange,
    MassRange,
    MuRange,
    Pair,
    Uncertain,
    com_boxes,
    friction_intervals,
    mass_intervals,
    width_notes,
)
from holdfast.scene.scene import Scene

GUARANTEE = (
    "not a proof: what holds by engine {engine} was asked at {count} combinations of values, those given and the ends "
    "of all ranges (friction: all low or all high)"
)


class RobustnessUnder(Sampled):
    """The largest push at each of n points, in each of ``samples`` samples of the uncertain quantities.

    ``force`` (samples, n) [N] is 0 where a sample does not stand, and inf where no push moves anything. Where the
    sample or the push is undecided, the 0 is no answer. ``status`` (samples, n) distinguishes these cases, as in
    Robustness, and ``undecided_pushes`` counts the undecided ones. ``lower`` and ``upper`` (samples, n) [N] bound the
    true answer of each sample.

    ``stands`` is the share of samples that certainly stand (STABLE), and ``undecided`` the share that may stand; the
    remaining samples do not stand. ``nominal`` (n,) [N] is R of the assembly as it was given, without uncertainty, and
    ``nominal_status`` (n,) is its status. ``points`` (n, 3) [m], the unit ``directions`` (n, 3) and ``verdict`` also
    belong to that assembly, in the world frame. ``seed`` is the seed of the samples, and ``notes`` are the
    simplifications on which the answer depends.
    """

    unit: ClassVar[str] = "N"
    place: ClassVar[str] = "where"

    body: str
    points: Float = column("n 3")
    directions: Float = column("n 3")

    plain = "body points directions force status nominal nominal_status stands undecided undecided_pushes samples seed"

    force = Of[Float]("_values", "The largest force (samples, n) [N] before anything moves.")
    undecided_pushes = Of[Undecided](
        "answers.undecided", "How many of the pushes on all samples are not known (``count``, ``share``), and why."
    )

    def summary(self) -> Summary:
        """Summarise the answer by quantiles at the points with the smallest medians."""
        headline = f"{self.samples} samples of {len(self.nominal):,} pushes on {self.body}"
        return self.weakest(headline, places_of(self.points))


@hinting(uncertain=Uncertain)
def robustness_under(
    assembly: Assembly | Scene,
    body: str,
    points: ArrayLike,
    directions: ArrayLike,
    uncertain: Uncertain | None = None,
    *,
    standing: Iterable[Load] = (),
    engine: EngineChoice = DEFAULT_ENGINE,
) -> RobustnessUnder:
    """Compute R(p, e) in samples of uncertain poses, friction, masses and faces.

    ``uncertain`` says what is uncertain and how many samples are drawn, see Uncertain. By default, only the existence
    of uncertain contacts is. ``body``, ``points``, ``directions``, ``standing`` and ``engine`` have the same meaning as
    in ``robustness``.

    Points and standing loads move with their body; directions, forces and moments stay fixed in the world. The contacts
    of each sample are detected again, between the pairs that touch in ``assembly``, with a tolerance that allows for
    the deviations. Gaps and overlaps within this tolerance are accepted; the outline, place and tilt of the contacts
    change.

    Uncertain contacts (see ``Interface.certain``) are present only in some samples, unless something would fall without
    them. With ``pose_sigma``, they are present where the sampled poses close them to within the default gap; otherwise
    each is present in half of the samples.

    Raises HoldfastError if ``pose_sigma`` is given for an assembly whose interfaces were given, or exceeds the
    thickness of a body. See docs/howto/uncertainty.md.
    """
    assembly = checked_assembly(assembly)
    method, loads = engine_of(engine), checked_loads(standing)
    samples = sampler(assembly, uncertain, method, loads, f"robustness of {body!r} under uncertainty")
    nominal = robustness(assembly, body, points, directions, standing=loads, engine=method)
    number = body_number(assembly, body)

    def columns(sample: Sample) -> Float:
        return push_columns(sample.assembly, number, sample.along(body, nominal.points), nominal.directions)

    return RobustnessUnder(
        body=body,
        points=nominal.points,
        directions=nominal.directions,
        **samples.fields(nominal, [] if number == FIXED else [number], columns),
    )


class WorstCase(Forces):
    """The smallest R at each of n points over all values of the uncertain quantities.

    ``force`` (n,) [N] has the bounds ``lower`` and ``upper`` and a ``status`` (n,) as in Robustness; ``lower`` is the
    least of all corners. With the ``claim`` *holds* that is what everything held where it was asked, and ``guarantee``
    says where. With the claim *exists* it is proved for the whole region, of the existence of an equilibrium.

    The status is UNSTABLE where the assembly does not stand at some corner of the uncertain region. It is UNDECIDED
    where the answer at a corner is; the force 0 is no answer then. ``nominal`` (n,) [N] is R without uncertainty, with
    ``nominal_status`` (n,) and ``verdict``.

    ``masses`` (n,) and ``coms`` (n,) hold for each point the masses [kg] and centres of mass [m, world frame] at the
    corner where it is weakest, by the name of the uncertain body. ``mu`` holds the friction coefficients at the corner
    of the weakest of all points, by pair of bodies. ``corners`` is the number of corners that were solved.
    """

    body: str
    nominal: Float = column("n")
    nominal_status: Objects = column("n", of=Status)
    mu: Table[Pair, float]
    masses: Objects = column("n", of=Mapping[str, float])
    coms: Objects = column("n", of=Mapping[str, tuple[float, float, float]])
    corners: int
    guarantee: str

    plain = "body corners guarantee force lower upper status moving mode nominal nominal_status mu masses coms"

    def summary(self) -> Summary:
        """Summarise the answer by its weakest points."""
        headline = f"{len(self.force):,} pushes on {self.body} at {self.corners:,} corners: {least(self.answers, 'N')}"
        nominal = zip(self.nominal_status, self.nominal, strict=True)
        places = objects([f"nominal {amount(status, value, 'N')}" for status, value in nominal])
        return self.table(headline, places)

    def facts(self) -> list[tuple[str, str]]:
        """Return what applies to the whole table as (name, text) pairs, and what was proved or asked."""
        return [*super().facts(), ("guarantee", self.guarantee)]


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
    exists: bool = False,
) -> WorstCase:
    """Compute the smallest R(p, e) over uncertain friction, masses and centres of mass.

    ``mu_range`` is a relative width (0.2 means ± 20 %) or an interval (low, high) for all touching pairs, or a dict of
    intervals by the names of the two bodies. ``mass_range`` is a relative width for all movable bodies, or a dict of
    intervals (low, high) [kg] by body name. ``com_range`` is a half width [m] for all movable bodies, or a dict of half
    widths (3,) [m] by body name; the box lies along the world axes around the centre of mass. Anything that is not
    named is taken as known. Poses, contacts and points are held in place. ``points``, ``directions`` and ``standing``
    have the same meaning as in ``robustness``.

    By default it is the least of the default engine's answers with the values as given and at all corners: all pairs at
    the lower or all at the upper ends of μ, with all ends of masses and centres of mass. Take ``lower``. In between
    less may hold, though that is seldom seen: ``guarantee`` says what was asked. With ``exists`` it is exact, but for
    the existence of an equilibrium, which need not come about: it uses the lower end of every μ and all other corners.

    The number of corners, and with it the time, doubles with every uncertain value, except for shifts of a centre of
    mass along gravity. Raises HoldfastError if there are more than 4,096 corners, and SceneError for ``mu_range`` where
    faces have a cohesion (pulled, they hold less with more friction) and for what is held, unless with ``exists``.
    """
    assembly = checked_assembly(assembly)
    where = f"worst case of {body!r}"
    if mu_range is not None and assembly.scene.friction.cohesion:  # a pair that is pulled holds less with more friction
        refuse_joined(assembly, f"{where}: mu_range", "leave out cohesion or mu_range: a tension alone is taken")
    engine, loads = engine_for(assembly, where, exists=exists), checked_loads(standing)
    nominal = robustness(assembly, body, points, directions, standing=loads, engine=engine)
    intervals = friction_intervals(assembly, mu_range, where)
    near = next((group for group in assembly.groups if body in group), ())  # other groups do not affect the answer
    masses = {name: ends for name, ends in mass_intervals(assembly, mass_range, where).items() if name in near}
    coms = {name: half for name, half in com_boxes(assembly, com_range, where).items() if name in near}
    wrench = total_wrench(assembly, loads)
    W = push_columns(assembly, body_number(assembly, body), nominal.points, nominal.directions)
    ends = [{pair: mu[k] for pair, mu in intervals.items()} for k in ((0,) if exists or mu_range is None else (0, 1))]
    rough = [(end, assembly if mu_range is None else assembly.with_friction(end)) for end in ends]
    if exists:
        mu, roughest = rough[0]
        prove, prepare = WORST_CASES.of(engine, engine=engine.name, where=where), partial(prepared, engine, roughest)
        proved = prove.weakest(roughest, wrench, W, masses=masses, coms=coms, prepare=prepare, where=where)
        answers, worst, guarantee = proved.answers, proved.corner, proved.guarantee
        cases = [(mu, corner) for corner in proved.corners]
    else:
        cases_to_ask = [
            (mu, there, corner) for mu, there in rough for corner in corners_of(assembly, masses, coms, where)
        ]
        tables = (
            prepared(engine, there, wrench + change_at(assembly, corner)).load_factor(W)
            for _, there, corner in reported("worst case", cases_to_ask)
        )
        answers, worst = least_of(chain(tables, (nominal.answers,)), "lower")
        cases = [*((mu, corner) for mu, _, corner in cases_to_ask), _as_given(assembly, masses, coms, where)]
        guarantee = GUARANTEE.format(engine=engine.name, count=len(cases))
    mu, _ = cases[worst[int(answers.ranking[0])]]
    # the corners do not ask who is crushed
    notes = (*nominal.notes, *width_notes(assembly, mu_range), *unchecked_limits(assembly.bodies))
    return WorstCase(
        answers=replace(answers, verdict=nominal.verdict, notes=notes),
        body=body,
        nominal=nominal.force,
        nominal_status=nominal.status,
        mu=Table(mu),
        masses=objects([Table(cases[k][1].masses) for k in worst]),
        coms=objects([Table(cases[k][1].coms) for k in worst]),
        corners=len(cases),
        guarantee=guarantee,
    )


def _as_given(
    assembly: Assembly, masses: Iterable[str], coms: Iterable[str], where: str
) -> tuple[dict[Pair, float], Corner]:
    """Return the friction of all pairs, and the masses and centres of these bodies, as they were given."""
    given = {pair: mu for pair, (mu, _) in friction_intervals(assembly, None, where).items()}
    centres = {name: assembly.com[assembly.index[name]].tolist() for name in coms}
    own = {name: float(assembly.mass[assembly.index[name]]) for name in masses}
    return given, Corner(own, {name: (x, y, z) for name, (x, y, z) in centres.items()})
