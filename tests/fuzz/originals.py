"""One small valid file of every kind that the library reads, written by it and by trimesh, to be mutated."""

from __future__ import annotations

import base64
import json
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import holdfast as hf
from fuzz import foreign
from holdfast.scene.shipped import shipped_scene
from holdfast.scene.shipped.blocks import box, floor

Original = dict[str, Any]


@cache
def originals() -> tuple[Original, ...]:
    """All of them: ``reader``, ``suffix``, ``content`` and the files ``beside``."""
    with tempfile.TemporaryDirectory() as folder:
        return (*_meshes(), *_scenes(Path(folder)), *_answers(Path(folder)))


def _file(reader: str, suffix: str, content: bytes, beside: dict[str, bytes] | None = None) -> Original:
    return {"reader": reader, "suffix": suffix, "content": content, "beside": beside or {}}


def _meshes() -> list[Original]:
    solid = trimesh.creation.box((0.1, 0.2, 0.3))
    found = []
    for suffix, options in (
        (".obj", {}),
        (".stl", {}),
        (".ply", {}),
        (".ply", {"encoding": "ascii"}),
        (".glb", {}),
        (".off", {}),
    ):
        exported = solid.export(file_type=suffix[1:], **options)
        found.append(_file("mesh", suffix, exported if isinstance(exported, bytes) else exported.encode()))
    found.append(_file("mesh", ".stl", trimesh.exchange.stl.export_stl_ascii(solid).encode()))
    two = trimesh.Scene([solid, trimesh.creation.icosphere(1, 0.05).apply_translation([1, 0, 0])])
    found.append(_file("mesh", ".glb", two.export(file_type="glb")))
    materials = b"mtllib some.mtl\nusemtl a\no thing\nvn 0 0 1\nvt 0 0\ns off\n"
    found.append(
        _file("mesh", ".obj", materials + solid.export(file_type="obj").encode(), {"some.mtl": b"newmtl a\nKd 1 0 0\n"})
    )
    found.append(_file("mesh", ".dae", foreign.DAE.encode()))
    return found


def _scenes(folder: Path) -> list[Original]:
    solid = trimesh.creation.box((0.1, 0.2, 0.3))
    stl = solid.export(file_type="stl")
    (folder / "m.stl").write_bytes(stl)
    bodies = [
        floor(),
        box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05)),
        hf.Body("tube", hf.Cylinder(0.02, 0.1, 8), density=500.0, pose=np.eye(4), material="steel"),
        hf.Body("ball", hf.Sphere(0.02, 1), mass=2, com=(0, 0, 0.001), inertia=np.eye(3)),
        hf.Body("mesh", hf.Mesh(solid.vertices, solid.faces, noise=1e-4), mass=1),
        hf.Body("file", hf.Mesh.from_file(folder / "m.stl"), mass=1),
    ]
    box_ = hf.Box((0.1, 0.1, 0.1))
    bodies += [
        hf.Body("level", hf.HalfSpace(), fixed=True),
        hf.Body("pill", hf.Capsule(0.02, 0.1, 12), mass=1),
        hf.Body("egg", hf.Ellipsoid((0.01, 0.02, 0.03), 1), mass=1),
        hf.Body("pair", hf.Compound([hf.Part(box_), hf.Part(box_, np.eye(4) + 0.1 * np.eye(4, k=3), "steel")]), mass=1),
    ]
    friction = hf.Friction(0.5, {("cube", "floor"): 0.3, ("steel", "cube"): 0.1})
    found = []
    for suffix in (".yaml", ".json", ".glb", ".gltf"):
        hf.save_scene(hf.Scene(bodies, friction, name="all"), folder / f"s{suffix}")
        found.append(_file("scene", suffix, (folder / f"s{suffix}").read_bytes(), {"m.stl": stl}))
    found.append(_file("scene", ".json", json.dumps(_settled()).encode(), {"m.stl": stl}))
    found.append(_file("scene", ".json", json.dumps(_blocks(solid)).encode()))
    for suffix, content, options in foreign.scenes(folder):
        found.append(_file("scene", suffix, content, {"m.stl": stl, **foreign.BESIDE}) | {"options": options})
    return found


def _settled() -> Original:
    thing = {"mesh": "m.stl", "scale": [1, 1, 1], "pose": np.eye(4).tolist(), "friction": 0.5}
    objects = [thing | {"name": "a", "mass": 1.5, "fixed": False}, thing | {"name": "b", "mass": 0.0, "fixed": True}]
    return {"format": "settled-scene/1", "name": "x", "units": {"gravity": [0, 0, -9.81]}, "objects": objects}


def _blocks(solid: trimesh.Trimesh) -> Original:
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    one = {"vertices": solid.vertices.tolist(), "faces": quads, "mass": 1.0, "fixed": False}
    whole = [one | {"name": "a"}, one | {"name": "b", "fixed": True}]
    return {"blocks": whole, "interfaces": [], "friction": 0.6, "gravity": [0, 0, -9.81]}


def _answers(folder: Path) -> list[Original]:
    assembly = hf.assemble(shipped_scene("cube"))
    thing = hf.Body("thing", hf.Box((0.05, 0.05, 0.05)), mass=0.2)
    answers = [
        hf.stability(assembly, engine="limit"),
        hf.robustness(assembly, "cube", [(-0.05, 0, 0.05), (0, 0, 0.1)], [(1, 0, 0), (0, 0, -1)], engine="limit"),
        hf.robustness_map(assembly, spacing=0.05, engine="limit"),
        hf.sets.sustainable_accelerations(assembly, accuracy=0.3),
        hf.transport_limits(assembly, [(1, 0, 0)], engine="limit"),
        hf.disassembly_order(assembly, engine="limit"),
        hf.load_factor(assembly, [hf.Load("cube", (0, 0, 0.1), force=(1, 0, 0))], engine="limit"),
        hf.sets.sensitivity(assembly, "cube", (-0.05, 0, 0.05), (1, 0, 0)),
        hf.sets.worst_case(assembly, "cube", (-0.05, 0, 0.05), (1, 0, 0), mu_range=0.1, mass_range=0.1),
        hf.robustness_under(
            assembly,
            "cube",
            (-0.05, 0, 0.05),
            (1, 0, 0),
            uncertain=hf.sets.Uncertain(mu_range=0.1, samples=2),
            engine="limit",
        ),
        hf.plan_placement(assembly, thing, search=hf.Search(confirm=None, spacing=0.05), engine="limit"),
    ]
    found = []
    for answer in answers:
        for suffix in (".json", ".npz"):
            answer.save(folder / f"a{suffix}")
            found.append(_file("answer", suffix, (folder / f"a{suffix}").read_bytes()))
    return found


def packed(item: Original) -> Original:
    """The same with its bytes as text, for JSON."""
    text = {name: base64.b64encode(content).decode() for name, content in item["beside"].items()}
    return item | {"content": base64.b64encode(item["content"]).decode(), "beside": text}
