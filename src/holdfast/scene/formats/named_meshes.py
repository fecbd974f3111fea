"""Scenes of named meshes without masses, friction or gravity, as trimesh and glTF have them: ``hf.from_trimesh``."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked, checked_mapping, checked_number, checked_word
from holdfast.base.errors import GeometryError, SceneError, message, nearest_of
from holdfast.base.ranges import DENSITY, MASS, SCALE
from holdfast.base.rigid import Y_TO_Z
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Shape
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats.links import checked_fixed, scene_of, with_floor
from holdfast.scene.formats.made_meshes import MESHES, MeshRules
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.by_trimesh import Node, nodes_of
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Mesh

Numbers = float | Mapping[str, float]
Weight = tuple[float | None, float | None]  # a mass [kg] and a density [kg/m³]

GRAVITY = (0.0, 0.0, -9.81)  # [m/s²]
LEAST_STRETCH = 1e-9  # [-] least stretch of a matrix; with less it is singular


class Known(NamedTuple):
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
    check_weights(mass, density, names)
    weights = {name: first_of(own(mass, density, name), common(mass, density)) for name in names}
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
    known: Mapping[str, Known] | None = None,
    rules: MeshRules = MESHES,
    excluded: Sequence[Excluded] = (),
) -> Scene:
    """Return the scene of these nodes, with a mass or a density for each name; otherwise as ``from_trimesh``.

    ``known`` holds further data of some bodies, by name, and ``excluded`` are pairs that do not touch. Of the others,
    ``rules`` say which are the hulls of their meshes.
    """
    names = [node.name for node in nodes]
    if not names:
        raise SceneError(message("scene", "holds no triangles", "needs a node with a mesh"))
    checked_word(up, ("y", "z"), "up_axis")
    held = checked_fixed(fixed, names, "node")
    check_names("materials", material, names)
    if up == "y":
        notes.append("y is up in the file: turned about x so that z is up")
    more = known or {}
    bodies = []
    for node in nodes:
        taken = partial(_body, rules=rules, notes=notes)
        body = taken if node.name not in more else partial(_known_body, known=more[node.name])
        turn = Y_TO_Z if up == "y" else None
        bodies.append(body(node, weights[node.name], node.name in held, material.get(node.name), turn))
    remedy = f"give fixed=[name] ({listed(names)}), or floor=True for a floor at z = 0"
    return scene_of(with_floor(bodies, floor, "scene", remedy), friction, gravity, name, notes, excluded)


def check_names(what: str, names: Any, known: Sequence[str]) -> None:  # noqa: ANN401
    """Raise SceneError if a key of a mapping, or an item of a list, is not among the known names."""
    if isinstance(names, Mapping | list):
        there = frozenset(known)
        for name in names:
            if not isinstance(name, str) or name not in there:
                raise SceneError(message(what, f"no node is named {quoted(name)}", nearest_of(name, known)))


def check_weights(mass: Numbers | None, density: Numbers | None, names: Sequence[str]) -> None:
    """Raise SceneError for masses or densities of unknown names, and for an invalid number for all bodies.

    Numbers for single names are checked where they are used.
    """
    for what, given, within in (("mass", mass, MASS), ("density", density, DENSITY)):
        check_names(what, given, names)
        if given is not None and not isinstance(given, Mapping):
            checked_number(given, what, above=0, within=within)


def own(mass: Numbers | None, density: Numbers | None, name: str) -> Weight:
    """Return the mass and density that are given for a name."""
    mass_of, density_of = (each.get(name) if isinstance(each, Mapping) else None for each in (mass, density))
    return mass_of, density_of


def common(mass: Numbers | None, density: Numbers | None) -> Weight:
    """Return the mass and density that are given for all names."""
    for_all, dense = (None if isinstance(each, Mapping) else each for each in (mass, density))
    return for_all, dense


def first_of(*weights: Weight) -> Weight:
    """Return the first of these that gives a number; a mass has priority over a density."""
    mass, density = next((each for each in weights if each != (None, None)), (None, None))
    return mass, None if mass is not None else density


def _body(
    node: Node,
    weight: Weight,
    fixed: bool,
    material: str | None,
    turn: Float | None,
    rules: MeshRules,
    notes: list[str],
) -> Body:
    where = f"node {quoted(node.name)}"
    mass, density = (weight[0], None) if fixed else weight
    if (mass, density) == (None, None) and not fixed:
        raise SceneError(message(where, "has no mass", "give mass= or density=, for it or for all, or fixed=[name]"))
    pose, stretch = split(node.matrix if turn is None else turn @ node.matrix, where)
    vertices = node.vertices if np.array_equal(stretch, np.eye(3)) else node.vertices @ stretch.T
    faces = node.faces if np.linalg.det(stretch) > 0 else node.faces[:, ::-1]
    mesh = rules.taken(Mesh(vertices, faces, label=where), notes, node.name)
    return Body(node.name, mesh, mass=mass, density=density, pose=pose, material=material, fixed=fixed)


def _known_body(
    node: Node, weight: Weight, fixed: bool, material: str | None, turn: Float | None, *, known: Known
) -> Body:
    where = f"node {quoted(node.name)}"
    pose, _ = split(node.matrix if turn is None else turn @ node.matrix, where)
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
