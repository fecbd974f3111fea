"""Plan placements by the robustness of the scene, after Nadeau & Kelly, Sec. VII-A.

1. One to three points of the scene are chosen at random, weighted by the pushes that they withstand. 2. A face of the
object is laid on them with opposed normals, with the centre of mass between the points. 3. The object is lowered until
it rests (``lowering``). 4. Overlap, supports, region, orientation and the way in are checked, and then whether
everything stands (``checks``). 5. Several such poses are compared by the pushes that the object and its supports
withstand and by the room around it, and the best few are shifted to where there is more room (``comparing``).

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
from holdfast.applications.placement.comparing import UNASKED, Clock, RatedPose, Trials, compared, unasked_map
from holdfast.applications.placement.conditions import (
    ATTEMPTS,
    CANDIDATES,
    Approach,
    Search,
    Where,
    friction_with,
    names_of,
)
from holdfast.applications.placement.margins import normals_into
from holdfast.applications.placement.result import Candidate, Placement, least_push
from holdfast.applications.placement.support import Proposals, SupportPoints, scene_map, support_points, unmapped_points
from holdfast.applications.resting_poses import Face, StandingFaces, rolls_on
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.caution import doubts
from holdfast.base.errors import SceneError, hinting, message
from holdfast.base.progress import OutOfTimeError, report, until
from holdfast.base.text import listed, quoted
from holdfast.base.values import Table
from holdfast.engines.answers import Answers, joined_notes
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.engines.rest import undecided
from holdfast.engines.verdict import Status, Verdict
from holdfast.queries.lower_bounds import covering
from holdfast.queries.map import RobustnessMap, robustness_map
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, checked_options, engine_of
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

COARSER = 3.0  # spacing of the scene's coarse map, as a multiple of that of the fine one
SPENT = "the time was used up"
NAME = "plan_placement"


@hinting(where=Where, approach=Approach, search=Search)
def plan_placement(
    assembly: Assembly | Scene,
    obj: Body,
    where: Where | None = None,
    approach: Approach | None = None,
    search: Search | None = None,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    friction: Friction | float | None = None,
    imperfect: Imperfect | None = None,
) -> Placement:
    """Find a good pose for ``obj`` in which everything stands; the pose that it already has is ignored.

    Several stable poses are compared: by the smallest push that moves the object or its supports, and by the room to
    edges and neighbours (``Placement.rating``). Poses on flat faces rank before poses on a facet of a round side, from
    which a round body would roll.

    - ``where``, ``approach`` and ``search`` say where the object may be placed, how it gets there, and how long to
      search: see Where, Approach and Search. By default any place, orientation and way in is allowed, and the search
      takes at most 60 s.
    - ``friction``: the coefficient of the object with all bodies with which the scene's table does not pair it, or
      the whole table of the scene with the object. By default it is the scene's own table.
    - ``imperfect``: imperfect faces, as in ``robustness``. Stable poses are then compared by ``lower``, which holds on
      the samples, as does ``lower`` of the result; forces remain those of ideal faces. With 32 samples, a comparison
      takes about as long as 30 maps.

    If no place is found, the result says why. Raises SceneError if ``obj`` is fixed, is not a Body or has the name of
    another body, and HoldfastError if an option is invalid or ``imperfect`` is given for an engine other than
    ``compliant``.
    """
    place = checked_options(where, Where, f"{NAME}: where", "holdfast")
    if place.apart is not None:
        raise SceneError(message(f"{NAME}: where", "has apart", "it is the distance between several: ask place_all"))
    return planner(assembly, obj, place, approach, search, engine=engine, friction=friction, imperfect=imperfect).plan()


def planner(
    assembly: Assembly | Scene,
    obj: Body,
    where: Where | None = None,
    approach: Approach | None = None,
    search: Search | None = None,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    friction: Friction | float | None = None,
    imperfect: Imperfect | None = None,
) -> Planner:
    """Return a planner that can be used with many seeds; the arguments are those of ``plan_placement``."""
    assembly = checked_assembly(assembly)
    refuse_holds(assembly.scene.holds, NAME, "place into the scene without them")
    place = checked_options(where, Where, f"{NAME}: where", "holdfast")
    way = checked_options(approach, Approach, f"{NAME}: approach", "holdfast")
    how = checked_options(search, Search, f"{NAME}: search", "holdfast")
    if not isinstance(obj, Body):
        raise SceneError(message(NAME, f"obj is a {type(obj).__name__}", "needs a holdfast.Body with a mass"))
    if obj.fixed:
        raise SceneError(message(NAME, f"body {quoted(obj.name)} is fixed", "needs one that can be moved"))
    if any(other.name == obj.name for other in assembly.bodies):
        problem = f"the scene has a body named {quoted(obj.name)}"
        raise SceneError(message(NAME, problem, "give the object another name"))
    method = engine_of(engine)
    second = None if how.confirm is None else engine_of(how.confirm)
    table = friction_with(assembly, [obj], friction, names_of(assembly, place.supports, "supports"))
    covering(imperfect, method, assembly)  # raises an error if the engine does not take imperfect faces
    # an engine may have options that name the new body
    names = {obj.name} if obj.material is None else {obj.name, obj.material}
    assembly = replace(assembly, absent=tuple(sorted({*assembly.absent, *names})))
    return Planner(
        Checks(assembly, obj, method, None if second == method else second, place, way, how, table, imperfect)
    )


@dataclass(frozen=True, eq=False)
class Planner:
    """A planner of poses that pass ``checks``, which can be used with many seeds.

    The maps of the scene and the faces of the object are computed once, when they are first needed.
    """

    checks: Checks

    def plan(self) -> Placement:
        """Return the best of the stable poses that the search of the checks asks for.

        Its time limit is checked wherever progress is reported, at least every half second.
        """
        checks, search = self.checks, self.checks.search
        clock = Clock.started(search.limit)
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
            region = " in the box" if np.isfinite(checks.region).any() else ""
            return self._nothing(Trials(), f"no exposed point of {listed(checks.supports)} faces up{region}", clock)
        if not support.chance.any():
            undecided_in = [found for found in vars(self).get("maps", []) if found.undecided.count]
            unknown = "".join(f"; {found.undecided.text}" for found in undecided_in)
            return self._nothing(Trials(), f"no support point certainly withstands a push{unknown}", clock)
        proposals, ends = Proposals(checks, support, self.faces), [clock.by("search"), clock.by("end")]
        attempts = ATTEMPTS if search.solves is None else search.solves
        trials = self._searched(proposals, ends, search.seed, search.candidates, attempts)
        if not trials.stable:
            spent = SPENT if trials.out_of_time else "all attempts were used up"
            return self._nothing(trials, f"no stable pose found, {spent}", clock)
        return self._best(trials, support, clock)

    def search(self, *, seed: int = 0, attempts: int = ATTEMPTS, mapped: bool = True) -> Trials:
        """Search for one stable pose as ``plan`` does, without rating it.

        The scene must stand. Without ``mapped``, support points are chosen without computing which pushes they
        withstand.
        """
        if mapped:
            proposals = self.proposals
        else:
            proposals = Proposals(self.checks, unmapped_points(self.checks), self.faces)
            if not proposals.support.chance.any():
                return Trials()
        return self._searched(proposals, [np.inf], seed, 1, attempts)

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict on whether the scene stands before anything is put down."""
        return prepared(self.checks.engine, self.checks.assembly).verdict()

    @cached_property
    def maps(self) -> list[RobustnessMap]:
        """The robustness maps of the scene's supports."""
        return self._maps_at(self.checks.search.spacing)

    @cached_property
    def support(self) -> SupportPoints:
        """The support points: points of the scene on which poses can be built."""
        return self._support_of(self.maps)

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """The faces of the object's convex hull."""
        return StandingFaces(self.checks.body).faces()

    @cached_property
    def proposals(self) -> Proposals:
        """The generator of poses."""
        return Proposals(self.checks, self.support, self.faces)

    @cached_property
    def weight(self) -> float:
        """The weight of the object [N]."""
        assert self.checks.body.mass is not None
        return self.checks.body.mass * float(np.linalg.norm(self.checks.assembly.scene.gravity))

    def attempt(
        self,
        rng: np.random.Generator,
        points: Any = None,  # noqa: ANN401 - numbers
        proposals: Proposals | None = None,
    ) -> tuple[Candidate, Assembly | None]:
        """Make one attempt: return a pose with its fault, or a stable pose with the assembly after the placement.

        ``points`` are the numbers of the support points to build on; by default they are chosen at random.
        ``proposals`` are by default those on the points of ``support``.
        """
        proposals = self.proposals if proposals is None else proposals
        chosen = proposals.points(rng) if points is None else points
        places, normals = proposals.support.points[chosen], proposals.support.normals[chosen]
        pose = proposals.pose(places, normals, rng)
        rest = proposals.let_down(pose)
        if rest is None:
            return Candidate(pose, places, normals, FALLS if self.checks.free(pose) else OVERLAPS), None
        fault, pose, after = self.checks.nudged(rest)
        return Candidate(pose, places, normals, fault), after

    def _maps_at(self, spacing: float) -> list[RobustnessMap]:
        return scene_map(self.checks.assembly, self.checks.engine, spacing, self.checks.supports)

    def _support_of(self, maps: list[RobustnessMap]) -> SupportPoints:
        return support_points(maps, self.weight, self.checks.up, self.checks.search.weights, self.checks.region)

    def _support_in(self, clock: Clock) -> SupportPoints:
        """Return the support points, from the finest maps that there is time for, or without maps."""
        try:
            with until(clock.by("map")):
                return self.support
        except OutOfTimeError:
            pass
        try:
            with until(clock.by("coarse map")):
                return self._support_of(self._maps_at(COARSER * self.checks.search.spacing))
        except OutOfTimeError:
            return unmapped_points(self.checks)

    def _searched(
        self, proposals: Proposals, deadlines: Sequence[float], seed: int, candidates: int, attempts: int
    ) -> Trials:
        """Search until the first of ``deadlines``; if no stable pose on a flat face was found, until the next one."""
        rng = np.random.default_rng(seed)
        search, clock = Trials(), Clock.started(None)
        has_flat_face = any(face.tilt > 0 and not face.rolls for face in self.faces)

        def try_poses() -> None:
            """Make attempts until ``search`` holds enough poses, or ``attempts`` were made."""
            # one on a facet of a round side is only used if there is no other, so it does not end the search as soon
            while len(search.flat) < candidates and len(search.rolling) < max(candidates, CANDIDATES):
                if search.tried >= attempts:
                    return
                report("attempts to place it", search.tried, attempts)
                candidate, after = self.attempt(rng, proposals=proposals)
                search.tried += 1
                if after is None:
                    search.failed(candidate)
                    continue
                rolls = has_flat_face and rolls_on(
                    self.faces, candidate.pose, normals_into(after, self.checks.body.name)
                )
                (search.rolling if rolls else search.flat).append((candidate, after))
                if search.first is None:
                    search.first = clock.elapsed

        for deadline in deadlines:
            try:
                with until(deadline):
                    try_poses()
                    break
            except OutOfTimeError:
                search.out_of_time = True
                if search.flat:
                    break
        return search

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

    def _full_map(self, chosen: RatedPose, clock: Clock) -> tuple[RobustnessMap, str]:
        """Return a map of all movable bodies, or the part that there was time for, with a remark on what is missing."""
        checks, name = self.checks, self.checks.body.name
        try:
            with until(clock.by("end")):
                return robustness_map(
                    chosen.after, spacing=checks.search.spacing, engine=checks.engine, imperfect=checks.imperfect
                ), ""
        except OutOfTimeError:
            if chosen.own is not None:
                return chosen.own, f"; {SPENT}: the map covers {name} only, at few points"
            return unasked_map(chosen.after, name, checks.search.spacing, checks.engine), f"; {UNASKED}"

    def _nothing(self, search: Trials, why: str, clock: Clock) -> Placement:
        counts = ", ".join(f"{count} x {fault}" for fault, count in search.faults.most_common())
        reason = f"{why} ({search.tried} attempts: {counts})" if counts else why
        return self._without(Status.UNDECIDED, reason, search, clock, self.verdict)

    def _without(self, status: Status, reason: str, search: Trials, clock: Clock, verdict: Verdict) -> Placement:
        engine = self.checks.engine
        none = Answers.not_standing(0, engine=engine.name, claim=engine.claim, verdict=verdict)
        return self._placement(search, clock, answers=none, status=status, reason=reason, best=search.nearest)

    def _placement(self, search: Trials, clock: Clock, **found: Any) -> Placement:  # noqa: ANN401 - fields
        faults, answers = Table(search.faults), found["answers"]
        body = self.checks.body
        found["answers"] = replace(answers, notes=joined_notes([doubts([body]), answers.notes]))
        return Placement(name=body.name, attempts=search.tried, faults=faults, elapsed=clock.elapsed, **found)
