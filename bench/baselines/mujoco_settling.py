"""Bring a scene to rest in MuJoCo, as its users do: with its own contacts and settings, for two seconds.

Optional: the extra ``bench``.
"""

from __future__ import annotations

import numpy as np

from bench.baselines.mujoco import mujoco_module
from holdfast.base.rigid import pose_from
from holdfast.scene.formats.mjcf.writer import write
from holdfast.scene.scene import Scene

SECONDS = 2.0  # [s] simulated time


def settled_by_mujoco(scene: Scene) -> Scene:
    """Return the scene with the poses that its bodies have after SECONDS in MuJoCo."""
    from pathlib import Path

    mujoco = mujoco_module()
    model = mujoco.MjModel.from_xml_string(write(scene, Path()).decode())
    data = mujoco.MjData(model)
    for _ in range(round(SECONDS / model.opt.timestep)):
        mujoco.mj_step(model, data)
    poses = {}
    for body in scene.movable:
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body.name)
        poses[body.name] = pose_from(np.array(data.xpos[number]), np.array(data.xquat[number]))
    return scene.moved(poses)
