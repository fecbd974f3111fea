"""A body flush with a flat face below it: what one pose in the middle of the face says of the others.

On one plane, contact forces that only press are enough as long as the centre of mass is over the area of contact and
friction exceeds the slope; beyond the face, nothing turns the body back. So what an engine says of a body with its foot
in the middle of a face holds at all poses at which the same foot is flush with the face and the centre of mass well
over both. A little above the face, the body would come to rest there, so that it is not known to fall.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import tangents, transform
from holdfast.contacts.detect import Near, shared_length
from holdfast.contacts.flags import SHAKY
from holdfast.contacts.overlap import find_overlaps
from holdfast.contacts.tolerances import doubtful_gap
from holdfast.engines.answers import ONLY_BALANCED
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.graph.engine import Graph
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import outline_numbers
from holdfast.queries.poses.decisions import Decided, Groups, Locals, overlapping, quiet
from holdfast.queries.poses.neighbourhoods import Piece
from holdfast.queries.poses.outlines import Outline

FRICTION = 0.25  # share of the friction that leaning may use
SURELY = 0.9  # share of a tolerance within which nothing else about it matters
LEVEL = 1e-3  # sine of the angle up to which a body stands level enough to carry another one
SAME = 1e-9  # [rad, and of the body's size] difference of two poses that is rounding
STEEP = 2.0 ** np.arange(-3, 8)  # slopes λ that are tried
UPRIGHT = 0.9  # least cosine of the angle between a face and the horizontal
FALLS = "no contact forces balance every body: the centre of mass of {} is beyond the edge of {}"
TIPS = "no contact forces balance every body: nothing of {} that {} could hold is below its centre of mass"
ANYWHERE = "no contact forces balance every body: {} falls anywhere on {} at this height and lean"
HOVERS = "no contact within tolerance holds {}, but {} is within reach below and it would rest there: settle"


@dataclass(frozen=True, eq=False)
class Face:
    """A flat face of a convex part, in the frame of its body.

    ``normal`` (3,) points outward, and ``corners`` (k, 3) [m] bound the face. Points x over it have
    ``edges`` (m, 3) · x + ``offsets`` (m,) >= 0.
    """

    normal: Float
    corners: Float
    edges: Float
    offsets: Float

    @classmethod
    def of(cls, normal: Float, corners: Float) -> Face:
        """Return the face with these corners (k, 3) [m], in any order."""
        u, v = tangents(normal)
        flat = corners @ np.array([u, v]).T
        ring = flat[outline_numbers(flat)]  # counter-clockwise about u x v, the normal
        along = np.roll(ring, -1, axis=0) - ring
        inward = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
        return cls(normal, corners, inward @ np.array([u, v]), -(inward * ring).sum(1))

    @classmethod
    def highest(cls, part: Outline, up: Float) -> Face | None:
        """Return the face of a part that looks along ``up`` (3,) most of all, or None if it leans too much."""
        if part.unbounded:
            plane = cls(np.array([0.0, 0.0, 1.0]), np.zeros((1, 3)), np.zeros((0, 3)), np.zeros(0))
            return plane if up[2] > UPRIGHT else None
        facets = part.flat_facets if part.solid else []
        normal, corners = max(facets, key=lambda facet: float(facet[0] @ up), default=(-up, np.zeros((0, 3))))
        return cls.of(normal, corners) if normal @ up > UPRIGHT else None

    @cached_property
    def middle(self) -> Float:
        """The middle (3,) [m] of its corners."""
        return np.asarray(self.corners.mean(0))

    def room(self, points: Float) -> Float:
        """Return how far (n,) [m] points (n, 3) are inside the outline, seen along the normal."""
        return np.asarray((points @ self.edges.T + self.offsets).min(1, initial=np.inf))


@dataclass(frozen=True, eq=False)
class Below:
    """A ``face`` below the moved body, of the body ``name``; ``only_part`` tells whether it has no other ``part``."""

    name: str
    part: int
    face: Face
    only_part: bool


class Flush(NamedTuple):
    """Where (n,) a foot ``touches`` a face or ``hovers`` within reach above it, flush with it.

    The centre of mass is ``over`` it or ``beyond`` its edge; where it is neither, that is too close to say.
    """

    touches: Bool
    hovers: Bool
    over: Bool
    beyond: Bool


@dataclass(frozen=True, eq=False)
class OnFaces:
    """The moved body ``name`` on flat faces of others."""

    local: Locals
    name: str
    _faces: dict[int, Below | None] = field(default_factory=dict, init=False, repr=False)
    _stood: dict[tuple[str, int, int], Decided | None] = field(default_factory=dict, init=False, repr=False)

    def at_once(self, piece: Piece, rows: Int, rest: Groups) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which the body is flush with a face, and the verdicts on the groups of its piece.

        ``rest`` are the groups beside it, all of which stand.
        """
        if not isinstance(self.local.engine, Compliant | Limit | Graph):
            return
        around = self.local.around
        meets = around.meets[rows, around.given.names.index(self.name)]
        for number, (its, _) in enumerate(around.parts):
            below = self._below(number) if its in piece.beside and len(rows) else None
            if below is not None:
                alone = ~np.delete(meets, number, axis=1).any(1)
                yield from self._over(piece, rows[alone], rest, below)
                if around.assembly.scene.body(its).fixed:
                    yield from self._into_others(piece, rows[~alone], meets[~alone], rest, below)

    @cached_property
    def _feet(self) -> list[Face]:
        """The faces of the body on which it can stand."""
        around = self.local.around
        body, (outline, *more) = around.assembly.scene.body(self.name), around.outlines[self.name]
        feet = [Face.of(*facet) for facet in ([] if more or not outline.solid else outline.flat_facets)]
        return [foot for foot in feet if foot.room(body.com_body[None])[0] > 0]

    def _below(self, number: int) -> Below | None:
        """Return the face of the part with this number on which the body may stand, or None."""
        if number not in self._faces:
            around = self.local.around
            scene, (its, part) = around.assembly.scene, around.parts[number]
            body, other = scene.body(self.name), scene.body(its)
            apart = its in around.given.names or scene.touching(body, other) != [(body, other)]
            face = None if apart else Face.highest(part, scene.up @ other.pose[:3, :3])
            self._faces[number] = None if face is None else Below(its, number, face, len(around.outlines[its]) == 1)
        return self._faces[number]

    def _over(self, piece: Piece, rows: Int, rest: Groups, below: Below) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which the body is flush with one face and touches nothing else."""
        its, placed = below.name, self._placed(rows, below)
        alone = self.local.around.assembly.scene.body(its).fixed and below.only_part and piece.beside == {its}
        left = np.ones(len(rows), dtype=bool)
        for number in range(len(self._feet)):
            flush = self._flush(placed, below, number)
            stands = flush.touches & flush.over & self._carried(placed, below, rest)
            stood = self._stood_on(below, number) if stands.any() else None
            if stood is not None:
                left &= ~stands
                yield rows[stands], (stood, *(group for group in rest if its not in group.names))
            rests = flush.hovers & flush.over
            left &= ~rests
            yield rows[rests], (self._said(Status.UNDECIDED, HOVERS, its), *rest)
            if alone:
                falls = (flush.touches | flush.hovers) & flush.beyond
                left &= ~falls
                yield rows[falls], (self._said(Status.UNSTABLE, FALLS, its), *rest)
        if alone:
            rows, placed = rows[left], placed[left]
            tips = self._tips(placed, below)
            yield rows[tips], (self._said(Status.UNSTABLE, TIPS, its), *rest)
            yield from self._alike(piece, below, rows[~tips], placed[~tips])

    def _into_others(
        self, piece: Piece, rows: Int, meets: Bool, rest: Groups, below: Below
    ) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which the body stands on a fixed face and overlaps other bodies, that it ``meets`` (n, P).

        All of these stand without each other, so that nothing falls but for what they do where they overlap.
        """
        around = self.local.around
        scene, tolerances = around.assembly.scene, around.assembly.tolerances
        placed = self._placed(rows, below)
        for number in range(len(self._feet)):
            flush = self._flush(placed, below, number)
            for k in np.flatnonzero(flush.touches & flush.over).tolist():
                met = dict.fromkeys(around.parts[part][0] for part in np.flatnonzero(meets[k]))
                there = scene.body(self.name).moved(around.given.of(self.name)[rows[k]])
                pairs = [
                    pair
                    for name in met
                    if name != below.name
                    for pair in scene.touching(*sorted((there, scene.body(name)), key=lambda b: around.order(b.name)))
                ]
                limits = tolerances.of_pairs((scene.body(a.name), scene.body(b.name)) for a, b in pairs)
                near = [Near(a, b, shared_length(a, b), own) for (a, b), own in zip(pairs, limits, strict=True)]
                deep = find_overlaps(scene, tolerances, near=near)
                if deep:
                    yield rows[k : k + 1], overlapping(self.name, {o.bodies: o.text for o in deep}, rest)

    def _placed(self, rows: Int, below: Below) -> Float:
        """Return the poses (n, 4, 4) of the body in the frame of the one below."""
        around = self.local.around
        return np.asarray(np.linalg.inv(around.assembly.scene.body(below.name).pose) @ around.given.of(self.name)[rows])

    def _along_gravity(self, placed: Float, below: Below) -> tuple[Float, Float]:
        """Return where the weight acts on the plane of a face (n, 3), and along which direction (3,), in its frame."""
        scene, face = self.local.around.assembly.scene, below.face
        down = -scene.up @ scene.body(below.name).pose[:3, :3]
        com = placed[:, :3, :3] @ scene.body(self.name).com_body + placed[:, :3, 3]
        return com - down * ((com - face.middle) @ face.normal / (down @ face.normal))[:, None], down

    def _flush(self, placed: Float, below: Below, number: int) -> Flush:
        """Tell at which poses ``placed`` (n, 4, 4) a foot is flush with a face."""
        around, face, foot = self.local.around, below.face, self._feet[number]
        body, other = (around.assembly.scene.body(name) for name in (self.name, below.name))
        own, base = around.assembly.tolerances.between(body, other), around.assembly.tolerances.base(body, other)
        turned, moved = placed[:, :3, :3], placed[:, :3, 3]
        over, down = self._along_gravity(placed, below)
        leaning = np.linalg.norm(np.cross(turned @ foot.normal, face.normal), axis=1)
        slope = float(np.linalg.norm(np.cross(down, face.normal)))
        heights = (foot.corners @ np.swapaxes(turned, 1, 2) + moved[:, None] - face.middle) @ face.normal
        flat = (turned @ foot.normal) @ face.normal < 0
        flat &= leaning <= SURELY * SHAKY * np.sin(np.radians(own.angle))
        flat &= leaning + slope <= FRICTION * self._friction(below.name)
        flat &= foot.room(((over - moved)[:, None] @ turned)[:, 0]) > 2 * own.gap
        lowest, highest, room = heights.min(1), heights.max(1), face.room(over)
        touches = flat & (np.maximum(-lowest, highest) <= SURELY * SHAKY * base)
        hovers = flat & (lowest > own.gap / SURELY) & (highest < SURELY * doubtful_gap(body, other))
        return Flush(touches, hovers, room > 2 * own.gap, room < -2 * own.gap)

    def _alike(self, piece: Piece, below: Below, rows: Int, placed: Float) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which all is the same but for the place on a level face and the turn about its normal.

        ``placed`` (n, 4, 4) are the poses in the frame of the face's body. All of the body has to be over the face.
        """
        around, face = self.local.around, below.face
        body, other = (around.assembly.scene.body(name) for name in (self.name, below.name))
        if np.linalg.norm(np.cross(around.assembly.scene.up @ other.pose[:3, :3], face.normal)) > SAME:
            return
        corners = np.vstack([part.corners for part in around.outlines[self.name]])
        inside = np.array([face.room(transform(pose, corners)).min() for pose in placed]) > around.reach(body, other)
        at = np.flatnonzero(inside)
        heights = (placed[at, :3, 3] - face.middle) @ face.normal / body.shape.surface.diagonal
        keys = np.round(np.column_stack([face.normal @ placed[at, :3, :3], heights]) / SAME).astype(np.int64)
        _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        for number in np.flatnonzero(np.bincount(which.ravel()) > 1):
            with quiet():
                (own,) = self.local.decided(piece, around.given.row(int(rows[at[first[number]]])))
            if own.status is Status.UNSTABLE:
                own = replace(own, reason=ANYWHERE.format(self.name, below.name))
            yield rows[at[which.ravel() == number]], (own,)

    def _tips(self, placed: Float, below: Below) -> Bool:
        """Tell at which poses ``placed`` (n, 4, 4) over a fixed face nothing of the body is below its centre of mass.

        Only points of the body within reach of the plane, at heights h <= reach, can ever be held by it; the farthest
        of them along any direction d is at most max(d · x - λ (h - reach)) over the corners, for any λ >= 0. Friction
        moves the line of their forces by no more than μ times the reach, and so do faces that lean a little.
        """
        around, face = self.local.around, below.face
        body, other = (around.assembly.scene.body(name) for name in (self.name, below.name))
        own, base = around.assembly.tolerances.between(body, other), around.assembly.tolerances.base(body, other)
        reach = max(doubtful_gap(body, other), own.gap) / SURELY
        corners = np.vstack([part.corners for part in around.outlines[self.name]])
        radius = max(part.radius for part in around.outlines[self.name])
        points = corners @ np.swapaxes(placed[:, :3, :3], 1, 2) + placed[:, None, :3, 3]
        heights = (points - face.middle) @ face.normal - radius
        over, _ = self._along_gravity(placed, below)
        above = heights.min(1) >= -SURELY * SHAKY * base
        above &= (points @ face.edges.T + face.offsets).min((1, 2), initial=np.inf) >= reach + radius
        lowest = np.take_along_axis(points, heights.argmin(1)[:, None, None], axis=1)[:, 0]
        towards = over - lowest
        towards -= np.outer(towards @ face.normal, face.normal)
        towards /= np.maximum(np.linalg.norm(towards, axis=1), 1e-300)[:, None]
        onward = ((points - over[:, None]) @ towards[:, :, None])[..., 0] + radius
        least = -(onward[..., None] - (heights - reach)[..., None] * STEEP).max(1).min(1)
        leaning = self._friction(below.name) + np.sin(np.radians(own.angle))
        return np.asarray(above & (least > leaning * reach + 2 * own.gap))

    def _said(self, status: Status, words: str, its: str) -> Decided:
        moving = (self.name,) if status is Status.UNSTABLE else ()
        return Decided((self.name,), status, words.format(self.name, its), moving)

    def _friction(self, its: str) -> float:
        """Return the least coefficient of friction of any of the materials of the body and another one."""
        scene = self.local.around.assembly.scene
        one, two = scene.body(self.name), scene.body(its)
        return min(
            scene.friction.between(self.name, its, {self.name: a, its: b}) for a in one.materials for b in two.materials
        )

    def _carried(self, placed: Float, below: Below, rest: Groups) -> Bool:
        """Tell at which poses ``placed`` (n, 4, 4) the body below carries the moved one, and does not tip over.

        A fixed one does. A movable one has to stand alone and level on fixed ones, with the weight well over its base.
        """
        around, its = self.local.around, below.name
        scene = around.assembly.scene
        if scene.body(its).fixed:
            return np.ones(len(placed), dtype=bool)
        assert around.rest is not None
        patches = [p for i in around.rest.interfaces if its in i.bodies for p in i.patches]
        level = all(np.linalg.norm(np.cross(patch.normal, scene.up)) <= LEVEL for patch in patches)
        if not level or all(group.names != (its,) for group in rest):
            return np.zeros(len(placed), dtype=bool)
        base = Face.of(scene.up, np.vstack([patch.polygon for patch in patches]))
        over, _ = self._along_gravity(placed, below)
        return np.asarray(base.room(scene.body(its).placed(over)) > 2 * around.gap(self.name, its))

    def _stood_on(self, below: Below, number: int) -> Decided | None:
        """Return what the engine says of a foot in the middle of a face; None if not that the body stands."""
        key = (below.name, below.part, number)
        if key not in self._stood:
            scene, foot, face = self.local.around.assembly.scene, self._feet[number], below.face
            body, other = scene.body(self.name), scene.body(below.name)
            turn = _frame(face.normal) @ _frame(-foot.normal).T
            down = -scene.up @ other.pose[:3, :3]
            com = turn @ body.com_body
            height = (com - turn @ foot.middle) @ face.normal
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = turn, face.middle + down * height / (down @ face.normal) - com
            piece = self.local.around.piece_on(self.name, below.name)
            with quiet():
                groups = self.local.decided(piece, {self.name: other.pose @ pose})
            (stood,) = (group for group in groups if self.name in group.names)
            known = stood.status is Status.STABLE and ONLY_BALANCED not in stood.reason
            self._stood[key] = stood if known else None
        return self._stood[key]


def _frame(normal: Float) -> Float:
    """Return a rotation (3, 3) that takes the z axis to ``normal`` (3,)."""
    return np.column_stack([*tangents(normal), normal])
