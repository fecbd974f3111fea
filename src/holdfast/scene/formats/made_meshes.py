"""Meshes for what files describe otherwise: cones, extruded outlines, and convex hulls in place of meshes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import manifold3d
import numpy as np
from scipy.spatial import KDTree

from holdfast.base.arrays import Float, checked_number, checked_word
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, SceneError, message, nearest_of
from holdfast.base.files import check_ordinary
from holdfast.base.ranges import LENGTH
from holdfast.base.rigid import Y_TO_Z, transform
from holdfast.base.text import quoted
from holdfast.scene.formats.gltf.joined import packed
from holdfast.scene.formats.source import Source
from holdfast.scene.meshes import glb
from holdfast.scene.shapes import MassProperties, Mesh

CONE_SIDES = 64  # of the prism that stands for a round side
ROUNDED = 1e-6  # share of an outline's size within which a point is one of its own, rounded
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
            vertices, faces = glb.read(packed(Source(path)))
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
