"""How far real faces may be from the ideal ones that engines take: not flat, and not equally stiff."""

from __future__ import annotations

from holdfast.base.arrays import checked_number, checked_whole
from holdfast.base.errors import HoldfastError, message
from holdfast.base.public import Record
from holdfast.base.ranges import LENGTH, MOST_SEED, STIFFNESS, TOLERANCE
from holdfast.base.text import quoted

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
        object.__setattr__(self, "stiffness_range", _checked_range(self.stiffness_range))
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


def _checked_range(given: tuple[float, float]) -> tuple[float, float]:
    where = "Imperfect: stiffness_range"
    if not isinstance(given, tuple | list) or len(given) != 2:
        raise HoldfastError(message(where, f"is {quoted(given)}", "needs a range (low, high) of factors"))
    low, high = (checked_number(value, where, above=0, within=STIFFNESS) for value in given)
    if low > high:
        raise HoldfastError(message(where, f"{low:g} is above {high:g}", "needs (low, high)"))
    return low, high
