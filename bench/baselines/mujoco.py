"""MuJoCo as a referee: rigid bodies with many stiff contact points, integrated in time.

Every contact node of an interface is a tiny sphere on body b against a wide flat box on body a; only these pairs
collide. MuJoCo's contacts are regularised: normal ones are damped springs, friction yields to any force at a speed
(creep), here some 1e-6 m/s at the friction limit. Springs are set so that all contacts of an assembly are equally stiff
per tributary area, as in engine ``compliant``; MuJoCo's own choice, equal time constants, would make contacts of heavy
bodies stiffer. Geometry is exact: bodies tilt and points move, by some 1e-6 m before anything gives way.

Optional: the extra ``bench``.
"""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from bench.baselines.search import Peak, Trial, grid_nodes, largest_load, push, trial_under
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message

SIDE = 5  # nodes along a side unless given
STEP = 1e-4  # [s]
STEPS = 4  # number of time steps in the time constant of a contact's spring, which is critically damped
IMPEDANCE = 2.0  # mean share of a contact's stiffness over the body's own inertia, d / (1 - d) in MuJoCo's terms
IMPRATIO = 1e5  # friction over normal constraint impedance: creep falls with it
GLIDE = 0.01  # dashpot of friction over the normal one; sliding contacts press harder in proportion to it
SPHERE = 2e-3  # radius over the assembly's size
SETTLE = 0.1  # [s] time under the weight alone
RAMP = 0.1  # [s] time over which a load grows
HOLD = 0.2  # [s] shortest time under the full load
LONGEST = 0.6  # [s] longest time under the full load, if neither rest nor motion is seen earlier
LOOK = 250  # time steps between two measurements
FAR = 1e-3  # displacement under the load, in sizes of the assembly, above which contact nodes count as moving
SLOW = 5e-5  # speed at the end, in sizes of the assembly per second, below which contact nodes count as resting
STAYS = 0.8  # share of the speed at half time: an assembly at least that fast at the end keeps moving
PASSIVE = {"contype": "0", "conaffinity": "0", "mass": "0"}  # collides only in pairs that are named


def holds(assembly: Assembly, load: Float | None = None, nodes: ContactNodes | None = None) -> Trial:
    """Whether the assembly comes to rest under its weight, and then under ``load`` (6J,) [N, N m] as well.

    ``nodes``: grids of SIDE x SIDE on every (rectangular) patch unless given.
    """
    return trial_under(World(assembly, nodes), load)


def peak(
    assembly: Assembly,
    body: str,
    point: Float,
    direction: Float,
    nodes: ContactNodes | None = None,
    *,
    accuracy: float = 5e-3,
) -> Peak:
    """The largest push [N] at ``point`` [m] of ``body`` along ``direction`` that comes to rest, by bisection.

    Every load is tried from rest under the weight alone, to ``accuracy`` times the load. ``nodes`` as in ``holds``.
    """
    return largest_load(World(assembly, nodes), assembly.weight, push(assembly, body, point, direction), accuracy)


class World:
    """An assembly in MuJoCo, at rest under its weight; ``weighed`` is the trial under the weight alone."""

    def __init__(self, assembly: Assembly, nodes: ContactNodes | None = None) -> None:
        nodes = grid_nodes(assembly, SIDE) if nodes is None else nodes
        self.assembly, self.nodes = assembly, nodes
        self.mujoco = mujoco_module()
        self.model: Any = self.mujoco.MjModel.from_xml_string(describe(assembly, nodes))
        equal_stiffness(self.model, nodes)
        self.data: Any = self.mujoco.MjData(self.model)
        self.start: Float | None = None
        self.weighed = self.trial(np.zeros(6 * len(assembly.movable)), SETTLE)
        self.start = self._state()

    def trial(self, load: Float, ramp: float = RAMP) -> Trial:
        """Raise ``load`` (6J,) [N, N m] smoothly from rest and simulate until rest or motion is seen."""
        model, data = self.model, self.data
        if self.start is not None:
            self.mujoco.mj_setState(model, data, self.start, self.mujoco.mjtState.mjSTATE_INTEGRATION)
        self.mujoco.mj_forward(model, data)
        before = self._places()
        wrench = load.reshape(-1, 6)
        size = self.assembly.size
        drift = speed = half = 0.0
        grown, enough, most = (round(t / STEP) for t in (ramp, ramp + HOLD, ramp + LONGEST))
        for step in range(1, most + 1):
            share = min(1.0, step / grown)
            data.xfrc_applied[1:] = share * share * (3 - 2 * share) * wrench
            self.mujoco.mj_step(model, data)
            if step % LOOK:
                continue
            places = self._places()
            drift, speed = _apart(places[0] - before[0]), _apart(places[1])
            if not np.isfinite(drift) or drift > FAR * size:
                return Trial(False, drift, speed, step)
            if step >= enough and speed < SLOW * size:
                return Trial(True, drift, speed, step)
            half = speed if step <= (grown + most) // 2 else half
        return Trial(False if speed > STAYS * half else None, drift, speed, most)

    def _state(self) -> Float:
        kind = self.mujoco.mjtState.mjSTATE_INTEGRATION
        state = np.empty(self.mujoco.mj_stateSize(self.model, kind))
        self.mujoco.mj_getState(self.model, self.data, state, kind)
        return state

    def _places(self) -> tuple[Float, Float]:
        return node_motion(self.assembly, self.nodes, self.data)


def node_motion(assembly: Assembly, nodes: ContactNodes, data: Any) -> tuple[Float, Float]:  # noqa: ANN401
    """Displacement [m] and velocity [m/s] of the nodes on body b relative to those on body a, (I, 3) each."""
    count = len(assembly.movable)
    place, speed = np.zeros((2, len(nodes), 3)), np.zeros((2, len(nodes), 3))
    turns, centres = data.xmat[1 : count + 1].reshape(count, 3, 3), data.xipos[1:]
    velocity = data.qvel[: 6 * count].reshape(count, 6)
    for side, end in enumerate((nodes.a, nodes.b)):
        free = end != FIXED
        k = end[free]
        arm = np.einsum("ixy,iy->ix", turns[k], nodes.points[free] - assembly.com[k])
        place[side, free] = centres[k] + arm - nodes.points[free]
        spin = np.einsum("ixy,iy->ix", turns[k], velocity[k, 3:])
        speed[side, free] = velocity[k, :3] + np.cross(spin, arm)
        if len(data.qvel) > 6 * count:  # a carrier, which slides
            place[side, ~free], speed[side, ~free] = data.qpos[-3:], data.qvel[-3:]
    return place[1] - place[0], speed[1] - speed[0]


def describe(assembly: Assembly, nodes: ContactNodes, carrier: float | None = None, step: float = STEP) -> str:
    """The assembly in MuJoCo's XML: frames at centres of mass along the world's axes, a contact pair a node.

    With ``carrier`` [kg] all fixed bodies form one body of that mass, the last one, which slides along x, y and z.
    """
    root = Xml.Element("mujoco")
    Xml.SubElement(root, "compiler", angle="radian", balanceinertia="false", boundmass="0", boundinertia="0")
    Xml.SubElement(
        root,
        "option",
        timestep=f"{step}",
        gravity=as_text(assembly.scene.gravity),
        cone="elliptic",
        impratio=f"{IMPRATIO}",
        solver="Newton",
        iterations="100",
        tolerance="1e-12",
        integrator="Euler",
    )
    Xml.SubElement(root, "size", memory="64M")
    space = Xml.SubElement(root, "worldbody")
    homes = []
    for k, body in enumerate(assembly.movable):
        home = Xml.SubElement(space, "body", pos=as_text(assembly.com[k]))
        Xml.SubElement(home, "freejoint")
        turn = body.pose[:3, :3]
        inertia = turn @ body.inertia_com @ turn.T
        entries = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        Xml.SubElement(home, "inertial", pos="0 0 0", mass=f"{body.mass!r}", fullinertia=as_text(entries))
        homes.append(home)
    homes.append(space if carrier is None else _carrier(space, carrier))
    contact = Xml.SubElement(root, "contact")
    size = assembly.size
    centre = np.vstack([assembly.com, np.zeros((1, 3))])  # the last one is FIXED
    for i in range(len(nodes)):
        a, b, point, axes = nodes.a[i], nodes.b[i], nodes.points[i], nodes.axes[i]
        pad, ball = homes[a], homes[b]
        if i == 0 or nodes.interface[i] != nodes.interface[i - 1] or _leaves(nodes, i, 1e-9 * size):
            name = f"pad{i}"
            across = np.concatenate([axes[1], axes[2]])
            middle = point - 0.1 * size * axes[0] - centre[a]
            half = as_text(np.array([2, 2, 0.1]) * size)
            shape = {"type": "box", "name": name, "pos": as_text(middle), "xyaxes": as_text(across), "size": half}
            Xml.SubElement(pad, "geom", shape | PASSIVE)
        radius = SPHERE * size
        place = as_text(point + radius * axes[0] - centre[b])
        Xml.SubElement(ball, "geom", {"type": "sphere", "name": f"n{i}", "pos": place, "size": f"{radius!r}"} | PASSIVE)
        mu = max(float(nodes.mu[i]), 1e-5)
        friction = as_text(np.array([mu, mu, 0, 0, 0]))
        Xml.SubElement(contact, "pair", geom1=name, geom2=f"n{i}", condim="3", friction=friction)
    return Xml.tostring(root, encoding="unicode")


def _carrier(space: Xml.Element, mass: float) -> Xml.Element:
    home = Xml.SubElement(space, "body", name="carrier")
    for axis in np.eye(3):
        Xml.SubElement(home, "joint", type="slide", axis=as_text(axis))
    Xml.SubElement(home, "inertial", pos="0 0 0", mass=f"{mass!r}", diaginertia=as_text(np.full(3, mass)))
    return home


def _leaves(nodes: ContactNodes, i: int, flat: float) -> bool:
    """Whether node i does not lie in the plane of the one before."""
    turned = np.abs(nodes.axes[i] - nodes.axes[i - 1]).max() > 1e-12
    return bool(turned or abs((nodes.points[i] - nodes.points[i - 1]) @ nodes.axes[i, 0]) > flat)


def equal_stiffness(model: Any, nodes: ContactNodes, step: float = STEP) -> None:  # noqa: ANN401 - it has no types
    """Give every pair a spring in proportion to its tributary area.

    MuJoCo's constraint i yields by R_i = (1 - d_i) / d_i A_i (A_i the inverse masses of both bodies) and is driven by
    -b v - k d r; at rest the force is k d r / R. With d / (1 - d) in proportion to area times A, and k, b divided by
    the powers of d that MuJoCo puts on them, that is a spring in proportion to area.
    """
    inverse = model.body_invweight0[1:, 0]
    if model.nv % 6 == 0:  # the last one is FIXED: a carrier, which has three joints, or the world
        inverse = np.append(inverse, 0.0)
    share = nodes.weights * (inverse[nodes.a] + inverse[nodes.b])
    share *= IMPEDANCE / share.mean()
    d = share / (1 + share)
    constant = STEPS * step
    model.pair_solimp[:] = np.column_stack([d, d, np.full(len(d), 1e-3), np.full(len(d), 0.5), np.full(len(d), 2.0)])
    model.pair_solref[:] = -d[:, None] * np.array([1 / constant**2, 2 / constant])
    model.pair_solreffriction[:] = model.pair_solref * np.array([1, GLIDE])


def _apart(u: Float) -> float:
    """The largest length of rows (n, 3)."""
    return float(np.sqrt((u**2).sum(1).max(initial=0.0)))


def as_text(values: Float) -> str:
    """Numbers as an attribute of MuJoCo's XML, every digit kept."""
    return " ".join(repr(float(v)) for v in values)


def mujoco_module() -> ModuleType:
    """The simulator, or an error that says how to get it."""
    try:
        return importlib.import_module("mujoco")
    except ImportError:
        remedy = "pip install -e '.[bench]'"
        raise HoldfastError(message("referee mujoco", "MuJoCo is not installed", remedy)) from None
