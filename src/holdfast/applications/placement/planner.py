"""Plan placements by the robustness of the scene, after Nadeau & Kelly, Sec. VII-A.

1. One to three points of the scene are chosen at random, weighted by the pushes that they withstand. 2. A face of the
object is laid on them with opposed normals, with the centre of mass between the points. 3. The object is lowered until
it rests (``lowering``). 4. Overlap, supports, region, orientation and the way in are checked, and then whether
everything stands (``checks``). 5. Several such poses are compared by the pushes that the object and its supports
withstand and by the room around it (``rating``), and the best few are shifted to where there is more room (``refine``).

The planner of the paper's reference [16] was not available. The steps are those that Sec. VII-A describes; the details
are our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.applications.placement.checks import FALLS, OVERLAPS, Checks
from holdfast.applications.placement.comparing import Clock, Compared, Trials, compared
from holdfast.applications.placement.conditions import ATTEMPTS, CANDIDATES, Options
from holdfast.applications.placement.margins import normals_into
from holdfast.applications.placement.rating import UNASKED, least_push, unasked_map
from holdfast.applications.placement.result import Candidate, Placement
from holdfast.applications.placement.support import Proposals, SupportPoints, scene_map, support_points, unmapped_points
from holdfast.applications.resting_poses import Face, StandingFaces, rolls_on
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.caution import doubts
from holdfast.base.progress import OutOfTimeError, report, until
from holdfast.base.text import listed
from holdfast.base.values import Table
from holdfast.engines.answers import Answers, joined_notes
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Status, Verdict
from holdfast.queries.map import RobustnessMap, robustness_map
from holdfast.scene.body import Body

COARSER = 3.0  # spacing of the scene's coarse map, as a multiple of that of the fine one
SPENT = "the time was used up"


@dataclass(frozen=True, eq=False)
class Planner:
    """A planner for one object, one scene and one engine, which can be used with many seeds.

    The maps of the scene and the faces of the object are computed once, when they are first needed. ``confirm`` is a
    second engine that must also find every returned pose stable, or None.
    """

    assembly: Assembly
    body: Body
    engine: Engine
    confirm: Engine | None
    options: Options

    def plan(
        self,
        *,
        seed: int = 0,
        seconds: float | None = None,
        candidates: int = CANDIDATES,
        attempts: int = ATTEMPTS,
    ) -> Placement:
        """Return the best of up to ``candidates`` stable poses.

        The search ends after ``attempts`` attempts. Everything together takes at most about ``seconds``: the limit is
        checked wherever progress is reported, at least every half second.
        """
        clock = Clock.started(seconds)
        try:
            with until(clock.by("search")):
                verdict = self.verdict
                if verdict.status is not Status.STABLE:
                    moving = "" if verdict.mechanism is None else f": {verdict.mechanism.text}"
                    words = "does not stand" if verdict.status is Status.UNSTABLE else "is undecided"
                    reason = f"the scene {words} before anything is put down: {verdict.reason}{moving}"
                    return self._without(verdict.status, reason, Trials(), clock, verdict)
                support = self._support_in(clock)
        except OutOfTimeError:
            verdict = undecided(f"{SPENT} before it was known whether the scene stands")
            return self._without(Status.UNDECIDED, verdict.reason, Trials(), clock, verdict)
        if not len(support.points):
            region = " in the box" if np.isfinite(self.options.box).any() else ""
            return self._nothing(
                Trials(), f"no exposed point of {listed(self.options.supports)} faces up{region}", clock
            )
        if not support.chance.any():
            undecided_in = [found for found in vars(self).get("maps", []) if found.undecided.count]
            unknown = "".join(f"; {found.undecided.text}" for found in undecided_in)
            return self._nothing(Trials(), f"no support point certainly withstands a push{unknown}", clock)
        proposals, ends = Proposals(self.checks, support, self.faces), [clock.by("search"), clock.by("end")]
        search = self._searched(proposals, ends, seed, candidates, attempts)
        if not search.stable:
            spent = SPENT if search.out_of_time else "all attempts were used up"
            return self._nothing(search, f"no stable pose found, {spent}", clock)
        return self._best(search, support, clock)

    def search(
        self,
        *,
        seed: int = 0,
        seconds: float | None = None,
        candidates: int = 1,
        attempts: int = ATTEMPTS,
        mapped: bool = True,
    ) -> Trials:
        """Search for stable poses as ``plan`` does, without rating them.

        The scene must stand. Without ``mapped``, support points are chosen without computing which pushes they
        withstand.
        """
        if mapped:
            proposals = self.proposals
        else:
            proposals = Proposals(self.checks, unmapped_points(self.assembly, self.options), self.faces)
            if not proposals.support.chance.any():
                return Trials()
        return self._searched(proposals, [Clock.started(seconds).by("end")], seed, candidates, attempts)

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict on whether the scene stands before anything is put down."""
        return prepared(self.engine, self.assembly).verdict()

    @cached_property
    def maps(self) -> list[RobustnessMap]:
        """The robustness maps of the scene's supports."""
        return scene_map(self.assembly, self.engine, self.options.spacing, self.options.supports)

    @cached_property
    def support(self) -> SupportPoints:
        """The support points: points of the scene on which poses can be built."""
        return self._support_of(self.maps)

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """The faces of the object's convex hull."""
        return StandingFaces(self.body).faces()

    @cached_property
    def checks(self) -> Checks:
        """The checks of a pose."""
        return Checks(self.assembly, self.body, self.engine, self.confirm, self.options)

    @cached_property
    def proposals(self) -> Proposals:
        """The generator of poses."""
        return Proposals(self.checks, self.support, self.faces)

    @cached_property
    def weight(self) -> float:
        """The weight of the object [N]."""
        assert self.body.mass is not None
        return self.body.mass * float(np.linalg.norm(self.assembly.scene.gravity))

    def attempt(self, rng: np.random.Generator, points: Any = None) -> tuple[Candidate, Assembly | None]:  # noqa: ANN401
        """Make one attempt: return a pose with its fault, or a stable pose with the assembly after the placement.

        ``points`` are the numbers of the points of ``support`` to build on; by default they are chosen at random.
        """
        return self._attempted(self.proposals, rng, points)

    def _support_of(self, maps: list[RobustnessMap]) -> SupportPoints:
        options = self.options
        return support_points(maps, self.weight, self.assembly.scene.up, options.weights, options.box)

    def _support_in(self, clock: Clock) -> SupportPoints:
        """Return the support points, from the finest maps that there is time for, or without maps."""
        try:
            with until(clock.by("map")):
                return self.support
        except OutOfTimeError:
            pass
        coarse = COARSER * self.options.spacing
        try:
            with until(clock.by("coarse map")):
                return self._support_of(scene_map(self.assembly, self.engine, coarse, self.options.supports))
        except OutOfTimeError:
            return unmapped_points(self.assembly, self.options)

    def _searched(
        self, proposals: Proposals, deadlines: Sequence[float], seed: int, candidates: int, attempts: int
    ) -> Trials:
        """Search until the first of ``deadlines``; if no stable pose on a flat face was found, until the next one."""
        rng = np.random.default_rng(seed)
        search, clock = Trials(), Clock.started(None)
        flat = any(face.tilt > 0 and not face.rolls for face in self.faces)

        def look() -> None:
            while len(search.found) < candidates and len(search.rolling) < max(candidates, CANDIDATES):
                if search.tried >= attempts:
                    return
                report("attempts to place it", search.tried, attempts)
                candidate, after = self._attempted(proposals, rng)
                search.tried += 1
                if after is None:
                    search.failed(candidate)
                    continue
                rolls = flat and rolls_on(self.faces, candidate.pose, normals_into(after, self.body.name))
                (search.rolling if rolls else search.found).append((candidate, after))
                if search.first is None:
                    search.first = clock.elapsed

        for deadline in deadlines:
            try:
                with until(deadline):
                    look()
                    break
            except OutOfTimeError:
                search.out_of_time = True
                if search.found:
                    break
        return search

    def _attempted(
        self,
        proposals: Proposals,
        rng: np.random.Generator,
        points: Any = None,  # noqa: ANN401 - numbers
    ) -> tuple[Candidate, Assembly | None]:
        chosen = proposals.points(rng) if points is None else points
        places, normals = proposals.support.points[chosen], proposals.support.normals[chosen]
        pose = proposals.pose(places, normals, rng)
        rest = proposals.let_down(pose)
        if rest is None:
            return Candidate(pose, places, normals, FALLS if self.checks.free(pose) else OVERLAPS), None
        fault, pose, after = self.checks.nudged(rest)
        return Candidate(pose, places, normals, fault), after

    def _best(self, search: Trials, support: SupportPoints, clock: Clock) -> Placement:
        """Choose the best candidate, and compute its full map."""
        ranked = compared(self.checks, self.faces, search.stable, clock)
        first = ranked[0]
        full, late = self._full_map(first, clock)
        reason = "everything stands with it"
        if full.undecided.count and not late:
            least = least_push(full)
            others = f"; the other points hold at least {least:.3g} N" if least else ""
            reason += f"; {full.undecided.text_on('points of the map')}{others}"
        if first.rating.rolls:
            reason += "; it balances on one facet of a round side, from which a round one would roll"
        return self._placement(
            search,
            clock,
            answers=full.answers,
            status=Status.STABLE,
            reason=reason + late,
            map=full,
            candidates=tuple(entry.candidate for entry in ranked),
            beneath=first.beneath,
            support=support,
            time_to_stable=search.first,
        )

    def _full_map(self, chosen: Compared, clock: Clock) -> tuple[RobustnessMap, str]:
        """Return a map of all movable bodies, or the part that there was time for, with a remark on what is missing."""
        options = self.options
        try:
            with until(clock.by("end")):
                found = robustness_map(
                    chosen.after, spacing=options.spacing, engine=self.engine, imperfect=options.imperfect
                )
                return found, ""
        except OutOfTimeError:
            if chosen.own is not None:
                return chosen.own, f"; {SPENT}: the map covers {self.body.name} only, at few points"
            return unasked_map(chosen.after, self.body.name, options.spacing, self.engine), f"; {UNASKED}"

    def _nothing(self, search: Trials, why: str, clock: Clock) -> Placement:
        counts = ", ".join(f"{count} x {fault}" for fault, count in search.faults.most_common())
        reason = f"{why} ({search.tried} attempts: {counts})" if counts else why
        return self._without(Status.UNDECIDED, reason, search, clock, self.verdict)

    def _without(self, status: Status, reason: str, search: Trials, clock: Clock, verdict: Verdict) -> Placement:
        none = Answers.not_standing(0, engine=self.engine.name, claim=self.engine.claim, verdict=verdict)
        return self._placement(search, clock, answers=none, status=status, reason=reason, best=search.nearest)

    def _placement(self, search: Trials, clock: Clock, **found: Any) -> Placement:  # noqa: ANN401 - fields
        faults, answers = Table(search.faults), found["answers"]
        found["answers"] = replace(answers, notes=joined_notes([doubts([self.body]), answers.notes]))
        return Placement(name=self.body.name, attempts=search.tried, faults=faults, elapsed=clock.elapsed, **found)
