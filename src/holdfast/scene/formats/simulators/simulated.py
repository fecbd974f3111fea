"""Scenes from links, joints and colliders: what every simulator has, whatever it calls them; shapes are cached."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias, TypeVar

import manifold3d
import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Bool, Float, checked_whole
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.ranges import MANY
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound, Inertial, Part, Shape, together
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats.links import (
    SAME_FRAME,
    BodyParts,
    BodyPiece,
    Welded,
    kept_apart,
    unique,
    weighed_body,
    weld,
)
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.shapes import Mesh

S = TypeVar("S")
MOST_CACHED = 4096  # number of shapes that are kept
UNSCALED = np.ones(3)
Touching: TypeAlias = Callable[[Sequence[int], Sequence[int]], Bool]  # which colliders may touch, by their marks


def hull(vertices: Float) -> Mesh:
    """Return the convex hull of ``vertices`` (n, 3) [m], which simulators collide in place of a mesh.

    Raises GeometryError if they span no volume.
    """
    return cached_shape(_hull, np.ascontiguousarray(vertices, dtype=np.float64).tobytes())


def _hull(vertices: bytes) -> Mesh:
    points = np.frombuffer(vertices).reshape(-1, 3)
    mesh = manifold3d.Manifold.hull_points(points).to_mesh64()
    if not len(mesh.tri_verts):
        raise GeometryError(message("mesh", "its convex hull is flat", "needs corners that are not in one plane"))
    return Mesh(np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64), label="mesh")


def mesh_as_given(vertices: Float, faces: ArrayLike, scale: Float = UNSCALED) -> Mesh:
    """Return the mesh with ``vertices`` (n, 3) and ``faces`` (m, 3) as it is, for simulators that collide it so.

    ``scale`` (3,) [m] stretches it along its axes; one that mirrors it turns its faces, too.
    """
    triangles = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
    triangles = triangles if scale.prod() > 0 else triangles[:, ::-1]
    corners = np.ascontiguousarray(vertices * scale, dtype=np.float64)
    return cached_shape(_mesh_as_given, corners.tobytes(), np.ascontiguousarray(triangles).tobytes())


def _mesh_as_given(vertices: bytes, faces: bytes) -> Mesh:
    corners, triangles = np.frombuffer(vertices).reshape(-1, 3), np.frombuffer(faces, dtype=np.int64).reshape(-1, 3)
    return Mesh(corners, triangles, label="mesh")


def cached_shape(kind: Callable[..., S], *sizes: Any) -> S:  # noqa: ANN401 - what the class of shapes takes
    """Return a shape of this ``kind``, the same one for the same sizes.

    So its surface, or its union, is computed once for all states of a simulation.
    """
    shape: S = _cached_shape(kind, sizes)
    return shape


@lru_cache(MOST_CACHED)
def _cached_shape(kind: Callable[..., Any], sizes: tuple[Any, ...]) -> Any:  # noqa: ANN401
    return kind(*sizes)


class JointState(Enum):
    """What a joint allows: no motion, none while its motor is on, or motion."""

    RIGID = "rigid"
    HELD = "held"
    LOOSE = "loose"


@dataclass(eq=False)
class Link:
    """A body of a simulator at ``pose`` (4, 4), link frame to world.

    ``inertial`` is in the frame of the link; None means no mass. A ``fixed`` link never moves.
    """

    name: str
    pose: Float
    fixed: bool
    inertial: Inertial | None = None
    colliders: list[BodyPiece] = field(default_factory=list)


class SimulatedJoint(NamedTuple):
    """A joint between two links, by their numbers; None is the world."""

    name: str
    ends: tuple[int | None, int | None]
    hold: JointState


class LinkedBody(NamedTuple):
    """One body of the scene: its links, which move as one, and those of their colliders that are its own."""

    name: str
    fixed: bool
    links: Sequence[Link]
    colliders: Sequence[BodyPiece]


def bodies_of(
    links: Sequence[Link], joints: Sequence[SimulatedJoint], *, rigid: bool, touching: Touching | None = None
) -> tuple[list[Body], list[Excluded], list[str]]:
    """Return the bodies of a scene, which of them may not touch, and notes.

    Links that rigid joints join move as one body. Links that hang on fixed ones by joints with motors are fixed where
    they are. Any other joint of a link that moves raises SceneError with its name, unless ``rigid`` is True: then it is
    rigid, too. Without ``touching`` all colliders may touch.
    """
    welded, notes = _welded(links, joints, rigid=rigid)
    found: list[LinkedBody] = []
    empty = []
    for whole in welded:
        members = [links[k] for k in whole.members]
        if whole.fixed:
            for link in members:  # one body for each plane, which has no end, and one for all else
                planes = [each for each in link.colliders if isinstance(each.shape, HalfSpace)]
                others = [each for each in link.colliders if not isinstance(each.shape, HalfSpace)]
                parts = [*([plane] for plane in planes), others]
                found += [LinkedBody(link.name, True, [link], each) for each in parts if each]
        elif colliders := [each for link in members for each in _colliders_in(link, members[0].pose)]:
            found.append(LinkedBody(members[0].name, False, members, colliders))
        else:
            empty.append(members[0].name)
    if empty:
        notes.append(f"left out, as nothing of theirs collides: {listed(empty)}")
    names = unique(group.name for group in found)
    bodies = [_body(group, name) for group, name in zip(found, names, strict=True)]
    if touching is None:
        return bodies, [], notes
    marked = [BodyParts(body, [each.mark for each in g.colliders]) for g, body in zip(found, bodies, strict=True)]
    return bodies, kept_apart(itertools.combinations(marked, 2), touching), notes


def _welded(
    links: Sequence[Link], joints: Sequence[SimulatedJoint], *, rigid: bool
) -> tuple[list[Welded[int]], list[str]]:
    """Return the links, by their numbers, that move as one, in the order of the simulator, and notes."""
    group = {k: Welded([k], link.fixed) for k, link in enumerate(links)}

    def ends(joint: SimulatedJoint) -> list[Welded[int] | None]:
        return [None if end is None else group[end] for end in joint.ends]

    def join(joint: SimulatedJoint) -> None:
        weld(group, ends(joint), lambda k: k)

    for joint in joints:
        if joint.hold is JointState.RIGID:
            join(joint)
    held = [joint for joint in joints if joint.hold is JointState.HELD]
    hung: list[str] = []
    count = -1
    while len(hung) > count:  # a link that is held holds what hangs on it
        count = len(hung)
        for joint in held:
            both = ends(joint)
            if any(each is None or each.fixed for each in both):
                for each in both:
                    if each is not None and not each.fixed:
                        each.fixed = True
                        hung += [links[k].name for k in each.members]
    loose = [joint for joint in joints if joint.hold is not JointState.RIGID and _moves(ends(joint))]
    faults = [
        f"{quoted(joint.name)} of {' and '.join(quoted(links[k].name) for k in joint.ends if k is not None)}"
        for joint in loose
    ]
    if faults and not rigid:
        remedy = "say rigid=True to take what they join as one rigid body as it is now, or fix it in the simulation"
        raise SceneError(message("joints that can move", listed(faults), remedy))
    for joint in loose:
        join(joint)
    notes = [f"taken as rigid as it is now: {listed(faults)}"] if faults else []
    if hung:
        notes.append(f"held fixed at their joint positions: {listed(hung)}")
    return list({id(each): each for each in group.values()}.values()), notes


def _moves(ends: Sequence[Welded[int] | None]) -> bool:
    """Tell whether a joint joins two groups that may move against each other."""
    first, second = ends
    return first is not second and any(each is not None and not each.fixed for each in ends)


def _colliders_in(link: Link, home: Float) -> list[BodyPiece]:
    """Return the colliders of a link in the frame ``home`` (4, 4)."""
    if link.pose is home:
        return link.colliders
    return [each._replace(pose=relative(link.pose @ each.pose, home)) for each in link.colliders]


def _body(group: LinkedBody, name: str) -> Body:
    with located(f"body {quoted(name)}"):
        if group.fixed:
            return body_of(name, group.links[0].pose, group.colliders)
        home = group.links[0].pose
        each = [
            link.inertial if link.pose is home else link.inertial.seen(relative(link.pose, home))
            for link in group.links
            if link.inertial is not None
        ]
        if not each:
            raise SceneError(message("mass", "is missing", "give it one in the simulation, or make it static"))
        return body_of(name, home, group.colliders, together(each))


def body_of(name: str, pose: Float, colliders: Sequence[BodyPiece], inertial: Inertial | None = None) -> Body:
    """Return a body of one or more colliders at ``pose`` (4, 4), body frame to world; without inertia it is fixed.

    A plane must be the only collider, and its body has the frame of the plane.
    """
    materials = [each.material for each in colliders]
    usual = max(dict.fromkeys(materials), key=materials.count)
    first = colliders[0]
    if isinstance(first.shape, HalfSpace):
        return Body(name, first.shape, pose=pose @ first.pose, material=usual, fixed=True)
    shape: Shape = first.shape
    if len(colliders) > 1 or np.abs(first.pose - np.eye(4)).max() > SAME_FRAME:
        shape = cached_shape(
            Compound,
            tuple(Part(each.shape, each.pose, None if each.material == usual else each.material) for each in colliders),
        )
    return weighed_body(name, shape, inertial, pose=pose, material=usual, fixed=inertial is None)


def world_of(world: int | None, count: int, what: str) -> int:
    """Return the number of the world to read, of ``count`` in ``what``, which has to be said if there are several."""
    if world is None and count > 1:
        raise SceneError(message("world", f"the {what} has {count}", f"say which: world=0 to {count - 1}"))
    return 0 if world is None else checked_whole(world, "world", 0, min(max(count, 1), MANY) - 1)


def relative(pose: Float, home: Float) -> Float:
    """Return a pose (4, 4) in the world relative to the frame ``home`` (4, 4)."""
    back = np.eye(4)
    back[:3, :3], back[:3, 3] = home[:3, :3].T, -home[:3, :3].T @ home[:3, 3]
    return np.asarray(back @ pose)
