"""All interfaces and overlaps of a scene, with flags that warn of what depends on a tolerance, a pose or a mesh.

A search reuses earlier results between bodies that have not changed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from holdfast.base.public import Record
from holdfast.base.values import made
from holdfast.contacts.compound_parts import by_material
from holdfast.contacts.detect import Touching, find_all_patches
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.merging import merged
from holdfast.contacts.neighbours import near_pairs
from holdfast.contacts.occlusion import Fronts, Pair
from holdfast.contacts.overlap import Overlap, find_overlaps
from holdfast.contacts.patches import NEGLIGIBLE_WIDTH
from holdfast.contacts.tolerances import Tolerances
from holdfast.geometry.distance import distance_to_surface
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound
from holdfast.scene.scene import Scene

SHAKY = 0.5  # separation or depth, relative to the gap, above which another gap may give another contact
DOUBTFUL = frozenset({"ambiguous_gap", "fragile", "sliver", "occluded"})  # flags of contacts that may not exist
EXACT = 1e-3  # separation, relative to the gap, up to which surfaces touch exactly, up to rounding
ALIKE = float(np.cos(np.radians(20)))  # cosine of the largest angle between a patch and the triangle on which it lies
FRAGILE = 0.5  # least share of the face area that remains when a body is moved sideways by the gap


class Contacts(Record):
    """The interfaces of a scene, and the ``occluded`` pairs, which would touch if no third body lay between them."""

    interfaces: tuple[Interface, ...]
    occluded: tuple[tuple[str, str], ...]


class Shown(NamedTuple):
    """Where two bodies are ``touching``, what third bodies have ``left`` of that, and the resulting ``interfaces``.

    ``left`` holds the remaining patches of each of ``touching.parts``. If nothing is left, there are no interfaces.
    """

    touching: Touching
    left: tuple[tuple[Patch, ...], ...]
    interfaces: tuple[Interface, ...]


@dataclass(frozen=True, eq=False)
class FoundContacts:
    """The contacts and overlaps of a scene with these ``bodies`` (by name), at these ``tolerances``.

    ``patches`` holds where each pair of bodies would touch if there were no third bodies, ``shown`` what third bodies
    leave of that, and ``by_pair`` the interfaces with their status. Pairs are in the order of the bodies.
    """

    tolerances: Tolerances
    bodies: Mapping[str, Body]
    overlaps: tuple[Overlap, ...]
    patches: Mapping[Pair, Touching]
    shown: Mapping[Pair, Shown]
    by_pair: Mapping[Pair, tuple[Interface, ...]]

    @property
    def interfaces(self) -> tuple[Interface, ...]:
        """All interfaces."""
        return tuple(interface for several in self.by_pair.values() for interface in several)

    @property
    def occluded(self) -> tuple[Pair, ...]:
        """The pairs that would touch if no third body lay between them."""
        return tuple(pair for pair, shown in self.shown.items() if not shown.interfaces)

    def without(self, gone: Collection[str]) -> FoundContacts:
        """Return the same without the bodies ``gone``, none of which may have hidden a contact of two others."""
        return FoundContacts(
            self.tolerances,
            {name: body for name, body in self.bodies.items() if name not in gone},
            tuple(o for o in self.overlaps if not any(name in gone for name in o.bodies)),
            {pair: part for pair, part in self.patches.items() if not any(name in gone for name in pair)},
            {pair: part for pair, part in self.shown.items() if not any(name in gone for name in pair)},
            {pair: part for pair, part in self.by_pair.items() if not any(name in gone for name in pair)},
        )


def search(scene: Scene, tolerances: Tolerances, before: FoundContacts | None = None) -> FoundContacts:
    """Find all contacts and overlaps of a scene; the result does not depend on ``before``, which only saves time.

    The earlier result between two bodies is reused if both are the same objects and the tolerances are unchanged. An
    interface stays the same object if third bodies leave the same patches visible as before.
    """
    if before is None or tolerances.rule != before.tolerances.rule:
        before = FoundContacts(tolerances, {}, (), {}, {}, {})
    same = {body.name for body in scene.bodies if before.bodies.get(body.name) is body}
    near = near_pairs(scene, tolerances, tolerances.widest(scene), same)
    overlaps = find_overlaps(scene, tolerances, before.overlaps, same, near=near)
    patches = find_all_patches(scene, near, before.patches, same)
    both = {**patches, **before.patches}
    changed = {name for pair in both for name in pair if patches.get(pair) is not before.patches.get(pair)}
    shown = show(scene, tolerances, patches, before.shown, changed)
    deep = {overlap.bodies for overlap in overlaps}
    by_pair: dict[Pair, tuple[Interface, ...]] = {}
    for pair, contact in shown.items():
        if before.shown.get(pair) is contact:
            by_pair[pair] = before.by_pair[pair]
        elif pair in deep:
            by_pair[pair] = tuple(replace(interface, status="penetrating") for interface in contact.interfaces)
        else:
            by_pair[pair] = contact.interfaces
    bodies = {body.name: body for body in scene.bodies}
    return FoundContacts(tolerances, bodies, overlaps, patches, shown, by_pair)


def find_contacts(scene: Scene, tolerances: Tolerances, *, merge: bool = True) -> Contacts:
    """Find all interfaces between bodies of which at least one is movable, in the order of the bodies.

    If poses are uncertain, no interface is certain. Many patches between two bodies are merged into few, unless
    ``merge`` is False.
    """
    near = near_pairs(scene, tolerances, tolerances.widest(scene))
    shown = show(scene, tolerances, find_all_patches(scene, near), {}, frozenset(), merge=merge)
    return Contacts(
        tuple(interface for each in shown.values() for interface in each.interfaces),
        tuple(pair for pair, each in shown.items() if not each.interfaces),
    )


def show(
    scene: Scene,
    tolerances: Tolerances,
    found: Mapping[Pair, Touching],
    known: Mapping[Pair, Shown],
    changed: Set[str],
    *,
    merge: bool = True,
) -> dict[Pair, Shown]:
    """Return the interfaces of pairs of bodies that touch, without what third bodies hide.

    ``known`` is an earlier result; only bodies named in ``changed`` have other patches than then. If the visible
    patches of a pair are the same as before, its interfaces are the same objects. ``merge`` is as in ``find_contacts``.
    """
    result: dict[Pair, Shown] = {}
    fronts = Fronts({pair: touching.patches for pair, touching in found.items()})
    bodies = {body.name: body for body in scene.bodies}
    for pair, touching in found.items():
        before = known.get(pair)
        if before is None or before.touching is not touching:
            before = None
        elif pair[0] not in changed and pair[1] not in changed:
            result[pair] = before
            continue
        a, b = bodies[pair[0]], bodies[pair[1]]
        gap, width = touching.limits.own.gap, NEGLIGIBLE_WIDTH * min(a.size, b.size)
        left = tuple([fronts.visible(patches, pair, gap, width) for *_, patches in touching.parts])
        if before is not None and left == before.left:
            result[pair] = before
        else:
            found_now = _interfaces(scene, (a, b), touching, left, posed=not tolerances.capped, merge=merge)
            result[pair] = Shown(touching, left, found_now)
    return result


def _interfaces(
    scene: Scene,
    bodies: tuple[Body, Body],
    touching: Touching,
    left: tuple[tuple[Patch, ...], ...],
    *,
    posed: bool,
    merge: bool,
) -> tuple[Interface, ...]:
    """Return the interfaces of two ``bodies`` that are ``touching``; ``left`` are the patches that are not hidden.

    ``posed`` says that the poses are as given.
    """
    rest = left[0] if len(left) == 1 else tuple(patch for patches in left for patch in patches)
    if not rest:
        return ()
    a, b = bodies
    own, base, usual, sagitta = touching.limits
    flags = flags_of(a, b, rest, own.gap, hidden=rest != touching.patches)
    certain = posed and is_certain(rest, flags, gap=base, usual=usual, sagitta=sagitta)
    shares: dict[float | None, list[Patch]] = {}
    if _mixed(a) or _mixed(b):
        for (one, two, _), patches in zip(touching.parts, left, strict=True):
            for mu, piece in by_friction(scene, one, two, patches, own.gap).items():
                shares.setdefault(mu, []).extend(piece)
    else:
        shares[None] = list(rest)
    pair = a.name, b.name
    interfaces = []
    for mu, share in shares.items():
        few = merged(share, own.gap, own.angle) if merge else tuple(share)
        more = (*flags, "merged") if any(patch.spots is not None for patch in few) else flags
        found = made(Interface, bodies=pair, patches=few, status="touching", flags=more, certain=certain, mu=mu)
        interfaces.append(found)
    return tuple(interfaces)


def by_friction(
    scene: Scene, a: Body, b: Body, patches: Sequence[Patch], gap: float
) -> dict[float | None, list[Patch]]:
    """Return the patches by friction coefficient; the key is None where the coefficient of the two bodies holds."""
    if not patches or not (_mixed(a) or _mixed(b)):
        return {None: list(patches)} if patches else {}
    found: dict[float | None, list[Patch]] = {}
    for (of_a, of_b), piece in by_material(a, b, patches, gap).items():
        mu = scene.friction.between(a.name, b.name, {a.name: of_a, b.name: of_b})
        found.setdefault(mu, []).extend(piece)
    return found


def _mixed(body: Body) -> bool:
    """Tell whether a part of a body is not of its material."""
    return isinstance(body.shape, Compound) and {*body.materials} != {body.material}


def flags_of(a: Body, b: Body, patches: Sequence[Patch], gap: float, *, hidden: bool) -> tuple[str, ...]:
    """Return the flags of the interface of two bodies.

    ``patches`` are what remains after occlusion, and ``hidden`` says whether a third body hides a part.

    - sliver: every patch is narrower than the gap or lies within the gap of a sharp edge, so the bodies may separate if
      one is moved sideways by the gap.
    - fragile: the bodies may lose half of the contact area if one is moved sideways by the gap.
    - ambiguous_gap: surfaces are somewhere further apart, or overlap by more, than half the gap, so another gap gives
      another interface.
    - facet: a face lies on a facet that represents a curved surface, or a line lies on such a facet of a mesh. If the
      real surface is smooth, it touches elsewhere, along a line or at a point, and the body may roll.
    - occluded: a third body between the two hides a part.
    - not_manifold: a surface is not closed, so the overlap is estimated.
    - orientation_unknown: it is not known which side of a surface is the inside.
    """
    flags = []
    faces = kept = widest = farthest = 0.0
    for patch in patches:
        room = patch.room
        widest = max(widest, room)
        if patch.kind == "face":
            area = patch.area
            faces += area
            kept += area * max(0.0, 1 - gap / room)
        if patch.separation is not None:
            low, high = patch.separation
            farthest = max(farthest, abs(low), abs(high))
    if widest < gap:
        flags.append("sliver")
    if kept < FRAGILE * faces or (not faces and widest < gap / FRAGILE):
        flags.append("fragile")
    if farthest > SHAKY * gap:
        flags.append("ambiguous_gap")
    if _on_facet(a, patches, 1.0) or _on_facet(b, patches, -1.0):
        flags.append("facet")
    if hidden:
        flags.append("occluded")
    one, two = a.shape.surface, b.shape.surface
    if not (one.closed and two.closed):
        flags.append("not_manifold")
    if not (one.oriented and two.oriented):
        flags.append("orientation_unknown")
    return tuple(flags)


def _on_facet(body: Body, patches: Sequence[Patch], outward: float) -> bool:
    """Tell whether the middle of a face, or of a line on a mesh, lies on a triangle that represents a curved surface.

    Lines on shapes with a known sagitta are exact and do not count. ``outward`` is 1 if the normals of the patches
    point out of the body, and -1 if they point into it.
    """
    surface = body.shape.surface
    if not surface.bends:
        return False
    for patch in patches:
        if patch.kind != "face" and (patch.kind != "line" or surface.sagitta > 0):
            continue
        alike = outward * (surface.normals @ (patch.normal @ body.pose[:3, :3])) >= ALIKE
        if (alike & surface.curved).any():
            middle = ((patch.polygon.mean(0) - body.pose[:3, 3]) @ body.pose[:3, :3])[None]
            curved, flat = (
                distance_to_surface(middle, replace(surface, faces=surface.faces[alike & which]))
                for which in (surface.curved, ~surface.curved)
            )
            if curved[0] < flat[0]:
                return True
    return False


def is_certain(patches: Sequence[Patch], flags: Sequence[str], *, gap: float, usual: float, sagitta: float) -> bool:
    """Tell whether two bodies certainly touch, if their poses are as given.

    ``gap`` is the gap of the search and ``usual`` the default gap of the scene; ``sagitta`` is how far the meshes of
    the two bodies may lie inside their true surfaces, all [m]. The bodies may not touch if they are further apart than
    the default gap accepts, or if one of the flags DOUBTFUL is set. Flags do not count if the surfaces touch exactly
    and the gap is not wider than the default, because such a gap only allows for rounding.
    """
    apart = min((patch.separation[0] for patch in patches if patch.separation is not None), default=0.0) - sagitta
    if apart > usual:
        return False
    return DOUBTFUL.isdisjoint(flags) or (gap <= usual and apart <= EXACT * gap)
