"""Balls, capsules and ellipsoids on a face of a cuboid, far from its edges: a point or a line, without triangles."""

from __future__ import annotations

import numpy as np

from holdfast.contacts.interface import Patch
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry.cuboid import Cuboid
from holdfast.scene.body import Body
from holdfast.scene.round_shapes import Round, round_of


def on_plane(a: Body, b: Body, tolerances: Tolerances, breadth: float) -> tuple[Patch, ...] | None:
    """Return the patch, ``breadth`` [m] wide, at which a round body without flat ends lies on a face of a cuboid.

    The normal points into ``b``. There is no patch if the tessellated surfaces alone are within the gap. None if the
    bodies are others, or touch in another way or not at all.
    """
    for body, other, sign in ((a, b, -1.0), (b, a, 1.0)):
        shape = round_of(body.shape)
        if shape is not None and not shape.has_flat_ends and other.cuboid is not None:
            sagittas = body.shape.surface.sagitta + other.shape.surface.sagitta
            return _lying(shape, body, other.cuboid, sign, tolerances, sagittas, breadth)
    return None


def _lying(
    shape: Round, body: Body, cuboid: Cuboid, sign: float, tolerances: Tolerances, sagittas: float, breadth: float
) -> tuple[Patch, ...] | None:
    gap, R = tolerances.gap, body.pose[:3, :3]
    centre = cuboid.axes @ (body.pose[:3, 3] - cuboid.centre)
    face = int(np.argmax(np.abs(centre) - cuboid.half))
    normal = cuboid.axes[face] * (1.0 if centre[face] > 0 else -1.0)
    own = normal @ R
    lowest = body.pose[:3, 3] - R @ (own * shape.radii**2 / np.linalg.norm(own * shape.radii))
    along = shape.half * R[:, 2]
    points = np.array([lowest - along, lowest + along]) if shape.half else lowest[None]
    heights = (points - cuboid.centre) @ normal - cuboid.half[face]
    # deeper than the gap, or with one end higher, it may touch elsewhere, too
    if sagittas > gap or (np.abs(heights) > min(gap, tolerances.depth)).any():
        return None
    # whatever of the body is within the gap is within half of this of the points
    spread = shape.spread(gap + sagittas, own)
    beside = np.abs((points - cuboid.centre) @ cuboid.axes.T) + spread > cuboid.half
    beside[:, face] = False
    if beside.any():
        return None
    if heights.min() > gap - sagittas:
        return ()
    ends = points - np.outer(heights / 2, normal)
    return (Patch(ends, sign * normal, (), (float(heights.min()), float(heights.max())), breadth),)
