"""The data that holdfast writes to glTF files, in the ``extras`` of the scene and of nodes under ``holdfast``.

The scene has friction, gravity, excluded pairs and its name; a node has the mass of its body, whether it is fixed, its
material, and its shape if that is not just a mesh. The mesh of a node may have been edited since: ``surface`` is a
checksum of the mesh that was written, and if it does not match, the mesh counts.
"""

from __future__ import annotations

import zlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

import numpy as np
from pydantic import BaseModel, Field

from holdfast.base.arrays import Float, Int
from holdfast.base.text import listed
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound, Shape
from holdfast.scene.excluded import Excluded, excluded_among
from holdfast.scene.formats.entries import (
    EntryModel,
    FrictionModel,
    Matrix3,
    Number,
    Triple,
    Truth,
    friction_data,
    friction_of,
    validated,
)
from holdfast.scene.formats.named_meshes import Known, Weight, split
from holdfast.scene.formats.native import FORMAT, AnyModel, EndModel, excluded_data, shape_data, shape_of
from holdfast.scene.friction import STRENGTHS, Friction
from holdfast.scene.meshes.by_trimesh import Node
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

KEY = "holdfast"
FAR = 16.0  # [sizes of the mesh] if a mesh is farther from its frame, its node gets an own frame, for precision

M = TypeVar("M", bound=BaseModel)


class SceneWords(EntryModel):
    """The data of the scene."""

    format: Literal["holdfast-scene/1"]
    name: str = ""
    gravity: Triple
    friction: FrictionModel
    excluded: list[tuple[EndModel, EndModel]] = Field([], fail_fast=True)


class BodyWords(EntryModel):
    """The data of a node about its body; numbers are as in a scene file."""

    surface: str
    shape: Annotated[AnyModel, Field(discriminator="type")] | None = None
    noise: Number = 0.0
    origin: Triple | None = None
    mass: Number | None = None
    density: Number | None = None
    com: Triple | None = None
    inertia: Matrix3 | None = None
    material: str | None = None
    fixed: Truth = False
    top_load: Number | None = None
    pressure: Number | None = None


class Drawn(NamedTuple):
    """The mesh of a node: vertices (V, 3) and triangles (T, 3), and its position (3,) [m] in the body frame."""

    vertices: Float
    faces: Int
    origin: Float


def drawn(shape: Shape) -> Drawn:
    """Return the mesh of a shape as it is in a glTF file."""
    if not isinstance(shape, Mesh):
        return Drawn(shape.surface.vertices, shape.surface.faces, np.zeros(3))
    low, high = shape.vertices.min(0), shape.vertices.max(0)
    far = np.abs((low + high) / 2).max() > FAR * np.ptp(shape.vertices, axis=0).max()
    origin = np.asarray((low + high) / 2 if far else np.zeros(3))
    return Drawn(shape.vertices - origin, shape.faces, origin)


def scene_data(scene: Scene) -> dict[str, Any]:
    """Return the extras of the scene."""
    data: dict[str, Any] = {"format": FORMAT, "name": scene.name, "gravity": scene.gravity.tolist()}
    data["friction"] = friction_data(scene.friction)
    return {KEY: data | excluded_data(scene)}


def body_data(body: Body, shown: Drawn) -> dict[str, Any]:
    """Return the extras of the node of a body.

    A mesh is in the file in single precision, so data that follow from the exact shape are written, too.
    """
    data: dict[str, Any] = {"surface": checksum(shown.vertices, shown.faces)}
    com, inertia, density = body.com, body.inertia, body.density
    if isinstance(body.shape, Mesh):
        density = None
        data |= {"noise": body.shape.noise} if body.shape.noise else {}
        data |= {"origin": shown.origin.tolist()} if shown.origin.any() else {}
        if not body.fixed:
            com = body.com_body
            inertia = body.inertia_com if inertia is not None or body.shape.is_closed else None
    else:
        data["shape"] = shape_data(body.shape, None)
    data |= {"mass": body.mass} if density is None else {"density": density}
    data |= {"com": None if com is None else com.tolist(), "inertia": None if inertia is None else inertia.tolist()}
    data |= {"material": body.material, "fixed": body.fixed or None}
    data |= {"top_load": body.top_load, "pressure": body.pressure}
    return {KEY: {key: value for key, value in data.items() if value is not None}}


def checksum(vertices: Float, faces: Int) -> str:
    """Return a checksum of a mesh in single precision, as it is in a file."""
    return f"{zlib.crc32(vertices.astype('<f4').tobytes() + faces.astype('<u4').tobytes()):08x}"


def _words(model: type[M], extras: Any, path: Path) -> M | None:  # noqa: ANN401
    """Return the data of a scene or a node, or None if there are none; raise SceneError if they are malformed."""
    data = extras.get(KEY) if isinstance(extras, dict) else None
    return None if data is None else validated(model, data, path)


@dataclass(frozen=True)
class Inside:
    """The data of the scene and of each node about its body; empty if another program wrote the file."""

    scene: SceneWords | None
    bodies: Mapping[str, BodyWords]

    @classmethod
    def of(cls, nodes: Sequence[Node], extras: Any, path: Path) -> Inside:  # noqa: ANN401 - plain data
        """Return the data in the file at ``path``; raise SceneError if they are malformed."""
        found = {node.name: _words(BodyWords, node.extras, path) for node in nodes}
        return cls(
            _words(SceneWords, extras, path), {name: words for name, words in found.items() if words is not None}
        )

    def weight(self, name: str) -> Weight:
        """Return the mass [kg] and the density [kg/m³] of a body, None if not given."""
        words = self.bodies.get(name)
        return (None, None) if words is None else (words.mass, words.density)

    @cached_property
    def fixed(self) -> frozenset[str]:
        """The names of the bodies that are fixed."""
        return frozenset(name for name, words in self.bodies.items() if words.fixed)

    @property
    def materials(self) -> dict[str, str]:
        """The materials of bodies that have one."""
        return {name: words.material for name, words in self.bodies.items() if words.material is not None}

    def known(self, nodes: Sequence[Node], weights: Mapping[str, Weight], notes: list[str]) -> dict[str, Known]:
        """Return the shapes, centres of mass and inertias of bodies whose meshes are unchanged.

        The inertia belongs to the written mass, so it is left out for a body with another mass in ``weights``.
        """
        found, edited = {}, []
        for node in nodes:
            words = self.bodies.get(node.name)
            if words is None:
                continue
            _, stretch = split(node.matrix, f"node {node.name}")
            if not (np.array_equal(stretch, np.eye(3)) and checksum(node.vertices, node.faces) == words.surface):
                edited.append(node.name)
                continue
            shape = None if words.shape is None else shape_of(words.shape, None, node.name)
            com, inertia, origin = (
                None if each is None else np.array(each) for each in (words.com, words.inertia, words.origin)
            )
            same = weights[node.name] == self.weight(node.name)
            at = np.zeros(3) if origin is None else origin
            found[node.name] = Known(shape, words.noise, com, inertia if same else None, at)
        if edited:
            about = "their shapes, centres of mass and inertias are those of their meshes"
            notes.append(f"meshes are not those that holdfast wrote, so {about}: {listed(edited)}")
        return found

    def friction(self, names: Collection[str], notes: list[str]) -> Friction | None:
        """Return the friction table without pairs of bodies and materials that do not exist any more."""
        if self.scene is None:
            return None
        whole = friction_of(self.scene.friction)
        table = whole.among(names)
        lost = sum(len(getattr(whole, name)) - len(getattr(table, name)) for name in ("pairs", "values", *STRENGTHS))
        if lost:
            notes.append(f"{lost} entries of the friction table are left out: they name what is not in the file")
        return table

    def limited(self, scene: Scene) -> Scene:
        """Return the scene with what its bodies may bear."""
        if all((words.top_load, words.pressure) == (None, None) for words in self.bodies.values()):
            return scene
        bodies = []
        for body in scene.bodies:
            words = self.bodies.get(body.name)
            bodies.append(body if words is None else replace(body, top_load=words.top_load, pressure=words.pressure))
        return replace(scene, bodies=tuple(bodies))

    def excluded(self, names: Collection[str], known: Mapping[str, Known], notes: list[str]) -> list[Excluded]:
        """Return the excluded pairs of which both bodies, or parts of compounds, still exist."""
        pairs = [] if self.scene is None else self.scene.excluded
        compounds = {name for name, each in known.items() if isinstance(each.shape, Compound)}
        kept = [
            pair
            for pair in excluded_among(pairs, names)
            if all(isinstance(end, str) or end[0] in compounds for end in pair)
        ]
        if len(kept) < len(pairs):
            notes.append(f"{len(pairs) - len(kept)} excluded pairs are left out: they name what is not in the file")
        return kept


def materials_of_parts(known: Mapping[str, Known]) -> set[str]:
    """Return the materials of parts of compounds."""
    shapes = [each.shape for each in known.values()]
    parts = [part for shape in shapes if isinstance(shape, Compound) for part in shape.parts]
    return {part.material for part in parts if part.material is not None}
