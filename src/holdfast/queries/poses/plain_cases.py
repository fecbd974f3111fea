"""Poses of a single body that are decided for all at once: in the air, deep in others, and flush with a flat face.

On one plane, contact forces that only press are enough as long as the centre of mass is over the area of contact and
friction exceeds the slope; beyond the face, nothing turns the body back. So what an engine says of a body with its foot
in the middle of a face holds at all poses at which the same foot is flush with the face and the centre of mass well
over both. A little above the face, the body would come to rest there, so that it is not known to fall.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import compress
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.rigid import tangents, transform
from holdfast.contacts.contact_search import SHAKY
from holdfast.contacts.tolerances import doubtful_gap
from holdfast.engines.answers import ONLY_BALANCED
from holdfast.engines.compliant.engine import Compliant
from holdfast.engines.graph.engine import Graph
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status
from holdfast.geometry.hull import outline_numbers
from holdfast.queries.poses.neighbourhoods import Decided, Groups, Neighbourhood, Neighbourhoods
from holdfast.queries.poses.outlines import PartHull, shared_ball
from holdfast.queries.request import quiet
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

FRICTION = 0.25  # share of the friction that leaning may use
SURELY = 0.9  # share of a tolerance within which nothing else about it matters
LEVEL = 1e-3  # sine of the angle up to which a body stands level enough to carry another one
SAME = 1e-9  # [rad, and of the body's size] difference of two poses that is rounding
UPRIGHT = 0.9  # least cosine of the angle between a face and the horizontal
IN_THE_AIR = "unsupported: {}: no chain of contacts leads to a fixed body; nothing is within reach of it"
OVERLAP = (
    "{} and {} overlap by more than their tolerance of {}, so what they carry there is "
    "not known: settle, or correct the poses"
)
FALLS = "no contact forces balance every body: the centre of mass of {} is beyond the edge of {}"
ANYWHERE = "no contact forces balance every body: {} falls anywhere on {} at this height and lean"
HOVERS = "no contact within tolerance holds {}, but {} is within reach below and it would rest there: settle"
SURE = 2.0  # [gaps] radius of a ball that two bodies share, which proves an overlap of 4/3 gaps between convex bodies


@dataclass(frozen=True, eq=False)
class FlatFace:
    """A flat face of a convex part, in the frame of its body.

    ``normal`` (3,) points outward, and ``corners`` (k, 3) [m] bound the face. Points x over it have
    ``edges`` (m, 3) · x + ``offsets`` (m,) >= 0.
    """

    normal: Float
    corners: Float
    edges: Float
    offsets: Float

    @classmethod
    def of(cls, normal: Float, corners: Float) -> FlatFace:
        """Return the face with these corners (k, 3) [m], in any order."""
        u, v = tangents(normal)
        flat = corners @ np.array([u, v]).T
        ring = flat[outline_numbers(flat)]  # counter-clockwise about u x v, the normal
        along = np.roll(ring, -1, axis=0) - ring
        inward = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
        return cls(normal, corners, inward @ np.array([u, v]), -(inward * ring).sum(1))

    @classmethod
    def highest(cls, part: PartHull, up: Float) -> FlatFace | None:
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
class FaceBelow:
    """A ``face`` below the moved body, of a ``part`` of ``body``; ``whole`` tells whether that is all of it."""

    body: Body
    part: int
    face: FlatFace
    whole: bool


class Flush(NamedTuple):
    """Where (n,) a foot ``touches`` a face or ``hovers`` within reach above it, flush with it.

    The centre of mass is ``over`` it or ``beyond`` its edge; where it is neither, that is too close to say.
    """

    touches: Bool
    hovers: Bool
    over: Bool
    beyond: Bool


@dataclass(frozen=True, eq=False)
class PlainCases:
    """The verdicts that follow from where the moved body ``name`` is, without a search for contacts."""

    around: Neighbourhoods
    name: str
    _faces: dict[int, FaceBelow | None] = field(default_factory=dict, init=False, repr=False)
    _stood: dict[tuple[str, int, int], Decided | None] = field(default_factory=dict, init=False, repr=False)

    def at_once(self, piece: Neighbourhood, rows: Int) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which a piece has the same verdicts; all other ``rows`` have to be decided one by one."""
        around, name = self.around, self.name
        if len(piece.moved) > 1 or around.rest is None or self._scene.friction.joins:  # faces may hold what hangs
            return
        if not piece.beside:
            yield rows, (Decided((name,), Status.UNSTABLE, IN_THE_AIR.format(name), (name,)),)
            return
        rest = tuple(group for group in around.rest_groups if not piece.others.isdisjoint(group.names))
        if any(group.status is not Status.STABLE for group in rest):
            return
        near = around.meets[rows, around.given.names.index(name)]
        parts = [[other == beside for other, _ in around.parts] for beside in sorted(piece.beside)]
        deep, meets = self._deep(piece, rows), (near[:, None] & np.array(parts)).any(2)  # both in alphabetical order
        left = np.ones(len(rows), dtype=bool)
        for pattern in np.unique(np.hstack([deep, meets]), axis=0):
            into, touched = (set(compress(sorted(piece.beside), part)) for part in np.split(pattern, 2))
            movable = {other for other in touched if not self._scene.body(other).fixed}
            # whatever falls would move the overlapping bodies against each other, which nobody knows to happen
            if into and movable <= into:
                at = (deep == pattern[: deep.shape[1]]).all(1) & (meets == pattern[deep.shape[1] :]).all(1)
                left &= ~at
                yield rows[at], self._overlapping(into, rest)
        if isinstance(around.engine, Compliant | Limit | Graph):
            rows, near = rows[left], near[left]
            for number, (its, _) in enumerate(around.parts):
                below = self._below(number) if its in piece.beside and len(rows) else None
                if below is not None:
                    yield from self._over(piece, rows[~np.delete(near, number, axis=1).any(1)], rest, below)

    @property
    def _scene(self) -> Scene:
        return self.around.assembly.scene

    @property
    def _body(self) -> Body:
        return self._scene.body(self.name)

    def _overlapping(self, into: set[str], rest: Groups) -> Groups:
        """Return the verdicts where the body overlaps those of ``into``; ``rest`` are the groups beside it."""
        place, texts = self.around.order.__getitem__, {}
        for other in sorted(into, key=place):
            pair = tuple(sorted((self.name, other), key=place))
            texts[pair] = OVERLAP.format(*pair, f"{1e3 * self.around.gap(self.name, other):.2g} mm")
        found = [Decided((self.name,), Status.UNDECIDED, "; ".join(texts.values()))]
        for group in rest:
            said = [text for pair, text in texts.items() if not set(pair).isdisjoint(group.names)]
            found.append(Decided(group.names, Status.UNDECIDED, "; ".join(said)) if said else group)
        return tuple(found)

    def _deep(self, piece: Neighbourhood, rows: Int) -> Bool:
        """Tell which of the bodies beside a piece, in alphabetical order, surely overlap the body (n, m)."""
        around, body, own = self.around, self._body, self.around.outlines[self.name]
        apart = around.apart[rows, around.given.names.index(self.name)]
        deep = np.zeros((len(rows), len(piece.beside)), dtype=bool)
        for number, beside in enumerate(sorted(piece.beside)):
            other, its = self._scene.body(beside), around.outlines[beside]
            if len(own) > 1 or len(its) > 1 or self._scene.touching(body, other) != [(body, other)]:
                continue
            sure = self._sure(body, other)
            part = next(k for k, (each, _) in enumerate(around.parts) if each == beside)
            at = np.flatnonzero(apart[:, part] <= -2 * sure)  # along any direction they share twice the ball's radius
            poses = around.given.of(self.name)[rows[at]]
            deep[at, number] = shared_ball(own[0], poses, its[0], np.broadcast_to(other.pose, poses.shape)) > sure
        return deep

    def _sure(self, a: Body, b: Body) -> float:
        """Return the radius [m] of a ball in two convex bodies, beyond which they overlap and do not touch as well.

        A convex part of volume V and area A with a ball of radius r inside has V >= r A / 3, and an overlap counts as
        2 V / A deep at least. If the two touched within their gap somewhere, a plane there would have both on different
        sides, but for the gap and the angle that is allowed between their faces.
        """
        own = self.around.assembly.tolerances.between(a, b)
        if a.fixed or b.fixed:  # where else they touch makes no difference
            return SURE * own.gap
        return SURE * own.gap + float(np.sin(np.radians(own.angle))) * min(o.shape.surface.diagonal for o in (a, b))

    @cached_property
    def _feet(self) -> list[FlatFace]:
        """The faces of the body on which it can stand."""
        outline, *more = self.around.outlines[self.name]
        feet = [FlatFace.of(*facet) for facet in ([] if more or not outline.solid else outline.flat_facets)]
        return [foot for foot in feet if foot.room(self._body.com_body[None])[0] > 0]

    def _below(self, number: int) -> FaceBelow | None:
        """Return the face of the part with this number on which the body may stand, or None."""
        if number not in self._faces:
            its, part = self.around.parts[number]
            body, other = self._body, self._scene.body(its)
            apart = its in self.around.given.names or self._scene.touching(body, other) != [(body, other)]
            face = None if apart else FlatFace.highest(part, self._scene.up @ other.pose[:3, :3])
            whole = len(self.around.outlines[its]) == 1
            self._faces[number] = None if face is None else FaceBelow(other, number, face, whole)
        return self._faces[number]

    def _over(self, piece: Neighbourhood, rows: Int, rest: Groups, below: FaceBelow) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which the body is flush with one face and touches nothing else; all of the ``rest`` stands."""
        its = below.body.name
        placed = np.linalg.inv(below.body.pose) @ self.around.given.of(self.name)[rows]  # in the frame of that body
        alone = below.body.fixed and below.whole and piece.beside == {its}
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
            yield rows[rests], (Decided((self.name,), Status.UNDECIDED, HOVERS.format(self.name, its)), *rest)
            if alone:
                falls = (flush.touches | flush.hovers) & flush.beyond
                left &= ~falls
                said = Decided((self.name,), Status.UNSTABLE, FALLS.format(self.name, its), (self.name,))
                yield rows[falls], (said, *rest)
        if alone:
            yield from self._alike(piece, below, rows[left], placed[left])

    def _along_gravity(self, placed: Float, below: FaceBelow) -> tuple[Float, Float]:
        """Return where the weight acts on the plane of a face (n, 3), and along which direction (3,), in its frame."""
        face, down = below.face, -self._scene.up @ below.body.pose[:3, :3]
        com = placed[:, :3, :3] @ self._body.com_body + placed[:, :3, 3]
        return com - down * ((com - face.middle) @ face.normal / (down @ face.normal))[:, None], down

    def _flush(self, placed: Float, below: FaceBelow, number: int) -> Flush:
        """Tell at which poses ``placed`` (n, 4, 4) a foot is flush with a face."""
        body, other, face, foot = self._body, below.body, below.face, self._feet[number]
        tolerances, friction = self.around.assembly.tolerances, self._scene.friction
        own, base = tolerances.between(body, other), tolerances.base(body, other)
        mu = min(
            friction.between(body.name, other.name, {body.name: one, other.name: two})
            for one in body.materials
            for two in other.materials
        )
        turned, moved = placed[:, :3, :3], placed[:, :3, 3]
        over, down = self._along_gravity(placed, below)
        leaning = np.linalg.norm(np.cross(turned @ foot.normal, face.normal), axis=1)
        slope = float(np.linalg.norm(np.cross(down, face.normal)))
        heights = (foot.corners @ np.swapaxes(turned, 1, 2) + moved[:, None] - face.middle) @ face.normal
        flat = (turned @ foot.normal) @ face.normal < 0
        flat &= leaning <= SURELY * SHAKY * np.sin(np.radians(own.angle))
        flat &= leaning + slope <= FRICTION * mu
        flat &= foot.room(((over - moved)[:, None] @ turned)[:, 0]) > 2 * own.gap
        lowest, highest, room = heights.min(1), heights.max(1), face.room(over)
        touches = flat & (np.maximum(-lowest, highest) <= SURELY * SHAKY * base)
        hovers = flat & (lowest > own.gap / SURELY) & (highest < SURELY * doubtful_gap(body, other))
        return Flush(touches, hovers, room > 2 * own.gap, room < -2 * own.gap)

    def _alike(self, piece: Neighbourhood, below: FaceBelow, rows: Int, placed: Float) -> Iterator[tuple[Int, Groups]]:
        """Yield rows at which all is the same but for the place on a level face and the turn about its normal.

        ``placed`` (n, 4, 4) are the poses in the frame of the face's body. All of the body has to be over the face.
        """
        around, body, face = self.around, self._body, below.face
        if np.linalg.norm(np.cross(self._scene.up @ below.body.pose[:3, :3], face.normal)) > SAME:
            return
        corners = np.vstack([part.corners for part in around.outlines[self.name]])
        reach = around.reach(body, below.body)
        at = np.flatnonzero(np.array([face.room(transform(pose, corners)).min() for pose in placed]) > reach)
        heights = (placed[at, :3, 3] - face.middle) @ face.normal / body.shape.surface.diagonal
        keys = np.round(np.column_stack([face.normal @ placed[at, :3, :3], heights]) / SAME).astype(np.int64)
        _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        for number in np.flatnonzero(np.bincount(which.ravel()) > 1):
            with quiet():
                (own,) = around.verdicts_on(around.at(piece, around.given.row(int(rows[at[first[number]]]))))
            if own.status is Status.UNSTABLE:
                own = replace(own, reason=ANYWHERE.format(self.name, below.body.name))
            yield rows[at[which.ravel() == number]], (own,)

    def _carried(self, placed: Float, below: FaceBelow, rest: Groups) -> Bool:
        """Tell at which poses ``placed`` (n, 4, 4) the body below carries the moved one, and does not tip over.

        A fixed one does. A movable one has to stand alone and level on fixed ones, with the weight well over its base.
        """
        its, up = below.body.name, self._scene.up
        if below.body.fixed:
            return np.ones(len(placed), dtype=bool)
        assert self.around.rest is not None
        patches = [p for i in self.around.rest.interfaces if its in i.bodies for p in i.patches]
        level = all(np.linalg.norm(np.cross(patch.normal, up)) <= LEVEL for patch in patches)
        if not level or all(group.names != (its,) for group in rest):
            return np.zeros(len(placed), dtype=bool)
        base = FlatFace.of(up, np.vstack([patch.polygon for patch in patches]))
        over, _ = self._along_gravity(placed, below)
        return np.asarray(base.room(below.body.placed(over)) > 2 * self.around.gap(self.name, its))

    def _stood_on(self, below: FaceBelow, number: int) -> Decided | None:
        """Return what the engine says of a foot in the middle of a face; None if not that the body stands."""
        key = (below.body.name, below.part, number)
        if key not in self._stood:
            foot, face, other = self._feet[number], below.face, below.body
            turn = _frame(face.normal) @ _frame(-foot.normal).T
            down = -self._scene.up @ other.pose[:3, :3]
            com = turn @ self._body.com_body
            height = (com - turn @ foot.middle) @ face.normal
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = turn, face.middle + down * height / (down @ face.normal) - com
            alone = frozenset({other.name})
            piece = Neighbourhood((self.name,), alone, frozenset(self.around.with_all_near(alone)))
            with quiet():
                groups = self.around.verdicts_on(self.around.at(piece, {self.name: other.pose @ pose}))
            (stood,) = (group for group in groups if self.name in group.names)
            known = stood.status is Status.STABLE and ONLY_BALANCED not in stood.reason
            self._stood[key] = stood if known else None
        return self._stood[key]


def _frame(normal: Float) -> Float:
    """Return a rotation (3, 3) that takes the z axis to ``normal`` (3,)."""
    return np.column_stack([*tangents(normal), normal])
