"""A single group of an assembly as an assembly of its own, in an order that depends on geometry alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.axes import by_place, own_frame
from holdfast.base.arrays import Bool, Int, frozen
from holdfast.base.memory import Same
from holdfast.contacts.interface import Interface, canonical
from holdfast.contacts.overlap import Overlap
from holdfast.scene.body import Body, materials_of
from holdfast.scene.excluded import Excluded, excluded_among
from holdfast.scene.friction import Friction
from holdfast.scene.hold import AnyHold, held_names, holds_among
from holdfast.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Part:
    """The bodies of one group and the fixed bodies that they touch, as an assembly of their own.

    Nothing in ``assembly`` depends on the bodies outside the group, nor on the names of the bodies and their order in
    the scene: bodies and interfaces are in canonical order, and every interface points from the lower body of the
    canonical order to the higher one. So an answer for the part is the same, to the last digit, whatever else is in the
    scene and in whatever order the bodies were given. The order is determined in the frame of the group (axes.py), so
    that it does not depend on the axes of the world either.

    ``members`` (K,) are the numbers of its movable bodies in the whole assembly, in the order of the part.
    ``interfaces`` (I,) are the numbers of its interfaces in the whole assembly, and ``flipped`` (I,) tells which of
    them point the other way there. ``content`` is a key for everything on which answers for the part depend: after an
    edit of the assembly that does not change the group, the part has an equal key.
    """

    assembly: Assembly
    members: Int
    interfaces: Int
    flipped: Bool
    content: Same

    @cached_property
    def rows(self) -> Int:
        """The rows (6K,) of the part's bodies in wrenches and load columns of the whole assembly."""
        return np.asarray(frozen((6 * self.members[:, None] + np.arange(6)).ravel()))


@dataclass(frozen=True, eq=False)
class _Canonical:
    """A group in canonical form: its ``assembly``, and the origin of its bodies and interfaces.

    ``order`` (K,), ``interfaces`` (I,) and ``flipped`` (I,) are as the ``members``, ``interfaces`` and ``flipped`` of a
    ``Part``, but with numbers within the group, in the order of the whole assembly.
    """

    assembly: Assembly
    order: Int
    interfaces: Int
    flipped: Bool


def part_of(whole: Assembly, group: tuple[str, ...]) -> Part:
    """Return the part of the assembly ``whole`` that consists of one of its groups, given by the names of its bodies.

    At least one body of the group touches a fixed body or is held. The part is cached in the assembly. Its content is
    cached in the memory that the assembly shares with its edits, and is the same object as long as nothing in it
    changes.
    """
    part: Part | None = whole.parts.get(group)
    if part is None:
        part = whole.parts[group] = _part(whole, group)
    return part


def _part(whole: Assembly, group: tuple[str, ...]) -> Part:
    given = np.array([whole.index[name] for name in group])
    chosen = sorted({k for number in given.tolist() for k in whole.interfaces_of[number]})
    names = set(group)
    overlaps = tuple(o for o in whole.overlaps if not names.isdisjoint(o.bodies) and _still(whole, o.bodies, names))
    occluded = tuple(p for p in whole.occluded if not names.isdisjoint(p) and _still(whole, p, names))
    pairs = (*(whole.interfaces[k].bodies for k in chosen), *(o.bodies for o in overlaps), *occluded)
    holds = holds_among(whole.scene.holds, names, [body.name for body in whole.fixed])
    touched = ({name for pair in pairs for name in pair} | held_names(holds)) - names
    still = [body for body in whole.fixed if body.name in touched] or list(whole.fixed[:1])  # if it is held in the air
    moving = [whole.movable[k] for k in given.tolist()]
    interfaces = [whole.interfaces[k] for k in chosen]
    named = {body.name for body in (*still, *moving)}
    table = whole.scene.friction.among(named | materials_of([*still, *moving]))
    excluded = excluded_among(whole.scene.excluded, named)
    about = (whole.scene.gravity.tobytes(), whole.scene.name, whole.tolerances.rule, whole.detected)
    key = (*map(Same, (*still, *moving, *interfaces)), overlaps, occluded, table, excluded, holds, *about)

    def canonical() -> _Canonical:
        return _canonical(whole, still, moving, interfaces, (overlaps, occluded, table, excluded, holds))

    content = whole.memory.recalled(("part", *key), len(group), canonical)
    assembly = content.assembly
    if assembly.absent != whole.known_names:
        assembly = replace(assembly, absent=whole.known_names)
    return Part(
        assembly,
        np.asarray(frozen(given[content.order])),
        np.asarray(frozen(np.array(chosen, dtype=np.int64)[content.interfaces])),
        content.flipped,
        Same(content),
    )


def _canonical(
    whole: Assembly,
    still: list[Body],
    moving: list[Body],
    interfaces: list[Interface],
    about: tuple[tuple[Overlap, ...], tuple[tuple[str, str], ...], Friction, tuple[Excluded, ...], tuple[AnyHold, ...]],
) -> _Canonical:
    """Return the canonical form of a group of ``moving`` bodies and the fixed bodies ``still`` that they touch."""
    up = whole.scene.up
    frame = own_frame(moving, up)
    com = np.array([body.com_world for body in moving])
    order = by_place(com, np.array([body.mass for body in moving], dtype=np.float64), up, frame.axes)
    rank = {moving[k].name: place for place, k in enumerate(order.tolist())}
    ranks = [tuple(rank.get(name, FIXED) for name in interface.bodies) for interface in interfaces]
    flipped = [a > b for a, b in ranks]
    same = canonical(interfaces, flipped, frame)
    places = frame.seen(np.array([one.patches[0].centroid for one in same]).reshape(-1, 3)).tolist()
    keys = [(min(ranks[k]), max(ranks[k]), float(one.area), places[k], k) for k, one in enumerate(same)]
    kept = np.array([key[-1] for key in sorted(keys)], dtype=np.int64)
    overlaps, occluded, table, excluded, holds = about
    bodies = [*still, *(moving[k] for k in order.tolist())]
    scene = Scene(bodies, table, whole.scene.gravity, whole.scene.name, excluded, holds=holds)
    part = Assembly(
        scene,
        tuple(same[k] for k in kept.tolist()),
        whole.tolerances.on(scene),
        overlaps,
        occluded,
        whole.detected,
        whole.known_names,
    )
    part.__dict__["axes"] = frame.axes
    return _Canonical(
        part,
        order,
        kept,
        np.asarray(frozen(np.array(flipped, dtype=bool)[kept])),
    )


def _still(whole: Assembly, pair: tuple[str, str], names: set[str]) -> bool:
    """Tell whether both bodies of a pair are in the group or fixed."""
    return all(name in names or whole.index[name] == FIXED for name in pair)
