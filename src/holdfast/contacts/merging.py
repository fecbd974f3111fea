"""Merging of many small patches between two bodies, as between scans, into few.

Scanned surfaces touch in thousands of slivers. Slivers that lie in one plane, up to a share of the gap, and whose
normals agree within the angle tolerance, become one patch with the normal of that plane. The remaining patches, on
curved surfaces, become one bent patch whose points have normals of their own. Either way, the contact is represented by
its ``Spots``. All of these are points where the surfaces are near each other, so merging adds no support: the hull of a
plane patch is that of its parts, and forces at some points of a curved contact are among those that it can carry.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely

from holdfast.base.arrays import Bool, Float, Int, unit
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import tangents
from holdfast.contacts.interface import Patch
from holdfast.contacts.spots import LEAST, Spots, corrected, in_order, nearest_spot
from holdfast.geometry import polygon as flat
from holdfast.geometry.hull import convex_hull, corner_numbers

FEW = 8  # two bodies with at most this many patches keep them
MOST = 12  # two bodies with more planes of narrow patches than this touch along curved surfaces
FACETS = 32  # up to this many patches may be the facets of a prism and are not merged as a curved contact
BROAD = 64  # if there are more broad faces than this, they are merged, too
NARROW = 8.0  # [gaps] a face with a smaller width is narrow
RESIDUAL = 0.5  # [gaps] largest distance of patches from their plane, which is about their uncertainty
FITS = 3  # how often a plane is fitted to its patches
LARGE = 0.1  # a plane with at least this share of a curved contact remains a patch of its own
ON_PLANE, ON_BENT = 200, 128  # largest number of spots of a plane patch and of a bent patch
STEPS = 24  # patches larger than the extent of the contact over this are sampled at several points
INWARD = 1e-3  # share of the way to the centroid by which corners are moved, so that neighbours' corners differ
CANCELLED = 0.1  # a mean of unit normals that is shorter than this gives no direction


class _Plane(NamedTuple):
    """Patches in one plane, through ``origin`` (3,) [m] with a unit ``normal`` (3,)."""

    members: list[Patch]
    origin: Float
    normal: Float


def merged(patches: Sequence[Patch], gap: float, angle: float) -> tuple[Patch, ...]:
    """Return the contact of two bodies with few patches; up to FEW patches, and up to BROAD broad faces, are unchanged.

    ``gap`` [m] and ``angle`` [deg] are the tolerances with which the patches were found.
    """
    if len(patches) <= FEW:
        return tuple(patches)
    cosine = float(np.cos(np.radians(angle)))
    narrow = [patch for patch in patches if patch.kind != "face" or patch.width < NARROW * gap]
    broad = [patch for patch in patches if patch.kind == "face" and patch.width >= NARROW * gap]
    planes = _planes(narrow, RESIDUAL * gap, cosine)
    if len(broad) > BROAD:
        broad, planes = [], _planes(patches, RESIDUAL * gap, cosine)
    band: list[Patch] = []
    if len(planes) > MOST and len(patches) > FACETS:
        least = LARGE * sum(patch.measure for patch in patches)
        small = [sum(patch.measure for patch in plane.members) < least for plane in planes]
        band = [patch for plane, is_small in zip(planes, small, strict=True) if is_small for patch in plane.members]
        planes = [plane for plane, is_small in zip(planes, small, strict=True) if not is_small]
    joined = [patch for plane in planes for patch in _on_plane(plane)]
    return (*broad, *joined, *([_bent(band)] if band else []))


def _planes(patches: Sequence[Patch], residual: float, cosine: float) -> list[_Plane]:
    """Group patches by planes. The largest remaining patch defines a plane, which is then fitted to all that lie in it.

    All corners of a group are within ``residual`` [m] of the plane, and the cosine between the normals of its patches
    and of the plane is at least ``cosine``.
    """
    if not patches:
        return []
    corners = [_corners(patch) for patch in patches]
    starts = np.cumsum([0, *(len(part) for part in corners[:-1])])
    places = np.vstack(corners)
    normals = np.array([patch.normal for patch in patches])
    centres = np.array([patch.centroid for patch in patches])
    sizes = np.array([patch.measure for patch in patches])
    left = np.ones(len(patches), dtype=bool)

    def members_of(origin: Float, normal: Float) -> Bool:
        off = np.maximum.reduceat(np.abs((places - origin) @ normal), starts)
        return np.asarray(left & (off <= residual) & (normals @ normal >= cosine))

    found = []
    while left.any():
        seed = int(np.argmax(np.where(left, sizes, -1.0)))
        origin, normal = centres[seed], normals[seed]
        chosen = members_of(origin, normal)
        chosen[seed] = True
        for _ in range(FITS):
            weights = sizes * chosen
            middle, mean = weights @ centres / weights.sum(), unit(weights @ normals)
            better = members_of(middle, mean)
            if not better[seed]:
                break
            origin, normal, chosen = middle, mean, better
        found.append(_Plane([patches[k] for k in np.flatnonzero(chosen).tolist()], origin, normal))
        left &= ~chosen
    return found


def _on_plane(plane: _Plane) -> list[Patch]:
    """Merge the patches of a plane; return them unchanged if there is only one, or if all lie along one line."""
    members, origin, normal = plane
    frame = np.array(tangents(normal))
    corners = np.vstack([_corners(patch) for patch in members])
    extent = float(np.linalg.norm(np.ptp(corners, axis=0)))
    seen = (corners - origin) @ frame.T
    if len(members) == 1 or not extent > 0:
        return members
    outline = convex_hull(seen, COORDINATES * extent)
    if len(outline) < 3 or abs(flat.signed_area(outline)) <= COORDINATES * extent**2:
        return members
    sampled, _, shares = _samples(members, extent / STEPS)
    points = (sampled - origin) @ frame.T
    lifted, same = origin + points @ frame, np.broadcast_to(normal, (len(points), 3))
    spots = in_order(lifted, same, ON_PLANE)
    tributary = _tributary(shares, nearest_spot(lifted, same, spots), len(spots))
    moments = sum((_moments(patch, origin, frame) for patch in members), np.zeros(6))
    x, y = points[spots].T / extent
    basis = np.array([np.ones_like(x), x, y, x * x, x * y, y * y])
    wanted = moments / extent ** np.array([0, 1, 1, 2, 2, 2])
    known = Spots(
        lifted[spots],
        same[spots],
        corrected(tributary, basis, wanted, (6, 3)),
        bent=False,
        area=sum(patch.area for patch in members),
        residual=float(np.abs((corners - origin) @ normal).max()),
        spread=_degrees(min(float(patch.normal @ normal) for patch in members)),
    )
    return [Patch(origin + outline @ frame, normal, separation=_separation(members), spots=known)]


def _bent(members: Sequence[Patch]) -> Patch:
    """Merge patches with any normals to one bent patch, whose points have the normals of their original patches."""
    corners = np.vstack([_corners(patch) for patch in members])
    extent = float(np.linalg.norm(np.ptp(corners, axis=0)))
    points, normals, shares = _samples(members, extent / STEPS, INWARD)
    spots = in_order(points, normals, ON_BENT)
    nearest = nearest_spot(points, normals, spots)
    tributary = _tributary(shares, nearest, len(spots))
    centre = points.mean(0)
    at, turned = (points[spots] - centre) / extent, normals[spots]
    basis = np.column_stack([np.ones(len(spots)), at, turned, np.cross(at, turned)]).T
    sizes = np.array([patch.measure for patch in members])
    middles = (np.array([patch.centroid for patch in members]) - centre) / extent
    ways = np.array([patch.normal for patch in members])
    wanted = sizes @ np.column_stack([np.ones(len(members)), middles, ways, np.cross(middles, ways)])
    chosen = spots[nearest]
    known = Spots(
        points[spots],
        turned,
        corrected(tributary, basis, wanted, (10, 7, 4)),
        bent=True,
        area=sum(patch.area for patch in members),
        residual=float(np.linalg.norm(points - points[chosen], axis=1).max()),
        spread=_degrees(float((normals * normals[chosen]).sum(1).min())),
    )
    mean = sizes @ ways / sizes.sum()
    if np.linalg.norm(mean) < CANCELLED:  # normals all around a peg cancel, so use the direction of the peg
        mean = np.linalg.eigh((ways * sizes[:, None]).T @ ways)[1][:, 0]
    normal = unit(mean)
    return Patch(_outline(known.points, normal), normal, separation=_separation(members), spots=known)


def _outline(points: Float, normal: Float) -> Float:
    """Return those of the points (n, 3) that are corners of their convex hull, seen along a normal (3,)."""
    seen = points @ np.array(tangents(normal)).T
    low, size = seen.min(0), np.ptp(seen, axis=0)
    return np.asarray(points[corner_numbers(np.ascontiguousarray((seen - low) / max(float(size.max()), 1e-300)))])


def _tributary(shares: Float, nearest: Int, count: int) -> Float:
    """Return the sum of ``shares`` (n,) at the nearest of ``count`` spots, with a small positive minimum for each."""
    own = np.bincount(nearest, shares, minlength=count) + LEAST * shares.sum() / count
    return np.asarray(own * (shares.sum() / own.sum()))


def _samples(patches: Sequence[Patch], step: float, inward: float = 0.0) -> tuple[Float, Float, Float]:
    """Return points (n, 3) [m] on patches, their normals (n, 3), and the shares (n,) [m²] that they stand for.

    Points are inside patches, about a ``step`` [m] apart on larger ones, and at all corners.

    Corners are moved by the share ``inward`` of the way to the centroid. With n points along a line, or n² points on a
    face, all corners of a patch together stand for 1 / (2 n² + 1) of it: then the second moments of a line and of a
    rectangle are exact (n = 1 is Simpson's rule). Without weights at the corners, a contact would tilt too easily.
    """
    points, shares = [], []
    outlines = flat.polygons([patch.rings for patch in patches if patch.kind == "face"])
    middles = shapely.get_coordinates(shapely.point_on_surface(outlines))
    faces = zip(outlines, middles, strict=True)
    for patch in patches:
        inner = _over(patch, step, *next(faces)) if patch.kind == "face" else _along(patch, step)
        corners = _corners(patch)
        outer = 0.0 if patch.kind == "point" else 1 / (2 * len(inner) ** (2 if patch.kind == "line" else 1) + 1)
        points += [inner, corners + inward * (patch.centroid - corners)]
        shares += [
            np.full(len(inner), (1 - outer) * patch.measure / len(inner)),
            np.full(len(corners), outer * patch.measure / len(corners)),
        ]
    counts = [len(inner) + len(corners) for inner, corners in zip(points[::2], points[1::2], strict=True)]
    normals = np.repeat([patch.normal for patch in patches], counts, axis=0)
    return np.vstack(points), normals, np.concatenate(shares)


def _along(patch: Patch, step: float) -> Float:
    """Return points (n, 3) spread evenly over a line or a point, about a ``step`` [m] apart, and at least one."""
    if patch.kind == "point":
        return patch.polygon
    count = max(1, int(np.ceil(patch.length / step)))
    share = (np.arange(count)[:, None] + 0.5) / count
    return np.asarray((1 - share) * patch.polygon[0] + share * patch.polygon[1])


def _over(patch: Patch, step: float, outline: shapely.Polygon, middle: Float) -> Float:
    """Return points (n, 3) spread evenly over a face, about a ``step`` [m] apart, and at least its ``middle`` (2,)."""
    if patch.size > step:
        low, high = patch.rings[0].min(0), patch.rings[0].max(0)
        counts = np.ceil((high - low) / step).astype(np.int64)
        grid = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in counts), indexing="ij"), -1).reshape(-1, 2)
        points = low + grid * (high - low) / counts
        points = points[flat.inside(outline, points)]
        if len(points):
            return patch.lifted(points)
    return patch.lifted(middle[None])


def _moments(patch: Patch, origin: Float, frame: Float) -> Float:
    """Return the integrals (6,) of 1, x, y, x², xy and y² over a patch projected to a plane, scaled to its measure."""
    if patch.kind == "face":
        found = flat.polynomial_moments([(ring - origin) @ frame.T for ring in (patch.polygon, *patch.holes)])
        return np.asarray(found * (patch.area / found[0]))
    (x, y), (u, v) = ((patch.polygon[k] - origin) @ frame.T for k in (0, -1))
    second = [(x * x + x * u + u * u) / 3, (2 * x * y + x * v + u * y + 2 * u * v) / 6, (y * y + y * v + v * v) / 3]
    return np.array([1.0, (x + u) / 2, (y + v) / 2, *second]) * patch.measure


def _corners(patch: Patch) -> Float:
    return np.vstack([patch.polygon, *patch.holes])


def _separation(patches: Sequence[Patch]) -> tuple[float, float] | None:
    known = [patch.separation for patch in patches if patch.separation is not None]
    return (min(low for low, _ in known), max(high for _, high in known)) if known else None


def _degrees(cosine: float) -> float:
    return float(np.degrees(np.arccos(min(max(cosine, -1.0), 1.0))))
