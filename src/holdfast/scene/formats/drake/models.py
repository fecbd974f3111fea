"""The models that directives add, from SDF and URDF files: links in groups that move as one, with their frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked_number
from holdfast.base.errors import nearest_of
from holdfast.base.files import read_ordinary
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Inertial
from holdfast.scene.formats.drake.directives import Directive
from holdfast.scene.formats.links import Notes, Piece
from holdfast.scene.formats.made_meshes import MeshRules
from holdfast.scene.formats.references import References
from holdfast.scene.formats.sdf.scopes import Frames, Scope, ScopeReader
from holdfast.scene.formats.sdf.sdf_joints import carrier
from holdfast.scene.formats.sdf.sdf_joints import groups_of as sdf_groups
from holdfast.scene.formats.sdf.sdf_links import ATTRIBUTES as SDF_ATTRIBUTES
from holdfast.scene.formats.sdf.sdf_links import KNOWN as SDF_KNOWN
from holdfast.scene.formats.sdf.sdf_links import LinkReader as SdfLinks
from holdfast.scene.formats.sdf.sdf_links import Plane
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.formats.urdf.tree import groups_of as urdf_groups
from holdfast.scene.formats.urdf.urdf_links import ATTRIBUTES as URDF_ATTRIBUTES
from holdfast.scene.formats.urdf.urdf_links import KNOWN as URDF_KNOWN
from holdfast.scene.formats.urdf.urdf_links import LinkReader as UrdfLinks
from holdfast.scene.xml import MAX_BYTES, Element, parsed

WORLD = "world"


class Content(NamedTuple):
    """The shapes of a link, its planes, and its mass if it is known, all in its own frame."""

    pieces: list[Piece]
    planes: list[Plane]
    inertial: Inertial | None


class Member(NamedTuple):
    """A link: its full name, its pose (4, 4) in its group, and a function that reads it, fixed or not."""

    name: str
    pose: Float
    read: Callable[[bool], Content]


@dataclass(eq=False)
class Clump:
    """Links that move as one, the pose (4, 4) of the group in the world as its file says, and whether it is fixed."""

    members: list[Member]
    pose: Float
    fixed: bool = False


class At(NamedTuple):
    """A frame: the clump that carries it and its pose (4, 4) there."""

    clump: Clump
    pose: Float


@dataclass
class ModelReader:
    """Reads model files, with the rules for what they leave out; ``frames`` maps full names to frames."""

    surfaces: Surfaces
    friction: float | None
    density: float | None
    rigid: bool
    meshes: MeshRules
    notes: Notes
    clumps: list[Clump] = field(default_factory=list)
    frames: dict[str, At] = field(default_factory=dict)

    def add(self, directive: Directive) -> None:
        """Add the model of a directive ``add_model``."""
        name = directive.within(directive.text("name"))
        path = directive.references.file(directive.text("file"), directive.where)
        text = read_ordinary(path, "model file", most=MAX_BYTES).decode("utf-8", "replace")
        root = parsed(text, path)
        references = directive.references.beside(path)
        before = len(self.clumps)
        if f"{name}::" in {full[: len(name) + 2] for full in self.frames}:
            directive.fail(f"the model {quoted(name)} is there already", "names of models are unique")
        if root.tag == "sdf":
            self._sdf(root, name, references, directive)
        elif root.tag == "robot":
            self._urdf(root, name, references, directive, path)
        else:
            directive.fail(f"{quoted(path.name)} is a <{root.tag}>", "reads SDF (<sdf>) and URDF (<robot>) models")
        if len(self.clumps) == before:
            directive.fail(f"{quoted(path.name)} has no links", "needs at least one")

    def frame(self, name: str, directive: Directive) -> At:
        """Return a frame by its full name or, without a namespace, by a last name that only one frame has."""
        if name in self.frames:
            return self.frames[name]
        if "::" not in name:
            found = [at for full, at in self.frames.items() if full.rpartition("::")[2] == name]
            if len(found) == 1:
                return found[0]
            if found:
                several = listed([full for full in self.frames if full.rpartition("::")[2] == name], 3)
                directive.fail(f"names {quoted(name)}, which may be {several}", "write the model before it")
        return directive.fail(f"names the frame {quoted(name)}, which is not there", nearest_of(name, self.frames))

    def _sdf(self, root: Element, name: str, references: References, directive: Directive) -> None:
        models = root.all("model")
        if len(models) != 1 or root.all("world"):
            directive.fail(f"{quoted(root.file)} has {len(models)} models and {len(root.all('world'))} worlds",
                           "needs one <model>")  # fmt: skip
        for joint, value in directive.map("default_joint_positions").items():
            if any(checked_number(each, f"{directive.where}: {joint}") for each in _list(value)):
                directive.fail(f"joint {quoted(joint)} of an SDF model has a position", "reads those of URDF models")
        top = ScopeReader(self.notes).world(models[0], references)
        self.notes.unread([scope.element for scope in top.within()], SDF_KNOWN, SDF_ATTRIBUTES)
        links = SdfLinks("drake", self.surfaces, self.friction, self.density, self.meshes, self.notes)
        frames = Frames()
        (model,) = top.models.values()
        cut = len(model.name)

        def full(scope: Scope, last: str) -> str:
            return f"{name}{scope.path[cut:]}::{last}"

        for group in sdf_groups(top, (), self.rigid, self.notes):
            first = group.members[0]
            base = frames.of(first.scope, first.element)
            clump = Clump([], base, group.fixed)
            for place in group.members:
                pose = np.linalg.inv(base) @ frames.of(place.scope, place.element)
                own = full(place.scope, place.element.attribute("name"))
                clump.members.append(Member(own, pose, _sdf_link(links, place.scope, place.element)))
                self.frames[own] = At(clump, pose)
            self.clumps.append(clump)
        for scope in top.within():
            if scope.is_world:
                continue
            others = [each for each, what in scope.named.items() if what.tag != "link"]
            for last in [*others, "__model__"]:
                key = carrier(scope, last, scope.element)
                if key is not None:
                    at = self.frames[full(key[0], key[1].attribute("name"))]
                    pose = np.linalg.inv(frames.of(*key)) @ frames.named(scope, last, scope.element)
                    self.frames[full(scope, last)] = At(at.clump, at.pose @ pose)

    def _urdf(self, root: Element, name: str, references: References, directive: Directive, path: Path) -> None:
        positions = {}
        for joint, value in directive.map("default_joint_positions").items():
            given = _list(value)
            if len(given) != 1:
                directive.fail(f"joint {quoted(joint)} has {len(given)} positions", "reads those of one number")
            positions[joint] = checked_number(given[0], f"{directive.where}: {joint}")
        self.notes.unread([root], URDF_KNOWN, URDF_ATTRIBUTES)
        links = {link.attribute("name"): link for link in root.all("link")}
        reader = UrdfLinks(root, references, "drake", self.friction, self.meshes, self.notes)
        reader.surfaces = self.surfaces
        for group in urdf_groups(root, links, positions, self.rigid, self.notes):
            clump = Clump([], group.pose, group.top == WORLD and not links[WORLD].children)
            for link, pose in group.links.items():
                own = f"{name}::{link}"
                clump.members.append(Member(own, pose, _urdf_link(reader, links[link], self.density, directive)))
                self.frames[own] = At(clump, pose)
            self.clumps.append(clump)


def _list(value: object) -> list[object]:
    return value if isinstance(value, list) else [value]


def _sdf_link(links: SdfLinks, scope: Scope, element: Element) -> Callable[[bool], Content]:
    def read(fixed: bool) -> Content:
        found = links.link(scope, element, fixed)
        return Content([each.piece for each in found.contents], found.planes, found.inertial)

    return read


def _urdf_link(
    reader: UrdfLinks, link: Element, density: float | None, directive: Directive
) -> Callable[[bool], Content]:
    def read(fixed: bool) -> Content:
        pieces = reader.pieces(link)
        inertial = None if fixed else reader.inertial(link, pieces, density)
        if pieces and not fixed and inertial is None:
            link.fail("has no mass", "give density=")
        return Content(pieces, [], inertial)

    return read
