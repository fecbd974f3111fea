"""The straight way out of every body, checked against the meshes of all others."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.geometry.sweep import Swept, hit_distance


class Exits:
    """What stands in a body's way along the unit vector ``direction`` (3,), and how far off [m].

    Bodies stay where they are until they go, so each pair is looked at once. Two surfaces may lie within the contact
    tolerance of their pair, sideways and ahead: walls that it slides along are not in its way.
    """

    def __init__(self, assembly: Assembly, direction: Float) -> None:
        self.assembly, self.direction = assembly, direction
        self._found: dict[str, tuple[tuple[str, float], ...]] = {}

    @cached_property
    def _swept(self) -> dict[str, Swept]:
        return {body.name: Swept(body.reduced_world, self.direction) for body in self.assembly.bodies}

    @cached_property
    def _boxes(self) -> tuple[Float, Float]:
        """Lowest and highest coordinates (n, 3) of all bodies across and along the direction."""
        swept = self._swept.values()
        return np.array([s.low for s in swept]), np.array([s.high for s in swept])

    def in_the_way(self, name: str) -> tuple[tuple[str, float], ...]:
        """All bodies of the assembly that ``name`` would run into, each with its distance [m]; nearest first."""
        if name not in self._found:
            self._found[name] = self._search(name)
        return self._found[name]

    def blockers(self, name: str, remaining: Collection[str]) -> tuple[tuple[str, float], ...]:
        """The same, of the bodies that remain and of the fixed ones."""
        fixed = self._fixed
        return tuple(hit for hit in self.in_the_way(name) if hit[0] in remaining or hit[0] in fixed)

    @cached_property
    def _fixed(self) -> set[str]:
        return {body.name for body in self.assembly.bodies if body.fixed}

    def _search(self, name: str) -> tuple[tuple[str, float], ...]:
        bodies, index = self.assembly.bodies, list(self._swept).index(name)
        low, high = self._boxes
        beside = ((low[:, :2] < high[index, :2]) & (low[index, :2] < high[:, :2])).all(1)
        slack = self.assembly.tolerances.widest(self.assembly.scene)
        ahead = high[:, 2] >= low[index, 2] - slack
        found = []
        for k in np.flatnonzero(beside & ahead).tolist():
            if k == index:
                continue
            tolerance = self.assembly.tolerances.between(bodies[index], bodies[k]).depth
            distance = hit_distance(self._swept[name], self._swept[bodies[k].name], tolerance)
            if np.isfinite(distance):
                found.append((bodies[k].name, distance))
        return tuple(sorted(found, key=lambda hit: hit[1]))
