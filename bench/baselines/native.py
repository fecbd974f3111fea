"""Pushes in MuJoCo with the bodies' real shapes: it finds contacts by itself, and its friction remembers nothing.

Elliptic cones, implicitfast, noslip, and small steps, so that what creeps is told from what moves.
"""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from bench.baselines.mujoco import as_text, mujoco_module
from bench.scenes.random_pushes import Push
from holdfast import Body, Box, Cylinder, Mesh, Scene, Sphere
from holdfast.base.arrays import Float

SETTLE, RAMP, HOLD = 0.3, 0.3, 0.4  # [s]
FAR = 2e-3  # [m] by which what moves has moved at the end
SLIGHT = 2e-4  # [m] of what still moves then, by a third or more in the last half of the time
STILL = 1e-3  # [m] by which bodies may settle before they are pushed
UPRIGHT = 0.7  # cosine of its axis with the vertical from which on a cylinder stands
LOOK = 200  # steps from one look to the next


class Native:
    """A scene in MuJoCo, at rest under its weight where it ``stands``."""

    def __init__(self, scene: Scene, step: float, settle: float = SETTLE) -> None:
        self.mujoco, self.step = mujoco_module(), step
        self.model: Any = self.mujoco.MjModel.from_xml_string(described(scene, step))
        self.data: Any = self.mujoco.MjData(self.model)
        self.number = {body.name: k + 1 for k, body in enumerate(scene.bodies)}
        self.movable = [self.number[body.name] for body in scene.movable]
        self.mujoco.mj_forward(self.model, self.data)
        before = self._places()
        for _ in range(round(settle / step)):
            self.mujoco.mj_step(self.model, self.data)
        self.stands = float(np.abs(self._places() - before).max()) < STILL
        self.data.qvel[:] = 0
        self.kind = self.mujoco.mjtState.mjSTATE_INTEGRATION
        self.start = np.empty(self.mujoco.mj_stateSize(self.model, self.kind))
        self.mujoco.mj_getState(self.model, self.data, self.start, self.kind)

    def moves(self, push: Push, force: float, slight: float = SLIGHT) -> bool:
        """Whether a push of this force [N], which acts where it began and keeps its direction, moves something far.

        What has moved by more than ``slight`` [m] and goes on counts too; with infinity, only what is FAR does.
        """
        data, body, count = self.data, self.number[push.body], round((RAMP + HOLD) / self.step)
        self.mujoco.mj_setState(self.model, data, self.start, self.kind)
        self.mujoco.mj_forward(self.model, data)
        own = data.xmat[body].reshape(3, 3).T @ (push.point - data.xpos[body])
        before, half = self._places(), 0.0
        for k in range(count):
            share = min(1.0, (k + 1) * self.step / RAMP)
            load = share * share * (3 - 2 * share) * force * push.direction
            at = data.xpos[body] + data.xmat[body].reshape(3, 3) @ own
            data.xfrc_applied[body] = [*load, *np.cross(at - data.xipos[body], load)]
            self.mujoco.mj_step(self.model, data)
            if k == round((RAMP + HOLD / 2) / self.step):
                half = self._apart(before)
            if k % LOOK == LOOK - 1 and not self._apart(before) < 5 * FAR:
                break
        data.xfrc_applied[:] = 0
        apart = self._apart(before)
        return not apart <= FAR or (apart > slight and apart - half > half / 3)

    def _apart(self, before: Float) -> float:
        return float(np.abs(self._places() - before).max())

    def _places(self) -> Float:
        """Centres of mass and axes, these as if they were 50 mm long (n, 12) [m]."""
        axes = self.data.ximat[self.movable].reshape(-1, 9)
        return np.hstack([self.data.xipos[self.movable], 0.05 * axes])


def described(scene: Scene, step: float) -> str:
    """The scene in MuJoCo's XML, with a contact pair for every two bodies."""
    root = Xml.Element("mujoco")
    Xml.SubElement(root, "compiler", angle="radian", boundmass="0", boundinertia="0", inertiafromgeom="false")
    solver = {"integrator": "implicitfast", "noslip_iterations": "20", "noslip_tolerance": "1e-10"}
    exact = {"iterations": "100", "tolerance": "1e-12", "cone": "elliptic", "impratio": "100"}
    Xml.SubElement(root, "option", {"timestep": repr(step), "gravity": as_text(scene.gravity)} | solver | exact)
    asset, world, contact = (Xml.SubElement(root, name) for name in ("asset", "worldbody", "contact"))
    for k, body in enumerate(scene.bodies):
        add_body(world, asset, body, k)
    soft = {"condim": "3", "solref": f"{4 * step!r} 1", "solimp": "0.99 0.999 0.0001 0.5 2"}
    materials = {body.name: body.material for body in scene.bodies}
    for j, b in enumerate(scene.bodies):
        for i, a in enumerate(scene.bodies[:j]):
            if not (a.fixed and b.fixed):
                mu = max(scene.friction.between(a.name, b.name, materials), 1e-5)
                pair = {"geom1": f"g{i}", "geom2": f"g{j}", "friction": f"{mu} {mu} 0 0 0"}
                Xml.SubElement(contact, "pair", pair | soft)
    return Xml.tostring(root, encoding="unicode")


def add_body(world: Xml.Element, asset: Xml.Element, body: Body, number: int) -> None:
    """Add a body, which is a box, a cylinder, a sphere or a convex mesh."""
    turn = body.pose[:3, :3]
    axes = as_text(np.concatenate([turn[:, 0], turn[:, 1]]))
    home = Xml.SubElement(world, "body", pos=as_text(body.pose[:3, 3]), xyaxes=axes)
    if body.mass is not None and not body.fixed:
        Xml.SubElement(home, "freejoint")
        entries = as_text(body.inertia_com[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])
        Xml.SubElement(home, "inertial", pos=as_text(body.com_body), mass=repr(body.mass), fullinertia=entries)
    shape = {"name": f"g{number}", "contype": "0", "conaffinity": "0"}
    if isinstance(body.shape, Box):
        shape |= {"type": "box", "size": as_text(np.array(body.shape.size) / 2)}
    elif isinstance(body.shape, Sphere):
        shape |= {"type": "sphere", "size": f"{body.shape.radius!r}"}
    elif isinstance(body.shape, Cylinder):
        # where one lies, MuJoCo finds both ends of a capsule's line on a box, of a cylinder's often one
        kind = "cylinder" if abs(turn[2, 2]) > UPRIGHT else "capsule"
        shape |= {"type": kind, "size": f"{body.shape.radius!r} {body.shape.height / 2!r}"}
    else:
        assert isinstance(body.shape, Mesh)
        Xml.SubElement(asset, "mesh", name=f"m{number}", vertex=as_text(body.shape.vertices.ravel()))
        shape |= {"type": "mesh", "mesh": f"m{number}"}
    Xml.SubElement(home, "geom", shape)
