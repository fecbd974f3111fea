"""Assemblies of COMPAS, as compas_assembly 0.6 (COMPAS 1.17) and 0.7 (COMPAS 2.15) and compas_dem 0.6 write them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scene_content import Load, loading

import holdfast as hf

CORNERS = [(-1, -1, -1), (-1, 1, -1), (1, 1, -1), (1, -1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
FACES = [[0, 1, 2, 3], [0, 3, 5, 4], [3, 2, 6, 5], [2, 1, 7, 6], [1, 0, 4, 7], [4, 5, 6, 7]]
ZERO = {"x": 0.0, "y": 0.0, "z": 0.0}
AT = {"0": 0.0, "1": 1.0, "7": 2.0}  # heights of three cubes, the lowest one of which is a support


def mesh(z: float) -> dict[str, Any]:
    vertices = {str(k): {"x": x / 2, "y": y / 2, "z": c / 2 + z} for k, (x, y, c) in enumerate(CORNERS)}
    faces = {str(k): face for k, face in enumerate(FACES)}
    return {"attributes": {}, "vertex": vertices, "face": faces, "facedata": {}, "max_vertex": 7, "max_face": 5}


def of_compas_1() -> dict[str, Any]:
    def block(z: float) -> dict[str, Any]:
        return {"dtype": "compas_assembly.datastructures/Block", "value": {"dva": ZERO, **mesh(z)}, "guid": "g"}

    nodes = {key: {"block": block(z), **({} if z else {"is_support": True})} for key, z in AT.items()}
    graph = {"attributes": {"name": "Graph"}, "node": nodes, "edge": {"0": {"1": {"interfaces": []}}, "1": {"7": {}}}}
    return {"dtype": "compas_assembly.datastructures/Assembly", "value": {"attributes": {}, "graph": graph}}


def of_compas_2() -> dict[str, Any]:
    def block(z: float) -> dict[str, Any]:
        inner = {"default_vertex_attributes": ZERO, **mesh(z)}
        return {"dtype": "compas_assembly.datastructures/Block", "data": inner, "name": "Box", "guid": "g"}

    nodes = {key: {"block": block(z), **({} if z else {"is_support": True})} for key, z in AT.items()}
    graph = {"dtype": "compas.datastructures/Graph", "data": {"node": nodes, "edge": {"0": {"1": {}}, "1": {"7": {}}}}}
    return {"dtype": "compas_assembly.datastructures/Assembly", "data": {"attributes": {}, "graph": graph}}


def moved(z: float) -> dict[str, Any]:
    matrix = np.eye(4)
    matrix[2, 3] = z
    return {"dtype": "compas.geometry/Transformation", "data": {"matrix": matrix.tolist()}}


def of_compas_dem() -> dict[str, Any]:
    """The blocks hang below a group that is moved, and the model is moved, too."""

    def element(z: float) -> dict[str, Any]:
        geometry = {"dtype": "compas.datastructures/Mesh", "data": mesh(0.0)}
        inner = {"transformation": moved(z - 0.5), "geometry": geometry, "is_support": not z}
        return {"dtype": "compas_dem.elements/Block", "data": inner, "guid": "g"}

    elements = {f"guid{key}": element(z) for key, z in AT.items()}
    elements["group"] = {"dtype": "compas_model.elements/Group", "data": {"transformation": moved(0.3)}}
    nodes = {**{key: {"element": f"guid{key}"} for key in AT}, "9": {"element": "group"}}
    leaves = [{"element": f"guid{key}", "name": "ElementNode"} for key in AT]
    tree = {"root": {"name": "root", "children": [{"element": "group", "children": leaves}]}}
    graph = {"node": nodes, "edge": {"0": {"1": {"contacts": []}}, "1": {"7": {}}}}
    inner = {"transformation": moved(0.2), "elements": elements, "tree": tree, "graph": graph}
    return {"dtype": "compas_dem.models/BlockModel", "data": inner}


KINDS = {"compas 1": of_compas_1, "compas 2": of_compas_2, "compas_dem": of_compas_dem}


load = loading("arch.json", json.dumps, density=2000, friction=0.6)


@pytest.mark.parametrize("kind", KINDS)
def test_blocks_are_bodies_and_supports_are_fixed(kind: str, load: Load) -> None:
    scene = load(KINDS[kind]())
    assert {body.name: body.fixed for body in scene.bodies} == {"0": True, "1": False, "7": False}
    for name, z in AT.items():
        low, high = scene.body(name).box
        np.testing.assert_allclose((low, high), ([-0.5, -0.5, z - 0.5], [0.5, 0.5, z + 0.5]), atol=1e-12)
    for body in scene.movable:
        assert body.mass == pytest.approx(2000, rel=1e-12)
        np.testing.assert_allclose(body.inertia_com, np.eye(3) * 2000 / 6, rtol=1e-12, atol=1e-9)
    assert scene.mu("0", "7") == 0.6
    assert "interfaces in the file are ignored, 2 of them: contacts are found anew" in scene.notes
    assert "fixed, as supports: 0" in scene.notes


def test_a_list_of_meshes_is_a_block_each(load: Load) -> None:
    meshes = [{"dtype": "compas.datastructures/Mesh", "data": mesh(z), "guid": "g"} for z in AT.values()]
    scene = load(meshes, fixed=["0"])
    assert {body.name: body.fixed for body in scene.bodies} == {"0": True, "1": False, "2": False}
    for body, z in zip(scene.bodies, AT.values(), strict=True):
        np.testing.assert_allclose(body.box, ([-0.5, -0.5, z - 0.5], [0.5, 0.5, z + 0.5]), atol=1e-12)
    with pytest.raises(hf.errors.SceneError, match="in no known format"):
        load([*meshes, {"dtype": "compas.geometry/Point", "data": [0, 0, 0]}])


def test_masses_by_name_and_more_that_is_fixed(load: Load) -> None:
    scene = load(of_compas_2(), mass={"1": 5.0}, fixed=["7"])
    assert {body.name: body.mass for body in scene.movable} == {"1": 5.0}


def test_friction_masses_and_supports_are_never_guessed(load: Load) -> None:
    with pytest.raises(hf.errors.SceneError, match=r"arch.json: says nothing of friction; give friction="):
        load(of_compas_2(), friction=None)
    with pytest.raises(hf.errors.SceneError, match=r"node '1': has no mass; give mass= or density="):
        load(of_compas_2(), density=None)
    loose = of_compas_1()
    del loose["value"]["graph"]["node"]["0"]["is_support"]
    with pytest.raises(
        hf.errors.SceneError, match=r"nothing in it is fixed; give fixed=\[name\] \(0, 1, 7\), or floor=True"
    ):
        load(loose)
    assert load(loose, floor=True).body("floor").fixed


def changed(path: str, value: object) -> dict[str, Any]:
    """The assembly of COMPAS 2 with another value, or none, at a path of keys."""
    data = of_compas_2()
    *keys, last = path.split()
    inner: Any = data
    for key in keys:
        inner = inner[key]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    return data


BLOCK = "data graph data node 1 block"


@pytest.mark.parametrize(
    ("path", "value", "match"),
    [
        ("data", None, r"arch.json: is no assembly of COMPAS: KeyError"),
        ("data", [], "is no assembly of COMPAS: TypeError"),
        ("data graph", None, "is no assembly of COMPAS: KeyError"),
        ("data graph data node", 7, "is no assembly of COMPAS: AttributeError"),
        ("data graph data node", {}, "holds no triangles"),
        (BLOCK, None, "is no assembly of COMPAS: KeyError"),
        (f"{BLOCK} data face 0", [0, 1, 99], "is no assembly of COMPAS: KeyError: '99'"),
        (f"{BLOCK} data face", {}, "block '1': has no faces"),
        (f"{BLOCK} data vertex 0 x", "nan", "block '1': vertices: "),
        (f"{BLOCK} data vertex 0 x", 1e300, "vertices: contains"),
    ],
)
def test_what_is_wrong_is_one_clear_error(path: str, value: object, match: str, load: Load) -> None:
    with pytest.raises(hf.HoldfastError, match=match) as caught:
        load(changed(path, value))
    assert "arch.json" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_open_block_and_other_geometry_are_refused(load: Load) -> None:
    with pytest.raises(hf.errors.GeometryError, match="not watertight"):
        load(changed(f"{BLOCK} data face 0", None))
    solid = of_compas_dem()
    solid["data"]["elements"]["guid1"]["data"]["geometry"] = {"dtype": "compas_occ.brep/OCCBrep", "data": {}}
    with pytest.raises(hf.errors.SceneError, match=r"geometry of element 1 is a .compas_occ.brep/OCCBrep., not a mesh"):
        load(solid)


def test_json_of_others_is_left_to_others(load: Load, tmp_path: Path) -> None:
    with pytest.raises(
        hf.errors.SceneError, match=r"is in no known format .*COMPAS assembly \(\.json: `dtype: compas_"
    ):
        load({"dtype": "compas.geometry/Box", "data": {}})
