"""The assembly of a scene: its bodies and their interfaces, detected or given."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.axes import contact_axes, own_frame
from holdfast.assembly.caution import (
    check_copies,
    check_units,
    doubts_of_scene,
    warn_of_bodies,
    warn_of_gap,
    warn_of_huge,
    warn_of_overlaps,
)
from holdfast.base.arrays import Float, Int, checked_items, checked_number, checked_truth, frozen
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.memory import Memory
from holdfast.base.public import Record, Summary, in_notebook, number
from holdfast.base.ranges import ANGLE, FRICTION, TOLERANCE
from holdfast.base.text import listed, quoted
from holdfast.base.values import altered, shortened
from holdfast.contacts.contact_search import FoundContacts, search
from holdfast.contacts.interface import Interface
from holdfast.contacts.neighbours import components
from holdfast.contacts.overlap import Overlap, nearest_outside
from holdfast.contacts.sharp_contacts import meeting_sharply, sharp_interface
from holdfast.contacts.tolerances import Tolerances, tolerances_of
from holdfast.geometry.triangles import NONE
from holdfast.scene.body import Body
from holdfast.scene.friction import checked_pairs
from holdfast.scene.hold import AnyHold, hold_ends, jointed
from holdfast.scene.scene import Scene, with_notes

MOST_CACHED = 4000  # bodies in the cache of an assembly and its edits, counted for each part and prepared engine
FIXED = -1  # the body number of all fixed bodies, which are one node of the contact graph


class Assembly(Record):
    """The bodies of a scene and the interfaces between them.

    The J movable bodies are numbered 0..J-1 in scene order; all fixed bodies together are the node FIXED. ``overlaps``
    lists the pairs of bodies that overlap by more than the tolerance. ``occluded`` lists the pairs that would touch if
    no third body lay between them. ``detected`` is true if the interfaces were detected by holdfast, and false if they
    were given. ``absent`` holds names of bodies and materials that are not in this scene, but were in the larger
    assembly from which this one was made. It takes no part in comparisons.
    """

    scene: Scene
    interfaces: tuple[Interface, ...]
    tolerances: Tolerances
    overlaps: tuple[Overlap, ...] = ()
    occluded: tuple[tuple[str, str], ...] = ()
    detected: bool = True
    absent: tuple[str, ...] = field(default=(), compare=False)

    def __repr__(self) -> str:
        parts = {"movable bodies": self.movable, "interfaces": self.interfaces, "overlaps": self.overlaps}
        counts = ", ".join(f"{len(part)} {name}" for name, part in parts.items())
        found = self.tolerances.text if self.detected else "interfaces given"
        return f"Assembly(<Scene {shortened(repr(self.scene.name), 60)}>, {counts}, {found})"

    def _repr_html_(self) -> str:
        """Return the assembly for notebooks: a small picture and a table of its interfaces, without scripts."""
        overlaps = f", {len(self.overlaps)} overlaps" if self.overlaps else ""
        counts = f"{len(self.movable)} movable bodies, {len(self.interfaces)} interfaces{overlaps}"
        rows = [
            [" - ".join(one.bodies), number(1e4 * one.area, "cm²"), number(mu), "" if one.certain else "may not exist"]
            for one, mu in zip(self.interfaces, self.mu, strict=True)
        ]
        summary = Summary(f"{self.scene.name or 'scene'}: {counts}", (), ("between", "area", "μ", ""), rows, self.notes)
        return in_notebook(self, summary)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All bodies of the scene."""
        return self.scene.bodies

    @cached_property
    def movable(self) -> tuple[Body, ...]:
        """The J movable bodies; each has six rows in the equilibrium operator."""
        return self.scene.movable

    @cached_property
    def fixed(self) -> tuple[Body, ...]:
        """The fixed bodies, in scene order."""
        return tuple(body for body in self.bodies if body.fixed)

    @cached_property
    def index(self) -> Mapping[str, int]:
        """The number of each body by its name: 0..J-1, or FIXED."""
        numbers = {body.name: k for k, body in enumerate(self.movable)}
        return MappingProxyType({body.name: numbers.get(body.name, FIXED) for body in self.bodies})

    @cached_property
    def ends(self) -> tuple[tuple[int, int], ...]:
        """The numbers (a, b) of the two bodies of every interface; FIXED for fixed bodies."""
        return tuple((self.index[a], self.index[b]) for a, b in (i.bodies for i in self.interfaces))

    @cached_property
    def interfaces_of(self) -> tuple[tuple[int, ...], ...]:
        """The numbers of the interfaces of every movable body."""
        own: list[list[int]] = [[] for _ in self.movable]
        for interface, ends in enumerate(self.ends):
            for body in ends:
                if body != FIXED:
                    own[body].append(interface)
        return tuple(tuple(numbers) for numbers in own)

    @cached_property
    def mu(self) -> tuple[float, ...]:
        """The friction coefficient of every interface."""
        return tuple(self.scene.mu(*i.bodies) if i.mu is None else i.mu for i in self.interfaces)

    @cached_property
    def com(self) -> Float:
        """The centres of mass (J, 3) [m] in the world frame; all wrenches refer to them."""
        return frozen(np.array([body.com_world for body in self.movable]).reshape(-1, 3))

    @cached_property
    def mass(self) -> Float:
        """The masses (J,) [kg] of the movable bodies."""
        return frozen(np.array([body.mass for body in self.movable], dtype=np.float64))

    def with_friction(self, mu: Mapping[tuple[str, str], float]) -> Assembly:
        """Return the assembly with the friction coefficients in ``mu``, given by the names of the two bodies.

        The contacts stay the same. A coefficient holds for all parts of two bodies.
        """
        old = self.scene
        if not isinstance(mu, Mapping):
            raise SceneError(message("with_friction", f"got {quoted(mu)}", 'needs a dict such as {("a", "b"): 0.4}'))
        known = checked_pairs(mu, "with_friction", "friction", minimum=0, within=FRICTION)
        table = replace(old.friction, pairs={**old.friction.pairs, **known})
        contacts = (replace(i, mu=None) if (min(i.bodies), max(i.bodies)) in known else i for i in self.interfaces)
        return replace(self, scene=replace(old, friction=table), interfaces=tuple(contacts))

    def with_masses(self, masses: Mapping[str, float]) -> Assembly:
        """Return the assembly with the ``masses`` [kg] of some movable bodies, by name; all else stays the same."""
        bodies = [replace(b, mass=masses[b.name], density=None) if b.name in masses else b for b in self.bodies]
        return replace(self, scene=replace(self.scene, bodies=tuple(bodies)))

    def with_mu(self, mu: Sequence[float]) -> Assembly:
        """Return the assembly with the friction coefficients ``mu``, one for each interface."""
        contacts = (replace(i, mu=value) for i, value in zip(self.interfaces, mu, strict=True))
        return replace(self, interfaces=tuple(contacts))

    def with_holds(self, *holds: AnyHold) -> Assembly:
        """Return the assembly with these holds on some of its bodies, beside those that it has.

        The contacts stay the same, but for those of two bodies that a joint connects from now on (``Hold``). Raises
        SceneError for a hold of a body that is unknown or fixed.
        """
        scene = replace(self.scene, holds=(*self.scene.holds, *holds))
        joints = {frozenset(pair) for pair in jointed(scene.holds)}
        kept = tuple(contact for contact in self.interfaces if frozenset(contact.bodies) not in joints)
        return replace(self, scene=scene, interfaces=kept)

    def without_interfaces(self, numbers: Collection[int]) -> Assembly:
        """Return the assembly without the interfaces with these numbers, as if the bodies did not touch there.

        The interfaces of the result count as given, so that no contacts are detected again.
        """
        gone = {frozenset(self.interfaces[k].bodies) for k in numbers}
        kept = tuple(interface for k, interface in enumerate(self.interfaces) if k not in numbers)
        overlaps = tuple(o for o in self.overlaps if frozenset(o.bodies) not in gone)
        return replace(self, interfaces=kept, overlaps=overlaps, detected=False)

    def weight_wrench(self, acceleration: Float | None = None) -> Float:
        """Return the weight of every body as wrenches (6J,) at the centres of mass, along the world axes.

        If the support accelerates by ``acceleration`` (3,) [m/s²], the inertial forces are included.
        """
        pull = self.scene.gravity - (0 if acceleration is None else acceleration)
        return body_forces(self.mass[:, None] * pull)

    @cached_property
    def weight(self) -> float:
        """The total weight of the movable bodies [N], which serves as the scale of forces."""
        return float(self.mass.sum() * np.linalg.norm(self.scene.gravity))

    @cached_property
    def equation_scale(self) -> Float:
        """Factors (6J,) that scale the equilibrium equations of each body to order one, by its own weight and size.

        If all bodies were scaled by the weight of the assembly, the fall of a light body beside a heavy one would be
        lost in the tolerance.
        """
        share = self.mass.sum() / self.mass
        size = np.array([body.size for body in self.movable])
        return frozen(np.repeat(np.column_stack([share, share / size]).ravel(), 3))

    @cached_property
    def levers(self) -> Float:
        """Factors (6J,) that convert torques to forces: 1 for forces, 1 / ``size`` for torques."""
        return frozen(np.tile(np.repeat([1.0, 1 / self.size], 3), len(self.movable)))

    def load_sizes(self, W: Float) -> Float:
        """Return the largest component (n,) [N] of each load, a column of W (6J, n) with torques as forces; 1 of none.

        A load over its size has one answer whatever units it came in.
        """
        size = np.abs(W * self.levers[:, None]).max(axis=0, initial=0.0)
        return np.where(size > 0, size, 1.0)

    @cached_property
    def size(self) -> float:
        """The diagonal [m] of a box around the movable bodies along ``axes``, which serves as the scale of lengths."""
        if not self.movable:
            return 1.0
        corners = np.vstack([body.surface_world.vertices for body in self.movable])
        return float(np.linalg.norm(np.ptp(corners @ self.axes.T, axis=0)))

    @cached_property
    def axes(self) -> Float:
        """The axes of the assembly as rows (3, 3) in the world: those of its heaviest movable body (``own_frame``)."""
        return own_frame(self.movable, self.scene.up).axes

    @cached_property
    def patch_axes(self) -> Float:
        """The contact axes (patches, 3, 3) of all patches, interface by interface; see ``contact_axes``."""
        normals = [patch.normal for interface in self.interfaces for patch in interface.patches]
        return frozen(contact_axes(self.axes, np.array(normals).reshape(-1, 3)))

    @cached_property
    def hanging(self) -> tuple[tuple[str, ...], ...]:
        """The groups of bodies that no chain of interfaces connects to a fixed body, and that nothing holds."""
        groups = components(len(self.movable), (*self.ends, *hold_ends(self.scene.holds, self.index, FIXED)))
        return tuple(tuple(self.movable[k].name for k in group) for group in groups)

    @cached_property
    def unmodelled(self) -> tuple[tuple[str, str], ...]:
        """Pairs of bodies that come within the gap but have no interface: a sharp corner on a corner or on an edge.

        Such a contact has no certain normal and is not modelled, although in reality it carries force. An assembly that
        seems to fall may stand on it (``sharpened``). The tuple is empty if the interfaces were given.
        """
        return tuple(dict.fromkeys((a.name, b.name) for a, b in self._unmodelled_parts))

    @cached_property
    def _unmodelled_parts(self) -> tuple[tuple[Body, Body], ...]:
        """The pairs of ``unmodelled`` as bodies; of a body in parts, a body of only those parts that may touch."""
        if not self.detected:
            return ()
        settled = (*(interface.bodies for interface in self.interfaces), *self.occluded)
        return meeting_sharply(self.scene, self.tolerances, {frozenset(pair) for pair in settled})

    @cached_property
    def sharpened(self) -> Assembly:
        """The assembly with more interfaces, after its own, for pairs in ``unmodelled`` that do not overlap.

        What falls even with these falls for certain. It is this assembly if there are none.
        """
        deep = {overlap.bodies for overlap in self.overlaps}
        pairs = (pair for pair in self._unmodelled_parts if (pair[0].name, pair[1].name) not in deep)
        found = [sharp_interface(self.scene, self.tolerances, *pair) for pair in pairs]
        return replace(self, interfaces=(*self.interfaces, *found)) if found else self

    @cached_property
    def gaps(self) -> tuple[float, ...]:
        """The gap [m] at which the two bodies of every interface count as touching, sagittas included."""
        return tuple(self._between(interface.bodies).gap for interface in self.interfaces)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """A note that lists the pairs with wider tolerances because of rough surfaces; empty if there are none."""
        rough = {body.name for body in self.bodies if body.shape.surface.roughness != NONE}
        if not rough:
            return ()
        plain = replace(self.tolerances, rough=False)
        wider = []
        for pair in dict.fromkeys(one.bodies for one in self.interfaces if not rough.isdisjoint(one.bodies)):
            own, exact = self._between(pair), plain.between(*(self.scene.body(name) for name in pair))
            if own.gap > exact.gap or own.angle > exact.angle:
                wider.append(f"{'-'.join(sorted(pair))} {own.gap * 1e3:.2g} mm and {own.angle:.2g} degrees")
        return (f"rough surfaces widen what counts as touching: {listed(wider)}",) if wider else ()

    def _between(self, pair: tuple[str, str]) -> Tolerances:
        return self.tolerances.between(*(self.scene.body(name) for name in pair))

    @cached_property
    def parts(self) -> dict[tuple[str, ...], Any]:
        """The assemblies of single groups made so far (one_group.py), by the names of their bodies."""
        return {}

    @cached_property
    def known_names(self) -> tuple[str, ...]:
        """The names of all bodies and materials in this scene and in ``absent``."""
        return (*self.absent, *self.scene.names)

    @cached_property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """The names of the movable bodies, grouped by contacts and holds between them, in the order of the scene.

        Contacts with fixed bodies do not connect groups: two separate stacks on one floor are two groups.
        """
        return tuple(tuple(self.movable[k].name for k in group) for group in self._joined)

    @cached_property
    def group_of(self) -> Int:
        """The number (J,) of the group of every movable body."""
        number = [0] * len(self.movable)
        for k, group in enumerate(self._joined):
            for body in group:
                number[body] = k
        return frozen(np.array(number, dtype=np.int64))

    @cached_property
    def _joined(self) -> list[list[int]]:
        """The numbers of the bodies of every group."""
        ends = (*self.ends, *hold_ends(self.scene.holds, self.index, FIXED))
        return components(len(self.movable), [(a, b) for a, b in ends if a >= 0 and b >= 0])

    @cached_property
    def memory(self) -> Memory:
        """The cache of parts and prepared engines for further queries, shared with all edits of this assembly.

        It is bounded, and neither pickled nor copied.
        """
        return Memory(MOST_CACHED)

    @cached_property
    def found(self) -> FoundContacts:
        """The result of contact detection, from which edits take what does not change."""
        return search(self.scene, self.tolerances)

    def moved(self, poses: Mapping[str, ArrayLike]) -> Assembly:
        """Return the assembly with some bodies at other poses.

        ``poses`` maps names of bodies to poses (4, 4), body frame to world. The result equals ``assemble`` of the moved
        scene with the tolerances of this assembly, but contacts are detected only where a body moved, and engines that
        were prepared for unchanged groups of bodies are reused. Raises HoldfastError if the interfaces were given.
        """
        return self._sought(self.scene.moved(poses), "moved")

    def at(self, poses: Mapping[str, ArrayLike], notes: tuple[str, ...], *, allow_large: bool = False) -> Assembly:
        """Return the assembly with some bodies at other poses as if it were the first of this scene.

        Unlike ``moved`` it notes and warns what ``assemble`` does, with ``notes`` in place of those of this scene.
        """
        scene = altered(self.scene.moved(poses), notes=notes)
        check_copies(scene)
        gap = None if self.tolerances.by_pair else self.tolerances.gap
        warn_of_bodies(scene.movable, gap, allow_large=allow_large)
        made = _search(scene, self.tolerances.on(scene), (), before=self.found)
        return self.heir(replace(made, scene=with_notes(scene, doubts_of_scene(scene, made.interfaces, made.overlaps))))

    def tilted(self, tilt_degrees: ArrayLike) -> Assembly:
        """Return the assembly, with its contacts, on a carrier that is tilted; see ``Scene.tilted``."""
        return replace(self, scene=self.scene.tilted(tilt_degrees))

    def with_body(self, body: Body) -> Assembly:
        """Return the assembly with ``body`` added after the others.

        The result equals ``assemble`` of the larger scene with the tolerances of this assembly; what did not change is
        reused as by ``moved``. Raises HoldfastError if the interfaces were given.
        """
        scene = self.scene.with_body(body)
        warn_of_huge([body])
        if not self.tolerances.by_pair:
            warn_of_gap([body], self.tolerances.gap)
        return self._sought(scene, "with_body")

    def _sought(self, scene: Scene, what: str) -> Assembly:
        if not self.detected:
            problem = "its interfaces were given, and where bodies touch now cannot be told from them"
            remedy = "assemble the changed scene with interfaces= of its own"
            raise HoldfastError(message(f"Assembly.{what}", problem, remedy))
        tolerances = self.tolerances.on(scene)
        edited = _search(scene, tolerances, self.overlaps, before=self.found, absent=self.absent)
        return self.heir(edited)

    def heir(self, edited: Assembly) -> Assembly:
        """Return an edit of this assembly that shares what was prepared for it."""
        edited.__dict__["memory"] = self.memory
        return edited

    def without(self, *names: str | Iterable[str]) -> Assembly:
        """Return the assembly without the bodies of these names.

        The interfaces between the other bodies stay. If a removed body lay between two bodies that come within the gap
        (``occluded``), or if the modelled block of a half space becomes smaller without it, contacts are detected again
        where that changes them. The result equals ``assemble`` of the smaller scene with the same tolerances. If the
        interfaces were given, the remaining ones stay as given. The removed names are listed in ``absent``. Raises
        SceneError for an unknown name.
        """
        gone = self.scene.checked_names(*names)
        scene = self.scene.without(gone)
        absent = tuple(sorted({*self.absent, *self.scene.names} - scene.names))
        tolerances = self.tolerances.on(scene)
        resized = any(scene.body(body.name) is not body for body in self.bodies if body.name not in gone)
        if self.detected and (resized or self._uncovers(gone)):
            return self.heir(_search(scene, tolerances, self.overlaps, before=self.found, absent=absent))
        overlaps = tuple(o for o in self.overlaps if gone.isdisjoint(o.bodies))
        kept = tuple(i for i in self.interfaces if gone.isdisjoint(i.bodies))
        occluded = tuple(pair for pair in self.occluded if gone.isdisjoint(pair))
        left = Assembly(scene, kept, tolerances, overlaps, occluded, self.detected, absent)
        if "found" in self.__dict__:
            left.__dict__["found"] = self.found.without(gone)
        return self.heir(left)

    def _uncovers(self, gone: Collection[str]) -> bool:
        """Tell whether one of the removed bodies may have hidden a contact between two remaining bodies.

        This is possible if it is near at least one of the two.
        """
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
        """Find the body of a hanging group that is nearest to a body outside the group.

        Returns (name inside, name outside, distance [m]), or None if there is no body outside.
        """
        return nearest_outside(self.bodies, group)


def assemble(
    scene: Scene,
    *,
    gap: float | None = None,
    angle_degrees: float | None = None,
    pose_sigma: float | tuple[float, float] | None = None,
    interfaces: Iterable[Interface] | None = None,
    allow_large: bool = False,
) -> Assembly:
    """Detect the contact interfaces of a scene, or take the given ones, and return the assembly.

    ``gap`` [m] is the largest distance or overlap at which two surfaces still touch, and ``angle_degrees`` the largest
    angle between two touching faces. By default both follow from the two bodies of each pair alone: a thousandth of
    their size, or what the scatter of scanned surfaces explains, and 1 degree, or more between scanned surfaces
    (``Tolerances.between``). What is given holds for all pairs. With a gap, the angle is 1 by default.

    ``pose_sigma`` is the standard deviation of the poses' positions [m], or a pair of those of positions [m] and
    rotations [deg]. The gap of each pair of bodies is then 4σ, including the displacement that a rotation causes at the
    far end of the larger body, but at most half the thickness of the thinner body. The angle is widened by 4σ. Give
    ``gap`` or ``pose_sigma``, not both.

    The ``flags`` of each interface say what in it depends on a tolerance, and ``certain`` is False where the bodies may
    not touch at all: with ``pose_sigma`` everywhere, else where only a wide gap closes the contact. Bodies that overlap
    by more than the gap raise a HoldfastWarning with their names and the depth.

    Given ``interfaces`` are taken as complete and are not checked against the meshes; those between two fixed bodies
    are left out.

    A body whose centre of mass lies outside of it by more than its size also causes a HoldfastWarning.

    If all movable bodies are as large as houses, the scene is probably in millimetres; it is refused unless
    ``allow_large`` confirms that its units are metres. Raises HoldfastError, too, if several bodies have the same shape
    and pose, if an argument is out of range, or if ``scene`` is not a Scene.
    """
    if not hasattr(scene, "movable"):
        problem = f"got a {type(scene).__name__}"
        raise HoldfastError(message("assemble", problem, "needs a Scene: hf.load_scene(path) reads one from a file"))
    if gap is not None and pose_sigma is not None:
        raise HoldfastError(
            message("assemble", f"gap = {quoted(gap)} and pose_sigma = {quoted(pose_sigma)}", "give one of them")
        )
    if interfaces is None:
        check_copies(scene)
    sigma = None if pose_sigma is None else checked_pose_sigma(pose_sigma, "assemble")
    tolerances = tolerances_of(scene, gap, angle_degrees, sigma)
    if not checked_truth(allow_large, "assemble: allow_large"):
        check_units(scene.movable)
    warn_of_bodies(scene.movable, None if tolerances.by_pair else tolerances.gap, allow_large=allow_large)
    if interfaces is not None:
        scene = with_notes(scene, doubts_of_scene(scene))
        return Assembly(scene, _given(scene, interfaces), tolerances, detected=False)
    return _search(scene, tolerances, ())


def _search(
    scene: Scene,
    tolerances: Tolerances,
    known: Collection[Overlap],
    *,
    before: FoundContacts | None = None,
    absent: tuple[str, ...] = (),
) -> Assembly:
    """Detect all contacts of the scene and return the assembly; warn of overlaps that are not among ``known``."""
    found = search(scene, tolerances, before)
    new = [overlap for overlap in found.overlaps if overlap not in known]
    warn_of_overlaps(new)
    scene = with_notes(scene, doubts_of_scene(scene, found.interfaces, new) if before is None else ())
    assembly = Assembly(scene, found.interfaces, tolerances, found.overlaps, found.occluded, absent=absent)
    assembly.__dict__["found"] = found
    return assembly


def checked_pose_sigma(value: object, where: str) -> tuple[float, float]:
    """Check ``pose_sigma`` and return the standard deviations of the poses' positions [m] and rotations [deg]."""
    both = value if isinstance(value, tuple | list) else (value, 0.0)
    if len(both) != 2:
        remedy = "needs metres, or a pair (metres, degrees)"
        raise HoldfastError(message(where, f"pose_sigma = {quoted(value)}", remedy))
    metres = checked_number(both[0], f"{where}: pose_sigma", above=0, within=TOLERANCE)
    return metres, checked_number(both[1], f"{where}: pose_sigma: rotation [deg]", minimum=0, within=ANGLE)


def body_forces(forces: Float) -> Float:
    """Return the wrenches (6J,) of forces (J, 3) [N] that act at the centres of mass."""
    return np.hstack([forces, np.zeros_like(forces)]).reshape(-1)


def _given(scene: Scene, interfaces: Iterable[Interface]) -> tuple[Interface, ...]:
    """Return the given interfaces, without those between two fixed bodies, which no query asks about."""
    kept = []
    for interface in checked_items(interfaces, "assemble: interfaces", "Interface objects"):
        if not hasattr(interface, "patches"):
            problem = f"interfaces holds a {type(interface).__name__}"
            raise SceneError(message("assemble", problem, "needs holdfast.answers.Interface objects"))
        a, b = (scene.body(name) for name in interface.bodies)
        if not (a.fixed and b.fixed):
            kept.append(interface)
    return tuple(kept)
