"""Cohesion beyond friction times tension, as nodes with friction cones: see hold_nodes.py.

The forces that such a face bears at a point are those of its cone, moved by the tension, plus any force along the face
up to a bound. That bound is the tangential force of a node whose normal force is given. Between two bodies that can
move, a fastener passes it on, as a layer of mortar would: one node for each side, and equations that both exert the
same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import shapely

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import strengths_of
from holdfast.base.arrays import Float
from holdfast.base.rigid import cross
from holdfast.contacts.interface import Patch
from holdfast.geometry import polygon as flat

PARTS = 4  # parts of a face along each side: torsion counts at their centroids, which is 1.5 % cautious on a square


@dataclass
class Cohesive:
    """The nodes of one interface, number ``interface``, that bears ``shear`` [Pa] beside its cones."""

    assembly: Assembly
    interface: int
    shear: float
    mu: list[float] = field(default_factory=list)
    blocks: list[Float] = field(default_factory=list)
    usual: list[float] = field(default_factory=list)
    bodies: list[int] = field(default_factory=list)
    at: list[int] = field(default_factory=list)
    equations: list[bool] = field(default_factory=list)
    owners: list[int] = field(default_factory=list)
    given: list[Float] = field(default_factory=list)

    def __post_init__(self) -> None:
        a, b = self.assembly.ends[self.interface]
        self._sides = [(body, sign) for body, sign in ((b, 1.0), (a, -1.0)) if body >= 0]
        self._lighter = min((body for body, _ in self._sides), key=lambda body: float(self.assembly.mass[body]))
        self._unit = float(self.assembly.mass[self._lighter] * np.linalg.norm(self.assembly.scene.gravity))
        for patch in self.assembly.interfaces[self.interface].patches:
            for point, area in _parts(patch):
                self._add(patch, point, self.shear * area)

    @property
    def amounts(self) -> Float:
        """The right-hand sides (6F,) of the equations of all fasteners."""
        return np.concatenate([np.empty(0), *self.given])

    def _add(self, patch: Patch, point: Float, most: float) -> None:
        """Add any force along a patch up to ``most`` [N] at a point, with a fastener of its own."""
        amounts = np.zeros(6)
        for row, (body, sign) in zip((0, 3), self._sides, strict=False):
            block, amounts[row] = np.zeros((3, 2, 6)), self._unit
            block[0, 1, row] = 1.0
            for axis, way in enumerate(patch.frame, start=1):
                block[axis, 0] = sign * np.concatenate([way, cross(point - self.assembly.com[body], way)])
                if len(self._sides) > 1:
                    block[axis, 1, axis] = sign
            self.mu.append(most / self._unit)
            self.blocks.append(block)
            self.usual.append(self._unit)
            self.bodies.append(body)
            self.at.append(len(self.owners))
            self.equations.append(True)
        self.owners.append(self._lighter)
        self.given.append(amounts)


def cohesive_faces(assembly: Assembly) -> list[Cohesive]:
    """Return the nodes of all interfaces with a cohesion beyond friction times tension."""
    if not assembly.scene.friction.joins:
        return []
    strengths = strengths_of(assembly)
    found = [Cohesive(assembly, k, strength.shear) for k, strength in enumerate(strengths) if strength.shear > 0]
    return [one for one in found if one.owners]


def _parts(patch: Patch) -> Iterator[tuple[Float, float]]:
    """Yield the centroids (3,) [m] and areas [m²] of parts of a face; one part where many patches were merged."""
    if patch.spots is not None or patch.kind != "face":
        if patch.area > 0 and not patch.bent:
            yield patch.centroid, patch.area
        return
    outline = flat.shapely_polygon(patch.rings)
    low, high = np.array(outline.bounds).reshape(2, 2)
    step = (high - low) / PARTS
    for i in range(PARTS):
        for j in range(PARTS):
            corner = low + step * (i, j)
            piece = outline.intersection(shapely.box(*corner, *(corner + step)))
            if piece.area > 0:
                yield patch.lifted(np.array(piece.centroid.coords))[0], float(piece.area)
