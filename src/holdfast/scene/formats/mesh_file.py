"""Reads mesh files (.obj, .stl, .ply, .off, .dae) as scenes: one body, or one body for each object of the file."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Literal

from numpy.typing import ArrayLike

from holdfast.base.arrays import checked_name, checked_word
from holdfast.base.errors import SceneError, located, message
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.formats.links import checked_fixed, copies_of, scene_of, with_floor
from holdfast.scene.formats.made_meshes import Collision, MeshRules
from holdfast.scene.formats.named_meshes import Numbers, check_weights, common, first_of, own
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.text_meshes import objects_of_obj
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

SUFFIXES = (".obj", ".stl", ".ply", ".off", ".dae")


def read(
    source: Source,
    *,
    bodies: Literal["one", "objects"] = "one",
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: bool | Collection[str] = (),
    pose: ArrayLike | None = None,
    poses: Mapping[str, ArrayLike] | None = None,
    floor: bool = False,
    collision: Collision = "mesh",
    up_axis: Literal["y", "z"] | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of a mesh file: one body with the name of the file.

    With ``bodies="objects"`` each object (``o``, or group ``g``) of an OBJ file is a body with its name. Mesh files
    have neither friction nor masses: ``friction``, and ``density`` [kg/m³] or ``mass`` [kg] of what is not ``fixed``
    are needed. Lengths are taken as metres. ``pose`` (4, 4) puts everything there; ``poses`` gives several copies
    instead. ``floor`` adds the half space below z = 0. With ``collision="hull"`` meshes are their convex hulls, and
    ``up_axis`` is the axis of the file that points up.

    Raises SceneError or GeometryError if the file cannot be read, or if something that is needed is not given.
    """
    where, notes = str(source.path), list[str]()
    checked_word(bodies, ("one", "objects"), "bodies")
    if source.given is not None:
        raise SceneError(message(where, "is not a file by itself", "meshes are read from files: save it first"))
    rules = MeshRules(up_axis, collision)
    meshes = _meshes(source, bodies, rules, notes)
    notes.append("lengths are taken as metres: mesh files have no units")
    if friction is None:
        remedy = "give friction=, density= or mass=, and floor=True or fixed="
        raise SceneError(
            message(where, "is a mesh, which says nothing of friction, of mass and of what it lies on", remedy)
        )
    copies = copies_of("", pose, poses)
    single = len(meshes) == 1
    placed = {(copy if single else f"{copy}/{name}") if copy else name: (at, mesh)
              for copy, at in copies for name, mesh in meshes.items()}  # fmt: skip
    rules.check_names([*meshes, *placed])
    check_weights(mass, density, list(placed))
    held = frozenset(placed) if fixed is True else checked_fixed(() if fixed is False else fixed, placed)
    found = []
    for name, (at, mesh) in placed.items():
        weight = (None, None) if name in held else first_of(own(mass, density, name), common(mass, density))
        if weight == (None, None) and name not in held:
            remedy = "give density= or mass=, for it or for all, or fixed=[name]"
            raise SceneError(message(f"{where}: body {quoted(name)}", "has no mass", remedy))
        with located(where):
            found.append(Body(name, mesh, *weight, pose=at, fixed=name in held))
    remedy = f"give floor=True for a floor at z = 0, or fixed=[name] ({listed(list(placed))})"
    found = with_floor(found, floor, where, remedy, problem="is a thing that nothing carries")
    return scene_of(found, friction, gravity, source.path.stem, notes)


def _meshes(source: Source, bodies: str, rules: MeshRules, notes: list[str]) -> dict[str, Mesh]:
    """Return the meshes of a file by their names."""
    name, path = checked_name(source.path.stem, f"{source.path}: name"), source.path
    if bodies == "one":
        return {name: rules.read(path, (1.0, 1.0, 1.0), notes, name)}
    if source.suffix != ".obj":
        remedy = "read it as one body, or export it as OBJ or GLB"
        raise SceneError(message(str(path), f"{source.suffix} files have no objects", remedy))
    with located(str(path)):
        rules.read(path, (1.0, 1.0, 1.0), notes, name)  # for the errors of the file as a whole
        found = {}
        for given, vertices, faces in objects_of_obj(source.content):
            own_name = checked_name(given or name, "name of an object")
            mesh = rules.turned(Mesh(vertices, faces, label=f"object {quoted(own_name)}"))
            found[own_name] = rules.taken(mesh, notes, own_name)
    return found


MESH_FILE = Format("mesh file", SUFFIXES, read=read)
