"""The models of an SDF file and of included files, as nested scopes of names, and the poses of what they name."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TypeAlias
from urllib.parse import unquote

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.errors import nearest_of
from holdfast.base.files import read_ordinary
from holdfast.base.rigid import pose_from
from holdfast.base.text import quoted
from holdfast.scene.formats.links import pose_of
from holdfast.scene.formats.references import FUEL, References
from holdfast.scene.xml import MAX_BYTES, Element, parsed

MOST_STEPS = 200  # longest chain of frames that are relative or attached to each other
MOST_INCLUDES = 2_000  # largest number of included models of a scene
MOST_NAMES = 200_000  # largest number of links, frames, joints and models of a scene, with repetitions
MOST_LEVELS = 30  # largest depth of models in models
NAMED = ("link", "frame", "joint")
OWNER = "/openrobotics/"  # of Gazebo's own models in addresses of models
UNFELT = ("light", "actor")  # included elements that have no contacts
# The models that every world of Gazebo names, as they come with it; they are taken where no folder has them
GAZEBOS = {
    "sun": '<sdf version="1.5"><light type="directional" name="sun"/></sdf>',
    "ground_plane": """<sdf version="1.5"><model name="ground_plane"><static>true</static><link name="link">
      <collision name="collision"><geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
        <surface><friction><ode><mu>100</mu><mu2>50</mu2></ode></friction></surface></collision></link></model></sdf>""",
}


@dataclass(eq=False, repr=False)
class Scope:
    """A world or a model: its name, its named elements, and the models in it.

    ``outer`` is the scope that contains it. ``given`` is the element with its pose: its own element or the include.
    ``references`` finds the files to which it refers. ``merged`` says that its elements count as those of ``outer``.
    ``names`` holds the elements and models of this scope and of those merged into it, each with its scope.
    """

    name: str
    element: Element
    given: Element
    references: References
    outer: Scope | None
    static: bool
    merged: bool = False
    named: dict[str, Element] = field(default_factory=dict)
    models: dict[str, Scope] = field(default_factory=dict)
    names: dict[str, tuple[Scope, Element | Scope]] = field(default_factory=dict)

    @cached_property
    def touches_itself(self) -> bool:
        """Whether links of this model touch each other (<self_collide>)."""
        return truth(self.whole.element, "self_collide")

    @property
    def whole(self) -> Scope:
        """The model or world of which this is a part: itself, unless it was merged into another one."""
        return self.outer.whole if self.merged and self.outer else self

    @property
    def is_world(self) -> bool:
        """Whether this is the world, not a model."""
        return self.outer is None

    @property
    def path(self) -> str:
        """The names of the enclosing models and its own name, joined by two colons."""
        if self.outer is None:
            return ""
        if self.merged:
            return self.outer.path
        return f"{self.outer.path}::{self.name}" if self.outer.path else self.name

    def within(self) -> Iterator[Scope]:
        """Yield this scope and all below it."""
        yield self
        for model in self.models.values():
            yield from model.within()

    def found(self, name: str, asking: Element) -> tuple[Scope, Element | Scope]:
        """Return the scope to which a name such as ``arm::hand`` leads, and the element with that name."""
        scope, names, known = self, name.split("::"), self.whole.names
        if name in known:
            return known[name]
        for outer in names[:-1]:
            _, inside = scope.whole.names.get(outer, (scope, None))
            if not isinstance(inside, Scope):
                asking.fail(f"names {quoted(name)}: no model {quoted(outer)}", nearest_of(outer, scope.models))
            scope = inside
        last, known = names[-1], scope.whole.names
        if last == "__model__" and not scope.is_world:
            return scope, scope
        if last in known:
            return known[last]
        return asking.fail(f"names {quoted(name)}, which is not there", nearest_of(last, known))


def truth(element: Element, tag: str, default: bool = False) -> bool:
    """Return the truth value in a child, by default ``default``."""
    child = element.child(tag)
    if child is None:
        return default
    words = {"true": True, "1": True, "false": False, "0": False}
    word = child.text.strip().lower()
    return words[word] if word in words else child.fail(f"is {quoted(word)}", "needs true or false")


class ScopeReader:
    """Builds scopes, counts and caches the files that they include, and adds what it assumes to ``notes``."""

    def __init__(self, notes: list[str]) -> None:
        self.notes = notes
        self._files: dict[Path, Element] = {}
        self._included = self._named = 0

    def world(self, element: Element, references: References) -> Scope:
        """Return the scope of a world, or of a single model in a world of its own."""
        if element.tag == "model":
            around = Element("world", {}, element.file, element.line, [element])
            return self.world(around, references)
        scope = Scope(element.attributes.get("name", ""), element, element, references, None, False)
        self._fill(scope, (references.path.resolve(),), 0)
        return scope

    def _fill(self, scope: Scope, files: tuple[Path, ...], level: int) -> None:
        """Find the named elements of a scope; ``files`` is the chain of includes down to this file."""
        if level > MOST_LEVELS:
            scope.element.fail("lies in too many models", f"the limit is {MOST_LEVELS}")
        for child in scope.element.children:
            if child.tag in NAMED:
                self._add(scope, child.attribute("name"), child, child)
            elif child.tag == "model":
                static = scope.static or truth(child, "static")
                model = Scope(child.attribute("name"), child, child, scope.references, scope, static)
                self._add(scope, model.name, model, child)
                self._fill(model, files, level + 1)
            elif child.tag == "include":
                self._include(scope, child, files, level)

    def _add(self, scope: Scope, name: str, what: Element | Scope, element: Element) -> None:
        if name in scope.whole.names:
            element.fail("is the second of this name in its model or world", "names are unique there")
        self._named += 1
        if self._named > MOST_NAMES:
            element.fail("is one too many", f"the limit is {MOST_NAMES:,} links, frames, joints and models")
        old = element.tag == "link"  # files of old Gazebo call a link "model::link"
        if ("::" in name and not old) or name in ("world", "__model__", "__root__"):
            element.fail("has a name that SDF keeps for itself", "needs another")
        scope.whole.names[name] = scope, what
        if isinstance(what, Scope):
            scope.models[name] = what
        else:
            scope.named[name] = what

    def _include(self, scope: Scope, include: Element, files: tuple[Path, ...], level: int) -> None:
        """Add the model of another file; the name, pose and static of the include have priority."""
        self._included += 1
        if self._included > MOST_INCLUDES:
            include.fail("is one too many", f"the limit is {MOST_INCLUDES:,} included models")
        merged = include.attributes.get("merge", "").strip().lower() in ("true", "1")
        if merged and scope.is_world:
            include.fail("merges a model into the world", "include it without merge")
        known = _gazebos(scope.references, include)
        if known == "ground_plane":
            self.notes.append("ground_plane is in no folder: Gazebo's is taken, a plane with a friction of 50")
        path = Path(known) if known else _model_file(scope.references, include)
        real = path.resolve()
        if real in files:
            include.fail(f"includes {quoted(str(path))}, in which it lies", "break the circle")
        if real not in self._files:
            content = GAZEBOS[known].encode() if known else read_ordinary(path, "model file", most=MAX_BYTES)
            self._files[real] = parsed(content.decode("utf-8", "replace"), path)
        root = self._files[real]
        models = root.all("model")
        if not models and any(root.all(tag) for tag in UNFELT):
            return
        if root.tag != "sdf" or len(models) != 1:
            root.fail(f"is included and has {len(models)} models", "needs <sdf> with one <model>")
        element = models[0]
        renamed = include.child("name")
        name = element.attribute("name") if renamed is None else renamed.text.strip()
        overrides = include.child("pose") is not None or include.child("placement_frame") is not None
        static = scope.static or (not merged and truth(include, "static", truth(element, "static")))
        references = scope.references.beside(path)
        model = Scope(name, element, include if overrides else element, references, scope, static, merged)
        self._add(scope, f"_merged__{name}__model__" if merged else name, model, include)
        self._fill(model, (*files, real), level + 1)


def _gazebos(references: References, include: Element) -> str:
    """Return the name of the model of Gazebo that is included and has no folder; "" for any other."""
    uri = include.needed("uri").text.strip()
    fetched = FUEL.fullmatch(uri) if OWNER in uri.lower() else None
    folder = unquote(fetched[1] if fetched else uri.partition("model://")[2].strip("/"))
    name = folder.lower().replace(" ", "_") if fetched else folder
    return name if name in GAZEBOS and references.known_package(folder) is None else ""


def _model_file(references: References, include: Element) -> Path:
    """Return the file of an included model: itself, or the one of its folder."""
    uri = include.needed("uri")
    path = references.file(uri.text.strip(), uri.place)
    if not os.path.isdir(path):  # False for a name that is too long
        return path
    config, name = path / "model.config", "model.sdf"
    if os.path.isfile(config):
        listing = parsed(read_ordinary(config, "model.config", most=MAX_BYTES).decode("utf-8", "replace"), config)
        files = listing.all("sdf")
        name = files[-1].text.strip() if files else name  # the newest version comes last
        return References(config, None).file(name, listing.place)
    return path / name


def posed(element: Element) -> tuple[Float, str]:
    """Return the pose (4, 4) in an element's <pose>, by default the identity, and the name of its frame."""
    pose = element.child("pose")
    if pose is None:
        return np.eye(4), ""
    frame = pose.attributes.get("relative_to", pose.attributes.get("frame", "")).strip()
    if not pose.text.strip():
        return np.eye(4), frame
    form = pose.attributes.get("rotation_format", "euler_rpy")
    if form == "quat_xyzw":
        x, y, z, *turned = pose.values(7)
        if abs(np.linalg.norm(turned) - 1) > 1e-3:
            pose.fail(f"has a quaternion of length {np.linalg.norm(turned):.4g}", "needs length 1")
        return pose_from(np.array([x, y, z]), np.array([turned[3], *turned[:3]])), frame
    if form != "euler_rpy":
        pose.fail(f"rotation_format = {quoted(form)}", "needs euler_rpy or quat_xyzw")
    *xyz, roll, pitch, yaw = pose.values(6)
    degrees = pose.attributes.get("degrees", "").strip().lower() in ("true", "1")
    rpy = (roll, pitch, yaw)
    return pose_of(xyz, [math.radians(angle) for angle in rpy] if degrees else rpy), frame


Key: TypeAlias = tuple[Scope, Element | Scope]


class Frames:
    """The poses of all named elements in the world; each is computed once."""

    def __init__(self) -> None:
        self._known: dict[Key, Float] = {}
        self._asking: list[Key] = []

    def of(self, scope: Scope, what: Element | Scope) -> Float:
        """Return the pose (4, 4) in the world of a link, frame, joint or model in ``scope``."""
        key = (scope, what)  # models from the same file share elements
        if isinstance(what, Scope) and what.outer is None:
            return np.eye(4)
        element = what.given if isinstance(what, Scope) else what
        if key not in self._known:
            if key in self._asking:
                element.fail("has a pose that is relative to itself, by other frames", "break the circle")
            if len(self._asking) >= MOST_STEPS:
                element.fail("has a pose behind too many frames", f"the limit is {MOST_STEPS}")
            self._asking.append(key)
            self._known[key] = self._model(what) if isinstance(what, Scope) else self._element(scope, what)
            self._asking.pop()
        return self._known[key]

    def named(self, scope: Scope, name: str, asking: Element) -> Float:
        """Return the pose (4, 4) in the world of the element ``name`` in a scope; without a name, that of the scope."""
        if not name or (name == "world" and scope.is_world):
            return self.of(scope.outer or scope, scope)
        found_in, what = scope.found(name, asking)
        return self.of(what.outer or what, what) if isinstance(what, Scope) else self.of(found_in, what)

    def _element(self, scope: Scope, element: Element) -> Float:
        pose, frame = posed(element)
        if not frame and element.tag == "frame":
            frame = element.attributes.get("attached_to", "").strip()
        if not frame and element.tag == "joint":
            frame = element.needed("child").text.strip()
        return np.asarray(self.named(scope, frame, element) @ pose)

    def _model(self, model: Scope) -> Float:
        """Return the pose of a model; the file may give it as the pose of one of its frames."""
        assert model.outer is not None
        pose, frame = posed(model.given)
        at = self.named(model.outer, frame, model.given) @ pose
        child = model.given.child("placement_frame") if model.given.tag == "include" else None
        placed = (model.element.attributes.get("placement_frame", "") if child is None else child.text).strip()
        if not placed:
            return np.asarray(at)
        inner = _Within(model)
        return np.asarray(at @ np.linalg.inv(inner.named(model, placed, model.given)))


class _Within(Frames):
    """Poses within a model whose own pose is not known yet."""

    def __init__(self, model: Scope) -> None:
        super().__init__()
        self._known[model.outer or model, model] = np.eye(4)
