"""Lower an object onto a scene that does not move: straight down first, then tipping, until friction holds it.

Each step is the allowed motion that lowers the centre of mass the most. A motion is allowed if at every contact the
relative velocity u satisfies u_n >= mu |u_t|, or if it does not close a contact that is still open. By duality, no such
motion lowers the centre of mass if contact forces within the friction cones can carry the weight. So the object stops
where it can rest, not where it is lowest. The motion is quasi-static and the scene is fixed; whether the scene stands
with the object is checked afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.base.arrays import Float, unit
from holdfast.base.errors import SceneError, message
from holdfast.base.progress import keep_to_time
from holdfast.base.rigid import tangents, transform
from holdfast.conic.solve import ConeKind, ConeProgram, Outcome, solve
from holdfast.contacts.search_mesh import SearchMesh, moved_mesh, near_faces, touching_features
from holdfast.contacts.tolerances import Angles
from holdfast.geometry.surface import Surface
from holdfast.geometry.sweep import Swept, hit_distance
from holdfast.scene.body import Body

STEP = 0.08  # length of the longest step, as a share of half the object's size; also its largest rotation [rad]
RANGE = 2.5  # distance, in steps, beyond which features do not matter in a step
AT_REST = 1e-6  # length, in steps, below which a motion counts as none
TOUCHING = 1e-5  # distance below which friction holds, as a share of the object's size
PARALLEL = 3.0  # [deg] edges and faces that are parallel to within this angle touch at both of their ends
CAUTION = 1e-3  # weight of a step's length in the objective: of equally deep steps, the shortest is taken
MOST_STEPS = 80  # largest number of steps
NEGLIGIBLE = 1e-6  # distance from sharp edges within which features count as degenerate, as a share of the size


@dataclass(frozen=True, eq=False)
class Still:
    """A body of the scene that counts as fixed, prepared for the contact search.

    ``mu`` is its friction coefficient with the object, or None if it is not known, which is an error once the two come
    close. ``up`` (3,) is the unit vector opposite to gravity.
    """

    body: Body
    mu: float | None
    up: Float

    @cached_property
    def mesh(self) -> SearchMesh:
        """The surface of the body, prepared for the contact search."""
        return SearchMesh.of(self.body)

    @cached_property
    def swept(self) -> Swept:
        """The surface of the body, prepared for an object that falls onto it."""
        return Swept(self.body.reduced_world, -self.up)


@dataclass(frozen=True, eq=False)
class Moved:
    """The object in its own frame, prepared for the contact search in any pose."""

    body: Body

    @cached_property
    def mesh(self) -> SearchMesh:
        """The surface of the object in the body frame, prepared for the contact search."""
        return SearchMesh.of(self.body.moved(np.eye(4)))

    @cached_property
    def size(self) -> float:
        """Twice the largest distance between a corner and the centre of mass [m]."""
        return 2 * float(np.linalg.norm(self.body.shape.surface.vertices - self.com, axis=1).max())

    @property
    def com(self) -> Float:
        """The centre of mass (3,) [m] in the body frame."""
        return self.body.com_body

    def surface(self, pose: Float) -> Surface:
        """Return the surface of the object at ``pose`` (4, 4), with coplanar triangles merged."""
        local = self.body.shape.surface.reduced
        return Surface(transform(pose, local.vertices), local.faces, local.sagitta, local.oriented)


@dataclass(frozen=True, eq=False)
class Touches:
    """The n places where the object may touch the scene.

    ``points`` (n, 3) [m] and ``normals`` (n, 3), which point into the object, are in the world frame; ``gaps`` (n,) [m]
    are the distances and ``mu`` (n,) the friction coefficients.
    """

    points: Float
    normals: Float
    gaps: Float
    mu: Float


def lowered(moved: Moved, pose: Float, stills: Sequence[Still], up: Float) -> Float | None:
    """Return the pose (4, 4) in which the object rests after it is lowered slowly from ``pose``, or None.

    It must start where it touches nothing. The result is None if it falls past everything, slides off, or does not come
    to rest within MOST_STEPS steps.
    """
    half = moved.size / 2
    step = STEP * half
    pose = np.array(pose)
    for _ in range(MOST_STEPS):
        keep_to_time()
        touches = touching(moved, pose, stills, RANGE * step)
        if not len(touches.gaps) or touches.gaps.min() > TOUCHING * moved.size:
            falling = Swept(moved.surface(pose), -up)
            fall = min((hit_distance(falling, still.swept) for still in stills), default=np.inf)
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


def touching(moved: Moved, pose: Float, stills: Sequence[Still], within: float) -> Touches:
    """Find the corners and edges of the object and the scene that are ``within`` [m] of each other's surfaces.

    Raises SceneError if the friction coefficient there is not known.
    """
    mesh = moved_mesh(moved.mesh, pose)
    low, high = mesh.box[0] - within, mesh.box[1] + within
    points, normals, gaps, mu = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0)], [np.empty(0)]
    for still in stills:
        other = still.mesh
        box_low, box_high = still.body.box
        if (box_low > high).any() or (box_high < low).any():
            continue
        pairs = near_faces(other, mesh, within)
        if not len(pairs):
            continue
        if still.mu is None:
            where = f"friction of ({still.body.name!r}, {moved.body.name!r})"
            raise SceneError(message(where, "is not given", "add the pair or a default"))
        size = min(moved.size, still.body.size)
        found = touching_features(
            other, mesh, pairs, gap=within, depth=within, angles=Angles(PARALLEL, PARALLEL),
            size=size, strict=NEGLIGIBLE * size,
        )  # fmt: skip
        for features, ends in zip(found, (2, 1), strict=True):  # lines have two each
            points.append(features.ends[:, :ends].reshape(-1, 3))
            normals.append(np.repeat(features.normals, ends, axis=0))
            gaps.append(features.heights[:, :ends].reshape(-1))
            mu.append(np.full(len(gaps[-1]), still.mu))
    places, ways = np.vstack(points), np.vstack(normals)
    # flat faces of many triangles touch at the same place with the same normal several times
    key = np.round(np.hstack([places / (1e-4 * moved.size), ways / 1e-3])).astype(np.int64)
    _, first = np.unique(key, axis=0, return_index=True)
    return Touches(places[first], ways[first], np.concatenate(gaps)[first], np.concatenate(mu)[first])


def _descent(moved: Moved, pose: Float, touches: Touches, up: Float, step: float) -> Float | None:
    """Return one step (6,): the displacement of the centre of mass, and the rotation times half the size [m]; or None.

    In units of a step x = (v, turn), it minimises up . v + CAUTION |x|²/2 subject to u_n - mu |u_t| >= -gap where the
    object touches, u_n >= -gap elsewhere, and |x_k| <= 1. None means that the solver found no solution.
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
    """Return the pose after a rotation about ``about`` (3,) and a translation, which ``twist`` (6,) holds."""
    angle = float(np.linalg.norm(twist[3:]))
    turn = np.eye(3)
    if angle > 0:
        x, y, z = unit(twist[3:])
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = turn + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    moved = np.eye(4)
    u, _, vt = np.linalg.svd(turn @ pose[:3, :3])
    moved[:3, :3] = u @ vt  # the nearest rotation; many small ones accumulate a little shear
    moved[:3, 3] = about + turn @ (pose[:3, 3] - about) + twist[:3]
    return moved
