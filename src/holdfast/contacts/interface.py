"""Contact patches and interfaces as values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, checked, frozen, kept, unit
from holdfast.base.errors import GeometryError, message
from holdfast.base.rigid import tangents
from holdfast.base.values import Value
from holdfast.geometry import polygon as flat
from holdfast.geometry.hull import convex_hull

FLATNESS = 0.02  # [-] how far a given polygon's corners may leave its plane, relative to its size

PatchKind = Literal["face", "line", "point"]
InterfaceStatus = Literal["touching", "penetrating"]


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Patch(Value):
    """A flat piece of contact: a face, a line, or a point.

    ``polygon`` (k, 3) [m], counter-clockwise seen from the tip of ``normal`` (3,); two corners are a line, one is a
    point. ``holes`` (h, 3) run clockwise. ``separation``: least and largest distance of the two surfaces along the
    normal [m], negative where they overlap; None where it is not known. ``breadth`` [m] stands for the width that a
    line or a point has in reality, ``inset`` [m] tells how far inside the nearest sharp edge it lies.
    """

    polygon: Float
    normal: Float
    holes: tuple[Float, ...] = ()
    separation: tuple[float, float] | None = None
    breadth: float = 0.0
    inset: float = np.inf

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "polygon", kept(self.polygon))
        set_(self, "normal", kept(self.normal))
        set_(self, "holes", tuple(kept(hole) for hole in self.holes))

    @property
    def kind(self) -> PatchKind:
        """What touches: "face", "line" or "point"."""
        return "face" if len(self.polygon) > 2 else "line" if len(self.polygon) == 2 else "point"

    @cached_property
    def frame(self) -> Float:
        """(2, 3) tangents t1, t2 with t1 x t2 = normal; they depend on the normal alone."""
        return frozen(np.array(tangents(self.normal)))

    @cached_property
    def rings(self) -> tuple[Float, ...]:
        """The outline and holes in the frame, relative to the first corner."""
        return tuple(frozen((ring - self.polygon[0]) @ self.frame.T) for ring in (self.polygon, *self.holes))

    def lifted(self, points: Float) -> Float:
        """Points (n, 2) of the frame in the world (n, 3)."""
        return np.asarray(self.polygon[0] + points @ self.frame)

    @cached_property
    def _moments(self) -> Float:
        return frozen(flat.polynomial_moments(self.rings))

    @property
    def area(self) -> float:
        """[m²]; a line and a point have none."""
        return float(self._moments[0]) if self.kind == "face" else 0.0

    @property
    def length(self) -> float:
        """Of a line [m], else 0."""
        return float(np.linalg.norm(self.polygon[1] - self.polygon[0])) if self.kind == "line" else 0.0

    @property
    def measure(self) -> float:
        """Its weight where nodes and stiffness are shared out [m²]: the area; lines and points are ``breadth`` wide."""
        return {"face": self.area, "line": self.length * self.breadth, "point": self.breadth**2}[self.kind]

    @cached_property
    def centroid(self) -> Float:
        """(3,) [m]."""
        if self.kind != "face":
            return frozen(self.polygon.mean(0))
        return frozen(self.lifted(self._moments[None, 1:3] / self.area)[0])

    @cached_property
    def size(self) -> float:
        """Largest extent along the frame's axes [m]."""
        return float(np.ptp(self.rings[0], axis=0).max())

    @cached_property
    def width(self) -> float:
        """Twice the area over the perimeter [m]: the thickness of a strip, about half that of a square."""
        if self.kind != "face":
            return 0.0
        ring = self.rings[0]
        perimeter = float(np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1).sum())
        return 2 * self.area / perimeter if perimeter > 0 else 0.0

    @property
    def room(self) -> float:
        """How far the bodies may slip sideways before the patch is lost [m], in its narrowest direction."""
        return self.width if self.kind == "face" else self.inset

    @cached_property
    def hull(self) -> Float:
        """(m, 3) corners of the convex hull, counter-clockwise."""
        if self.kind != "face":
            return self.polygon
        return frozen(self.lifted(convex_hull(self.rings[0], 1e-9 * self.size)))

    def flipped(self) -> Patch:
        """The same patch seen from the other body."""
        holes = tuple(hole[::-1] for hole in self.holes)
        return replace(self, polygon=self.polygon[::-1], normal=-self.normal, holes=holes)


@archived
@dataclass(frozen=True, init=False, eq=False, repr=False)
class Interface(Value):
    """All patches between two bodies; their normals point into the second one."""

    bodies: tuple[str, str]
    patches: tuple[Patch, ...]
    status: InterfaceStatus
    flags: tuple[str, ...]

    def __init__(
        self,
        bodies: tuple[str, str],
        polygon: Any = None,  # noqa: ANN401 - (k, 3) numbers, checked
        normal: Any = None,  # noqa: ANN401 - (3,) numbers, checked
        *,
        patches: Sequence[Patch] = (),
        status: InterfaceStatus = "touching",
        flags: Sequence[str] = (),
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

    @cached_property
    def samples(self) -> dict[tuple[int, str, int], list[tuple[Float, Float]]]:
        """Nodes sampled so far, by count, sampling and seed: many assemblies that differ little share an interface."""
        return {}

    @property
    def area(self) -> float:
        """Sum over the patches [m²]; 0 where only edges or points touch."""
        return sum(patch.area for patch in self.patches)


def given_patch(polygon: Any, normal: Any, where: str) -> Patch:  # noqa: ANN401 - checked here
    """A patch from a polygon (k, 3) and a normal (3,) given from outside, in either sense of rotation."""
    corners = checked(polygon, (None, 3), f"{where}: polygon", error=GeometryError)
    direction = checked(normal, (3,), f"{where}: normal", error=GeometryError)
    if len(corners) < 3:
        raise GeometryError(message(where, f"polygon has {len(corners)} corners", "needs at least 3"))
    if not np.linalg.norm(direction) > 0:
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
