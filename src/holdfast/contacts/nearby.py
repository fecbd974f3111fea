"""Contacts that bodies would have if they were a little closer, and that might hold a body that seems to fall."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from holdfast.base.arrays import Float
from holdfast.contacts.contact_search import by_friction
from holdfast.contacts.detect import find_patches
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.search_mesh import SearchMesh
from holdfast.contacts.tolerances import DOUBTFUL_GAP, Tolerances, doubtful_gap
from holdfast.contacts.without_triangles import of_cuboids
from holdfast.geometry.polygon import MANY
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene

WIDE = 5.0  # [deg] angle between faces that would be parallel if the poses were slightly different
MOST_PIECES = 2 * MANY  # pairs of triangles that may meet between two bodies: 1,600 in scans of bowls, 9,700 of needles
GROWS = 1.2  # a contact whose area grows by this factor at twice the angle is on a curved surface, which can roll


@dataclass(frozen=True, eq=False)
class Nearby:
    """The contacts of a ``scene`` at gaps beyond its ``tolerances``, up to ``doubtful_gap``.

    ``touching`` are the pairs of bodies that touch within the tolerances.
    """

    scene: Scene
    tolerances: Tolerances
    touching: Collection[frozenset[str]]
    _beside: dict[str, list[Body]] = field(default_factory=dict, init=False, repr=False)
    _meshes: dict[int, SearchMesh] = field(default_factory=dict, init=False, repr=False)
    _known: dict[tuple[str, str, float, bool], tuple[Interface, ...]] = field(
        default_factory=dict, init=False, repr=False
    )

    @cached_property
    def _boxes(self) -> Float:
        """The bounding boxes (n, 2, 3) of all bodies."""
        return np.array([body.box for body in self.scene.bodies])

    def beside(self, name: str) -> list[Body]:
        """Return the bodies within ``doubtful_gap`` of this one that may touch it, in the order of the scene."""
        if name not in self._beside:
            body = self.scene.body(name)
            low, high = self._boxes[:, 0], self._boxes[:, 1]
            apart = np.linalg.norm(np.maximum(np.maximum(low - body.box[1], body.box[0] - high), 0), axis=1)
            near = [(self.scene.bodies[k], float(apart[k])) for k in np.flatnonzero(apart <= DOUBTFUL_GAP)]
            self._beside[name] = [
                other
                for other, gap in near
                if other.name != name and gap <= doubtful_gap(body, other) and self.scene.touching(body, other)
            ]
        return self._beside[name]

    def pairs(self, names: Collection[str], others: Collection[str]) -> list[tuple[Body, Body]]:
        """Return the pairs of a body in ``names`` and one in ``names`` or ``others`` within ``doubtful_gap``."""
        inside = {name for name in names if name in self.scene.names}
        found = [(self.scene.body(name), other) for name in inside for other in self.beside(name)]
        found = [(a, b) for a, b in found if (a.name < b.name if b.name in inside else b.name in others)]
        return sorted(found, key=lambda pair: [self._place[body.name] for body in pair])

    @cached_property
    def _place(self) -> dict[str, int]:
        return {body.name: k for k, body in enumerate(self.scene.bodies)}

    def contacts(self, a: Body, b: Body, gap: float, *, wide: bool) -> tuple[Interface, ...]:
        """Return each patch of two bodies at ``gap`` [m], limited to ``doubtful_gap``, as an interface of its own.

        The angle tolerance is that of the pair or, if ``wide``, at least WIDE. If the bodies touch already, a wide
        angle does not count on curved surfaces: otherwise a body that can roll would seem to rest on its side. Raises
        TooFineError if more than MOST_PIECES pairs of their triangles meet.
        """
        key = a.name, b.name, gap, wide
        if key not in self._known:
            own = self.tolerances.between(a, b)
            gap = min(max(gap, own.gap), max(doubtful_gap(a, b), own.gap))
            angle = max(WIDE, own.angle) if wide else own.angle
            curved = wide and None in (a.cuboid, b.cuboid) and frozenset((a.name, b.name)) in self.touching
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
        return find_patches(a, b, self._meshes[id(a)], self._meshes[id(b)], own, MOST_PIECES)


def _area(patches: tuple[Patch, ...]) -> float:
    return sum(patch.area for patch in patches)
