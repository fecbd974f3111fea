"""Read block assemblies: polygon meshes with one friction coefficient (keys ``blocks`` and ``interfaces``).

A scene holds no contacts, so the interfaces in such a file, which another program detected, are ignored.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np

from holdfast.base.arrays import Float, Int, checked, checked_number
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError
from holdfast.base.ranges import FRICTION, PLACE
from holdfast.base.rigid import tangents
from holdfast.base.text import quoted
from holdfast.geometry.area import outline_vector
from holdfast.scene.body import Body
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.rigid_parts import not_read, unknown_keys
from holdfast.scene.formats.source import Source
from holdfast.scene.meshes.text_meshes import fan
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

KEYS = ("name", "source", "licence", "units", "friction", "gravity", "blocks", "interfaces", "expected")
NEEDED = "needs blocks (name, vertices, faces, mass, fixed), friction, gravity"
BLOCK_KEYS = ("name", "vertices", "faces", "mass", "fixed")


def sniff(source: Source) -> bool:
    """Tell whether the file is a block assembly."""
    data = source.data
    return isinstance(data, dict) and isinstance(data.get("blocks"), list)


def read(source: Source) -> Scene:
    """Return the scene of a block assembly; faces may have more than three corners and may be non-convex.

    Raises SceneError if the file is not a valid block assembly.
    """
    data, path = source.data, source.path
    with foreign(str(path), "is not a block assembly", NEEDED):
        bodies = [_body(block, path) for block in data["blocks"]]
        friction = checked_number(data["friction"], f"{path}: friction", minimum=0, within=FRICTION)
        found = Counter(unknown_keys(data, KEYS, "the file"))
        for block in data["blocks"]:
            found.update(unknown_keys(block, BLOCK_KEYS, "blocks"))
        return Scene(bodies, friction, data["gravity"], data.get("name", path.stem), notes=not_read(found))


def _body(block: dict[str, Any], path: Path) -> Body:
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


PUBLISHED = Format("block assembly", (".json",), sniff, read, mark="`blocks`")
