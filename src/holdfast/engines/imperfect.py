"""How far real faces may be from the ideal ones that engines take: not flat, and not equally stiff.

Random faces of one sample: the clearance between the two faces of every patch, and how stiff each pair of bodies is.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked_number, checked_whole
from holdfast.base.errors import HoldfastError, message
from holdfast.base.memory import Same
from holdfast.base.public import Record
from holdfast.base.ranges import LENGTH, MOST_SEED, STIFFNESS, TOLERANCE
from holdfast.base.text import quoted
from holdfast.contacts.interface import Patch
from holdfast.contacts.patch_nodes import interface_nodes
from holdfast.geometry.polygon import inside, shapely_polygon

MOST_SAMPLES = 100_000  # more answers than anybody waits for
DEPTH = 0.1  # [m] of material behind a face that gives way with it, where the bed is taken from Young's modulus

# Young's moduli [Pa], each at the stiff end of what handbooks give for the material (Ashby, "Materials Selection in
# Mechanical Design", table of properties; wood along the grain; corrugated board flat crush, TAPPI T 825): the stiffer
# the bed, the fewer high spots carry
MODULUS = {
    "steel": 2.1e11,
    "glass": 7.2e10,
    "wood": 1.2e10,
    "plastic": 3.0e9,
    "cardboard": 3.0e6,
    "rubber": 1.0e7,
}
BED = {name: modulus / DEPTH for name, modulus in MODULUS.items()}  # [N/m³]


class Imperfect(Record):
    """Faces that touch at high spots, with contacts that are not equally stiff.

    - ``flatness`` [m]: peak to valley of the clearance between the two faces of every patch of contact: a smooth random
      height field. 0 for flat faces.
    - ``bed`` [N/m³]: the normal stiffness of the faces per area, a pressure [Pa] over the distance [m] by which it
      presses them together; or ``material``, a word of BED, from which it is taken: the stiff end of Young's modulus
      over a depth of 0.1 m. Clearances count by flatness x bed over the pressure that the weight causes: the stiffer
      the bed, the fewer spots carry. Faces for which this is above 1,000 are taken as if it were 1,000: they touch at
      three spots anyway. Not needed if ``flatness`` is 0.
    - ``stiffness_range``: the range (low, high) of the factor by which the stiffness of a pair of bodies may differ
      from the bed's, drawn evenly on a logarithmic scale.
    - ``correlation`` [m]: how far from each other heights are about equal; None means a third of the longer side of the
      patch.
    - ``samples``: how many surfaces are drawn, with ``seed``. The same seed gives the same surfaces, and a larger
      number of samples begins with the same ones.
    - ``quantile``: the share of the samples that may lie below ``lower``; 0 means none.

    It is not made for walls of many blocks: the least of the samples is that in which some block rocks, far below what
    measured walls bear (docs/howto/uncertainty.md).

    Raises HoldfastError for options out of range, for an unknown material and where the bed is not known.
    """

    flatness: float
    bed: float | None = None
    material: str | None = None
    stiffness_range: tuple[float, float] = (1.0, 1.0)
    correlation: float | None = None
    samples: int = 32
    seed: int = 0
    quantile: float = 0.0

    def __post_init__(self) -> None:
        checked_number(self.flatness, "Imperfect: flatness", minimum=0, within=TOLERANCE)
        if self.correlation is not None:
            checked_number(self.correlation, "Imperfect: correlation", above=0, within=LENGTH)
        checked_whole(self.samples, "Imperfect: samples", 1, MOST_SAMPLES)
        checked_whole(self.seed, "Imperfect: seed", 0, MOST_SEED)
        checked_number(self.quantile, "Imperfect: quantile", minimum=0, below=1)
        where = "Imperfect: stiffness_range"
        if not isinstance(self.stiffness_range, tuple | list) or len(self.stiffness_range) != 2:
            raise HoldfastError(
                message(where, f"is {quoted(self.stiffness_range)}", "needs a range (low, high) of factors")
            )
        low, high = (checked_number(value, where, above=0, within=STIFFNESS) for value in self.stiffness_range)
        if low > high:
            raise HoldfastError(message(where, f"{low:g} is above {high:g}", "needs (low, high)"))
        object.__setattr__(self, "stiffness_range", (low, high))
        if self.bed is not None and self.material is not None:
            raise HoldfastError(message("Imperfect", "has a bed and a material", "give one of them"))
        if self.bed is not None:
            checked_number(self.bed, "Imperfect: bed", above=0, within=STIFFNESS)
        elif self.material is not None:
            if self.material not in BED:
                problem = f"{quoted(self.material)} is unknown"
                raise HoldfastError(message("Imperfect: material", problem, f"known: {', '.join(BED)}"))
        elif self.flatness > 0:
            remedy = f"give bed= [N/m³], or material= one of {', '.join(BED)}"
            raise HoldfastError(
                message("Imperfect", "has a flatness, but how stiff the faces are is not known", remedy)
            )

    @property
    def bed_stiffness(self) -> float:
        """The normal stiffness per area [N/m³]; 1 for flat faces of unknown stiffness, where it does not count."""
        if self.material is not None:
            return BED[self.material]
        return 1.0 if self.bed is None else float(self.bed)


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
class HeightField:
    """A smooth random surface over a patch: the sum of plane waves, times ``scale`` [m].

    Heights about ``centre`` (3,) [m] have normally distributed wave vectors ``waves`` (3, WAVES) [1/m] and random
    ``phases`` (WAVES,), so their correlation falls with the distance d as exp(-d² / 2ℓ²).
    """

    centre: Float
    waves: Float
    phases: Float
    scale: float = 1.0

    @classmethod
    def drawn(cls, ground: Ground, imperfect: Imperfect, random: np.random.Generator) -> HeightField:
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
class RandomFaces:
    """One sample of the faces of an assembly, the one with number ``sample``.

    What is drawn depends on the seed, the number of the sample and the order of the assembly's contacts alone. That
    order is the group's own (assembly/one_group.py), so neither names nor unrelated bodies change anything.
    """

    imperfect: Imperfect
    sample: int
    _drawn: dict[Same, list[HeightField]] = field(default_factory=dict, init=False, repr=False)

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
        key = Same(assembly)
        if key not in self._drawn:
            random = self._random(0)
            self._drawn[key] = [HeightField.drawn(ground, self.imperfect, random) for ground in grounds_of(assembly)]
        patches = (each for one in assembly.interfaces for each in interface_nodes(one, count, "quadrature"))
        pairs = zip(patches, self._drawn[key], strict=True)
        return np.concatenate([np.empty(0), *(surface.heights(points) for (points, _), surface in pairs)])

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
