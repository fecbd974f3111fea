"""Check the straight way out of every body against the meshes of all other bodies."""

from __future__ import annotations

from collections.abc import Collection
from functools import cached_property

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.geometry.sweep import Swept, hit_distance


class Exits:
    """The obstacles on each body's straight way out along the unit vector ``direction`` (3,), with their distances [m].

    Bodies stay in place until they are taken out, so each pair is checked only once. Two surfaces may overlap by the
    contact tolerance of their pair, so a wall along which a body slides is not an obstacle.
    """

    def __init__(self, assembly: Assembly, direction: Float) -> None:
        self.assembly, self.direction = assembly, direction
        self._found: dict[str, tuple[tuple[str, float], ...]] = {}

    @cached_property
    def _swept(self) -> dict[str, Swept]:
        return {body.name: Swept(body.reduced_world, self.direction) for body in self.assembly.bodies}

    @cached_property
    def _boxes(self) -> tuple[Float, Float]:
        """The lowest and highest coordinates (n, 3) [m] of all bodies, across and along the direction."""
        swept = self._swept.values()
        return np.array([s.low for s in swept]), np.array([s.high for s in swept])

    def in_the_way(self, name: str) -> tuple[tuple[str, float], ...]:
        """Return all bodies that ``name`` would hit on its way out, each with its distance [m], the nearest first."""
        if name not in self._found:
            self._found[name] = self._search(name)
        return self._found[name]

    def blockers(self, name: str, remaining: Collection[str]) -> tuple[tuple[str, float], ...]:
        """Return those of the bodies ``in_the_way`` that are fixed or among ``remaining``."""
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
