"""The ways in which several objects are tried: in which order, and which of its level places each of them takes.

Two simple rules of the packing literature choose a place by geometry alone: where most of the face is supported, or the
lowest one that is farthest in a corner. Comparing takes the better of what the rules choose, for each of several faces,
by what the object and what it rests on withstand.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from holdfast.applications.placement.level_places import Spot
from holdfast.scene.body import Body

Order = Callable[[Body], float]
Rule = Callable[[Spot], tuple[float, ...]]


def base_area(body: Body) -> float:
    """The product of the two longer sides of the body's own box [m²]."""
    sides = np.sort(np.ptp(body.shape.surface.vertices, axis=0))
    return float(sides[1] * sides[2])


def weight(body: Body) -> float:
    """The mass of the body [kg]."""
    return body.mass or 0.0


def bulk(body: Body) -> float:
    """The volume of the body's own box [m³]."""
    return float(np.prod(np.ptp(body.shape.surface.vertices, axis=0)))


def highest_support(spot: Spot) -> tuple[float, ...]:
    """Rank a place by the share of the face that is supported, the largest first, then as low as can be."""
    return (-round(spot.support, 2), round(spot.height, 4), *np.round(spot.corner, 6).tolist())


def bottom_left(spot: Spot) -> tuple[float, ...]:
    """Rank a place by its height, the lowest first, then by how far it is in one corner; of two turns the supported."""
    return (round(spot.height, 4), *np.round(spot.corner[::-1], 6).tolist(), -round(spot.support, 2))


RULES: Mapping[str, Rule] = MappingProxyType({"highest support": highest_support, "bottom-left": bottom_left})


@dataclass(frozen=True)
class Way:
    """One way to try: the ``order`` of the objects, the largest first, and the ``rules`` that choose their places.

    With one rule the first place in which everything stands is taken. With several, the first by each of them is
    compared, on each of several faces.
    """

    order: Order
    rules: tuple[Rule, ...]

    @property
    def compares(self) -> bool:
        """Whether several places of an object are looked at."""
        return len(self.rules) > 1

    def hurried(self) -> Way:
        """Return the way that takes the first place in which everything stands."""
        return Way(self.order, self.rules[:1])


RULED = tuple(Way(base_area, (rule,)) for rule in RULES.values())
COMPARING = tuple(Way(order, tuple(RULES.values())) for order in (base_area, weight, bulk))
