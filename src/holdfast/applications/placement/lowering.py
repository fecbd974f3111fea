"""Let an object down onto a scene that does not move: along a plumb line, then as it tips, until friction holds it.

A step is the motion that lowers the centre of mass most among those that contacts allow: at each of them the relative
velocity u has u_n >= mu |u_t| (or opens what is open before it closes). By duality no such motion lowers it where
contact forces within friction cones can carry the weight, so that the object stops where it can rest, not where it is
lowest. Slow: no momentum, and the scene under it is taken as fixed; what it does to the scene is judged afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import starmap

import numpy as np
from scipy import sparse

from holdfast.base.arrays import Float, unit
from holdfast.base.errors import SceneError, message
from holdfast.base.rigid import tangents, transform
from holdfast.base.values import sealed
from holdfast.conic.program import ConeKind, ConeProgram
from holdfast.conic.solve import Outcome, solve
from holdfast.contacts.features import Features, touching_features
from holdfast.contacts.skin import Skin, near_faces
from holdfast.geometry.surface import Surface
from holdfast.geometry.sweep import Swept, hit_distance
from holdfast.scene.body import Body

STEP = 0.08  # of the object's half size: the longest step, and in radians the largest turn
REACH = 2.5  # steps: features further apart do not matter in one
AT_REST = 1e-6  # steps: a shorter one is none
TOUCHING = 1e-5  # of the object's size: friction holds at what is nearer
PARALLEL = 3.0  # [deg] edges and faces within it are met at both their ends
CAUTION = 1e-3  # weight of a step's length beside the descent: of equally deep ones the shortest is taken
MOST_STEPS = 80
NEGLIGIBLE = 1e-6  # of the size: sharp edges are stayed away from by this


@dataclass(frozen=True, eq=False)
class Still:
    """A body of the scene that counts as fixed, made ready for the search of contacts.

    ``mu`` towards the object; None where it is not known, which is an error as soon as they come near each other.
    ``up`` (3,) against gravity.
    """

    body: Body
    mu: float | None
    up: Float

    @cached_property
    def skin(self) -> Skin:
        """Its surface."""
        return Skin.of(self.body)

    @cached_property
    def swept(self) -> Swept:
        """Its surface as the object falls onto it."""
        return Swept(self.body.reduced_world, -self.up)


@dataclass(frozen=True, eq=False)
class Moved:
    """The object in its own frame, ready to be put into any pose."""

    body: Body

    @cached_property
    def skin(self) -> Skin:
        """Its surface in the body frame."""
        return Skin.of(self.body.moved(np.eye(4)))

    @cached_property
    def size(self) -> float:
        """Twice the largest distance of a corner from the centre of mass [m]."""
        return 2 * float(np.linalg.norm(self.body.shape.surface.vertices - self.com, axis=1).max())

    @property
    def com(self) -> Float:
        """(3,) [m] in the body frame."""
        return self.body.com_body

    def surface(self, pose: Float) -> Surface:
        """Its surface at ``pose`` (4, 4), in as few triangles as it needs."""
        local = self.body.shape.surface.reduced
        return Surface(transform(pose, local.vertices), local.faces, local.sagitta, local.oriented)

    def skin_at(self, pose: Float) -> Skin:
        """The same skin in the world."""
        turn, skin = pose[:3, :3], self.skin
        triangles = transform(pose, skin.triangles.reshape(-1, 3)).reshape(-1, 3, 3)
        placed = skin._replace(
            vertices=transform(pose, skin.vertices),
            triangles=triangles,
            normals=np.ascontiguousarray(skin.normals @ turn.T),
            low=triangles.min(1),
            high=triangles.max(1),
            mean=np.ascontiguousarray(skin.mean @ turn.T),
            outward=np.ascontiguousarray(skin.outward @ turn.T),
        )
        return sealed(placed)


@dataclass(frozen=True, eq=False)
class Touches:
    """Where the object may touch: ``points`` (n, 3), ``normals`` (n, 3) into it, ``gaps`` (n,) [m], ``mu`` (n,)."""

    points: Float
    normals: Float
    gaps: Float
    mu: Float


def height_above(moved: Moved, pose: Float, stills: Sequence[Still], up: Float) -> float:
    """How far the object can go down before it meets something [m]; inf where there is nothing below."""
    falling = Swept(moved.surface(pose), -up)
    return min((hit_distance(falling, still.swept) for still in stills), default=np.inf)


def lowered(moved: Moved, pose: Float, stills: Sequence[Still], up: Float) -> Float | None:
    """The pose (4, 4) in which the object comes to rest when it is let down slowly from ``pose``; None if it does not.

    It starts where it touches nothing. None: it falls past everything, slides off, or has not come to rest after
    MOST_STEPS.
    """
    half = moved.size / 2
    step = STEP * half
    pose = np.array(pose)
    for _ in range(MOST_STEPS):
        touches = touching(moved, pose, stills, REACH * step)
        if not len(touches.gaps) or touches.gaps.min() > TOUCHING * moved.size:
            fall = height_above(moved, pose, stills, up)
            if not np.isfinite(fall):
                return None
            pose[:3, 3] -= fall * up
            if fall > TOUCHING * moved.size:
                continue
        motion = _descent(moved, pose, touches, up, step)
        if motion is None:
            return None
        length = float(np.abs(motion).max())
        if length <= AT_REST * step:
            return pose
        pose = _stepped(pose, motion / np.repeat([1.0, half], 3), transform(pose, moved.com[None])[0])
    return None


def touching(moved: Moved, pose: Float, stills: Sequence[Still], reach: float) -> Touches:
    """Corners and edges of the object and the scene that come within ``reach`` [m] of each other's surfaces."""
    skin = moved.skin_at(pose)
    low, high = skin.low.min(0) - reach, skin.high.max(0) + reach
    points, normals, gaps, mu = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0)], [np.empty(0)]
    for still in stills:
        other = still.skin
        box_low, box_high = still.body.box
        if (box_low > high).any() or (box_high < low).any():
            continue
        pairs = near_faces(other, skin, reach)
        if not len(pairs):
            continue
        if still.mu is None:
            where = f"friction of ({still.body.name!r}, {moved.body.name!r})"
            raise SceneError(message(where, "is not given", "add the pair or a default"))
        size = min(moved.size, still.body.size)
        found = touching_features(
            other, skin, pairs, gap=reach, depth=reach, sin_angle=float(np.sin(np.radians(PARALLEL))),
            size=size, strict=NEGLIGIBLE * size,
        )  # fmt: skip
        for place, normal, gap in starmap(_ends, zip(found, (True, False), strict=True)):
            points.append(place)
            normals.append(normal)
            gaps.append(gap)
            mu.append(np.full(len(gap), still.mu))
    return _distinct(
        Touches(np.vstack(points), np.vstack(normals), np.concatenate(gaps), np.concatenate(mu)), moved.size
    )


def _ends(features: Features, lines: bool) -> tuple[Float, Float, Float]:
    """Points (n, 3), normals (n, 3) and heights (n,): both ends of lines."""
    count = 2 if lines else 1
    points = features.ends[:, :count].reshape(-1, 3)
    return points, np.repeat(features.normals, count, axis=0), features.heights[:, :count].reshape(-1)


def _distinct(touches: Touches, size: float) -> Touches:
    """Those at the same place and with the same normal once: flat faces of many triangles give them often."""
    key = np.round(np.hstack([touches.points / (1e-4 * size), touches.normals / 1e-3])).astype(np.int64)
    _, first = np.unique(key, axis=0, return_index=True)
    return Touches(touches.points[first], touches.normals[first], touches.gaps[first], touches.mu[first])


def _descent(moved: Moved, pose: Float, touches: Touches, up: Float, step: float) -> Float | None:
    """(6,) velocity of the centre of mass and turn times half the size [m] of one step; None if there is no way.

    In units of a step: minimise  up . v + CAUTION |x|²/2  subject to  u_n - mu |u_t| >= -gap  where it touches,
    u_n >= -gap elsewhere, |x_k| <= 1.
    """
    half = moved.size / 2
    arm = (touches.points - transform(pose, moved.com[None])[0]) / half
    t1, t2 = tangents(touches.normals)
    rows = {
        name: np.hstack([axis, np.cross(arm, axis)]) for name, axis in (("n", touches.normals), ("t", t1), ("s", t2))
    }
    gap = np.maximum(touches.gaps, -step / 4) / step
    rough = (touches.gaps <= TOUCHING * moved.size) & (touches.mu > 0)
    smooth = ~rough
    count = int(rough.sum())
    cone = np.stack(
        [rows["n"][rough], touches.mu[rough, None] * rows["t"][rough], touches.mu[rough, None] * rows["s"][rough]], 1
    )
    offset = np.zeros((count, 3))
    offset[:, 0] = gap[rough]
    identity = np.eye(6)
    A = np.vstack([-identity, identity, -rows["n"][smooth], -cone.reshape(-1, 6)])
    b = np.concatenate([np.ones(12), gap[smooth], offset.reshape(-1)])
    cones: list[tuple[ConeKind, int]] = [("nonnegative", 12 + int(smooth.sum())), *[("second_order", 3)] * count]  # type: ignore[list-item]
    program = ConeProgram(
        sparse.csc_matrix(CAUTION * identity), np.concatenate([up, np.zeros(3)]), sparse.csc_matrix(A), b, tuple(cones)
    )
    solution = solve(program, tolerance=1e-9)
    if solution.outcome not in (Outcome.SOLVED, Outcome.ALMOST_SOLVED):
        return None
    return step * solution.x


def _stepped(pose: Float, twist: Float, about: Float) -> Float:
    """The pose moved by ``twist`` (6,) taken at ``about`` (3,): a turn about it, then a translation."""
    angle = float(np.linalg.norm(twist[3:]))
    turn = np.eye(3)
    if angle > 0:
        x, y, z = unit(twist[3:])
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = turn + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    moved = np.eye(4)
    moved[:3, :3] = _orthonormal(turn @ pose[:3, :3])
    moved[:3, 3] = about + turn @ (pose[:3, 3] - about) + twist[:3]
    return moved


def _orthonormal(matrix: Float) -> Float:
    """The nearest rotation: many small turns add up to a little shear."""
    u, _, vt = np.linalg.svd(matrix)
    return np.asarray(u @ vt)
