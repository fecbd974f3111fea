"""Decide whether an object may be placed in a pose: first by geometry, then by whether everything stands.

Geometry includes a straight way in for the object and its gripper, and the way back for the gripper.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import manifold3d
import numpy as np

from holdfast.applications.placement.conditions import (
    Approach,
    Search,
    Where,
    allowed_turns,
    names_of,
    region_of,
    regions_to_keep_out_of,
)
from holdfast.applications.placement.margins import around, clearance, edge_margin, supporting_bodies, way_back
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, unit
from holdfast.base.errors import SceneError, message
from holdfast.base.progress import keep_to_time
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import tangents, transform
from holdfast.base.text import listed
from holdfast.contacts.contact_search import find_contacts
from holdfast.contacts.interface import Interface
from holdfast.contacts.overlap import find_overlaps, solid_of
from holdfast.engines.bearing import bearings
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.engines.imperfect import Imperfect
from holdfast.engines.verdict import Status
from holdfast.geometry.solid import hull_solid
from holdfast.geometry.surface import Surface
from holdfast.geometry.sweep import Swept, first_hit, hit_distance
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box

TURNS = 4  # number of headings of a gripper that are tried, a quarter turn apart
OVERLAPS, FALLS, OUTSIDE = "overlaps the scene", "slides or falls off", "outside the region"
TURNED, UNSUPPORTED, SHUT_IN = "not in an allowed orientation", "not on enough of the supports", "no way in"
FORBIDDEN, KEPT_OUT = "touches what it must not", "reaches into a region to keep out of"
HANGS, BALANCED = "juts out over an edge", "is only balanced"
AWAY, GRIPPED = "not next to what it should be next to", "no room for the gripper"
CRUSHED = "crushes a body"
FALLEN, UNSURE, REFUSED = "does not stand with it", "undecided with it", "refused by the second engine"
MARGINAL = "would not stand if it were heavier by the margin"
STAGES = (
    *(FALLS, OVERLAPS, OUTSIDE, TURNED, KEPT_OUT, AWAY, UNSUPPORTED, HANGS, FORBIDDEN, SHUT_IN, GRIPPED),
    *(UNSURE, FALLEN, BALANCED, CRUSHED, REFUSED, MARGINAL),
)  # in the order of the checks: an attempt with a later fault passed more of them
BESIDE = 0.5  # largest distance between bodies next to each other, as a share of the object's size


@dataclass(frozen=True, eq=False)
class Checks:
    """The checks of poses of one object in one scene, for what is asked of them.

    ``confirm`` is a second engine that must also find every pose stable, or None. ``friction`` is the table of the
    scene with the object. Raises SceneError for what the scene makes invalid.
    """

    assembly: Assembly
    body: Body
    engine: Engine
    confirm: Engine | None
    where: Where
    approach: Approach
    search: Search
    friction: Friction
    imperfect: Imperfect | None = None

    def __post_init__(self) -> None:
        _ = self.region, self.supports, self.avoid, self.turns, self.closed
        if self.where.next_to is not None:
            self.assembly.scene.body(self.where.next_to)
        if self.where.least_supports > len(self.supports):
            problem = f"least_supports is {self.where.least_supports}, supports are {listed(self.supports)}"
            raise SceneError(message("Where", problem, "ask for no more than there are"))

    @cached_property
    def region(self) -> Float:
        """The low and the high corner (2, 3) [m] of where the object may be placed."""
        return region_of(self.where.box, self.up, "Where: box")

    @cached_property
    def supports(self) -> tuple[str, ...]:
        """The names of the bodies to place the object on."""
        return names_of(self.assembly, self.where.supports, "supports")

    @cached_property
    def avoid(self) -> tuple[str, ...]:
        """The names of the bodies that it may not touch."""
        return names_of(self.assembly, self.where.avoid, "avoid")

    @cached_property
    def turns(self) -> Float | None:
        """The allowed rotations (k, 3, 3), or None if every rotation is allowed."""
        return allowed_turns(self.approach, self.up)

    @cached_property
    def closed(self) -> list[Float]:
        """The low and the high corners (2, 3) [m] of the regions to keep out of."""
        return regions_to_keep_out_of(self.where, self.up)

    @cached_property
    def frozen(self) -> tuple[Body, ...]:
        """The bodies of the scene, all made fixed, because contacts are only searched between them and the object."""
        return tuple(
            body if body.fixed else Body(body.name, body.shape, pose=body.pose, material=body.material, fixed=True)
            for body in self.assembly.bodies
        )

    @property
    def up(self) -> Float:
        """The unit vector (3,) opposite to gravity, world frame."""
        return self.assembly.scene.up

    @cached_property
    def _solids(self) -> list[tuple[Body, manifold3d.Manifold]]:
        """The closed bodies of the scene as solids; ``fits`` checks overlaps with open ones too."""
        solids = [(body, solid_of(body)) for body in self.frozen]
        return [(body, solid) for body, solid in solids if solid is not None]

    @cached_property
    def _solid(self) -> manifold3d.Manifold | None:
        """The object as a solid in its own frame, or None if its surface is not closed."""
        return solid_of(self.body.moved(np.eye(4)))

    def free(self, pose: Float) -> bool:
        """Return whether the object at ``pose`` (4, 4) overlaps no closed body of the scene."""
        if self._solid is None:
            return True
        vertices = transform(pose, self.body.shape.surface.vertices)
        low, high = vertices.min(0), vertices.max(0)
        least = COORDINATES * float(self._solid.volume())
        moved = None
        for body, solid in self._solids:
            if (body.box[0] < high).all() and (body.box[1] > low).all():
                moved = self._solid.transform(pose[:3]) if moved is None else moved
                if (moved ^ solid).volume() > least:
                    return False
        return True

    def fits(self, pose: Float) -> tuple[str, Body, tuple[Interface, ...]]:
        """Return the fault of a pose by geometry alone ("" if it has none), the object in it, and its interfaces.

        Interfaces are returned only without a fault, or for HANGS.
        """
        keep_to_time()
        placed = self.body.moved(pose)
        fault = self.misplaced(placed)
        if fault:
            return fault, placed, ()
        if self.where.next_to is not None:  # near it, with overlapping ranges of height
            other, near = self.assembly.scene.body(self.where.next_to), BESIDE * placed.size
            ours, theirs = placed.surface_world.vertices @ self.up, other.surface_world.vertices @ self.up
            level = min(ours.max(), theirs.max()) - max(ours.min(), theirs.min())
            if level <= COORDINATES * placed.size or clearance(placed, [other], 2 * near) > near:
                return AWAY, placed, ()
        beside = Scene([*self.frozen, placed], self.friction, self.assembly.scene.gravity)
        if find_overlaps(beside, self.assembly.tolerances, drawn=True):  # the pose is chosen, not measured
            return OVERLAPS, placed, ()
        contacts = find_contacts(beside, self.assembly.tolerances).interfaces
        touched = {name for interface in contacts for name in interface.bodies}
        carriers = supporting_bodies(placed.name, contacts, self.up)
        wanted = bool(carriers) and carriers <= set(self.supports)
        if not wanted or len(touched.intersection(self.supports)) < self.where.least_supports:
            return UNSUPPORTED, placed, ()
        if way_back(placed, self.frozen, contacts, self.up) is not None:
            return HANGS, placed, contacts
        if touched.intersection(self.avoid):
            return FORBIDDEN, placed, ()
        if self.approach.direction is not None and not any(self._open(placed, way) for way in self._ways):
            return SHUT_IN, placed, ()
        if not self._gripper_fits(placed):
            return GRIPPED, placed, ()
        return "", placed, contacts

    def misplaced(self, placed: Body) -> str:
        """Return the fault of a pose with a wrong position or orientation ("" if it has none), without the scene."""
        com, region = placed.com_world, self.region
        level = np.abs(self.up) < 1 - 1e-9  # the box does not limit the height of the centre of mass
        if not ((com >= region[0]) & (com <= region[1]))[level].all():
            return OUTSIDE
        if not self._allowed(placed.pose):
            return TURNED
        return KEPT_OUT if self._kept_out(placed) else ""

    def fault(self, pose: Float) -> tuple[str, Assembly | None]:
        """Return the fault of a pose ("" if it has none), and the assembly with the object there, or None."""
        fault, placed, contacts = self.fits(pose)
        return (fault, None) if fault else self.judged(self.with_object(placed, contacts))

    def nudged(self, pose: Float) -> tuple[str, Float, Assembly | None]:
        """Return what ``fault`` does, and the pose, shifted inwards if the object would overhang an edge."""
        fault, placed, contacts = self.fits(pose)
        back = way_back(placed, self.frozen, contacts, self.up) if fault == HANGS else None
        if back is not None:
            pose = np.array(pose)
            pose[:3, 3] += back
            fault, placed, contacts = self.fits(pose)
        if fault:
            return fault, pose, None
        fault, after = self.judged(self.with_object(placed, contacts))
        return fault, pose, after

    def with_object(self, placed: Body, contacts: Sequence[Interface]) -> Assembly:
        """Return the assembly with the object added, with its interfaces ``contacts``."""
        scene = self.assembly.scene
        after = Scene([*scene.bodies, placed], self.friction, scene.gravity, scene.name, scene.excluded)
        whole = replace(self.assembly, scene=after, interfaces=(*self.assembly.interfaces, *contacts))
        return self.assembly.heir(whole)

    def judged(self, after: Assembly) -> tuple[str, Assembly | None]:
        """Return the fault of an assembly with the object in place, and the assembly, or None if something may fall."""
        keep_to_time()
        state = prepared(self.engine, after)
        verdict = state.verdict()
        if verdict.status is not Status.STABLE:
            return FALLEN if verdict.status is Status.UNSTABLE else UNSURE, None
        if self.body.name in verdict.balanced:
            return BALANCED, None
        if any(one.crushed for one in bearings(after, state.verdicts)):
            return CRUSHED, None
        if self.confirm is not None and prepared(self.confirm, after).verdict().status is not Status.STABLE:
            return REFUSED, None
        margin = self.search.mass_margin
        if margin > 0:
            assert self.body.mass is not None
            more = np.zeros((len(after.movable), 6))
            more[after.index[self.body.name], :3] = margin * self.body.mass * after.scene.gravity
            heavier = prepared(self.confirm or self.engine, after, more.reshape(-1))
            if heavier.verdict().status is not Status.STABLE:
                return MARGINAL, None
        return "", after

    def room(self, placed: Body, interfaces: Sequence[Interface], beneath: Collection[str]) -> tuple[float, float]:
        """Return the distances [m] of the object from the edges of the bodies ``beneath`` it, and from other bodies.

        ``interfaces`` are those of the object. Bodies that touch it from the side count among the others, at distance
        0. The body of the option ``next_to`` does not count.
        """
        under = [body for body in self.frozen if body.name in beneath]
        beside = {name for interface in interfaces for name in interface.bodies} - {placed.name}
        beside -= supporting_bodies(placed.name, interfaces, self.up)
        apart = (set(beneath) - beside) | {self.where.next_to}
        others = [body for body in self.frozen if body.name not in apart]
        return edge_margin(placed, under, interfaces, self.up), clearance(placed, others, placed.size)

    def _allowed(self, pose: Float) -> bool:
        if self.turns is None:
            return True
        turn = pose[:3, :3]
        if self.approach.free_yaw:  # compare which direction of the body points up
            cosine = (np.swapaxes(self.turns, 1, 2) @ self.up) @ (turn.T @ self.up)
        else:
            cosine = (np.einsum("kij,ij->k", self.turns, turn) - 1) / 2
        return bool(cosine.max() >= np.cos(np.radians(self.approach.lean_degrees)) - 1e-12)

    def _kept_out(self, placed: Body) -> bool:
        """Return whether the object's convex hull overlaps a region of ``keep_out``."""
        low, high = placed.box
        near = [box for box in self.closed if (box[0] < high).all() and (box[1] > low).all()]
        if not near:
            return False
        solid = hull_solid(placed.surface_world.vertices)
        for box in near:
            inner = np.clip(box, low - placed.size, high + placed.size)  # a region may extend to infinity
            corners = np.array(
                [[inner[i, 0], inner[j, 1], inner[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
            )
            if (solid ^ hull_solid(corners)).volume() > COORDINATES * solid.volume():
                return True
        return False

    @cached_property
    def _ways(self) -> tuple[Float, ...]:
        """The unit directions (3,) of straight ways in that are tried, the axis of the cone first."""
        way, cone = self.approach.direction, float(np.radians(self.approach.cone_degrees))
        axis = -self.up if way is None else np.asarray(way)
        if cone == 0:
            return (axis,)
        ring = around(np.array(tangents(axis)))
        rings = [np.cos(lean) * axis + np.sin(lean) * ring for lean in (cone / 2, cone)]
        return (axis, *unit(np.vstack(rings)))

    def _gripper_fits(self, placed: Body) -> bool:
        """Return whether there is a straight way in that is free for both the object and the gripper's box."""
        if self.approach.gripper is None:
            return True
        ways = [way for way in self._ways if self.approach.direction is None or self._open(placed, way)]
        boxes = self._gripper_boxes(placed, *np.asarray(self.approach.gripper))
        return any(self._room_for(box, way) for way in ways for box in boxes)

    def _open(self, placed: Body, way: Float) -> bool:
        """Return whether the object hits nothing on its straight way out, the reverse of the way in."""
        going, depths = Swept(placed.reduced_world, -way), self.assembly.tolerances
        hits = (
            hit_distance(going, Swept(body.reduced_world, -way), depths.between(body, placed).depth)
            for body in self.frozen
        )
        return not any(map(np.isfinite, hits))

    def _gripper_boxes(self, placed: Body, low: Float, high: Float) -> list[Surface]:
        """Return the gripper's box at the end of the way in, once for each heading.

        Its corners ``low`` and ``high`` (3,) [m] are relative to the middle of the object's top: the third coordinate
        is along ``up``, and the first along the first of the object's axes that is roughly level.
        """
        vertices = placed.surface_world.vertices
        level = placed.pose[:3, :3].T - np.outer(placed.pose[:3, :3].T @ self.up, self.up)
        first = unit(level[int(np.argmax(np.linalg.norm(level, axis=1) > 0.5))])
        axes = np.array([first, np.cross(self.up, first), self.up])
        seen = vertices @ axes.T
        middle = np.array([*(seen.min(0) + seen.max(0))[:2] / 2, seen[:, 2].max()]) @ axes
        box = Box(high - low).surface
        local = box.vertices + (low + high) / 2
        angles = 2 * np.pi * np.arange(TURNS) / TURNS
        turns = [np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]]) for a in angles]
        return [Surface(middle + local @ turn @ axes, box.faces) for turn in turns]

    def _room_for(self, box: Surface, way: Float) -> bool:
        """Return whether a box that moves along ``way`` (3,) from outside the scene hits no body on the way."""
        ahead = box.vertices @ way
        for body in self.frozen:
            theirs = body.reduced_world.vertices @ way
            back = max(float(ahead.max() - theirs.min()), 0.0) + float(np.ptp(ahead))
            start = Surface(box.vertices - back * way, box.faces)
            tolerance = self.assembly.tolerances.of(body)
            if first_hit(start, body.reduced_world, way, tolerance) < back - tolerance:
                return False
        return True
