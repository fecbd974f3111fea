"""The joints of an SDF file, the groups of links that they hold together, and pairs of bodies that never touch."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Bool
from holdfast.base.text import listed, quoted
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats.links import BodyParts, Welded, kept_apart, weld
from holdfast.scene.formats.robots.scopes import MOST_STEPS, Scope, truth
from holdfast.scene.formats.robots.sdf_links import USUAL_MASK
from holdfast.scene.xml import Element

Key = tuple[Scope, Element]  # models from the same file share elements


@dataclass(eq=False)
class LinkPlace:
    """A link in its model; ``held`` is True if it is fixed by itself."""

    scope: Scope
    element: Element
    held: bool

    @property
    def path(self) -> str:
        """Its name with those of the enclosing models."""
        return f"{self.scope.path}::{self.element.attribute('name')}"


Group = Welded[LinkPlace]  # links


def groups_of(world: Scope, held: Iterable[str], rigid: bool, notes: list[str]) -> list[Group]:
    """Return the groups of links that fixed joints hold together; models in ``held`` are fixed besides static ones.

    Movable joints are refused by name, unless all links that they join are fixed, or ``rigid`` is True: then they hold.
    """
    names = set(held)
    places = {
        (scope, element): LinkPlace(scope, element, scope.static or _is_held(scope, names))
        for scope in world.within()
        for element in scope.named.values()
        if element.tag == "link"
    }
    group = {key: Welded([place], place.held) for key, place in places.items()}
    movable = []
    for scope in world.within():
        for joint in scope.named.values():
            if joint.tag != "joint":
                continue
            ends = []
            for tag in ("parent", "child"):
                end = joint.needed(tag)
                ends.append(carrier(scope, end.text.strip(), end))
            if joint.attribute("type") == "fixed" or rigid:
                weld(
                    group,
                    [None if key is None else group[key] for key in ends],
                    lambda place: (place.scope, place.element),
                )
            if joint.attribute("type") != "fixed":
                movable.append((scope, joint, ends))
    loose = [(s, j) for s, j, ends in movable if not all(key is None or group[key].fixed for key in ends)]
    paths = [f"{scope.path}::{joint.attribute('name')}" for scope, joint in loose]
    named = listed(
        [f"{quoted(path)} ({joint.attribute('type')})" for path, (_, joint) in zip(paths, loose, strict=True)]
    )
    if loose and not rigid:
        remedy = "give rigid=True to weld them as they are, or fixed=[model]"
        loose[0][1].fail(f"can move; joints that can: {named}; a joint between bodies is no contact", remedy)
    if loose:
        notes.append(f"joints that hold as if welded: {named}")
    return list(dict.fromkeys(group.values()))


def _is_held(scope: Scope, names: set[str]) -> bool:
    inside: Scope | None = scope
    while inside is not None and inside.outer is not None:
        if inside.path in names:
            return True
        inside = inside.outer
    return False


def carrier(scope: Scope, name: str, asking: Element) -> Key | None:
    """Return the link that carries the link, frame, joint or model of this name, and None for the world."""
    for _ in range(MOST_STEPS):
        if name == "world":
            return None
        scope, found = scope.found(name, asking)
        if isinstance(found, Scope):
            scope, name = found, _canonical(found, asking)
        elif found.tag == "link":
            return scope, found
        elif found.tag == "joint":
            name = found.needed("child").text.strip()
        else:
            name = found.attributes.get("attached_to", "").strip() or "__model__"
            if scope.is_world and name == "__model__":
                return None
    return asking.fail(f"names {quoted(name)}, which is attached to itself", "break the circle")


def _canonical(model: Scope, asking: Element) -> str:
    """Return the name of the canonical link of a model: the one that it names, or its first link."""
    given = model.element.attributes.get("canonical_link", "").strip()
    links = [name for name, element in model.named.items() if element.tag == "link"]
    first = links[0] if links else next((f"{name}::__model__" for name in model.models), "")
    return given or first or asking.fail(f"names the model {quoted(model.name)}, which has no link", "name a link")


class Toucher(NamedTuple):
    """The data that decide what a collision may touch: its model, whether it touches others of it, and its bits."""

    model: Scope
    own: bool
    mask: int


def toucher(place: LinkPlace, mask: int) -> Toucher:
    """Return the data for a collision of a link with these bits (<collide_bitmask>)."""
    own = place.scope.touches_itself or truth(place.element, "self_collide")
    return Toucher(place.scope.whole, own, mask)


def excluded_pairs(bodies: Sequence[BodyParts], notes: list[str]) -> list[Excluded]:
    """Return the pairs of bodies that never touch, or of their parts if other parts may touch.

    These are links of one model without <self_collide>, and collisions that have no bit in common.
    """
    found = kept_apart(_candidates(bodies), _may)
    if found:
        notes.append(f"{len(found)} pairs of bodies or parts never touch (links of one model, collide_bitmask)")
    return found


def _may(of_a: Sequence[Toucher], of_b: Sequence[Toucher]) -> Bool:
    """Tell which parts of two bodies may touch; equal parts are only compared once."""
    known = {
        (x, y): bool(x.mask & y.mask) and (x.model is not y.model or x.own or y.own)
        for x, y in product(dict.fromkeys(of_a), dict.fromkeys(of_b))
    }
    if len(set(known.values())) == 1:
        return np.full((1, 1), next(iter(known.values())))
    return np.array([[known[x, y] for y in of_b] for x in of_a], dtype=bool)


def _candidates(bodies: Sequence[BodyParts]) -> Iterable[tuple[BodyParts, BodyParts]]:
    """Return the pairs of bodies that may be excluded: those of the same model, or all pairs if some have bits."""
    if not all(each.mask == USUAL_MASK for _, touchers in bodies for each in touchers):
        return combinations(bodies, 2)
    of_model: dict[Scope, list[int]] = {}
    for number, (_, touchers) in enumerate(bodies):
        for model in {each.model for each in touchers}:
            of_model.setdefault(model, []).append(number)
    pairs = {pair for numbers in of_model.values() for pair in combinations(numbers, 2)}
    return [(bodies[a], bodies[b]) for a, b in sorted(pairs)]
