"""Random faces: the clearance between the two faces of every patch, and how stiff each pair of bodies is."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.memory import Same
from holdfast.contacts.interface import Patch
from holdfast.contacts.patch_nodes import interface_nodes
from holdfast.engines.imperfect import Imperfect
from holdfast.geometry.polygon import inside, shapely_polygon

WAVES = 32  # plane waves whose sum is a height field
PATCH_SHARE = 3.0  # longer side of a patch over the correlation length, unless that is given
LATTICE = 15  # places along each side of a patch among which peak and valley are sought
SPREAD = 4.0  # standard deviations from peak to valley where a patch is a single point


class Ground(NamedTuple):
    """A patch as its height fields see it: tangents ``axes`` (2, 3), ``centre`` (3,) [m], ``places`` (n, 3) [m] that
    cover it, and its ``longest`` side [m].
    """  # noqa: D205

    axes: Float
    centre: Float
    places: Float
    longest: float


def grounds_of(assembly: Assembly) -> list[Ground]:
    """Return the patches of an assembly, interface by interface; they are kept with it, as all samples share them."""

    def found() -> list[Ground]:
        patches = [patch for interface in assembly.interfaces for patch in interface.patches]
        each = zip(patches, assembly.patch_axes, strict=True)
        return [Ground(own[1:], patch.centroid, *_lattice(patch)) for patch, own in each]

    return assembly.memory.recalled(("grounds", Same(assembly)), len(assembly.movable), found)


@dataclass(frozen=True, eq=False)
class Surface:
    """A smooth random surface over a patch: the sum of plane waves, times ``scale`` [m].

    Heights about ``centre`` (3,) [m] have normally distributed wave vectors ``waves`` (3, WAVES) [1/m] and random
    ``phases`` (WAVES,), so their correlation falls with the distance d as exp(-d² / 2ℓ²).
    """

    centre: Float
    waves: Float
    phases: Float
    scale: float = 1.0

    @classmethod
    def drawn(cls, ground: Ground, imperfect: Imperfect, random: np.random.Generator) -> Surface:
        """Draw a surface over a patch that has the wanted peak to valley."""
        length = imperfect.correlation or max(ground.longest, 1e-300) / PATCH_SHARE
        waves, phases = random.standard_normal((WAVES, 2)), random.uniform(0, 2 * np.pi, WAVES)
        plain = cls(ground.centre, ground.axes.T @ waves.T / length, phases)
        range_ = float(np.ptp(plain.heights(ground.places))) if len(ground.places) > 1 else SPREAD
        return replace(plain, scale=imperfect.flatness / max(range_, 1e-300))

    def heights(self, points: Float) -> Float:
        """Return the heights (n,) [m] at ``points`` (n, 3) [m]."""
        waves = np.cos((points - self.centre) @ self.waves + self.phases)
        return np.asarray(waves.sum(1) * (np.sqrt(2 / WAVES) * self.scale))


@dataclass(frozen=True, eq=False)
class Faces:
    """One sample of the faces of an assembly, the one with number ``sample``.

    What is drawn depends on the seed, the number of the sample and the order of the assembly's contacts alone. That
    order is the group's own (assembly/one_group.py), so neither names nor unrelated bodies change anything.
    """

    imperfect: Imperfect
    sample: int
    _drawn: dict[Same, list[Surface]] = field(default_factory=dict, init=False, repr=False)

    def stiffness(self, assembly: Assembly) -> Float:
        """Return the normal stiffness per area (interfaces,) [N/m³], alike for all contacts of a pair of bodies."""
        low, high = np.log(self.imperfect.stiffness_range)
        pairs = list(dict.fromkeys(frozenset(interface.bodies) for interface in assembly.interfaces))
        levels = dict(zip(pairs, self._random(1).random(len(pairs)), strict=True))
        each = np.array([levels[frozenset(interface.bodies)] for interface in assembly.interfaces])
        return np.asarray(self.imperfect.bed_stiffness * np.exp(low + each * (high - low)))

    def clearances(self, assembly: Assembly, count: int) -> Float:
        """Return the clearance (I,) [m] at each of the nodes of ``contact_nodes(assembly, count, "quadrature")``.

        Another number of nodes sees the same surfaces at other places.
        """
        patches = (each for one in assembly.interfaces for each in interface_nodes(one, count, "quadrature"))
        heights = [
            surface.heights(points) for (points, _), surface in zip(patches, self._surfaces(assembly), strict=True)
        ]
        return np.concatenate([np.empty(0), *heights])

    def _surfaces(self, assembly: Assembly) -> list[Surface]:
        """Return the surfaces over the patches of an assembly; finer grids see the same ones."""
        key = Same(assembly)
        if key not in self._drawn:
            random = self._random(0)
            self._drawn[key] = [Surface.drawn(ground, self.imperfect, random) for ground in grounds_of(assembly)]
        return self._drawn[key]

    def _random(self, what: int) -> np.random.Generator:
        return np.random.default_rng((self.imperfect.seed, self.sample, what))


def _lattice(patch: Patch) -> tuple[Float, float]:
    """Return places (n, 3) [m] that cover a patch, and the length of its longer side [m]."""
    if patch.kind == "point":
        return patch.polygon, patch.breadth
    if patch.kind == "line":
        share = np.linspace(0, 1, LATTICE)[:, None]
        return (1 - share) * patch.polygon[0] + share * patch.polygon[1], patch.length
    axes, low, high, hull = patch.rectangle
    grid = np.stack(np.meshgrid(*np.linspace(low, high, LATTICE).T, indexing="ij"), axis=-1).reshape(-1, 2) @ axes
    kept = grid[inside(shapely_polygon(patch.rings), grid)]
    return patch.lifted(np.vstack([hull, kept])), float((high - low).max())
