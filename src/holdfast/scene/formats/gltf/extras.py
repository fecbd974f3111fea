"""The data that holdfast writes to glTF files, in the ``extras`` of the scene and of nodes under ``holdfast``.

The scene has friction, gravity, excluded pairs and its name; a node has the mass of its body, whether it is fixed, its
material, and its shape if that is not just a mesh. The mesh of a node may have been edited since: ``surface`` is a
checksum of the mesh that was written, and if it does not match, the mesh counts.
"""

from __future__ import annotations

import zlib
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

import numpy as np
from pydantic import BaseModel, Field, ValidationError

from holdfast.base.arrays import Float, Int
from holdfast.base.errors import SceneError
from holdfast.scene.body import Body
from holdfast.scene.compound import Shape
from holdfast.scene.formats.faults import first_fault
from holdfast.scene.formats.friction_entries import FrictionModel, friction_data
from holdfast.scene.formats.models_shared import Matrix3, Model, Number, Triple, Truth
from holdfast.scene.formats.named_meshes import Known
from holdfast.scene.formats.native import FORMAT, AnyModel, EndModel, excluded_data, limits_data, shape_data, shape_of
from holdfast.scene.meshes.by_trimesh import Node
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

KEY = "holdfast"
FAR = 16.0  # [sizes of the mesh] if a mesh is farther from its frame, its node gets an own frame, for precision

M = TypeVar("M", bound=BaseModel)


class SceneWords(Model):
    """The data of the scene."""

    format: Literal["holdfast-scene/1"]
    name: str = ""
    gravity: Triple
    friction: FrictionModel
    excluded: list[tuple[EndModel, EndModel]] = Field([], fail_fast=True)


class BodyWords(Model):
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
    data |= {"material": body.material, "fixed": body.fixed or None} | limits_data(body)
    return {KEY: {key: value for key, value in data.items() if value is not None}}


def checksum(vertices: Float, faces: Int) -> str:
    """Return a checksum of a mesh in single precision, as it is in a file."""
    return f"{zlib.crc32(vertices.astype('<f4').tobytes() + faces.astype('<u4').tobytes()):08x}"


def scene_words(extras: Any, path: Path) -> SceneWords | None:  # noqa: ANN401
    """Return the data of a scene, or None if there are none; raise SceneError if they are malformed."""
    return _checked(SceneWords, extras, path)


def body_words(node: Node, path: Path) -> BodyWords | None:
    """Return the data of a node, or None if there are none; raise SceneError if they are malformed."""
    return _checked(BodyWords, node.extras, path)


def _checked(model: type[M], extras: Any, path: Path) -> M | None:  # noqa: ANN401
    data = extras.get(KEY) if isinstance(extras, dict) else None
    if data is None:
        return None
    try:
        return model.model_validate(data)
    except ValidationError as cause:
        raise SceneError(first_fault(cause, model, data, path)) from None


def known_of(words: BodyWords, name: str) -> Known:
    """Return the shape, centre of mass and inertia of a body from a node whose mesh is unchanged."""
    shape = None if words.shape is None else shape_of(words.shape, None, name)
    com, inertia, origin = (
        None if each is None else np.array(each) for each in (words.com, words.inertia, words.origin)
    )
    return Known(shape, words.noise, com, inertia, np.zeros(3) if origin is None else origin)
