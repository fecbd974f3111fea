"""Reads model directives of Drake (.dmd.yaml): models, frames, welds, poses of free bodies and collision filters."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked_truth
from holdfast.base.errors import SceneError, located, message
from holdfast.base.text import listed, quoted
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats import links
from holdfast.scene.formats.links import FLOOR, BodyParts, Notes
from holdfast.scene.formats.made_meshes import Collision, MeshRules
from holdfast.scene.formats.references import Packages, References, model_folders
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.robots.directives import (
    WORLD,
    Directive,
    FramePlace,
    LinkPose,
    ModelReader,
    WeldedLinks,
    directives_of,
)
from holdfast.scene.formats.source import Source
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene

DIRECTIVES = re.compile(r"^directives\s*:", re.MULTILINE)
RULE = "harmonic mean"  # how Drake combines two coefficients


def sniff(source: Source) -> bool:
    """Tell whether the file is YAML with the key ``directives``."""
    return source.suffix in (".yaml", ".yml") and DIRECTIVES.search(source.text) is not None


def read(
    source: Source,
    *,
    rigid: bool = False,
    fixed: Iterable[str] = (),
    floor: bool = False,
    friction: float | None = None,
    density: float | None = None,
    package: Packages | None = None,
    model_path: Iterable[str | Path] | None = None,
    collision: Collision = "mesh",
    up_axis: Literal["y", "z"] | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene that directives of Drake describe; each group of welded links is a body.

    A body has the name of its model (``outer::inner``), or of its first link if the model has several bodies. Models
    are SDF and URDF files. ``friction`` is the coefficient of surfaces without ``drake:mu_static``, by default 0.5 as
    in Drake; a pair takes the harmonic mean. The other options are those of SDF and URDF files.

    Raises SceneError or GeometryError if a file is malformed, or leaves out what is needed.
    """
    friction, density = links.checked_defaults(friction, density)
    notes, surfaces = Notes(), Surfaces(RULE)
    references = References(source.path, package, models=model_folders(model_path, notes))
    meshes = MeshRules(up_axis, collision, turns_gltf=True)
    models = ModelReader(surfaces, friction, density, checked_truth(rigid, "rigid"), meshes, notes)
    build = _Build(models)
    for directive in directives_of(source, references, notes):
        build.add(directive)
    where = str(source.path)
    notes.append(f"friction: tags of drake; of two surfaces it is their {RULE}")
    names = build.names()
    fixed_names = links.checked_fixed(fixed, list(names.values()))
    found = [parts for clump, name in names.items() for parts in build.bodies(clump, name, name in fixed_names)]
    remedy = f"weld a model to world, or give fixed=[name] ({listed(list(names.values()))}) or floor=True"
    everything = links.with_floor([parts.body for parts in found], floor, where, remedy)
    excluded = build.excluded(found)
    return links.scene_of(
        everything,
        surfaces.table(FLOOR if floor else None),
        gravity,
        source.path.name.partition(".")[0],
        notes,
        excluded,
    )


class _FreePose(NamedTuple):
    """The pose (4, 4) of a frame of a free body in another frame."""

    base: str
    pose: Float
    child: FramePlace
    directive: Directive


class _Build:
    """Adds directives one after the other, in the order of the file, as Drake does."""

    def __init__(self, models: ModelReader) -> None:
        self.models = models
        self.world = WeldedLinks([], np.eye(4), fixed=True)
        models.frames[WORLD] = FramePlace(self.world, np.eye(4))
        self.merged: dict[WeldedLinks, FramePlace] = {}  # links that were welded to others, and their poses there
        self.free: list[_FreePose] = []
        self.groups: dict[str, set[str]] = {}
        self.ignored: list[tuple[str, str, Directive]] = []
        self.instances: dict[str, list[WeldedLinks]] = {}
        self._poses: dict[WeldedLinks, Float] = {}

    def add(self, directive: Directive) -> None:
        """Carry out one directive."""
        match directive.kind:
            case "add_model":
                before = len(self.models.clumps)
                self.models.add(directive)
                name = directive.within(directive.text("name"))
                self.instances[name] = self.models.clumps[before:]
                for link, given in directive.map("default_free_body_pose").items():
                    base, pose = directive.transform(given, "default_free_body_pose")
                    if not link and len(self.instances[name]) != 1:
                        directive.fail("default_free_body_pose names no body", "name one, as the model has several")
                    first = self.instances[name][0].members[0].name
                    child = self.models.frame(f"{name}::{link}" if link else first, directive)
                    self.free.append(_FreePose(directive.within(base or WORLD), pose, child, directive))
            case "add_frame":
                self._frame(directive)
            case "add_weld":
                self._weld(directive)
            case "add_collision_filter_group":
                self._filter(directive)

    def _frame(self, directive: Directive) -> None:
        name = directive.text("name")
        base, pose = directive.transform(directive.values.get("X_PF"), "X_PF")
        if base is None:
            directive.fail("X_PF has no base_frame", "name the frame in which it is")
        at = self.models.frame(directive.within(base), directive)
        if "::" in name or base == WORLD:
            full = directive.within(name)
        else:  # the frame belongs to the model of its base
            full = f"{directive.within(base).rpartition('::')[0]}::{name}"
        if full in self.models.frames:
            directive.fail(f"the frame {quoted(full)} is there already", "names are unique")
        self.models.frames[full] = FramePlace(at.clump, at.pose @ pose)

    def _weld(self, directive: Directive) -> None:
        """Merge the links of the child into those of the parent; its links keep their place relative to each other."""
        parent, child = (self._now(self.models.frame(directive.within(directive.text(key)), directive))
                         for key in ("parent", "child"))  # fmt: skip
        given = directive.values.get("X_PC")
        base, pose = directive.transform(given, "X_PC") if given is not None else (None, np.eye(4))
        if base is not None:
            directive.fail("X_PC has a base_frame", "give it to the frame of the parent")
        if parent.clump is child.clump:
            directive.fail("welds two frames of one body", "leave it out")
        seat = parent.pose @ pose @ np.linalg.inv(child.pose)
        into, gone = parent.clump, child.clump
        if gone.fixed:
            into, gone, seat = gone, into, np.linalg.inv(seat)
        if gone.fixed:
            directive.fail("welds two bodies that are fixed already", "leave out one of the welds, or <static>")
        if into is self.world:
            gone.fixed, gone.pose = True, seat
            return
        into.members += [LinkPose(each.name, seat @ each.pose, each.read) for each in gone.members]
        self.merged[gone] = FramePlace(into, seat)

    def _now(self, at: FramePlace) -> FramePlace:
        """Return a frame among the links to which its own were welded."""
        while at.clump in self.merged:
            into, seat = self.merged[at.clump]
            at = FramePlace(into, seat @ at.pose)
        return at

    def _filter(self, directive: Directive) -> None:
        space = directive.values.get("model_namespace")
        prefix = f"{directive.text('model_namespace')}::" if space is not None and not directive.namespace else ""
        name = directive.within(prefix + directive.text("name"))
        members = set()
        for each in directive.names("members"):
            full = directive.within(prefix + each)
            self.models.frame(full, directive)
            members.add(full)
        for each in directive.names("member_groups"):
            members |= self.groups.get(directive.within(prefix + each), set())
        self.groups.setdefault(name, set()).update(members)
        for each in directive.names("ignored_collision_filter_groups"):
            self.ignored.append((name, directive.within(prefix + each), directive))

    def names(self) -> dict[WeldedLinks, str]:
        """Return the name of each body that is left after all welds."""
        left = [clump for clump in self.models.clumps if clump not in self.merged]
        several = {name for name, clumps in self.instances.items() if len(clumps) > 1}
        names = {}
        for clump in left:
            model, _, link = clump.members[0].name.rpartition("::")
            names[clump] = f"{model}::{link}" if model in several or model not in self.instances else model
        return names

    def bodies(self, clump: WeldedLinks, name: str, fixed_by_name: bool) -> list[BodyParts]:
        """Return the bodies of links that move as one, each plane by itself, marked with the names of links."""
        fixed = fixed_by_name or clump.fixed
        home = self._pose(clump)
        inside = []
        for member in clump.members:
            content = member.read(fixed)
            named = [piece._replace(mark=member.name) for piece in content.pieces]
            inside.append((member.pose, content._replace(pieces=named)))
        pieces = [piece for _, content in inside for piece in content.pieces]
        if not fixed and any(isinstance(piece.shape, HalfSpace) for piece in pieces):
            raise SceneError(message(f"body {quoted(name)}", "has a <plane> and can move", "weld it to world"))
        if not pieces:
            self.models.notes.of(name, "has no shape, so it is left out")
        with located(f"body {quoted(name)}"):
            return list(links.bodies_of_links(name, inside, pose=home, fixed=fixed))

    @cached_property
    def _given(self) -> dict[WeldedLinks, _FreePose]:
        """What the last directive says of the pose of each group of links, once all directives are carried out."""
        return {self._now(free.child).clump: free for free in self.free}

    def _pose(self, clump: WeldedLinks) -> Float:
        """Return the pose (4, 4) of welded links in the world: as a directive says, else as its file does.

        Poses may be relative to others in a long chain and in any order.
        """
        chain: dict[WeldedLinks, Float] = {}  # the poses of groups of links, each in the next
        while clump not in self._poses and clump is not self.world and not clump.fixed and clump in self._given:
            last = self._given[clump]
            if clump in chain:
                last.directive.fail("the pose of a body is relative to itself, by others", "break the circle")
            base = self._now(self.models.frame(last.base, last.directive))
            chain[clump] = base.pose @ last.pose @ np.linalg.inv(self._now(last.child).pose)
            clump = base.clump
        pose = np.eye(4) if clump is self.world else self._poses.get(clump, clump.pose)
        for above, within in reversed(chain.items()):
            pose = self._poses[above] = np.asarray(pose @ within)
        return pose

    def excluded(self, bodies: list[BodyParts]) -> list[Excluded]:
        """Return the pairs that collision filter groups keep apart."""
        apart: set[frozenset[str]] = set()
        for first, second, directive in self.ignored:
            for name in (first, second):
                if name not in self.groups:
                    directive.fail(f"names the group {quoted(name)}, which is not there", "add it")
            apart |= {frozenset((a, b)) for a in self.groups[first] for b in self.groups[second]}
        if not apart:
            return []
        return links.kept_apart(
            combinations(bodies, 2),
            lambda of_a, of_b: np.array([[frozenset((x, y)) not in apart for y in of_b] for x in of_a]),
        )


DRAKE = Format("Drake directives", (".yaml", ".yml"), sniff, read, mark="`directives`")
