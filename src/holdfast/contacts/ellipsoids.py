"""Nearest points of ellipsoids to each other, to balls, capsules and the sides of cylinders, and to edges.

An ellipsoid with centre c and half axes a along the columns of R has the support function n·c + h(n) for unit normals
n, with h(n) = √(nᵀ M n) and M = R diag(a²) Rᵀ. The distance of two convex bodies is the maximum of
n·(c₂ - c₁) - h₁(n) - h₂(n) over all n, negative where they overlap. At the maximum, M n / h is the vector from the
centre to the point that touches. The second derivative of h, restricted to the plane perpendicular to n, is the inverse
of the curvature there (Schneider, Convex Bodies: The Brunn-Minkowski Theory, section 2.5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, unit
from holdfast.base.ranges import COORDINATES, UNIT
from holdfast.base.rigid import tangents
from holdfast.contacts.swept import Meeting, Swept, gap_bends, meeting

MOST_STEPS = 60  # largest number of Newton steps
HALVINGS = 30  # largest number of halvings of one step
FOUND = 1e-12  # convergence: size of the step, and sideways distance of the nearest points relative to the size
ROUNDING = 4 * UNIT  # rounding error of a distance, relative to the size of the bodies
ALONG = 1e-12  # accuracy of the nearest point on an axis, relative to its half length


class PlacedEllipsoid(NamedTuple):
    """An ellipsoid with ``centre`` (3,) [m] in the world; ``squares`` (3, 3) [m²] is the matrix M, zero for a point."""

    centre: Float
    squares: Float

    @classmethod
    def of(cls, pose: Float, radii: Float) -> PlacedEllipsoid:
        """Return the ellipsoid with half axes ``radii`` (3,) [m] along the axes of a ``pose`` (4, 4)."""
        return cls(pose[:3, 3], (pose[:3, :3] * radii**2) @ pose[:3, :3].T)

    @property
    def extent(self) -> Float:
        """Half the size (3,) [m] of the bounding box, along the axes of the world."""
        return np.sqrt(np.diag(self.squares))

    @property
    def thickness(self) -> float:
        """The largest half axis [m]."""
        return float(np.sqrt(np.linalg.eigvalsh(self.squares)[-1]))

    def curvature(self, normal: Float, least: float) -> Float:
        """Return the curvature (3, 3) [1/m] of its surface where that has a unit ``normal`` (3,).

        Radii of curvature count as no less than ``least`` [m].
        """
        frame = np.array(tangents(normal))
        radii, axes = np.linalg.eigh(frame @ self.support_function(normal)[2] @ frame.T)
        along = axes.T @ frame
        return np.asarray((along.T / np.maximum(radii, least)) @ along)

    def flattest(self, normal: Float) -> float:
        """Return the least curvature [1/m] where its surface has a unit ``normal`` (3,)."""
        return float(np.linalg.eigvalsh(self.curvature(normal, COORDINATES * self.thickness))[1])

    def least_apart(self, ends: Float) -> Float:
        """Return lower bounds (n,) [m] of the distances from lines with ``ends`` (n, 2, 3), negative for an overlap.

        Scaling the ellipsoid to a ball of radius 1 gives exact distances there; scaling back multiplies them by the
        least half axis at least.
        """
        squares, axes = np.linalg.eigh(self.squares)
        radii = np.sqrt(np.maximum(squares, ROUNDING * squares[-1]))
        starts, along = ((arms @ axes) / radii for arms in (ends[:, 0] - self.centre, ends[:, 1] - ends[:, 0]))
        share = np.clip(-(starts * along).sum(1) / np.maximum((along * along).sum(1), 1e-300), 0, 1)
        away = np.linalg.norm(starts + share[:, None] * along, axis=1)
        return np.asarray((away - 1) * radii[0])

    def support_function(self, normal: Float) -> tuple[float, Float, Float]:
        """Return h [m], its gradient M n / h (3,) [m] and its second derivative (3, 3) [m] at a unit normal (3,)."""
        arm = self.squares @ normal
        h = float(np.sqrt(max(float(normal @ arm), 0.0)))
        if not h:
            return 0.0, arm, self.squares
        return h, arm / h, self.squares / h - np.outer(arm, arm) / h**3


class Nearest(NamedTuple):
    """The distance ``apart`` [m] of two ellipsoids, its unit ``normal`` (3,), and the nearest points (3,) [m]."""

    apart: float
    normal: Float
    of_one: Float
    of_two: Float


def meet(
    one: PlacedEllipsoid | Swept,
    two: PlacedEllipsoid | Swept,
    *,
    gap: float,
    depth: float,
    cos_twist: float,
    cos_side: float,
) -> Meeting | None:
    """Return where two round bodies touch, as ``meeting`` does; an ellipsoid touches at one point."""
    if isinstance(one, PlacedEllipsoid):
        return _ellipsoid_meeting(one, two, gap=gap, depth=depth, cos_side=cos_side)
    if isinstance(two, Swept):
        return meeting(one, two, gap=gap, depth=depth, cos_twist=cos_twist, cos_side=cos_side)
    found = _ellipsoid_meeting(two, one, gap=gap, depth=depth, cos_side=cos_side)
    return None if found is None else found._replace(ends=found.ends[::-1], normal=-found.normal)


def _ellipsoid_meeting(
    ellipsoid: PlacedEllipsoid, other: PlacedEllipsoid | Swept, *, gap: float, depth: float, cos_side: float
) -> Meeting | None:
    """Return where an ellipsoid touches another body, as ``meet`` does."""
    if isinstance(other, PlacedEllipsoid):
        share, radius, second = 0.0, 0.0, other
    else:
        share, radius = _share(other, ellipsoid), other.radius
        second = _point(other, share)
    found = nearest(ellipsoid, second)
    height = found.apart - radius
    if not -depth <= height <= gap:
        return None
    if isinstance(other, Swept) and other.flat:
        leans = float(other.along @ found.normal) ** 2 > 1 - cos_side**2
        if leans or (abs(share) == 1 and height < -COORDINATES * radius):
            return None
    ends = np.array([[found.of_one], [found.of_two - radius * found.normal]])
    return Meeting(ends, found.normal, np.array([height]), float(gap_bends(ellipsoid, other, found.normal)[0]))


def nearest(one: PlacedEllipsoid, two: PlacedEllipsoid) -> Nearest:
    """Return where two ellipsoids, or an ellipsoid and a point, come nearest to each other or overlap least.

    The normal is found by Newton's method on the unit sphere. Steps are halved until they increase the distance along
    the normal, up to rounding. If the bodies overlap by more than their radii of curvature, the result may be only a
    local maximum.
    """
    way = two.centre - one.centre
    size = float(np.sqrt(np.trace(one.squares) + np.trace(two.squares)))
    normal = unit(way) if way.any() else np.array([0.0, 0.0, 1.0])
    for _ in range(MOST_STEPS):
        (h, arm, bend), (other_h, other_arm, other_bend) = one.support_function(normal), two.support_function(normal)
        apart = float(normal @ way) - h - other_h
        frame = np.array(tangents(normal))
        sideways = frame @ (way - arm - other_arm)
        stiff = frame @ (bend + other_bend) @ frame.T + apart * np.eye(2)
        least = float(np.linalg.eigvalsh(stiff)[0])
        if least <= FOUND * size:
            stiff += (FOUND * size + 0.1 * abs(apart) - least) * np.eye(2)
        step = np.linalg.solve(stiff, sideways) @ frame
        if np.linalg.norm(sideways) <= FOUND * size or np.linalg.norm(step) <= FOUND:
            break
        for _ in range(HALVINGS):
            tried = unit(normal + step)
            if (
                float(tried @ way) - one.support_function(tried)[0] - two.support_function(tried)[0]
                >= apart - ROUNDING * size
            ):
                break
            step = step / 2
        else:
            break
        normal = tried
    (h, arm, _), (other_h, other_arm, _) = one.support_function(normal), two.support_function(normal)
    return Nearest(float(normal @ way) - h - other_h, normal, one.centre + arm, two.centre - other_arm)


def _point(swept: Swept, share: float) -> PlacedEllipsoid:
    return PlacedEllipsoid(swept.at(share), np.zeros((3, 3)))


def _share(swept: Swept, ellipsoid: PlacedEllipsoid) -> float:
    """Return the point of the axis nearest to an ellipsoid, from -1 to 1; the distance is convex along the axis."""
    if not swept.half.any():
        return 0.0

    def rises(share: float) -> float:
        return float(nearest(ellipsoid, _point(swept, share)).normal @ swept.half)

    low, high = rises(-1.0), rises(1.0)
    if low >= 0 or high <= 0:
        return -1.0 if low >= 0 else 1.0
    from scipy.optimize import brentq  # only here, as it takes long to import

    return float(brentq(rises, -1.0, 1.0, xtol=ALONG, rtol=4 * ALONG))
