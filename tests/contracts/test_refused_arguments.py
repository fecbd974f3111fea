"""What is of the right kind and yet makes no sense, or says yes in words, is refused and not taken in silence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import holdfast as hf

CUBE = hf.shipped_scene("cube")
ON, ALONG = (-0.05, 0, 0.05), (1.0, 0, 0)
NEW = hf.Body("new", hf.Box((0.05, 0.05, 0.05)), mass=0.1)
SOLID = trimesh.creation.box((0.1, 0.1, 0.1))
LOAD = hf.Load("cube", ON, ALONG)
AROUND = [("cube", (-0.05, 0, 0.1)), ("cube", (0.05, 0, 0.1)), ("cube", (0, 0.05, 0.1))]


def saved(name: str, folder: Path) -> Path:
    """A file of a format with options."""
    path = folder / name
    path.write_text(FILES[name])
    return path


FILES = {
    "a.urdf": """<robot name="r"><link name="l">
        <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><geometry><box size=".1 .1 .1"/></geometry></collision></link></robot>""",
    "a.sdf": """<sdf version="1.9"><model name="m"><link name="l">
        <collision name="c"><geometry><box><size>.1 .1 .1</size></box></geometry></collision></link></model></sdf>""",
    "a.xml": """<mujoco><worldbody><geom type="plane" size="1 1 1"/>
        <body><freejoint/><geom size=".1"/></body></worldbody></mujoco>""",
}
TRUTHS: dict[str, Callable[[Any], object]] = {
    "Body: fixed": lambda v: hf.Body("b", hf.Sphere(1), mass=1, fixed=v),
    "Graph: isolated": lambda v: hf.Graph(isolated=v),
    "Strap: closed": lambda v: hf.Strap(AROUND, 1.0, closed=v),
    "assemble: allow_large": lambda v: hf.assemble(CUBE, allow_large=v),
    "robustness: bounds": lambda v: hf.robustness(CUBE, "cube", ON, ALONG, bounds=v),
    "load_factor: bounds": lambda v: hf.load_factor(CUBE, [LOAD], bounds=v),
    "transport: bounds": lambda v: hf.transport_limits(CUBE, ALONG, bounds=v),
    "carry: bounds": lambda v: hf.carry(CUBE, [[0, 1, 0, 0]], bounds=v),
    "placement: free_yaw": lambda v: hf.plan_placement(
        CUBE, NEW, approach=hf.sets.Approach(free_yaw=v), search=hf.Search(solves=1), engine="graph"
    ),
    "place_all: stack": lambda v: hf.place_all(
        CUBE, [NEW], where=hf.Where(stack=v), search=hf.Search(seconds=0.1), engine="graph"
    ),
    "from_trimesh: floor": lambda v: hf.from_trimesh(SOLID, friction=0.5, mass=1, fixed=["mesh"], floor=v),
}
READ = {
    "URDF: rigid": ("a.urdf", "rigid", {"floor": True, "friction": 0.5}),
    "URDF: floor": ("a.urdf", "floor", {"fixed": True, "friction": 0.5}),
    "SDF: rigid": ("a.sdf", "rigid", {"floor": True}),
    "SDF: floor": ("a.sdf", "floor", {"fixed": ["m"]}),
    "MJCF: rigid": ("a.xml", "rigid", {}),
}


@pytest.mark.parametrize("value", ["yes", "False", 1, 0, None, [], np.ones(2)], ids=repr)
@pytest.mark.parametrize("name", TRUTHS)
def test_a_truth_is_true_or_false(name: str, value: Any) -> None:
    with pytest.raises(hf.errors.SceneError, match=f"{name.split(': ')[1]}: is .*; needs True or False"):
        TRUTHS[name](value)


@pytest.mark.parametrize("name", TRUTHS)
def test_a_truth_of_numpy_is_one(name: str) -> None:
    TRUTHS[name](np.bool_(True))
    TRUTHS[name](np.bool_(False))


@pytest.mark.parametrize("name", READ)
def test_options_of_readers_are_true_or_false(name: str, tmp_path: Path) -> None:
    file, option, others = READ[name]
    path = saved(file, tmp_path)
    with pytest.raises(hf.errors.SceneError, match=f"{option}: is 'no'; needs True or False"):
        hf.load_scene(path, **others, **{option: "no"})
    assert hf.load_scene(path, **others, **{option: np.bool_(True)}).bodies


SENSELESS: dict[str, tuple[Callable[[], object], str]] = {
    "gap": (lambda: hf.assemble(CUBE, gap=-1), "assemble: gap: is -1; needs"),
    "angle": (lambda: hf.assemble(CUBE, angle_degrees=90), "assemble: angle_degrees = 90; needs less than 90"),
    "pose_sigma": (lambda: hf.assemble(CUBE, pose_sigma=0), "assemble: pose_sigma: is 0; needs"),
    "two tolerances": (
        lambda: hf.assemble(CUBE, gap=1e-3, pose_sigma=1e-3),
        r"gap = 0\.001 and pose_sigma = 0\.001; give one",
    ),
    "interfaces": (
        lambda: hf.assemble(CUBE, interfaces=[3]),  # type: ignore[list-item]
        r"interfaces holds a int; needs holdfast\.answers\.Interface",
    ),
    "accuracy of a constraint": (
        lambda: hf.sets.constraint(CUBE, "cube", accuracy=2),
        "accuracy: is 2; needs a finite number > 0 and < 1",
    ),
    "accuracy of a set": (
        lambda: hf.sets.sustainable_accelerations(CUBE, accuracy=1),
        "accuracy: is 1; needs a finite number > 0 and < 1",
    ),
    "turn_degrees": (
        lambda: hf.settle(CUBE, turn_degrees=400),
        r"settle: turn_degrees: is 400; needs a number from 0 to 180 degrees",
    ),
    "lean_degrees": (
        lambda: hf.plan_placement(CUBE, NEW, approach=hf.sets.Approach(lean_degrees=400)),
        "lean_degrees: is 400; needs a number of at most 180 degrees",
    ),
    "cone_degrees": (
        lambda: hf.plan_placement(CUBE, NEW, approach=hf.sets.Approach(cone_degrees=400)),
        "cone_degrees: is 400; needs a number of at most 180 degrees",
    ),
    "seconds": (
        lambda: hf.plan_placement(CUBE, NEW, search=hf.Search(seconds=0)),
        "seconds: is 0; needs a finite number > 0",
    ),
    "seconds of all": (
        lambda: hf.place_all(CUBE, [NEW], search=hf.Search(seconds=0)),
        "seconds: is 0; needs a finite number > 0",
    ),
    "everywhere": (
        lambda: hf.plan_placement(CUBE, NEW, where=hf.Where(keep_out=[None])),
        r"keep_out: holds None.*; give regions",
    ),
    "friction of nobody": (lambda: CUBE.mu("cub", "floor"), "no body named 'cub'; did you mean 'cube'"),
    "a note": (lambda: hf.Scene(CUBE.bodies, 0.5, notes=[1]), "notes: holds 1; needs a list of texts"),  # type: ignore[list-item]
    "a load": (lambda: hf.Load(None, ON, ALONG), "load: body: is None; needs a non-empty text"),  # type: ignore[arg-type]
    "scale": (lambda: hf.Mesh(SOLID.vertices, SOLID.faces, scale=(1, 0, 1)), r"Mesh: scale: is \[1.0, 0.0, 1.0\]"),
    "no stiffness": (
        lambda: hf.robustness_under(
            CUBE, "cube", ON, ALONG, uncertain=hf.sets.Uncertain(samples=2, stiffness_range=())
        ),  # type: ignore[arg-type]
        r"stiffness_range: is \(\); needs a range",
    ),
    "mass of no number": (
        lambda: hf.from_trimesh(SOLID, friction=0.5, floor=True, mass=1, density="much"),  # type: ignore[arg-type]
        "density: got 'much'; needs a finite number > 0",
    ),
    "names of curves": (
        lambda: hf.transport_limits(CUBE, engine="limit").save_png("never.png", names=["a", "b"]),
        "polar plot: names: 2 names of 1 answers; give one for each",
    ),
    "a step": (lambda: hf.disassembly_order(CUBE, engine="limit").answers(True), "step: is True; needs a whole number"),
}


@pytest.mark.parametrize("name", SENSELESS)
def test_what_makes_no_sense_is_refused(name: str) -> None:
    ask, match = SENSELESS[name]
    with pytest.raises(hf.HoldfastError, match=match):
        ask()


def test_bounds_of_what_makes_sense_are_taken() -> None:
    assert hf.settle(CUBE, turn_degrees=180).status is hf.Status.STABLE
    assert hf.sets.constraint(CUBE, "cube", accuracy=0.99, solves=0).accuracy_wanted == 0.99
    assert hf.disassembly_order(CUBE, engine="limit").answers(1) == ()
    m = hf.robustness_map(CUBE, spacing=0.05, engine="graph")
    assert m.at(-1) == m.at(len(m.force) - 1)
    with pytest.raises(hf.HoldfastError, match=r"index: is \d+; needs a whole number of at most"):
        m.at(len(m.force))
