"""Meshes for what files describe otherwise: cones, extruded outlines, and convex hulls in place of meshes."""

from __future__ import annotations

import base64
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import manifold3d
import numpy as np
from scipy.spatial import KDTree

from holdfast.base.arrays import Float, checked_number, checked_word
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, SceneError, message, nearest_of
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.ranges import LENGTH
from holdfast.base.rigid import Y_TO_Z, transform
from holdfast.base.text import quoted
from holdfast.geometry.gltf import container
from holdfast.scene.formats.references import References
from holdfast.scene.formats.source import MAX_BYTES, Source
from holdfast.scene.meshes.by_trimesh import read_glb
from holdfast.scene.shapes import MassProperties, Mesh
from holdfast.scene.xml import Element

CONE_SIDES = 64  # of the prism that stands for a round side
ROUNDED = 1e-6  # share of an outline's size within which a point is one of its own, rounded
PICTURES = ("images", "textures", "samplers", "materials")  # they do not matter for a scene at rest
WAYS = ("mesh", "hull")  # what the option collision= may ask for

Collision = Literal["mesh", "hull"] | Mapping[str, Literal["mesh", "hull"]]


def cone(radius: float, length: float, where: str) -> tuple[Mesh, MassProperties]:
    """Return a pyramid inscribed in a cone, apex up, centred at half its height, and the cone's mass properties."""
    for name, value in (("radius", radius), ("length", length)):
        checked_number(value, f"{where}: {name}", above=0, within=LENGTH, error=GeometryError)
    n = CONE_SIDES
    turn = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(n, -length / 2)])
    i = np.arange(n)
    j = (i + 1) % n
    faces = np.vstack([np.column_stack([i, j, np.full(n, n)]), np.column_stack([j, i, np.full(n, n + 1)])])
    mesh = Mesh(np.vstack([ring, [[0, 0, length / 2], [0, 0, -length / 2]]]), faces, label=where)
    volume = np.pi * radius**2 * length / 3
    across, along = 3 / 20 * radius**2 + 3 / 80 * length**2, 3 / 10 * radius**2
    com = np.array([0.0, 0.0, -length / 4])
    return mesh, MassProperties(volume, com, volume * np.diag([across, across, along]))


def extruded(outlines: Sequence[Float], height: float, where: str) -> Mesh:
    """Return the solid from z = 0 to ``height`` above closed outlines, each (n, 2) [m]; one within another is a hole.

    Raises GeometryError if they enclose nothing.
    """
    checked_number(height, f"{where}: height", above=0, within=LENGTH, error=GeometryError)
    flat = manifold3d.CrossSection(list(outlines), manifold3d.FillRule.EvenOdd)
    solid = manifold3d.Manifold.extrude(flat, height)
    if solid.is_empty():
        raise GeometryError(message(where, "encloses no area", "needs an outline of three points and more"))
    found = solid.to_mesh64()
    vertices, known = np.array(found.vert_properties)[:, :3], np.vstack(outlines)
    # outlines are kept to eight digits there: the points are taken as they were given
    away, nearest = (np.asarray(each) for each in KDTree(known).query(vertices[:, :2]))
    near = away < ROUNDED * np.ptp(known, axis=0).max()
    vertices[near, :2] = known[nearest[near]]
    return Mesh(vertices, np.array(found.tri_verts), label=where)


def factors_of(element: Element, scale: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the three factors of the mesh of an element; raises SceneError if they mirror it."""
    x, y, z = scale
    if min(x, y, z) < 0:
        element.fail(f"scale = {x:g} {y:g} {z:g} mirrors the mesh", "needs factors > 0: mirror it in its file")
    return x, y, z


def hull_of(mesh: Mesh) -> Mesh:
    """Return the convex hull of a mesh; raises GeometryError if it is flat."""
    import trimesh

    with foreign(mesh.label, "is flat, so it has no convex hull", 'give collision="mesh"', GeometryError):
        hull = trimesh.convex.convex_hull(mesh.vertices)
    return Mesh(np.array(hull.vertices), np.array(hull.faces), label=mesh.label)


@dataclass(frozen=True)
class MeshRules:
    """How the mesh files of a scene are read: the axis that points up in them, and whether their hulls are taken.

    ``collision`` is "mesh" or "hull", or a mapping from names of bodies to these; the others are meshes. ``turns_gltf``
    says that the simulator turns glTF, in which y is up.
    """

    up_axis: Literal["y", "z"] | None
    collision: Collision
    turns_gltf: bool = False

    def __post_init__(self) -> None:
        if self.up_axis is not None:
            checked_word(self.up_axis, ("y", "z"), "up_axis")
        given = self.collision.items() if isinstance(self.collision, Mapping) else [("", self.collision)]
        for name, way in given:
            checked_word(way, WAYS, f"collision: {quoted(name)}" if name else "collision")

    def check_names(self, known: Collection[str]) -> None:
        """Raise SceneError if ``collision`` names a body that is not among the ``known`` ones."""
        for name in self.collision if isinstance(self.collision, Mapping) else ():
            if name not in known:
                problem = f"no body is named {quoted(name)}"
                raise SceneError(message("collision", problem, nearest_of(str(name), known)))

    def hulled(self, *names: str) -> bool:
        """Whether the body with these names (its own and those of what it is in) is to be the hull of its meshes."""
        if not isinstance(self.collision, Mapping):
            return self.collision == "hull"
        return any(self.collision.get(name) == "hull" for name in names)

    def read(self, path: Path, scale: tuple[float, float, float], notes: list[str], *names: str) -> Mesh:
        """Return the mesh in a file, for the body with these names, and note what was done to it."""
        is_gltf, up = path.suffix.lower() in (".glb", ".gltf"), self.up_axis
        if up == "y":
            notes.append("mesh files: y is up in them, as up_axis= says, and is turned to z")
        if is_gltf and up is None:
            if not self.turns_gltf:
                problem = "is glTF, in which y is up; programs disagree whether to turn it"
                remedy = 'say up_axis="y" to turn it, or "z" to take it as it is'
                raise GeometryError(message(str(path), problem, remedy))
            up = "y"
        if path.suffix.lower() != ".gltf":
            return self.taken(Mesh.from_file(path, scale=scale, up_axis=up), notes, *names)
        check_ordinary(path, "mesh file", error=GeometryError, remedy="paths are relative to the scene file")
        with foreign(str(path), error=GeometryError):
            vertices, faces = read_glb(packed(Source(path)))
        turned = transform(Y_TO_Z, vertices) if up == "y" else vertices
        return self.taken(Mesh(turned * np.array(scale), faces, label=str(path)), notes, *names)

    def turned(self, mesh: Mesh) -> Mesh:
        """Return a mesh from a file, turned so that its axis ``up_axis`` is z."""
        return mesh if self.up_axis != "y" else Mesh(transform(Y_TO_Z, mesh.vertices), mesh.faces, label=mesh.label)

    def taken(self, mesh: Mesh, notes: list[str], *names: str) -> Mesh:
        """Return the mesh, or its hull, for the body with these names."""
        if not self.hulled(*names):
            return mesh
        notes.append("meshes are their convex hulls, as collision= says")
        return hull_of(mesh)


MESHES = MeshRules(None, "mesh")  # all are taken as they are


def packed(source: Source) -> bytes:
    """Return a .gltf file and the files that it needs as one binary file, without images.

    Raises ValueError if it is malformed, and SceneError if a file to which it refers is missing or elsewhere.
    """
    version = str(source.data["asset"]["version"])
    if not version.startswith("2."):
        raise ValueError(f"is of version {quoted(version)}, not 2")
    data: dict[str, Any] = {key: value for key, value in source.data.items() if key not in PICTURES}
    buffers, views = data.get("buffers", []), data.get("bufferViews", [])
    parts, starts, end = [], [], 0
    for buffer in buffers:
        content = _buffer(str(buffer["uri"]), source) if "uri" in buffer else b""
        if len(content) < int(buffer["byteLength"]) or end > MAX_BYTES:
            raise ValueError(f"says a buffer of {buffer['byteLength']} bytes, and has {len(content):,}")
        content += b"\0" * (-len(content) % 4)
        parts.append(content)
        starts.append(end)
        end += len(content)
    data["bufferViews"] = [
        view | {"buffer": 0, "byteOffset": int(view.get("byteOffset", 0)) + starts[view["buffer"]]} for view in views
    ]
    data["buffers"] = [{"byteLength": end}] if parts else []
    data["meshes"] = [
        mesh | {"primitives": [{k: v for k, v in each.items() if k != "material"} for each in mesh["primitives"]]}
        for mesh in data.get("meshes", [])
    ]
    return container(data, b"".join(parts))


def _buffer(uri: str, source: Source) -> bytes:
    if uri.startswith("data:"):
        kind, comma, text = uri.partition(",")
        if not comma or not kind.endswith(";base64"):
            raise ValueError(f"has a buffer {quoted(uri)}, which is not base64")
        return base64.b64decode(text, validate=True)
    path = References(source.path, None, "a file of its folder, not package").file(uri, f"{source.path}: buffer")
    return read_ordinary(path, "buffer", most=MAX_BYTES)
