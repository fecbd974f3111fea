"""Bodies whose poses change: their surfaces are prepared once and then moved rigidly."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import manifold3d
import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.contacts.search_mesh import SearchMesh, moved_mesh
from holdfast.geometry.distance import winding_number
from holdfast.geometry.solid import closed_solid
from holdfast.scene.body import Body

CLOSED = 1e-3  # largest sum of area vectors, relative to the area, of a surface without large holes


class Posed:
    """A body whose pose changes step by step.

    ``start`` is the body as given, ``body`` in its current pose, and ``mesh`` its surface there. ``radius`` [m] is the
    distance of its farthest vertex from the centre of mass.
    """

    def __init__(self, body: Body) -> None:
        self.start = self.body = body
        self._local = SearchMesh.of(body.moved(np.eye(4)))
        self.mesh = moved_mesh(self._local, body.pose)
        arms = body.shape.surface.vertices - body.com_body
        self.radius = float(np.linalg.norm(arms, axis=1).max())

    def move(self, shift: Float, turn: Float) -> None:
        """Turn the body about its centre of mass by the rotation vector ``turn`` (3,) and move it by ``shift`` (3,)."""
        com = self.body.com_world
        rotation = rotation_of(turn)
        pose = np.eye(4)
        pose[:3, :3] = nearest_rotation(rotation @ self.body.pose[:3, :3])
        pose[:3, 3] = com + shift + rotation @ (self.body.pose[:3, 3] - com)
        self.place(self.start.moved(pose))

    def place(self, body: Body) -> None:
        """Put the body into the pose of ``body``, which is the same body."""
        self.body = body
        self.mesh = moved_mesh(self._local, body.pose)

    @cached_property
    def _solid(self) -> manifold3d.Manifold | None:
        """The body as a solid in its own frame, or None if its surface is not closed."""
        local = self.start.shape.surface.reduced
        solid = closed_solid(local.vertices, local.faces)
        return None if solid is None else solid.as_original()

    @property
    def solid(self) -> manifold3d.Manifold | None:
        """The body as a solid in its current pose, or None if its surface is not closed."""
        return None if self._solid is None else self._solid.transform(self.body.pose[:3])

    @property
    def number(self) -> int:
        """The number by which manifold3d marks faces of ``solid`` in results of its operations; -1 without a solid."""
        return -1 if self._solid is None else self._solid.original_id()

    @cached_property
    def _closed(self) -> bool:
        """Whether the surface has an inside, that is, its area vectors sum to zero; it may be folded."""
        local = self.start.shape.surface.reduced
        corners = local.vertices[local.faces]
        areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return float(np.linalg.norm(areas.sum(0))) <= CLOSED * float(np.linalg.norm(areas, axis=1).sum())

    def encloses(self, points: Float) -> Bool:
        """Tell which of ``points`` (n, 3) are inside the body; all, if its surface is so open that it has no inside."""
        if not len(points) or not self._closed:
            return np.ones(len(points), dtype=bool)
        local = (points - self.body.pose[:3, 3]) @ self.body.pose[:3, :3]
        return np.asarray(winding_number(local, self.start.shape.surface.reduced) > 0.5)

    @property
    def moved(self) -> Float:
        """The displacement (3,) [m] of the centre of mass."""
        return np.asarray(self.body.com_world - self.start.com_world)

    @property
    def turned(self) -> float:
        """The angle [deg] by which the body has turned."""
        return turn_between(self.start.pose, self.body.pose)


def turn_between(before: Float, after: Float) -> float:
    """Return the angle [deg] between the orientations of two poses (4, 4)."""
    relative = before[:3, :3].T @ after[:3, :3]
    sine = np.linalg.norm([relative[k, m] - relative[m, k] for k, m in ((2, 1), (0, 2), (1, 0))]) / 2
    return float(np.degrees(np.arctan2(sine, (np.trace(relative) - 1) / 2)))


def rotation_of(turn: Float) -> Float:
    """Return the rotation (3, 3) by the angle |turn| [rad] about the axis ``turn`` (3,) (Rodrigues)."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    half = float(np.sinc(angle / (2 * np.pi)))
    return np.asarray(np.eye(3) + float(np.sinc(angle / np.pi)) * cross + half * half / 2 * cross @ cross)


def nearest_rotation(matrix: Float) -> Float:
    """Return the rotation nearest to a matrix (3, 3) that is a rotation up to rounding."""
    return np.asarray(1.5 * matrix - 0.5 * matrix @ matrix.T @ matrix)


def pairs_near(bodies: Sequence[Posed], gap: float, excluded: frozenset[frozenset[str]]) -> list[tuple[int, int]]:
    """Return the pairs of bodies, by number, whose boxes come within ``gap`` [m], without fixed or excluded pairs."""
    low = np.array([posed.mesh.box[0] for posed in bodies]) - gap / 2
    high = np.array([posed.mesh.box[1] for posed in bodies]) + gap / 2
    fixed = np.array([posed.start.fixed for posed in bodies])
    near = ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(2) & ~(fixed[:, None] & fixed[None])
    names = [posed.start.name for posed in bodies]
    return [
        (int(i), int(j)) for i, j in np.argwhere(np.triu(near, 1)) if frozenset((names[i], names[j])) not in excluded
    ]


def upright_pose(body: Body, up: Float) -> Float:
    """Return the pose (4, 4) of a body turned about its centre of mass by the least angle that makes it upright.

    It is upright if the axis of its frame that is nearest to ``up`` (3,), or to its opposite, is parallel to it.
    """
    axes = body.pose[:3, :3]
    k = int(np.argmax(np.abs(axes.T @ up)))
    axis = axes[:, k] * np.sign(axes[:, k] @ up)
    across = np.cross(axis, up)
    sine = float(np.linalg.norm(across))
    rotation = rotation_of(across / max(sine, 1e-300) * np.arctan2(sine, float(axis @ up)))
    pose = np.eye(4)
    pose[:3, :3] = nearest_rotation(rotation @ axes)
    pose[:3, 3] = body.com_world + rotation @ (body.pose[:3, 3] - body.com_world)
    return pose
