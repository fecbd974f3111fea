"""Where balls, capsules, sides of cylinders, ellipsoids and edges come nearest to each other.

All but ellipsoids are rods: a ball or a disc swept along a segment of its axis; for an edge the radius is zero. The
nearest points of two of their surfaces follow from those of the axes by the radii, in closed form.

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

PARALLEL = 0.1  # sine of the largest angle between two axes at which bodies may touch along a line
MOST_STEPS = 60  # largest number of Newton steps
HALVINGS = 30  # largest number of halvings of one step
FOUND = 1e-12  # convergence: size of the step, and sideways distance of the nearest points relative to the size
ROUNDING = 4 * UNIT  # rounding error of a distance, relative to the size of the bodies
ALONG = 1e-12  # accuracy of the nearest point on an axis, relative to its half length


class PlacedRod(NamedTuple):
    """A ball of ``radius`` [m] swept from ``centre`` - ``half`` to ``centre`` + ``half`` (3,) [m].

    ``flat`` is True if the ends are flat, as those of a cylinder; then only the side counts.
    """

    centre: Float
    half: Float
    radius: float
    flat: bool

    @property
    def along(self) -> Float:
        """The unit direction (3,) of the axis; zero for a ball."""
        length = float(np.linalg.norm(self.half))
        return self.half / length if length else self.half

    @property
    def extent(self) -> Float:
        """Half the size (3,) [m] of the bounding box, along the axes of the world."""
        return np.asarray(np.abs(self.half) + self.radius)

    @property
    def thickness(self) -> float:
        """The radius [m]."""
        return self.radius

    def curvature(self, normal: Float, least: float) -> Float:
        """Return the curvature (3, 3) [1/m] of its surface where that has a unit ``normal`` (3,).

        Radii of curvature count as no less than ``least`` [m].
        """
        flat = np.eye(3) - np.outer(normal, normal)
        along = flat @ self.along
        return np.asarray((flat - np.outer(along, along)) / max(self.radius, least))

    def flattest(self, normal: Float) -> float:
        """Return the curvature [1/m] across its axis."""
        return 1 / self.radius

    def share(self, point: Float) -> float:
        """Return the point of the axis nearest to a point (3,), as a multiple of ``half`` from -1 to 1."""
        length2 = float(self.half @ self.half)
        return float(np.clip((point - self.centre) @ self.half / length2, -1, 1)) if length2 else 0.0

    def at(self, share: float) -> Float:
        """Return the point (3,) of the axis at a share from -1 to 1."""
        return np.asarray(self.centre + share * self.half)


class RoundLimits(NamedTuple):
    """Tolerances of round contacts: true surfaces touch up to ``gap`` apart and ``depth`` into each other [m].

    ``cos_side`` is the cosine of the angle tolerance of flat faces, and of a normal against a perpendicular to the side
    of a cylinder; ``cos_twist`` is that of curved faces, and of the normals at the two ends of a line. ``seen`` [m] is
    the gap of the tessellated surfaces.
    """

    gap: float
    depth: float
    cos_side: float
    cos_twist: float
    seen: float


class Meeting(NamedTuple):
    """The contact of two round bodies, at a point or along a line.

    ``ends`` (2, 1 or 2, 3) [m] are points on the surface of the first and of the second, ``normal`` (3,) points into
    the second, ``heights`` (1 or 2,) [m] are the distances, negative where they overlap. ``bend`` [1/m] is the
    curvature of the gap between the bodies across the line or, at a point, the least curvature in any direction.
    """

    ends: Float
    normal: Float
    heights: Float
    bend: float


def meeting(one: PlacedRod, two: PlacedRod, limits: RoundLimits) -> Meeting | None:
    """Return where two rods touch, within ``limits``; None if they do not.

    They touch along a line if they are near enough at both ends of the part in which they lie side by side, and if the
    normals there are alike (``cos_twist``). Otherwise they may touch where they are nearest. The normal must be
    perpendicular to the side of a body with flat ends (``cos_side``). An overlap at a rim does not count, as the sides
    need not overlap there.
    """
    nearest = _nearest(one, two)
    for pairs in (_side_by_side(one, two), [nearest]):
        ways = [two.at(other) - one.at(share) for share, other in pairs]
        apart = np.linalg.norm(ways, axis=-1)
        heights = apart - one.radius - two.radius
        if not ways or (apart <= COORDINATES * (one.radius + two.radius)).any():
            continue
        normals = np.array(ways) / apart[:, None]
        if ((heights < -limits.depth) | (heights > limits.gap)).any() or float(
            normals[0] @ normals[-1]
        ) < limits.cos_twist:
            continue
        normal = unit(normals.sum(0))
        rim = len(pairs) == 1 and ((one.flat and abs(nearest[0]) == 1) or (two.flat and abs(nearest[1]) == 1))
        if not (rim and heights[0] < -COORDINATES * (one.radius + two.radius)) and all(
            not it.flat or float(it.along @ normal) ** 2 <= 1 - limits.cos_side**2 for it in (one, two)
        ):
            of_one = [one.at(share) + one.radius * way for (share, _), way in zip(pairs, normals, strict=True)]
            of_two = [two.at(other) - two.radius * way for (_, other), way in zip(pairs, normals, strict=True)]
            bends = gap_bends(one, two, normal)
            return Meeting(np.array([of_one, of_two]), normal, heights, float(bends[len(pairs) - 1]))
    return None


def _nearest(one: PlacedRod, two: PlacedRod) -> tuple[float, float]:
    """Return the nearest points of the two axes, each as a multiple of ``half`` from -1 to 1."""
    a, b = one.half, two.half
    aa, bb, ab = float(a @ a), float(b @ b), float(a @ b)
    apart = two.centre - one.centre
    across = aa * bb - ab * ab
    share = float(np.clip((float(apart @ a) * bb - float(apart @ b) * ab) / across, -1, 1)) if across > 0 else 0.0
    other = two.share(one.at(share))
    share = one.share(two.at(other))
    return share, two.share(one.at(share))


def _side_by_side(one: PlacedRod, two: PlacedRod) -> list[tuple[float, float]]:
    """Return the ends, as shares of both axes, of the part in which two nearly parallel axes lie side by side.

    The list is empty if there is none.
    """
    length2 = float(one.half @ one.half)
    if not length2 or not two.half.any() or np.linalg.norm(np.cross(one.along, two.along)) > PARALLEL:
        return []
    shadow = sorted(float((two.at(end) - one.centre) @ one.half) / length2 for end in (-1, 1))
    start, stop = max(-1.0, shadow[0]), min(1.0, shadow[1])
    if (stop - start) * np.sqrt(length2) <= COORDINATES * (one.radius + two.radius):
        return []
    return [(share, two.share(one.at(share))) for share in (start, stop)]


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


def gap_bends(one: PlacedEllipsoid | PlacedRod, two: PlacedEllipsoid | PlacedRod, normal: Float) -> Float:
    """Return the least and the greatest curvature (2,) [1/m] of the gap between two surfaces along a normal (3,)."""
    # an edge has no radius, and its infinite curvature would hide the other
    least = COORDINATES * (one.thickness + two.thickness)
    return np.asarray(np.linalg.eigvalsh(one.curvature(normal, least) + two.curvature(normal, least))[1:])


class Nearest(NamedTuple):
    """The distance ``apart`` [m] of two ellipsoids, its unit ``normal`` (3,), and the nearest points (3,) [m]."""

    apart: float
    normal: Float
    of_one: Float
    of_two: Float


def meet(one: PlacedEllipsoid | PlacedRod, two: PlacedEllipsoid | PlacedRod, limits: RoundLimits) -> Meeting | None:
    """Return where two round bodies touch, as ``meeting`` does; an ellipsoid touches at one point."""
    if isinstance(one, PlacedEllipsoid):
        return _ellipsoid_meeting(one, two, limits)
    if isinstance(two, PlacedRod):
        return meeting(one, two, limits)
    found = _ellipsoid_meeting(two, one, limits)
    return None if found is None else found._replace(ends=found.ends[::-1], normal=-found.normal)


def _ellipsoid_meeting(
    ellipsoid: PlacedEllipsoid, other: PlacedEllipsoid | PlacedRod, limits: RoundLimits
) -> Meeting | None:
    """Return where an ellipsoid touches another body, as ``meet`` does."""
    if isinstance(other, PlacedEllipsoid):
        share, radius, second = 0.0, 0.0, other
    else:
        share, radius = _share(other, ellipsoid), other.radius
        second = _point(other, share)
    found = nearest(ellipsoid, second)
    height = found.apart - radius
    if not -limits.depth <= height <= limits.gap:
        return None
    if isinstance(other, PlacedRod) and other.flat:
        leans = float(other.along @ found.normal) ** 2 > 1 - limits.cos_side**2
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


def _point(swept: PlacedRod, share: float) -> PlacedEllipsoid:
    return PlacedEllipsoid(swept.at(share), np.zeros((3, 3)))


def _share(swept: PlacedRod, ellipsoid: PlacedEllipsoid) -> float:
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
