"""Common parts of robot formats: rigid bodies assembled from shapes and masses with poses, and the floor below them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Bool, Float, checked_items, checked_number, checked_truth, unit
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.ranges import DENSITY, FRICTION, LENGTH
from holdfast.base.rigid import checked_pose, rpy_pose, tangents, transform
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound, Inertial, Part, Shape, Solid, together
from holdfast.scene.excluded import Excluded, excluded_by
from holdfast.scene.friction import Friction
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene, with_notes
from holdfast.scene.shapes import Mesh, Sphere
from holdfast.scene.xml import Element

SAME_FRAME = 1e-12  # [m, 1] up to which a shape is in the frame of its body: rounding of poses there and back
FLOOR = "floor"  # name of the body
LEVEL = 0.999  # cosine of the slope up to which a half space is a floor, and no ramp or wall: 2.6 degrees


class BodyPiece(NamedTuple):
    """A shape with its ``pose`` (4, 4) in the frame of its link or body, and the material of its surface.

    ``mark`` is whatever tells a reader what the piece may touch.
    """

    shape: Solid | HalfSpace
    pose: Float
    material: str | None = None
    mark: Any = None


class LinkContent(NamedTuple):
    """The pieces of a link in its frame, and its mass there; None if the link is fixed or its mass is not known."""

    pieces: list[BodyPiece]
    inertial: Inertial | None


class BodyParts(NamedTuple):
    """A body with the marks of the pieces that are its parts."""

    body: Body
    marks: Sequence[Any]


class Notes(list[str]):
    """Notes on what a reader assumed or left out; a note that holds for several links is written once."""

    def __init__(self) -> None:
        super().__init__()
        self._said: dict[str, tuple[int, list[str]]] = {}

    def of(self, link: str, text: str) -> None:
        """Add a note about a link."""
        place, links = self._said.setdefault(text, (len(self), []))
        if link in links:
            return
        links.append(link)
        if len(links) == 1:
            self.append("")
        self[place] = f"link{'s' if len(links) > 1 else ''} {listed(links)}: {text}"

    def unread(
        self, elements: Iterable[Element], known: Mapping[str, Collection[str]], attributes: Collection[str]
    ) -> None:
        """Add a note on the elements below these, and on attributes of elements, that the reader does not know.

        ``known`` maps each tag whose children are inspected to the tags that are read or irrelevant, and ``attributes``
        are the names of attributes that are.
        """
        found: Counter[str] = Counter()
        waiting, seen = list(elements), set[Element]()
        while waiting:
            element = waiting.pop()
            if element in seen:
                continue
            seen.add(element)
            for name in element.attributes:
                if name not in attributes and not name.startswith("xmlns"):
                    found[f"{name}= of <{element.tag}>"] += 1
            for child in element.children if element.tag in known else ():
                if child.tag in known[element.tag]:
                    waiting.append(child)
                else:
                    found[f"<{child.tag}> in <{element.tag}>"] += 1
        self += not_read(found)


NAMED = 12  # largest number of kinds of things in one note


def not_read(found: Mapping[str, int]) -> list[str]:
    """Return a note on things in a file that its reader does not know, each with its number; none if there are none."""
    each = [what + (f" ({count} times)" if count > 1 else "") for what, count in sorted(found.items())]
    return [f"not read, though it may matter: {listed(each, NAMED)}"] if each else []


def unknown_keys(data: Mapping[str, Any], known: Collection[str], what: str) -> Iterator[str]:
    """Yield the keys of a map that are not known and hold something, with ``what`` the map is of."""
    return (f"{key} of {what}" for key, value in data.items() if key not in known and value not in (None, [], {}))


def plane_frame(normal: Float) -> Float:
    """Return the frame (4, 4) of a plane through the origin, with its ``normal`` (3,), which is not zero, along z."""
    frame, up = np.eye(4), unit(normal)
    if not np.array_equal(up, (0, 0, 1)):
        frame[:3, :3] = np.column_stack([*tangents(up), up])
    return frame


def ball(radius: float, link: str, notes: Notes) -> Sphere:
    """Return a sphere; one that is smaller than allowed represents a point contact and gets the smallest radius."""
    if 0 <= radius < LENGTH.least:
        notes.of(link, f"spheres of radius {radius:g} m are taken as points ({LENGTH.least:g} m)")
        return Sphere(LENGTH.least)
    return Sphere(radius)


M = TypeVar("M")
K = TypeVar("K")


@dataclass(eq=False)
class Welded(Generic[M]):
    """Members that move as one body, in the order of the file; the body is fixed if one of them is."""

    members: list[M]
    fixed: bool


G = TypeVar("G", bound=Welded[Any])


def weld(group: dict[K, G], ends: Sequence[G | None], key: Callable[[Any], K]) -> None:
    """Merge the groups at the two ends of a joint; None is the world, and a group that is joined to it becomes fixed.

    ``group`` maps the ``key`` of each member to its group, and is updated.
    """
    found = [end for end in ends if end is not None]
    if len(found) < len(ends):
        for each in found:
            each.fixed = True
        return
    first, second = found
    if first is not second:
        first.members += second.members
        first.fixed = first.fixed or second.fixed
        for member in second.members:
            group[key(member)] = first


def filled(pieces: Sequence[BodyPiece], density: float) -> Inertial:
    """Return the inertial of pieces with the same ``density`` [kg/m³]; common volume counts once.

    Raises GeometryError if one of them encloses no volume.
    """
    shape = Compound([Part(piece.shape, piece.pose) for piece in pieces]) if len(pieces) > 1 else pieces[0].shape
    own = shape.mass_properties
    found = Inertial(density * own.volume, np.asarray(own.com), density * np.asarray(own.inertia))
    return found if len(pieces) > 1 else found.seen(pieces[0].pose)


def rigid_body(
    name: str, pieces: Sequence[BodyPiece], *, pose: Float, inertial: Inertial | None = None, fixed: bool = False
) -> Body:
    """Return a body of these pieces at ``pose`` (4, 4), body frame to world; a single mesh is moved in it."""
    materials = {piece.material for piece in pieces}
    material = materials.pop() if len(materials) == 1 else None
    return weighed_body(name, _shape(pieces), inertial, pose=pose, material=material, fixed=fixed)


def weighed_body(
    name: str, shape: Shape, inertial: Inertial | None, *, pose: Float, material: str | None, fixed: bool
) -> Body:
    """Return a body with a mass as it was summed: its inertia is made symmetric, which rounding may have spoiled."""
    if inertial is None:
        return Body(name, shape, pose=pose, material=material, fixed=fixed)
    inertia = (inertial.inertia + inertial.inertia.T) / 2
    return Body(name, shape, inertial.mass, None, pose, inertial.com, inertia, material, fixed)


def bodies_of_links(
    name: str, links: Sequence[tuple[Float, LinkContent]], *, pose: Float, fixed: bool
) -> Iterator[BodyParts]:
    """Yield the body of links that move as one, and before it a fixed one for each plane among their pieces.

    ``links`` are the pose (4, 4) of each link in the body and what is in it, and ``pose`` (4, 4) is that of the body in
    the world. Of a body that moves, the masses of its links are summed.
    """
    pieces = [piece._replace(pose=at @ piece.pose) for at, link in links for piece in link.pieces]
    planes = [piece for piece in pieces if isinstance(piece.shape, HalfSpace)]
    solids = [piece for piece in pieces if not isinstance(piece.shape, HalfSpace)]
    for number, plane in enumerate(planes):
        own = name if not solids and len(planes) == 1 else f"{name}::plane{number if number else ''}"
        body = Body(own, HalfSpace(), pose=pose @ plane.pose, material=plane.material, fixed=True)
        yield BodyParts(body, [plane.mark])
    if solids:
        each = [link.inertial.seen(at) for at, link in links if link.inertial is not None and link.inertial.mass]
        whole = None if fixed else together(each)
        yield BodyParts(
            rigid_body(name, solids, pose=pose, inertial=whole, fixed=fixed), [piece.mark for piece in solids]
        )


def kept_apart(
    pairs: Iterable[tuple[BodyParts, BodyParts]], touching: Callable[[Sequence[Any], Sequence[Any]], Bool]
) -> list[Excluded]:
    """Return the excluded pairs among these: of bodies, or of their parts if other parts of the same bodies may touch.

    ``touching`` tells for the marks of two bodies which parts may touch, as (len(a), len(b)) or the same for all.
    """
    found: list[Excluded] = []
    for (a, of_a), (b, of_b) in pairs:
        if not (a.fixed and b.fixed):
            may = touching(of_a, of_b)
            if not may.all():
                found += excluded_by(a.name, b.name, may)
    return found


def scene_of(
    bodies: Sequence[Body],
    friction: Friction | float,
    gravity: ArrayLike,
    name: str,
    notes: Sequence[str],
    excluded: Sequence[Excluded] = (),
) -> Scene:
    """Return the scene of a file with the notes of its reader, without repetitions."""
    return Scene(bodies, friction, gravity, name, excluded, dict.fromkeys(notes))


def _shape(pieces: Sequence[BodyPiece]) -> Shape:
    """Return the shape of a body, in the frame of the pieces."""
    first = pieces[0]
    if len(pieces) == 1:
        if np.abs(first.pose - np.eye(4)).max() <= SAME_FRAME:
            return first.shape
        if isinstance(first.shape, Mesh):
            mesh = first.shape
            return Mesh(transform(first.pose, mesh.vertices), mesh.faces, label=mesh.label)
    own = len({piece.material for piece in pieces}) > 1
    return Compound([Part(piece.shape, piece.pose, piece.material if own else None) for piece in pieces])


def pose_of(xyz: Sequence[float], rpy: Sequence[float]) -> Float:
    """Return the pose (4, 4) at ``xyz`` [m], turned by roll, pitch and yaw [rad] about the fixed x, y and z axes."""
    return rpy_pose(xyz, np.sin(rpy), np.cos(rpy))


def checked_fixed(fixed: Iterable[str], known: Collection[str], what: str = "body") -> frozenset[str]:
    """Check the option ``fixed`` of readers and return it as names.

    Raises SceneError unless ``fixed`` is a list of ``known`` names; ``what`` says in the message what has these names.
    """
    names = checked_items(fixed, "fixed", 'names, as ["table"]')
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise SceneError(message("fixed", f"no {what} is named {quoted(name)}", nearest_of(name, known)))
    return frozenset(names)


def checked_defaults(friction: float | None, density: float | None) -> tuple[float | None, float | None]:
    """Check the options ``friction`` and ``density`` [kg/m³] of readers, which stand for what a file leaves out."""
    dense = None if density is None else checked_number(density, "density", above=0, within=DENSITY)
    mu = None if friction is None else checked_number(friction, "friction", minimum=0, within=FRICTION)
    return mu, dense


def copies_of(name: str, pose: ArrayLike | None, poses: Mapping[str, ArrayLike] | None) -> list[tuple[str, Float]]:
    """Check the options ``pose`` and ``poses`` of readers; return the name and the pose (4, 4) of each copy.

    Without ``poses`` there is one copy, called ``name``. Raises SceneError if both are given, or are malformed.
    """
    if poses is None:
        return [(name, checked_pose(np.eye(4) if pose is None else pose, "pose"))]
    if pose is not None or not hasattr(poses, "items") or not len(poses):
        raise SceneError(message("poses", f"is {quoted(poses)}", 'needs a dict such as {"left": T}, and no pose='))
    return [(copy, checked_pose(at, f"poses: {quoted(copy)}")) for copy, at in poses.items()]


def with_floor(
    bodies: Sequence[Body], floor: bool, where: str, remedy: str, *, problem: str = "nothing in it is fixed"
) -> list[Body]:
    """Return the bodies of a file and, if ``floor``, the half space below z = 0, which never moves.

    Raises SceneError about ``where``, with the ``problem`` and its ``remedy``, if nothing is fixed, and if a body has
    the name of the floor.
    """
    if checked_truth(floor, "floor") and any(body.name == FLOOR for body in bodies):
        raise SceneError(message(FLOOR, "the file has a body of this name", "leave floor= out"))
    found = [*bodies, Body(FLOOR, HalfSpace(), fixed=True)] if floor else list(bodies)
    if not any(body.fixed for body in found):
        raise SceneError(message(where, problem, remedy))
    return found


def unique(wanted: Iterable[str]) -> list[str]:
    """Return the names with numbers appended to repeated ones."""
    taken: set[str] = set()
    numbers: dict[str, int] = {}
    result = []
    for name in wanted:
        chosen = name
        while chosen in taken:
            numbers[name] = numbers.get(name, 1) + 1
            chosen = f"{name} ({numbers[name]})"
        taken.add(chosen)
        result.append(chosen)
    return result


def on_the_floor(scene: Scene) -> Scene:
    """Return the scene moved vertically, as one, so that its lowest point is on the floor; a note says how far.

    The floor is the highest level half space, and all but half spaces are moved. Without one it is the top of the only
    fixed body, and what can move is moved. Raises SceneError if there is neither.
    """
    planes = [body for body in scene.bodies if isinstance(body.shape, HalfSpace)]
    tops = [float(body.pose[:3, 3] @ scene.up) for body in planes if body.pose[:3, 2] @ scene.up > LEVEL]
    fixed = [body for body in scene.bodies if body.fixed and body not in planes]
    if not tops and len(fixed) == 1:
        tops, planes = [_heights(fixed[0], scene.up).max()], [*planes, *fixed]
    if not tops:
        problem = f"of {len(fixed)} fixed bodies none is a level half space"
        raise SceneError(message("on_floor", problem, "give floor=True, or one fixed body that carries the others"))
    moved = [body for body in scene.bodies if body not in planes]
    lift = max(tops) - min((_heights(body, scene.up).min() for body in moved), default=max(tops))
    step = np.eye(4)
    step[:3, 3] = lift * scene.up
    way = f"lowered by {-lift:.6g} m" if lift < 0 else f"raised by {lift:.6g} m"
    return with_notes(
        scene.moved({body.name: step @ body.pose for body in moved}),
        [f"on_floor: {way}, so that the lowest point is on the floor"],
    )


def _heights(body: Body, up: Float) -> Float:
    return np.asarray(body.surface_world.vertices @ up)
