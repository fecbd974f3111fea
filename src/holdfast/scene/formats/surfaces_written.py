"""Friction of a scene for formats that have a coefficient for each surface, not for each pair."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.scene.body import Body
from holdfast.scene.excluded import by_bodies
from holdfast.scene.friction import refuse_strengths
from holdfast.scene.scene import Scene


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
