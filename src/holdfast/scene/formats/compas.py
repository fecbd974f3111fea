"""Reads COMPAS assemblies (compas_assembly, COMPAS 1 and 2), block models of compas_dem, and lists of meshes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, SceneError, message
from holdfast.base.ranges import PLACE, SCALE
from holdfast.base.text import listed, quoted
from holdfast.scene.formats.links import checked_fixed, not_read, unknown_keys
from holdfast.scene.formats.named_meshes import Numbers, Weights, scene_of_nodes
from holdfast.scene.formats.published import triangulated
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import Source
from holdfast.scene.friction import Friction
from holdfast.scene.meshes.by_trimesh import Node
from holdfast.scene.scene import Scene

Data = Mapping[str, Any]

MESH = "compas.datastructures/Mesh"
# Keys that are read, or do not matter; a note lists all others
MODEL_KEYS = ("attributes", "graph", "elements", "tree", "transformation")
GRAPH_KEYS = ("attributes", "node", "edge", "adjacency", "max_node", "default_node_attributes",
              "default_edge_attributes", "dna", "dea")  # fmt: skip
NODE_KEYS = ("block", "element", "is_support", "x", "y", "z", "displacement", "section", "mesh_size")
ELEMENT_KEYS = ("geometry", "shape", "is_support", "transformation", "name")
MESH_KEYS = ("attributes", "vertex", "face", "max_vertex", "max_face", "edgedata", "facedata", "dva", "dea", "dfa",
             "default_vertex_attributes", "default_edge_attributes", "default_face_attributes")  # fmt: skip


def sniff(source: Source) -> bool:
    """Tell whether the file is JSON of an assembly or a model of COMPAS, or a list of its meshes."""
    data = source.data
    if isinstance(data, list):
        return bool(data) and all(_dtype(each) == MESH for each in data)
    kind = _dtype(data)
    return kind.startswith("compas_") and kind.endswith(("Assembly", "Model"))


def _dtype(data: Any) -> str:  # noqa: ANN401 - plain data
    kind = data.get("dtype") if isinstance(data, dict) else None
    return kind if isinstance(kind, str) else ""


def read(
    source: Source,
    *,
    friction: Friction | float | None = None,
    density: Numbers | None = None,
    mass: Numbers | None = None,
    fixed: Collection[str] = (),
    floor: bool = False,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of an assembly: one body for each block, named by the number of its node in the graph.

    In a list of meshes, each mesh is a block named by its position from 0, and none is a support. Supports and the
    blocks named in ``fixed`` are fixed. COMPAS files have neither friction nor masses nor units: ``friction`` and
    ``density`` [kg/m³] or ``mass`` [kg] are needed, each one number or one for each name, and lengths are taken as
    metres. Interfaces in the file are ignored; contacts are detected. ``floor`` adds the half space below z = 0.

    Raises SceneError or GeometryError if the file is malformed, or if friction or masses are missing.
    """
    where = str(source.path)
    with foreign(where, "is no assembly of COMPAS", "needs blocks with meshes: save it again with compas.json_dump"):
        blocks, supports, edges = _blocks(source.data)
        unknown = list(_unknown(source.data, [mesh for mesh, _ in blocks.values()]))
        nodes = [_node(name, mesh, matrix, where) for name, (mesh, matrix) in blocks.items()]
    if friction is None:
        raise SceneError(message(where, "says nothing of friction", "give friction="))
    names = list(blocks)
    weights = Weights(mass, density, names)
    notes = ["lengths are taken as metres: COMPAS keeps no units", *not_read(Counter(unknown))]
    if edges:
        notes.append(f"interfaces in the file are ignored, {edges} of them: contacts are found anew")
    if supports:
        notes.append(f"fixed, as supports: {listed(supports)}")
    return scene_of_nodes(
        nodes,
        {name: weights.of(name) for name in names},
        friction,
        [*supports, *checked_fixed(fixed, names, "node")],
        {},
        up="z",
        floor=floor,
        gravity=gravity,
        name=source.path.stem,
        notes=notes,
    )


def _inside(wrapped: Any) -> Data:  # noqa: ANN401
    """Return the content of a COMPAS object: ``data`` since version 2.0, ``value`` before."""
    inner = wrapped["data"] if "data" in wrapped else wrapped["value"]
    if not isinstance(inner, Mapping):
        raise TypeError(f"{quoted(wrapped.get('dtype'))} holds no map")
    return inner


def _blocks(data: Data | list[Data]) -> tuple[dict[str, tuple[Data, Float]], list[str], int]:
    """Return the mesh and the matrix (4, 4) of each block by name, the names of supports, and the number of edges."""
    if isinstance(data, list):
        return {str(k): (_inside(mesh), np.eye(4)) for k, mesh in enumerate(data)}, [], 0
    inner = _inside(data)
    graph = inner["graph"]
    graph = _inside(graph) if "dtype" in graph else graph
    edges = sum(len(ends) for ends in graph.get("edge", {}).values())
    if "elements" not in inner:
        found = {str(key): (_inside(node["block"]), np.eye(4)) for key, node in graph["node"].items()}
        return found, [str(key) for key, node in graph["node"].items() if node.get("is_support")], edges
    elements = _elements(inner)
    places = _places(inner, elements)
    found, supports = {}, []
    for key, node in graph["node"].items():
        element = elements[node["element"]]
        geometry = element.get("geometry", element.get("shape"))  # as early versions of compas_dem call it
        if geometry is None:  # a group of elements
            continue
        kind = str(geometry["dtype"])
        if not kind.endswith("Mesh"):
            raise ValueError(f"the geometry of element {key} is a {quoted(kind)}, not a mesh")
        matrix = places.get(node["element"], np.eye(4)) @ _matrix(element.get("transformation"))
        found[str(key)] = (_inside(geometry), matrix)
        if element.get("is_support"):
            supports.append(str(key))
    return found, supports, edges


def _unknown(data: Data | list[Data], meshes: list[Data]) -> Iterator[str]:
    """Yield the words in a file that say something of blocks and are not read."""
    for mesh in meshes:
        yield from unknown_keys(mesh, MESH_KEYS, "meshes")
        yield from unknown_keys(mesh.get("attributes", {}), ("name", "node"), "attributes of meshes")
    if isinstance(data, list):
        return
    inner = _inside(data)
    graph = inner["graph"]
    graph = _inside(graph) if "dtype" in graph else graph
    yield from unknown_keys(inner, MODEL_KEYS, "the model")
    yield from unknown_keys(graph, GRAPH_KEYS, "the graph")
    for node in graph["node"].values():
        yield from unknown_keys(node, NODE_KEYS, "nodes")
    for element in _elements(inner).values() if "elements" in inner else ():
        yield from unknown_keys(element, ELEMENT_KEYS, "elements")


def _elements(model: Data) -> dict[str, Data]:
    """Return the elements of a model by their names, which earlier versions keep in each element of a list."""
    given = model["elements"]
    named = given.items() if isinstance(given, Mapping) else ((each["guid"], each) for each in given)
    return {guid: _inside(element) for guid, element in named}


def _places(model: Data, elements: Mapping[str, Data]) -> dict[str, Float]:
    """Return the matrix (4, 4) from the frame of each element to the world, by the tree of the model."""
    found = {}
    waiting = [(model.get("tree", {}).get("root", {}), _matrix(model.get("transformation")))]
    while waiting:
        node, matrix = waiting.pop()
        guid = node.get("element")
        if guid is not None:
            found[guid] = matrix
            matrix = matrix @ _matrix(elements[guid].get("transformation"))
        waiting += [(child, matrix) for child in node.get("children", [])]
    return found


def _matrix(transformation: Any) -> Float:  # noqa: ANN401
    if transformation is None:
        return np.eye(4)
    return checked(_inside(transformation)["matrix"], (4, 4), "transformation", within=SCALE, error=GeometryError)


def _node(name: str, mesh: Data, matrix: Float, where: str) -> Node:
    place = f"{where}: block {quoted(name)}"
    number = {key: k for k, key in enumerate(mesh["vertex"])}
    usual = mesh.get("default_vertex_attributes", mesh.get("dva", {}))
    rows = [[{**usual, **vertex}[axis] for axis in "xyz"] for vertex in mesh["vertex"].values()]
    vertices = checked(rows, (None, 3), f"{place}: vertices", within=PLACE, error=GeometryError)
    faces = [np.array([number[str(key)] for key in face], dtype=np.int64) for face in mesh["face"].values()]
    triangles = [triangulated(vertices, face) for face in faces if len(face) > 2]
    if not triangles:
        raise GeometryError(message(place, "has no faces", "needs a closed mesh"))
    return Node(name, vertices, np.vstack(triangles), matrix)


COMPAS = Format("COMPAS assembly", (".json",), sniff, read, mark="`dtype: compas_.../Assembly`")
