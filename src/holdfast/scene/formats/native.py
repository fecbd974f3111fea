"""The native scene file, ``format: holdfast-scene/1``: its schema, its reader and its writer."""

from __future__ import annotations

import difflib
import os
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationError,
    model_validator,
)

from holdfast.base.arrays import Float
from holdfast.base.errors import SceneError, located, message
from holdfast.base.rigid import pose_from
from holdfast.scene.body import Body
from holdfast.scene.formats import text
from holdfast.scene.formats.registry import register
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Combine, Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Mesh, Shape, Sphere

FORMAT: Literal["holdfast-scene/1"] = "holdfast-scene/1"


def _no_truth_value(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, bool):
        raise ValueError("needs a number")
    return value


def _friction_kind(value: Any) -> str:  # noqa: ANN401
    return "table" if isinstance(value, dict | BaseModel) else "number"


Number = Annotated[float, BeforeValidator(_no_truth_value)]
Triple = tuple[Number, Number, Number]
Quadruple = tuple[Number, Number, Number, Number]
Matrix3 = tuple[Triple, Triple, Triple]
Matrix4 = tuple[Quadruple, Quadruple, Quadruple, Quadruple]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class BoxModel(_Model):
    """A cuboid centred on the origin of its frame."""

    type: Literal["box"]
    size: Triple = Field(description="edge lengths [m]")


class CylinderModel(_Model):
    """A cylinder about the z axis, centred on the origin of its frame."""

    type: Literal["cylinder"]
    radius: Number = Field(description="[m]")
    height: Number = Field(description="[m]")
    segments: int = Field(64, description="sides of the prism that contacts see")


class SphereModel(_Model):
    """A ball centred on the origin of its frame."""

    type: Literal["sphere"]
    radius: Number = Field(description="[m]")
    subdivisions: int = Field(3, ge=0, le=6, description="of the icosahedron that contacts see")


class MeshModel(_Model):
    """A triangle mesh, either from a file or given by its vertices and faces."""

    type: Literal["mesh"]
    file: str | None = Field(None, description="OBJ, STL, PLY, GLB or OFF; relative to this scene file")
    scale: Number | Triple = Field(1.0, description="applied to the file's coordinates")
    noise: Number = Field(0.0, ge=0, description="standard deviation of a scan's vertices [m]; flat regions are fitted")
    vertices: list[Triple] | None = Field(None, description="[m]")
    faces: list[tuple[int, int, int]] | None = Field(None, description="outward winding")

    @model_validator(mode="after")
    def _one_source(self) -> MeshModel:
        if (self.file is None) == (self.vertices is None) or (self.vertices is None) != (self.faces is None):
            raise ValueError("needs either file, or vertices and faces")
        return self


class BodyModel(_Model):
    """A rigid body. Its pose is given as ``pose``, or as ``position`` and ``orientation``."""

    name: str
    shape: Annotated[BoxModel | CylinderModel | SphereModel | MeshModel, Field(discriminator="type")]
    mass: Number | None = Field(None, description="[kg]")
    density: Number | None = Field(None, description="[kg/m³], instead of mass")
    pose: Matrix4 | None = Field(None, description="4x4 body to world, rows")
    position: Triple | None = Field(None, description="origin of the body frame in the world [m]")
    orientation: Quadruple | None = Field(None, description="unit quaternion w, x, y, z, body to world")
    com: Triple | None = Field(None, description="centre of mass in the body frame [m]")
    inertia: Matrix3 | None = Field(None, description="about the centre of mass, body axes [kg m²]")
    material: str | None = None
    fixed: bool = False

    @model_validator(mode="after")
    def _one_pose(self) -> BodyModel:
        if self.pose is not None and (self.position is not None or self.orientation is not None):
            raise ValueError("needs either pose, or position and orientation")
        if self.orientation is not None and abs(np.linalg.norm(self.orientation) - 1) > 1e-3:
            raise ValueError(f"orientation has length {np.linalg.norm(self.orientation):.4g}, needs a unit quaternion")
        return self


class PairModel(_Model):
    """Friction between two bodies or materials."""

    between: tuple[str, str]
    mu: Number


class FrictionModel(_Model):
    """Static Coulomb friction."""

    default: Number | None = None
    pairs: list[PairModel] = []
    values: dict[str, Number] = Field({}, description="one coefficient a body, for imported scenes; needs combine")
    combine: Combine | None = Field(None, description="how two values make a pair's")


class SceneModel(_Model):
    """A holdfast scene: rigid bodies in frictional contact. SI units, z up unless gravity says otherwise."""

    format: Literal["holdfast-scene/1"]
    name: str = ""
    gravity: Triple = (0.0, 0.0, -9.81)
    friction: Annotated[
        Annotated[Number, Tag("number")] | Annotated[FrictionModel, Tag("table")], Discriminator(_friction_kind)
    ]
    bodies: list[BodyModel]


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
    data, path = source.data, source.path
    try:
        model = SceneModel.model_validate(data)
    except ValidationError as cause:
        raise SceneError(_first_problem(cause, data, path)) from None
    bodies = [_body(body, path) for body in model.bodies]
    return Scene(bodies, _friction(model.friction), model.gravity, model.name)


def write(scene: Scene, path: Path) -> bytes:
    """Return the content of a scene file from which ``read`` gives an equal scene.

    The suffix of ``path`` selects JSON or YAML. Paths of meshes are relative to ``path``.
    """
    data = _scene_data(scene, path)
    return (text.as_json(data) if path.suffix.lower() == ".json" else text.as_yaml(data)).encode()


def _scene_data(scene: Scene, path: Path) -> dict[str, Any]:
    friction = scene.friction
    table: dict[str, Any] = {"default": friction.default}
    table["pairs"] = [{"between": list(pair), "mu": mu} for pair, mu in friction.pairs.items()]
    table["values"] = dict(friction.values)
    table["combine"] = friction.combine
    return {
        "format": FORMAT,
        "name": scene.name,
        "gravity": scene.gravity.tolist(),
        "friction": {key: value for key, value in table.items() if value not in (None, [], {})},
        "bodies": [_body_data(body, path) for body in scene.bodies],
    }


def _body(model: BodyModel, path: Path) -> Body:
    with located(f"body {model.name!r}"):
        return _built(model, path)


def _built(model: BodyModel, path: Path) -> Body:
    pose: Any = model.pose
    if pose is None:
        pose = pose_from(np.array(model.position or (0, 0, 0.0)), np.array(model.orientation or (1.0, 0, 0, 0)))
    return Body(
        model.name,
        _shape(model.shape, path, model.name),
        mass=model.mass,
        density=model.density,
        pose=pose,
        com=_array(model.com),
        inertia=_array(model.inertia),
        material=model.material,
        fixed=model.fixed,
    )


def _array(value: tuple[Any, ...] | None) -> Float | None:
    return None if value is None else np.array(value, dtype=np.float64)


def _shape(model: BoxModel | CylinderModel | SphereModel | MeshModel, path: Path, name: str) -> Shape:
    match model:
        case BoxModel():
            return Box(np.array(model.size))
        case CylinderModel():
            return Cylinder(model.radius, model.height, model.segments)
        case SphereModel():
            return Sphere(model.radius, model.subdivisions)
        case MeshModel(file=str(file)):
            return Mesh.from_file(path.parent / file, scale=model.scale, noise=model.noise)
    return Mesh(np.array(model.vertices), np.array(model.faces), noise=model.noise, where=f"body {name!r}: mesh")


def _friction(model: float | FrictionModel) -> Friction:
    if not isinstance(model, FrictionModel):
        return Friction(default=model)
    pairs: dict[tuple[str, str], float] = {}
    for pair in model.pairs:
        if pair.between in pairs or pair.between[::-1] in pairs:
            raise SceneError(message("friction", f"pair {pair.between!r} stands twice", "give each pair once"))
        pairs[pair.between] = pair.mu
    return Friction(model.default, pairs, model.values, model.combine)


def _body_data(body: Body, path: Path) -> dict[str, Any]:
    data: dict[str, Any] = {"name": body.name, "shape": _shape_data(body.shape, path)}
    if body.density is not None:
        data["density"] = body.density
    elif body.mass is not None:
        data["mass"] = body.mass
    data["pose"] = body.pose.tolist()
    if body.com is not None:
        data["com"] = body.com.tolist()
    if body.inertia is not None:
        data["inertia"] = body.inertia.tolist()
    if body.material is not None:
        data["material"] = body.material
    if body.fixed:
        data["fixed"] = True
    return data


def _shape_data(shape: Shape, path: Path) -> dict[str, Any]:
    match shape:
        case Box():
            return {"type": "box", "size": shape.size.tolist()}
        case Cylinder():
            return {
                "type": "cylinder",
                "radius": shape.radius,
                "height": shape.height,
                "segments": shape.segments,
            }
        case Sphere():
            return {"type": "sphere", "radius": shape.radius, "subdivisions": shape.subdivisions}
        case Mesh(file=Path() as file):
            relative = Path(os.path.relpath(file, path.parent)).as_posix()
            source: dict[str, Any] = {"file": relative, "scale": list(shape.scale)}
        case Mesh():
            source = {"vertices": shape.vertices.tolist(), "faces": shape.faces.tolist()}
    return {"type": "mesh"} | source | ({"noise": shape.noise} if shape.noise else {})


_MODELS = (BoxModel, CylinderModel, SphereModel, MeshModel, BodyModel, PairModel, FrictionModel, SceneModel)
_KEYS = {"quaternion": "orientation"} | {key: key for model in _MODELS for key in model.model_fields}


def _first_problem(error: ValidationError, data: Any, path: Path) -> str:  # noqa: ANN401
    """Describe the first error that pydantic found in one line, with the name of the body as well as its number."""
    first = error.errors()[0]
    parts: list[str] = []
    for key in first["loc"]:
        if isinstance(key, int):
            parts[-1] += f"[{key}]"
        elif key not in ("box", "cylinder", "sphere", "mesh", "table", "number"):
            parts.append(str(key))
    where = f"{path}: {'.'.join(parts) or 'scene'}"
    match first["loc"]:
        case ("bodies", int(index), *_) if isinstance(data, dict):
            body = data["bodies"][index]
            if isinstance(body, dict) and "name" in body:
                where += f" (body {body['name']!r})"
    value = first.get("input")
    shown = f", got {value!r:.60}" if not isinstance(value, dict | list) else ""
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] == "extra_forbidden":
        near = difflib.get_close_matches(str(first["loc"][-1]), _KEYS, n=1)
        hint = f"did you mean {_KEYS[near[0]]!r}? " if near else ""
        return message(where, f"unknown key{more}", f"{hint}`holdfast schema` prints the keys there are")
    problem = first["msg"].removeprefix("Value error, ")
    return message(where, f"{problem}{shown}{more}", "`holdfast schema` prints the format")


register("holdfast scene", text.SUFFIXES, sniff, read, write, mark=f"`format: {FORMAT}`")
