"""Read published cases: block assemblies (keys ``blocks`` and ``interfaces``), and ``settled-scene/1`` files.

A block assembly is polygon meshes with one friction coefficient. A scene holds no contacts, so the interfaces in such a
file, which another program detected, are ignored. A settled scene is objects at rest, each with a mesh file and a
friction coefficient.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any, Literal

import manifold3d
import numpy as np
from pydantic import BaseModel, Field

from holdfast.base.arrays import Float, Int, checked, checked_number
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError
from holdfast.base.ranges import FRICTION, PLACE
from holdfast.base.rigid import tangents
from holdfast.base.text import quoted
from holdfast.geometry.triangles import outline_vector
from holdfast.scene.body import Body
from holdfast.scene.formats.entries import Matrix4, Number, Triple, Truth, validated
from holdfast.scene.formats.links import not_read, unknown_keys
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.read import fan
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

ASSEMBLY_KEYS = ("name", "source", "licence", "units", "friction", "gravity", "blocks", "interfaces", "expected")
NEEDED = "needs blocks (name, vertices, faces, mass, fixed), friction, gravity"
BLOCK_KEYS = ("name", "vertices", "faces", "mass", "fixed")
SETTLED = "settled-scene/1"
# keys that say where a scene or an object is from
ABOUT = ("note", "friction_rule", "settling", "original_mesh_gap_mm", "com_source", "watertight", "source")


def sniff_blocks(source: Source) -> bool:
    """Tell whether the file is a block assembly."""
    data = source.data
    return isinstance(data, dict) and isinstance(data.get("blocks"), list)


def read_blocks(source: Source) -> Scene:
    """Return the scene of a block assembly; faces may have more than three corners and may be non-convex.

    Raises SceneError if the file is not a valid block assembly.
    """
    data, path = source.data, source.path
    with foreign(str(path), "is not a block assembly", NEEDED):
        bodies = [_block(block, path) for block in data["blocks"]]
        friction = checked_number(data["friction"], f"{path}: friction", minimum=0, within=FRICTION)
        found = Counter(unknown_keys(data, ASSEMBLY_KEYS, "the file"))
        for block in data["blocks"]:
            found.update(unknown_keys(block, BLOCK_KEYS, "blocks"))
        return Scene(bodies, friction, data["gravity"], data.get("name", path.stem), notes=not_read(found))


def _block(block: dict[str, Any], path: Path) -> Body:
    where = f"{path}: block {quoted(block['name'])}"
    vertices = checked(block["vertices"], (None, 3), f"{where}: vertices", within=PLACE, error=GeometryError)
    triangles = [triangulated(vertices, np.array(face)) for face in block["faces"]]
    mesh = Mesh(vertices, np.vstack(triangles), label=where)
    return Body(block["name"], mesh, mass=block["mass"], fixed=block["fixed"])


def triangulated(vertices: Float, face: Int) -> Int:
    """Split a nearly flat, possibly non-convex polygon into triangles (t, 3) with the same winding."""
    if len(face) == 3:
        return face[None]
    corners = vertices[face]
    across = outline_vector(corners)
    if not np.linalg.norm(across) > 0:
        return np.array(fan(face.tolist()))
    t1, t2 = tangents(across / np.linalg.norm(across))
    flat = np.column_stack([corners @ t1, corners @ t2])
    flat = (flat - flat.mean(0)) / np.ptp(flat, axis=0).max()
    return np.asarray(face[np.array(manifold3d.triangulate([flat]))], dtype=np.int64)


PUBLISHED = Format("block assembly", (".json",), sniff_blocks, read_blocks, mark="`blocks`")


def sniff_settled(source: Source) -> bool:
    """Tell whether the file is a settled scene."""
    data = source.data
    return isinstance(data, dict) and data.get("format") == SETTLED


class UnitsModel(BaseModel):
    """The gravity of the scene; lengths are in metres and masses in kilograms."""

    gravity: Triple = Field(description="[m/s²]")


class ObjectModel(BaseModel):
    """One object at rest."""

    name: str
    mesh: str = Field(description="path of the mesh file, relative to this file")
    scale: Number | Triple = Field(description="factor, or three, of the coordinates in the mesh file")
    pose: Matrix4 = Field(description="pose of the mesh in the world")
    mass: Number | None = Field(None, description="[kg]; needed unless fixed")
    com: Triple | None = Field(None, description="centre of mass [m] in the frame of the mesh")
    friction: Number = Field(description="coefficient; a pair takes the larger of two")
    fixed: Truth


class SettledModel(BaseModel):
    """A settled scene: objects at rest, each a mesh with a friction coefficient. Other keys may stand beside these."""

    format: Literal["settled-scene/1"]
    name: str | None = None
    units: UnitsModel
    objects: list[ObjectModel]


def settled_schema() -> dict[str, Any]:
    """Return the JSON schema of a settled scene."""
    return SettledModel.model_json_schema() | {"$schema": "https://json-schema.org/draft/2020-12/schema"}


def read_settled(source: Source) -> Scene:
    """Return the scene; as the format prescribes, the friction of a pair is the larger of its two values.

    Keys that are not read are noted. Raises SceneError if the file is not a valid settled scene.
    """
    path = source.path
    model = validated(SettledModel, source.data, path, "settled")
    bodies = [_settled_body(item, path) for item in model.objects]
    values = {item.name: item.friction for item in model.objects}
    found = Counter(unknown_keys(source.data, (*SettledModel.model_fields, *ABOUT), "the file"))
    found.update(unknown_keys(source.data["units"], ("gravity", "length", "mass", "up"), "units"))
    for item in source.data["objects"]:
        found.update(unknown_keys(item, (*ObjectModel.model_fields, *ABOUT), "objects"))
    friction = Friction(values=values, combine="max")
    return Scene(bodies, friction, model.units.gravity, model.name or path.stem, notes=not_read(found))


def _settled_body(item: ObjectModel, path: Path) -> Body:
    where = f"{path}: object {quoted(item.name)}"
    return Body(
        item.name,
        Mesh.from_file(path.parent / item.mesh, scale=item.scale),
        mass=None if item.fixed else item.mass,
        pose=_orthonormal(checked(item.pose, (4, 4), f"{where}: pose")),
        com=item.com,
        fixed=item.fixed,
    )


def _orthonormal(pose: Float) -> Float:
    """Return the nearest rigid pose.

    The files give rotations with nine digits; without this correction, rounding would tilt faces.
    """
    u, _, vt = np.linalg.svd(pose[:3, :3])
    rotation = u @ vt
    if np.abs(rotation - pose[:3, :3]).max() > 1e-5:
        return pose
    result = pose.copy()
    result[:3, :3] = rotation
    return result


SETTLED_SCENE = Format("settled scene", (".json",), sniff_settled, read_settled, mark=f"`format: {SETTLED}`")
