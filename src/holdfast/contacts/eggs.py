"""Where ellipsoids come nearest to each other, to balls, capsules and the sides of cylinders, and to edges.

Along a unit normal n, an ellipsoid about c reaches as far as n·c + h(n), h(n) = √(nᵀ M n), where M = R diag(a²) Rᵀ has
its half axes a along the columns of R. Two convex bodies are apart by the largest n·(c₂ - c₁) - h₁(n) - h₂(n) of all
n, which is negative where they overlap; there, M n / h leads from a centre to where its surface touches. The second
derivative of h, on the plane across n, is the inverse of the curvature there (Schneider, Convex Bodies: The
Brunn-Minkowski Theory, section 2.5).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from holdfast.base.arrays import Float, unit
from holdfast.base.rigid import tangents
from holdfast.contacts.swept import TINY, Meeting, Swept, gap_bends, meeting

MOST_STEPS = 60  # of Newton's method
HALVINGS = 30  # of one of its steps
FOUND = 1e-12  # of the bodies' size: step along the normal's plane, and sideways distance of the nearest points
ROUNDING = 4e-16  # of the bodies' size, more or less, in how far apart they are
ALONG = 1e-12  # of half an axis: how well the nearest point on it is known


class Egg(NamedTuple):
    """An ellipsoid about ``centre`` (3,) [m], whose ``squares`` (3, 3) [m²] is M: zero for a point."""

    centre: Float
    squares: Float

    @classmethod
    def of(cls, pose: Float, radii: Float) -> Egg:
        """Return the ellipsoid with half axes ``radii`` (3,) [m] along the axes of a ``pose`` (4, 4)."""
        return cls(pose[:3, 3], (pose[:3, :3] * radii**2) @ pose[:3, :3].T)

    @property
    def extent(self) -> Float:
        """(3,) [m] half the size of the box around it, along the axes of the world."""
        return np.sqrt(np.diag(self.squares))

    @property
    def thickness(self) -> float:
        """The greatest half axis [m]."""
        return float(np.sqrt(np.linalg.eigvalsh(self.squares)[-1]))

    def curvature(self, normal: Float, least: float) -> Float:
        """Return the curvature (3, 3) [1/m] of its surface where that has a unit ``normal`` (3,).

        Radii of curvature count as no less than ``least`` [m].
        """
        frame = np.array(tangents(normal))
        radii, axes = np.linalg.eigh(frame @ self.reach(normal)[2] @ frame.T)
        along = axes.T @ frame
        return np.asarray((along.T / np.maximum(radii, least)) @ along)

    def flattest(self, normal: Float) -> float:
        """Return the least curvature [1/m] where its surface has a unit ``normal`` (3,)."""
        return float(np.linalg.eigvalsh(self.curvature(normal, TINY * self.thickness))[1])

    def least_apart(self, ends: Float) -> Float:
        """Return how far (n,) [m] it is at least from lines with these ``ends`` (n, 2, 3), or overlaps them: negative.

        Where the ellipsoid is stretched to a ball of radius 1, lines are a known way from it, and stretching back to
        its least half axis leaves at least that share of it.
        """
        squares, axes = np.linalg.eigh(self.squares)
        radii = np.sqrt(np.maximum(squares, ROUNDING * squares[-1]))
        starts, along = ((arms @ axes) / radii for arms in (ends[:, 0] - self.centre, ends[:, 1] - ends[:, 0]))
        share = np.clip(-(starts * along).sum(1) / np.maximum((along * along).sum(1), 1e-300), 0, 1)
        away = np.linalg.norm(starts + share[:, None] * along, axis=1)
        return np.asarray((away - 1) * radii[0])

    def reach(self, normal: Float) -> tuple[float, Float, Float]:
        """Return h [m], the point M n / h (3,) [m] and the second derivative (3, 3) [m] of h along a normal (3,)."""
        arm = self.squares @ normal
        h = float(np.sqrt(max(float(normal @ arm), 0.0)))
        if not h:
            return 0.0, arm, self.squares
        return h, arm / h, self.squares / h - np.outer(arm, arm) / h**3


class Nearest(NamedTuple):
    """How far two ellipsoids are ``apart`` [m], along a unit ``normal`` (3,), and where they touch: (3,) [m] each."""

    apart: float
    normal: Float
    of_one: Float
    of_two: Float


def meet(
    one: Egg | Swept, two: Egg | Swept, *, gap: float, depth: float, cos_twist: float, cos_side: float
) -> Meeting | None:
    """Return where two round bodies touch, as ``meeting`` does; an ellipsoid touches at one point."""
    if isinstance(one, Egg):
        return _egg_meeting(one, two, gap=gap, depth=depth, cos_side=cos_side)
    if isinstance(two, Swept):
        return meeting(one, two, gap=gap, depth=depth, cos_twist=cos_twist, cos_side=cos_side)
    found = _egg_meeting(two, one, gap=gap, depth=depth, cos_side=cos_side)
    return None if found is None else found._replace(ends=found.ends[::-1], normal=-found.normal)


def _egg_meeting(egg: Egg, other: Egg | Swept, *, gap: float, depth: float, cos_side: float) -> Meeting | None:
    """Return where an ellipsoid touches another body, as ``meet`` does."""
    if isinstance(other, Egg):
        share, radius, second = 0.0, 0.0, other
    else:
        share, radius = _share(other, egg), other.radius
        second = _point(other, share)
    found = nearest(egg, second)
    height = found.apart - radius
    if not -depth <= height <= gap:
        return None
    if isinstance(other, Swept) and other.flat:
        leans = float(other.along @ found.normal) ** 2 > 1 - cos_side**2
        if leans or (abs(share) == 1 and height < -TINY * radius):
            return None
    ends = np.array([[found.of_one], [found.of_two - radius * found.normal]])
    return Meeting(ends, found.normal, np.array([height]), float(gap_bends(egg, other, found.normal)[0]))


def nearest(one: Egg, two: Egg) -> Nearest:
    """Return where two ellipsoids, or an ellipsoid and a point, come nearest to each other or overlap least.

    The normal is improved by Newton's method on the unit sphere. Steps are halved until bodies are farther apart along
    it, up to rounding. Where they overlap by more than their curvature allows, it ends at a place from which no step is
    better.
    """
    way = two.centre - one.centre
    size = float(np.sqrt(np.trace(one.squares) + np.trace(two.squares)))
    normal = unit(way) if way.any() else np.array([0.0, 0.0, 1.0])
    for _ in range(MOST_STEPS):
        (h, arm, bend), (other_h, other_arm, other_bend) = one.reach(normal), two.reach(normal)
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
            if float(tried @ way) - one.reach(tried)[0] - two.reach(tried)[0] >= apart - ROUNDING * size:
                break
            step = step / 2
        else:
            break
        normal = tried
    (h, arm, _), (other_h, other_arm, _) = one.reach(normal), two.reach(normal)
    return Nearest(float(normal @ way) - h - other_h, normal, one.centre + arm, two.centre - other_arm)


def _point(swept: Swept, share: float) -> Egg:
    return Egg(swept.at(share), np.zeros((3, 3)))


def _share(swept: Swept, egg: Egg) -> float:
    """Return where on the axis it comes nearest to an ellipsoid, from -1 to 1: the distance is convex along it."""
    if not swept.half.any():
        return 0.0

    def rises(share: float) -> float:
        return float(nearest(egg, _point(swept, share)).normal @ swept.half)

    low, high = rises(-1.0), rises(1.0)
    if low >= 0 or high <= 0:
        return -1.0 if low >= 0 else 1.0
    return float(brentq(rises, -1.0, 1.0, xtol=ALONG, rtol=4 * ALONG))
