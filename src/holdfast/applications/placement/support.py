"""Propose poses: lay a face of the object on points of the scene that withstand large pushes, and lower it.

Support points can carry an object. A pose lays one of its faces on one to three of them, with opposed normals.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.applications.placement.checks import Checks
from holdfast.applications.placement.conditions import Weights
from holdfast.applications.placement.lowering import Moved, Still, lowered
from holdfast.applications.placement.margins import STEEPEST
from holdfast.applications.resting_poses import Face
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float, Int, Objects, objects, unit
from holdfast.base.errors import SceneError
from holdfast.base.public import Record, column
from holdfast.base.rigid import tangents
from holdfast.geometry.cells import Cells
from holdfast.queries.map import RobustnessMap, exposed_cells, robustness_map, spacing_for
from holdfast.queries.request import EngineChoice
from holdfast.scene.scene import Scene

MOST_FIXED = 3000  # largest number of points on fixed bodies, where no push needs an answer
STEEPEST_LINE = 0.8  # sine of the largest slope of the line between two points that are used together
STEEPEST_PLANE = 0.4  # cosine of the largest tilt of the plane of three points
LEAST_APART = 0.15  # smallest distance between points that are used together, as a share of the object's size
ALIGNED = 0.7  # share of the poses in which the face is aligned with an edge of the scene
CLEARANCE = 0.02  # height above its place from which the object is lowered, as a share of its size
SEVERAL = (0.5, 0.35, 0.15)  # probabilities of building a pose on one, two and three points
UPRIGHT_SHARE = 0.5  # smallest share of proposals with the object upright, if it can stand upright
ROUND_SHARE = 0.25  # largest share of proposals on facets of round sides, if the object also has flat faces


class SupportPoints(Record):
    """The n exposed points of the scene that face up and can carry an object.

    ``points`` (n, 3) [m] and outward ``normals`` (n, 3) are in the world frame; ``body`` (n,) holds names. ``force``
    (n,) [N] is the inward push that each point withstands, nan if it was not computed, and ``area`` (n,) [m²] the area
    that the point represents. ``chance`` (n,) is the probability of choosing it; the probabilities add up to 1.
    """

    points: Float = column("n 3")
    normals: Float = column("n 3")
    body: Objects = column("n", of=str)
    force: Float = column("n")
    area: Float = column("n")
    chance: Float = column("n")


def scene_map(assembly: Assembly, engine: EngineChoice, spacing: float, names: Collection[str]) -> list[RobustnessMap]:
    """Return robustness maps of the movable and of the fixed bodies among ``names``.

    The map of the fixed bodies is coarse, because no push moves them.
    """
    maps = []
    movable = [body.name for body in assembly.movable if body.name in names]
    fixed = [body.name for body in assembly.bodies if body.fixed and body.name in names]
    if movable:
        maps.append(robustness_map(assembly, movable, spacing=spacing, engine=engine))
    if fixed:
        step = max(spacing, spacing_for(assembly, fixed, MOST_FIXED))
        maps.append(robustness_map(assembly, fixed, spacing=step, engine=engine))
    return maps


def support_points(
    maps: list[RobustnessMap], weight: float, up: Float, weights: Weights, region: Float
) -> SupportPoints:
    """Return the points of the maps that face up and lie in ``region`` (2, 3) [m], with their probabilities.

    ``weight`` [N] is the weight of the object, and ``up`` (3,) the unit vector opposite to gravity.
    """
    cells = {name: seen for found in maps for name, seen in found.cells.items()}
    return _chosen(cells, np.concatenate([found.force for found in maps]), weight, up, weights, region)


def unmapped_points(checks: Checks) -> SupportPoints:
    """Return the points of the supports without computing the pushes that they withstand; ``force`` is nan.

    Their probabilities are those of points that withstand any push.
    """
    assembly, search = checks.assembly, checks.search
    names = [body.name for body in assembly.bodies if body.name in checks.supports]
    step = max(search.spacing, spacing_for(assembly, names, MOST_FIXED))
    cells = {name: exposed_cells(assembly, name, step)[0] for name in names}
    force = np.full(sum(len(seen.points) for seen in cells.values()), np.nan)
    return _chosen(cells, force, 0.0, checks.up, search.weights, checks.region)


def _chosen(
    cells: Mapping[str, Cells], force: Float, weight: float, up: Float, weights: Weights, region: Float
) -> SupportPoints:
    """Return the points of cells that can carry weight and lie in the region, with their probabilities."""
    points = np.vstack([seen.points for seen in cells.values()])
    normals = np.vstack([seen.normals for seen in cells.values()])
    area = np.concatenate([seen.areas for seen in cells.values()])
    level = normals @ up
    kept = (level > STEEPEST) & ((points >= region[0]) & (points <= region[1])).all(1)
    sure = ~np.isfinite(force)
    share = np.where(sure, 1.0, force / (np.where(sure, 1.0, force) + weight))
    chance = np.where(kept, area * share**weights.robustness * np.maximum(level, 0.0) ** weights.level, 0.0)[kept]
    total = chance.sum()
    return SupportPoints(
        points=points[kept],
        normals=normals[kept],
        body=objects([name for name, seen in cells.items() for _ in seen.points])[kept],
        force=force[kept],
        area=area[kept],
        chance=chance / total if total > 0 else chance,
    )


def choose_points(
    support: SupportPoints, count: int, size: float, up: Float, apart: bool, rng: np.random.Generator
) -> Int:
    """Choose up to ``count`` points that an object of ``size`` [m] can span, and return their numbers.

    With ``apart``, they belong to different bodies.
    """
    chosen = [int(rng.choice(len(support.chance), p=support.chance))]
    while len(chosen) < count:
        chance = support.chance.copy()
        for k in chosen:
            arm = support.points - support.points[k]
            distance = np.linalg.norm(arm, axis=1)
            near = (distance < size) & (distance > LEAST_APART * size) & (np.abs(arm @ up) < STEEPEST_LINE * distance)
            if apart:
                near &= support.body != support.body[k]
            chance[~near] = 0
        if len(chosen) == 2:
            a, b = support.points[chosen]
            normal = np.cross(b - a, support.points - a)
            length = np.linalg.norm(normal, axis=1)
            wide = length > LEAST_APART * size * np.linalg.norm(b - a)
            chance[~(wide & (np.abs(normal @ up) > STEEPEST_PLANE * length))] = 0
        if not chance.sum() > 0:
            break
        chosen.append(int(rng.choice(len(chance), p=chance / chance.sum())))
    return np.array(chosen)


def pose_on(points: Float, normal: Float, face: Face, along: Float, rng: np.random.Generator) -> Float:
    """Return the pose (4, 4) with ``face`` on the plane of 1 to 3 points (n, 3) [m] with this ``normal`` (3,).

    With several points, the centre of mass lies between them. A single point lies anywhere in the face, more likely
    near the foot of the centre of mass. The longer side of the face points along ``along`` (3,).
    """
    if len(points) == 1:
        corner = rng.dirichlet(np.ones(len(face.corners))) @ face.corners
        on_face = face.foot + rng.random() ** 2 * (corner - face.foot)
        on_scene = points[0]
    else:
        on_face, on_scene = face.foot, rng.dirichlet(np.full(len(points), 3.0)) @ points
    body = np.column_stack([face.normal, face.along, np.cross(face.normal, face.along)])
    world = np.column_stack([-normal, along, np.cross(-normal, along)])
    turn = world @ body.T  # the face's normal to minus ``normal``, its longer side to ``along``
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = on_scene - turn @ on_face
    return pose


def plane_of(points: Float, normals: Float, up: Float) -> Float:
    """Return the unit normal (3,) of the plane through 1 to 3 points (n, 3) with surface ``normals`` (n, 3).

    With one point, it is the surface normal there. With two, the plane is as level as possible.
    """
    if len(points) == 1:
        return np.asarray(normals[0])
    along = unit(points[1] - points[0])
    if len(points) == 2:
        return unit(up - (up @ along) * along)
    normal = unit(np.cross(along, points[2] - points[0]))
    return normal if normal @ up > 0 else -normal


def direction_in(points: Float, normal: Float, edges: Float, rng: np.random.Generator) -> Float:
    """Choose a random unit direction (3,) in the plane for the longer side of the face.

    In a share ALIGNED of the cases, it is along or across one of the ``edges`` (m, 3) of the scene or a line between
    the points.
    """
    t1, t2 = tangents(normal)
    if rng.random() > ALIGNED:
        angle = rng.uniform(0, 2 * np.pi)
        return np.asarray(np.cos(angle) * t1 + np.sin(angle) * t2)
    lines = edges if len(points) == 1 else np.vstack([edges, unit(points[1:] - points[0])])
    flat = lines - (lines @ normal)[:, None] * normal
    flat = flat[np.linalg.norm(flat, axis=1) > 0.5]
    way = unit(flat[rng.integers(len(flat))]) if len(flat) else t1
    quarter = rng.integers(4)
    across = np.cross(normal, way)
    return np.asarray((way, across, -way, -across)[quarter])


@dataclass(frozen=True, eq=False)
class Proposals:
    """A generator of random poses of one object in one scene.

    ``checks`` are those of its poses; ``support`` holds the support points, and ``faces`` the faces of the object.
    """

    checks: Checks
    support: SupportPoints
    faces: tuple[Face, ...]

    @cached_property
    def moved(self) -> Moved:
        """The object, prepared for the contact search in any pose."""
        return Moved(self.checks.body)

    @cached_property
    def chances(self) -> Float:
        """The probability (n,) of choosing each face.

        It increases with the tilt at which the object still stands on the face. Facets of round sides have at most
        ROUND_SHARE together; unless orientations are given, faces on which the object is upright have at least
        UPRIGHT_SHARE.
        """
        tilt = np.array([face.tilt for face in self.faces])
        chance = np.where(tilt > 0, np.maximum(tilt, 0.0) ** self.checks.search.weights.steadiness, 0.0)
        if not chance.sum() > 0:
            return np.full(len(tilt), 1 / len(tilt))
        rolls = np.array([face.rolls for face in self.faces])
        if chance[~rolls].sum() > 0:
            chance = _at_most(chance, rolls, ROUND_SHARE)
        if self.checks.approach.prefers_upright:
            upright = np.array([face.upright for face in self.faces])
            if (chance[upright] > 0).any():
                chance = _at_most(chance, ~upright, 1 - UPRIGHT_SHARE)
        return np.asarray(chance / chance.sum())

    @cached_property
    def _stills(self) -> tuple[Still, ...]:
        with_object = Scene([*self.checks.assembly.bodies, self.checks.body], self.checks.friction)

        def mu(name: str) -> float | None:
            try:
                return with_object.mu(name, self.checks.body.name)
            except SceneError:
                return None

        return tuple(Still(body, mu(body.name), self.checks.up) for body in self.checks.frozen)

    @cached_property
    def _edges(self) -> Float:
        """The directions (n, 3) of the axes of all bodies of the scene."""
        axes = [body.pose[:3, :3].T for body in self.checks.assembly.bodies]
        return np.unique(np.round(np.vstack(axes), 6), axis=0)

    def points(self, rng: np.random.Generator) -> Int:
        """Choose the support points of a pose, and return their numbers."""
        wanted = self.checks.where.least_supports
        least = min(wanted, 3)
        chance = np.array(SEVERAL[least - 1 :])
        count = least + int(rng.choice(len(chance), p=chance / chance.sum()))
        return choose_points(self.support, count, self.moved.size, self.checks.up, wanted > 1, rng)

    def pose(self, places: Float, normals: Float, rng: np.random.Generator) -> Float:
        """Return a pose (4, 4) in which a face of the object lies on points (k, 3) [m] with ``normals`` (k, 3)."""
        normal = plane_of(places, normals, self.checks.up)
        turns = self.checks.turns
        if turns is None:
            face = self.faces[int(rng.choice(len(self.faces), p=self.chances))]
            along = direction_in(places, normal, self._edges, rng)
        else:
            turn = turns[rng.integers(len(turns))]
            face = min(self.faces, key=lambda f: float((turn @ f.normal) @ normal))
            along = direction_in(places, normal, self._edges, rng)
            if not self.checks.approach.free_yaw:
                level = turn @ face.along
                along = unit(level - (level @ normal) * normal)
        return pose_on(places, normal, face, along, rng)

    def let_down(self, pose: Float) -> Float | None:
        """Lower the object from just above ``pose`` (4, 4), or from above the scene if there is no room.

        Returns the pose (4, 4) at rest, or None.
        """
        lifted = pose.copy()
        lifted[:3, 3] += CLEARANCE * self.moved.size * self.checks.up
        approach = self.checks.approach
        from_afar = approach.direction is not None or approach.gripper is not None  # its way in is checked
        if from_afar or not self.checks.free(lifted):
            lowest = float((self.moved.surface(lifted).vertices @ self.checks.up).min())
            top = max(
                float((body.surface_world.vertices @ self.checks.up).max()) for body in self.checks.assembly.bodies
            )
            lifted[:3, 3] += max(top - lowest, 0.0) * self.checks.up
        return lowered(self.moved, lifted, self._stills, self.checks.up)


def _at_most(chance: Float, which: Bool, share: float) -> Float:
    """Return the probabilities ``chance`` (n,), scaled so that those of ``which`` (n,) are at most ``share`` of all."""
    some, rest = float(chance[which].sum()), float(chance[~which].sum())
    if some <= share * (some + rest):
        return chance
    return np.where(which, chance * (share / (1 - share)) * rest / some, chance)
