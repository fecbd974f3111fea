"""A rigid body: shape, mass and pose."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, checked, checked_number, frozen
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.rigid import checked_pose, transform
from holdfast.base.values import Value
from holdfast.geometry.surface import Surface
from holdfast.scene.shapes import Shape, as_shape

if TYPE_CHECKING:
    import trimesh


ROUNDING = 1e-9  # [-] by how much a mass may differ from density times volume: processors differ in the last digits


@archived
@dataclass(frozen=True, init=False, eq=False, repr=False)
class Body(Value):
    """A rigid body.

    ``pose`` (4, 4) takes the body frame to the world. A movable body needs ``mass`` [kg] or ``density`` [kg/m³]; a
    density gives the mass too. ``com`` (3,) [m] in the body frame and ``inertia`` (3, 3) [kg m²] about it come from the
    shape unless given: they stay None, ``com_body`` and ``inertia_com`` are what they come to. ``material`` names a row
    of the friction table.

    ``dataclasses.replace`` makes a body with another pose, name, material ...; where it changes the mass, the density
    or the shape of a body that was given by density, say both: ``mass=None, density=500``.
    """

    name: str
    shape: Shape
    mass: float | None
    density: float | None
    pose: Float
    com: Float | None
    inertia: Float | None
    material: str | None
    fixed: bool

    def __init__(
        self,
        name: str,
        shape: Shape | trimesh.Trimesh,
        mass: float | None = None,
        density: float | None = None,
        pose: ArrayLike | None = None,
        com: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        material: str | None = None,
        fixed: bool = False,
    ) -> None:
        if not isinstance(name, str) or not name.strip():
            raise SceneError(message("body", f"name is {name!r}", "needs a non-empty text"))
        where = f"body {name!r}"
        set_ = object.__setattr__
        set_(self, "name", name)
        set_(self, "material", material)
        with located(where):
            if not isinstance(fixed, bool | np.bool_):
                raise SceneError(message(f"{where}: fixed", f"is {fixed!r}", "needs True or False"))
            set_(self, "fixed", bool(fixed))
            set_(self, "shape", as_shape(shape, where))
            set_(self, "pose", checked_pose(np.eye(4) if pose is None else pose, f"{where}: pose"))
            set_(self, "com", None if com is None else checked(com, (3,), f"{where}: com"))
            set_(self, "inertia", None if inertia is None else _checked_inertia(inertia, f"{where}: inertia"))
            self._set_mass(mass, density, where)
            if not self.fixed:
                _ = self.com_body  # a shape without a volume has none: say so now

    def _set_mass(self, mass: float | None, density: float | None, where: str) -> None:
        """Keep the mass that was given or follows from the density; both only where they agree."""
        set_ = object.__setattr__
        if mass is not None:
            mass = checked_number(mass, f"{where}: mass", above=0)
        if density is not None:
            density = checked_number(density, f"{where}: density", above=0)
            follows = density * self.shape.mass_properties.volume
            if mass is not None and not math.isclose(mass, follows, rel_tol=ROUNDING):
                problem = f"mass = {mass:g} and density = {density:g}"
                raise SceneError(message(where, problem, "give one of them, the other as None"))
            mass = follows if mass is None else mass
        if mass is None and not self.fixed:
            raise SceneError(message(where, "has no mass", "give mass= or density=, or fixed=True"))
        set_(self, "mass", mass)
        set_(self, "density", density)

    def moved(self, pose: ArrayLike) -> Body:
        """The same body at another ``pose`` (4, 4), body frame to world."""
        return replace(self, pose=checked_pose(pose, f"body {self.name!r}: pose"))

    @cached_property
    def com_body(self) -> Float:
        """(3,) centre of mass in the body frame [m]; the frame's origin for a fixed body without one."""
        if self.com is not None:
            return self.com
        return frozen(np.zeros(3) if self.fixed else np.array(self.shape.mass_properties.com))

    @cached_property
    def com_world(self) -> Float:
        """(3,) centre of mass in the world [m]; the frame's origin for a fixed body without one."""
        return frozen(self.placed(self.com_body[None])[0])

    @cached_property
    def inertia_com(self) -> Float:
        """(3, 3) inertia about the centre of mass, body axes [kg m²]."""
        if self.inertia is not None:
            return self.inertia
        shape = self.shape.mass_properties
        mass = 0.0 if self.mass is None else self.mass
        offset = shape.com - (shape.com if self.com is None else self.com)
        parallel = np.eye(3) * (offset @ offset) - np.outer(offset, offset)
        return frozen(mass / shape.volume * shape.inertia + mass * parallel)

    def placed(self, points: Float) -> Float:
        """Points (n, 3) of the body frame in the world [m]."""
        return transform(self.pose, points)

    @cached_property
    def box(self) -> tuple[Float, Float]:
        """Lowest and highest corner (3,) of the bounding box in the world [m]."""
        vertices = self.surface_world.vertices
        return frozen(vertices.min(0)), frozen(vertices.max(0))

    @property
    def size(self) -> float:
        """Diagonal of the bounding box in the world [m]."""
        return float(np.linalg.norm(self.box[1] - self.box[0]))

    @cached_property
    def surface_world(self) -> Surface:
        """The shape's triangles in the world."""
        surface = self.shape.surface
        return Surface(self.placed(surface.vertices), surface.faces, surface.sagitta, surface.oriented)

    @cached_property
    def reduced_world(self) -> Surface:
        """The same solid in as few triangles as its flat faces need, in the world: what contact search works on."""
        local = self.shape.surface.reduced
        return Surface(self.placed(local.vertices), local.faces, local.sagitta, local.oriented)


def _checked_inertia(value: Any, where: str) -> Float:  # noqa: ANN401
    inertia = checked(value, (3, 3), where)
    if not np.allclose(inertia, inertia.T, rtol=1e-9, atol=1e-15):
        raise GeometryError(message(where, "is not symmetric", "needs a symmetric (3, 3) array"))
    if np.linalg.eigvalsh(inertia).min() < -1e-12 * abs(inertia).max():
        raise GeometryError(message(where, "has a negative principal moment", "needs a positive semi-definite array"))
    return inertia
