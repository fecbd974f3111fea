"""A scene: rigid bodies, friction between them, and gravity."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_items, checked_name, checked_whole, frozen, unit
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.public import Record, Summary, column, in_notebook, number
from holdfast.base.ranges import ACCELERATION, ANGLE
from holdfast.base.rigid import tangents
from holdfast.base.text import quoted
from holdfast.base.values import altered
from holdfast.scene.body import Body, materials_of, place_cuboids
from holdfast.scene.excluded import Excluded, by_bodies, checked_excluded, excluded_among, may_touch, touching_parts
from holdfast.scene.friction import Friction, joined_friction
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.hold import AnyHold, checked_holds, holds_among, jointed, moved_hold

DIRECTIONS = 100  # number of directions on the default circle (Nadeau & Kelly, Fig. 15)
MOST_DIRECTIONS = 1_000_000  # more answers would not fit into memory
# Parts of a turn in radians, such as 1.5708, are multiples of pi / 12; they are often given with three digits, as 1.57
PART, DIGITS_OFF = np.pi / 12, 6e-4
ANGLE_ZERO = 1e-6  # [deg] of rounding in poses


class Scene(Record):
    """Rigid bodies, the friction between them, and gravity.

    ``bodies`` have unique names, and at least one of them is fixed. ``friction`` is a Friction table, or one
    coefficient for all pairs. ``gravity`` (3,) [m/s²] is in the world frame and not zero. ``excluded`` are pairs of
    bodies that never touch: contacts and overlaps between them are not searched. Each of the two is a name, or a name
    and the number of one part of a compound, from 0: ``[("hand", "cup"), (("hand", 2), "table")]``. Each pair is in
    alphabetical order, and so are the pairs. ``notes`` say what a reader of files assumed or left out, and what looks
    like a mistake; they take no part in comparisons. ``holds`` are the hands and grippers that hold movable bodies
    (Hold, Grip). Raises SceneError if one of these conditions is violated, or if the friction table, ``excluded`` or
    ``holds`` uses an unknown name.

    For example:

    >>> floor = hf.Body("floor", hf.HalfSpace(), fixed=True)
    >>> crate = hf.Body("crate", hf.Box((0.2, 0.2, 0.3)), mass=4, position=(0, 0, 0.15))
    >>> print(hf.stability(hf.Scene([floor, crate], friction=0.5)).status)
    stable
    """

    bodies: tuple[Body, ...]
    friction: Friction
    gravity: Float = column("3")
    name: str
    excluded: tuple[Excluded, ...]
    notes: tuple[str, ...] = field(compare=False)
    holds: tuple[AnyHold, ...]

    def __init__(
        self,
        bodies: Iterable[Body],
        friction: Friction | float,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        name: str = "",
        excluded: Iterable[Excluded] = (),
        notes: Iterable[str] = (),
        holds: Iterable[AnyHold] = (),
    ) -> None:
        set_ = object.__setattr__
        set_(self, "bodies", tuple(checked_items(bodies, "scene: bodies", "Body objects")))
        if isinstance(friction, Mapping):
            remedy = "write Friction(pairs={('cup', 'table'): 0.4})"
            raise SceneError(message("scene: friction", f"is {quoted(friction, 80)}", remedy))
        set_(self, "friction", friction if isinstance(friction, Friction) else Friction(default=friction))
        set_(self, "gravity", checked(gravity, (3,), "scene: gravity", within=ACCELERATION))
        set_(self, "name", "" if isinstance(name, str) and not name else checked_name(name, "scene: name"))
        given = tuple(checked_items(notes, "scene: notes", "texts"))
        for note in given:
            if not isinstance(note, str):
                raise SceneError(message("scene: notes", f"holds {quoted(note)}", "needs a list of texts"))
        set_(self, "notes", tuple(map(str, given)))
        self._check()
        set_(self, "excluded", checked_excluded(excluded, self.bodies))
        set_(self, "holds", checked_holds(holds, self.bodies))
        if any(isinstance(body.shape, HalfSpace) for body in self.bodies):
            set_(self, "bodies", _under(self.bodies))

    def _repr_html_(self) -> str:
        """Return the scene for notebooks: a small picture and a table of its bodies, without scripts."""
        count = len(self.movable)
        headline = f"{self.name or 'scene'}: {count} movable, {len(self.bodies) - count} fixed"
        rows = [
            [
                body.name,
                "fixed" if body.fixed or body.mass is None else number(body.mass, "kg"),
                type(body.shape).__name__,
                body.material or "",
            ]
            for body in self.bodies
        ]
        return in_notebook(self, Summary(headline, (), ("body", "mass", "shape", "material"), rows, self.notes))

    def _check(self) -> None:
        for body in self.bodies:
            if not isinstance(body, Body):
                raise SceneError(message("scene", f"bodies holds a {type(body).__name__}", "needs Body objects"))
        if not self.bodies:
            raise SceneError(message("scene", "has no bodies", "needs at least one fixed body"))
        names = [body.name for body in self.bodies]
        twice = sorted(name for name, count in Counter(names).items() if count > 1)
        if twice:
            raise SceneError(message("scene", f"several bodies are named {quoted(twice[0])}", "names are unique"))
        if not any(body.fixed for body in self.bodies):
            problem = f"none of its {len(names)} bodies is fixed"
            remedy = "mark what carries the others with fixed=True, or add a fixed HalfSpace"
            raise SceneError(message("scene", problem, f"{remedy}; files of other programs take floor=True"))
        strength = math.hypot(*self.gravity.tolist())
        if 0 < strength < ACCELERATION.least:
            raise SceneError(message("scene: gravity", f"is {strength:g} m/s²", f"needs a length {ACCELERATION}"))
        if not strength > 0:
            remedy = "contacts carry nothing without it: give a vector such as (0, 0, -9.81) m/s²"
            raise SceneError(message("scene", "gravity is zero", remedy))
        self.friction.check_names(names, self.names - set(names))
        strong = {*self.friction.tension, *self.friction.cohesion}
        for body in self.bodies if self.friction.joins else ():
            known = {body.name, *body.materials}
            if {*body.materials} != {body.material} and any(known & {*pair} for pair in strong):
                problem = "has a tension or a cohesion, and parts with materials of their own"
                raise SceneError(message(f"body {quoted(body.name)}", problem, "give it one material"))

    @cached_property
    def materials(self) -> Mapping[str, str | None]:
        """The material of each body by its name, or None."""
        return MappingProxyType({body.name: body.material for body in self.bodies})

    @cached_property
    def names(self) -> frozenset[str]:
        """The names of all bodies and materials."""
        return frozenset(body.name for body in self.bodies) | materials_of(self.bodies)

    @cached_property
    def up(self) -> Float:
        """The unit vector (3,) opposite to gravity, world frame."""
        return frozen(unit(-self.gravity))

    @cached_property
    def movable(self) -> tuple[Body, ...]:
        """The bodies that are not fixed, in scene order."""
        return tuple([body for body in self.bodies if not body.fixed])

    def body(self, name: str) -> Body:
        """Return the body with this name; raises SceneError, with the most similar name, if there is none."""
        found = self._by_name.get(name) if isinstance(name, str) else None
        if found is None:
            raise SceneError(message("scene", f"has no body named {quoted(name)}", nearest_of(name, self._by_name)))
        return found

    @cached_property
    def _by_name(self) -> dict[str, Body]:
        return {body.name: body for body in self.bodies}

    @cached_property
    def _apart(self) -> dict[tuple[str, str], list[Excluded]]:
        return by_bodies((*self.excluded, *jointed(self.holds)))

    @cached_property
    def _views(self) -> dict[tuple[str, tuple[int, ...]], Body]:
        return {}

    def touching(self, a: Body, b: Body) -> list[tuple[Body, Body]]:
        """Return the pairs of bodies between which contacts of ``a`` and ``b`` are searched; none if they are excluded.

        It is one pair, the two bodies themselves, if all of their parts may touch. Otherwise each pair consists of
        bodies with fewer parts.
        """
        apart = self._apart.get((min(a.name, b.name), max(a.name, b.name)))
        if apart is None:
            return [(a, b)]
        return [
            (self._with_parts(a, tuple(first)), self._with_parts(b, tuple(second)))
            for first, second in touching_parts(may_touch(a, b, apart))
        ]

    def _with_parts(self, body: Body, parts: tuple[int, ...]) -> Body:
        if len(parts) == len(body.materials):  # each part has a material: all parts are meant
            return body
        key = body.name, parts
        if key not in self._views:
            self._views[key] = body.only(parts)
        return self._views[key]

    def moved(self, poses: Mapping[str, ArrayLike]) -> Scene:
        """Return the scene with some bodies at other poses.

        ``poses`` maps names of bodies to poses (4, 4), body frame to world. Holds move with their bodies. Raises
        SceneError for an unknown name.
        """
        if not hasattr(poses, "items"):
            remedy = 'needs a dict such as {"cup": pose}'
            raise SceneError(message("scene: moved", f"got a {type(poses).__name__}", remedy))
        for name in poses:
            self.body(name)
        bodies = tuple([body.moved(poses[body.name]) if body.name in poses else body for body in self.bodies])
        if any(isinstance(body.shape, HalfSpace) for body in bodies):
            bodies = _under(bodies)
        place = {old.name: (old.pose, new.pose) for old, new in zip(self.bodies, bodies, strict=True)}
        holds = []
        for hold in self.holds:
            old, new = place[hold.body]
            holds.append(hold if old is new else moved_hold(hold, new @ np.linalg.inv(old)))
        return altered(self, bodies=bodies, holds=tuple(holds))

    def with_body(self, obj: Body) -> Scene:
        """Return the scene with ``obj`` added after the others."""
        return replace(self, bodies=(*self.bodies, obj))

    def without(self, *names: str | Iterable[str]) -> Scene:
        """Return the scene without the bodies of these names.

        Entries of the friction table that name a removed body, or a material that no other body has, are dropped, and
        so are the excluded pairs and the holds of a removed body. Raises SceneError for an unknown name.
        """
        gone = self.checked_names(*names)
        left = tuple(body for body in self.bodies if body.name not in gone)
        known = {body.name for body in left} | materials_of(left)
        excluded = excluded_among(self.excluded, {body.name for body in left})
        holds = holds_among(self.holds, {body.name for body in left})
        return replace(self, bodies=left, friction=self.friction.among(known), excluded=excluded, holds=holds)

    def __add__(self, other: Scene) -> Scene:
        """Return the scene with the bodies of both, their friction tables, excluded pairs, holds and notes.

        A fixed body that is equal in both, such as the floor, is in the sum once. Raises SceneError if any other name
        is in both, if gravity differs, or if the friction tables conflict: a pair of names has two coefficients, a
        table would change a coefficient within the other scene, or default or ``combine`` differ.
        """
        if not isinstance(other, Scene):
            return NotImplemented
        known = self._by_name
        added = [body for body in other.bodies if not (body.fixed and known.get(body.name) == body)]
        twice = next((body.name for body in added if body.name in known), None)
        if twice is not None:
            problem = f"a body named {quoted(twice)} is in both"
            raise SceneError(
                message("scene + scene", problem, "give it another name: dataclasses.replace(body, name=...)")
            )
        if (self.gravity != other.gravity).any():
            problem = f"gravity is {self.gravity.tolist()} and {other.gravity.tolist()}"
            raise SceneError(message("scene + scene", problem, "needs the same gravity in both"))
        return Scene(
            (*self.bodies, *added),
            joined_friction(self.friction, other.friction, self.names, other.names),
            self.gravity,
            " + ".join(filter(None, (self.name, other.name))),
            (*self.excluded, *other.excluded),
            dict.fromkeys((*self.notes, *other.notes)),
            (*self.holds, *other.holds),
        )

    def checked_names(self, *names: str | Iterable[str]) -> frozenset[str]:
        """Return all names as one set; they can be given one by one or in lists.

        Raises SceneError for an unknown name.
        """
        single = [[name] if isinstance(name, str) else checked_items(name, "scene", "names") for name in names]
        return frozenset(self.body(name).name for several in single for name in several)

    def horizontal_directions(self, count: int = DIRECTIONS) -> Float:
        """Return ``count`` unit vectors (count, 3), evenly spaced around the circle perpendicular to gravity.

        The first is the x axis of the scene, projected into the horizontal plane. Raises HoldfastError if ``count`` is
        not a whole number of at least 1.
        """
        checked_whole(count, "horizontal_directions: count", 1, MOST_DIRECTIONS)
        ahead, left = tangents(self.up)
        angle = 2 * np.pi * np.arange(count)[:, None] / count
        return np.asarray(frozen(np.cos(angle) * ahead + np.sin(angle) * left))

    def tilted(self, tilt_degrees: ArrayLike) -> Scene:
        """Return the scene on a carrier that is tilted; gravity is rotated the opposite way in the axes of the scene.

        ``tilt_degrees`` is a rotation vector (3,) [deg]. It rotates the axes of the scene from where they are now to
        where the tilted carrier has them. Raises SceneError for anything else.
        """
        given = checked(tilt_degrees, (3,), "tilt_degrees", within=ANGLE)
        from scipy.spatial.transform import Rotation  # only here, as it takes a tenth of a second

        turn = Rotation.from_rotvec(np.radians(given)).as_matrix()
        vector = np.degrees(Rotation.from_matrix(turn).as_rotvec())
        angle = float(np.linalg.norm(vector))
        axis = ", ".join(f"{v + 0.0:.3g}" for v in np.round(vector / angle, 9)) if angle else "any axis"
        note = f"the carrier is tilted by {angle:.4g}° about ({axis})" if angle else ""
        if like_radians(given):
            note += f": are these degrees? {angle:.5g} rad are {np.degrees(angle):.3g}°"
        return with_notes(replace(self, gravity=turn.T @ self.gravity), [note] if note else [])

    def mu(self, a: str, b: str) -> float:
        """Return the static friction coefficient between two bodies.

        Raises SceneError if the table has none, or for an unknown name.
        """
        return self.friction.between(self.body(a).name, self.body(b).name, self.materials)


def with_notes(scene: Scene, notes: Iterable[str]) -> Scene:
    """Return the scene with ``notes`` appended to its own, without repetitions."""
    whole = tuple(dict.fromkeys((*scene.notes, *notes)))
    return scene if whole == scene.notes else altered(scene, notes=whole)


def _under(bodies: tuple[Body, ...]) -> tuple[Body, ...]:
    """Return the bodies with the block of every half space so large that all other bodies lie over it."""
    place_cuboids(bodies)
    solid = [corner for body in bodies if not isinstance(body.shape, HalfSpace) for corner in body.box]
    corners = np.array(solid or [np.zeros(3)])
    around = corners.mean(0) + float(np.ptp(corners, axis=0).max()) * np.vstack([np.eye(3), -np.eye(3)])

    def enlarged(body: Body) -> Body:
        if not isinstance(body.shape, HalfSpace):
            return body
        shape = body.shape.over((around - body.pose[:3, 3]) @ body.pose[:3, :3])
        return body if shape.reach == body.shape.reach else replace(body, shape=shape)

    return tuple(enlarged(body) for body in bodies)


def like_radians(degrees: Float) -> bool:
    """Tell whether angles (n,) [deg] look as if they were in radians.

    None is larger than a turn in radians, and half of those that are not zero are its usual parts, 30, 45, 60, 90 ...
    """
    angles = np.abs(degrees[np.abs(degrees) > ANGLE_ZERO])
    number = np.round(angles / PART)
    part = (np.abs(angles - number * PART) <= DIGITS_OFF * angles) & ((number % 2 == 0) | (number % 3 == 0))
    return bool(len(angles) and angles.max() <= 24.1 * PART and 2 * part.sum() >= len(angles))
