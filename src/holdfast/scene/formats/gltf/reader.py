"""Reads and writes glTF scenes: one body for each node with a mesh, with masses from densities or from a sidecar file.

Files that are written have a coloured node for each body, with all data that the reader needs to restore the scene.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, ConfigDict

from holdfast.base.arrays import checked_mapping, checked_truth
from holdfast.base.borders.foreign import foreign
from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.errors import SceneError, message
from holdfast.geometry.gltf import MAGIC, Gltf, Primitive
from holdfast.scene.compound import Shape
from holdfast.scene.formats.entries import FrictionModel, Number, Triple, Truth, friction_of, validated
from holdfast.scene.formats.gltf.extras import KEY, Drawn, Inside, body_data, drawn, materials_of_parts, scene_data
from holdfast.scene.formats.links import FLOOR, checked_fixed, not_read, unknown_keys
from holdfast.scene.formats.made_meshes import Collision, MeshRules, packed
from holdfast.scene.formats.named_meshes import (
    Numbers,
    Weights,
    check_names,
    scene_of_nodes,
)
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.by_trimesh import LOOKING, read_nodes
from holdfast.scene.scene import Scene

# What glTF has for each kind of its objects; what only looks or moves is ignored
KEYS = {
    "asset": ("version", "generator", "copyright", "minVersion", "extras"),
    "scenes": ("nodes", "name"),
    "nodes": ("mesh", "name", "children", "matrix", "translation", "rotation", "scale", "camera", "weights"),
    "meshes": ("primitives", "weights", "name", "extras"),
    "primitives": ("attributes", "indices", "material", "mode", "targets", "extras"),
    "the file": (
        "asset", "scene", "scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers", "materials", "textures",
        "images", "samplers", "cameras", "skins", "animations", "extensionsUsed", "extensionsRequired", "extras",
    ),
}  # fmt: skip
USUAL_GRAVITY = (0.0, 0.0, -9.81)  # [m/s²]
FIXED: Final = rgb_of("#d3d2ce")
# colours of movable bodies, in their order, repeated if there are more bodies
COLOURS: Final = tuple(
    map(rgb_of, ("#4f7cac", "#e08e45", "#5aa469", "#c65b5b", "#8a6fb3", "#c9a227", "#3f9aa6", "#b0688f"))
)
TEXT: Final = ".gltf"


def unknown_words(header: dict[str, Any]) -> Iterator[str]:
    """Yield the keys, extensions and custom properties of a checked header that are not known."""
    yield from _unknown_of(header, "the file")
    yield from _unknown_of(header.get("asset", {}), "asset")
    for kind in ("scenes", "nodes", "meshes"):
        for each in header.get(kind, []):
            yield from _unknown_of(each, kind)
    for mesh in header.get("meshes", []):
        for each in mesh.get("primitives", []):
            yield from _unknown_of(each, "primitives")


def _unknown_of(data: dict[str, Any], kind: str) -> Iterator[str]:
    yield from unknown_keys(data, (*KEYS[kind], "extras", "extensions"), kind)
    extras, extensions, weights = data.get("extras"), data.get("extensions"), data.get("weights")
    if kind in ("nodes", "meshes") and isinstance(weights, list) and any(weights):
        yield f"weights of {kind}"  # morph targets change the shape
    if kind in ("scenes", "nodes") and isinstance(extras, dict):
        yield from unknown_keys(extras, (KEY,), f"extras of {kind}")
    for name in extensions if isinstance(extensions, dict) else ():
        if not name.startswith(LOOKING):
            yield f"{name} of {kind}"


class NodeModel(BaseModel):
    """The data of one node in a sidecar file."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    mass: Number | None = None
    density: Number | None = None
    fixed: Truth = False
    material: str | None = None


class SidecarModel(BaseModel):
    """A sidecar file with the data that a glTF file lacks."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    friction: Number | FrictionModel | None = None
    density: Number | None = None
    gravity: Triple | None = None
    floor: Truth = False
    nodes: dict[str, NodeModel] = {}


def sniff(source: Source) -> bool:
    """Tell whether the file is binary glTF, or JSON with an ``asset`` of a version."""
    if source.head.startswith(MAGIC):
        return True
    if source.suffix != ".gltf":
        return False
    data = source.data
    return isinstance(data, dict) and isinstance(data.get("asset"), dict) and "version" in data["asset"]


def read(
    source: Source,
    *,
    friction: Friction | float | None = None,
    mass: Numbers | None = None,
    density: Numbers | None = None,
    fixed: Collection[str] = (),
    material: Mapping[str, str] | None = None,
    floor: bool = False,
    collision: Collision = "mesh",
    gravity: ArrayLike | None = None,
) -> Scene:
    """Return the scene of a glTF file, turned so that its y axis, which is up in glTF, becomes z.

    The options are those of ``hf.from_trimesh``; with ``collision="hull"`` meshes, which may be open, are their convex
    hulls, all or those of the nodes that are named. A file ``NAME.glb.yaml`` beside ``NAME.glb`` may give the others
    too, with ``nodes: {mug: {mass: 0.3, material: glass}, table: {fixed: true}}``. Options have priority over this
    file, and both over the data that holdfast wrote to the glTF file itself.

    Raises SceneError or GeometryError if the file is malformed, or if masses or friction are not given.
    """
    beside, path = _sidecar(source), str(source.path)
    with foreign(path):
        content = source.content if source.head.startswith(MAGIC) else packed(source)
        nodes, about, header = read_nodes(content)
        notes = not_read(Counter(unknown_words(header)))
    names = [node.name for node in nodes]
    rules = MeshRules(None, collision)
    rules.check_names(names)
    given = Weights(mass, density, names)
    check_names(str(_beside(source)), beside.nodes, names)
    inside = Inside.of(nodes, about, source.path)
    said = {name: beside.nodes.get(name, NodeModel()) for name in names}
    weights = {}
    for name in names:
        its = (said[name].mass, said[name].density), inside.weight(name)
        weights[name] = given.of(name, *its, alone=name in inside.fixed, last=(None, beside.density))
    known = inside.known([node for node in nodes if not rules.hulled(node.name)], weights, notes)
    beside_materials = {name: each.material for name, each in said.items() if each.material is not None}
    given_materials = {} if material is None else checked_mapping(material, "material", '{"table": "oak"}')
    materials = {**inside.materials, **beside_materials, **given_materials}
    below = checked_truth(floor, "floor") or beside.floor
    there = {*names, *materials.values(), *materials_of_parts(known), *([FLOOR] if below else [])}
    if friction is not None and inside.scene is not None:
        notes.append("friction: as given, in place of the table in the file")
    if friction is None:
        friction = inside.friction(there, notes) if beside.friction is None else friction_of(beside.friction)
    if friction is None:
        raise SceneError(message(path, "says nothing of friction", f"give friction=, or write it to {_beside(source)}"))
    held = [*inside.fixed, *(name for name in names if said[name].fixed)]
    whole = inside.scene
    standard = USUAL_GRAVITY if whole is None else whole.gravity
    scene = scene_of_nodes(
        nodes,
        weights,
        friction,
        [*held, *checked_fixed(fixed, names, "node")],
        materials,
        up="y",
        floor=below,
        gravity=next(each for each in (gravity, beside.gravity, standard) if each is not None),
        name=source.path.stem if whole is None else whole.name,
        notes=notes,
        known=known,
        rules=rules,
        excluded=inside.excluded(set(names), known, notes),
    )
    return inside.limited(scene)


def _beside(source: Source) -> Path:
    return source.path.with_name(source.path.name + ".yaml")


def _sidecar(source: Source) -> SidecarModel:
    """Return the data of the sidecar file; empty if there is none, or if the scene is not a file."""
    path = _beside(source)
    if source.given is not None or not path.exists():
        return SidecarModel()
    data = Source(path).data
    return validated(SidecarModel, {} if data is None else data, path)


def write(scene: Scene, path: Path) -> bytes:
    """Return the content of a binary file or, for the suffix .gltf, of a text file that includes its buffer.

    The reader restores shapes, masses, poses, friction and everything else exactly, but meshes in single precision.
    """
    file = Gltf()
    meshes: dict[tuple[Shape, Rgb], tuple[int, Drawn]] = {}
    moving = 0
    for body in scene.bodies:
        colour = FIXED if body.fixed else COLOURS[moving % len(COLOURS)]
        moving += not body.fixed
        if (body.shape, colour) not in meshes:  # equal shapes with the same colour share a mesh
            shown = drawn(body.shape)
            primitive = Primitive(shown.vertices, shown.faces, file.material(colour))
            meshes[body.shape, colour] = file.mesh([primitive]), shown
        number, shown = meshes[body.shape, colour]
        there = np.eye(4)
        there[:3, 3] = shown.origin
        file.node(body.name, number, body.pose @ there if shown.origin.any() else body.pose, body_data(body, shown))
    return file.content(scene_data(scene), binary=path.suffix.lower() != TEXT)


GLTF = Format("glTF", (".glb", ".gltf"), sniff, read, write, mark="one body a node")
