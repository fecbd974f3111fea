"""The native scene file, ``format: holdfast-scene/1``: its schema, its reader and its writer."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, Discriminator, Field, Tag, model_validator

from holdfast.base.errors import SceneError, located, message
from holdfast.base.rigid import pose_from
from holdfast.base.text import quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound, Part, Shape
from holdfast.scene.formats import entries
from holdfast.scene.formats.entries import (
    EntryModel,
    FrictionModel,
    Matrix3,
    Matrix4,
    Number,
    Quadruple,
    Triple,
    Truth,
    Whole,
)
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import SUFFIXES, Source, as_json, as_yaml
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere

FORMAT: Literal["holdfast-scene/1"] = "holdfast-scene/1"
# shapes whose entries have the names of their fields
SHAPES: Mapping[str, type[Any]] = {
    "box": Box,
    "cylinder": Cylinder,
    "sphere": Sphere,
    "capsule": Capsule,
    "ellipsoid": Ellipsoid,
    "halfspace": HalfSpace,
}
# entries of a body that its class takes under the same names
AS_IN_BODY = ("mass", "density", "pose", "position", "rpy_degrees", "com", "inertia", "material", "fixed", "top_load",
              "pressure")  # fmt: skip


def _quaternion(value: Any) -> Any:  # noqa: ANN401
    """Refuse three numbers, and name the key for angles."""
    if isinstance(value, list | tuple) and len(value) == 3:
        raise ValueError(
            f"needs four numbers, a unit quaternion w, x, y, z; write angles as rpy_degrees: {list(value)}"
        )
    return value


class BoxModel(EntryModel):
    """A cuboid centred on the origin of its frame."""

    type: Literal["box"]
    size: Triple = Field(description="edge lengths [m]")


class CylinderModel(EntryModel):
    """A cylinder about the z axis, centred on the origin of its frame."""

    type: Literal["cylinder"]
    radius: Number = Field(description="[m]")
    height: Number = Field(description="[m]")
    segments: Whole = Field(64, description="sides of the prism that contacts see")


class SphereModel(EntryModel):
    """A ball centred on the origin of its frame."""

    type: Literal["sphere"]
    radius: Number = Field(description="[m]")
    subdivisions: Whole = Field(3, ge=0, le=6, description="of the icosahedron that contacts see")


class MeshModel(EntryModel):
    """A triangle mesh, either from a file or given by its vertices and faces."""

    type: Literal["mesh"]
    file: str | None = Field(None, description="OBJ, STL, PLY, GLB, OFF or DAE; relative to this scene file")
    scale: Number | Triple = Field(1.0, description="applied to the file's coordinates")
    noise: Number = Field(0.0, ge=0, description="standard deviation of a scan's vertices [m]; flat regions are fitted")
    vertices: list[Triple] | None = Field(None, fail_fast=True, description="[m]")
    faces: list[tuple[Whole, Whole, Whole]] | None = Field(None, fail_fast=True, description="outward winding")

    @model_validator(mode="after")
    def _one_source(self) -> MeshModel:
        if (self.file is None) == (self.vertices is None) or (self.vertices is None) != (self.faces is None):
            raise ValueError("needs either file, or vertices and faces")
        return self


class CapsuleModel(EntryModel):
    """A cylinder about the z axis with half a ball on either end, centred on the origin of its frame."""

    type: Literal["capsule"]
    radius: Number = Field(description="[m]")
    length: Number = Field(description="of the cylinder alone [m]")
    segments: Whole = Field(48, description="sides of the surface that contacts see")


class EllipsoidModel(EntryModel):
    """An ellipsoid along the axes of its frame."""

    type: Literal["ellipsoid"]
    radii: Triple = Field(description="half axes [m]")
    subdivisions: Whole = Field(3, ge=0, le=6, description="of the icosahedron that contacts see")


class HalfSpaceModel(EntryModel):
    """Everything below the plane z = 0 of the body's frame; only for fixed bodies."""

    type: Literal["halfspace"]


SolidModel = Annotated[
    BoxModel | CylinderModel | SphereModel | CapsuleModel | EllipsoidModel | MeshModel, Field(discriminator="type")
]


class PartModel(EntryModel):
    """One shape of a compound."""

    shape: SolidModel
    pose: Matrix4 | None = Field(None, description="4x4 part to body, rows")
    material: str | None = Field(None, description="of this part, instead of the body's")


class CompoundModel(EntryModel):
    """Several shapes that move as one body."""

    type: Literal["compound"]
    parts: list[PartModel] = Field(fail_fast=True)


AnyModel = (
    BoxModel | CylinderModel | SphereModel | CapsuleModel | EllipsoidModel | MeshModel | HalfSpaceModel | CompoundModel
)


class BodyModel(EntryModel):
    """A rigid body. Its pose is given as ``pose``, or as ``position`` and ``rpy_degrees`` or ``orientation``."""

    name: str
    shape: Annotated[AnyModel, Field(discriminator="type")]
    mass: Number | None = Field(None, description="[kg]")
    density: Number | None = Field(None, description="[kg/m³], instead of mass")
    pose: Matrix4 | None = Field(None, description="4x4 body to world, rows")
    position: Triple | None = Field(None, description="origin of the body frame in the world [m]")
    rpy_degrees: Triple | None = Field(None, description="roll, pitch, yaw [deg]: turns about the world's x, y, z")
    orientation: Annotated[Quadruple, BeforeValidator(_quaternion)] | None = Field(
        None, description="unit quaternion w, x, y, z, body to world"
    )
    com: Triple | None = Field(None, description="centre of mass in the body frame [m]")
    inertia: Matrix3 | None = Field(None, description="about the centre of mass, body axes [kg m²]")
    material: str | None = None
    fixed: Truth = False
    top_load: Number | None = Field(None, description="the most that may press down on it [N]")
    pressure: Number | None = Field(None, description="the most that a face of it may bear [Pa]")

    @model_validator(mode="after")
    def _one_pose(self) -> BodyModel:
        turned = (self.rpy_degrees, self.orientation)
        if self.pose is not None and (self.position, *turned) != (None, None, None):
            raise ValueError("needs either pose, or position and rpy_degrees")
        if None not in turned:
            raise ValueError("needs either rpy_degrees or orientation")
        if self.orientation is not None and abs(math.hypot(*self.orientation) - 1) > 1e-3:
            length = math.hypot(*self.orientation)
            unit = ", ".join(f"{part / length:.6g}" for part in self.orientation) if length > 0 else "1, 0, 0, 0"
            raise ValueError(f"orientation has length {length:.4g}, needs a unit quaternion, as in [{unit}]")
        return self


EndModel = str | tuple[str, Whole]


class SceneModel(EntryModel):
    """A holdfast scene: rigid bodies in frictional contact. SI units, z up unless gravity says otherwise."""

    format: Literal["holdfast-scene/1"]
    name: str = ""
    gravity: Triple = (0.0, 0.0, -9.81)
    friction: Annotated[
        Annotated[Number, Tag("number")] | Annotated[FrictionModel, Tag("table")],
        Discriminator(lambda value: "table" if isinstance(value, dict | BaseModel) else "number"),
    ]
    bodies: list[BodyModel] = Field(fail_fast=True)
    excluded: list[tuple[EndModel, EndModel]] = Field(
        [], fail_fast=True, description="pairs of bodies, or of [body, number of a part from 0], that never touch"
    )
    holds: list[entries.AnyHoldModel] = Field([], fail_fast=True, description="what holds bodies beside their contacts")


def schema() -> dict[str, Any]:
    """Return the JSON schema of the native scene file."""
    return SceneModel.model_json_schema() | {"$schema": "https://json-schema.org/draft/2020-12/schema"}


def sniff(source: Source) -> bool:
    """Tell whether the file declares itself a native scene, of any version."""
    data = source.data
    return isinstance(data, dict) and str(data.get("format")).startswith("holdfast-scene/")


def read(source: Source) -> Scene:
    """Return the scene that the file describes; paths of meshes are relative to the file.

    Raises SceneError if the file does not match the schema.
    """
    path = source.path
    model = entries.validated(SceneModel, source.data, path)
    bodies = []
    for body in model.bodies:
        with located(f"body {quoted(body.name)}"):
            bodies.append(body_of(body, path))
    holds = [entries.hold_of(hold) for hold in model.holds]
    return Scene(bodies, entries.friction_of(model.friction), model.gravity, model.name, model.excluded, holds=holds)


def write(scene: Scene, path: Path) -> bytes:
    """Return the content of a scene file from which ``read`` gives an equal scene.

    The suffix of ``path`` selects JSON or YAML. Paths of meshes are relative to ``path``.
    """
    data = _scene_data(scene, path)
    return (as_json(data) if path.suffix.lower() == ".json" else as_yaml(data)).encode()


def scene_text(scene: Scene, folder: Path = Path()) -> str:
    """Return the YAML text of a scene file in ``folder``, by default the current one."""
    return as_yaml(_scene_data(scene, folder / "scene.yaml"))


def _scene_data(scene: Scene, path: Path) -> dict[str, Any]:
    data = {
        "format": FORMAT,
        "name": scene.name,
        "gravity": scene.gravity.tolist(),
        "friction": entries.friction_data(scene.friction),
        "bodies": [_body_data(body, path) for body in scene.bodies],
    }
    return (
        data
        | excluded_data(scene)
        | ({"holds": [entries.hold_data(hold) for hold in scene.holds]} if scene.holds else {})
    )


def excluded_data(scene: Scene) -> dict[str, Any]:
    """Return the pairs that do not touch as plain data, if there are any."""
    excluded = [[end if isinstance(end, str) else list(end) for end in pair] for pair in scene.excluded]
    return {"excluded": excluded} if excluded else {}


def body_of(model: BodyModel, path: Path) -> Body:
    """Return the body that an entry of a scene file at ``path`` describes."""
    given: dict[str, Any] = {name: getattr(model, name) for name in AS_IN_BODY}
    if model.orientation is not None:
        position = np.array(model.position or (0, 0, 0.0))
        given |= {"pose": pose_from(position, np.array(model.orientation)), "position": None}
    return Body(model.name, shape_of(model.shape, path, model.name), **given)


def shape_of(model: AnyModel, path: Path | None, name: str) -> Any:  # noqa: ANN401 - a Solid of a SolidModel, else a Shape
    """Return the shape of a body in a scene file at ``path``; without a path, mesh files are refused."""
    match model:
        case CompoundModel():
            parts = [(shape_of(part.shape, path, name), part) for part in model.parts]
            return Compound([Part(solid, part.pose, part.material) for solid, part in parts])
        case MeshModel(file=str(file)):
            if path is None:
                problem = f"names the mesh file {quoted(file)}"
                raise SceneError(message(f"body {quoted(name)}", problem, "needs vertices and faces"))
            return Mesh.from_file(path.parent / file, scale=model.scale, noise=model.noise)
        case MeshModel():
            label = f"body {quoted(name)}: mesh"
            return Mesh(np.array(model.vertices), np.array(model.faces), noise=model.noise, label=label)
    return SHAPES[model.type](**model.model_dump(exclude={"type"}))


def _body_data(body: Body, path: Path) -> dict[str, Any]:
    weight = {"mass": body.mass} if body.density is None else {"density": body.density}
    data = {"name": body.name, "shape": shape_data(body.shape, path)} | weight
    data |= {name: getattr(body, name) for name in ("pose", "com", "inertia", "material")}
    data |= {"fixed": body.fixed or None, "top_load": body.top_load, "pressure": body.pressure}
    return {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in data.items()
        if value is not None
    }


def shape_data(shape: Shape, path: Path | None) -> dict[str, Any]:
    """Return a shape as a scene file at ``path`` holds it; without a path, meshes are written out."""
    match shape:
        case HalfSpace():
            return {"type": "halfspace"}
        case Compound():
            parts: list[dict[str, Any]] = []
            for part in shape.parts:
                data = {"shape": shape_data(part.shape, path), "pose": part.pose.tolist()}
                parts.append(data if part.material is None else data | {"material": part.material})
            return {"type": "compound", "parts": parts}
        case Mesh():
            source: dict[str, Any] = {"vertices": shape.vertices.tolist(), "faces": shape.faces.tolist()}
            if shape.file is not None and path is not None:
                relative = Path(os.path.relpath(shape.file, path.parent)).as_posix()
                source = {"file": relative, "scale": list(shape.scale)}
            return {"type": "mesh"} | source | ({"noise": shape.noise} if shape.noise else {})
    kind = next(kind for kind, made in SHAPES.items() if isinstance(shape, made))
    return {"type": kind} | shape.to_dict()


NATIVE = Format("holdfast scene", SUFFIXES, sniff, read, write, mark=f"`format: {FORMAT}`", holds=True)
