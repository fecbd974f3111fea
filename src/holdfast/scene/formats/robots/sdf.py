"""Reads SDF: a world, or a single model, as Gazebo would load it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Literal

import numpy as np

from holdfast.base.arrays import checked_name, checked_truth, checked_word
from holdfast.base.errors import nearest_of
from holdfast.base.text import quoted
from holdfast.scene.formats.links import (
    FLOOR,
    BodyParts,
    Notes,
    bodies_of_links,
    checked_defaults,
    checked_fixed,
    scene_of,
    with_floor,
)
from holdfast.scene.formats.made_meshes import Collision, MeshRules
from holdfast.scene.formats.references import Packages, References, model_folders
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.robots.scopes import Frames, Scope, ScopeReader
from holdfast.scene.formats.robots.sdf_joints import Group, excluded_pairs, groups_of, toucher
from holdfast.scene.formats.robots.sdf_links import ATTRIBUTES, KNOWN, RULES, SdfLinks, coefficients
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
    links = [f"{scope.path}::{link.attribute('name')}" for scope in models for link in scope.element.all("link")]
    meshes.check_names([scope.path for scope in models] + links)
    friction, density = checked_defaults(friction, density)
    notes.unread([whole, *(scope.element for scope in top.within())], KNOWN, ATTRIBUTES)
    tags = _tags(root, top, simulator, notes)
    reader = SdfLinks(tags, Surfaces(RULES[tags]), friction, density, meshes, notes)
    held = checked_fixed(fixed, [scope.path for scope in top.within() if not scope.is_world], "model")
    groups = groups_of(top, held, checked_truth(rigid, "rigid"), notes)
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
    bodies = with_floor(bodies, floor, root.place, remedy, problem="has nothing that is static")
    gravity = root.child("gravity")
    name = root.attributes.get("name") or source.path.stem
    return scene_of(
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
    links = (link for scope in top.within() for link in scope.element.all("link"))
    collisions = [collision for link in links for collision in link.all("collision")]
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
    links = [(place, reader.link(place.scope, place.element, group.fixed)) for place in group.members]
    first = group.members[0]
    base = frames.of(first.scope, first.element)
    inside = []
    for place, link in links:
        pose = frames.of(place.scope, place.element)
        marked = [piece._replace(mark=toucher(place, piece.mark)) for piece in link.pieces]
        at = np.eye(4) if pose is base else np.asarray(np.linalg.inv(base) @ pose)
        inside.append((at, link._replace(pieces=marked)))
    if not group.fixed:
        if any(isinstance(piece.shape, HalfSpace) for _, link in inside for piece in link.pieces):
            first.element.fail("has a <plane> and can move", "make its model static")
        if not any(link.pieces for _, link in inside):
            reader.notes.of(first.path, "has no shape, so it is left out")
    yield from bodies_of_links(name, inside, pose=base, fixed=group.fixed)


SDF = Format("SDF", (".sdf", ".world"), sniff, read, mark="<sdf>")
