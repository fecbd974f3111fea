"""Contact patches, and the interfaces that consist of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from holdfast.base.arrays import Float, checked, checked_number, frozen, read_only, unit
from holdfast.base.errors import GeometryError, message
from holdfast.base.memory import Memory
from holdfast.base.public import Record, column
from holdfast.base.ranges import COORDINATES, FRICTION, PLACE
from holdfast.base.rigid import Frame, snapped, tangents
from holdfast.base.values import altered
from holdfast.contacts.spots import Spots
from holdfast.geometry import polygon as flat
from holdfast.geometry.hull import convex_hull, search_tree, smallest_rectangle
from holdfast.native import core

FLATNESS = 0.02  # [-] largest distance of a given polygon's corners from its plane, relative to its size

MOST_CACHED = 100  # sets of nodes that are kept with an interface

PatchKind = Literal["face", "line", "point"]
InterfaceStatus = Literal["touching", "penetrating"]


class Patch(Record):
    """A flat piece of contact: a face, a line or a point. All vectors are in the world frame.

    - ``polygon`` (k, 3) [m]: the corners, counter-clockwise seen from the tip of the normal. A patch with two corners
      is a line, and one with a single corner is a point.
    - ``normal`` (3,): the unit normal, which points into the second body.
    - ``holes``: polygons (h, 3) [m], which run clockwise.
    - ``separation`` [m]: the smallest and the largest distance of the two surfaces along the normal, negative where
      they overlap. None if it is not known.
    - ``breadth`` [m]: a nominal width of a line or a point, which in reality has some width.
    - ``inset`` [m]: how far inside the nearest sharp edge a line or a point lies.
    - ``spots``: the points at which it touches, if it replaces many smaller patches, with their deviations. The
      polygon is then an outline around these points; if ``spots.bent``, its corners are spots and not in one plane.
    """

    polygon: Float = column("k 3")
    normal: Float = column("3")
    holes: tuple[Float, ...] = ()
    separation: tuple[float, float] | None = None
    breadth: float = 0.0
    inset: float = np.inf
    spots: Spots | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "polygon", read_only(self.polygon))
        set_(self, "normal", read_only(self.normal))
        set_(self, "holes", tuple(read_only(hole) for hole in self.holes))

    @cached_property
    def bent(self) -> bool:
        """Whether the patch is not in one plane."""
        return self.spots is not None and self.spots.bent

    def normals_at(self, points: Float) -> Float:
        """Return the normals (n, 3) at points (n, 3) of the patch; on a bent patch, those of the nearest spots."""
        if self.spots is None or not self.bent:
            return np.broadcast_to(self.normal, points.shape)
        return np.asarray(self.spots.normals[search_tree(self.spots.points).query(points)[1]])

    @property
    def rectangular(self) -> bool:
        """Whether the patch is a rectangle without holes, and the bodies touch on all of it."""
        if len(self.polygon) != 4 or self.holes or self.spots is not None:
            return False
        a, b, c, d = self.polygon
        slack = COORDINATES * float(np.linalg.norm(c - a))
        same = abs(np.linalg.norm(c - a) - np.linalg.norm(d - b)) <= slack
        return bool(same and np.abs((a + c) - (b + d)).max() <= slack)

    @cached_property
    def kind(self) -> PatchKind:
        """The kind of the patch: "face", "line" or "point"."""
        return "face" if len(self.polygon) > 2 else "line" if len(self.polygon) == 2 else "point"

    @cached_property
    def frame(self) -> Float:
        """The unit tangents t1 and t2 (2, 3), with t1 x t2 = normal. They depend on the normal alone."""
        return frozen(np.array(tangents(self.normal)))

    @cached_property
    def rings(self) -> tuple[Float, ...]:
        """The outline and the holes (k, 2) [m] in the frame (t1, t2), relative to the first corner."""
        return tuple(frozen((ring - self.polygon[0]) @ self.frame.T) for ring in (self.polygon, *self.holes))

    def lifted(self, points: Float) -> Float:
        """Convert points (n, 2) [m] in the frame (t1, t2) to points (n, 3) in the world frame."""
        return np.asarray(self.polygon[0] + points @ self.frame)

    @cached_property
    def moments(self) -> Float:
        """The integrals (6,) of 1, x, y, x², xy and y² in the frame (t1, t2), relative to the first corner."""
        if self.spots is not None:
            x, y = ((self.spots.points - self.polygon[0]) @ self.frame.T).T
            return frozen(np.array([np.ones_like(x), x, y, x * x, x * y, y * y]) @ self.spots.shares)
        return frozen(flat.polynomial_moments(self.rings))

    @cached_property
    def area(self) -> float:
        """The area [m²]; 0 for a line or a point."""
        if self.spots is not None:
            return self.spots.area
        return float(self.moments[0]) if self.kind == "face" else 0.0

    @property
    def areas(self) -> tuple[Float, Float]:
        """Points (n, 3) [m] and vector areas (n, 3) [m²], along the normals, that stand for the area in all sums.

        They are exact for pressures that are the same everywhere. A line or a point has none.
        """
        if self.spots is not None:
            share = self.area / self.measure * self.spots.shares
            return self.spots.points, frozen(share[:, None] * self.normals_at(self.spots.points))
        count = 1 if self.kind == "face" else 0
        return frozen(self.centroid[None][:count]), frozen((self.area * self.normal)[None][:count])

    @property
    def length(self) -> float:
        """The length of a line [m]; 0 for a face or a point."""
        return float(np.linalg.norm(self.polygon[1] - self.polygon[0])) if self.kind == "line" else 0.0

    @cached_property
    def measure(self) -> float:
        """The area [m²] by which nodes and stiffness are distributed. Lines and points count as ``breadth`` wide."""
        if self.spots is not None:
            return float(self.spots.shares.sum())
        return {"face": self.area, "line": self.length * self.breadth, "point": self.breadth**2}[self.kind]

    @cached_property
    def centroid(self) -> Float:
        """The centroid (3,) [m] in the world frame."""
        if self.spots is not None:
            return frozen(np.asarray(self.spots.shares @ self.spots.points / self.measure))
        if self.kind != "face":
            return frozen(self.polygon.mean(0))
        return frozen(self.lifted(self.moments[None, 1:3] / self.area)[0])

    @cached_property
    def size(self) -> float:
        """The largest extent along t1 or t2 [m]."""
        return float(np.ptp(self.rings[0], axis=0).max())

    @cached_property
    def width(self) -> float:
        """Twice the area over the perimeter [m]: the width of a narrow strip, and half the side of a square."""
        if self.kind != "face":
            return 0.0
        ring = self.rings[0]
        perimeter = float(np.linalg.norm(ring - flat.turned(ring, 1), axis=1).sum())
        return 2 * self.area / perimeter if perimeter > 0 else 0.0

    @property
    def room(self) -> float:
        """How far the bodies may move sideways, in the narrowest direction, before the patch is lost [m]."""
        return self.width if self.kind == "face" else self.inset

    @cached_property
    def hull(self) -> Float:
        """The corners (m, 3) [m] of the convex hull, counter-clockwise seen from the tip of the normal."""
        if self.kind != "face" or self.bent:
            return self.polygon
        return frozen(self.lifted(self.corners))

    @cached_property
    def corners(self) -> Float:
        """The corners (m, 2) [m] of the convex hull of a face, in the frame (t1, t2) relative to the first corner."""
        return frozen(convex_hull(self.rings[0], 1e-9 * self.size))

    @cached_property
    def rectangle(self) -> tuple[Float, Float, Float, Float]:
        """The smallest rectangle around the outline, in the frame (t1, t2) relative to the first corner.

        It is given by its unit axes as rows (2, 2), that of the longer side first, by its low and its high corner (2,)
        [m] along them, and by the corners (m, 2) [m] of the outline's hull, beginning at the one nearest to the first
        corner of the outline.
        """
        hull = self.corners
        hull = flat.turned(hull, int(np.argmin(np.hypot(*hull.T))))  # decides between equal rectangles
        axes, low, high = smallest_rectangle(hull)
        return frozen(axes), frozen(low), frozen(high), frozen(hull)

    def flipped(self) -> Patch:
        """Return the same patch seen from the other body, with the normal reversed."""
        holes = tuple(hole[::-1] for hole in self.holes)
        spots = None if self.spots is None else self.spots.flipped()
        return replace(self, polygon=self.polygon[::-1], normal=-self.normal, holes=holes, spots=spots)


class Interface(Record):
    """All contact between two bodies: the patches, with normals that point into the second body.

    ``bodies`` are the two body names. A patch can be given by its ``polygon`` (k, 3) [m] and ``normal`` (3,) in the
    world frame, besides the ``patches``. ``status`` is "touching" or "penetrating", and ``flags`` say which contacts
    depend on a tolerance, a pose or a mesh. ``certain`` is False if the two bodies may not touch at all, for example if
    poses are uncertain; docs/howto/uncertainty.md says how answers use it. ``mu`` is the friction coefficient if it
    differs from that of the two bodies, as between parts of compounds with materials of their own, and otherwise None;
    two bodies have one interface for each coefficient. Raises GeometryError for a body paired with itself, for no
    patches and for a polygon that is not usable.
    """

    bodies: tuple[str, str]
    patches: tuple[Patch, ...]
    status: InterfaceStatus
    flags: tuple[str, ...]
    certain: bool
    mu: float | None

    def __init__(
        self,
        bodies: tuple[str, str],
        polygon: Any = None,  # noqa: ANN401 - (k, 3) numbers, checked
        normal: Any = None,  # noqa: ANN401 - (3,) numbers, checked
        *,
        patches: Sequence[Patch] = (),
        status: InterfaceStatus = "touching",
        flags: Sequence[str] = (),
        certain: bool = True,
        mu: float | None = None,
    ) -> None:
        if not isinstance(bodies, tuple | list) or len(bodies) != 2:
            raise GeometryError(message("interface", f"bodies is {bodies!r}", "needs the names of two bodies"))
        a, b = bodies
        where = f"interface ({a!r}, {b!r})"
        if a == b:
            raise GeometryError(message(where, "joins a body with itself", "needs two bodies"))
        if polygon is not None:
            patches = (given_patch(polygon, normal, where), *patches)
        if not patches:
            raise GeometryError(message(where, "has no patches", "give polygon= and normal="))
        set_ = object.__setattr__
        set_(self, "bodies", (a, b))
        set_(self, "patches", tuple(patches))
        set_(self, "status", status)
        set_(self, "flags", tuple(flags))
        set_(self, "certain", bool(certain))
        own = None if mu is None else checked_number(mu, f"{where}: mu", minimum=0, within=FRICTION)
        set_(self, "mu", own)

    @cached_property
    def memory(self) -> Memory:
        """Nodes on it that may be asked for again; they go with it."""
        return Memory(MOST_CACHED)

    @cached_property
    def canonical(self) -> dict[tuple[bytes, bytes, bool], Interface]:
        """Canonical forms of this contact that were made before, by origin and axes of the frame and if flipped."""
        return {}

    @property
    def separation(self) -> float | None:
        """The smallest distance of the two bodies at a patch [m], negative where they overlap; None if not known."""
        return min((patch.separation[0] for patch in self.patches if patch.separation is not None), default=None)

    @cached_property
    def area(self) -> float:
        """The total area of the patches [m²]; 0 if only lines or points touch."""
        return sum(patch.area for patch in self.patches)

    def flipped(self) -> Interface:
        """Return the same contact with its bodies in the other order, and all normals reversed."""
        a, b = self.bodies
        return altered(self, bodies=(b, a), patches=tuple(patch.flipped() for patch in self.patches))


def given_patch(polygon: Any, normal: Any, where: str) -> Patch:  # noqa: ANN401 - checked here
    """Return a patch from a user's polygon (k, 3) [m], in either sense of rotation, and normal (3,).

    Raises GeometryError if the polygon is not flat, has no area, crosses itself or does not match the normal; ``where``
    names the interface.
    """
    corners = checked(polygon, (None, 3), f"{where}: polygon", within=PLACE, error=GeometryError)
    direction = checked(normal, (3,), f"{where}: normal", error=GeometryError)
    if len(corners) < 3:
        raise GeometryError(message(where, f"polygon has {len(corners)} corners", "needs at least 3"))
    if not direction.any():
        raise GeometryError(message(where, "normal is zero", "needs a direction"))
    normal_ = unit(direction)
    centred = corners - corners.mean(0)
    size = float(np.linalg.norm(centred, axis=1).max())
    if np.abs(centred @ normal_).max() > FLATNESS * size:
        tilt = float(np.abs(centred @ normal_).max())
        raise GeometryError(message(where, f"corners leave the plane by {tilt:.3g} m", "split it into flat polygons"))
    flattened = corners - np.outer(centred @ normal_, normal_)
    patch = Patch(frozen(flattened), frozen(normal_))
    if patch.area < 0:
        patch = Patch(frozen(flattened[::-1].copy()), frozen(normal_))
    if not patch.area > 1e-12 * size**2:
        raise GeometryError(message(where, f"polygon has area {patch.area:.3g} m²", "needs a surface"))
    if not flat.shapely_polygon(patch.rings).is_valid:
        raise GeometryError(message(where, "polygon crosses itself", "give its corners in order"))
    return patch


def canonical(interfaces: Sequence[Interface], flipped: Sequence[bool], frame: Frame) -> list[Interface]:
    """Return the same contacts in canonical form.

    Coordinates in ``frame`` are rounded, far below their accuracy. Every outline begins at its first corner in the
    order of these coordinates, and patches are in the order of these corners. Those that are ``flipped`` are seen from
    the other body: the order of the bodies and all normals are reversed. Each is kept with the contact.
    """
    about = frame.origin.tobytes(), frame.axes.tobytes()
    missing = [k for k, one in enumerate(interfaces) if (*about, flipped[k]) not in one.canonical]
    patches = [(patch, flipped[k]) for k in missing for patch in interfaces[k].patches]
    made = iter(_canonical_patches(patches, frame) if patches else [])
    for k in missing:
        one, own = interfaces[k], [next(made) for _ in interfaces[k].patches]
        if len(own) > 1:
            places = np.array([frame.seen(patch.polygon[0]) for patch in own])
            order = np.lexsort(snapped(places, float(np.abs(places).max()), core.FIRST).T[::-1])
            own = [own[number] for number in order.tolist()]
        bodies = one.bodies[::-1] if flipped[k] else one.bodies
        one.canonical.clear()  # bodies belong to one group at a time
        one.canonical[*about, flipped[k]] = altered(one, bodies=bodies, patches=tuple(own))
    return [one.canonical[*about, turned] for one, turned in zip(interfaces, flipped, strict=True)]


def _canonical_patches(patches: Sequence[tuple[Patch, bool]], frame: Frame) -> list[Patch]:
    """Return patches in canonical form, those flipped of which that is said."""
    rings = [(patch.polygon, *patch.holes) for patch, _ in patches]
    every = [ring for own in rings for ring in own]
    ring = np.cumsum([0, *map(len, rings)])
    corners, corner, normals, moments, centroids = (
        frozen(each)
        for each in core.canonical(
            (
                np.concatenate(every),
                np.cumsum([0, *map(len, every)]),
                ring,
                np.array([patch.normal for patch, _ in patches]),
                np.array([flipped for _, flipped in patches]),
            ),
            frame.origin,
            frame.axes,
        )
    )
    outlines = [corners[a:b] for a, b in pairwise(corner.tolist())]  # parts of a read-only array are read-only
    frames = frozen(np.stack(tangents(np.asarray(normals, dtype=np.float64)), axis=1))
    found = []
    for k, ((patch, flipped), (first, last)) in enumerate(zip(patches, pairwise(ring.tolist()), strict=True)):
        spots = patch.spots
        if spots is not None:
            spots = (spots.flipped() if flipped else spots).canonical(frame, core.CANONICAL)
        outline, *holes = outlines[first:last]
        same = altered(patch, polygon=outline, normal=normals[k], holes=tuple(holes), spots=spots)
        same.__dict__["frame"] = frames[k]
        if same.kind == "face" and spots is None:
            same.__dict__.update(moments=moments[k], centroid=centroids[k])
        found.append(same)
    return found
