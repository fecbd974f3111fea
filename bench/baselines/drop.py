"""Drop test: release an assembly in MuJoCo with its real shapes and measure how far its bodies move.

Unlike ``baselines.mujoco``, which loads the contacts that holdfast has found, this test lets MuJoCo find contacts by
itself, so that bodies that overlap or float show as motion. MuJoCo's contacts are damped springs and its friction
creeps, with the settings here by some micrometres a second.

Optional: the extra ``bench``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from bench.baselines.mujoco import as_text, mujoco_module
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import HoldfastError, message
from holdfast.scene.body import Body
from holdfast.scene.shapes import Box

STEP = 5e-4  # [s]
SECONDS = 1.0
LIFT = 1e-4  # [m] height above its place at which the dropped body starts
STILL = 2e-3  # [m] displacement above which a body does not stand
STRAIGHT = 1.0  # [deg] rotation above which a body does not stand
CONVEX = 1e-6  # a body is convex if its volume is smaller than that of its hull by no more than this share
SOFTNESS = {"solref": "0.002 1", "solimp": "0.99 0.999 0.0001 0.5 2"}


@dataclass(frozen=True)
class Drop:
    """The body that ended farthest from where it began: ``moved`` [m] and ``turned`` [deg] of ``body``."""

    moved: float
    turned: float
    body: str
    steps: int

    @property
    def stands(self) -> bool:
        """Whether everything stayed within STILL and STRAIGHT."""
        return self.moved < STILL and self.turned < STRAIGHT


def drop(
    assembly: Assembly, body: str | None = None, *, seconds: float = SECONDS, lift: float = LIFT, step: float = STEP
) -> Drop:
    """Release everything at once, ``body`` from ``lift`` [m] above its place, and simulate ``seconds`` by ``step`` [s].

    ``moved`` is the displacement of the centre of mass and ``turned`` the rotation between the pose in the scene and
    the pose at the end. Shapes must be convex.
    """
    mujoco = mujoco_module()
    model: Any = mujoco.MjModel.from_xml_string(describe(assembly, body, lift, step))
    data: Any = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    steps = round(seconds / step)
    for _ in range(steps):
        mujoco.mj_step(model, data)
    places = np.array(data.xipos[1:])
    turns = np.array(data.xmat[1:]).reshape(-1, 3, 3)  # bodies begin in the world's axes
    moved = np.linalg.norm(places - assembly.com, axis=1)
    cosine = (np.trace(turns, axis1=1, axis2=2) - 1) / 2
    turned = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    worst = int(np.argmax(np.maximum(moved / STILL, turned / STRAIGHT)))
    finite = bool(np.isfinite(moved).all())
    return Drop(
        float(moved[worst]) if finite else np.inf,
        float(turned[worst]) if finite else np.inf,
        assembly.movable[worst].name,
        steps,
    )


def describe(assembly: Assembly, lifted: str | None, lift: float, step: float = STEP) -> str:
    """The assembly in MuJoCo's XML: bodies in the world's axes about their centres of mass, every pair with its mu."""
    root = Xml.Element("mujoco")
    Xml.SubElement(root, "compiler", angle="radian", balanceinertia="false", boundmass="0", boundinertia="0")
    option = Xml.SubElement(
        root, "option", timestep=f"{step}", gravity=as_text(assembly.scene.gravity), cone="elliptic", impratio="100",
        solver="Newton", iterations="100", tolerance="1e-10", noslip_iterations="4",
    )  # fmt: skip
    Xml.SubElement(option, "flag", multiccd="enable")
    asset, space = Xml.SubElement(root, "asset"), Xml.SubElement(root, "worldbody")
    up = assembly.scene.up
    for number, body in enumerate(assembly.bodies):
        centre = np.zeros(3)
        home = space
        if not body.fixed:
            centre = body.com_world
            start = centre + (lift * up if body.name == lifted else 0.0)
            home = Xml.SubElement(space, "body", pos=as_text(start))
            Xml.SubElement(home, "freejoint")
            inertia = body.pose[:3, :3] @ body.inertia_com @ body.pose[:3, :3].T
            entries = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            Xml.SubElement(home, "inertial", pos="0 0 0", mass=f"{body.mass!r}", fullinertia=as_text(entries))
        geom = {"name": body.name, "condim": "3", "contype": "0", "conaffinity": "0"}
        if isinstance(body.shape, Box):
            across = np.concatenate([body.pose[:3, 0], body.pose[:3, 1]])
            shape = {"type": "box", "size": as_text(body.shape.size / 2), "xyaxes": as_text(across)}
            Xml.SubElement(home, "geom", geom | shape | {"pos": as_text(body.pose[:3, 3] - centre)})
        else:
            # MuJoCo moves a mesh into its own principal axes and undoes that in the geom's pose
            vertices, faces = _hull(body)
            name = f"m{number}"
            Xml.SubElement(
                asset, "mesh", name=name, vertex=as_text((vertices - centre).ravel()),
                face=" ".join(str(k) for k in faces.ravel()),
            )  # fmt: skip
            Xml.SubElement(home, "geom", geom | {"type": "mesh", "mesh": name})
    contact = Xml.SubElement(root, "contact")
    for i, a in enumerate(assembly.bodies):
        for b in assembly.bodies[i + 1 :]:
            if not (a.fixed and b.fixed):
                mu = max(assembly.scene.mu(a.name, b.name), 1e-5)
                friction = as_text(np.array([mu, mu, 0, 0, 0]))
                pair = {"geom1": a.name, "geom2": b.name, "condim": "3", "friction": friction}
                Xml.SubElement(contact, "pair", pair | SOFTNESS)
    return Xml.tostring(root, encoding="unicode")


def _hull(body: Body) -> tuple[Float, Int]:
    """Vertices (V, 3) in the world and faces (F, 3) of a convex body."""
    surface = body.surface_world
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    volume = float((a * np.cross(b, c)).sum()) / 6
    try:
        hull = ConvexHull(surface.vertices)
    except QhullError:
        hull = None
    if hull is None or volume < (1 - CONVEX) * hull.volume:
        remedy = "MuJoCo takes its hull: ask baselines.mujoco.holds, which goes by the contacts found"
        raise HoldfastError(message(f"drop test: body {body.name!r}", "is not convex", remedy))
    return surface.vertices, surface.faces
