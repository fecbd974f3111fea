"""Scenes, bodies, shapes, friction and assemblies pickle, copy, compare, hash and show themselves in short."""

from __future__ import annotations

import copy
import dataclasses
import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.base.archive import load, save
from holdfast.scene.shipped.blocks import at, box, floor

BALL = trimesh.creation.icosphere(subdivisions=2, radius=0.1)


def overlapping() -> hf.answers.Assembly:
    with pytest.warns(hf.errors.HoldfastWarning, match="overlap"):
        return hf.assemble(hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.045))], 0.5))


def stack() -> hf.answers.Assembly:
    return hf.assemble(hf.shipped_scene("stack"))


# each is called twice: equal values are made of other objects
VALUES: dict[str, Any] = {
    "box": lambda: hf.Box((0.1, 0.2, 0.3)),
    "cylinder": lambda: hf.Cylinder(0.1, 0.2, segments=32),
    "sphere": lambda: hf.Sphere(0.1),
    "mesh": lambda: hf.Mesh(BALL.vertices, BALL.faces),
    "noisy mesh": lambda: hf.Mesh(BALL.vertices, BALL.faces, noise=1e-4),
    "friction": lambda: hf.Friction(0.5, {("slab", "leg"): 0.4}, {"slab": 0.1, "leg": 0.2}, "min"),
    "body": lambda: hf.Body("b", hf.Box((1, 1, 1)), mass=2, com=(0, 0, 0.1), inertia=np.eye(3), material="oak"),
    "body by density": lambda: hf.Body("b", hf.Mesh(BALL.vertices, BALL.faces), density=700),
    "fixed body": lambda: hf.Body("b", hf.Box((1, 1, 1)), fixed=True),
    "scene": lambda: hf.shipped_scene("table"),
    "scene with an excluded pair": lambda: dataclasses.replace(
        hf.shipped_scene("table"), excluded=[("slab", "leg_left")], notes=["what was read"]
    ),
    "scene of files": lambda: hf.shipped_scene("tabletop"),
    "interface": lambda: stack().interfaces[0],
    "patch": lambda: stack().interfaces[0].patches[0],
    "surface": lambda: hf.Sphere(0.1, subdivisions=1).surface,
    "facets": lambda: hf.Cylinder(0.1, 0.2).surface.facets,
    "topology": lambda: hf.Box((1, 1, 1)).surface.topology,
    "mass properties": lambda: hf.Sphere(0.1).mass_properties,
    "report of a mesh": lambda: hf.Mesh(BALL.vertices, BALL.faces, noise=1e-4).report,
    "assembly": stack,
    "assembly, uncertain poses": lambda: hf.assemble(hf.shipped_scene("stack"), pose_sigma=(1e-4, 0.1)),
    "assembly, interfaces given": lambda: hf.assemble(hf.shipped_scene("stack"), interfaces=stack().interfaces[:2]),
    "assembly with overlaps": overlapping,
}  # fmt: skip


SHARED = ("surface", "facets", "topology")  # by all shapes that are alike


@pytest.mark.parametrize("name", VALUES)
def test_a_value_equals_another_made_alike_and_its_copies(name: str) -> None:
    value, alike = VALUES[name](), VALUES[name]()
    for other in (alike, pickle.loads(pickle.dumps(value)), copy.deepcopy(value), dataclasses.replace(value)):
        assert other is not value or name in SHARED
        assert other == value
        assert hash(other) == hash(value)
    dataclasses.asdict(value)


@pytest.mark.parametrize("name", VALUES)
def test_a_value_is_saved_without_loss(name: str, tmp_path: Path) -> None:
    value = VALUES[name]()
    for suffix in (".json", ".npz"):
        save(value, tmp_path / f"value{suffix}")
        assert load(tmp_path / f"value{suffix}") == value


@pytest.mark.parametrize("name", VALUES)
def test_a_value_shows_itself_in_short(name: str) -> None:
    text = repr(VALUES[name]())
    assert len(text) < 1000
    assert " at 0x" not in text


def test_values_that_differ_are_not_equal() -> None:
    values = [VALUES[name]() for name in VALUES]
    assert len(set(values)) == len(values)


@pytest.mark.parametrize(
    "change",
    [
        {"name": "c"},
        {"shape": hf.Box((1, 1, 1.1))},
        {"mass": 2.1},
        {"pose": at(0, 0, 1)},
        {"com": None},
        {"inertia": None},
        {"material": None},
        {"fixed": True},
    ],
)
def test_every_field_of_a_body_matters(change: dict[str, Any]) -> None:
    body = VALUES["body"]()
    other = dataclasses.replace(body, **change)
    assert other != body
    assert dataclasses.replace(other, **{name: getattr(body, name) for name in change}) == body


def test_a_mesh_is_its_triangles_wherever_they_were_read_from(tmp_path: Path) -> None:
    """Not its file, the scale that was applied, or what errors call it; but its noise, which contacts see."""
    path = tmp_path / "ball.ply"
    BALL.export(path)
    read = hf.Mesh.from_file(path)
    assert read == hf.Mesh(read.vertices, read.faces, label="another")
    assert hash(read) == hash(hf.Mesh(read.vertices, read.faces))
    assert read != hf.Mesh(read.vertices, read.faces, noise=1e-3)
    assert read != hf.Mesh(read.vertices * 2, read.faces)
    assert pickle.loads(pickle.dumps(read)).file == path


def test_pairs_of_friction_compare_in_either_order() -> None:
    one, other = (
        hf.Friction(pairs={("a", "b"): 0.5, ("c", "d"): 1}),
        hf.Friction(pairs={("d", "c"): 1, ("b", "a"): 0.5}),
    )
    assert one == other
    assert len({one, other}) == 1


def test_comparing_makes_no_meshes() -> None:
    """Of two scenes that were just made, nothing is computed but what they were given."""
    one, other = (hf.Body("b", hf.Sphere(0.1), mass=1.0, com=(0, 0, 0)) for _ in range(2))
    assert one == other
    assert hash(one) == hash(other)
    for body in (one, other):
        assert "surface" not in vars(body.shape)
        assert "surface_world" not in vars(body)


def test_answers_of_a_copy_are_the_same_to_the_last_bit() -> None:
    assembly = stack()
    other = pickle.loads(pickle.dumps(assembly))
    given = [(0.05, 0, 0.25)], [(-1, 0, 0)]
    one, same = (hf.robustness(a, "cube3", *given, engine="graph").force for a in (assembly, other))
    assert one.tobytes() == same.tobytes()


def test_scenes_and_assemblies_go_to_other_processes_and_come_back() -> None:
    values = [VALUES[name]() for name in ("scene of files", "assembly", "assembly, interfaces given", "friction")]
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        assert list(pool.map(_sent, values)) == values


def _sent(value: Any) -> Any:
    return value
