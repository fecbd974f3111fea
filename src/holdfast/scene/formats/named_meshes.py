"""Scenes of meshes without masses, friction or gravity: of trimesh, and of mesh files."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_mapping, checked_name, checked_number, checked_word
from holdfast.base.errors import GeometryError, SceneError, located, message, nearest_of
from holdfast.base.ranges import DENSITY, MASS, SCALE
from holdfast.base.rigid import Y_TO_Z
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Shape
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats.links import checked_fixed, copies_of, scene_of, with_floor
from holdfast.scene.formats.made_meshes import MESHES, Collision, MeshRules
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.by_trimesh import Node, nodes_of
from holdfast.scene.meshes.read import objects_of_obj
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

Numbers = float | Mapping[str, float]
Weight = tuple[float | None, float | None]  # a mass [kg] and a density [kg/m³]

GRAVITY = (0.0, 0.0, -9.81)  # [m/s²]
LEAST_STRETCH = 1e-9  # [-] least stretch of a matrix; with less it is singular
SUFFIXES = (".obj", ".stl", ".ply", ".off", ".dae")


class KnownBody(NamedTuple):
    """Data of a body besides the mesh of its node: its ``shape``, if it is not just the mesh, and its ``noise`` [m].

    ``com`` (3,) [m] and ``inertia`` (3, 3) [kg m²] are as in ``Body``; the origin of the mesh is at ``origin`` (3,) [m]
    in the frame of the body.
    """

    shape: Shape | None
    noise: float
    com: Float | None
    inertia: Float | None
    origin: Float


def from_trimesh(
    meshes: Any,  # noqa: ANN401 - a trimesh.Scene or trimesh.Trimesh, whose types are not followed
    *,
    friction: Friction | float,
    mass: Numbers | None = None,
    density: Numbers | None = None,
    fixed: Collection[str] = (),
    materials: Mapping[str, str] | None = None,
    up_axis: Literal["y", "z"] = "z",
    floor: bool = False,
) -> Scene:
    """Return the scene of ``meshes``: a ``trimesh.Scene``, or one ``trimesh.Trimesh``, which is named ``mesh``.

    Every node with triangles is a body with its name. A scale in its matrix is applied to the vertices, and the rest is
    its pose. ``mass`` [kg] and ``density`` [kg/m³] are one number for all movable bodies, or one for each name. A
    number for a name has priority, and so has a mass over a density. ``fixed`` are names of bodies, and ``materials``
    maps names of bodies to materials for the friction table. With ``up_axis="y"`` everything is rotated so that y
    becomes z. ``floor`` adds the half space below z = 0. Lengths are in metres. Gravity is 9.81 m/s² downwards;
    ``dataclasses.replace`` gives the scene another, or a name.

    Raises SceneError for unknown names and missing masses, and GeometryError for meshes and matrices that are invalid.

    For example:

    >>> import trimesh
    >>> crate = trimesh.creation.box((0.3, 0.2, 0.2), trimesh.transformations.translation_matrix((0, 0, 0.1)))
    >>> scene = hf.from_trimesh(crate, friction=0.5, mass=4, floor=True)
    >>> print(hf.stability(scene).status)
    stable
    """
    if not hasattr(meshes, "graph"):
        if not hasattr(meshes, "faces"):
            problem = f"got a {type(meshes).__name__}"
            raise SceneError(message("from_trimesh", problem, "needs a trimesh.Scene or a trimesh.Trimesh"))
        nodes = [Node("mesh", np.array(meshes.vertices, dtype=np.float64), np.array(meshes.faces), np.eye(4))]
    else:
        nodes = nodes_of(meshes)
    if materials is not None:
        materials = checked_mapping(materials, "materials", '{"table": "oak"}')
    names = [node.name for node in nodes]
    given = Weights(mass, density, names)
    weights = {name: given.of(name) for name in names}
    return scene_of_nodes(
        nodes, weights, friction, fixed, materials or {}, up=up_axis, floor=floor, gravity=GRAVITY, name="", notes=[]
    )


def scene_of_nodes(
    nodes: Sequence[Node],
    weights: Mapping[str, Weight],
    friction: Friction | float,
    fixed: Collection[str],
    material: Mapping[str, str],
    *,
    up: str,
    floor: bool,
    gravity: ArrayLike,
    name: str,
    notes: list[str],
    known: Mapping[str, KnownBody] | None = None,
    rules: MeshRules = MESHES,
    excluded: Sequence[Excluded] = (),
) -> Scene:
    """Return the scene of these nodes: one body for each, as ``from_trimesh`` makes them.

    ``weights`` holds a mass or a density for each name, ``known`` holds further data of some bodies, by name, and
    ``excluded`` are pairs that do not touch. Of the others, ``rules`` say which are the hulls of their meshes.
    """
    names = [node.name for node in nodes]
    if not names:
        raise SceneError(message("scene", "holds no triangles", "needs a node with a mesh"))
    checked_word(up, ("y", "z"), "up_axis")
    fixed_names = checked_fixed(fixed, names, "node")
    check_names("materials", material, names)
    if up == "y":
        notes.append("y is up in the file: turned about x so that z is up")
        nodes = [node._replace(matrix=Y_TO_Z @ node.matrix) for node in nodes]
    known_bodies = known or {}
    bodies = []
    for node in nodes:
        of_body = node, weights[node.name], node.name in fixed_names, material.get(node.name)
        known_body = known_bodies.get(node.name)
        bodies.append(_body(*of_body, rules, notes) if known_body is None else _known_body(*of_body, known_body))
    remedy = f"give fixed=[name] ({listed(names)}), or floor=True for a floor at z = 0"
    return scene_of(with_floor(bodies, floor, "scene", remedy), friction, gravity, name, notes, excluded)


def check_names(what: str, names: Any, known: Sequence[str]) -> None:  # noqa: ANN401
    """Raise SceneError if a key of a mapping, or an item of a list, is not among the known names."""
    if isinstance(names, Mapping | list):
        there = frozenset(known)
        for name in names:
            if not isinstance(name, str) or name not in there:
                raise SceneError(message(what, f"no node is named {quoted(name)}", nearest_of(name, known)))


class Weights:
    """Masses [kg] and densities [kg/m³] that are given to a reader, each one number for all names or one for a name."""

    def __init__(self, mass: Numbers | None, density: Numbers | None, names: Sequence[str]) -> None:
        """Raise SceneError for unknown names, and for an invalid number for all; others are checked where used."""
        self.given = mass, density
        for what, each, within in (("mass", mass, MASS), ("density", density, DENSITY)):
            check_names(what, each, names)
            if each is not None and not isinstance(each, Mapping):
                checked_number(each, what, above=0, within=within)

    def of(self, name: str, *said: Weight, alone: bool = False, last: Weight = (None, None)) -> Weight:
        """Return the mass or the density of a name, None for both if there is none.

        First comes what is given for the name, then what files have ``said`` of it and, unless it is to be ``alone``,
        what is given for all, and what a file says ``last``. A mass has priority over a density.
        """
        mass, density = (each.get(name) if isinstance(each, Mapping) else None for each in self.given)
        for_all, dense = (None if isinstance(each, Mapping) else each for each in self.given)
        weights = ((mass, density), *said, *(() if alone else ((for_all, dense), last)))
        mass, density = next((each for each in weights if each != (None, None)), (None, None))
        return mass, None if mass is not None else density


def _body(node: Node, weight: Weight, fixed: bool, material: str | None, rules: MeshRules, notes: list[str]) -> Body:
    where = f"node {quoted(node.name)}"
    mass, density = (weight[0], None) if fixed else weight
    if (mass, density) == (None, None) and not fixed:
        raise SceneError(message(where, "has no mass", "give mass= or density=, for it or for all, or fixed=[name]"))
    pose, stretch = split(node.matrix, where)
    vertices = node.vertices if np.array_equal(stretch, np.eye(3)) else node.vertices @ stretch.T
    faces = node.faces if np.linalg.det(stretch) > 0 else node.faces[:, ::-1]
    mesh = rules.taken(Mesh(vertices, faces, label=where), notes, node.name)
    return Body(node.name, mesh, mass=mass, density=density, pose=pose, material=material, fixed=fixed)


def _known_body(node: Node, weight: Weight, fixed: bool, material: str | None, known: KnownBody) -> Body:
    where = f"node {quoted(node.name)}"
    pose, _ = split(node.matrix, where)
    shape = known.shape
    if shape is None:
        shape = Mesh(node.vertices + known.origin, node.faces, noise=known.noise, label=where)
        if known.origin.any():
            pose[:3, 3] -= pose[:3, :3] @ known.origin
    mass, density = weight
    return Body(node.name, shape, mass, density, pose, known.com, known.inertia, material, fixed)


def split(matrix: Float, where: str) -> tuple[Float, Float]:
    """Split an affine matrix (4, 4) into a pose (4, 4) and the scale, shear and mirror (3, 3) applied before it.

    Raises GeometryError if the matrix is not finite, is huge or singular, or if its last row is not (0, 0, 0, 1).
    """
    matrix = checked(matrix, (4, 4), f"{where}: matrix", within=SCALE, error=GeometryError)
    linear = matrix[:3, :3]
    if not np.allclose(matrix[3], (0, 0, 0, 1), atol=1e-9):
        raise GeometryError(message(where, f"has the last row {matrix[3].tolist()}", "needs (0, 0, 0, 1)"))
    pose = np.eye(4)
    pose[:3, 3] = matrix[:3, 3]
    if np.abs(linear.T @ linear - np.eye(3)).max() < LEAST_STRETCH and np.linalg.det(linear) > 0:
        pose[:3, :3] = linear
        return pose, np.eye(3)
    u, sizes, vt = np.linalg.svd(linear)
    if not sizes[2] > LEAST_STRETCH * sizes[0]:
        raise GeometryError(
            message(where, f"is scaled to nothing: {linear.tolist()}", "needs a matrix that is not flat")
        )
    turn = u @ vt
    turn = turn if np.linalg.det(turn) > 0 else -turn
    pose[:3, :3] = turn
    return pose, np.asarray(turn.T @ linear)


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
    weights = Weights(mass, density, list(placed))
    fixed_names = frozenset(placed) if fixed is True else checked_fixed(() if fixed is False else fixed, placed)
    meshed = []
    for name, (at, mesh) in placed.items():
        weight = (None, None) if name in fixed_names else weights.of(name)
        if weight == (None, None) and name not in fixed_names:
            remedy = "give density= or mass=, for it or for all, or fixed=[name]"
            raise SceneError(message(f"{where}: body {quoted(name)}", "has no mass", remedy))
        with located(where):
            meshed.append(Body(name, mesh, *weight, pose=at, fixed=name in fixed_names))
    remedy = f"give floor=True for a floor at z = 0, or fixed=[name] ({listed(list(placed))})"
    meshed = with_floor(meshed, floor, where, remedy, problem="is a thing that nothing carries")
    return scene_of(meshed, friction, gravity, source.path.stem, notes)


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
