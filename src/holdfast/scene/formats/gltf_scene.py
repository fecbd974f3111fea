"""Reads and writes glTF scenes: one body for each node with a mesh, with masses from densities or from a sidecar file.

Files that are written have a coloured node for each body. What the reader needs to restore the scene is in the
``extras`` of the scene and of nodes under ``holdfast``: the scene has friction, gravity, excluded pairs and its name; a
node has the mass of its body, whether it is fixed, its material, and its shape if that is not just a mesh. The mesh of
a node may have been edited since: ``surface`` is a checksum of the mesh that was written, and if it does not match, the
mesh counts.
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Final, Literal, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, Field

from holdfast.base.arrays import Float, Int, checked_mapping, checked_truth
from holdfast.base.borders.foreign import foreign
from holdfast.base.colour import Rgb, rgb_of
from holdfast.base.errors import SceneError, message
from holdfast.base.text import listed
from holdfast.geometry.gltf import MAGIC, Gltf, Primitive
from holdfast.scene.body import Body
from holdfast.scene.compound import Compound, Shape
from holdfast.scene.excluded import Excluded, excluded_among
from holdfast.scene.formats import entries, native
from holdfast.scene.formats.entries import EntryModel, FrictionModel, Number, Triple, Truth
from holdfast.scene.formats.links import FLOOR, checked_fixed, not_read, unknown_keys
from holdfast.scene.formats.made_meshes import Collision, MeshRules, packed
from holdfast.scene.formats.named_meshes import KnownBody, Numbers, Weight, Weights, check_names, scene_of_nodes, split
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import STRENGTHS, Friction
from holdfast.scene.meshes.by_trimesh import LOOKING, Node, read_nodes
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

M = TypeVar("M", bound=BaseModel)

KEY = "holdfast"
FAR = 16.0  # [sizes of the mesh] if a mesh is farther from its frame, its node gets an own frame, for precision

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


class NodeModel(EntryModel):
    """The data of one node in a sidecar file."""

    mass: Number | None = None
    density: Number | None = None
    fixed: Truth = False
    material: str | None = None


class SidecarModel(EntryModel):
    """A sidecar file with the data that a glTF file lacks."""

    friction: Number | FrictionModel | None = None
    density: Number | None = None
    gravity: Triple | None = None
    floor: Truth = False
    nodes: dict[str, NodeModel] = Field(default={})


class SceneExtras(EntryModel):
    """The data of the scene."""

    format: Literal["holdfast-scene/1"]
    name: str = ""
    gravity: Triple
    friction: FrictionModel
    excluded: list[tuple[native.EndModel, native.EndModel]] = Field([], fail_fast=True)


class BodyExtras(EntryModel):
    """The data of a node about its body; numbers are as in a scene file."""

    surface: str
    shape: Annotated[native.AnyModel, Field(discriminator="type")] | None = None
    noise: Number = 0.0
    origin: Triple | None = None
    mass: Number | None = None
    density: Number | None = None
    com: Triple | None = None
    inertia: entries.Matrix3 | None = None
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
    data: dict[str, Any] = {"format": native.FORMAT, "name": scene.name, "gravity": scene.gravity.tolist()}
    data["friction"] = entries.friction_data(scene.friction)
    return {KEY: data | native.excluded_data(scene)}


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
        data["shape"] = native.shape_data(body.shape, None)
    data |= {"mass": body.mass} if density is None else {"density": density}
    data |= {"com": None if com is None else com.tolist(), "inertia": None if inertia is None else inertia.tolist()}
    data |= {"material": body.material, "fixed": body.fixed or None}
    data |= {"top_load": body.top_load, "pressure": body.pressure}
    return {KEY: {key: value for key, value in data.items() if value is not None}}


def checksum(vertices: Float, faces: Int) -> str:
    """Return a checksum of a mesh in single precision, as it is in a file."""
    return f"{zlib.crc32(vertices.astype('<f4').tobytes() + faces.astype('<u4').tobytes()):08x}"


@dataclass(frozen=True)
class HoldfastExtras:
    """The data of the scene and of each node about its body; empty if another program wrote the file."""

    scene: SceneExtras | None
    bodies: Mapping[str, BodyExtras]

    @classmethod
    def of(cls, nodes: Sequence[Node], extras: Any, path: Path) -> HoldfastExtras:  # noqa: ANN401 - plain data
        """Return the data in the file at ``path``; raise SceneError if they are malformed."""

        def words(model: type[M], given: Any) -> M | None:  # noqa: ANN401
            data = given.get(KEY) if isinstance(given, dict) else None
            return None if data is None else entries.validated(model, data, path)

        found = {node.name: words(BodyExtras, node.extras) for node in nodes}
        return cls(words(SceneExtras, extras), {name: each for name, each in found.items() if each is not None})

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

    def known(self, nodes: Sequence[Node], weights: Mapping[str, Weight], notes: list[str]) -> dict[str, KnownBody]:
        """Return the shapes, centres of mass and inertias of bodies whose meshes are unchanged.

        The inertia belongs to the written mass, so it is left out for a body with another mass in ``weights``.
        """
        found, edited = {}, []
        for node in (node for node in nodes if node.name in self.bodies):
            words = self.bodies[node.name]
            _, stretch = split(node.matrix, f"node {node.name}")
            if not (np.array_equal(stretch, np.eye(3)) and checksum(node.vertices, node.faces) == words.surface):
                edited.append(node.name)
                continue
            shape = None if words.shape is None else native.shape_of(words.shape, None, node.name)
            com, inertia, origin = (
                None if each is None else np.array(each) for each in (words.com, words.inertia, words.origin)
            )
            same = weights[node.name] == self.weight(node.name)
            at = np.zeros(3) if origin is None else origin
            found[node.name] = KnownBody(shape, words.noise, com, inertia if same else None, at)
        if edited:
            about = "their shapes, centres of mass and inertias are those of their meshes"
            notes.append(f"meshes are not those that holdfast wrote, so {about}: {listed(edited)}")
        return found

    def friction(self, names: Collection[str], notes: list[str]) -> Friction | None:
        """Return the friction table without pairs of bodies and materials that do not exist any more."""
        if self.scene is None:
            return None
        whole = entries.friction_of(self.scene.friction)
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

    def excluded(self, names: Collection[str], known: Mapping[str, KnownBody], notes: list[str]) -> list[Excluded]:
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


def _materials_of_parts(known: Mapping[str, KnownBody]) -> set[str]:
    compounds = [each.shape for each in known.values() if isinstance(each.shape, Compound)]
    return {part.material for shape in compounds for part in shape.parts if part.material is not None}


def unknown_words(header: dict[str, Any]) -> Iterator[str]:
    """Yield the keys, extensions and custom properties of a checked header that are not known."""
    groups = {"the file": [header], "asset": [header.get("asset", {})]}
    groups |= {kind: header.get(kind, []) for kind in ("scenes", "nodes", "meshes")}
    groups["primitives"] = [each for mesh in groups["meshes"] for each in mesh.get("primitives", [])]
    for kind, data in ((kind, data) for kind, group in groups.items() for data in group):
        yield from unknown_keys(data, (*KEYS[kind], "extras", "extensions"), kind)
        extras, extensions, weights = data.get("extras"), data.get("extensions"), data.get("weights")
        if kind in ("nodes", "meshes") and isinstance(weights, list) and any(weights):
            yield f"weights of {kind}"  # morph targets change the shape
        if kind in ("scenes", "nodes") and isinstance(extras, dict):
            yield from unknown_keys(extras, (KEY,), f"extras of {kind}")
        for name in extensions if isinstance(extensions, dict) else ():
            if not name.startswith(LOOKING):
                yield f"{name} of {kind}"


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
    check_names(str(_sidecar_path(source)), beside.nodes, names)
    inside = HoldfastExtras.of(nodes, about, source.path)
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
    there = {*names, *materials.values(), *_materials_of_parts(known), *([FLOOR] if below else [])}
    if friction is not None and inside.scene is not None:
        notes.append("friction: as given, in place of the table in the file")
    if friction is None:
        friction = inside.friction(there, notes) if beside.friction is None else entries.friction_of(beside.friction)
    if friction is None:
        remedy = f"give friction=, or write it to {_sidecar_path(source)}"
        raise SceneError(message(path, "says nothing of friction", remedy))
    fixed_names = [*inside.fixed, *(name for name in names if said[name].fixed)]
    whole = inside.scene
    standard = USUAL_GRAVITY if whole is None else whole.gravity
    scene = scene_of_nodes(
        nodes,
        weights,
        friction,
        [*fixed_names, *checked_fixed(fixed, names, "node")],
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


def _sidecar_path(source: Source) -> Path:
    return source.path.with_name(source.path.name + ".yaml")


def _sidecar(source: Source) -> SidecarModel:
    """Return the data of the sidecar file; empty if there is none, or if the scene is not a file."""
    path = _sidecar_path(source)
    if source.given is not None or not path.exists():
        return SidecarModel()
    data = Source(path).data
    return entries.validated(SidecarModel, {} if data is None else data, path)


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
    return file.content(scene_data(scene), binary=path.suffix.lower() != ".gltf")


GLTF = Format("glTF", (".glb", ".gltf"), sniff, read, write, mark="one body a node")
