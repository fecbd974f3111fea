"""The directives of a .dmd.yaml file and of the files that it adds, and the models that they add, as groups."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.borders.foreign import YAML, spend
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.ranges import PLACE
from holdfast.base.text import listed, quoted
from holdfast.scene.formats.links import LinkContent, Notes, not_read, pose_of
from holdfast.scene.formats.made_meshes import MeshRules
from holdfast.scene.formats.references import References
from holdfast.scene.formats.robots.scopes import Frames, Scope, ScopeReader
from holdfast.scene.formats.robots.sdf import carrier
from holdfast.scene.formats.robots.sdf import groups_of as sdf_groups
from holdfast.scene.formats.robots.sdf_links import ATTRIBUTES as SDF_ATTRIBUTES
from holdfast.scene.formats.robots.sdf_links import KNOWN as SDF_KNOWN
from holdfast.scene.formats.robots.sdf_links import SdfLinks
from holdfast.scene.formats.robots.urdf_links import ATTRIBUTES as URDF_ATTRIBUTES
from holdfast.scene.formats.robots.urdf_links import KNOWN as URDF_KNOWN
from holdfast.scene.formats.robots.urdf_links import UrdfLinks
from holdfast.scene.formats.robots.urdf_links import groups_of as urdf_groups
from holdfast.scene.formats.source import PlainMap, Source, from_yaml
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.xml import MAX_BYTES, Element, parsed

MOST_FILES = 1_000  # largest number of files of directives that a scene may add
# the keys of each directive
KEYS = {
    "add_model": ("name", "file", "default_joint_positions", "default_free_body_pose"),
    "add_model_instance": ("name",),
    "add_frame": ("name", "X_PF"),
    "add_weld": ("parent", "child", "X_PC"),
    "add_collision_filter_group": (
        "name", "model_namespace", "members", "member_groups", "ignored_collision_filter_groups",
    ),
    "add_directives": ("file", "model_namespace"),
}  # fmt: skip
POSE_KEYS = ("base_frame", "translation", "rotation")
WORLD = "world"


@dataclass(frozen=True)
class Directive(PlainMap):
    """One directive: its ``kind``, its keys and values, the namespace in which its names are, and its place."""

    kind: str
    values: Mapping[str, Any]
    namespace: str
    where: str
    references: References

    def names(self, key: str) -> list[str]:
        """Return a list of texts, by default empty."""
        value = self.values.get(key) or []
        if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
            self.fail(f"{key} is {quoted(value, 60)}", "needs a list of names")
        return value

    def map(self, key: str) -> dict[str, Any]:
        """Return a mapping, by default empty."""
        value = self.values.get(key) or {}
        return value if isinstance(value, dict) else self.fail(f"{key} is {quoted(value, 60)}", "needs keys and values")

    def within(self, name: str) -> str:
        """Return the full name of something that this directive names."""
        return name if name == WORLD or not self.namespace else f"{self.namespace}::{name}"

    def transform(self, value: Any, key: str) -> tuple[str | None, Float]:  # noqa: ANN401 - plain data
        """Return the name of the base frame, if there is one, and the pose (4, 4) of a transform."""
        if not isinstance(value, dict):
            self.fail(f"{key} is {quoted(value, 60)}", "needs base_frame, translation, rotation")
        self.check(value, POSE_KEYS, key)
        base = value.get("base_frame")
        if base is not None and not isinstance(base, str):
            self.fail(f"{key}: base_frame is {quoted(base)}", "needs the name of a frame")
        where = f"{self.where}: {key}"
        given = self._plain(value.get("translation", [0, 0, 0]), f"{key}: translation")
        pose = np.eye(4)
        pose[:3, :3] = self._rotation(value.get("rotation") or {}, key)
        pose[:3, 3] = checked(given, (3,), f"{where}: translation", within=PLACE)
        return base, pose

    def _plain(self, value: Any, what: str) -> Any:  # noqa: ANN401 - plain data
        tag = next(iter(value), "") if isinstance(value, dict) else ""
        if tag.startswith("!"):
            self.fail(f"{what} is drawn at random ({tag})", "write the value out")
        return value

    def _rotation(self, value: Any, key: str) -> Float:  # noqa: ANN401 - plain data
        where = f"{self.where}: {key}: rotation"
        match value:
            case {"!Rpy": {"deg": deg, **rest}} if not rest:
                angles = checked(self._plain(deg, f"{key}: deg"), (3,), where)
                return pose_of((0, 0, 0), np.radians(angles).tolist())[:3, :3]
            case {"!AngleAxis": {"angle_deg": angle, "axis": axis, **rest}} if not rest:
                turn = checked_number(self._plain(angle, f"{key}: angle_deg"), where)
                along = checked(self._plain(axis, f"{key}: axis"), (3,), where)
                length = float(np.linalg.norm(along))
                if not length > 0:
                    self.fail(f"{key}: axis is zero", "needs a direction")
                return np.asarray(Rotation.from_rotvec(np.radians(turn) * along / length).as_matrix())
            case {} if value in ({}, {"!Identity": {}}):
                return np.eye(3)
        tag = next(iter(value), "") if isinstance(value, dict) else ""
        if tag == "!Uniform":
            self.fail(f"{key}: rotation is drawn at random (!Uniform)", "write the value out")
        return self.fail(
            f"{key}: rotation is {quoted(value, 60)}",
            "needs !Rpy {deg: [r, p, y]}, !AngleAxis {angle_deg: a, axis: [x, y, z]} or !Identity {}",
        )

    def check(self, values: Mapping[str, Any], known: Iterable[str], what: str) -> None:
        """Raise SceneError for a key that is not known, as Drake does."""
        for key in values:
            if key not in known:
                self.fail(f"unknown key {quoted(key)} in {what}", nearest_of(key, list(known)))


def directives_of(source: Source, references: References, notes: list[str]) -> list[Directive]:
    """Return all directives of a file and of those that it adds, in order."""
    return list(_Files(notes).read(source, references, "", ()))


class _Files:
    """Reads files of directives, and counts them."""

    def __init__(self, notes: list[str]) -> None:
        self.notes = notes
        self.count = 0

    def read(
        self, source: Source, references: References, namespace: str, above: tuple[str, ...]
    ) -> Iterator[Directive]:
        where, here = str(source.path), str(source.path.resolve())
        self.count += 1
        if self.count > MOST_FILES:
            raise SceneError(message(where, "is one file too many", f"the limit is {MOST_FILES:,}"))
        if here in above:
            raise SceneError(message(where, "adds itself", "break the circle"))
        data = from_yaml(source.text, where, tags=True)
        found = data.get("directives") if isinstance(data, dict) else None
        if not isinstance(found, list):
            raise SceneError(message(where, "has no list of directives", "needs `directives:` with a list"))
        unread = [key for key in data if key != "directives"]
        self.notes += not_read(Counter(map(str, unread)))
        for each in found:  # before the first one is parsed
            added = each.get("add_directives") if isinstance(each, dict) else None
            if isinstance(added, dict) and isinstance(added.get("file"), str):
                spend(YAML, check_ordinary(references.file(added["file"], where), "file of directives"), where)
        for number, each in enumerate(found):
            one = Directive("", each if isinstance(each, dict) else {}, namespace, f"{where}: directives[{number}]",
                            references)  # fmt: skip
            kind = next(iter(one.values), "")
            if len(one.values) != 1 or kind not in KEYS:
                one.fail(f"is {quoted(each, 60)}", f"needs one of {', '.join(KEYS)}")
            values = each[kind]
            one = Directive(kind, values if isinstance(values, dict) else {}, namespace, f"{one.where}: {kind}",
                            references)  # fmt: skip
            if not isinstance(values, dict):
                one.fail(f"is {quoted(values, 60)}", f"needs {', '.join(KEYS[kind])}")
            one.check(values, KEYS[kind], kind)
            if kind != "add_directives":
                yield one
                continue
            path = references.file(one.text("file"), one.where)
            inner = one.values.get("model_namespace")
            below = one.within(one.text("model_namespace")) if inner is not None else namespace
            yield from self.read(Source(path), references.beside(path), below, (*above, here))


class LinkPose(NamedTuple):
    """A link: its full name, its pose (4, 4) in its group, and a function that reads it, fixed or not."""

    name: str
    pose: Float
    read: Callable[[bool], LinkContent]


@dataclass(eq=False)
class WeldedLinks:
    """Links that move as one, the pose (4, 4) of the group in the world as its file says, and whether it is fixed."""

    members: list[LinkPose]
    pose: Float
    fixed: bool = False


class FramePlace(NamedTuple):
    """A frame: the links that carry it and its pose (4, 4) there."""

    clump: WeldedLinks
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
    clumps: list[WeldedLinks] = field(default_factory=list)
    frames: dict[str, FramePlace] = field(default_factory=dict)

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
            self._urdf(root, name, references, directive)
        else:
            directive.fail(f"{quoted(path.name)} is a <{root.tag}>", "reads SDF (<sdf>) and URDF (<robot>) models")
        if len(self.clumps) == before:
            directive.fail(f"{quoted(path.name)} has no links", "needs at least one")

    def frame(self, name: str, directive: Directive) -> FramePlace:
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
            clump = WeldedLinks([], base, group.fixed)
            for place in group.members:
                pose = np.linalg.inv(base) @ frames.of(place.scope, place.element)
                own = full(place.scope, place.element.attribute("name"))
                clump.members.append(LinkPose(own, pose, partial(links.link, place.scope, place.element)))
                self.frames[own] = FramePlace(clump, pose)
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
                    self.frames[full(scope, last)] = FramePlace(at.clump, at.pose @ pose)

    def _urdf(self, root: Element, name: str, references: References, directive: Directive) -> None:
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
            clump = WeldedLinks([], group.pose, group.top == WORLD and not links[WORLD].children)
            for link, pose in group.links.items():
                own = f"{name}::{link}"
                clump.members.append(LinkPose(own, pose, _urdf_link(reader, links[link], self.density)))
                self.frames[own] = FramePlace(clump, pose)
            self.clumps.append(clump)


def _list(value: object) -> list[object]:
    return value if isinstance(value, list) else [value]


def _urdf_link(reader: UrdfLinks, link: Element, density: float | None) -> Callable[[bool], LinkContent]:
    def read(fixed: bool) -> LinkContent:
        pieces = reader.pieces(link)
        inertial = None if fixed else reader.inertial(link, pieces, density)
        if pieces and not fixed and inertial is None:
            link.fail("has no mass", "give density=")
        return LinkContent(pieces, inertial)

    return read
