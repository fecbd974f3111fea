"""Contacts that bodies would have if they were a little closer, and that might hold a body that seems to fall."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

from holdfast.contacts.detect import box_distance, by_friction, find_patches, of_cuboids
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import Tolerances, doubtful_gap
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

WIDE = 5.0  # [deg] angle between faces that would be parallel if the poses were slightly different
GROWS = 1.2  # a contact whose area grows by this factor at twice the angle is on a curved surface, which can roll


@dataclass(frozen=True, eq=False)
class Nearby:
    """The contacts of a ``scene`` at gaps beyond its ``tolerances``, up to ``doubtful_gap``.

    ``touching`` are the pairs of bodies that touch within the tolerances.
    """

    scene: Scene
    tolerances: Tolerances
    touching: Collection[frozenset[str]]
    _meshes: dict[int, SearchMesh] = field(default_factory=dict, init=False, repr=False)
    _known: dict[tuple[str, str, float, bool], tuple[Interface, ...]] = field(
        default_factory=dict, init=False, repr=False
    )

    def pairs(self, names: Collection[str], others: Collection[str]) -> list[tuple[Body, Body]]:
        """Return the pairs of a body in ``names`` and one in ``names`` or ``others`` within ``doubtful_gap``."""
        inside, among = frozenset(names), frozenset((*names, *others))
        bodies = [body for body in self.scene.bodies if body.name in among]
        found = []
        for a in (body for body in bodies if body.name in inside):
            for b in bodies:
                new = b.name not in inside or a.name < b.name
                if new and box_distance(a, b) <= doubtful_gap(a, b) and self.scene.touching(a, b):
                    found.append((a, b))
        return found

    def contacts(self, a: Body, b: Body, gap: float, *, wide: bool) -> tuple[Interface, ...]:
        """Return each patch of two bodies at ``gap`` [m], limited to ``doubtful_gap``, as an interface of its own.

        The angle tolerance is that of the pair or, if ``wide``, at least WIDE. If the bodies touch already, a wide
        angle does not count on curved surfaces: otherwise a body that can roll would seem to rest on its side.
        """
        key = a.name, b.name, gap, wide
        if key not in self._known:
            own = self.tolerances.between(a, b)
            gap = min(max(gap, own.gap), max(doubtful_gap(a, b), own.gap))
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
            if id(body) not in self._meshes:
                self._meshes[id(body)] = SearchMesh.of(body)
        return find_patches(a, b, self._meshes[id(a)], self._meshes[id(b)], own)


def _area(patches: tuple[Patch, ...]) -> float:
    return sum(patch.area for patch in patches)
