"""Sample the robustness under uncertain poses, friction and faces: quantiles, and how many samples do not stand."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from holdfast.assembly.assembly import FIXED, Assembly, checked_pose_sigma
from holdfast.base.archive import archived, to_dict
from holdfast.base.arrays import Bool, Float, Int, Objects, checked, checked_number, frozen, objects
from holdfast.base.errors import HoldfastError, HoldfastWarning, message
from holdfast.base.field_hints import hinting
from holdfast.base.kinds import check_kinds, shaped
from holdfast.base.progress import report
from holdfast.base.public import Summary, number
from holdfast.base.text import quoted
from holdfast.contacts.tolerances import plain_gap
from holdfast.engines.amendments.absent_contacts import Absences
from holdfast.engines.answers import Answers, Undecided, joined
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.queries.imperfect_bounds import covering
from holdfast.queries.intervals import friction_intervals
from holdfast.queries.push import Robustness, robustness
from holdfast.queries.request import (
    DEFAULT_ENGINE,
    EngineChoice,
    Load,
    body_number,
    checked_assembly,
    checked_loads,
    engine_of,
    push_columns,
    total_wrench,
)
from holdfast.queries.result import SHOWN, Result, amount, places_of
from holdfast.queries.uncertain import Uncertain
from holdfast.scene.scene import Scene

EVEN = 0.5  # probability that an uncertain contact is absent from a sample, if poses are not sampled


@archived
@shaped(points="n 3", directions="n 3", nominal="n", nominal_status="n")
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RobustnessUnder(Result):
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

    ``answers`` holds the rows of all samples, one sample after another, without mechanisms.
    """

    body: str
    points: Float
    directions: Float
    nominal: Float
    nominal_status: Objects
    stands: float
    undecided: float
    samples: int
    seed: int

    @property
    def force(self) -> Float:
        """The largest force (samples, n) [N] before anything moves."""
        return self.answers.force.reshape(self.samples, -1)

    @property
    def status(self) -> Objects:
        """The status (samples, n) of each answer: FINITE, INFINITE, UNSTABLE or UNDECIDED."""
        return self.answers.status.reshape(self.samples, -1)

    @property
    def lower(self) -> Float:
        """The lower bounds (samples, n) [N] of the true answers, as far as the engine can promise them."""
        return self.answers.lower.reshape(self.samples, -1)

    @property
    def upper(self) -> Float:
        """The upper bounds (samples, n) [N] of the true answers, as far as the engine can promise them."""
        return self.answers.upper.reshape(self.samples, -1)

    @property
    def undecided_pushes(self) -> Undecided:
        """How many of the pushes on all samples are not known (``count``, ``share``), and why (``reasons``)."""
        return self.answers.undecided

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the samples that were read from a file do not make up the answers."""
        if len(self.answers) != max(self.samples, 0) * len(self.nominal) or self.samples < 1:
            problem = f"{len(self.answers)} answers for {self.samples} samples of {len(self.nominal)} pushes"
            raise HoldfastError(message("robustness under uncertainty", problem, "needs one for each"))
        check_kinds(self.nominal_status, Status, "nominal_status")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        names = (
            *("body", "points", "directions", "force", "status", "nominal", "nominal_status"),
            *("stands", "undecided", "undecided_pushes", "samples", "seed"),
        )
        return self.about() | {name: to_dict(getattr(self, name)) for name in names}

    def summary(self) -> Summary:
        """Summarise the answer by quantiles at the points with the smallest medians."""
        headline = f"{self.samples} samples of {len(self.nominal):,} pushes on {self.body}: {self.stands:.0%} stand"
        headline = "; ".join([headline, *filter(None, [self.undecided_pushes.text])])
        places, low, middle = places_of(self.points), self.quantile(0.05), self.median
        known_low, known_middle = self.known(0.05), self.known(0.5)
        rows = [
            [
                places[k],
                amount(self.nominal_status[k], self.nominal[k], "N"),
                number(middle[k], "N") if known_middle[k] else "?",
                number(low[k], "N") if known_low[k] else "?",
            ]
            for k in np.lexsort((middle, ~known_middle))[:SHOWN].tolist()
        ]
        return Summary(headline, self.facts(), ("where", "nominal", "median", "5 % quantile"), rows, self.notes)

    def __float__(self) -> float:
        """Raise HoldfastError: a push has a force in each sample."""
        problem = f"it holds the forces of {self.samples:,} samples"
        raise HoldfastError(message("float() of RobustnessUnder", problem, "ask .median or .quantile(0.05)"))

    def quantile(self, q: ArrayLike) -> Float:
        """Return the force (n,) [N] that at least a share 1 - ``q`` of the samples reach; ``q`` = 0 gives the smallest.

        Several shares ``q`` (k,) give forces (k, n).

        It is always the force of one of the samples and is never interpolated. Samples that do not stand count as 0,
        and so do undecided ones, because no force is certain there; ``known(q)`` is False where the quantile is such a
        0. Raises HoldfastError if ``q`` is not between 0 and 1.
        """
        return frozen(np.sort(self.force, axis=0)[self._number(q)])

    def known(self, q: ArrayLike) -> Bool:
        """Return for each point (n,) whether ``quantile(q)`` is an answer; several shares ``q`` (k,) give (k, n).

        It is False where the quantile falls on an undecided sample, whose force 0 is no answer. Raises HoldfastError if
        ``q`` is not between 0 and 1.
        """
        decided = self.answers.decided.reshape(self.samples, -1)
        zeros = (decided & (self.force == 0)).sum(axis=0)  # decided zeros count as smaller than undecided ones
        number = self._number(q)[..., None]
        return np.asarray((number < zeros) | (number >= zeros + (~decided).sum(axis=0)))

    def _number(self, q: ArrayLike) -> Int:
        """Return the ranks () or (k,) of the samples whose forces are the quantiles; rank 0 is the smallest force."""
        where = "quantile: q"
        several = isinstance(q, list | tuple) or (isinstance(q, np.ndarray) and q.ndim > 0)
        shares = checked(q, (None,), where) if several else np.asarray(checked_number(q, where))
        wrong = shares[(shares < 0) | (shares > 1)]
        if wrong.size:
            raise HoldfastError(message(where, f"is {wrong[0]:g}", "needs shares from 0 to 1"))
        return np.asarray(shares * (self.samples - 1), dtype=np.int64)

    @property
    def median(self) -> Float:
        """The median force (n,) [N], that is the quantile for q = 0.5."""
        return self.quantile(0.5)


@dataclass(frozen=True, eq=False)
class _Spread:
    """What is uncertain about ``assembly``.

    ``deviation`` holds the standard deviations [m, deg] of the poses, and ``friction`` the intervals of the friction
    coefficients; either is None if it is known. ``absences`` decides which uncertain contacts may be left out.
    """

    assembly: Assembly
    deviation: tuple[float, float] | None
    friction: dict[tuple[str, str], tuple[float, float]] | None
    absences: Absences

    def __call__(self, rng: np.random.Generator) -> tuple[Assembly, Float, Float]:
        """Draw one sample, with the shifts (J, 3) [m] and rotations (J, 3, 3) of its movable bodies.

        The same random numbers are drawn whether or not they are used. So the sampled friction is the same with known
        and with uncertain poses, and vice versa. Each uncertain contact takes one more number.
        """
        level, deviates = rng.random(), rng.standard_normal((len(self.assembly.movable), 6))
        metres, degrees = self.deviation or (0.0, 0.0)
        shifts = metres * deviates[:, :3]
        turns = Rotation.from_rotvec(np.radians(degrees) * deviates[:, 3:]).as_matrix().reshape(-1, 3, 3)
        chances = dict(zip(self.absences.uncertain, rng.random(len(self.absences.uncertain)), strict=True))
        if self.deviation is None:
            absent = self.absences.largest([k for k, chance in chances.items() if chance < EVEN])
            sample = self.assembly.without_interfaces(absent) if absent else self.assembly
        else:
            sample = self._present(self._moved(shifts, turns))
        if self.friction is not None:
            sample = sample.with_friction({p: a + level * (b - a) for p, (a, b) in self.friction.items()})
        return sample, shifts, turns

    def _moved(self, shifts: Float, turns: Float) -> Assembly:
        """Move the bodies and detect their contacts again, but only between pairs that touch in the given assembly."""
        given = self.assembly
        poses = {}
        for k, body in enumerate(given.movable):
            pose = np.array(body.pose)
            pose[:3, :3] = turns[k] @ pose[:3, :3]
            pose[:3, 3] = given.com[k] + shifts[k] + turns[k] @ (pose[:3, 3] - given.com[k])
            poses[body.name] = pose
        metres, degrees = self.deviation or (0.0, 0.0)  # the relative deviation of two bodies is √2 times that of one
        wider = replace(given, tolerances=given.tolerances.widened(np.sqrt(2) * metres, np.sqrt(2) * degrees))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", HoldfastWarning)  # the notes count the overlaps
            found = wider.moved(poses)
        known = {frozenset(interface.bodies) for interface in given.interfaces}
        interfaces = tuple(i for i in found.interfaces if frozenset(i.bodies) in known)
        return replace(found, interfaces=interfaces)

    def _present(self, sample: Assembly) -> Assembly:
        """Remove the uncertain contacts that are open in a sample, except those without which bodies would fall.

        A contact is open if its bodies are further apart than the default gap, even if they are within the wider gap of
        the sample.
        """
        if not self.absences.uncertain:
            return sample
        there = {frozenset(interface.bodies): interface.separation for interface in sample.interfaces}
        open_ = []
        for k in self.absences.uncertain:
            pair = self.assembly.interfaces[k].bodies
            apart = there.get(frozenset(pair), np.inf)
            a, b = (sample.scene.body(name) for name in pair)
            if apart is not None and apart > plain_gap(a, b) + a.shape.surface.sagitta + b.shape.surface.sagitta:
                open_.append(k)
        absent = {frozenset(self.assembly.interfaces[k].bodies) for k in self.absences.largest(open_)}
        gone = [k for k, interface in enumerate(sample.interfaces) if frozenset(interface.bodies) in absent]
        return sample.without_interfaces(gone) if gone else sample


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
    """Compute R(p, e) in samples of uncertain poses, friction and faces.

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
    thickness of a body. See docs/uncertainty.md.
    """
    assembly = checked_assembly(assembly)
    where = f"robustness of {body!r} under uncertainty"
    asked = Uncertain() if uncertain is None else uncertain
    if not isinstance(asked, Uncertain):
        raise HoldfastError(message(f"{where}: uncertain", f"is {quoted(asked)}", "needs holdfast.Uncertain(...)"))
    count = asked.samples
    method, loads = engine_of(engine), checked_loads(standing)
    spread = _Spread(
        assembly,
        None if asked.pose_sigma is None else _deviation(assembly, asked.pose_sigma, where),
        None if asked.mu_range is None else friction_intervals(assembly, asked.mu_range, where),
        Absences(method, assembly, total_wrench(assembly, loads)),
    )
    faces = asked.faces
    covers = None if faces is None else covering(faces, method, assembly)
    nominal = robustness(assembly, body, points, directions, standing=loads, engine=method)
    rng = np.random.default_rng(asked.seed)
    found = []
    for k in range(count):
        report("samples", k, count)
        sampled = method if covers is None else covers.sample(k)
        found.append(_answered(spread(rng), assembly, body, nominal, loads, sampled))
    report("samples", count, count)
    answers = [answer for answer, _ in found]
    verdicts = [answer.verdict.status for answer in answers]
    overlapping = 0 if spread.deviation is None else sum(overlaps for _, overlaps in found)
    notes = (*nominal.notes, *_sample_notes(answers, overlapping))
    table = joined([nominal.answers.rows(slice(0)), *answers])
    return RobustnessUnder(
        answers=replace(table, notes=notes, lower_bound=nominal.lower_bound, upper_bound=nominal.upper_bound),
        body=body,
        points=nominal.points,
        directions=nominal.directions,
        nominal=nominal.force,
        nominal_status=nominal.status,
        stands=verdicts.count(Status.STABLE) / count,
        undecided=verdicts.count(Status.UNDECIDED) / count,
        samples=count,
        seed=asked.seed,
    )


def _sample_notes(answers: Sequence[Answers], overlapping: int) -> Iterator[str]:
    """Yield notes on the answers of all samples; ``overlapping`` counts the samples with overlapping bodies."""
    if overlapping:
        share = f"{overlapping} of {len(answers)} samples have bodies that overlap by more than the tolerance"
        yield f"{share}: contacts there may be missing, which lowers their forces"
    unknown = [answer.undecided.reasons[0] for answer in answers if answer.undecided.count]
    if unknown:
        yield f"{len(unknown)} of {len(answers)} samples have undecided pushes; the first: {unknown[0]}"


def _answered(
    drawn: tuple[Assembly, Float, Float],
    given: Assembly,
    body: str,
    nominal: Robustness,
    standing: Iterable[Load],
    engine: Engine,
) -> tuple[Answers, bool]:
    """Answer the pushes of ``nominal`` on one sample, and return whether its bodies overlap.

    Points and ``standing`` loads move with their bodies.
    """
    sample, shifts, turns = drawn
    points, loads = _attached(given, sample, body, nominal.points, standing, shifts, turns)
    state, number = prepared(engine, sample, total_wrench(sample, loads)), body_number(sample, body)
    columns = push_columns(sample, number, points, nominal.directions)
    verdict = state.verdict_on([] if number == FIXED else [number])
    if verdict.status is Status.STABLE:
        found = state.load_factor(columns)
    else:  # a sample that may not stand counts as 0, whatever the push
        found = Answers.not_standing(len(points), engine=engine.name, claim=engine.claim, verdict=verdict)
    return replace(found, mechanism=objects([None] * len(found))), bool(sample.overlaps)


def _attached(
    given: Assembly, sample: Assembly, body: str, points: Float, loads: Iterable[Load], shifts: Float, turns: Float
) -> tuple[Float, list[Load]]:
    """Return points (n, 3) [m] and loads of the given assembly, moved along with the bodies of the sample."""
    if sample.scene.bodies is given.scene.bodies:
        return points, list(loads)

    def moved_along(name: str, place: Float) -> Float:
        k = given.index[name]
        if k == FIXED:
            return place
        return np.asarray(given.com[k] + shifts[k] + (place - given.com[k]) @ turns[k].T)

    return moved_along(body, points), [
        replace(load, point=moved_along(load.body, np.asarray(load.point))) for load in loads
    ]


def _deviation(assembly: Assembly, pose_sigma: float | tuple[float, float], where: str) -> tuple[float, float]:
    metres, degrees = checked_pose_sigma(pose_sigma, where)
    if not assembly.detected:
        problem = f"pose_sigma = {pose_sigma!r}, but the interfaces of the assembly were given"
        remedy = "they cannot be detected again for moved bodies: vary mu_range only, or assemble without interfaces"
        raise HoldfastError(message(where, problem, remedy))
    thin = min(assembly.movable, key=lambda b: b.shape.surface.thickness, default=None)
    if thin is not None and metres > thin.shape.surface.thickness:
        problem = (
            f"pose_sigma = {metres:g} m, but body {thin.name!r} is only {thin.shape.surface.thickness:.3g} m thick"
        )
        raise HoldfastError(message(where, problem, "needs metres, and less than the thickness of every movable body"))
    return metres, degrees
