"""Poses of rest of 40 objects beside random drops in MuJoCo and beside trimesh's stable poses.

Each object is let fall from all sides onto a plane, as its convex hull, from just above it. A drop that ends in a pose
that is not listed is missing; a listed pose that MuJoCo does not keep for a second, from rest, is false. Poses are the
same if the direction that points down, in the body's frame, is; on a round side, if the centre of mass is as high, and
then the side whose facets are nearest.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import holdfast as hf
from bench.baselines.mujoco import mujoco_module
from bench.checkout import ROOT
from bench.suite import Case, Row, Suite
from holdfast.applications.resting_poses import RestingPose, RestingPoses, StandingFaces
from holdfast.scene.formats.mjcf.writer import write

MESHES = ROOT.parent / "shared" / "cases" / "meshes"
DROPS = 500
SAME_DEGREES, SAME_HEIGHT = 4.0, 0.03  # a contact gives way by a few tenths of a millimetre, and a rolling body goes on
SLOWS = 2.0  # [1/s] by which the air slows a rotation
SECONDS, STILL, CALM = 8.0, 1e-3, 100  # longest drop [s]; a body at rest is slower [m/s, rad/s] for so many steps
SCANNED = (
    *("apple", "banana", "bleach_cleanser", "bowl", "cracker_box", "d_cups", "f_cups", "foam_brick", "gelatin_box"),
    *("h_cups", "hammer", "j_cups", "large_clamp", "lemon", "master_chef_can", "mug", "peach", "pitcher_base", "plate"),
    *("plum", "potted_meat_can", "power_drill", "pudding_box", "rubiks_cube", "spatula", "sugar_box"),
)


def _cone() -> hf.Mesh:
    mesh = trimesh.creation.cone(radius=0.04, height=0.1, sections=48)
    return hf.Mesh(mesh.vertices, mesh.faces)


def _tetrahedron() -> hf.Mesh:
    points = np.array([[0, 0, 0], [0.12, 0, 0], [0.03, 0.1, 0], [0.05, 0.04, 0.09]])
    return hf.Mesh(points, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def _part(size: tuple[float, float, float], *centre: float) -> hf.Part:
    return hf.Part(hf.Box(size), pose=hf.pose(*centre))


def _mug() -> hf.Compound:
    cup = hf.Part(hf.Cylinder(0.04, 0.1), pose=hf.pose(z=0.05))
    return hf.Compound([cup, _part((0.03, 0.01, 0.06), 0.055, 0, 0.05)])


MADE: dict[str, Callable[[], Any]] = {
    "box": lambda: hf.Box((0.1, 0.2, 0.3)),
    "cube": lambda: hf.Box((0.1, 0.1, 0.1)),
    "book": lambda: hf.Box((0.2, 0.14, 0.025)),
    "cylinder": lambda: hf.Cylinder(0.04, 0.1),
    "disc": lambda: hf.Cylinder(0.1, 0.02),
    "rod": lambda: hf.Cylinder(0.01, 0.2),
    "capsule": lambda: hf.Capsule(0.03, 0.1),
    "sphere": lambda: hf.Sphere(0.05),
    "flat ellipsoid": lambda: hf.Ellipsoid((0.03, 0.05, 0.08)),
    "long ellipsoid": lambda: hf.Ellipsoid((0.04, 0.04, 0.08)),
    "cone": _cone,
    "tetrahedron": _tetrahedron,
    "L": lambda: hf.Compound([_part((0.2, 0.06, 0.05), 0.1, 0, 0.025), _part((0.05, 0.06, 0.2), 0.025, 0, 0.1)]),
    "mug with a handle": _mug,
}


def cases() -> Mapping[str, Case]:
    made: dict[str, Case] = {name: partial(_measured, name, make) for name, make in MADE.items()}
    if not MESHES.is_dir():
        return made
    return made | {name: partial(_measured, name, partial(_scan, name)) for name in SCANNED}


def _scan(name: str) -> hf.Mesh:
    mesh = trimesh.load(MESHES / "YCB" / f"ycb_{name}.ply", process=True).convex_hull
    return hf.Mesh(mesh.vertices, mesh.faces)


def _measured(name: str, make: Callable[[], Any]) -> list[Row]:
    shape = make()
    begin = time.process_time()
    found = hf.resting_poses(shape, mass=0.5)
    took = time.process_time() - begin
    world, body = World(found), found.body
    rng = np.random.default_rng(7)
    sides = _sides(found)
    ends: Counter[int | None] = Counter(_which(found, sides, *world.drop(rng)) for _ in range(DROPS))
    off = [abs(pose.probability - ends[k] / DROPS) for k, pose in enumerate(found)]
    kept = [world.keeps(pose) for pose in found if not pose.rolls]
    begin = time.process_time()
    hull = trimesh.Trimesh(body.shape.surface.vertices, body.shape.surface.faces)
    hull.center_mass = body.com_body
    others, shares = trimesh.poses.compute_stable_poses(hull, center_mass=body.com_body, n_samples=1)
    return [
        {
            "case": name,
            "poses": len(found),
            "round": sum(pose.rolls for pose in found),
            "ms": 1e3 * took,
            "drops elsewhere": ends[None],
            "false": kept.count(False),
            "largest difference of probability": max(off),
            "trimesh's poses": len(others),
            "its sum of probabilities": float(np.sum(shares)),
        }
    ]


def _sides(found: RestingPoses) -> list[np.ndarray]:
    """The normals (n, 3) of all facets that belong to each pose."""
    standing = StandingFaces(found.body)
    own = [int(np.argmax(standing.graph.normals @ -pose.pose[2, :3])) for pose in found]
    return [standing.graph.normals[standing.family == standing.family[k]] for k in own]


def _which(found: RestingPoses, sides: list[np.ndarray], down: np.ndarray, height: float) -> int | None:
    nearest = int(np.argmax([down @ -pose.pose[2, :3] for pose in found]))
    if down @ -found[nearest].pose[2, :3] > np.cos(np.radians(SAME_DEGREES)):
        return nearest
    alike = [k for k, pose in enumerate(found) if pose.rolls and abs(height / pose.height - 1) < SAME_HEIGHT]
    return max(alike, key=lambda k: float((sides[k] @ down).max()), default=None)


class World:
    """One body above a plane in MuJoCo, which has its own balls, cylinders and the like, and hulls of meshes."""

    def __init__(self, found: RestingPoses) -> None:
        self.mujoco, self.com = mujoco_module(), found.body.com_body
        self.model = self.mujoco.MjModel.from_xml_string(write(found.scene(0), Path()).decode())
        self.model.dof_damping[3:] = (
            SLOWS * np.linalg.eigvalsh(found.body.inertia_com)[-1]
        )  # else an egg rocks for long
        self.data = self.mujoco.MjData(self.model)
        self.radius = float(np.linalg.norm(found.body.shape.surface.vertices - self.com, axis=1).max())

    def drop(self, rng: np.random.Generator) -> tuple[np.ndarray, float]:
        """Let the body fall from a random side; return its downward direction, body frame, and its centre's height."""
        turn = rng.normal(size=4)
        return self._after(SECONDS, turn / np.linalg.norm(turn), 1.05 * self.radius)

    def keeps(self, pose: RestingPose) -> bool:
        """Whether the body stays in a pose for a second."""
        turn = np.empty(4)
        self.mujoco.mju_mat2Quat(turn, pose.pose[:3, :3].ravel())
        down, _ = self._after(1.0, turn, pose.height)
        return bool(down @ -pose.pose[2, :3] > np.cos(np.radians(SAME_DEGREES)))

    def _after(self, seconds: float, turn: np.ndarray, height: float) -> tuple[np.ndarray, float]:
        self.mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[3:] = turn
        self.data.qpos[:3] = np.array([0, 0, height]) - self._turned() @ self.com
        calm = 0
        for _ in range(round(seconds / self.model.opt.timestep)):
            self.mujoco.mj_step(self.model, self.data)
            calm = calm + 1 if np.abs(self.data.qvel).max() < STILL else 0
            if calm > CALM:
                break
        matrix = self._turned()
        return -matrix[2], float(self.data.qpos[2] + matrix[2] @ self.com)

    def _turned(self) -> np.ndarray:
        matrix = np.empty(9)
        self.mujoco.mju_quat2Mat(matrix, self.data.qpos[3:])
        return matrix.reshape(3, 3)


SUITE = Suite("resting", __doc__, cases)
