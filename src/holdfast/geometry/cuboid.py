"""Cuboids, recognised from their surfaces however the faces are divided into triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.base.arrays import Float, Int, frozen
from holdfast.base.values import Value, made, seal

EXACT = 1e-12  # largest deviation of corners, relative to the diagonal, and largest cosine of an angle that is right
IDENTITY = frozen(np.eye(3))


@dataclass(frozen=True, eq=False, repr=False)
class Cuboid(Value):
    """A solid box: all points centre + x · axes with |x_k| <= half_k.

    ``centre`` (3,) [m]; the rows of ``axes`` (3, 3) are unit vectors at right angles; ``half`` (3,) [m] are half the
    edge lengths along them.
    """

    centre: Float
    axes: Float
    half: Float

    def __post_init__(self) -> None:
        seal(self)

    @cached_property
    def rows(self) -> Float:
        """The centre, the axes and the half lengths as rows (5, 3)."""
        return frozen(np.vstack([self.centre, self.axes, self.half]))

    @classmethod
    def of(cls, vertices: Float, faces: Int, normals: Float) -> Cuboid | None:
        """Return the cuboid that triangles bound, or None if it is none.

        The triangles ``faces`` (F, 3) over ``vertices`` (V, 3) form a closed surface with outward ``normals`` (F, 3).
        """
        if len(vertices) != 8 or len(faces) != 12:
            return None
        first = normals[0]
        second = normals[np.argmin(np.abs(normals @ first))]
        axes = np.array([first, second, np.cross(first, second)])
        slopes = normals @ axes.T
        facing = np.abs(slopes) > 0.5
        if (facing.sum(1) != 1).any() or np.abs(slopes[~facing]).max() > EXACT:
            return None
        centre = (vertices.min(0) + vertices.max(0)) / 2
        seen = (vertices - centre) @ axes.T
        half = np.ptp(seen, axis=0) / 2
        tiny = EXACT * float(np.linalg.norm(half))
        corners = {tuple(corner) for corner in (seen > 0).tolist()}
        if len(corners) != 8 or np.abs(np.abs(seen) - half).max() > tiny:
            return None
        outward = (slopes[:, None] * seen[faces] * facing[:, None]).sum(2)  # (F, 3 corners)
        return cls(centre, axes, half) if (outward > 0).all() else None

    def placed(self, pose: Float) -> Cuboid | None:
        """Return the cuboid moved by ``pose`` (4, 4), or None if that is no exact rotation.

        A pose that is given with six digits is not exact: it would shear the cuboid.
        """
        return self.placed_together([self], pose[None, :3, :3], pose[None, None, :3, 3])[0]

    @staticmethod
    def placed_together(cuboids: Sequence[Cuboid], turns: Float, places: Float) -> list[Cuboid | None]:
        """Return each of n cuboids as ``placed``, by rotations ``turns`` (n, 3, 3) and ``places`` (n, 1, 3) [m]."""
        back = turns.transpose(0, 2, 1)
        rigid = (np.abs(turns @ back - IDENTITY).max((1, 2)) <= EXACT).tolist()
        local = np.array([cuboid.rows for cuboid in cuboids])
        rows = np.concatenate([local[:, :1] @ back + places, local[:, 1:4] @ back, local[:, 4:]], axis=1)
        return [
            made(Cuboid, centre=own[0], axes=own[1:4], half=own[4], rows=own) if exact else None
            for exact, own in zip(rigid, frozen(rows), strict=True)
        ]
