"""Strategies for several objects: the order in which they are placed, and the rules that choose their places.

Two rules of the packing literature choose a level place by geometry alone: the one where most of the face is supported,
or the lowest one that is farthest in a corner. A strategy that compares takes the better of the places that the rules
choose, for each of several faces, by the pushes that the object and its supports withstand.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from holdfast.applications.placement.level_places import LevelPlace
from holdfast.scene.body import Body

Order = Callable[[Body], float]
Rule = Callable[[LevelPlace], tuple[float, ...]]


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


def highest_support(place: LevelPlace) -> tuple[float, ...]:
    """Rank a place by the share of the face that is supported, the largest first, then by height, the lowest first."""
    return (-round(place.support, 2), round(place.height, 4), *np.round(place.corner, 6).tolist())


def bottom_left(place: LevelPlace) -> tuple[float, ...]:
    """Rank a place by its height, the lowest first, then by its closeness to one corner, then by support."""
    return (round(place.height, 4), *np.round(place.corner[::-1], 6).tolist(), -round(place.support, 2))


RULES: Mapping[str, Rule] = MappingProxyType({"highest support": highest_support, "bottom-left": bottom_left})


@dataclass(frozen=True)
class Strategy:
    """One strategy: objects come in decreasing ``order``, and the ``rules`` choose their places.

    With one rule, the first place where everything stands is taken. With several, the first place of each rule is
    compared, on each of several faces.
    """

    order: Order
    rules: tuple[Rule, ...]

    @property
    def compares(self) -> bool:
        """Whether several places of an object are compared."""
        return len(self.rules) > 1

    def hurried(self) -> Strategy:
        """Return the strategy that takes the first place where everything stands."""
        return Strategy(self.order, self.rules[:1])


RULED = tuple(Strategy(base_area, (rule,)) for rule in RULES.values())
COMPARING = tuple(Strategy(order, tuple(RULES.values())) for order in (base_area, weight, bulk))
