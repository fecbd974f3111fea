"""One group of an assembly as an assembly of its own, in an order that depends on geometry alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.axes import by_place, own_frame
from holdfast.base.arrays import Bool, Int, frozen
from holdfast.base.rigid import Frame
from holdfast.contacts.interface import Interface
from holdfast.scene.body import materials_of
from holdfast.scene.excluded import excluded_among
from holdfast.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Part:
    """The bodies of one group and the fixed bodies that they touch, as an assembly of their own.

    Nothing in ``assembly`` depends on the bodies outside the group, nor on the names of the bodies and their order in
    the scene: bodies and interfaces are in canonical order, and every interface points from the lower body of the
    canonical order to the higher one. So an answer on the part is the same, to the last digit, whatever else the scene
    holds, and rounding is the same in whatever order the bodies were given. What decides the order is seen in the
    group's own frame (axes.py), so that it does not depend on the axes of the world either.

    ``members`` (K,) are the numbers of its movable bodies in the whole assembly, in the order of the part.
    ``interfaces`` (I,) are the numbers of its interfaces in the whole assembly, and ``flipped`` (I,) tells which of
    them point the other way there.
    """

    assembly: Assembly
    members: Int
    interfaces: Int
    flipped: Bool

    @cached_property
    def rows(self) -> Int:
        """The rows (6K,) of the part's bodies in wrenches and load columns of the whole assembly."""
        return np.asarray(frozen((6 * self.members[:, None] + np.arange(6)).ravel()))


def part_of(whole: Assembly, group: tuple[str, ...]) -> Part:
    """Return the part of the assembly ``whole`` that consists of one of its groups, given by the names of its bodies.

    At least one body of the group touches a fixed body.
    """
    names = set(group)
    given = np.array([whole.index[name] for name in group])
    frame = own_frame([whole.movable[k] for k in given.tolist()], whole.scene.up)
    members = given[by_place(whole.com[given], whole.mass[given], whole.scene.up, frame.axes)]
    rank = {whole.movable[k].name: place for place, k in enumerate(members.tolist())}
    chosen = [(k, i) for k, i in enumerate(whole.interfaces) if not names.isdisjoint(i.bodies)]
    turned = [rank.get(i.bodies[0], FIXED) > rank.get(i.bodies[1], FIXED) for _, i in chosen]
    written = [i.canonical(frame, flipped=turn) for (_, i), turn in zip(chosen, turned, strict=True)]
    found = [(*_place(i, rank, frame), k, turn, i) for i, (k, _), turn in zip(written, chosen, turned, strict=True)]
    found.sort(key=lambda entry: entry[:-1])
    touched = {name for _, i in chosen for name in i.bodies} - names
    overlaps = tuple(o for o in whole.overlaps if not names.isdisjoint(o.bodies) and _still(whole, o.bodies, names))
    occluded = tuple(p for p in whole.occluded if not names.isdisjoint(p) and _still(whole, p, names))
    touched |= {name for pair in (*(o.bodies for o in overlaps), *occluded) for name in pair} - names
    bodies = [body for body in whole.bodies if body.name in touched]
    bodies += [whole.movable[k] for k in members.tolist()]
    named = {body.name for body in bodies}
    table = whole.scene.friction.among(named | materials_of(bodies))
    excluded = excluded_among(whole.scene.excluded, named)
    scene = Scene(bodies, table, whole.scene.gravity, whole.scene.name, excluded)
    interfaces = tuple(entry[-1] for entry in found)
    return Part(
        Assembly(scene, interfaces, whole.tolerances, overlaps, occluded, whole.detected, whole.known_names),
        np.asarray(frozen(members)),
        np.asarray(frozen(np.array([entry[-3] for entry in found], dtype=np.int64))),
        np.asarray(frozen(np.array([entry[-2] for entry in found], dtype=bool))),
    )


def _still(whole: Assembly, pair: tuple[str, str], names: set[str]) -> bool:
    """Tell whether both bodies of a pair are of the group or fixed."""
    return all(name in names or whole.index[name] == FIXED for name in pair)


def _place(
    interface: Interface, rank: dict[str, int], frame: Frame
) -> tuple[tuple[int, int], float, tuple[float, ...]]:
    """Return what orders interfaces: the places of their bodies, then area and place of their first patch."""
    a, b = (rank.get(name, FIXED) for name in interface.bodies)
    patch = interface.patches[0]
    return (a, b), float(interface.area), tuple(frame.seen(patch.centroid).tolist())
