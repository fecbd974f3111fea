"""What is uncertain about an assembly: friction, masses and centres of mass, as checked intervals and boxes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.base.arrays import Float, checked, checked_number, checked_whole
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.ranges import MOST_SEED, PLACE
from holdfast.base.text import listed, quoted
from holdfast.base.values import Value
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.request import body_number
from holdfast.scene.friction import checked_pair, names_between

NAMED = 3  # the most coefficients that a note names

Pair: TypeAlias = tuple[str, str]
MuRange: TypeAlias = float | tuple[float, float] | Mapping[Pair, tuple[float, float]]
MassRange: TypeAlias = float | Mapping[str, tuple[float, float]]
ComRange: TypeAlias = float | Mapping[str, Any]
MOST_SAMPLES = 1_000_000  # more answers than the memory holds


def friction_intervals(assembly: Assembly, mu: MuRange | None, where: str) -> dict[Pair, tuple[float, float]]:
    """Return the interval (low, high) of the friction coefficient for every pair of touching bodies.

    ``mu`` is a relative width for all pairs (0.2 means ± 20 %), one interval (low, high) for all pairs, or a dict of
    intervals for pairs of names. A name is that of a body or of a material. As in the friction table, a pair of two
    bodies takes precedence over a body and a material, and that over two materials. The interval of a pair that is not
    named has the known coefficient at both ends. Raises SceneError if a named pair does not touch, or if an interval is
    not 0 <= low <= high.
    """
    pairs: dict[Pair, float] = {}
    for i, m in zip(assembly.interfaces, assembly.mu, strict=True):  # the parts of two bodies may have several
        pairs[i.bodies] = min(m, pairs.get(i.bodies, m))
    if mu is None:
        return {p: (m, m) for p, m in pairs.items()}
    if isinstance(mu, Mapping):
        named = {checked_pair(pair, f"{where}: mu_range"): interval for pair, interval in mu.items()}
        given = {
            (min(pair), max(pair)): _interval(interval, f"{where}: mu_range of {quoted(pair)}")
            for pair, interval in named.items()
        }
        ways = {p: names_between(*p, assembly.scene.materials) for p in pairs}
        touching = {key for way in ways.values() for keys in way for key in keys}
        unknown = [pair for pair in named if (min(pair), max(pair)) not in touching]
        if unknown:
            problem = f"no contact between {quoted(unknown[0])}"
            raise SceneError(message(f"{where}: mu_range", problem, "name touching bodies, or their materials"))
        found = {}
        for pair, m in pairs.items():  # each of its ways to be named names the same bodies: the first that is given
            first = next((keys for way in ways[pair] if (keys := [key for key in way if key in given])), [])
            ends = [given[key] for key in first] or [(m, m)]
            found[pair] = min(low for low, _ in ends), max(high for _, high in ends)
        return found
    if isinstance(mu, tuple | list):
        return dict.fromkeys(pairs, _interval(mu, f"{where}: mu_range"))
    width = _width(mu, f"{where}: mu_range")
    return {p: (m * (1 - width), m * (1 + width)) for p, m in pairs.items()}


def width_notes(assembly: Assembly, mu: MuRange | None) -> tuple[str, ...]:
    """Return a note on what a relative width means for the coefficients that there are; none for intervals."""
    if mu is None or isinstance(mu, Mapping | tuple | list):
        return ()
    each = [f"{m * (1 - mu):.4g} to {m * (1 + mu):.4g} of {m:.4g}" for m in sorted(set(assembly.mu))]
    return (f"mu_range {mu:g} is relative: friction {listed(each, NAMED)}",)


def mass_intervals(assembly: Assembly, mass: MassRange | None, where: str) -> dict[str, tuple[float, float]]:
    """Return the interval (low, high) [kg] of the mass for each uncertain body, by name.

    ``mass`` is a relative width for all movable bodies, or a dict of intervals by body name. Raises SceneError if a
    named body is fixed, or if an interval is not 0 <= low <= high.
    """
    if mass is None:
        return {}
    if not isinstance(mass, Mapping):
        width = _width(mass, f"{where}: mass_range")
        return {
            b.name: (m * (1 - width), m * (1 + width)) for b, m in zip(assembly.movable, assembly.mass, strict=True)
        }
    _check_movable(assembly, mass, f"{where}: mass_range")
    return {name: _interval(interval, f"{where}: mass_range of {quoted(name)}") for name, interval in mass.items()}


def com_boxes(assembly: Assembly, com: ComRange | None, where: str) -> dict[str, Float]:
    """Return the half widths (3,) [m] of the box around the centre of mass for each uncertain body, by name.

    The boxes lie along the world axes. ``com`` is one half width for all movable bodies, or a dict of half widths (3,)
    by body name. Raises SceneError if a named body is fixed, or if a half width is negative.
    """
    if com is None:
        return {}
    if not isinstance(com, Mapping):
        width = checked_number(com, f"{where}: com_range", minimum=0, within=PLACE)
        return {b.name: np.full(3, width) for b in assembly.movable}
    _check_movable(assembly, com, f"{where}: com_range")
    boxes = {
        name: checked(half, (3,), f"{where}: com_range of {quoted(name)}", within=PLACE) for name, half in com.items()
    }
    for name, half in boxes.items():
        if (half < 0).any():
            raise SceneError(
                message(f"{where}: com_range of {quoted(name)}", f"is {half.tolist()}", "needs half widths >= 0")
            )
    return boxes


def _check_movable(assembly: Assembly, names: Iterable[str], where: str) -> None:
    for name in names:
        if body_number(assembly, name) == FIXED:
            raise SceneError(message(where, f"{quoted(name)} is fixed", "name movable bodies"))


def _interval(value: Any, where: str) -> tuple[float, float]:  # noqa: ANN401
    low, high = (float(v) for v in checked(value, (2,), where))
    if not 0 <= low <= high:
        raise SceneError(message(where, f"is ({low:g}, {high:g})", "needs 0 <= low <= high"))
    return low, high


def _width(value: Any, where: str) -> float:  # noqa: ANN401
    width = checked_number(value, where, minimum=0)
    if width >= 1:
        raise SceneError(message(where, f"relative width {width:g}", "needs less than 1; give (low, high) instead"))
    return width


@dataclass(frozen=True, eq=False, repr=False)
class Uncertain(Value):
    """What is uncertain, as ``robustness_under`` and ``transport_under`` sample it, and how many samples are drawn.

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
