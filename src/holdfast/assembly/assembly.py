"""From a scene to an assembly: interfaces found or given, the graph they make, and what hangs in the air."""

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
    """Bodies and the interfaces between them.

    Movable bodies are numbered 0..J-1 in scene order; all fixed bodies are the one node FIXED. ``overlaps`` are pairs
    that share more volume than the tolerance explains, ``occluded`` those that would touch if no third body lay between
    them; ``detected`` says whether the interfaces were searched for.
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
        """Number of each body: 0..J-1, or FIXED."""
        numbers = {body.name: k for k, body in enumerate(self.movable)}
        return MappingProxyType({body.name: numbers.get(body.name, FIXED) for body in self.bodies})

    @cached_property
    def ends(self) -> tuple[tuple[int, int], ...]:
        """Body numbers (a, b) of every interface."""
        return tuple((self.index[a], self.index[b]) for a, b in (i.bodies for i in self.interfaces))

    @cached_property
    def mu(self) -> tuple[float, ...]:
        """Friction coefficient of every interface."""
        return tuple(self.scene.mu(*interface.bodies) for interface in self.interfaces)

    @cached_property
    def com(self) -> Float:
        """(J, 3) centres of mass in the world [m]: the reference points of all wrenches."""
        return frozen(np.array([body.com_world for body in self.movable]).reshape(-1, 3))

    @cached_property
    def mass(self) -> Float:
        """(J,) [kg]."""
        return frozen(np.array([body.mass for body in self.movable], dtype=np.float64))

    def weight_wrench(self, acceleration: Float | None = None) -> Float:
        """(6J,) weight of every body, and its inertial force on a support that accelerates by (3,) [m/s²]."""
        pull = self.scene.gravity - (0 if acceleration is None else acceleration)
        return body_forces(self.mass[:, None] * pull)

    @cached_property
    def weight(self) -> float:
        """Total weight of the movable bodies [N]: the scale of forces."""
        return float(self.mass.sum() * np.linalg.norm(self.scene.gravity))

    @cached_property
    def equation_scale(self) -> Float:
        """(6J,) factors that bring every body's equilibrium to order one: by its own weight and its own size.

        In units of the whole assembly a light body beside a heavy one could fall unnoticed.
        """
        share = self.mass.sum() / self.mass
        size = np.array([body.size for body in self.movable])
        return frozen(np.repeat(np.column_stack([share, share / size]).ravel(), 3))

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around the movable bodies [m]: the scale of lengths."""
        if not self.movable:
            return 1.0
        corners = np.vstack([body.surface_world.vertices for body in self.movable])
        return float(np.linalg.norm(np.ptp(corners, axis=0)))

    @cached_property
    def hanging(self) -> tuple[tuple[str, ...], ...]:
        """Groups of bodies that no chain of interfaces ties to a fixed body."""
        return tuple(
            tuple(self.movable[k].name for k in group) for group in components(len(self.movable), self.ends) if group
        )

    @cached_property
    def unmodelled(self) -> tuple[tuple[str, str], ...]:
        """Pairs that come within the gap without a contact that has a normal: sharp corner on corner or on edge.

        Such contacts carry force in reality; an assembly that seems to fall may stand on them. Empty where the
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
        """Names of the movable bodies that share contacts, group by group, in the order of the scene.

        Contacts with fixed bodies join nothing: what stands apart on one floor is several groups.
        """
        between = [(a, b) for a, b in self.ends if FIXED not in (a, b)]
        return tuple(tuple(self.movable[k].name for k in group) for group in components(len(self.movable), between))

    def moved(self, poses: Mapping[str, ArrayLike]) -> Assembly:
        """The assembly with the bodies of these names at other poses (4, 4), body frame to world.

        Contacts are sought anew: it equals ``assemble`` of the moved scene at this assembly's tolerances, which are
        kept. Raises HoldfastError where the interfaces were given.
        """
        return self._sought(self.scene.moved(poses), "moved")

    def with_body(self, body: Body) -> Assembly:
        """The assembly with one body more, after the others.

        Contacts are sought anew: it equals ``assemble`` of the larger scene at this assembly's tolerances, which are
        kept. Raises HoldfastError where the interfaces were given.
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
        """The assembly with these bodies taken away: the interfaces of the others are kept, not sought again.

        It equals ``assemble`` of the scene without them at the same tolerances. Where one of them lay between two
        bodies that come within the gap (``occluded``), contacts are sought anew. Given interfaces stay given.
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
        """Whether a body that goes may hide something between two that stay: it is near to one of them at least."""
        hidden = [set(pair) for pair in self.occluded]
        hidden += [set(i.bodies) for i in self.interfaces if "occluded" in i.flags]
        return any(pair.isdisjoint(gone) and any(self._beside[name] & pair for name in gone) for pair in hidden)

    @cached_property
    def _beside(self) -> dict[str, set[str]]:
        """The bodies that each body touches, or would touch if none lay between."""
        beside: dict[str, set[str]] = {body.name: set() for body in self.bodies}
        for a, b in (*(i.bodies for i in self.interfaces), *self.occluded):
            beside[a].add(b)
            beside[b].add(a)
        return beside

    def nearest_support(self, group: Sequence[str]) -> tuple[str, str, float] | None:
        """Of a hanging group, the body nearest to one outside it: (inside, outside, distance [m])."""
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

    ``gap`` [m]: how far apart, or into each other, two surfaces may lie and still touch (a thousandth of the usual body
    size unless given). ``angle`` [deg]: how far two faces may be from parallel (1 unless given). ``pose_sigma``: the
    standard deviation of the poses' positions [m], or of positions [m] and rotations [deg]; it sets the gap of each
    pair to 4σ, with what a rotation moves at the end of the larger body, up to half the thickness of the thinner one,
    and widens the angle by 4σ. Each interface's ``flags`` tell what in it depends on a tolerance. Bodies that overlap
    more than the gap raise a HoldfastWarning that names them and the depth. Given interfaces are taken as complete and
    are not checked against the meshes; those between two fixed bodies are left out.
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
    """The assembly of all contacts there are; a warning names the overlaps that are not ``known``."""
    overlaps = find_overlaps(scene, tolerances)
    new = [overlap for overlap in overlaps if overlap not in known]
    if new:
        warn_of_overlaps(new, stacklevel=stacklevel + 1)
    contacts = find_contacts(scene, tolerances)
    return Assembly(scene, _with_status(contacts.interfaces, overlaps), tolerances, overlaps, contacts.occluded)


def checked_pose_sigma(value: object, where: str) -> tuple[float, float]:
    """Standard deviations of the poses' positions [m] and rotations [deg]."""
    both = value if isinstance(value, tuple | list) else (value, 0.0)
    if len(both) != 2:
        remedy = "needs metres, or a pair (metres, degrees)"
        raise HoldfastError(message(where, f"pose_sigma = {value!r}", remedy))
    metres = checked_number(both[0], f"{where}: pose_sigma", above=0)
    return metres, checked_number(both[1], f"{where}: pose_sigma: rotation [deg]", minimum=0)


def body_forces(forces: Float) -> Float:
    """(6J,) wrenches of forces (J, 3) at the centres of mass."""
    return np.hstack([forces, np.zeros_like(forces)]).reshape(-1)


def components(count: int, ends: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Connected groups of 0..count-1 that no edge path ties to FIXED."""
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
    """The interfaces whose bodies can move against each other; those between fixed bodies carry nothing we ask for."""
    kept = []
    for interface in interfaces:
        if not hasattr(interface, "patches"):
            problem = f"interfaces holds a {type(interface).__name__}"
            raise SceneError(message("assemble", problem, "needs holdfast.Interface objects"))
        a, b = (scene.body(name) for name in interface.bodies)
        if not (a.fixed and b.fixed):
            kept.append(interface)
    return tuple(kept)
