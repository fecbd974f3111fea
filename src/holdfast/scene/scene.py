"""A scene: rigid bodies, friction between them, and gravity."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.archive import archived
from holdfast.base.arrays import Float, checked, frozen, unit
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.values import Value
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction


@archived
@dataclass(frozen=True, init=False, eq=False, repr=False)
class Scene(Value):
    """Rigid bodies, the friction between them, and gravity.

    ``bodies`` have unique names, and at least one of them is fixed. ``friction`` is a Friction table, or one
    coefficient for all pairs. ``gravity`` (3,) [m/s²] is in the world frame and not zero. Raises SceneError if one of
    these conditions is violated, or if the friction table uses an unknown name.
    """

    bodies: tuple[Body, ...]
    friction: Friction
    gravity: Float
    name: str

    def __init__(
        self,
        bodies: Iterable[Body],
        friction: Friction | float,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        name: str = "",
    ) -> None:
        set_ = object.__setattr__
        if not hasattr(bodies, "__iter__"):
            raise SceneError(message("scene: bodies", f"is {bodies!r:.40}", "needs a list of Body objects"))
        set_(self, "bodies", tuple(bodies))
        set_(self, "friction", friction if isinstance(friction, Friction) else Friction(default=friction))
        set_(self, "gravity", checked(gravity, (3,), "scene: gravity"))
        set_(self, "name", str(name))
        self._check()

    def _check(self) -> None:
        for body in self.bodies:
            if not isinstance(body, Body):
                raise SceneError(message("scene", f"bodies holds a {type(body).__name__}", "needs Body objects"))
        if not self.bodies:
            raise SceneError(message("scene", "has no bodies", "needs at least one fixed body"))
        names = [body.name for body in self.bodies]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise SceneError(message("scene", f"several bodies are named {twice[0]!r}", "names are unique"))
        if not any(body.fixed for body in self.bodies):
            problem = f"none of its {len(names)} bodies is fixed"
            raise SceneError(message("scene", problem, "mark what carries the others with fixed=True"))
        if not np.linalg.norm(self.gravity) > 0:
            remedy = "contacts carry nothing without it: give a vector such as (0, 0, -9.81) m/s²"
            raise SceneError(message("scene", "gravity is zero", remedy))
        self.friction.check_names(names, {m for m in self.materials.values() if m is not None})

    @cached_property
    def materials(self) -> Mapping[str, str | None]:
        """The material of each body by its name, or None."""
        return MappingProxyType({body.name: body.material for body in self.bodies})

    @cached_property
    def names(self) -> frozenset[str]:
        """The names of all bodies and materials."""
        return frozenset(self.materials) | {name for name in self.materials.values() if name is not None}

    @cached_property
    def up(self) -> Float:
        """The unit vector (3,) opposite to gravity, world frame."""
        return frozen(unit(-self.gravity))

    @property
    def movable(self) -> tuple[Body, ...]:
        """The bodies that are not fixed, in scene order."""
        return tuple(body for body in self.bodies if not body.fixed)

    def body(self, name: str) -> Body:
        """Return the body with this name; raises SceneError, with the most similar name, if there is none."""
        for body in self.bodies:
            if body.name == name:
                return body
        remedy = nearest_of(name, [body.name for body in self.bodies])
        raise SceneError(message("scene", f"has no body named {name!r}", remedy))

    def moved(self, poses: Mapping[str, ArrayLike]) -> Scene:
        """Return the scene with some bodies at other poses.

        ``poses`` maps names of bodies to poses (4, 4), body frame to world. Raises SceneError for an unknown name.
        """
        if not hasattr(poses, "items"):
            remedy = 'needs a dict such as {"cup": pose}'
            raise SceneError(message("scene: moved", f"got a {type(poses).__name__}", remedy))
        for name in poses:
            self.body(name)
        return replace(
            self, bodies=tuple(body.moved(poses[body.name]) if body.name in poses else body for body in self.bodies)
        )

    def with_body(self, body: Body) -> Scene:
        """Return the scene with ``body`` added after the others."""
        return replace(self, bodies=(*self.bodies, body))

    def without(self, *names: str | Iterable[str]) -> Scene:
        """Return the scene without the bodies of these names.

        Entries of the friction table that name a removed body, or a material that no other body has, are dropped.
        Raises SceneError for an unknown name.
        """
        gone = self.checked_names(*names)
        left = tuple(body for body in self.bodies if body.name not in gone)
        known = {body.name for body in left} | {body.material for body in left if body.material is not None}
        return replace(self, bodies=left, friction=self.friction.among(known))

    def checked_names(self, *names: str | Iterable[str]) -> frozenset[str]:
        """Return all names as one set; they can be given one by one or in lists.

        Raises SceneError for an unknown name.
        """
        single = [[name] if isinstance(name, str) else name for name in names]
        return frozenset(self.body(name).name for several in single for name in several)

    def mu(self, a: str, b: str) -> float:
        """Return the static friction coefficient between two bodies; raises SceneError if the table has none."""
        return self.friction.between(a, b, self.materials)
