"""A map that is computed in portions: body by body, first at few points and then at more."""

from __future__ import annotations

from typing import Final, NamedTuple

from holdfast.assembly.assembly import Assembly
from holdfast.base.errors import HoldfastError, message
from holdfast.engines.contract import Engine
from holdfast.engines.groups import prepared
from holdfast.queries.map import RobustnessMap, check_count, expected_points, joined_maps, robustness_map

COARSER: Final = (4, 2, 1)  # the spacing of each round, as multiples of the final one
FEW: Final = 1000  # a map of fewer points is computed in one round


class Part(NamedTuple):
    """The map of one body, and its ``spacing`` [m]."""

    spacing: float
    map: RobustnessMap


class Portions:
    """A map of all movable bodies of an assembly, as far as it is known.

    ``go_on`` computes the next portion. An exception in it loses only that portion.
    """

    def __init__(self, assembly: Assembly, engine: Engine, spacing: float) -> None:
        self.assembly, self.engine = assembly, engine
        names = [body.name for body in assembly.movable]
        check_count(assembly, names, spacing)
        self._size = {name: expected_points(assembly, [name], spacing) for name in names}
        rounds = COARSER if sum(self._size.values()) > FEW else COARSER[-1:]
        self._rounds = [multiple * spacing for multiple in rounds]
        self._parts: dict[str, Part] = {}

    @property
    def done(self) -> bool:
        """Whether every body is mapped at the final spacing."""
        return bool(self._size) and self._round() is None

    @property
    def text(self) -> str:
        """The number of bodies that are mapped at each spacing, in words, the finest first."""
        count = len(self._size)
        known = [(s, sum(part.spacing == s for part in self._parts.values())) for s in reversed(self._rounds)]
        return ", ".join(f"{n} of {count} bodies at points {s:.2g} m apart" for s, n in known if n)

    @property
    def map(self) -> RobustnessMap:
        """The map of the bodies so far, in the order of the assembly, with the verdict on all bodies."""
        verdict = prepared(self.engine, self.assembly).verdict()
        return joined_maps([self._parts[name].map for name in self._size if name in self._parts], verdict)

    def go_on(self, first: str | None = None) -> None:
        """Map one more body, or the same more finely.

        In each round, the body ``first`` comes before the others, which come from the largest to the smallest. Raises
        HoldfastError if nothing is left to map, and the errors of ``robustness_map``.
        """
        spacing = self._round()
        if spacing is None:
            raise HoldfastError(message("live map", "nothing is left to map", "needs a movable body"))
        left = [name for name in self._size if self._spacing(name) > spacing]
        name = min(left, key=lambda name: (name != first, -self._size[name]))
        self._parts[name] = Part(spacing, robustness_map(self.assembly, [name], spacing=spacing, engine=self.engine))

    def _round(self) -> float | None:
        """Return the spacing [m] of the first round that is not complete; None after the last."""
        return next((s for s in self._rounds if any(self._spacing(name) > s for name in self._size)), None)

    def _spacing(self, name: str) -> float:
        return self._parts[name].spacing if name in self._parts else float("inf")
