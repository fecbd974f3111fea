"""Plan placements after Sec. VII-A: what a scene withstands says where to put the next object.

1. One to three points of the scene are chosen by what they withstand. 2. A face of the object is laid on them with
opposed normals, and the centre of mass between the points. 3. The object is lowered until it rests (``lowering``). 4.
Overlap, supports, region, orientation and the way in are checked, and then whether everything stands. 5. Of several
such poses, the one is chosen that leaves the weakest point of the assembly strongest.

The planner of the paper's reference [16] was not available. The steps are those that Sec. VII-A reports of it; the
details are ours.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import manifold3d
import numpy as np

from holdfast.applications.placement.faces import Face, faces_of
from holdfast.applications.placement.lowering import Moved, Still, lowered
from holdfast.applications.placement.options import Options
from holdfast.applications.placement.poses import choose_points, direction_in, plane_of, pose_on
from holdfast.applications.placement.rating import Rating, least_push
from holdfast.applications.placement.result import Candidate, Placement
from holdfast.applications.placement.support import (
    SupportPoints,
    scene_map,
    support_points,
)
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, unit
from holdfast.base.errors import SceneError
from holdfast.base.progress import report, reported
from holdfast.base.rigid import transform
from holdfast.base.text import listed
from holdfast.base.values import Table
from holdfast.contacts.detect import find_contacts
from holdfast.contacts.interface import Interface
from holdfast.contacts.overlap import find_overlaps, solid_of
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status, Verdict
from holdfast.geometry.sweep import Swept, hit_distance
from holdfast.queries.map import RobustnessMap, robustness_map
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

ROUGHLY = 3  # spacing of the coarse maps that rank candidates, as a multiple of the spacing of the full map
CLEARANCE = 0.02  # of the object's size: the height above its place from which the object is lowered
MOST_ATTEMPTS = 400  # default number of attempts after which a search stops
SHARED = 1e-9  # of the object's volume: a smaller shared volume is no overlap
SEVERAL = (0.5, 0.35, 0.15)  # probabilities of building a pose on one, two and three points

OVERLAPS, FALLS, OUTSIDE = "overlaps the scene", "slides or falls off", "outside the region"
TURNED, UNSUPPORTED, SHUT_IN = "not in an allowed orientation", "not on enough of the supports", "no way in"
FORBIDDEN = "touches what it must not"
FALLEN, UNSURE, REFUSED = "does not stand with it", "undecided with it", "refused by the second engine"
MARGINAL = "would not stand if it were heavier by the margin"
STAGES = (
    *(FALLS, OVERLAPS, OUTSIDE, TURNED, UNSUPPORTED, FORBIDDEN, SHUT_IN),
    *(UNSURE, FALLEN, REFUSED, MARGINAL),
)  # in the order of the checks: the later the fault, the nearer the attempt is to a place


@dataclass(eq=False)
class Search:
    """The state of a search.

    ``found`` holds the stable poses, each with the assembly after the placement. ``tried`` counts the attempts, and
    ``faults`` counts the failed ones by their fault; ``nearest`` is the failed attempt that passed the most checks.
    ``first`` [s] is the time until the first stable pose.
    """

    found: list[tuple[Candidate, Assembly]] = field(default_factory=list)
    tried: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    nearest: Candidate | None = None
    first: float | None = None


@dataclass(frozen=True, eq=False)
class Planner:
    """A planner for one object, one scene and one engine, which is prepared once and asked with many seeds.

    The maps of the scene and the faces of the object are computed when they are first needed. ``confirm`` is a second
    engine that must also find every returned pose stable, or None.
    """

    assembly: Assembly
    body: Body
    engine: Engine
    confirm: Engine | None
    options: Options

    def plan(
        self, *, seed: int = 0, budget: float | None = None, candidates: int = 1, attempts: int = MOST_ATTEMPTS
    ) -> Placement:
        """Return the best of up to ``candidates`` stable poses.

        The search ends after ``budget`` [s] or ``attempts`` attempts.
        """
        start = time.perf_counter()
        if self.verdict.status is not Status.STABLE:
            return self._refused(start)
        if not len(self.support.points):
            region = " in the region" if np.isfinite(self.options.region).any() else ""
            return self._nothing(
                Search(), f"no exposed point of {listed(self.options.supports)} faces up{region}", start
            )
        if not self.support.chance.any():
            return self._nothing(Search(), f"no point to build on is sure to withstand a push{self._unknown()}", start)
        left = None if budget is None else budget - (time.perf_counter() - start)  # the maps took some of the time
        search = self.search(seed=seed, budget=left, candidates=candidates, attempts=attempts)
        if not search.found:
            spent = "the time was spent" if search.tried < attempts else "all attempts were spent"
            return self._nothing(search, f"no stable pose found, {spent}", start)
        return self._best(search, start)

    def search(
        self, *, seed: int = 0, budget: float | None = None, candidates: int = 1, attempts: int = MOST_ATTEMPTS
    ) -> Search:
        """Search for stable poses as ``plan`` does, but do not rate them.

        The scene must stand, and there must be points to build on.
        """
        start = time.perf_counter()
        rng = np.random.default_rng(seed)
        search = Search()
        while len(search.found) < candidates and search.tried < attempts:
            report("attempts to place it", search.tried, attempts)
            if search.tried and budget is not None and time.perf_counter() - start > budget:
                break
            search.tried += 1
            candidate, after = self.attempt(rng)
            if after is not None:
                search.found.append((candidate, after))
                if search.first is None:
                    search.first = time.perf_counter() - start
                continue
            search.faults[candidate.fault] += 1
            if search.nearest is None or STAGES.index(candidate.fault) > STAGES.index(search.nearest.fault):
                search.nearest = candidate
        return search

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
        """The points of the scene on which poses can be built."""
        return support_points(self.maps, self.weight, self.up, self.options.weights, self.options.region)

    @property
    def up(self) -> Float:
        """The unit vector (3,) opposite to gravity, world frame."""
        return self.assembly.scene.up

    @cached_property
    def weight(self) -> float:
        """The weight of the object [N]."""
        assert self.body.mass is not None
        return self.body.mass * float(np.linalg.norm(self.assembly.scene.gravity))

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """The faces of the object's convex hull."""
        return faces_of(self.body)

    @cached_property
    def _steadiness(self) -> Float:
        """The probability (n,) of choosing each face."""
        tilt = np.array([face.tilt for face in self.faces]) ** self.options.weights.steadiness
        tilt[[face.tilt <= 0 for face in self.faces]] = 0
        return np.asarray(tilt / tilt.sum()) if tilt.sum() > 0 else np.full(len(tilt), 1 / len(tilt))

    @cached_property
    def _moved(self) -> Moved:
        return Moved(self.body)

    @cached_property
    def _frozen(self) -> tuple[Body, ...]:
        """The bodies of the scene, all made fixed, because contacts are only searched between them and the object."""
        return tuple(replace_fixed(body) for body in self.assembly.bodies)

    @cached_property
    def _stills(self) -> tuple[Still, ...]:
        with_object = Scene([*self.assembly.bodies, self.body], self.options.friction)

        def mu(name: str) -> float | None:
            try:
                return with_object.mu(name, self.body.name)
            except SceneError:
                return None

        return tuple(Still(body, mu(body.name), self.up) for body in self._frozen)

    @cached_property
    def _solids(self) -> list[tuple[Body, manifold3d.Manifold]]:
        """The closed bodies of the scene as solids; overlaps with the other bodies are only checked at the end."""
        solids = [(body, solid_of(body)) for body in self._frozen]
        return [(body, solid) for body, solid in solids if solid is not None]

    @cached_property
    def _solid(self) -> manifold3d.Manifold | None:
        """The object as a solid in its own frame, or None if its surface is not closed."""
        return solid_of(self.body.moved(np.eye(4)))

    @cached_property
    def _edges(self) -> Float:
        """The directions (n, 3) of the axes of all bodies of the scene."""
        axes = [body.pose[:3, :3].T for body in self.assembly.bodies]
        return np.unique(np.round(np.vstack(axes), 6), axis=0)

    @cached_property
    def _top(self) -> float:
        """The highest coordinate of the whole scene along ``up`` [m]."""
        return max(float((body.surface_world.vertices @ self.up).max()) for body in self.assembly.bodies)

    def attempt(self, rng: np.random.Generator, points: Any = None) -> tuple[Candidate, Assembly | None]:  # noqa: ANN401
        """Make one attempt: return a pose with its fault, or a stable pose with the assembly after the placement.

        ``points`` are the numbers of the points of ``support`` to build on; by default they are chosen at random.
        """
        if points is None:
            points = choose_points(
                self.support, self._how_many(rng), self._moved.size, self.up, self.options.least_supports > 1, rng
            )
        places, normals = self.support.points[points], self.support.normals[points]
        pose = self._pose_on(places, normals, rng)
        rest = self._let_down(pose)
        if rest is None:
            return Candidate(pose, places, normals, FALLS if self._free(pose) else OVERLAPS), None
        fault, after = self._checked(rest)
        return Candidate(rest, places, normals, fault), after

    def _how_many(self, rng: np.random.Generator) -> int:
        least = min(self.options.least_supports, 3)
        chance = np.array(SEVERAL[least - 1 :])
        return least + int(rng.choice(len(chance), p=chance / chance.sum()))

    def _pose_on(self, places: Float, normals: Float, rng: np.random.Generator) -> Float:
        normal = plane_of(places, normals, self.up)
        allowed = self.options.orientations
        if allowed is None:
            face = self.faces[int(rng.choice(len(self.faces), p=self._steadiness))]
            along = direction_in(places, normal, self._edges, rng)
        else:
            turn = allowed[rng.integers(len(allowed))]
            face = min(self.faces, key=lambda f: float((turn @ f.normal) @ normal))
            along = direction_in(places, normal, self._edges, rng)
            if not self.options.turn:
                level = turn @ face.along
                along = unit(level - (level @ normal) * normal)
        return pose_on(places, normal, face, along, rng)

    def _let_down(self, pose: Float) -> Float | None:
        """Return the pose at rest, or None.

        The object is released just above its place if there is room, and otherwise from above the scene.
        """
        lifted = pose.copy()
        lifted[:3, 3] += CLEARANCE * self._moved.size * self.up
        if self.options.approach is not None or not self._free(lifted):
            lowest = float((self._moved.surface(lifted).vertices @ self.up).min())
            lifted[:3, 3] += max(self._top - lowest, 0.0) * self.up
        return lowered(self._moved, lifted, self._stills, self.up)

    def _free(self, pose: Float) -> bool:
        """Tell whether the object shares no volume with the scene."""
        if self._solid is None:
            return True
        vertices = transform(pose, self.body.shape.surface.vertices)
        low, high = vertices.min(0), vertices.max(0)
        least = SHARED * float(self._solid.volume())
        moved = None
        for body, solid in self._solids:
            if (body.box[0] < high).all() and (body.box[1] > low).all():
                moved = self._solid.transform(pose[:3]) if moved is None else moved
                if (moved ^ solid).volume() > least:
                    return False
        return True

    def _checked(self, pose: Float) -> tuple[str, Assembly | None]:
        """Return the fault of a pose, and the assembly with the object in that pose if it has no fault."""
        options, placed = self.options, self.body.moved(pose)
        com = placed.com_world
        level = np.abs(self.up) < 1 - 1e-9  # the region does not limit the height of the centre of mass
        if not ((com >= options.region[0]) & (com <= options.region[1]))[level].all():
            return OUTSIDE, None
        if not self._allowed(pose):
            return TURNED, None
        beside = Scene([*self._frozen, placed], self.options.friction, self.assembly.scene.gravity)
        if find_overlaps(beside, self.assembly.tolerances):
            return OVERLAPS, None
        contacts = find_contacts(beside, self.assembly.tolerances).interfaces
        touched = {name for interface in contacts for name in interface.bodies}
        if len(touched.intersection(options.supports)) < options.least_supports:
            return UNSUPPORTED, None
        if touched.intersection(options.avoid):
            return FORBIDDEN, None
        if options.approach is not None and self._shut_in(placed, -options.approach):
            return SHUT_IN, None
        return self._judged(self.with_object(placed, contacts))

    def _shut_in(self, placed: Body, way: Float) -> bool:
        """Tell whether the object meets anything on its straight way out, which is the reverse of its way in."""
        going, tolerances = Swept(placed.reduced_world, way), self.assembly.tolerances
        return any(
            np.isfinite(hit_distance(going, Swept(body.reduced_world, way), tolerances.between(body, placed).depth))
            for body in self._frozen
        )

    def with_object(self, placed: Body, contacts: Sequence[Interface]) -> Assembly:
        """Return the assembly with the object added, whose interfaces are ``contacts``."""
        scene = self.assembly.scene
        after = Scene([*scene.bodies, placed], self.options.friction, scene.gravity, scene.name, scene.excluded)
        return replace(self.assembly, scene=after, interfaces=(*self.assembly.interfaces, *contacts))

    def _judged(self, after: Assembly) -> tuple[str, Assembly | None]:
        status = prepared(self.engine, after).verdict().status
        if status is not Status.STABLE:
            return FALLEN if status is Status.UNSTABLE else UNSURE, None
        if self.confirm is not None and prepared(self.confirm, after).verdict().status is not Status.STABLE:
            return REFUSED, None
        margin = self.options.mass_margin
        if margin > 0:
            more = np.zeros((len(after.movable), 6))
            more[after.index[self.body.name], :3] = -margin * self.weight * self.up
            heavier = prepared(self.confirm or self.engine, after, more.reshape(-1))
            if heavier.verdict().status is not Status.STABLE:
                return MARGINAL, None
        return "", after

    def _allowed(self, pose: Float) -> bool:
        allowed = self.options.orientations
        if allowed is None:
            return True
        turns = pose[:3, :3]
        if self.options.turn:  # compare which direction of the body points up
            cosine = (np.swapaxes(allowed, 1, 2) @ self.up) @ (turns.T @ self.up)
        else:
            cosine = (np.einsum("kij,ij->k", allowed, turns) - 1) / 2
        return bool(cosine.max() >= np.cos(np.radians(self.options.tilt)) - 1e-12)

    def _best(self, search: Search, start: float) -> Placement:
        """Choose the candidate whose weakest point is strongest by a coarse map, and compute its full map."""
        found = search.found
        if len(found) > 1:
            rated = [self._rated(candidate, after) for candidate, after in reported("poses compared", found)]
            rated.sort(key=lambda entry: entry[0], reverse=True)
            found = [(candidate, after) for _, candidate, after in rated]
        after = found[0][1]
        options = self.options
        full = robustness_map(after, None, spacing=options.spacing, engine=self.engine, imperfect=options.imperfect)
        reason = "everything stands with it"
        if full.undecided.count:
            least = least_push(full)
            others = "" if least is None else f"; the other points hold at least {least:.3g} N"
            reason += f"; points {full.undecided.text}{others}"
        return self._placement(
            search,
            start,
            answers=full.answers,
            status=Status.STABLE,
            reason=reason,
            map=full,
            candidates=tuple(candidate for candidate, _ in found),
            support=self.support,
            time_to_stable=search.first,
        )

    def _rated(self, candidate: Candidate, after: Assembly) -> tuple[tuple[float, ...], Candidate, Assembly]:
        """Rate a stable pose by the decided points of a coarse map: the larger the key, the better the pose.

        Where ``lower`` covers imperfect faces it decides, and otherwise the force.
        """
        covers = self.options.imperfect
        step = ROUGHLY * self.options.spacing
        coarse = robustness_map(after, None, spacing=step, engine=self.engine, imperfect=covers)
        ideal = Rating.of(coarse, self.body.name)
        if covers is None:
            return ideal.key, replace(candidate, robustness=ideal.least), after
        sure = Rating.of(coarse, self.body.name, "lower")
        return sure.key, replace(candidate, robustness=ideal.least, lower=sure.least), after

    def _unknown(self) -> str:
        """Say how many answers of the scene's maps are not known, or nothing if all are known."""
        return "".join(f"; {found.undecided.text}" for found in self.maps if found.undecided.count)

    def _refused(self, start: float) -> Placement:
        verdict = self.verdict
        moving = "" if verdict.mechanism is None else f": {verdict.mechanism.text}"
        words = "does not stand" if verdict.status is Status.UNSTABLE else "is undecided"
        reason = f"the scene {words} before anything is put down: {verdict.reason}{moving}"
        return self._without(verdict.status, reason, Search(), start)

    def _nothing(self, search: Search, why: str, start: float) -> Placement:
        told = ", ".join(f"{count} x {fault}" for fault, count in search.faults.most_common())
        reason = f"{why} ({search.tried} attempts: {told})" if told else why
        return self._without(Status.UNDECIDED, reason, search, start)

    def _without(self, status: Status, reason: str, search: Search, start: float) -> Placement:
        none = Answers.not_standing(0, engine=self.engine.name, claim=self.engine.claim, verdict=self.verdict)
        return self._placement(search, start, answers=none, status=status, reason=reason, best=search.nearest)

    def _placement(self, search: Search, start: float, **found: Any) -> Placement:  # noqa: ANN401 - fields
        faults, elapsed = Table(search.faults), time.perf_counter() - start
        return Placement(name=self.body.name, attempts=search.tried, faults=faults, elapsed=elapsed, **found)


def replace_fixed(body: Body) -> Body:
    """Return the same body, made fixed."""
    return body if body.fixed else Body(body.name, body.shape, pose=body.pose, material=body.material, fixed=True)
