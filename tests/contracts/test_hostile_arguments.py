"""Arguments of every kind where another one belongs: a HoldfastError on one line, or an answer, never anything else."""

from __future__ import annotations

import contextlib
import dataclasses
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import trimesh

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor

SCENE = hf.Scene([floor(), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5)
BODY = SCENE.body("cube")
NEW = hf.Body("new", hf.Box((0.05, 0.05, 0.05)), mass=0.1)
ON, DOWN = (0.05, 0, 0.05), (-1.0, 0, 0)
POSES = np.array([hf.pose(0, 0, 0.05)])
SOLID = trimesh.creation.box((0.1, 0.1, 0.1))
ITSELF: list[Any] = []
ITSELF.append(ITSELF)

ODD: tuple[Any, ...] = (
    *(None, "x", "3", b"x", True, 1j, np.nan, np.inf, 1e300, -1e300, 5e-324, 10**400, 2**70, -1, 0),
    *([], [[]], {}, {1: 2}, (1, 2), [1, 2, 3], ["1", "2", "3"], [np.nan] * 3, [1e300] * 3, [5e-324] * 3, ("a", "b")),
    *([None], {"cube": np.nan}, (np.nan, np.nan), (2, 1), np.zeros((2, 2)), np.array(3.0), str),
    *(ITSELF, object(), range(3), np.zeros((0, 3)), np.zeros((2, 3, 3)), np.array("x"), np.ma.masked, len),
)


@pytest.fixture(scope="module")
def assembly() -> hf.answers.Assembly:
    return hf.assemble(SCENE)


def made(**changes: Any) -> hf.Body:
    return hf.Body(**{"name": "b", "shape": NEW.shape, "mass": 1} | changes)


def pushed(assembly: hf.answers.Assembly, **changes: Any) -> hf.answers.Robustness:
    return hf.robustness(assembly, **{"body": "cube", "points": ON, "directions": DOWN, "engine": "limit"} | changes)


def under(assembly: hf.answers.Assembly, **changes: Any) -> hf.answers.RobustnessUnder:
    names = {field.name for field in dataclasses.fields(hf.sets.Uncertain)}
    given: dict[str, Any] = {"mu_range": 0.1, "samples": 2, "engine": "limit"} | changes
    uncertain = hf.sets.Uncertain(**{name: value for name, value in given.items() if name in names})
    others = {name: value for name, value in given.items() if name not in names}
    return hf.robustness_under(assembly, "cube", ON, DOWN, uncertain, **others)


def measured(assembly: hf.answers.Assembly, pushes: Any, **changes: Any) -> hf.answers.MeasuredFriction:
    return hf.friction_from(assembly, pushes, **{"scatter": 0.1, "engine": "limit"} | changes)


def placed(assembly: hf.answers.Assembly, **changes: Any) -> hf.answers.Placement:
    fields = {kind: {f.name for f in dataclasses.fields(kind)} for kind in (hf.Where, hf.sets.Approach, hf.Search)}
    given: dict[str, Any] = {"solves": 1, "confirm": None} | changes
    values = [kind(**{name: given[name] for name in names & given.keys()}) for kind, names in fields.items()]
    return hf.plan_placement(assembly, NEW, *values, engine="graph")


def small(value: Any) -> Any:
    """The value, unless it is a number of solves or pushes that would take hours."""
    return 30 if type(value) is int and value > 30 else value


@cache
def constrained() -> hf.answers.Constraint:
    return hf.sets.constraint(SCENE, "cube", solves=20)


@cache
def mapped() -> hf.answers.RobustnessMap:
    return hf.robustness_map(SCENE, engine="graph", spacing=0.1)


@cache
def limits() -> hf.answers.TransportLimits:
    return hf.transport_limits(SCENE, (1, 0, 0), engine="limit")


@cache
def watching() -> hf.Monitor:
    return hf.Monitor(SCENE, solves=1)


MAKING: dict[str, Callable[[Any], object]] = {
    "Box": hf.Box,
    "Cylinder": lambda v: hf.Cylinder(v, 1),
    "Cylinder: segments": lambda v: hf.Cylinder(1, 1, v),
    "Sphere": hf.Sphere,
    "Sphere: subdivisions": lambda v: hf.Sphere(1, v),
    "Capsule": lambda v: hf.Capsule(v, 1),
    "Capsule: length": lambda v: hf.Capsule(1, v),
    "Capsule: segments": lambda v: hf.Capsule(1, 1, v),
    "Ellipsoid": hf.Ellipsoid,
    "HalfSpace": hf.HalfSpace,
    "Compound": hf.Compound,
    "Part: shape": hf.Part,
    "Part: pose": lambda v: hf.Part(NEW.shape, v),
    "Part: material": lambda v: hf.Part(NEW.shape, material=v),
    "Mesh: vertices": lambda v: hf.Mesh(v, [[0, 1, 2]]),
    "Mesh: faces": lambda v: hf.Mesh(np.eye(3), v),
    "Mesh: scale": lambda v: hf.Mesh(np.eye(3), [[0, 1, 2]], scale=v),
    "Mesh: file": lambda v: hf.Mesh(np.eye(3), [[0, 1, 2]], file=v),
    "Mesh: noise": lambda v: hf.Mesh(np.eye(3), [[0, 1, 2]], noise=v),
    "Mesh.from_file": hf.Mesh.from_file,
    "Body: name": lambda v: made(name=v),
    "Body: shape": lambda v: made(shape=v),
    "Body: mass": lambda v: made(mass=v),
    "Body: density": lambda v: made(mass=None, density=v),
    "Body: pose": lambda v: made(pose=v),
    "Body: com": lambda v: made(com=v),
    "Body: inertia": lambda v: made(inertia=v),
    "Body: material": lambda v: made(material=v),
    "Body: fixed": lambda v: made(fixed=v),
    "Body.moved": BODY.moved,
    "Scene: bodies": lambda v: hf.Scene(v, 0.5),
    "Scene: friction": lambda v: hf.Scene(SCENE.bodies, v),
    "Scene: gravity": lambda v: hf.Scene(SCENE.bodies, 0.5, v),
    "Scene: name": lambda v: hf.Scene(SCENE.bodies, 0.5, name=v),
    "Scene: notes": lambda v: hf.Scene(SCENE.bodies, 0.5, notes=v),
    "Scene.mu": lambda v: SCENE.mu(v, "cube"),
    "Scene.body": SCENE.body,
    "Scene.without": SCENE.without,
    "Scene.moved": SCENE.moved,
    "Scene.with_body": SCENE.with_body,
    "Friction": hf.Friction,
    "Friction: pairs": lambda v: hf.Friction(0.5, v),
    "Friction: pair": lambda v: hf.Friction(0.5, {("a", "b"): v}),
    "Friction: values": lambda v: hf.Friction(0.5, {}, v, "max"),
    "Friction: combine": lambda v: hf.Friction(0.5, {}, {}, v),
    "Interface: bodies": lambda v: hf.answers.Interface(v, [[0, 0, 0], [1, 0, 0], [0, 1, 0]], (0, 0, 1)),
    "Interface: polygon": lambda v: hf.answers.Interface(("a", "b"), v, (0, 0, 1)),
    "Interface: normal": lambda v: hf.answers.Interface(("a", "b"), [[0, 0, 0], [1, 0, 0], [0, 1, 0]], v),
    "Load: body": lambda v: hf.Load(v, ON, (1, 0, 0)),
    "Load: point": lambda v: hf.Load("cube", v, (1, 0, 0)),
    "Load: force": lambda v: hf.Load("cube", ON, v),
    "Load: moment": lambda v: hf.Load("cube", moment=v),
    "Compliant: nodes": lambda v: hf.Compliant(nodes=v),
    "Compliant: stiffness_ratio": lambda v: hf.Compliant(stiffness_ratio=v),
    "Compliant: stiffness": lambda v: hf.Compliant(stiffness=v),
    "Graph: isolated": lambda v: hf.Graph(isolated=v),
    "Graph: sampling": lambda v: hf.Graph(sampling=v),
    "Graph: nodes": lambda v: hf.Graph(nodes=v),
    "Graph: mass_margin": lambda v: hf.Graph(mass_margin=v),
    "Graph: immobile_above": lambda v: hf.Graph(immobile_above=v),
    "Graph: max_cuts": lambda v: hf.Graph(max_cuts=v),
    "Limit: cone": hf.Limit,
    "Limit: sides": lambda v: hf.Limit("inscribed", v),
    "from_trimesh: mass": lambda v: hf.from_trimesh(SOLID, friction=0.5, floor=True, mass=v),
    "from_trimesh: density": lambda v: hf.from_trimesh(SOLID, friction=0.5, floor=True, density=v),
    "from_trimesh: fixed": lambda v: hf.from_trimesh(SOLID, friction=0.5, mass=1, fixed=v),
    "from_trimesh: material": lambda v: hf.from_trimesh(SOLID, friction=0.5, floor=True, mass=1, materials=v),
    "from_trimesh: up": lambda v: hf.from_trimesh(SOLID, friction=0.5, floor=True, mass=1, up_axis=v),
    "from_trimesh: floor": lambda v: hf.from_trimesh(SOLID, friction=0.5, mass=1, floor=v),
    "load_scene": hf.load_scene,
    "load_answer": hf.load_answer,
    "shipped_scene": hf.shipped_scene,
    "save_scene": lambda v: hf.save_scene(v, "never.yaml"),
}
ASKING: dict[str, Callable[[hf.answers.Assembly, Any], object]] = {
    "assemble": lambda _, v: hf.assemble(v),
    "assemble: gap": lambda _, v: hf.assemble(SCENE, gap=v),
    "assemble: angle": lambda _, v: hf.assemble(SCENE, angle_degrees=v),
    "assemble: pose_sigma": lambda _, v: hf.assemble(SCENE, pose_sigma=v),
    "assemble: allow_large": lambda _, v: hf.assemble(SCENE, allow_large=v),
    "assemble: interfaces": lambda _, v: hf.assemble(SCENE, interfaces=v),
    "with_body": lambda a, v: a.with_body(v),
    "without": lambda a, v: a.without(v),
    "moved": lambda a, v: a.moved(v),
    "with_friction": lambda a, v: a.with_friction(v),
    "stability": lambda _, v: hf.stability(v, engine="limit"),
    "stability: loads": lambda a, v: hf.stability(a, loads=v, engine="limit"),
    "stability: engine": lambda a, v: hf.stability(a, engine=v),
    "stability_of_poses": lambda _, v: hf.stability_of_poses(v, "cube", POSES),
    "stability_of_poses: bodies": lambda a, v: hf.stability_of_poses(a, v, POSES),
    "stability_of_poses: poses": lambda a, v: hf.stability_of_poses(a, "cube", v),
    "stability_of_poses: poses by name": lambda a, v: hf.stability_of_poses(a, ["cube"], {"cube": v}),
    "robustness_of_poses: points": lambda a, v: hf.robustness_of_poses(a, "cube", POSES, v, DOWN),
    "robustness_of_poses: directions": lambda a, v: hf.robustness_of_poses(a, "cube", POSES, ON, v),
    "robustness_of_poses: body": lambda a, v: hf.robustness_of_poses(a, "cube", POSES, ON, DOWN, body=v),
    "robustness: body": lambda a, v: pushed(a, body=v),
    "robustness: points": lambda a, v: pushed(a, points=v),
    "robustness: directions": lambda a, v: pushed(a, directions=v),
    "robustness: bounds": lambda a, v: pushed(a, bounds=v),
    "robustness: imperfect": lambda a, v: pushed(a, imperfect=v),
    "robustness: standing": lambda a, v: pushed(a, standing=v),
    "load_factor": lambda a, v: hf.load_factor(a, v, engine="limit"),
    "map: bodies": lambda a, v: hf.robustness_map(a, v, engine="graph", spacing=0.1),
    "map: spacing": lambda a, v: hf.robustness_map(a, engine="graph", spacing=v),
    "map: accuracy": lambda a, v: hf.robustness_map(a, engine="graph", spacing=0.1, accuracy=v),
    "transport": lambda a, v: hf.transport_limits(a, v, engine="limit"),
    "map: at": lambda _, v: mapped().at(v),
    "transport: bounds": lambda a, v: hf.transport_limits(a, (1, 0, 0), bounds=v, engine="limit"),
    "transport: others": lambda _, v: limits().save_png("never.jpg", others=v),
    "transport: names": lambda _, v: limits().save_png("never.jpg", names=v),
    "transport: tilt_degrees": lambda a, v: hf.transport_limits(a, (1, 0, 0), tilt_degrees=v, engine="limit"),
    "carry": lambda a, v: hf.carry(a, v, engine="limit"),
    "fastest_carry": lambda a, v: hf.sets.fastest_carry(a, v, engine="limit"),
    "fastest_carry: speed": lambda a, v: hf.sets.fastest_carry(a, [ON, DOWN], speed=v, engine="limit"),
    "carry: standing": lambda a, v: hf.carry(a, [[0, 1, 0, 0]], standing=v, engine="limit"),
    "Monitor: bodies": lambda a, v: hf.Monitor(a, bodies=v, solves=1),
    "Monitor: pivot": lambda a, v: hf.Monitor(a, pivot=v, solves=1),
    "Monitor: seconds": lambda a, v: hf.Monitor(a, seconds=v, solves=1),
    "Monitor: solves": lambda a, v: hf.Monitor(a, solves=small(v)),
    "Monitor: acceleration": lambda _, v: watching().update(v),
    "Monitor: angular_velocity": lambda _, v: watching().update(angular_velocity=v),
    "Monitor: gravity": lambda _, v: watching().update(gravity=v),
    "Monitor: poses": lambda _, v: watching().update(poses=v),
    "profile: acceleration": lambda _, v: hf.Profile([0.0], v),
    "profile: time": lambda _, v: hf.Profile(v, [(1, 0, 0)]),
    "profile: at": lambda _, v: hf.Profile.named("road").at(v),
    "profile: speed": lambda _, v: hf.Profile.named("road").at_speed(v),
    "profile: name": lambda _, v: hf.Profile.named(v),
    "profile: heading": lambda _, v: hf.Profile.named("road", heading=v),
    "strap": lambda _, v: hf.Strap(v, 1.0),
    "strap: point": lambda _, v: hf.Strap([("cube", v), ("floor", ON)], 1.0),
    "strap: closed": lambda _, v: hf.Strap([("cube", ON), ("floor", (1, 0, 0)), ("cube", DOWN)], 1.0, closed=v),
    "strap: pretension": lambda _, v: hf.Strap([("cube", ON), ("floor", (1, 0, 0))], v),
    "strap: spring": lambda _, v: hf.Strap([("cube", ON), ("floor", (1, 0, 0))], 1.0, spring=v),
    "strap: height": lambda a, v: hf.Strap.around(a, v, 1.0),
    "strap: bodies": lambda a, v: hf.Strap.around(a, 0.05, 1.0, v),
    "tied": lambda a, v: hf.Strap.tied(a, v, bedding=1.0),
    "load_straps": lambda _, v: hf.Strap.from_file(v),
    "tilted": lambda a, v: a.tilted(v),
    "horizontal_directions": lambda a, v: a.scene.horizontal_directions(v),
    "inertial_loads": lambda a, v: hf.sets.inertial_loads(a, angular_velocity=v),
    "disassembly: lift": lambda a, v: hf.disassembly_order(a, lift=v, engine="limit"),
    "disassembly: goal": lambda a, v: hf.disassembly_order(a, goal=v, engine="limit"),
    "disassembly: step": lambda a, v: hf.disassembly_order(a, engine="limit").answers(v),
    "disassembly: budget": lambda a, v: hf.disassembly_order(a, solves=v, engine="limit"),
    "under: mu_range": lambda a, v: under(a, mu_range=v),
    "friction_from: measured": lambda a, v: measured(a, v),
    "friction_from: push": lambda a, v: measured(a, [v]),
    "friction_from: body": lambda a, v: measured(a, [(v, ON, DOWN, 1.0)]),
    "friction_from: point": lambda a, v: measured(a, [("cube", v, DOWN, 1.0)]),
    "friction_from: direction": lambda a, v: measured(a, [("cube", ON, v, 1.0)]),
    "friction_from: force": lambda a, v: measured(a, [("cube", ON, DOWN, v)]),
    "friction_from: moved": lambda a, v: measured(a, [("cube", ON, DOWN, 1.0, v)]),
    "friction_from: scatter": lambda a, v: measured(a, [("cube", ON, DOWN, 1.0)] * 2, scatter=v),
    "friction_from: confidence": lambda a, v: measured(a, [("cube", ON, DOWN, 1.0)], confidence=v),
    "friction_from: standing": lambda a, v: measured(a, [("cube", ON, DOWN, 1.0)], standing=v),
    "under: mass_range": lambda a, v: under(a, mass_range=v),
    "transport_under: directions": lambda a, v: hf.transport_under(a, v, hf.sets.Uncertain(samples=1), engine="limit"),
    "transport_under: uncertain": lambda a, v: hf.transport_under(a, DOWN, v, engine="limit"),
    "under: pose_sigma": lambda a, v: under(a, pose_sigma=v),
    "under: standing": lambda a, v: under(a, standing=v),
    "under: stiffness_range": lambda a, v: under(a, stiffness_range=v, engine="compliant"),
    "under: flatness": lambda a, v: under(a, flatness=v, bed=1e9, engine="compliant"),
    "under: samples": lambda a, v: under(a, samples=v),
    "under: seed": lambda a, v: under(a, seed=v),
    "worst_case: friction": lambda a, v: hf.sets.worst_case(a, "cube", ON, DOWN, mu_range=v),
    "worst_case: mass": lambda a, v: hf.sets.worst_case(a, "cube", ON, DOWN, mass_range=v),
    "worst_case: standing": lambda a, v: hf.sets.worst_case(a, "cube", ON, DOWN, standing=v),
    "worst_case: com": lambda a, v: hf.sets.worst_case(a, "cube", ON, DOWN, com_range=v),
    "sensitivity: point": lambda a, v: hf.sets.sensitivity(a, "cube", v, DOWN),
    "sensitivity: direction": lambda a, v: hf.sets.sensitivity(a, "cube", ON, v),
    "accelerations: bound": lambda a, v: hf.sets.sustainable_accelerations(a, box=v),
    "accelerations: gap": lambda a, v: hf.sets.sustainable_accelerations(a, accuracy=v),
    "wrenches: bound": lambda a, v: hf.sets.admissible_wrenches(a, "cube", box=v),
    "wrenches: budget": lambda a, v: hf.sets.admissible_wrenches(a, "cube", solves=small(v)),
    "constraint: body": lambda a, v: hf.sets.constraint(a, v, solves=20),
    "constraint: gap": lambda a, v: hf.sets.constraint(a, "cube", accuracy=v, solves=20),
    "constraint: near": lambda a, v: hf.sets.constraint(a, "cube", near=v, solves=20),
    "constraint: box": lambda a, v: hf.sets.constraint(a, "cube", box=v, solves=20),
    "constraint: solves": lambda a, v: hf.sets.constraint(a, "cube", solves=small(v)),
    "constraint: value": lambda a, v: constrained().value(v),
    "constraint: points": lambda a, v: constrained().wrenches(v, DOWN),
    "can_remove: body": lambda a, v: hf.can_remove(a, v, engine="limit"),
    "can_remove: lift": lambda a, v: hf.can_remove(a, "cube", lift=v, engine="limit"),
    "build_order: lift": lambda a, v: hf.build_order(a, lift=v, engine="limit", pushes=0),
    "build_order: pushes": lambda a, v: hf.build_order(a, pushes=small(v), engine="graph"),
    "build_order: solves": lambda a, v: hf.build_order(a, pushes=0, solves=v, engine="limit"),
    "safe_pushes: force": lambda a, v: hf.safe_pushes(a, "cube", v, spacing=0.1),
    "safe_pushes: directions": lambda a, v: hf.safe_pushes(a, "cube", 1.0, directions=v, spacing=0.1),
    "safe_pushes: tool": lambda a, v: hf.safe_pushes(a, "cube", 1.0, tool=hf.sets.Tool(radius=v), spacing=0.1),
    "safe_pushes: travel": lambda a, v: hf.safe_pushes(a, "cube", 9.0, tool=hf.sets.Tool(travel=v), spacing=0.1),
    "safe_pushes: doubt": lambda a, v: hf.safe_pushes(a, "cube", 1.0, doubt=v, spacing=0.1),
    "placement: body": hf.plan_placement,
    "placement: box": lambda a, v: placed(a, box=v),
    "placement: orientations": lambda a, v: placed(a, orientations=v),
    "placement: lean_degrees": lambda a, v: placed(a, lean_degrees=v),
    "placement: direction": lambda a, v: placed(a, direction=v),
    "placement: weights": lambda a, v: placed(a, weights=v),
    "placement: seed": lambda a, v: placed(a, seed=v),
    "placement: seconds": lambda a, v: placed(a, seconds=v),
    "placement: supports": lambda a, v: placed(a, supports=v),
    "placement: free_yaw": lambda a, v: placed(a, free_yaw=v),
    "placement: cone_degrees": lambda a, v: placed(a, cone_degrees=v),
    "placement: keep_out": lambda a, v: placed(a, keep_out=v),
    "place_all: stack": lambda a, v: hf.place_all(
        a, [NEW], where=hf.Where(stack=v), search=hf.Search(confirm=None, seconds=0.1), engine="graph"
    ),
    "settle: travel": lambda _, v: hf.settle(SCENE, travel=v),
    "settle: turn_degrees": lambda _, v: hf.settle(SCENE, turn_degrees=v),
    "settle: known": lambda _, v: hf.settle(SCENE, known=v),
    "settle: pose_sigma": lambda _, v: hf.settle(SCENE, pose_sigma=v),
    "settle: upright": lambda _, v: hf.settle(SCENE, upright=v),
    "batch: ask": lambda _, v: hf.batch([SCENE], v, resources=hf.sets.Resources(shard="none"), out="never"),
    "batch: options": lambda _, v: hf.batch([SCENE], resources=hf.sets.Resources(shard="none"), out="never", options=v),
    "batch: retry": lambda _, v: hf.batch([SCENE], resources=hf.sets.Resources(shard="none"), out="never", retry=v),
    "batch: scenes": lambda _, v: hf.batch(v, resources=hf.sets.Resources(shard="none"), out="never"),
    "placement: avoid": lambda a, v: placed(a, avoid=v),
}


@contextlib.contextmanager
def told() -> Any:
    """Errors of holdfast pass, if they keep to one line and name a remedy; all others do not."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield
        except hf.HoldfastError as error:
            text = str(error)
            if not text.isprintable() or "; " not in text or len(text) > 1100:
                raise AssertionError(text) from error


@pytest.mark.parametrize("name", MAKING)
def test_u6_making_things_of_what_they_are_not_made_of(
    name: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for value in ODD:
        with told():
            MAKING[name](value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ASKING)
def test_u6_asking_with_what_makes_no_sense(name: str, assembly: hf.answers.Assembly) -> None:
    for value in ODD:
        with told():
            ASKING[name](assembly, value)


def test_the_check_itself_notices() -> None:
    with pytest.raises(KeyError), told():
        raise KeyError
    with pytest.raises(AssertionError), told():
        raise hf.HoldfastError("a line\nand another; remedy")
