"""Bodies that lie flat on each other: their faces answer for all edges and corners, which nobody has to look for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holdfast.base.arrays import Bool, Float, Int
from holdfast.contacts.interface import Patch
from holdfast.contacts.skin import Skin
from holdfast.geometry.topology import FLAT, SMOOTH

ROUNDING = 1e-9  # of the size of the smaller body: what counts as in the plane
UPRIGHT = 1e-9  # cosine of the angle between a plane and what stands on it at a right angle
STEEP = 0.01  # sine of the angle at which the edges of a triangle that stands on its corner rise at least
WIDE = 1e-6  # least gap over the size of the smaller body: patches cover what lies within the gap of them


def lie_flat(
    a: Skin,
    b: Skin,
    near_a: Bool,
    near_b: Bool,
    faces: Sequence[Patch],
    *,
    gap: float,
    size: float,
    by_large: bool = False,
) -> bool:
    """Tell whether the patches ``faces`` answer for every edge and corner that touches.

    ``near_a`` (F,) and ``near_b`` (G,) mark the faces of either body that come near the other, and may mark more. With
    ``by_large``, ``faces`` are the patches of large flat faces alone, and it is asked whether they answer for all
    other faces, too: whether none of these lies in the plane where they meet.

    That is certain if one plane separates the bodies as follows. What comes near of either lies in the plane, or leaves
    it at a right angle by a sharp rim, or is more than ``gap`` [m] beyond it. Then

    - a corner or an edge in the plane, on a face in the plane, belongs to the overlap of two faces, which is a patch;
    - on an upright face it could only be at that face's sharp rim, where nothing touches;
    - an upright edge begins at the plane, so that it crosses no edge of the other body between its ends;
    - all else is further away than the gap.

    ``size`` [m] is that of the smaller body.
    """
    if not faces or gap < WIDE * size:
        return False
    normal, origin = faces[0].normal, faces[0].polygon[0]
    tiny = ROUNDING * size
    for patch in faces[1:]:
        if np.abs(patch.normal - normal).max() > UPRIGHT or np.abs((patch.polygon - origin) @ normal).max() > tiny:
            return False
    return all(
        _leaves_squarely(skin, np.flatnonzero(near), away, origin, gap, tiny, by_large=by_large)
        for skin, near, away in ((a, near_a, -normal), (b, near_b, normal))
    )


def _leaves_squarely(
    skin: Skin, near: Int, away: Float, origin: Float, gap: float, tiny: float, *, by_large: bool
) -> bool:
    """Whether faces ``near`` (n,) of a body leave the plane through ``origin`` (3,) as told, the way of ``away``."""
    heights = (skin.vertices - origin) @ away
    level, beyond = np.abs(heights) <= tiny, heights > gap + tiny
    corners = skin.faces[near]
    if not (level | beyond)[corners].all():
        return False
    flat = level[corners].all(1)
    if by_large and (skin.facet[near[flat]] < 0).any():
        return False
    upright = level[corners].any(1) & ~flat
    slopes = skin.normals[near] @ away
    if (slopes[flat] > UPRIGHT - 1).any() or (np.abs(slopes[upright]) > UPRIGHT).any():
        return False
    grounded = np.zeros(len(heights), dtype=bool)
    grounded[corners[flat]] = True
    edges = np.unique(skin.of_face[near])
    return (
        bool(grounded[corners[level[corners]]].all())
        and _edges_leave(skin, edges, level, away)
        and (_stand_steeply(skin, near[level[corners].sum(1) == 1], level, away))
    )


def _edges_leave(skin: Skin, edges: Int, level: Bool, away: Float) -> bool:
    """Whether edges (n,) lie within a flat face, or in the plane and are sharp, or leave it upright.

    Of those that leave the plane, smooth ones are sides of a round upright face: where it ends, at the plane, its rim
    is as sharp as that of a prism.
    """
    bend = skin.bend[edges]
    ends = skin.edges[edges]
    leaves = level[ends[:, 0]] != level[ends[:, 1]]
    sharp = (bend >= SMOOTH) & np.isfinite(bend)
    round_ = leaves & (bend < SMOOTH)
    if not (sharp | round_ | (bend <= FLAT)).all():
        return False
    upright = (sharp & leaves) | (round_ & (bend > FLAT))
    along = skin.vertices[ends[upright, 1]] - skin.vertices[ends[upright, 0]]
    across = np.linalg.norm(np.cross(along, away), axis=1)
    if (across > UPRIGHT * np.linalg.norm(along, axis=1)).any():
        return False
    lies = level[ends].all(1) & sharp
    beside = skin.sides[edges[lies]]
    flat = np.all(level[skin.faces[beside]], axis=2)  # (n, 2): of the two faces beside each
    return bool(np.all(np.any(flat, axis=1)))


def _stand_steeply(skin: Skin, standing: Int, level: Bool, away: Float) -> bool:
    """Whether both edges of triangles (n,) with one corner in the plane rise steeply from it."""
    corners = skin.vertices[skin.faces[standing]]
    foot = level[skin.faces[standing]]
    rise = corners[~foot].reshape(-1, 2, 3) - corners[foot][:, None]
    return bool((rise @ away >= STEEP * np.linalg.norm(rise, axis=2)).all())
