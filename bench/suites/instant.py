"""A plain question, whether bodies stand, beside the second that physics engines simulate: SAPIEN (PhysX) and MuJoCo.

Each time all shapes and bodies are new, and their sizes differ by a millionth from those before, so that nothing is
remembered. Making scenes and models, with reading and welding meshes, counts for none of the three. Both engines have
their own solvers' settings, MuJoCo its own 500 steps, SAPIEN 240, and its default of 100, and hulls are given to all as
points. Times are processor time of one thread, medians of runs in turns.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from statistics import median
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import holdfast as hf
from bench.baselines.mujoco import mujoco_module
from bench.checkout import CASES
from bench.scenes.dense_pallet import pallet
from bench.scenes.shelf import shelf
from bench.suite import Case, Row, Suite
from holdfast.base.arrays import Float, Int
from holdfast.scene.round_shapes import Capsule
from holdfast.scene.shapes import Cylinder, Sphere
from holdfast.scene.shipped.blocks import at, wall

SCANS = ("cracker_box", "power_drill", "sugar_box", "tomato_soup_can", "bleach_cleanser")
APART = 0.35  # [m] from one of them to the next
RUNS = {"wall of 200": 5, "wall of 1,000": 3}  # else 15
HALF = 5.0  # [m] half the side of the ground


@dataclass(frozen=True)
class Thing:
    """A body: ``kind`` of shape, its ``sizes`` [m], or the points and faces of a hull, and the pose of its frame."""

    name: str
    kind: str
    sizes: tuple[float, ...]
    pose: Float
    mass: float
    points: Float | None = None
    faces: Int | None = None


def wxyz(thing: Thing) -> list[float]:
    """Its rotation as a quaternion."""
    return [float(each) for each in np.roll(Rotation.from_matrix(thing.pose[:3, :3]).as_quat(), 1)]


def boxes(count: int, step: Float) -> list[Thing]:
    """Cubes of 0.1 m, each one ``step`` (3,) [m] from the one before."""
    places = [np.array([0, 0, 0.05]) + k * step for k in range(count)]
    return [Thing(f"box{k}", "box", (0.1, 0.1, 0.1), at(*place), 1.0) for k, place in enumerate(places)]


def of_scene(scene: hf.Scene) -> list[Thing]:
    """The movable bodies of a scene on a level ground."""
    found = []
    for body in scene.movable:
        parts = getattr(body.shape, "parts", None) or [hf.Part(body.shape)]
        for k, part in enumerate(parts):
            shape = part.shape
            sizes: tuple[float, ...]
            match shape:
                case hf.Box():
                    kind, sizes = "box", tuple(shape.size)
                case Sphere():
                    kind, sizes = "sphere", (shape.radius,)
                case Cylinder():
                    kind, sizes = "cylinder", (shape.radius, shape.height)
                case Capsule():
                    kind, sizes = "capsule", (shape.radius, shape.length)
            assert body.mass is not None
            name = body.name if len(parts) == 1 else f"{body.name}/{k}"
            found.append(Thing(name, kind, sizes, body.pose @ part.pose, body.mass))
    return found


@cache
def hulls() -> list[Thing]:
    """Five hulls of scanned things, each in its most probable pose."""
    import trimesh

    found = []
    for k, name in enumerate(SCANS):
        mesh = trimesh.load_mesh(CASES / "meshes" / "YCB" / f"ycb_{name}.ply").convex_hull
        mesh.apply_translation(-mesh.center_mass)
        pose = hf.resting_poses(mesh).poses[0].pose @ np.eye(4)
        pose[:2, 3] = APART * k, 0.0
        found.append(Thing(name, "hull", (), pose, 0.5, np.array(mesh.vertices), np.array(mesh.faces)))
    return found


def scene_of(things: list[Thing], scale: float) -> hf.Scene:
    """The same as a scene, ``scale`` times as large."""
    bodies = [hf.Body("ground", hf.HalfSpace(), fixed=True)]
    parts: dict[str, list[Thing]] = {}
    for thing in things:
        parts.setdefault(thing.name.split("/")[0], []).append(thing)
    for name, own in parts.items():
        pose, inside = own[0].pose.copy(), np.linalg.inv(own[0].pose)
        pose[:3, 3] *= scale
        shape = _shape(own[0], scale)
        if len(own) > 1:
            places = [inside @ each.pose for each in own]
            for place in places:
                place[:3, 3] *= scale
            shape = hf.Compound([hf.Part(_shape(each, scale), place) for each, place in zip(own, places, strict=True)])
        bodies.append(hf.Body(name, shape, mass=sum(each.mass for each in own), pose=pose))
    scene = hf.Scene(bodies, 0.5)
    for body in scene.bodies:
        body.shape.surface  # noqa: B018 - reading and welding a mesh belongs to loading
    return scene


def _shape(thing: Thing, scale: float) -> Any:  # noqa: ANN401 - any shape
    sizes = tuple(scale * size for size in thing.sizes)
    match thing.kind:
        case "hull":
            assert thing.points is not None
            assert thing.faces is not None
            return hf.Mesh(scale * thing.points, thing.faces)
        case "box":
            return hf.Box(sizes)
        case "sphere":
            return Sphere(sizes[0])
        case "cylinder":
            return Cylinder(sizes[0], sizes[1])
    return Capsule(sizes[0], sizes[1])


def in_sapien(things: list[Thing], scale: float, steps: int) -> Callable[[], None]:
    """What simulates a second of them in SAPIEN."""
    import sapien

    physx = sapien.physx
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    scene.set_timestep(1 / steps)
    material = physx.PhysxMaterial(0.5, 0.5, 0)
    scene.add_ground(0, render=False, material=material)
    upright = sapien.Pose([0, 0, 0], [np.sqrt(0.5), 0, -np.sqrt(0.5), 0])  # from x to z
    for thing in things:
        s = [scale * size for size in thing.sizes]
        match thing.kind:
            case "hull":
                assert thing.points is not None
                points = (scale * thing.points).astype(np.float32)
                shape = physx.PhysxCollisionShapeConvexMesh(points, [1, 1, 1], material)
            case "box":
                shape = physx.PhysxCollisionShapeBox([size / 2 for size in s], material)
            case "sphere":
                shape = physx.PhysxCollisionShapeSphere(s[0], material)
            case "cylinder":
                shape = physx.PhysxCollisionShapeCylinder(s[0], s[1] / 2, material)
            case _:
                shape = physx.PhysxCollisionShapeCapsule(s[0], s[1] / 2, material)
        if thing.kind in ("cylinder", "capsule"):
            shape.set_local_pose(upright)
        body = physx.PhysxRigidDynamicComponent()
        body.attach(shape)
        entity = sapien.Entity()
        entity.add_component(body)
        entity.set_pose(sapien.Pose(scale * thing.pose[:3, 3], wxyz(thing)))
        scene.add_entity(entity)

    def simulate() -> None:
        for _ in range(steps):
            scene.step()

    return simulate


def in_mujoco(things: list[Thing], scale: float) -> Callable[[], None]:
    """What simulates a second of them in MuJoCo."""
    mujoco = mujoco_module()
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[HALF, HALF, 1])
    names = ("box", "sphere", "cylinder", "capsule")
    kinds = {name: getattr(mujoco.mjtGeom, f"mjGEOM_{name.upper()}") for name in names}
    for thing in things:
        body = spec.worldbody.add_body(pos=scale * thing.pose[:3, 3], quat=wxyz(thing))
        body.add_freejoint()
        s = [scale * size for size in thing.sizes]
        if thing.kind == "hull":
            assert thing.points is not None
            spec.add_mesh(name=thing.name, uservert=(scale * thing.points).ravel())
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=thing.name, mass=thing.mass)
            continue
        halves = {"box": [size / 2 for size in s], "sphere": [*s, 0, 0]}
        size = halves.get(thing.kind) or [s[0], s[1] / 2, 0]
        body.add_geom(type=kinds[thing.kind], size=size, mass=thing.mass)
    model = spec.compile()
    data = mujoco.MjData(model)

    def simulate() -> None:
        for _ in range(round(1 / model.opt.timestep)):
            mujoco.mj_step(model, data)

    return simulate


def _case(name: str, make: Callable[[], list[Thing]]) -> list[Row]:
    things = make()
    spent: dict[str, list[float]] = {}

    def timed(what: str, ask: Callable[[], Any]) -> Any:  # noqa: ANN401 - what ask returns
        begin = time.process_time()
        said = ask()
        spent.setdefault(what, []).append(time.process_time() - begin)
        return said

    for k in range(RUNS.get(name, 15)):
        scale = 1 + 1e-6 * (k + 1)
        scene = scene_of(things, scale)
        assembly = timed("assemble s", partial(hf.assemble, scene))
        verdict = timed("verdict s", partial(hf.stability, assembly))
        assert verdict.stable, verdict.reason
        up = at(0, 0.001 * (k + 1), 0)
        poses = {body.name: up @ body.pose for body in scene.movable[:5]}
        timed("five moved s", partial(_moved_and_asked, assembly, poses))
        timed("sapien s", in_sapien(things, scale, 240))
        timed("sapien, 100 steps s", in_sapien(things, scale, 100))
        timed("mujoco s", in_mujoco(things, scale))
    row: Row = {"case": name, "bodies": len(assembly.movable), **{what: median(times) for what, times in spent.items()}}
    ours = row["assemble s"] + row["verdict s"]
    return [row | {"over sapien": ours / row["sapien s"], "over mujoco": ours / row["mujoco s"]}]


def _moved_and_asked(assembly: hf.answers.Assembly, poses: Mapping[str, Float]) -> None:
    hf.stability(assembly.moved(poses))


def cases() -> Mapping[str, Case]:
    """Return the scenes by label."""
    makers: dict[str, Callable[[], list[Thing]]] = {
        "1 box": lambda: boxes(1, np.zeros(3)),
        "10 lone boxes": lambda: boxes(10, np.array([0.2, 0, 0])),
        "100 lone boxes": lambda: boxes(100, np.array([0.2, 0, 0])),
        "stack of 10": lambda: boxes(10, np.array([0, 0, 0.1])),
        "row of 10": lambda: boxes(10, np.array([0.1, 0, 0])),
        "shelf of 8": lambda: of_scene(shelf()),
        "5 scanned hulls": hulls,
        "pallet of 40": lambda: of_scene(pallet(2, 4, 5)),
        "wall of 200": lambda: of_scene(wall(20, 10, 0.25, "wall")),
        "wall of 1,000": lambda: of_scene(wall(40, 25, 0.25, "wall")),
    }
    return {name: partial(_case, name, make) for name, make in makers.items()}


SUITE = Suite("instant", __doc__ or "", cases)
