"""Propose poses: lay a face of the object on points of the scene that withstand large pushes, and lower it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.applications.placement.contact_poses import choose_points, direction_in, plane_of, pose_on
from holdfast.applications.placement.lowering import Moved, Still, lowered
from holdfast.applications.placement.options import Options
from holdfast.applications.placement.support import SupportPoints
from holdfast.applications.standing_faces import Face
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float, Int, unit
from holdfast.base.errors import SceneError
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

CLEARANCE = 0.02  # height above its place from which the object is lowered, as a share of its size
SEVERAL = (0.5, 0.35, 0.15)  # probabilities of building a pose on one, two and three points
UPRIGHT_SHARE = 0.5  # smallest share of proposals with the object upright, if it can stand upright
ROUND_SHARE = 0.25  # largest share of proposals on facets of round sides, if the object also has flat faces


@dataclass(frozen=True, eq=False)
class Proposals:
    """A generator of random poses of one object in one scene.

    ``support`` holds the support points, ``faces`` the faces of the object, and ``still`` the bodies of the scene, all
    fixed. ``free`` returns whether the object overlaps no closed body of the scene in a pose (4, 4).
    """

    assembly: Assembly
    body: Body
    options: Options
    support: SupportPoints
    faces: tuple[Face, ...]
    still: tuple[Body, ...]
    free: Callable[[Float], bool]

    @property
    def up(self) -> Float:
        """The unit vector (3,) opposite to gravity, world frame."""
        return self.assembly.scene.up

    @cached_property
    def moved(self) -> Moved:
        """The object, prepared for the contact search in any pose."""
        return Moved(self.body)

    @cached_property
    def chances(self) -> Float:
        """The probability (n,) of choosing each face.

        It increases with the tilt at which the object still stands on the face. Facets of round sides have at most
        ROUND_SHARE together; unless orientations are given, faces on which the object is upright have at least
        UPRIGHT_SHARE.
        """
        tilt = np.array([face.tilt for face in self.faces])
        chance = np.where(tilt > 0, np.maximum(tilt, 0.0) ** self.options.weights.steadiness, 0.0)
        if not chance.sum() > 0:
            return np.full(len(tilt), 1 / len(tilt))
        rolls = np.array([face.rolls for face in self.faces])
        if chance[~rolls].sum() > 0:
            chance = _at_most(chance, rolls, ROUND_SHARE)
        if self.options.prefer_upright:
            upright = np.array([face.upright for face in self.faces])
            if (chance[upright] > 0).any():
                chance = _at_most(chance, ~upright, 1 - UPRIGHT_SHARE)
        return np.asarray(chance / chance.sum())

    @cached_property
    def _stills(self) -> tuple[Still, ...]:
        with_object = Scene([*self.assembly.bodies, self.body], self.options.friction)

        def mu(name: str) -> float | None:
            try:
                return with_object.mu(name, self.body.name)
            except SceneError:
                return None

        return tuple(Still(body, mu(body.name), self.up) for body in self.still)

    @cached_property
    def _edges(self) -> Float:
        """The directions (n, 3) of the axes of all bodies of the scene."""
        axes = [body.pose[:3, :3].T for body in self.assembly.bodies]
        return np.unique(np.round(np.vstack(axes), 6), axis=0)

    @cached_property
    def _top(self) -> float:
        """The highest coordinate of the whole scene along ``up`` [m]."""
        return max(float((body.surface_world.vertices @ self.up).max()) for body in self.assembly.bodies)

    def points(self, rng: np.random.Generator) -> Int:
        """Choose the support points of a pose, and return their numbers."""
        least = min(self.options.least_supports, 3)
        chance = np.array(SEVERAL[least - 1 :])
        count = least + int(rng.choice(len(chance), p=chance / chance.sum()))
        return choose_points(self.support, count, self.moved.size, self.up, self.options.least_supports > 1, rng)

    def pose(self, places: Float, normals: Float, rng: np.random.Generator) -> Float:
        """Return a pose (4, 4) in which a face of the object lies on points (k, 3) [m] with ``normals`` (k, 3)."""
        normal = plane_of(places, normals, self.up)
        allowed = self.options.orientations
        if allowed is None:
            face = self.faces[int(rng.choice(len(self.faces), p=self.chances))]
            along = direction_in(places, normal, self._edges, rng)
        else:
            turn = allowed[rng.integers(len(allowed))]
            face = min(self.faces, key=lambda f: float((turn @ f.normal) @ normal))
            along = direction_in(places, normal, self._edges, rng)
            if not self.options.free_yaw:
                level = turn @ face.along
                along = unit(level - (level @ normal) * normal)
        return pose_on(places, normal, face, along, rng)

    def let_down(self, pose: Float) -> Float | None:
        """Lower the object from just above ``pose`` (4, 4), or from above the scene if there is no room.

        Returns the pose (4, 4) at rest, or None.
        """
        lifted = pose.copy()
        lifted[:3, 3] += CLEARANCE * self.moved.size * self.up
        if self.options.from_afar or not self.free(lifted):
            lowest = float((self.moved.surface(lifted).vertices @ self.up).min())
            lifted[:3, 3] += max(self._top - lowest, 0.0) * self.up
        return lowered(self.moved, lifted, self._stills, self.up)


def _at_most(chance: Float, which: Bool, share: float) -> Float:
    """Return the probabilities ``chance`` (n,), scaled so that those of ``which`` (n,) are at most ``share`` of all."""
    some, rest = float(chance[which].sum()), float(chance[~which].sum())
    if some <= share * (some + rest):
        return chance
    return np.where(which, chance * (share / (1 - share)) * rest / some, chance)
