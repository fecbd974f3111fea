"""Where bodies may be moved: on what they stand on, within limits, nearer neither to edges nor to other bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.applications.placement import margins
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked_number, checked_truth
from holdfast.base.errors import SceneError, message
from holdfast.base.ranges import BETWEEN, LENGTH
from holdfast.base.rigid import tangents
from holdfast.base.text import quoted
from holdfast.base.values import Value
from holdfast.queries.request import quiet
from holdfast.scene.halfspace import HalfSpace

WAYS = margins.AROUND + 2  # of one body: slides, and turns both ways
SLIDES = np.argsort(np.arange(margins.AROUND) % 2, kind="stable")  # those along the axes first: they change least
EVEN = 1e-6  # [m] a distance that is shorter by less is the same: outlines are rounded


@dataclass(frozen=True, eq=False, repr=False)
class Moves(Value):
    """How far bodies may be moved.

    - ``slide`` [m]: how far each may slide in the plane that it stands on.
    - ``turn_degrees`` [deg]: how far each may be turned about the normal of that plane.
    - ``apart`` [m]: the distance to keep from bodies that it does not touch, where it is not smaller already.
    - ``nearer_edges``: whether it may come nearer to the edges of what it stands on.

    Raises SceneError for a value that is invalid.
    """

    slide: float = 0.1
    turn_degrees: float = 180.0
    apart: float = 0.005
    nearer_edges: bool = False

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name, within in (("slide", LENGTH), ("turn_degrees", BETWEEN), ("apart", LENGTH)):
            set_(self, name, checked_number(getattr(self, name), f"Moves: {name}", minimum=0, within=within))
        set_(self, "nearer_edges", checked_truth(self.nearer_edges, "Moves: nearer_edges"))


@dataclass(frozen=True, eq=False)
class Surroundings:
    """How one body stands: on which ``carriers``, what it has ``touched``, and its distances [m]."""

    carriers: frozenset[str]
    touched: frozenset[str]
    edge: float
    clearance: float


@dataclass(frozen=True, eq=False)
class Freedom:
    """The places that ``bodies`` may be moved to from where they are in the ``assembly``, each with what it carries."""

    assembly: Assembly
    bodies: tuple[str, ...]
    moves: Moves

    @cached_property
    def loads(self) -> Mapping[str, tuple[str, ...]]:
        """Each body with all bodies that rest on it, which move along."""
        movable = [body.name for body in self.assembly.movable]
        on = {name: margins.rests_on(self.assembly, name, touching=False) for name in movable}
        return {name: (name, *(other for other in movable if name in on[other])) for name in self.bodies}

    @cached_property
    def movers(self) -> tuple[str, ...]:
        """The bodies that may move: those asked for, and what they carry."""
        moved = {other for load in self.loads.values() for other in load}
        return tuple(body.name for body in self.assembly.movable if body.name in moved)

    @cached_property
    def watched(self) -> tuple[str, ...]:
        """The movable bodies that are moved, and those that they touch or on which they rest."""
        near = {other for name in self.movers for other in margins.rests_on(self.assembly, name)}
        return tuple(body.name for body in self.assembly.movable if body.name in {*self.movers, *near})

    @cached_property
    def normals(self) -> Mapping[str, Float]:
        """The unit normal (3,) of the plane on which each body stands."""
        found = {}
        for name in self.bodies:
            normal = margins.support_normal(self.assembly, name)
            if normal is None:
                raise SceneError(message(f"firmer: {quoted(name)}", "stands on nothing", "move a body that stands"))
            found[name] = normal
        return found

    @cached_property
    def at_first(self) -> Mapping[str, Surroundings]:
        """How each body, and what it carries, stands before it is moved."""
        return {name: self._standing(self.assembly, name) for load in self.loads.values() for name in load}

    @cached_property
    def longest(self) -> float:
        """The longest way [m] that any point of a body may go."""
        turn = float(np.radians(min(self.moves.turn_degrees, 180.0)))
        radii = [float(self.assembly.scene.body(name).size) / 2 for name in self.bodies]
        return max(self.moves.slide, turn * max(radii))

    def stepped(self, assembly: Assembly, way: int, step: float) -> Assembly | None:
        """Return the assembly with one body moved by ``step`` [m] along one of its ways, or None if it may not be."""
        name, own = self.bodies[way // WAYS], way % WAYS
        if own < margins.AROUND:
            slide = step * margins.around(np.array(tangents(self.normals[name])))[SLIDES[own]]
            return self.placed(assembly, name, slide, 0.0)
        angle = step / (assembly.scene.body(name).size / 2) * (1 if own == margins.AROUND else -1)
        return self.placed(assembly, name, np.zeros(3), angle)

    def placed(self, assembly: Assembly, name: str, slide: Float, angle: float) -> Assembly | None:
        """Return the assembly with a body moved by ``slide`` (3,) [m] and ``angle`` [rad], or None if it may not be."""
        body, first = assembly.scene.body(name), self.assembly.scene.body(name)
        motion = np.eye(4)
        motion[:3, :3] = Rotation.from_rotvec(angle * self.normals[name]).as_matrix()
        motion[:3, 3] = body.com_world - motion[:3, :3] @ body.com_world + slide
        new = {other: motion @ assembly.scene.body(other).pose for other in self.loads[name]}
        turned = Rotation.from_matrix(new[name][:3, :3] @ first.pose[:3, :3].T).magnitude()
        away = float(np.linalg.norm(body.com_world + slide - first.com_world))
        if away > self.moves.slide + EVEN or np.degrees(turned) > self.moves.turn_degrees + EVEN:
            return None
        with quiet():
            moved = assembly.moved(new)
        return moved if self._allowed(moved, name) else None

    def _allowed(self, assembly: Assembly, name: str) -> bool:
        before = {frozenset(overlap.bodies) for overlap in self.assembly.overlaps}
        if any(frozenset(overlap.bodies) not in before for overlap in assembly.overlaps):
            return False
        for one in self.loads[name]:
            first, now = self.at_first[one], self._standing(assembly, one)
            kept = first.touched - self._fixed  # what is let go may lean there
            if now.carriers != first.carriers or not kept <= now.touched <= first.touched:
                return False
            if now.clearance < first.clearance - EVEN:
                return False
            if now.edge < first.edge - EVEN and not self.moves.nearer_edges:
                return False
        return True

    @cached_property
    def _fixed(self) -> frozenset[str]:
        return frozenset(body.name for body in self.assembly.bodies if body.fixed)

    @cached_property
    def _apart(self) -> Mapping[str, list[str]]:
        """For each body that is moved, the bodies that it neither carries nor touches at first."""
        found = {}
        for load in self.loads.values():
            for name in load:
                near = {other for own in margins.contacts_of(name, self.assembly.interfaces) for other in own.bodies}
                found[name] = [body.name for body in self.assembly.bodies if body.name not in {*near, *load}]
        return found

    def _standing(self, assembly: Assembly, name: str) -> Surroundings:
        scene = assembly.scene
        placed, own = scene.body(name), margins.contacts_of(name, assembly.interfaces)
        carriers = margins.supporting_bodies(name, own, scene.up)
        beneath = [scene.body(other) for other in carriers]
        bounded = not any(isinstance(body.shape, HalfSpace) for body in beneath)
        return Surroundings(
            carriers=frozenset(carriers),
            touched=frozenset(other for interface in own for other in interface.bodies if other != name),
            edge=margins.edge_margin(placed, beneath, own, scene.up) if bounded else np.inf,
            clearance=margins.clearance(placed, [scene.body(other) for other in self._apart[name]], self.moves.apart),
        )
