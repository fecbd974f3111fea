"""Samples of an assembly with uncertain poses, friction, masses and faces, and answers to loads on each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import FIXED, Assembly, checked_pose_sigma
from holdfast.base.arrays import Bool, Float, Int, Objects, checked, checked_number, frozen, objects
from holdfast.base.errors import HoldfastError, message
from holdfast.base.progress import report
from holdfast.base.public import Summary, column, number
from holdfast.contacts.tolerances import plain_gap
from holdfast.engines.answers import Answers, joined
from holdfast.engines.bearing import unchecked_limits
from holdfast.engines.contract import Engine
from holdfast.engines.doubts.doubtful_contacts import Absences
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.queries.lower_bounds import Covering, covering
from holdfast.queries.request import Load, checked_options, quiet, total_wrench
from holdfast.queries.result import SHOWN, Columns, Result, amount
from holdfast.queries.uncertain import Pair, Uncertain, friction_intervals, mass_intervals, width_notes

EVEN = 0.5  # probability that an uncertain contact is absent from a sample, if poses are not sampled


@dataclass(frozen=True, eq=False)
class Sample:
    """One sample of the assembly ``given``: its ``assembly``, and by how much each movable body was moved in it.

    ``shifts`` (J, 3) [m] are those of the centres of mass, about which the bodies are rotated by ``turns`` (J, 3, 3).
    """

    given: Assembly
    assembly: Assembly
    shifts: Float
    turns: Float

    def along(self, name: str, points: Float) -> Float:
        """Return points (n, 3) or (3,) [m] of a body of the given assembly, moved along with it."""
        k = self.given.index[name]
        if k == FIXED:
            return points
        return np.asarray(self.given.com[k] + self.shifts[k] + (points - self.given.com[k]) @ self.turns[k].T)

    def loads(self, loads: Iterable[Load]) -> list[Load]:
        """Return loads on the given assembly whose points are moved along with their bodies."""
        return [replace(load, point=self.along(load.body, np.asarray(load.point))) for load in loads]


@dataclass(frozen=True, eq=False)
class Sampler:
    """What is uncertain about ``assembly`` under ``standing`` loads, checked, and the ``engine`` that answers.

    ``deviation`` holds the standard deviations [m, deg] of the poses, and ``friction`` and ``masses`` the intervals of
    coefficients and of masses [kg]; each is None if it is known. ``absences`` decides which uncertain contacts may be
    left out, and ``covers`` makes imperfect faces. ``notes`` say what was understood.
    """

    assembly: Assembly
    engine: Engine
    standing: Sequence[Load]
    deviation: tuple[float, float] | None
    friction: dict[Pair, tuple[float, float]] | None
    masses: dict[str, tuple[float, float]] | None
    absences: Absences
    covers: Covering | None
    samples: int
    seed: int
    notes: tuple[str, ...]

    def drawn(self) -> Iterator[Sample]:
        """Draw the samples.

        The same random numbers are drawn whether or not they are used. So the sampled friction is the same with known
        and with uncertain poses, and vice versa. Each uncertain contact takes one more number. Masses have a stream of
        their own.
        """
        from scipy.spatial.transform import Rotation  # only here, as it takes long to import

        rng, masses = np.random.default_rng(self.seed), np.random.default_rng(self.seed).spawn(1)[0]
        uncertain = self.absences.uncertain
        for _ in range(self.samples):
            level, deviates = rng.random(), rng.standard_normal((len(self.assembly.movable), 6))
            metres, degrees = self.deviation or (0.0, 0.0)
            shifts = metres * deviates[:, :3]
            turns = Rotation.from_rotvec(np.radians(degrees) * deviates[:, 3:]).as_matrix().reshape(-1, 3, 3)
            chances = dict(zip(uncertain, rng.random(len(uncertain)), strict=True))
            if self.deviation is None:
                absent = self.absences.largest([k for k, chance in chances.items() if chance < EVEN])
                sample = self.assembly.without_interfaces(absent) if absent else self.assembly
            else:
                sample = self._present(self._moved(shifts, turns))
            if self.friction is not None:
                sample = sample.with_friction({p: a + level * (b - a) for p, (a, b) in self.friction.items()})
            if self.masses is not None:
                levels = masses.random(len(self.masses)).tolist()
                ends = zip(self.masses.items(), levels, strict=True)
                sample = sample.with_masses({name: a + at * (b - a) for (name, (a, b)), at in ends})
            yield Sample(self.assembly, sample, shifts, turns)

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
        with quiet():
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

    def fields(self, nominal: Columns, bodies: Iterable[int], columns: Callable[[Sample], Float]) -> dict[str, Any]:
        """Answer the loads in every sample, and return the fields of a Sampled result.

        ``nominal`` answers the n loads on the assembly as it was given. ``columns`` returns the load columns (6J, n) of
        a sample. A sample in which ``bodies``, by number, may not stand counts as 0, whatever the load.
        """
        found, overlapping, numbers = [], 0, list(bodies)
        for k, sample in enumerate(self.drawn()):
            report("samples", k, self.samples)
            engine = self.engine if self.covers is None else self.covers.sample(k)
            state = prepared(engine, sample.assembly, total_wrench(sample.assembly, sample.loads(self.standing)))
            verdict = state.verdict_on(numbers)
            if verdict.status is Status.STABLE:
                answers = state.load_factor(columns(sample))
            else:
                count = len(nominal.answers)
                answers = Answers.not_standing(count, engine=engine.name, claim=engine.claim, verdict=verdict)
            found.append(replace(answers, mechanism=objects([None] * len(answers))))
            overlapping += bool(sample.assembly.overlaps)
        report("samples", self.samples, self.samples)
        verdicts = [answers.verdict.status for answers in found]
        # samples do not ask who is crushed
        notes = [*nominal.notes, *self.notes, *unchecked_limits(self.assembly.bodies)]
        if overlapping and self.deviation is not None:
            share = f"{overlapping} of {len(found)} samples have bodies that overlap by more than the tolerance"
            notes.append(f"{share}: contacts there may be missing, which lowers their answers")
        unknown = [answers.undecided.reasons[0] for answers in found if answers.undecided.count]
        if unknown:
            notes.append(f"{len(unknown)} of {len(found)} samples have undecided answers; the first: {unknown[0]}")
        table = joined([nominal.answers.rows(slice(0)), *found])
        return {
            "answers": replace(
                table, notes=tuple(notes), lower_bound=nominal.lower_bound, upper_bound=nominal.upper_bound
            ),
            "nominal": nominal.answers.force,
            "nominal_status": nominal.status,
            "stands": verdicts.count(Status.STABLE) / self.samples,
            "undecided": verdicts.count(Status.UNDECIDED) / self.samples,
            "samples": self.samples,
            "seed": self.seed,
        }


def sampler(
    assembly: Assembly, uncertain: Uncertain | None, engine: Engine, standing: Sequence[Load], where: str
) -> Sampler:
    """Return the sampler of what is ``uncertain``: an Uncertain, or None for the existence of contacts alone.

    Raises HoldfastError, with ``where`` in its message, for what this assembly does not allow.
    """
    options = checked_options(uncertain, Uncertain, f"{where}: uncertain")
    return Sampler(
        assembly,
        engine,
        standing,
        None if options.pose_sigma is None else _deviation(assembly, options.pose_sigma, where),
        None if options.mu_range is None else friction_intervals(assembly, options.mu_range, where),
        None if options.mass_range is None else mass_intervals(assembly, options.mass_range, where),
        Absences(engine, assembly, total_wrench(assembly, standing)),
        None if options.faces is None else covering(options.faces, engine, assembly),
        options.samples,
        options.seed,
        width_notes(assembly, options.mu_range),
    )


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


class Sampled(Result):
    """A result with n answers in each of ``samples`` samples of the uncertain quantities.

    ``answers`` holds the rows of all samples, one sample after another, without mechanisms. A subclass says what an
    answer is, and in which unit.
    """

    unit: ClassVar[str] = ""
    place: ClassVar[str] = ""  # title of the column that says which of the n answers a row is about

    nominal: Float = column("n")
    nominal_status: Objects = column("n", of=Status)
    stands: float
    undecided: float
    samples: int
    seed: int

    @property
    def status(self) -> Objects:
        """The status (samples, n) of each answer: FINITE, INFINITE, UNSTABLE or UNDECIDED."""
        return self.answers.status.reshape(self.samples, -1)

    @property
    def lower(self) -> Float:
        """The lower bounds (samples, n) of the true answers, as far as the engine can promise them."""
        return self.answers.lower.reshape(self.samples, -1)

    @property
    def upper(self) -> Float:
        """The upper bounds (samples, n) of the true answers, as far as the engine can promise them."""
        return self.answers.upper.reshape(self.samples, -1)

    def checked_after_load(self) -> None:
        """Raise HoldfastError if the samples that were read from a file do not make up the answers."""
        if len(self.answers) != max(self.samples, 0) * len(self.nominal) or self.samples < 1:
            problem = f"{len(self.answers)} answers for {self.samples} samples of {len(self.nominal)}"
            raise HoldfastError(message("answer under uncertainty", problem, "needs one for each"))

    def weakest(self, headline: str, places: Objects) -> Summary:
        """Return the summary of the answer under a ``headline``: quantiles of its weakest rows, by their medians.

        ``places`` (n,) are the names of all rows. This is what ``summary`` of each kind of answer returns.
        """
        unit = self.unit
        low, middle = self.quantile(0.05), self.median
        known_low, known_middle = self.known(0.05), self.known(0.5)
        rows = [
            [
                places[k],
                amount(self.nominal_status[k], self.nominal[k], unit),
                number(middle[k], unit) if known_middle[k] else "?",
                number(low[k], unit) if known_low[k] else "?",
            ]
            for k in np.lexsort((middle, ~known_middle))[:SHOWN].tolist()
        ]
        whole = f"{headline}: {self.stands:.0%} stand"
        whole = "; ".join([whole, *filter(None, [self.answers.undecided.text])])
        return Summary(whole, self.facts(), (self.place, "nominal", "median", "5 % quantile"), rows, self.notes)

    def __float__(self) -> float:
        """Raise HoldfastError: there is an answer in each sample."""
        problem = f"it holds the answers of {self.samples:,} samples"
        raise HoldfastError(message(f"float() of {type(self).__name__}", problem, "ask .median or .quantile(0.05)"))

    def quantile(self, q: ArrayLike) -> Float:
        """Return the answer (n,) that at least a share 1 - ``q`` of the samples reach; ``q`` = 0 gives the smallest.

        Several shares ``q`` (k,) give answers (k, n).

        It is always the answer of one of the samples and is never interpolated. Samples that do not stand count as 0,
        and so do undecided ones, because nothing is certain there; ``known(q)`` is False where the quantile is such a
        0. Raises HoldfastError if ``q`` is not between 0 and 1.
        """
        return frozen(np.sort(self._values, axis=0)[self._rank(q)])

    def known(self, q: ArrayLike) -> Bool:
        """Return for each of the n answers whether ``quantile(q)`` is one; several shares ``q`` (k,) give (k, n).

        It is False where the quantile falls on an undecided sample, whose 0 is no answer. Raises HoldfastError if ``q``
        is not between 0 and 1.
        """
        decided = self.answers.decided.reshape(self.samples, -1)
        zeros = (decided & (self._values == 0)).sum(axis=0)  # decided zeros count as smaller than undecided ones
        rank = self._rank(q)[..., None]
        return np.asarray((rank < zeros) | (rank >= zeros + (~decided).sum(axis=0)))

    @property
    def median(self) -> Float:
        """The median answer (n,), that is the quantile for q = 0.5."""
        return self.quantile(0.5)

    @property
    def _values(self) -> Float:
        """The answers (samples, n)."""
        return self.answers.force.reshape(self.samples, -1)

    def _rank(self, q: ArrayLike) -> Int:
        """Return the ranks () or (k,) of the samples whose answers are the quantiles; rank 0 is the smallest answer."""
        where = "quantile: q"
        several = isinstance(q, list | tuple) or (isinstance(q, np.ndarray) and q.ndim > 0)
        shares = checked(q, (None,), where) if several else np.asarray(checked_number(q, where))
        wrong = shares[(shares < 0) | (shares > 1)]
        if wrong.size:
            raise HoldfastError(message(where, f"is {wrong[0]:g}", "needs shares from 0 to 1"))
        return np.asarray(shares * (self.samples - 1), dtype=np.int64)
