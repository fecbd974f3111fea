"""Reads SDF: a world, or a model, as Gazebo would load it; which links joints hold together, and what may touch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from holdfast.base.arrays import Bool, checked_name, checked_truth, checked_word
from holdfast.base.errors import nearest_of
from holdfast.base.text import listed, quoted
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats import links
from holdfast.scene.formats.links import FLOOR, BodyParts, Notes, Welded
from holdfast.scene.formats.made_meshes import Collision, MeshRules
from holdfast.scene.formats.references import Packages, References, model_folders
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.robots.scopes import MOST_STEPS, Frames, Scope, ScopeReader, truth
from holdfast.scene.formats.robots.sdf_links import ATTRIBUTES, KNOWN, RULES, USUAL_MASK, SdfLinks, coefficients
from holdfast.scene.formats.source import Source
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene
from holdfast.scene.xml import Element, parsed, root_name

USUAL_GRAVITY = (0.0, 0.0, -9.8)  # [m/s²] default of SDF


def sniff(source: Source) -> bool:
    """Tell whether the outermost element is <sdf>."""
    return root_name(source.text) == "sdf"


def read(
    source: Source,
    *,
    world: str | None = None,
    rigid: bool = False,
    fixed: Iterable[str] = (),
    floor: bool = False,
    friction: float | None = None,
    density: float | None = None,
    simulator: str | None = None,
    package: Packages | None = None,
    model_path: Iterable[str | Path] | None = None,
    collision: Collision = "mesh",
    up_axis: Literal["y", "z"] | None = None,
) -> Scene:
    """Return the scene of an SDF file.

    ``world`` names one of several worlds. ``fixed`` are names of models (``outer::inner``) that are fixed besides the
    static ones, and ``floor`` adds the half space below z = 0, with the friction of whatever lies on it. Movable joints
    are refused by name, unless ``rigid`` is True: then they hold. ``friction`` is the coefficient of surfaces and
    ``density`` [kg/m³] that of links for which the file gives none; without them, the defaults of SDF are used and
    noted: a coefficient of 1 and a mass of 1 kg. ``simulator``, "ode", "bullet" or "drake", chooses the friction tags.
    ``package`` maps the names of packages and models to folders, or is a function that does; ``model_path`` are folders
    in which models lie, also those that the file names by an address of Gazebo. With ``collision="hull"`` meshes are
    their convex hulls; a mapping says so for single models or links. ``up_axis`` is the axis that points up in mesh
    files.

    Raises SceneError or GeometryError if the file is malformed, or leaves out what is needed.
    """
    whole = parsed(source.text, source.path)
    root = _world(whole, world)
    notes, meshes = Notes(), MeshRules(up_axis, collision)
    references = References(source.path, package, models=model_folders(model_path, notes))
    top = ScopeReader(notes).world(root, references)
    models = [scope for scope in top.within() if not scope.is_world]
    names = [f"{scope.path}::{link.attribute('name')}" for scope in models for link in scope.element.all("link")]
    meshes.check_names([scope.path for scope in models] + names)
    friction, density = links.checked_defaults(friction, density)
    notes.unread([whole, *(scope.element for scope in top.within())], KNOWN, ATTRIBUTES)
    tags = _tags(root, top, simulator, notes)
    reader = SdfLinks(tags, Surfaces(RULES[tags]), friction, density, meshes, notes)
    fixed_names = links.checked_fixed(fixed, [scope.path for scope in top.within() if not scope.is_world], "model")
    groups = groups_of(top, fixed_names, checked_truth(rigid, "rigid"), notes)
    frames = Frames()
    found: list[BodyParts] = []
    count = Counter(group.members[0].scope.path for group in groups)
    for group in groups:
        first = group.members[0]
        name = first.scope.path if count[first.scope.path] == 1 else first.path
        found += _bodies(group, name, reader, frames)
    bodies, excluded = [body for body, _ in found], excluded_pairs(found, notes)
    if not bodies and not checked_truth(floor, "floor"):
        root.fail("has no link with a shape", "needs a <collision>")
    remedy = "give floor=True for a floor at z = 0, or fixed=[model]"
    bodies = links.with_floor(bodies, floor, root.place, remedy, problem="has nothing that is static")
    gravity = root.child("gravity")
    name = root.attributes.get("name") or source.path.stem
    return links.scene_of(
        bodies,
        reader.surfaces.table(FLOOR if floor else None),
        USUAL_GRAVITY if gravity is None else gravity.values(3),
        checked_name(name, f"{root.place}: name"),
        notes,
        excluded,
    )


def _world(root: Element, name: str | None) -> Element:
    """Return the world with this name, or the only world or model."""
    worlds = root.all("world")
    if name is not None:
        checked_name(name, "world")
        named = {each.attributes.get("name", ""): each for each in worlds}
        return named[name] if name in named else root.fail(f"has no world {quoted(name)}", nearest_of(name, named))
    found = worlds or root.all("model")
    if len(found) != 1:
        remedy = "name one with world=" if worlds else "needs one <world>, or one <model>"
        root.fail(f"has {len(worlds)} worlds and {len(root.all('model'))} models", remedy)
    return found[0]


def _tags(root: Element, top: Scope, simulator: str | None, notes: Notes) -> str:
    """Return the simulator whose friction tags count: the chosen one, or the one whose tags the file has.

    If the file has tags of ODE and Bullet, the physics of the world decides. Drake combines coefficients in another
    way, so a file with its tags and others raises SceneError unless one is chosen.
    """
    if simulator is not None:
        checked_word(simulator, RULES, "simulator")
    every = (link for scope in top.within() for link in scope.element.all("link"))
    collisions = [collision for link in every for collision in link.all("collision")]
    found = [tags for tags in RULES if any(coefficients(each, tags) for each in collisions)]
    if simulator is None and "drake" in found and len(found) > 1:
        problem = f"has friction for {' and '.join(found)}, which combine it in different ways"
        root.fail(problem, f"give simulator={found[0]!r}, or another")
    named = {physics.attributes.get("type") for physics in root.all("physics")}
    usual = "bullet" if len(found) > 1 and "bullet" in named else (*found, "ode")[0]
    chosen = simulator or usual
    if found:
        notes.append(f"friction: tags of {chosen}; of two surfaces it is their {RULES[chosen]}")
    return chosen


def _bodies(group: Group, name: str, reader: SdfLinks, frames: Frames) -> Iterator[BodyParts]:
    """Yield the body of a group and one for each plane, with the data that decide what they may touch."""
    content = [(place, reader.link(place.scope, place.element, group.fixed)) for place in group.members]
    first = group.members[0]
    base = frames.of(first.scope, first.element)
    inside = []
    for place, link in content:
        pose = frames.of(place.scope, place.element)
        marked = [piece._replace(mark=toucher(place, piece.mark)) for piece in link.pieces]
        at = np.eye(4) if pose is base else np.asarray(np.linalg.inv(base) @ pose)
        inside.append((at, link._replace(pieces=marked)))
    if not group.fixed:
        if any(isinstance(piece.shape, HalfSpace) for _, link in inside for piece in link.pieces):
            first.element.fail("has a <plane> and can move", "make its model static")
        if not any(link.pieces for _, link in inside):
            reader.notes.of(first.path, "has no shape, so it is left out")
    yield from links.bodies_of_links(name, inside, pose=base, fixed=group.fixed)


SDF = Format("SDF", (".sdf", ".world"), sniff, read, mark="<sdf>")


Key = tuple[Scope, Element]  # models from the same file share elements


@dataclass(eq=False)
class LinkPlace:
    """A link in its model; ``fixed`` is True if it is fixed by itself."""

    scope: Scope
    element: Element
    fixed: bool

    @property
    def path(self) -> str:
        """Its name with those of the enclosing models."""
        return f"{self.scope.path}::{self.element.attribute('name')}"


Group = Welded[LinkPlace]  # links


def groups_of(world: Scope, fixed_models: Iterable[str], rigid: bool, notes: list[str]) -> list[Group]:
    """Return the groups of links that fixed joints hold together; besides static models, ``fixed_models`` are fixed.

    Movable joints are refused by name, unless all links that they join are fixed, or ``rigid`` is True: then they hold.
    """
    names = set(fixed_models)
    places = {
        (scope, element): LinkPlace(scope, element, scope.static or _is_fixed(scope, names))
        for scope in world.within()
        for element in scope.named.values()
        if element.tag == "link"
    }
    group = {key: Welded([place], place.fixed) for key, place in places.items()}
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
                links.weld(
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


def _is_fixed(scope: Scope, names: set[str]) -> bool:
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
    inside = [name for name, element in model.named.items() if element.tag == "link"]
    first = inside[0] if inside else next((f"{name}::__model__" for name in model.models), "")
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
    found = links.kept_apart(_candidates(bodies), _may)
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
