"""A verdict on a fresh scene beside the second that physics engines simulate: SAPIEN (PhysX) and MuJoCo.

Each time all shapes and bodies are new, and their sizes differ by a millionth from those before, so that nothing is
remembered. Both engines get the same shapes and poses with their own defaults (SAPIEN 100 steps of 10 ms, MuJoCo 500 of
2 ms), and building their scenes counts as building ours does; hulls are given to all three as points. Times are
processor time of one thread, medians of runs in turns; SAPIEN and MuJoCo do not say whether anything stands.
"""

from __future__ import annotations

import time
import warnings
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
            shape, sizes = part.shape, ()
            match shape:
                case hf.Box():
                    kind, sizes = "box", tuple(shape.size)
                case Sphere():
                    kind, sizes = "sphere", (shape.radius,)
                case Cylinder():
                    kind, sizes = "cylinder", (shape.radius, shape.height)
                case Capsule():
                    kind, sizes = "capsule", (shape.radius, shape.length)
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


def ours(things: list[Thing], scale: float) -> str:
    """What holdfast says of them, from shapes on."""
    import trimesh

    bodies = [hf.Body("ground", hf.HalfSpace(), fixed=True)]
    parts: dict[str, list[tuple[Any, Thing]]] = {}
    for thing in things:
        sizes = tuple(scale * size for size in thing.sizes)
        match thing.kind:
            case "hull":
                assert thing.points is not None
                shape: Any = trimesh.Trimesh(scale * thing.points, thing.faces, process=False)
            case "box":
                shape = hf.Box(sizes)
            case "sphere":
                shape = Sphere(*sizes)
            case "cylinder":
                shape = Cylinder(*sizes)
            case _:
                shape = Capsule(*sizes)
        parts.setdefault(thing.name.split("/")[0], []).append((shape, thing))
    for name, own in parts.items():
        shape, thing = own[0]
        pose = thing.pose.copy()
        pose[:3, 3] *= scale
        if len(own) > 1:
            inside = np.linalg.inv(thing.pose)
            placed = [(part, inside @ each.pose) for part, each in own]
            shape = hf.Compound([hf.Part(part, pose) for part, pose in placed])
        bodies.append(hf.Body(name, shape, mass=sum(each.mass for _, each in own), pose=pose))
    return str(hf.stability(hf.assemble(hf.Scene(bodies, 0.5))).status)


def of_sapien(things: list[Thing], scale: float) -> None:
    """Let SAPIEN simulate them for a second."""
    import sapien

    physx = sapien.physx
    scene = sapien.Scene([physx.PhysxCpuSystem()])
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
    for _ in range(round(1 / scene.timestep)):
        scene.step()


def of_mujoco(things: list[Thing], scale: float) -> None:
    """Let MuJoCo simulate them for a second."""
    mujoco = mujoco_module()
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[HALF, HALF, 1])
    kinds = {name: getattr(mujoco.mjtGeom, f"mjGEOM_{name.upper()}") for name in ("box", "sphere", "cylinder", "capsule")}
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
    for _ in range(round(1 / model.opt.timestep)):
        mujoco.mj_step(model, data)


def _case(name: str, make: Callable[[], list[Thing]]) -> list[Row]:
    things, verdict = make(), ""
    spent: dict[str, list[float]] = {"holdfast": [], "sapien": [], "mujoco": []}
    for k in range(RUNS.get(name, 15)):
        scale = 1 + 1e-6 * (k + 1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for who, ask in (("holdfast", ours), ("sapien", of_sapien), ("mujoco", of_mujoco)):
                begin = time.process_time()
                said = ask(things, scale)
                spent[who].append(time.process_time() - begin)
                verdict = said or verdict
    row: Row = {"case": name, "bodies": len({thing.name.split("/")[0] for thing in things}), "verdict": verdict}
    row |= {f"{who} s": median(times) for who, times in spent.items()}
    ratios = {f"over {who}": row["holdfast s"] / row[f"{who} s"] for who in ("sapien", "mujoco")}
    return [row | ratios]


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


SUITE = Suite("physics_engines", __doc__ or "", cases)
