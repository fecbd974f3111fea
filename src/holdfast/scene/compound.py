"""Sums of masses and inertias, compounds of several shapes that move as one body, and the list of all shapes."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, Int, checked_items, checked_name
from holdfast.base.errors import GeometryError, located, message
from holdfast.base.public import Record
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import checked_pose, transform
from holdfast.geometry.solid import united
from holdfast.geometry.surface import Surface
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder, MassProperties, Mesh, Sphere, enclosed

Solid: TypeAlias = Box | Cylinder | Sphere | Capsule | Ellipsoid | Mesh


class Inertial(NamedTuple):
    """A mass [kg], its centre (3,) [m] and its inertia (3, 3) [kg m²] about it, along the axes of some frame."""

    mass: float
    com: Float
    inertia: Float

    def seen(self, pose: Float) -> Inertial:
        """Return the same in another frame; ``pose`` (4, 4) maps this frame to it."""
        R = pose[:3, :3]
        return Inertial(self.mass, transform(pose, self.com[None])[0], R @ self.inertia @ R.T)

    def about(self, point: Float) -> Float:
        """Return the inertia (3, 3) [kg m²] about another ``point`` (3,) [m] (parallel axis theorem)."""
        arm = self.com - point
        return np.asarray(self.inertia + self.mass * (np.eye(3) * (arm @ arm) - np.outer(arm, arm)))

    def weighing(self, mass: float | None) -> Inertial:
        """Return the same distribution with another ``mass`` [kg]; None stands for its own."""
        share = 1.0 if mass is None else mass / self.mass
        return Inertial(share * self.mass, self.com, share * self.inertia)


def together(inertials: Iterable[Inertial]) -> Inertial:
    """Return the sum of several inertials in the same frame, at least one of which has a mass."""
    each = list(inertials)
    if len(each) == 1:
        return each[0]
    mass = sum(one.mass for one in each)
    com = np.asarray(sum((one.mass * one.com for one in each), np.zeros(3)) / mass)
    return Inertial(float(mass), com, np.asarray(sum((one.about(com) for one in each), np.zeros((3, 3)))))


class Part(Record):
    """One shape of a compound, with its own ``pose`` (4, 4), part frame to body frame, and its own ``material``.

    ``shape`` is any shape with a volume, or a trimesh.Trimesh. Without a ``material`` the part has that of the body.
    Raises GeometryError for another shape or a pose that is not rigid.

    For example:

    >>> grip = hf.Part(hf.Cylinder(0.015, 0.12), hf.pose(0, 0, 0.06), material="rubber")
    >>> hf.Compound([hf.Box((0.1, 0.1, 0.02)), grip]).parts[1].material
    'rubber'
    """

    shape: Solid
    pose: Float
    material: str | None

    def __init__(self, shape: Any, pose: ArrayLike | None = None, material: str | None = None) -> None:  # noqa: ANN401
        solid = as_shape(shape, "Part")
        if isinstance(solid, HalfSpace | Compound):
            problem = f"shape is a {type(solid).__name__}"
            raise GeometryError(message("Part", problem, "needs a shape with an end; give the parts of a compound"))
        object.__setattr__(self, "shape", solid)
        object.__setattr__(self, "pose", checked_pose(np.eye(4) if pose is None else pose, "Part: pose"))
        named = None if material is None else checked_name(material, "Part: material")
        object.__setattr__(self, "material", named)

    def placed(self, points: Float) -> Float:
        """Map points (n, 3) [m] from the part frame to the body frame."""
        return transform(self.pose, points)


class Compound(Record):
    """Several parts that move as one: they may overlap, abut or lie apart.

    Contacts, maps and pictures use the surface of their union, so there are no contacts inside. Common volume counts
    once in the mass properties: if parts overlap, these are computed from the surface of the union, otherwise they are
    the sum of those of the parts. ``parts`` are ``Part`` objects, or shapes that need no pose. A part may be an open
    mesh. Then its surface is used as it is, and the mass properties raise GeometryError, so that the body must be fixed
    or be given its mass, centre of mass and inertia. Raises GeometryError if there are no parts.

    For example:

    >>> head = hf.Part(hf.Box((0.1, 0.03, 0.03)), hf.pose(0, 0, 0.165))
    >>> hammer = hf.Compound([hf.Box((0.02, 0.02, 0.3)), head])
    >>> round(hf.Body("hammer", hammer, density=1000).mass, 3)
    0.21
    """

    parts: tuple[Part, ...]

    def __init__(self, parts: Iterable[Part | Solid]) -> None:
        given = checked_items(parts, "Compound: parts", "parts", GeometryError)
        found = tuple(part if isinstance(part, Part) else Part(part) for part in given)
        if not found:
            raise GeometryError(message("Compound", "has no parts", "needs at least one"))
        object.__setattr__(self, "parts", found)

    @cached_property
    def _united(self) -> tuple[Surface, Int, float]:
        """The surface of the union, the part of each of its triangles, and the volume that parts have in common."""
        each = [(part.placed(part.shape.surface.vertices), part.shape.surface.faces) for part in self.parts]
        opened = [k for k, part in enumerate(self.parts) if isinstance(part.shape, Mesh) and not part.shape.is_closed]
        closed = [k for k in range(len(self.parts)) if k not in opened]
        vertices, faces, owner, shared = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], [], 0.0
        if closed:
            found = united([each[k] for k in closed])
            if found is None:
                problem = "the union of its parts cannot be made"
                raise GeometryError(message("Compound", problem, "check its meshes, or give one mesh"))
            vertices, faces, shared = [found.vertices], [found.faces], found.shared
            owner = [np.array(closed)[found.part]]
        for k in opened:
            faces.append(each[k][1] + sum(len(other) for other in vertices))
            vertices.append(each[k][0])
            owner.append(np.full(len(each[k][1]), k))
        surfaces = [part.shape.surface for part in self.parts]
        whole = Surface(
            np.vstack(vertices),
            np.vstack(faces),
            max(surface.sagitta for surface in surfaces),
            all(surface.oriented for surface in surfaces),
        )
        return whole, np.concatenate(owner), shared

    @property
    def surface(self) -> Surface:
        """The surface of the union."""
        return self._united[0]

    @property
    def part_of(self) -> Int:
        """The number of the part (F,) on which each triangle of the surface lies."""
        return self._united[1]

    def only(self, parts: tuple[int, ...]) -> Compound:
        """Return the compound of the parts with these numbers; the same one each time."""
        if parts not in self._subsets:
            self._subsets[parts] = Compound(self.parts[k] for k in parts)
        return self._subsets[parts]

    @cached_property
    def _subsets(self) -> dict[tuple[int, ...], Compound]:
        return {}

    @cached_property
    def mass_properties(self) -> MassProperties:
        """The mass properties of all parts together, with common volume counted once.

        Raises GeometryError if a part does not enclose a volume.
        """
        surface, _, shared = self._united
        volume = 0.0
        for k, part in enumerate(self.parts):
            with located(f"part {k}"):
                volume += part.shape.mass_properties.volume
        if shared > COORDINATES * volume:
            import trimesh

            # without processing, because welding nearly coincident vertices of a union could open it
            return enclosed(trimesh.Trimesh(surface.vertices, surface.faces, process=False))
        own = ((part.pose, part.shape.mass_properties) for part in self.parts)
        return MassProperties(*together(Inertial(p.volume, p.com, p.inertia).seen(pose) for pose, p in own))


Shape: TypeAlias = Solid | HalfSpace | Compound


def solids_in(shape: Solid | Compound) -> list[tuple[Solid, Float]]:
    """Return the solids of a shape, each with its pose (4, 4) in the frame of the shape."""
    return [(part.shape, part.pose) for part in shape.parts] if isinstance(shape, Compound) else [(shape, np.eye(4))]


def as_shape(value: Any, where: str) -> Shape:  # noqa: ANN401 - a shape or a trimesh.Trimesh
    """Return ``value`` if it is a shape, or a Mesh if it has ``vertices`` and ``faces``, as a trimesh.Trimesh has.

    Raises GeometryError for anything else.
    """
    if isinstance(value, Solid | HalfSpace | Compound):
        return value
    if hasattr(value, "vertices") and hasattr(value, "faces"):
        return Mesh(value.vertices, value.faces, label=where)
    remedy = "needs Box, Cylinder, Sphere, Capsule, Ellipsoid, HalfSpace, Mesh, Compound or a trimesh.Trimesh"
    raise GeometryError(message(where, f"shape is a {type(value).__name__}", remedy))
