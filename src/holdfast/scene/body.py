"""A rigid body, defined by its shape, mass and pose, and what a carton may bear."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence, Sized
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_name, checked_number, checked_truth, frozen
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.public import Record, column
from holdfast.base.ranges import COORDINATES, DENSITY, FORCE, INERTIA, LENGTH, MASS, PLACE, PRESSURE, Range
from holdfast.base.rigid import checked_pose, pose_at, transform
from holdfast.base.text import quoted
from holdfast.base.values import altered
from holdfast.geometry.surface import Cuboid, Surface
from holdfast.scene.compound import Compound, Inertial, Shape, as_shape
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.shapes import Box

if TYPE_CHECKING:
    import trimesh


MCKEE = 5.87  # for regular slotted cartons; dimensionless
# What is left at most of the strength of a carton of 50 % relative humidity, and after days under load.
HUMIDITY = ((0.5, 0.6, 0.7, 0.8, 0.9), (1.0, 0.9, 0.8, 0.68, 0.48))
DAYS = ((0.0, 10.0, 30.0, 90.0, 180.0), (1.0, 0.63, 0.6, 0.55, 0.5))


class Body(Record):
    """A rigid body with a shape, a mass and a pose.

    ``pose`` (4, 4) maps the body frame to the world frame; by default both are the same. Instead of it, ``position``
    (3,) [m], ``rpy_degrees`` (3,) [deg] (roll, pitch and yaw, see ``holdfast.pose``), or both can be given. A movable
    body needs ``mass`` [kg] or ``density`` [kg/m³]; a density also sets the mass. ``com`` (3,) [m] is the centre of
    mass in the body frame, and ``inertia`` (3, 3) [kg m²] is the inertia about it, along the body axes. If they are not
    given they stay None and follow from the shape: ``com_body`` and ``inertia_com`` are the values in use. ``material``
    is a name that the friction table can use for several bodies. A ``fixed`` body never moves and needs no mass.
    ``top_load`` [N] is the most that its upper faces may bear as force along gravity, such as the box compression
    strength of a carton, or 0 for what nothing may lie on; ``pressure`` [Pa] the most that a face of it may bear along
    its normal, as the mean over each contact. None means no limit. They change no status; ``Stability.bearing`` says
    who is crushed first.

    ``dataclasses.replace`` makes a body with another pose, name, material and so on. To change the mass, density or
    shape of a body that was given by density, pass both values: ``mass=None, density=500``.

    Raises SceneError if a value is malformed, or if the mass is missing or contradicts the density. Raises
    GeometryError if the pose is not rigid, the inertia is impossible or the shape is invalid. A movable body whose
    shape has no volume needs ``com``.

    For example:

    >>> crate = hf.Body("crate", hf.Box((0.2, 0.2, 0.3)), density=500, position=(0, 0, 0.15))
    >>> round(crate.mass, 3)  # 0.2 · 0.2 · 0.3 m³ · 500 kg/m³
    6.0
    """

    name: str
    shape: Shape
    mass: float | None
    density: float | None
    pose: Float = column("4 4")
    com: Float | None
    inertia: Float | None
    material: str | None
    fixed: bool
    top_load: float | None
    pressure: float | None

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
        *,
        position: ArrayLike | None = None,
        rpy_degrees: ArrayLike | None = None,
        top_load: float | None = None,
        pressure: float | None = None,
    ) -> None:
        where = f"body {quoted(checked_name(name, 'body: name'))}"
        set_ = object.__setattr__
        set_(self, "name", name)
        set_(self, "material", None if material is None else checked_name(material, f"{where}: material"))
        for what, limit, within in (("top_load", top_load, FORCE), ("pressure", pressure, PRESSURE)):
            known = None if limit is None else checked_number(limit, f"{where}: {what}", minimum=0, within=within)
            set_(self, what, known)
        with located(where):
            set_(self, "fixed", checked_truth(fixed, f"{where}: fixed"))
            set_(self, "shape", as_shape(shape, where))
            if isinstance(self.shape, HalfSpace) and not self.fixed:
                raise SceneError(message(where, "is a HalfSpace that can move", "needs fixed=True"))
            set_(self, "pose", _pose_of(pose, position, rpy_degrees, where))
            set_(self, "com", None if com is None else checked(com, (3,), f"{where}: com", within=PLACE))
            set_(self, "inertia", None if inertia is None else _checked_inertia(inertia, f"{where}: inertia"))
            self._set_mass(mass, density, where)
            if not self.fixed:
                _ = self.com_body  # raises now if the shape has no volume

    def _set_mass(self, mass: float | None, density: float | None, where: str) -> None:
        """Store the given mass, or the mass that follows from the density; accept both only if they agree."""
        set_ = object.__setattr__
        for what, given in (("mass", mass), ("density", density)):
            if _is_triple(given):
                remedy = "needs a number; where the body is, is written position=(x, y, z) [m]"
                raise SceneError(message(f"{where}: {what}", f"got {quoted(given, 80)}", remedy))
        if mass is not None:
            mass = checked_number(mass, f"{where}: mass", above=0, within=MASS)
        if density is not None:
            density = checked_number(density, f"{where}: density", above=0, within=DENSITY)
            follows = density * self.shape.mass_properties.volume
            if mass is not None and not math.isclose(mass, follows, rel_tol=COORDINATES):
                problem = f"mass = {mass:g} and density = {density:g}"
                raise SceneError(message(where, problem, "give one of them, the other as None"))
            mass = checked_number(follows if mass is None else mass, f"{where}: mass", above=0, within=MASS)
        if mass is None and not self.fixed:
            raise SceneError(message(where, "has no mass", "give mass= or density=, or fixed=True"))
        set_(self, "mass", mass)
        set_(self, "density", density)

    @property
    def materials(self) -> tuple[str | None, ...]:
        """The material of each part of the body: of a compound, the body's where a part has none of its own."""
        if not isinstance(self.shape, Compound):
            return (self.material,)
        return tuple(self.material if part.material is None else part.material for part in self.shape.parts)

    def only(self, parts: Sequence[int]) -> Body:
        """Return the body with only these parts of its compound, and with the same mass, centre of mass and pose."""
        if not isinstance(self.shape, Compound):
            return self
        return replace(self, shape=self.shape.only(tuple(parts)), density=None, com=self.com_body)

    def moved(self, pose: ArrayLike) -> Body:
        """Return the same body at another ``pose`` (4, 4), body frame to world."""
        return altered(self, pose=checked_pose(pose, f"body {quoted(self.name)}: pose"))

    @cached_property
    def com_body(self) -> Float:
        """The centre of mass (3,) [m] in the body frame; for a fixed body without one, the origin of that frame."""
        if self.com is not None:
            return self.com
        return frozen(np.zeros(3) if self.fixed else np.array(self.shape.mass_properties.com))

    @cached_property
    def com_world(self) -> Float:
        """The centre of mass (3,) [m] in the world frame; for a fixed body without one, its frame's origin."""
        return frozen(self.placed(self.com_body[None])[0])

    @cached_property
    def inertia_com(self) -> Float:
        """The inertia (3, 3) [kg m²] about the centre of mass, along the body axes."""
        if self.inertia is not None:
            return self.inertia
        shape = self.shape.mass_properties
        mass = 0.0 if self.mass is None else self.mass
        whole = Inertial(mass, shape.com, mass / shape.volume * shape.inertia)
        return frozen(whole.about(shape.com if self.com is None else self.com))

    def placed(self, points: Float) -> Float:
        """Map points (n, 3) [m] from the body frame to the world frame."""
        return transform(self.pose, points)

    @cached_property
    def box(self) -> tuple[Float, Float]:
        """The lowest and the highest corner (3,) [m] of the bounding box, in the world frame."""
        vertices = self.surface_world.vertices
        return frozen(vertices.min(0)), frozen(vertices.max(0))

    @cached_property
    def size(self) -> float:
        """The diagonal [m] of the bounding box in the world frame."""
        return float(np.linalg.norm(self.box[1] - self.box[0]))

    @cached_property
    def across(self) -> float:
        """The longest side [m] of the bounding box in the world frame."""
        return float((self.box[1] - self.box[0]).max())

    @cached_property
    def surface_world(self) -> Surface:
        """The triangles of the shape in the world frame."""
        surface = self.shape.surface
        return Surface(self.placed(surface.vertices), surface.faces, surface.sagitta, surface.oriented)

    @cached_property
    def reduced_world(self) -> Surface:
        """The surface of the same solid in the world frame, with as few triangles as its flat faces need.

        The contact search works on this surface.
        """
        local = self.shape.surface.reduced
        return Surface(self.placed(local.vertices), local.faces, local.sagitta, local.oriented)

    @cached_property
    def cuboid(self) -> Cuboid | None:
        """The body as a cuboid in the world frame; None if it has another shape."""
        local = self.shape.surface.cuboid
        return None if local is None else local.placed(self.pose)


def place_cuboids(bodies: Sequence[Body]) -> None:
    """Find the boxes, sizes and cuboids of all bodies with the shape of a box together, with the same digits."""
    boxes = [body for body in bodies if isinstance(body.shape, Box | HalfSpace) and "cuboid" not in body.__dict__]
    new = [body for body in boxes if body.shape.surface.cuboid is not None]  # a sheet may not be one
    if not new:
        return
    local = [cuboid for body in new if (cuboid := body.shape.surface.cuboid) is not None]
    poses = np.array([body.pose for body in new])
    turns, places = poses[:, :3, :3], poses[:, None, :3, 3]
    back = turns.transpose(0, 2, 1)
    corners = np.array([body.shape.surface.vertices for body in new]) @ back + places
    low, high = frozen(corners.min(1)), frozen(corners.max(1))
    across = high - low
    sizes = np.sqrt(across[:, None] @ across[:, :, None]).ravel().tolist()
    longest = across.max(1).tolist()
    found = Cuboid.placed_together(local, turns, places)
    for k, body in enumerate(new):
        body.__dict__.update(box=(low[k], high[k]), size=sizes[k], across=longest[k], cuboid=found[k])


def materials_of(bodies: Iterable[Body]) -> frozenset[str]:
    """Return the names of all materials of bodies and of their parts."""
    return frozenset(name for body in bodies for name in (body.material, *body.materials) if name is not None)


def _pose_of(pose: Any, position: Any, rpy_degrees: Any, where: str) -> Float:  # noqa: ANN401 - checked here
    """Return the pose (4, 4) of a body, which is given by ``pose`` or by ``position`` and ``rpy_degrees``."""
    if pose is None:
        none = (0.0, 0.0, 0.0)
        return pose_at(none if position is None else position, none if rpy_degrees is None else rpy_degrees, where)
    if position is not None or rpy_degrees is not None:
        problem = "is given twice, by pose and by position or rpy_degrees"
        raise SceneError(message(f"{where}: pose", problem, "give pose=, or the other two"))
    if _is_triple(pose):
        remedy = "needs a (4, 4) array; a place alone is written position=(x, y, z) [m]"
        raise GeometryError(message(f"{where}: pose", f"got {quoted(pose, 80)}", remedy))
    return checked_pose(pose, f"{where}: pose")


def _is_triple(value: Any) -> bool:  # noqa: ANN401
    if isinstance(value, np.ndarray):
        return bool(value.shape == (3,))
    return isinstance(value, tuple | list) and len(value) == 3 and not isinstance(value[0], Sized)


def _checked_inertia(value: Any, where: str) -> Float:  # noqa: ANN401
    inertia = checked(value, (3, 3), where, within=INERTIA)
    if not np.allclose(inertia, inertia.T, rtol=1e-9, atol=1e-15):
        raise GeometryError(message(where, "is not symmetric", "needs a symmetric (3, 3) array"))
    if np.linalg.eigvalsh(inertia).min() < -1e-12 * abs(inertia).max():
        raise GeometryError(message(where, "has a negative principal moment", "needs a positive semi-definite array"))
    return inertia


def box_compression_strength(
    edge_crush: float, caliper: float, perimeter: float, *, humidity: float = 0.5, days: float = 0.0
) -> float:
    """Return the force [N] on its top that crushes a regular slotted carton; a ``top_load`` is less by a safety factor.

    McKee's formula, 5.87 ECT √(h Z), takes the edge crush strength ECT of the board, ``edge_crush`` [N/m], its
    ``caliper`` h [m] and the ``perimeter`` Z [m] of the carton (McKee, Gander and Wachuta, Paperboard Packaging 48(8),
    1963). The strength is then multiplied by what the Fibre Box Handbook (Fibre Box Association) leaves of it at a
    relative ``humidity`` from 0 to 0.9 and after up to 180 ``days`` under load, each by the next worse entry of its
    table. Raises HoldfastError for numbers out of range.
    """
    where = "box_compression_strength"
    edge = checked_number(edge_crush, f"{where}: edge_crush", above=0)
    h, z = (
        checked_number(value, f"{where}: {name}", above=0, within=LENGTH)
        for name, value in (("caliper", caliper), ("perimeter", perimeter))
    )
    damp = checked_number(
        humidity, f"{where}: humidity", minimum=0, within=Range(0.0, HUMIDITY[0][-1], "of saturation")
    )
    stood = checked_number(days, f"{where}: days", minimum=0, within=Range(0.0, DAYS[0][-1], "days"))
    left = [table[1][int(np.searchsorted(table[0], at))] for table, at in ((HUMIDITY, damp), (DAYS, stood))]
    return float(MCKEE * edge * np.sqrt(h * z) * left[0] * left[1])
