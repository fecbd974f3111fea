"""What is uncertain about an assembly, as ``robustness_under`` and ``transport_under`` sample it."""

from __future__ import annotations

from dataclasses import dataclass

from holdfast.base.arrays import checked_whole
from holdfast.base.errors import HoldfastError, message
from holdfast.base.ranges import MOST_SEED
from holdfast.base.values import Value
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.intervals import MassRange, MuRange

MOST_SAMPLES = 1_000_000  # more answers than the memory holds


@dataclass(frozen=True, eq=False, repr=False)
class Uncertain(Value):
    """What is uncertain, and how many samples of it are drawn.

    - ``pose_sigma``: the standard deviation of each movable body's position along each world axis [m]. A pair also
      gives that of its rotation about each world axis through its centre of mass [deg]. The deviations of different
      bodies are independent, and fixed bodies do not deviate.
    - ``mu_range``: a relative width (0.2 means ± 20 %) or an interval (low, high) for all touching pairs, or a dict of
      intervals by the names of the two bodies. In each sample, all coefficients are at the same relative position in
      their intervals, which is uniformly distributed.
    - ``mass_range``: a relative width for all movable bodies, or a dict of intervals (low, high) [kg] by name. Each
      mass is uniformly distributed in its interval, independently of the others; centres of mass stay where they are.
    - ``flatness`` [m], with ``bed`` [N/m³] or ``material``: how far faces are from flat. ``stiffness_range``: a range
      of factors for each pair of bodies. All four are as in ``Imperfect``; they need engine ``compliant``.
    - ``samples``: how many are drawn, with ``seed``. The same seed gives the same samples; with a larger number of
      samples, the first ones are the same.

    Raises HoldfastError for faces or numbers out of range; the rest is checked once the assembly is known.
    """

    pose_sigma: float | tuple[float, float] | None = None
    mu_range: MuRange | None = None
    mass_range: MassRange | None = None
    flatness: float | None = None
    bed: float | None = None
    material: str | None = None
    stiffness_range: tuple[float, float] | None = None
    samples: int = 200
    seed: int = 0

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "samples", checked_whole(self.samples, "Uncertain: samples", 1, MOST_SAMPLES))
        set_(self, "seed", checked_whole(self.seed, "Uncertain: seed", 0, MOST_SEED))
        if self.flatness is None and not (self.bed is None and self.material is None):
            problem = "has a bed or material but no flatness"
            raise HoldfastError(message("Uncertain", problem, "give flatness= [m], too"))

    @property
    def faces(self) -> Imperfect | None:
        """The faces that are sampled, or None if they are ideal."""
        if self.flatness is None and self.stiffness_range is None:
            return None
        flat = 0.0 if self.flatness is None else self.flatness
        equal = (1.0, 1.0) if self.stiffness_range is None else self.stiffness_range
        return Imperfect(flat, self.bed, self.material, equal, samples=self.samples, seed=self.seed)
