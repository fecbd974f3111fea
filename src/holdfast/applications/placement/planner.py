"""Placement planning after Sec. VII-A: what a scene withstands says where to put the next object.

1. points of the scene are chosen by what they withstand, one to three of them;
2. a face of the object is laid on them, normals opposed, its centre of mass between them;
3. the object is let down until it rests (``lowering``);
4. overlap, supports, region, orientation and the way in are checked, then whether everything stands;
5. of several such poses the one is taken after which the weakest point of the assembly is strongest.

The planner of the paper's [16] was not at hand: the steps are those that Sec. VII-A tells of it, their details are ours.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import manifold3d
import numpy as np

from holdfast.applications.exits import clear_path
from holdfast.applications.placement.faces import Face, faces_of
from holdfast.applications.placement.lowering import Moved, Still, at, lowered
from holdfast.applications.placement.poses import choose_points, direction_in, plane_of, pose_on
from holdfast.applications.placement.result import Candidate, Placement
from holdfast.applications.placement.support import (
    SupportPoints,
    Weights,
    checked_region,
    scene_map,
    support_points,
)
from holdfast.arrays import Float, checked, checked_number, unit
from holdfast.assembly.assembly import Assembly
from holdfast.contacts.detect import find_contacts
from holdfast.contacts.interface import Interface
from holdfast.contacts.overlap import find_overlaps, solid_of
from holdfast.engines.contract import Engine, Status, Verdict
from holdfast.errors import SceneError, message
from holdfast.rigid import checked_pose, transform
from holdfast.robustness.map import RobustnessMap, robustness_map
from holdfast.robustness.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

SPACING = 0.01  # [m] between the points of a map
ROUGHLY = 3  # times that between the points that rank candidates
CLEARANCE = 0.02  # of the object's size: how far above its place the object is let go
MOST_ATTEMPTS = 400
SHARED = 1e-9  # of the object's volume: less is no overlap
SEVERAL = (0.5, 0.35, 0.15)  # chance of building a pose on one, two, three points

OVERLAPS, FALLS, OUTSIDE = "overlaps the scene", "slides or falls off", "outside the region"
TURNED, UNSUPPORTED, SHUT_IN = "not in an allowed orientation", "not on enough of the supports", "no way in"
FALLEN, UNSURE, REFUSED = "does not stand with it", "undecided with it", "refused by the second engine"
STAGES = (FALLS, OVERLAPS, OUTSIDE, TURNED, UNSUPPORTED, SHUT_IN, UNSURE, FALLEN, REFUSED)


@dataclass(frozen=True, eq=False)
class Options:
    """What a placement must keep to; see ``plan_placement``."""

    region: Float
    supports: tuple[str, ...]
    least_supports: int
    orientations: Float | None
    turn: bool
    tilt: float
    approach: Float | None
    weights: Weights
    spacing: float


@dataclass(frozen=True, eq=False)
class Planner:
    """One object, one scene, one engine: prepared once, asked with many seeds.

    Maps of the scene and faces of the object are found when first needed. ``confirm``: the engine that must also find
    every returned pose stable, None if none is asked.
    """

    assembly: Assembly
    body: Body
    engine: Engine
    confirm: Engine | None
    options: Options

    def plan(
        self, *, seed: int = 0, budget: float | None = None, candidates: int = 1, attempts: int = MOST_ATTEMPTS
    ) -> Placement:
        """The best of up to ``candidates`` stable poses found within ``budget`` [s] and that many ``attempts``."""
        start = time.perf_counter()
        rng = np.random.default_rng(seed)
        verdict = self.verdict
        if verdict.status is not Status.STABLE:
            return self._refused(verdict, start)
        if not len(self.support.points):
            return self._nothing(Counter(), 0, None, start, self._no_points)
        found: list[tuple[Candidate, Assembly]] = []
        faults: Counter[str] = Counter()
        nearest: Candidate | None = None
        first: float | None = None
        tried = 0
        while len(found) < candidates and tried < attempts:
            if budget is not None and time.perf_counter() - start > budget:
                break
            tried += 1
            candidate, after = self.attempt(rng)
            if after is not None:
                first = time.perf_counter() - start if first is None else first
                found.append((candidate, after))
                continue
            faults[candidate.fault] += 1
            if nearest is None or STAGES.index(candidate.fault) > STAGES.index(nearest.fault):
                nearest = candidate
        if not found:
            cut = "the time was spent" if tried < attempts else "all attempts were spent"
            return self._nothing(faults, tried, nearest, start, f"no stable pose found, {cut}")
        return self._best(found, tried, faults, first, start)

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the scene stands before anything is put down."""
        return self.engine.prepare(self.assembly).verdict()

    @cached_property
    def maps(self) -> list[RobustnessMap]:
        """Maps of the scene's supports."""
        return scene_map(self.assembly, self.engine, self.options.spacing, self.options.supports)

    @cached_property
    def support(self) -> SupportPoints:
        """Points of the scene to build poses on."""
        return support_points(self.maps, self.weight, self.up, self.options.weights, self.options.region)

    @cached_property
    def up(self) -> Float:
        """(3,) against gravity."""
        return unit(-self.assembly.scene.gravity)

    @cached_property
    def weight(self) -> float:
        """Of the object [N]."""
        assert self.body.mass is not None
        return self.body.mass * float(np.linalg.norm(self.assembly.scene.gravity))

    @cached_property
    def faces(self) -> tuple[Face, ...]:
        """Faces of the object's hull."""
        return faces_of(self.body)

    @cached_property
    def _steadiness(self) -> Float:
        """(n,) chance of each face."""
        tilt = np.array([face.tilt for face in self.faces]) ** self.options.weights.steadiness
        tilt[[face.tilt <= 0 for face in self.faces]] = 0
        return np.asarray(tilt / tilt.sum()) if tilt.sum() > 0 else np.full(len(tilt), 1 / len(tilt))

    @cached_property
    def _moved(self) -> Moved:
        return Moved(self.body)

    @cached_property
    def _frozen(self) -> tuple[Body, ...]:
        """The bodies of the scene, all fixed: the search below looks at pairs with the object only."""
        return tuple(replace_fixed(body) for body in self.assembly.bodies)

    @cached_property
    def _stills(self) -> tuple[Still, ...]:
        with_object = Scene([*self.assembly.bodies, self.body], self.assembly.scene.friction)
        return tuple(Still(body, with_object.mu(body.name, self.body.name)) for body in self._frozen)

    @cached_property
    def _solids(self) -> list[tuple[Body, manifold3d.Manifold]]:
        """Closed bodies of the scene; the others are looked at in the end alone."""
        solids = [(body, solid_of(body)) for body in self._frozen]
        return [(body, solid) for body, solid in solids if solid is not None]

    @cached_property
    def _solid(self) -> manifold3d.Manifold | None:
        """The object in its own frame."""
        return solid_of(at(self.body, np.eye(4)))

    @cached_property
    def _edges(self) -> Float:
        """(n, 3) directions of the scene's bodies: their axes."""
        axes = [body.pose[:3, :3].T for body in self.assembly.bodies if body.pose is not None]
        return np.unique(np.round(np.vstack(axes), 6), axis=0)

    @cached_property
    def _top(self) -> float:
        """Of the whole scene [m], along ``up``."""
        return max(float((body.surface_world.vertices @ self.up).max()) for body in self.assembly.bodies)

    def attempt(self, rng: np.random.Generator, points: Any = None) -> tuple[Candidate, Assembly | None]:  # noqa: ANN401
        """One try: a pose with its fault, or a stable one with the assembly afterwards.

        On ``points``, numbers of points of ``support``, unless they are to be chosen.
        """
        if points is None:
            points = choose_points(
                self.support, self._how_many(rng), self._moved.size, self.up, self.options.least_supports > 1, rng
            )
        places = self.support.points[points]
        pose = self._pose_on(places, self.support.normals[points], rng)
        rest = self._let_down(pose)
        if rest is None:
            return Candidate(pose, places, FALLS if self._free(pose) else OVERLAPS), None
        fault, after = self._checked(rest)
        return Candidate(rest, places, fault), None if fault else after

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
        """The pose at rest; let go just above the place where there is room, else from above the scene."""
        lifted = pose.copy()
        lifted[:3, 3] += CLEARANCE * self._moved.size * self.up
        if self.options.approach is not None or not self._free(lifted):
            lowest = float((self._moved.surface(lifted).vertices @ self.up).min())
            lifted[:3, 3] += max(self._top - lowest, 0.0) * self.up
        return lowered(self._moved, lifted, self._stills, self.up)

    def _free(self, pose: Float) -> bool:
        """Whether the object shares no volume with the scene."""
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
        """What is wrong with a pose, and the assembly with the object there."""
        options, placed = self.options, at(self.body, pose)
        com = placed.com_world
        level = np.abs(self.up) < 1 - 1e-9  # the height of the centre of mass is not asked for
        if not ((com >= options.region[0]) & (com <= options.region[1]))[level].all():
            return OUTSIDE, None
        if not self._allowed(pose):
            return TURNED, None
        beside = Scene([*self._frozen, placed], self.assembly.scene.friction, self.assembly.scene.gravity)
        if find_overlaps(beside, self.assembly.tolerances):
            return OVERLAPS, None
        contacts = find_contacts(beside, self.assembly.tolerances).interfaces
        touched = {name for interface in contacts for name in interface.bodies} & set(options.supports)
        if len(touched) < options.least_supports:
            return UNSUPPORTED, None
        if options.approach is not None and not clear_path(
            placed, self._frozen, -options.approach, slack=self.assembly.tolerances.gap
        ):
            return SHUT_IN, None
        return self._judged(self.with_object(placed, contacts))

    def with_object(self, placed: Body, contacts: Sequence[Interface]) -> Assembly:
        """The assembly with one body more, whose interfaces are ``contacts``."""
        scene = self.assembly.scene
        after = Scene([*scene.bodies, placed], scene.friction, scene.gravity, scene.name)
        return replace(self.assembly, scene=after, interfaces=(*self.assembly.interfaces, *contacts))

    def _judged(self, after: Assembly) -> tuple[str, Assembly | None]:
        status = self.engine.prepare(after).verdict().status
        if status is not Status.STABLE:
            return FALLEN if status is Status.UNSTABLE else UNSURE, None
        if self.confirm is not None and self.confirm.prepare(after).verdict().status is not Status.STABLE:
            return REFUSED, None
        return "", after

    def _allowed(self, pose: Float) -> bool:
        allowed = self.options.orientations
        if allowed is None:
            return True
        turns = pose[:3, :3]
        if self.options.turn:  # compare what points up in the body
            cosine = (np.swapaxes(allowed, 1, 2) @ self.up) @ (turns.T @ self.up)
        else:
            cosine = (np.einsum("kij,ij->k", allowed, turns) - 1) / 2
        return bool(cosine.max() >= np.cos(np.radians(self.options.tilt)) - 1e-12)

    def _best(
        self,
        found: list[tuple[Candidate, Assembly]],
        tried: int,
        faults: Counter[str],
        first: float | None,
        start: float,
    ) -> Placement:
        """The candidate whose weakest point is strongest by a coarse map, then the full map of it."""
        if len(found) > 1:
            scored = []
            for candidate, after in found:
                coarse = robustness_map(after, None, ROUGHLY * self.options.spacing, engine=self.engine)
                own = float(coarse.force[coarse.body == self.body.name].min(initial=np.inf))
                force = float(coarse.force.min())
                scored.append((round(force, 9), own, replace(candidate, robustness=force), after))
            scored.sort(key=lambda entry: entry[:2], reverse=True)
            found = [(candidate, after) for _, _, candidate, after in scored]
        chosen, after = found[0]
        full = robustness_map(after, None, self.options.spacing, engine=self.engine)
        weakest = full.weakest()
        numbers = [int(np.argmin(np.linalg.norm(self.support.points - p, axis=1))) for p in chosen.points]
        return Placement(
            self.engine.name, self.engine.claim, Status.STABLE, "stands with it", chosen.pose, weakest.force, weakest,
            tuple(i for i in after.interfaces if self.body.name in i.bodies), tried, dict(faults),
            tuple(candidate for candidate, _ in found), None, chosen.points, self.support.normals[numbers],
            after.scene.body(self.body.name), after, first, time.perf_counter() - start, full.notes,
        )  # fmt: skip

    def _refused(self, verdict: Verdict, start: float) -> Placement:
        moving = "" if verdict.mechanism is None else f": {verdict.mechanism.text}"
        words = "does not stand" if verdict.status is Status.UNSTABLE else "is undecided"
        return self._without(verdict.status, f"the scene {words} before: {verdict.reason}{moving}", {}, 0, None, start)

    def _nothing(
        self, faults: Counter[str], tried: int, nearest: Candidate | None, start: float, why: str
    ) -> Placement:
        told = ", ".join(f"{count} x {fault}" for fault, count in faults.most_common())
        reason = f"{why} ({tried} attempts: {told})" if told else why
        return self._without(Status.UNDECIDED, reason, dict(faults), tried, nearest, start)

    def _without(
        self, status: Status, reason: str, faults: dict[str, int], tried: int, nearest: Candidate | None, start: float
    ) -> Placement:
        none = np.empty((0, 3))
        return Placement(
            self.engine.name, self.engine.claim, status, reason, None, 0.0, None, (), tried, faults, (), nearest,
            none, none, None, None, None, time.perf_counter() - start, (),
        )  # fmt: skip

    @property
    def _no_points(self) -> str:
        return (
            f"no exposed point of {', '.join(self.options.supports)} faces up"
            f"{' in the region' if np.isfinite(self.options.region).any() else ''}"
        )


def replace_fixed(body: Body) -> Body:
    """The same body, fixed."""
    return body if body.fixed else Body(body.name, body.shape, pose=body.pose, material=body.material, fixed=True)


def plan_placement(
    assembly: Assembly,
    body: Body,
    engine: EngineChoice = DEFAULT_ENGINE,
    region: Any = None,  # noqa: ANN401 - (2, 2) or (2, 3) numbers, checked
    budget: float | None = None,
    seed: int = 0,
    *,
    candidates: int = 1,
    attempts: int = MOST_ATTEMPTS,
    supports: Sequence[str] | None = None,
    least_supports: int = 1,
    orientations: Any = None,  # noqa: ANN401 - (k, 3, 3) numbers, checked
    turn: bool = True,
    tilt: float = 5.0,
    approach: Any = None,  # noqa: ANN401 - (3,) numbers, checked
    weights: Weights | None = None,
    spacing: float = SPACING,
    confirm: EngineChoice | None = DEFAULT_ENGINE,
) -> Placement:
    """Find a pose for ``body`` in which everything stands; its own pose is of no account.

    ``region`` [m]: low and high corner of a box, (2, 2) horizontal or (2, 3): the points of the scene that the pose is
    built on lie in it, and, seen from above, the centre of mass. ``budget`` [s] and ``attempts`` end the search;
    the same ``seed`` gives the same answer unless the time cut it short. ``candidates``: the best of that many stable
    poses. ``supports``: names of the bodies it may be built on (all unless given), of which it must touch
    ``least_supports`` (1 to 3 points are built on; it may lean on others besides). ``orientations`` (k, 3, 3): allowed
    rotations, body to world, each turned about the vertical as may be unless ``turn`` is False, to within ``tilt``
    [deg]. ``approach`` (3,): the straight way in, for instance (0, 0, -1), must be free. ``weights`` bias the choice;
    ``spacing`` [m] is that of all maps. ``confirm``: the engine that also has to find the pose stable, or None.
    """
    return planner(
        assembly, body, engine, region=region, supports=supports, least_supports=least_supports,
        orientations=orientations, turn=turn, tilt=tilt, approach=approach, weights=weights, spacing=spacing,
        confirm=confirm,
    ).plan(
        seed=seed,
        budget=None if budget is None else checked_number(budget, "plan_placement: budget", above=0),
        candidates=_counted(candidates, "candidates"),
        attempts=_counted(attempts, "attempts"),
    )  # fmt: skip


def planner(
    assembly: Assembly,
    body: Body,
    engine: EngineChoice = DEFAULT_ENGINE,
    *,
    region: Any = None,  # noqa: ANN401
    supports: Sequence[str] | None = None,
    least_supports: int = 1,
    orientations: Any = None,  # noqa: ANN401
    turn: bool = True,
    tilt: float = 5.0,
    approach: Any = None,  # noqa: ANN401
    weights: Weights | None = None,
    spacing: float = SPACING,
    confirm: EngineChoice | None = DEFAULT_ENGINE,
) -> Planner:
    """A planner to be asked with many seeds; arguments as of ``plan_placement``."""
    checked_assembly(assembly)
    where = "plan_placement"
    if not isinstance(body, Body):
        raise SceneError(message(where, f"body is a {type(body).__name__}", "needs a holdfast.Body with a mass"))
    if body.fixed:
        raise SceneError(message(where, f"body {body.name!r} is fixed", "needs one that can be moved"))
    if any(other.name == body.name for other in assembly.bodies):
        raise SceneError(message(where, f"the scene has a body named {body.name!r}", "give the object another name"))
    method = engine_of(engine)
    second = None if confirm is None else engine_of(confirm)
    up = unit(-assembly.scene.gravity)
    options = Options(
        checked_region(region, up),
        _checked_supports(assembly, supports),
        _counted(least_supports, "least_supports"),
        _checked_orientations(orientations),
        bool(turn),
        checked_number(tilt, f"{where}: tilt", minimum=0),
        None if approach is None else _checked_direction(approach),
        Weights() if weights is None else weights,
        checked_number(spacing, f"{where}: spacing", above=0),
    )
    if options.least_supports > len(options.supports):
        problem = f"least_supports is {options.least_supports}, supports are {', '.join(options.supports)}"
        raise SceneError(message(where, problem, "ask for no more than there are"))
    return Planner(assembly, body, method, None if second == method else second, options)


def _checked_supports(assembly: Assembly, names: Sequence[str] | None) -> tuple[str, ...]:
    if names is None:
        return tuple(body.name for body in assembly.bodies)
    if isinstance(names, str) or not len(names):
        raise SceneError(message("plan_placement: supports", f"is {names!r}", "needs a list of names of bodies"))
    return tuple(assembly.scene.body(name).name for name in names)


def _checked_orientations(value: Any) -> Float | None:  # noqa: ANN401
    if value is None:
        return None
    where = "plan_placement: orientations"
    array = np.asarray(value)
    turns = checked(array[None] if array.ndim == 2 else array, (None, 3, 3), where)
    if not len(turns):
        raise SceneError(message(where, "is empty", "give rotations (k, 3, 3), or None for any"))
    poses = np.tile(np.eye(4), (len(turns), 1, 1))
    poses[:, :3, :3] = turns
    return np.array([checked_pose(pose, f"{where}[{k}]")[:3, :3] for k, pose in enumerate(poses)])


def _checked_direction(value: Any) -> Float:  # noqa: ANN401
    direction = checked(value, (3,), "plan_placement: approach")
    if not np.linalg.norm(direction) > 0:
        raise SceneError(message("plan_placement: approach", "is zero", "needs a direction such as (0, 0, -1)"))
    return unit(direction)


def _counted(value: Any, name: str) -> int:  # noqa: ANN401
    number = checked_number(value, f"plan_placement: {name}", minimum=1)
    if number != int(number):
        raise SceneError(message(f"plan_placement: {name}", f"is {number:g}", "needs a whole number"))
    return int(number)
