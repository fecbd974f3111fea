"""Random faces: the clearance between the two faces of every patch, and how stiff each pair of bodies is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import node_axes
from holdfast.base.arrays import Float
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.nodes import interface_nodes
from holdfast.engines.imperfect import Imperfect
from holdfast.geometry.hull import convex_hull, smallest_rectangle
from holdfast.geometry.polygon import inside, shapely_polygon

WAVES = 32  # plane waves whose sum is a height field
PATCH_SHARE = 3.0  # longer side of a patch over the correlation length, unless that is given
LATTICE = 15  # places along each side of a patch among which peak and valley are sought
SPREAD = 4.0  # standard deviations from peak to valley where a patch is a single point


class Ground(NamedTuple):
    """A patch as its height fields see it: tangents ``axes`` (2, 3), ``centre`` (3,) [m], ``places`` (n, 3) [m] that
    cover it, and its ``longest`` side [m]; ``interface`` and ``number`` say which patch it is.
    """  # noqa: D205

    axes: Float
    centre: Float
    places: Float
    longest: float
    interface: Interface
    number: int


class Grounds:
    """The patches of assemblies, which all samples share."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[Assembly, list[Ground]]] = {}  # the assembly, too: its id is not given away

    def of(self, assembly: Assembly) -> list[Ground]:
        """Return the patches of an assembly, interface by interface."""
        if id(assembly) not in self._known:
            places = [(interface, k) for interface in assembly.interfaces for k in range(len(interface.patches))]
            normals = np.array([interface.patches[k].normal for interface, k in places]).reshape(-1, 3)
            found = []
            for (interface, k), axes in zip(places, node_axes(assembly, normals), strict=True):
                patch = interface.patches[k]
                found.append(Ground(axes[1:], patch.centroid, *_lattice(patch), interface, k))
            self._known[id(assembly)] = assembly, found
        return self._known[id(assembly)][1]


@dataclass(frozen=True, eq=False)
class Faces:
    """One sample of the faces of an assembly, the one with number ``sample``.

    What is drawn depends on the seed, the number of the sample and the order of the assembly's contacts alone. That
    order is the group's own (assembly/parts.py), so neither names nor unrelated bodies change anything. Samples that
    share ``grounds`` work out only once what they have in common.
    """

    imperfect: Imperfect
    sample: int
    grounds: Grounds = field(default_factory=Grounds)

    def stiffness(self, assembly: Assembly) -> Float:
        """Return the normal stiffness per area (interfaces,) [N/m³], alike for all contacts of a pair of bodies."""
        low, high = np.log(self.imperfect.stiffness)
        pairs = list(dict.fromkeys(frozenset(interface.bodies) for interface in assembly.interfaces))
        levels = dict(zip(pairs, self._random(1).random(len(pairs)), strict=True))
        each = np.array([levels[frozenset(interface.bodies)] for interface in assembly.interfaces])
        return np.asarray(self.imperfect.bed_stiffness * np.exp(low + each * (high - low)))

    def clearances(self, assembly: Assembly, count: int) -> Float:
        """Return the clearance (I,) [m] at each of the nodes of ``contact_nodes(assembly, count, "quadrature")``.

        Another number of nodes sees the same surfaces at other places.
        """
        random = self._random(0)
        found = [np.empty(0)]
        for ground in self.grounds.of(assembly):
            points, _ = interface_nodes(ground.interface, count, "quadrature")[ground.number]
            found.append(self._heights(ground, points, random))
        return np.concatenate(found)

    def _random(self, what: int) -> np.random.Generator:
        return np.random.default_rng((self.imperfect.seed, self.sample, what))

    def _heights(self, ground: Ground, points: Float, random: np.random.Generator) -> Float:
        """Return the heights (n,) [m] at ``points`` (n, 3) [m] of a new smooth surface over a patch.

        It is a sum of plane waves with normally distributed wave vectors and random phases, whose correlation falls
        with the distance d as exp(-d² / 2ℓ²), scaled to the wanted peak to valley.
        """
        length = self.imperfect.correlation or max(ground.longest, 1e-300) / PATCH_SHARE
        waves, phases = random.standard_normal((WAVES, 2)), random.uniform(0, 2 * np.pi, WAVES)

        def height(at: Float) -> Float:
            local = (at - ground.centre) @ ground.axes.T / length
            return np.asarray(np.cos(local @ waves.T + phases).sum(1) * np.sqrt(2 / WAVES))

        range_ = float(np.ptp(height(ground.places))) if len(ground.places) > 1 else SPREAD
        return self.imperfect.flatness / max(range_, 1e-300) * height(points)


def _lattice(patch: Patch) -> tuple[Float, float]:
    """Return places (n, 3) [m] that cover a patch, and the length of its longer side [m]."""
    if patch.kind == "point":
        return patch.polygon, patch.breadth
    if patch.kind == "line":
        share = np.linspace(0, 1, LATTICE)[:, None]
        return (1 - share) * patch.polygon[0] + share * patch.polygon[1], patch.length
    hull = convex_hull(patch.rings[0], 1e-9 * patch.size)
    axes, low, high = smallest_rectangle(hull)
    grid = np.stack(np.meshgrid(*np.linspace(low, high, LATTICE).T, indexing="ij"), axis=-1).reshape(-1, 2) @ axes
    kept = grid[inside(shapely_polygon(patch.rings), grid)]
    return patch.lifted(np.vstack([hull, kept])), float((high - low).max())
