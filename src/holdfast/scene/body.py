"""A rigid body: shape, mass and pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.base.arrays import Float, checked, checked_number, frozen
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.rigid import checked_pose, transform
from holdfast.geometry.surface import Surface
from holdfast.scene.shapes import Shape, as_shape


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body.

    ``pose`` (4, 4) takes the body frame to the world. A movable body needs ``mass`` [kg] or ``density`` [kg/m³].
    ``com`` (3,) [m] in the body frame and ``inertia`` (3, 3) [kg m²] about it come from the shape unless given.
    ``material`` names a row of the friction table.
    """

    name: str
    shape: Shape
    mass: float | None = None
    density: float | None = None
    pose: Float | None = None
    com: Float | None = None
    inertia: Float | None = None
    material: str | None = None
    fixed: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.strip():
            raise SceneError(message("body", f"name is {self.name!r}", "needs a non-empty text"))
        where = f"body {self.name!r}"
        with located(where):
            self._check(where)

    def _check(self, where: str) -> None:
        set_ = object.__setattr__
        if not isinstance(self.fixed, bool | np.bool_):
            raise SceneError(message(f"{where}: fixed", f"is {self.fixed!r}", "needs True or False"))
        set_(self, "shape", as_shape(self.shape, where))
        set_(self, "pose", checked_pose(np.eye(4) if self.pose is None else self.pose, f"{where}: pose"))
        set_(self, "com_given", self.com is not None)
        if self.com is not None:
            set_(self, "com", checked(self.com, (3,), f"{where}: com"))
        if self.inertia is not None:
            set_(self, "inertia", _checked_inertia(self.inertia, f"{where}: inertia"))
        self._resolve_mass(where)

    def _resolve_mass(self, where: str) -> None:
        if self.mass is not None and self.density is not None:
            problem = f"mass = {self.mass!r} and density = {self.density!r}"
            raise SceneError(message(where, problem, "give one of them"))
        if self.density is not None:
            density = checked_number(self.density, f"{where}: density", above=0)
            object.__setattr__(self, "mass", density * self.shape.mass_properties.volume)
        elif self.mass is not None:
            object.__setattr__(self, "mass", checked_number(self.mass, f"{where}: mass", above=0))
        elif not self.fixed:
            raise SceneError(message(where, "has no mass", "give mass= or density=, or fixed=True"))
        if not self.fixed and self.com is None:
            object.__setattr__(self, "com", self.shape.mass_properties.com)

    com_given = False

    @cached_property
    def com_world(self) -> Float:
        """(3,) centre of mass in the world [m]; the frame's origin for a fixed body without one."""
        com = np.zeros(3) if self.com is None else self.com
        return frozen(self.placed(com[None])[0])

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
        return transform(self._pose, points)

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

    @property
    def _pose(self) -> Float:
        assert self.pose is not None
        return self.pose


def _checked_inertia(value: Any, where: str) -> Float:  # noqa: ANN401
    inertia = checked(value, (3, 3), where)
    if not np.allclose(inertia, inertia.T, rtol=1e-9, atol=1e-15):
        raise GeometryError(message(where, "is not symmetric", "needs a symmetric (3, 3) array"))
    if np.linalg.eigvalsh(inertia).min() < -1e-12 * abs(inertia).max():
        raise GeometryError(message(where, "has a negative principal moment", "needs a positive semi-definite array"))
    return inertia
