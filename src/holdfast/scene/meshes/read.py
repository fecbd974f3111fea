"""Read the triangles of a mesh file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from holdfast.base.arrays import Float, Int, checked_word
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, message
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.rigid import Y_TO_Z, transform
from holdfast.scene.meshes import dae
from holdfast.scene.meshes.by_trimesh import read_glb, read_ply
from holdfast.scene.meshes.text_meshes import read_obj, read_off, read_stl

MAX_BYTES = 1_000_000_000  # size of the largest mesh file that is read

Reader = Callable[[bytes], tuple[Float, Int]]

READERS: dict[str, Reader] = {
    ".obj": read_obj,
    ".stl": read_stl,
    ".ply": read_ply,
    ".glb": read_glb,
    ".off": read_off,
    ".dae": dae.read,
}
SUFFIXES = tuple(READERS)  # suffixes of the mesh files that can be read


def triangles_of(path: Path, up_axis: str | None = None) -> tuple[Float, Int]:
    """Return the vertices (V, 3), in the units of the file, and the triangles (F, 3) of a mesh file.

    DAE files say their unit, so their vertices are in metres. All pieces of the file become one mesh; materials and
    textures are ignored. With ``up_axis="y"`` they are turned about x so that y is z; if ``up_axis`` is given, the up
    axis that a DAE file says does not count. Raises GeometryError if the file cannot be read completely.
    """
    if up_axis is not None:
        checked_word(up_axis, ("y", "z"), f"{path}: up_axis", GeometryError)
    where, reader = str(path), READERS.get(path.suffix.lower())
    check_ordinary(path, "mesh file", error=GeometryError, remedy="paths are relative to the scene file")
    if reader is None:
        raise GeometryError(message(where, f"suffix {path.suffix!r}", f"reads {', '.join(SUFFIXES)}"))
    content = read_ordinary(path, "mesh file", most=MAX_BYTES, error=GeometryError, too_large="simplify the mesh")
    with foreign(where, error=GeometryError), np.errstate(invalid="ignore"):  # NaN in integers is an error of the mesh
        vertices, faces = dae.read(content, any_up=True) if up_axis and reader is dae.read else reader(content)
    if not len(faces):
        raise GeometryError(message(where, "holds no triangles", "needs a surface mesh, not points or lines"))
    if up_axis == "y":
        vertices = transform(Y_TO_Z, np.asarray(vertices, dtype=np.float64))
    return np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)
