"""Which bodies of an SDF file never touch: links of one model, and collisions without a common bit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations, product
from typing import NamedTuple

from holdfast.scene.body import Body
from holdfast.scene.formats.sdf.groups import Place
from holdfast.scene.formats.sdf.links import USUAL_MASK
from holdfast.scene.formats.sdf.scopes import Scope, truth


class Toucher(NamedTuple):
    """What decides whether a collision touches another: its model, whether it touches others of it, and its bits."""

    model: Scope
    own: bool
    mask: int


Touching = tuple[Body, frozenset[Toucher]]


def toucher(place: Place, mask: int) -> Toucher:
    """Return what decides for a collision of a link with these bits (<collide_bitmask>)."""
    own = place.scope.touches_itself or truth(place.element, "self_collide")
    return Toucher(place.scope, own, mask)


def excluded_pairs(bodies: Sequence[Touching], notes: list[str]) -> list[tuple[str, str]]:
    """Return the pairs of bodies that never touch.

    Links of one model touch only with <self_collide>, and collisions only if they have a bit in common. A pair of which
    this holds for some collisions alone is not excluded, and noted.
    """
    found = []
    for (a, of_a), (b, of_b) in _candidates(bodies):
        if a.fixed and b.fixed:
            continue
        touch = [_touch(x, y) for x, y in product(of_a, of_b)]
        if not any(touch):
            found.append((a.name, b.name))
        elif not all(touch):
            notes.append(f"bodies {a.name} and {b.name}: some of their parts do not touch in the file, here all do")
    if found:
        notes.append(f"{len(found)} pairs of bodies never touch (links of one model, collide_bitmask)")
    return found


def _candidates(bodies: Sequence[Touching]) -> Iterable[tuple[Touching, Touching]]:
    """Return the pairs of bodies that may be excluded: those of one model, or all if some have bits of their own."""
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
