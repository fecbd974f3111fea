"""Contacts that bodies would have if they were a little closer: what might hold a body that seems to fall."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from holdfast.contacts.detect import box_distance, by_friction, find_patches, of_cuboids
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.skin import Skin
from holdfast.contacts.tolerances import Tolerances, reach
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

WIDE = 5.0  # [deg] angle between faces that would meet flat if a pose were a little off
GROWS = 1.2  # a contact that is larger by this factor at twice the angle lies on a curved surface, which rolls


@dataclass(frozen=True, eq=False)
class Nearby:
    """The contacts of a ``scene`` at gaps up to ``reach``, beyond its ``tolerances``.

    ``touching`` are the pairs of bodies that touch within the tolerances.
    """

    scene: Scene
    tolerances: Tolerances
    touching: Collection[frozenset[str]]
    _skins: dict[int, Skin] = field(default_factory=dict, init=False, repr=False)
    _known: dict[tuple[str, str, float, bool], tuple[Interface, ...]] = field(
        default_factory=dict, init=False, repr=False
    )

    def pairs(self, names: Collection[str], others: Collection[str]) -> list[tuple[Body, Body]]:
        """Return the pairs of one of the bodies ``names`` and any of these or ``others`` that come within reach."""
        inside, among = frozenset(names), frozenset((*names, *others))
        bodies = [body for body in self.scene.bodies if body.name in among]
        found = []
        for a in (body for body in bodies if body.name in inside):
            for b in bodies:
                new = b.name not in inside or a.name < b.name
                if new and box_distance(a, b) <= reach(a, b) and self.scene.touching(a, b):
                    found.append((a, b))
        return found

    def contacts(self, a: Body, b: Body, gap: float, *, wide: bool) -> tuple[Interface, ...]:
        """Return each patch of two bodies at ``gap`` [m], at most ``reach``, as an interface of its own.

        The angle is that of the pair, or WIDE. Where two bodies touch already, a wide angle finds no more of a curved
        surface: what rolls would else rest on the flank that it rolls over.
        """
        key = a.name, b.name, gap, wide
        if key not in self._known:
            own = self.tolerances.between(a, b)
            gap = min(max(gap, own.gap), max(reach(a, b), own.gap))
            angle = max(WIDE, own.angle) if wide else own.angle
            curved = wide and frozenset((a.name, b.name)) in self.touching
            found = []
            for one, two in self.scene.touching(a, b):
                patches = self._patches(one, two, gap, angle)
                if curved and _area(self._patches(one, two, gap, 2 * angle)) > GROWS * _area(patches):
                    continue
                for mu, share in by_friction(self.scene, one, two, patches, gap).items():
                    found += [Interface((a.name, b.name), patches=[patch], mu=mu) for patch in share]
            self._known[key] = tuple(found)
        return self._known[key]

    def _patches(self, a: Body, b: Body, gap: float, angle: float) -> tuple[Patch, ...]:
        depth = self.tolerances.between(self.scene.body(a.name), self.scene.body(b.name)).depth
        own = Tolerances(gap, angle, depth=depth)
        known = of_cuboids([(a, b)], [own])[0]
        if known is not None:
            return known
        for body in (a, b):
            if id(body) not in self._skins:
                self._skins[id(body)] = Skin.of(body)
        return find_patches(a, b, self._skins[id(a)], self._skins[id(b)], own)


def _area(patches: tuple[Patch, ...]) -> float:
    return sum(patch.area for patch in patches)
