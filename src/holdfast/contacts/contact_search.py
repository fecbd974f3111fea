"""The search for all contacts and overlaps of a scene, which reuses earlier results between unchanged bodies."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from holdfast.contacts.detect import Shown, Touching, find_all_patches, near_pairs, show
from holdfast.contacts.interface import Interface
from holdfast.contacts.occlusion import Pair
from holdfast.contacts.overlap import Overlap, find_overlaps
from holdfast.contacts.tolerances import Tolerances
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Found:
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

    def without(self, gone: Collection[str]) -> Found:
        """Return the same without the bodies ``gone``, none of which may have hidden a contact of two others."""
        return Found(
            self.tolerances,
            {name: body for name, body in self.bodies.items() if name not in gone},
            tuple(o for o in self.overlaps if not any(name in gone for name in o.bodies)),
            {pair: part for pair, part in self.patches.items() if not any(name in gone for name in pair)},
            {pair: part for pair, part in self.shown.items() if not any(name in gone for name in pair)},
            {pair: part for pair, part in self.by_pair.items() if not any(name in gone for name in pair)},
        )


def search(scene: Scene, tolerances: Tolerances, before: Found | None = None) -> Found:
    """Find all contacts and overlaps of a scene; the result does not depend on ``before``, which only saves time.

    The earlier result between two bodies is reused if both are the same objects and the tolerances are unchanged. An
    interface stays the same object if third bodies leave the same patches visible as before.
    """
    if before is not None and tolerances.rule != before.tolerances.rule:
        before = None
    same = () if before is None else {body.name for body in scene.bodies if before.bodies.get(body.name) is body}
    near = near_pairs(scene, tolerances, tolerances.widest(scene), same)
    if before is None:
        overlaps = find_overlaps(scene, tolerances, near=near)
        patches = find_all_patches(scene, tolerances, near=near)
        shown = show(scene, tolerances, patches)
    else:
        overlaps = find_overlaps(scene, tolerances, before.overlaps, same, near=near)
        patches = find_all_patches(scene, tolerances, before.patches, same, near)
        shown = show(scene, tolerances, patches, before.shown, _changed(patches, before.patches))
    deep = {overlap.bodies for overlap in overlaps}
    by_pair: dict[Pair, tuple[Interface, ...]] = {}
    for pair, contact in shown.items():
        if before is not None and before.shown.get(pair) is contact:
            by_pair[pair] = before.by_pair[pair]
        else:
            by_pair[pair] = (
                tuple(replace(interface, status="penetrating") for interface in contact.interfaces)
                if pair in deep
                else contact.interfaces
            )
    bodies = {body.name: body for body in scene.bodies}
    return Found(tolerances, bodies, overlaps, patches, shown, by_pair)


def _changed(now: Mapping[Pair, Touching], before: Mapping[Pair, Touching]) -> set[str]:
    """Return the names of the bodies that have other patches now than before."""
    return {name for pair in {**now, **before} for name in pair if now.get(pair) is not before.get(pair)}
