"""Bodies of an SDF file that never touch: links of the same model, and collisions without a common bit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool
from holdfast.scene.body import Body
from holdfast.scene.excluded import Excluded, excluded_by
from holdfast.scene.formats.sdf.scopes import Scope, truth
from holdfast.scene.formats.sdf.sdf_joints import Place
from holdfast.scene.formats.sdf.sdf_links import USUAL_MASK


class Toucher(NamedTuple):
    """The data that decide what a collision may touch: its model, whether it touches others of it, and its bits."""

    model: Scope
    own: bool
    mask: int


Touching = tuple[Body, tuple[Toucher, ...]]  # a body, with the data of each of its parts


def toucher(place: Place, mask: int) -> Toucher:
    """Return the data for a collision of a link with these bits (<collide_bitmask>)."""
    own = place.scope.touches_itself or truth(place.element, "self_collide")
    return Toucher(place.scope.whole, own, mask)


def excluded_pairs(bodies: Sequence[Touching], notes: list[str]) -> list[Excluded]:
    """Return the pairs of bodies that never touch, or of their parts if other parts may touch.

    These are links of one model without <self_collide>, and collisions that have no bit in common.
    """
    found: list[Excluded] = []
    for (a, of_a), (b, of_b) in _candidates(bodies):
        if not (a.fixed and b.fixed):
            may = _may(of_a, of_b)
            if not may.all():
                found += excluded_by(a.name, b.name, may)
    if found:
        notes.append(f"{len(found)} pairs of bodies or parts never touch (links of one model, collide_bitmask)")
    return found


def _may(of_a: Sequence[Toucher], of_b: Sequence[Toucher]) -> Bool:
    """Tell which parts of two bodies may touch; equal parts are only compared once."""
    first, second = dict.fromkeys(of_a), dict.fromkeys(of_b)
    known = {(x, y): _touch(x, y) for x, y in product(first, second)}
    if len(set(known.values())) == 1:
        return np.full((1, 1), next(iter(known.values())))
    return np.array([[known[x, y] for y in of_b] for x in of_a], dtype=bool)


def _candidates(bodies: Sequence[Touching]) -> Iterable[tuple[Touching, Touching]]:
    """Return the pairs of bodies that may be excluded: those of the same model, or all pairs if some have bits."""
    if not all(each.mask == USUAL_MASK for _, touching in bodies for each in touching):
        return combinations(bodies, 2)
    of_model: dict[Scope, list[int]] = {}
    for number, (_, touching) in enumerate(bodies):
        for model in {each.model for each in touching}:
            of_model.setdefault(model, []).append(number)
    pairs = {pair for numbers in of_model.values() for pair in combinations(numbers, 2)}
    return [(bodies[a], bodies[b]) for a, b in sorted(pairs)]


def _touch(a: Toucher, b: Toucher) -> bool:
    return bool(a.mask & b.mask) and (a.model is not b.model or a.own or b.own)
