"""Friction for formats with a coefficient for every surface: read, each is a material; written, each is of a unit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.scene.body import Body
from holdfast.scene.excluded import by_bodies
from holdfast.scene.friction import Friction, refuse_strengths
from holdfast.scene.scene import Scene

DRAKES_FRICTION = 0.5  # default of Drake (default_proximity_properties of SceneGraphConfig)
RULES: Mapping[str, Callable[[float, float], float]] = {
    "product": lambda a, b: a * b,
    "least": min,
    "largest": max,
    "mean": lambda a, b: (a + b) / 2,
    "geometric mean": lambda a, b: (a * b) ** 0.5,
    "harmonic mean": lambda a, b: 2 * a * b / (a + b) if a + b else 0.0,
}
PHYSX = ("mean", "least", "product", "largest")  # the rules of PhysX; of two materials the later one counts


@dataclass
class Surfaces:
    """The materials of a scene that is being read; ``rule`` combines the two coefficients of a pair.

    Unless it is the ``sole`` one, a material may have a rule of its own; of two such rules the later one of ``PHYSX``
    counts.
    """

    rule: str
    sole: bool = True
    coefficients: dict[str, float] = field(default_factory=dict)
    own: dict[str, str] = field(default_factory=dict)

    def material(self, mu: float, rule: str = "") -> str:
        """Return the name of the material with this coefficient and this ``rule`` of its own, if it has one."""
        if self.sole or not rule:
            name = f"friction {mu!r}"
        else:
            name = f"friction {mu!r}, {rule}"
            self.own[name] = rule
        self.coefficients[name] = mu
        return name

    def pairs(self) -> dict[tuple[str, str], float]:
        """Return the coefficient of every pair of materials."""
        named = sorted(self.coefficients.items())
        return {(a, b): self._rule(a, b)(x, y) for (a, x), (b, y) in combinations_with_replacement(named, 2)}

    def _rule(self, a: str, b: str) -> Callable[[float, float], float]:
        rules = [self.own[each] for each in (a, b) if each in self.own]
        return RULES[max(rules, key=PHYSX.index, default=self.rule)]

    def table(self, taking: str | None = None) -> Friction:
        """Return the friction table; a body with the name ``taking`` takes the coefficient of whatever it touches."""
        theirs = {} if taking is None else {(taking, material): mu for material, mu in self.coefficients.items()}
        return Friction(pairs={**self.pairs(), **theirs})


class Unit(NamedTuple):
    """The parts of a body, by their numbers, that have one material."""

    body: Body
    material: str | None
    parts: list[int]


def units_of(scene: Scene) -> list[Unit]:
    """Return the units of all bodies, in the order of the scene."""
    found = []
    for body in scene.bodies:
        parts: dict[str | None, list[int]] = {}
        for k, material in enumerate(body.materials):
            parts.setdefault(material, []).append(k)
        found += [Unit(body, material, numbers) for material, numbers in parts.items()]
    return found


def table_of(scene: Scene, units: list[Unit]) -> tuple[Float, Bool]:
    """Return the friction (U, U) between units, and whether they may touch as units of no excluded bodies.

    Raises SceneError if a pair has a tension or a cohesion.
    """
    refuse_strengths(scene.friction, "the file's format", "write .yaml, .json or .glb")
    mu, touch = np.zeros((len(units), len(units))), np.zeros((len(units), len(units)), dtype=bool)
    excluded = by_bodies(scene.excluded)
    for i, (a, like_a, _) in enumerate(units):
        for j, (b, like_b, _) in enumerate(units[:i]):
            if a is b or (a.fixed and b.fixed) or (min(a.name, b.name), max(a.name, b.name)) in excluded:
                continue
            touch[i, j] = touch[j, i] = True
            mu[i, j] = mu[j, i] = scene.friction.between(a.name, b.name, {a.name: like_a, b.name: like_b})
    return mu, touch
