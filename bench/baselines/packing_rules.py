"""Rules by which the packing literature judges whether boxes stand, extended to a carrier that accelerates.

Both look at one box after the other, at nothing but its base and its own weight:

- Base support: a box is taken to stand if at least a given share of its base rests on others (Gzara, Elhedhli &
  Yildiz, EJOR 2020, and many before; 0.8 is usual). The rule knows no acceleration: what stands slips at mu g.
- Support polygon: a box is taken to stand if its centre of mass is above the convex hull of its supporting contacts. On
  a carrier that accelerates by a along d, the centre of mass at height h above them is moved by -h a d / g, and the box
  slips at mu g with the least mu of its contacts.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.rigid import tangents

UPRIGHT = 0.9  # least cosine between a contact normal and the vertical at which the contact supports
SHARE = 0.8  # smallest share of the base that must be supported


def support_polygon_limits(assembly: Assembly, directions: Float) -> Float:
    """Return the accelerations (n,) [m/s²] along horizontal unit ``directions`` (n, 3) by the support polygon."""
    g, frame = float(np.linalg.norm(assembly.scene.gravity)), np.array(tangents(assembly.scene.up))
    way = directions @ frame.T
    least = np.full(len(way), np.inf)
    for number in range(len(assembly.movable)):
        points, mu, _ = _supports(assembly, number)
        if len(points) < 3:
            return np.zeros(len(way))
        corners = points @ frame.T
        middle = corners.mean(0)
        hull = ConvexHull(corners - middle)
        height = float((assembly.com[number] - points.mean(0)) @ assembly.scene.up)
        inside = -(hull.equations[:, :2] @ (assembly.com[number] @ frame.T - middle) + hull.equations[:, 2])
        if inside.min() < 0:
            return np.zeros(len(way))
        outward = hull.equations[:, :2] @ -way.T  # the centre of mass is moved backwards
        with np.errstate(divide="ignore"):
            lever = np.where(outward > 1e-12, inside[:, None] / outward, np.inf).min(0)
        least = np.minimum(least, np.minimum(mu * g, g * lever / height))
    return least


def base_support_limits(assembly: Assembly, directions: Float, share: float = SHARE) -> Float:
    """Return the accelerations (n,) [m/s²] by the rule of base support: mu g, or 0 if a box has too little support."""
    g = float(np.linalg.norm(assembly.scene.gravity))
    least = np.inf
    for number, body in enumerate(assembly.movable):
        _, mu, area = _supports(assembly, number)
        frame = np.array(tangents(assembly.scene.up))
        base = ConvexHull(body.surface_world.vertices @ frame.T).volume
        least = min(least, mu * g if area >= share * base else 0.0)
    return np.full(len(directions), least)


def _supports(assembly: Assembly, number: int) -> tuple[Float, float, float]:
    """Return the corners (k, 3) of the patches on which a body rests, their least mu, and their area [m²]."""
    corners, mu, area = [np.empty((0, 3))], np.inf, 0.0
    for k in assembly.interfaces_of[number]:
        interface = assembly.interfaces[k]
        sign = 1.0 if assembly.ends[k][1] == number else -1.0
        for patch in interface.patches:
            if sign * float(patch.normal @ assembly.scene.up) > UPRIGHT:
                corners.append(patch.polygon)
                mu, area = min(mu, assembly.mu[k]), area + patch.area
    return np.vstack(corners), mu, area
