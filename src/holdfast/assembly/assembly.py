"""Assemblies: the bodies of a scene with their contact interfaces, detected or given, and the contact graph."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.caution import warn_of_overlaps, warn_of_units
from holdfast.base.archive import archived
from holdfast.base.arrays import Float, checked_number, frozen
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.values import Value, cut
from holdfast.contacts.detect import (
    DEFAULT_ANGLE,
    SIGMAS,
    Tolerances,
    box_distance,
    default_gap,
    find_contacts,
    neighbours,
)
from holdfast.contacts.interface import Interface
from holdfast.contacts.overlap import Overlap, distance, find_overlaps
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

FIXED = -1  # the node of the graph into which all fixed bodies are merged


@archived
@dataclass(frozen=True, eq=False, repr=False)
class Assembly(Value):
    """The bodies of a scene and the contact interfaces between them.

    The J movable bodies are numbered 0..J-1 in scene order. All fixed bodies together are the node FIXED of the contact
    graph. ``overlaps`` are the pairs of bodies that overlap by more than the tolerance. ``occluded`` are the pairs that
    would touch if no third body lay between them. ``detected`` is True if the interfaces were searched for, and False
    if they were given.
    """

    scene: Scene
    interfaces: tuple[Interface, ...]
    tolerances: Tolerances
    overlaps: tuple[Overlap, ...] = ()
    occluded: tuple[tuple[str, str], ...] = ()
    detected: bool = True

    def __repr__(self) -> str:
        parts = {"movable bodies": self.movable, "interfaces": self.interfaces, "overlaps": self.overlaps}
        counts = ", ".join(f"{len(part)} {name}" for name, part in parts.items())
        found = f"gap {self.tolerances.gap * 1e3:.3g} mm" if self.detected else "interfaces given"
        return f"Assembly(<Scene {cut(repr(self.scene.name), 60)}>, {counts}, {found})"

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All bodies of the scene."""
        return self.scene.bodies

    @cached_property
    def movable(self) -> tuple[Body, ...]:
        """The J bodies that have rows in the equilibrium operator."""
        return self.scene.movable

    @cached_property
    def index(self) -> Mapping[str, int]:
        """The number of each body by name: 0..J-1 for movable bodies, FIXED for the others."""
        numbers = {body.name: k for k, body in enumerate(self.movable)}
        return MappingProxyType({body.name: numbers.get(body.name, FIXED) for body in self.bodies})

    @cached_property
    def ends(self) -> tuple[tuple[int, int], ...]:
        """The numbers (a, b) of the two bodies of every interface."""
        return tuple((self.index[a], self.index[b]) for a, b in (i.bodies for i in self.interfaces))

    @cached_property
    def mu(self) -> tuple[float, ...]:
        """The friction coefficient of every interface."""
        return tuple(self.scene.mu(*interface.bodies) for interface in self.interfaces)

    @cached_property
    def com(self) -> Float:
        """The centres of mass (J, 3) [m] in the world frame, which are the reference points of all wrenches."""
        return frozen(np.array([body.com_world for body in self.movable]).reshape(-1, 3))

    @cached_property
    def mass(self) -> Float:
        """The masses (J,) [kg] of the movable bodies."""
        return frozen(np.array([body.mass for body in self.movable], dtype=np.float64))

    def weight_wrench(self, acceleration: Float | None = None) -> Float:
        """Return the wrenches (6J,) [N, N m] of the weights of all movable bodies.

        They include the inertial forces if the support has an ``acceleration`` (3,) [m/s²] along the world axes.
        """
        pull = self.scene.gravity - (0 if acceleration is None else acceleration)
        return body_forces(self.mass[:, None] * pull)

    @cached_property
    def weight(self) -> float:
        """The total weight of the movable bodies [N], which is the scale of forces."""
        return float(self.mass.sum() * np.linalg.norm(self.scene.gravity))

    @cached_property
    def equation_scale(self) -> Float:
        """The factors (6J,) that bring the equilibrium equations of every body to order one.

        They use the weight and the size of each body. In units of the whole assembly, the fall of a light body beside a
        heavy one could go unnoticed.
        """
        share = self.mass.sum() / self.mass
        size = np.array([body.size for body in self.movable])
        return frozen(np.repeat(np.column_stack([share, share / size]).ravel(), 3))

    @cached_property
    def size(self) -> float:
        """The diagonal of the bounding box of the movable bodies [m], which is the scale of lengths."""
        if not self.movable:
            return 1.0
        corners = np.vstack([body.surface_world.vertices for body in self.movable])
        return float(np.linalg.norm(np.ptp(corners, axis=0)))

    @cached_property
    def hanging(self) -> tuple[tuple[str, ...], ...]:
        """The groups of bodies that no chain of interfaces connects to a fixed body."""
        return tuple(
            tuple(self.movable[k].name for k in group) for group in components(len(self.movable), self.ends) if group
        )

    @cached_property
    def unmodelled(self) -> tuple[tuple[str, str], ...]:
        """The pairs of bodies that come within the gap but have no contact normal, such as sharp corner on sharp edge.

        In reality such contacts carry forces, so an assembly that seems to fall may stand on them. Empty if the
        interfaces were given.
        """
        if not self.detected:
            return ()
        known = {frozenset(interface.bodies) for interface in self.interfaces} | {frozenset(p) for p in self.occluded}
        near = neighbours(self.scene, self.tolerances.widest(self.scene))
        return tuple(
            (a.name, b.name)
            for a, b in near
            if frozenset((a.name, b.name)) not in known
            and distance(a, b, 1.001 * self.tolerances.between(a, b).gap) is not None
        )

    @cached_property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """The names of the movable bodies in groups that are connected by contacts, in scene order.

        Contacts with fixed bodies do not connect: bodies that stand apart on one floor are in different groups.
        """
        between = [(a, b) for a, b in self.ends if FIXED not in (a, b)]
        return tuple(tuple(self.movable[k].name for k in group) for group in components(len(self.movable), between))

    def moved(self, poses: Mapping[str, ArrayLike]) -> Assembly:
        """Return the assembly with the named bodies at other poses (4, 4), from the body frame to the world frame.

        Contacts are detected anew, with the tolerances of this assembly. The result equals ``assemble`` of the moved
        scene with these tolerances. Raises HoldfastError if the interfaces were given.
        """
        return self._sought(self.scene.moved(poses), "moved")

    def with_body(self, body: Body) -> Assembly:
        """Return the assembly with one more body, which comes after the others.

        Contacts are detected anew, with the tolerances of this assembly. The result equals ``assemble`` of the larger
        scene with these tolerances. Raises HoldfastError if the interfaces were given.
        """
        warn_of_units([body], self.tolerances.gap, stacklevel=3)
        return self._sought(self.scene.with_body(body), "with_body")

    def _sought(self, scene: Scene, what: str) -> Assembly:
        if not self.detected:
            problem = "its interfaces were given, and where bodies touch now cannot be told from them"
            remedy = "assemble the changed scene with interfaces= of its own"
            raise HoldfastError(message(f"Assembly.{what}", problem, remedy))
        return _search(scene, self.tolerances, self.overlaps, stacklevel=4)

    def without(self, *names: str | Iterable[str]) -> Assembly:
        """Return the assembly without these bodies. The interfaces between the other bodies are kept.

        The result equals ``assemble`` of the scene without them at the same tolerances. Contacts are detected anew only
        if one of the bodies lay between two others that come within the gap (``occluded``). Interfaces that were given
        stay as they are.
        """
        gone = self.scene.checked_names(*names)
        scene = self.scene.without(gone)
        if self.detected and self._uncovers(gone):
            return _search(scene, self.tolerances, self.overlaps, stacklevel=3)
        overlaps = tuple(o for o in self.overlaps if gone.isdisjoint(o.bodies))
        kept = tuple(i for i in self.interfaces if gone.isdisjoint(i.bodies))
        occluded = tuple(pair for pair in self.occluded if gone.isdisjoint(pair))
        return Assembly(scene, kept, self.tolerances, overlaps, occluded, self.detected)

    def _uncovers(self, gone: Collection[str]) -> bool:
        """Say whether a removed body may have hidden a contact between two that stay: it is near to at least one."""
        hidden = [set(pair) for pair in self.occluded]
        hidden += [set(i.bodies) for i in self.interfaces if "occluded" in i.flags]
        return any(pair.isdisjoint(gone) and any(self._beside[name] & pair for name in gone) for pair in hidden)

    @cached_property
    def _beside(self) -> dict[str, set[str]]:
        """The bodies that each body touches, or would touch if no third body lay between them."""
        beside: dict[str, set[str]] = {body.name: set() for body in self.bodies}
        for a, b in (*(i.bodies for i in self.interfaces), *self.occluded):
            beside[a].add(b)
            beside[b].add(a)
        return beside

    def nearest_support(self, group: Sequence[str]) -> tuple[str, str, float] | None:
        """Find the smallest distance from a hanging group to a body outside it: (inside, outside, distance [m])."""
        inside = [self.scene.body(name) for name in group]
        outside = [body for body in self.bodies if body.name not in group]
        best: tuple[str, str, float] | None = None
        reach = float(np.linalg.norm(np.ptp(np.vstack([b.surface_world.vertices for b in self.bodies]), axis=0)))
        pairs = list(itertools.product(inside, outside))
        for least, k in sorted((box_distance(a, b), k) for k, (a, b) in enumerate(pairs)):
            if least > reach:
                break
            a, b = pairs[k]
            found = distance(a, b, 1.001 * reach)
            if found is not None and (best is None or found < best[2]):
                best, reach = (a.name, b.name, found), found
        return best


def assemble(
    scene: Scene,
    *,
    gap: float | None = None,
    angle: float | None = None,
    pose_sigma: float | tuple[float, float] | None = None,
    interfaces: Iterable[Interface] | None = None,
) -> Assembly:
    """Find the contact interfaces of a scene, or take the given ones.

    - ``gap`` [m]: two surfaces touch if they are at most this far apart, or overlap by at most this much. The default
      is a thousandth of the usual body size.
    - ``angle`` [deg]: two faces touch only if they are parallel up to this angle. The default is 1.
    - ``pose_sigma``: the standard deviation of the positions [m] of the poses, or a pair of the standard deviations of
      positions [m] and rotations [deg]. It sets the gap of each pair of bodies to 4σ, where the rotation counts as the
      distance that it moves the end of the larger body, up to half the thickness of the thinner body. It also widens
      the angle by 4σ.

    The ``flags`` of each interface say which of its contacts depend on a tolerance. If bodies overlap by more than the
    gap, a HoldfastWarning names them and the depth. Given interfaces are taken as complete and are not checked against
    the meshes; those between two fixed bodies are left out.
    """
    if not hasattr(scene, "movable"):
        problem = f"got a {type(scene).__name__}"
        raise HoldfastError(message("assemble", problem, "needs a Scene: hf.load_scene(path) reads one from a file"))
    if gap is not None and pose_sigma is not None:
        raise HoldfastError(message("assemble", f"gap = {gap!r} and pose_sigma = {pose_sigma!r}", "give one of them"))
    tilt = 0.0
    if pose_sigma is not None:
        metres, tilt = checked_pose_sigma(pose_sigma, "assemble")
        gap = SIGMAS * metres
    tolerances = Tolerances(
        default_gap(scene) if gap is None else checked_number(gap, "assemble: gap", above=0),
        DEFAULT_ANGLE if angle is None else checked_number(angle, "assemble: angle", above=0),
        tilt,
        capped=pose_sigma is not None,
    )
    if tolerances.angle >= 90:
        raise HoldfastError(message("assemble", f"angle = {tolerances.angle:g} deg", "needs less than 90"))
    warn_of_units(scene.movable, tolerances.gap, stacklevel=3)
    if interfaces is not None:
        return Assembly(scene, _given(scene, interfaces), tolerances, detected=False)
    return _search(scene, tolerances, (), stacklevel=3)


def _search(scene: Scene, tolerances: Tolerances, known: Collection[Overlap], stacklevel: int) -> Assembly:
    """Return the assembly with all contacts detected; a warning names the overlaps that are not ``known``."""
    overlaps = find_overlaps(scene, tolerances)
    new = [overlap for overlap in overlaps if overlap not in known]
    if new:
        warn_of_overlaps(new, stacklevel=stacklevel + 1)
    contacts = find_contacts(scene, tolerances)
    return Assembly(scene, _with_status(contacts.interfaces, overlaps), tolerances, overlaps, contacts.occluded)


def checked_pose_sigma(value: object, where: str) -> tuple[float, float]:
    """Return the standard deviations of positions [m] and of rotations [deg] of the poses, after checking them."""
    both = value if isinstance(value, tuple | list) else (value, 0.0)
    if len(both) != 2:
        remedy = "needs metres, or a pair (metres, degrees)"
        raise HoldfastError(message(where, f"pose_sigma = {value!r}", remedy))
    metres = checked_number(both[0], f"{where}: pose_sigma", above=0)
    return metres, checked_number(both[1], f"{where}: pose_sigma: rotation [deg]", minimum=0)


def body_forces(forces: Float) -> Float:
    """Return the wrenches (6J,) of ``forces`` (J, 3) [N] that act at the centres of mass."""
    return np.hstack([forces, np.zeros_like(forces)]).reshape(-1)


def components(count: int, ends: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Return the connected groups of the nodes 0..count-1 that no path of edges connects to FIXED."""
    parent = list(range(count + 1))  # the last one is FIXED

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for a, b in ends:
        parent[root(a if a >= 0 else count)] = root(b if b >= 0 else count)
    groups: dict[int, list[int]] = {}
    for k in range(count):
        groups.setdefault(root(k), []).append(k)
    groups.pop(root(count), None)
    return list(groups.values())


def _with_status(interfaces: Sequence[Interface], overlaps: Sequence[Overlap]) -> tuple[Interface, ...]:
    deep = {frozenset(overlap.bodies) for overlap in overlaps}
    return tuple(
        i
        if frozenset(i.bodies) not in deep
        else Interface(i.bodies, patches=i.patches, status="penetrating", flags=i.flags)
        for i in interfaces
    )


def _given(scene: Scene, interfaces: Iterable[Interface]) -> tuple[Interface, ...]:
    """Return the given interfaces that have a movable body; those between fixed bodies cannot change any answer."""
    kept = []
    for interface in interfaces:
        if not hasattr(interface, "patches"):
            problem = f"interfaces holds a {type(interface).__name__}"
            raise SceneError(message("assemble", problem, "needs holdfast.Interface objects"))
        a, b = (scene.body(name) for name in interface.bodies)
        if not (a.fixed and b.fixed):
            kept.append(interface)
    return tuple(kept)
