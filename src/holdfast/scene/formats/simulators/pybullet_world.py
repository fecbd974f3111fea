"""Scenes from a running PyBullet simulation.

Bullet multiplies the two coefficients of friction of a pair. PyBullet tells of everything that counts but collision
filters, the shapes of meshes that are not convex, and whether the motor of a joint is on: only the torque that it
needed in the last step, which is zero as well for one that had nothing to hold.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked_mapping, checked_truth
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import GeometryError, SceneError, located, message, nearest_of
from holdfast.base.rigid import pose_from
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Compound, Inertial, Solid, as_shape
from holdfast.scene.formats.links import BodyPiece, plane_frame
from holdfast.scene.formats.simulators import simulated
from holdfast.scene.formats.simulators.simulated import JointState, Link, SimulatedJoint, cached_shape
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.friction import Friction
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Sphere

MESH, PLANE = 5, 6  # pybullet.GEOM_MESH, pybullet.GEOM_PLANE
FIXED = 4  # pybullet.JOINT_FIXED
SOFT = 3  # bodies that getDynamicsInfo calls soft
MOST_FRICTION = 10.0  # to which Bullet limits a pair's coefficient
BASE = -1  # number of the base among the links of a body


class Dynamics(NamedTuple):
    """What getDynamicsInfo tells of a link, in its order."""

    mass: float
    friction: float
    moments: Any
    com: Any
    axes: Any
    restitution: float
    rolling: float
    spinning: float
    damping: float
    stiffness: float
    kind: int
    margin: float


def from_pybullet(
    client: Any,  # noqa: ANN401 - PyBullet has no types
    *,
    rigid: bool = False,
    shapes: Mapping[str, Any] | None = None,
    name: str = "",
) -> Scene:
    """Return the scene of a PyBullet simulation as it is now.

    ``client`` is a ``pybullet_utils.bullet_client.BulletClient``, the module ``pybullet`` itself for its first
    connection, or the number that ``pybullet.connect`` returned. Frames, masses, centres of mass and inertias are
    PyBullet's. Bodies without mass are fixed. Links that hang on a fixed base by joints whose motors carried something
    in the last step are fixed where they are. A body has the name of its file, with its number if that is not unique,
    or ``body 3``; other links than the base are ``body 3/arm``. Friction of a pair is the product of both coefficients,
    at most 10.

    With ``rigid=True``, bodies that are connected by other joints or constraints are one rigid body, fixed if one of
    them is; otherwise such a connection raises SceneError. ``shapes`` are those of links, by name and in the frame of
    the link, which PyBullet does not tell: meshes that are not convex, or of several pieces. Without them such a mesh
    raises SceneError, and so do soft bodies. docs/from/pybullet.md says what is used and what is ignored, and the
    scene's ``notes`` in this case.
    """
    bullet = _functions(client)
    given = {} if shapes is None else dict(checked_mapping(shapes, "shapes", '{"body 3": hf.Box((1, 1, 1))}'))
    world = _World(bullet)
    world.add_colliders(given)
    bodies, _, notes = simulated.bodies_of(world.links, world.joints, rigid=checked_truth(rigid, "rigid"))
    engine = bullet.getPhysicsEngineParameters()
    gravity = [engine[f"gravityAcceleration{axis}"] for axis in "XYZ"]
    pairs = {pair: min(mu, MOST_FRICTION) for pair, mu in world.surfaces.pairs().items()}
    return Scene(bodies, Friction(pairs=pairs), gravity, name, notes=[*world.notes(), *notes])


def _functions(client: Any) -> Any:  # noqa: ANN401
    """Return an object with PyBullet's functions for a client; only a number of one needs PyBullet itself."""
    if isinstance(client, int) and not isinstance(client, bool):
        import pybullet

        names = [each for each in dir(pybullet) if each.startswith("get") and each != "getAPIVersion"]
        return SimpleNamespace(
            **{each: functools.partial(getattr(pybullet, each), physicsClientId=client) for each in names}
        )
    if not hasattr(client, "getCollisionShapeData"):
        remedy = "needs a BulletClient, the module pybullet, or the number of a connection"
        raise SceneError(message("from_pybullet", f"got {quoted(client)}", remedy))
    return client


class _World:
    """The links and joints of all bodies of a simulation."""

    def __init__(self, bullet: Any) -> None:  # noqa: ANN401
        self.bullet = bullet
        self.surfaces = Surfaces("product")
        self.links: list[Link] = []
        self.joints: list[SimulatedJoint] = []
        self.number: dict[tuple[int, int], int] = {}  # of a link, by the number of its body and its own there
        self.margins: list[float] = []
        self.shapeless: list[str] = []
        self.rolling = False
        uids = [bullet.getBodyUniqueId(k) for k in range(bullet.getNumBodies())]
        names = [bullet.getBodyInfo(uid)[1].decode(errors="replace") for uid in uids]
        for uid, own in zip(uids, names, strict=True):
            self._add(uid, own if own and names.count(own) == 1 else f"{own or 'body'} {uid}")
        for k in range(bullet.getNumConstraints()):
            uid = bullet.getConstraintUniqueId(k)
            first, link, second, other = bullet.getConstraintInfo(uid)[:4]
            ends = (self.number[first, link], self.number.get((second, other)))  # of another body, or of the world
            self.joints.append(SimulatedJoint(f"constraint {uid}", ends, JointState.LOOSE))

    def add_colliders(self, given: Mapping[str, Any]) -> None:
        """Add the shapes of all links, of which some are ``given`` by the names of links."""
        names = [link.name for link in self.links]
        for key in given:
            if key not in names:
                raise SceneError(message("shapes", f"no link is named {quoted(key)}", nearest_of(key, names)))
        for (uid, k), number in self.number.items():
            link = self.links[number]
            with located(quoted(link.name)):
                dynamics = Dynamics(*self.bullet.getDynamicsInfo(uid, k))
                link.colliders = self._colliders(uid, k, dynamics, given.get(link.name))
            if link.fixed and not link.colliders:
                self.shapeless.append(link.name)
            self.rolling |= bool(link.colliders) and (dynamics.rolling > 0 or dynamics.spinning > 0)

    def notes(self) -> list[str]:
        """Return notes on what was taken for granted or left out."""
        found = [
            "friction: of two surfaces it is their product; PyBullet does not tell collision filters: all may touch"
        ]
        if any(joint.hold is JointState.LOOSE for joint in self.joints):
            found.append("PyBullet does not tell whether a motor without a torque is on: such joints are rigid= alone")
        if self.margins:
            gap = f"{2.2 * max(self.margins):.2g}"
            text = f"meshes are their convex hulls, with Bullet's margin of {max(self.margins):g} m around them"
            found.append(f"{text}, so that they rest apart: assemble with gap={gap}")
        if self.shapeless:
            found.append(f"left out, as PyBullet tells no shape of theirs: {listed(self.shapeless)}")
        if self.rolling:
            found.append("ignored: rolling and spinning friction, so bodies hold less than in PyBullet")
        return found

    def _add(self, uid: int, name: str) -> None:
        """Add the links and joints of a body."""
        bullet = self.bullet
        count = bullet.getNumJoints(uid)
        position, turn = bullet.getBasePositionAndOrientation(uid)
        self._link(uid, BASE, name, _pose(position, turn))
        for k in range(count):
            info = bullet.getJointInfo(uid, k)
            state = bullet.getLinkState(uid, k, computeForwardKinematics=True)
            self._link(uid, k, f"{name}/{info[12].decode(errors='replace')}", _pose(state[0], state[1]))
        for k in range(count):
            info = bullet.getJointInfo(uid, k)
            ends = (self.number[uid, info[16]], self.number[uid, k])
            carries = any(bullet.getJointStateMultiDof(uid, k)[3]) if info[2] != FIXED else False
            hold = JointState.RIGID if info[2] == FIXED else JointState.HELD if carries else JointState.LOOSE
            self.joints.append(SimulatedJoint(info[1].decode(errors="replace"), ends, hold))

    def _link(self, uid: int, k: int, name: str, principal: Float) -> None:
        """Add a link, of which ``principal`` (4, 4) is the frame of its centre and axes of inertia in the world."""
        with located(quoted(name)):
            dynamics = Dynamics(*self.bullet.getDynamicsInfo(uid, k))
            if dynamics.kind == SOFT:
                raise SceneError(message("body", "is soft", "needs rigid bodies alone"))
            own = _pose(dynamics.com, dynamics.axes)
            still = k == BASE and dynamics.mass == 0
            inertial = None
            if dynamics.mass > 0:
                inertial = Inertial(dynamics.mass, np.zeros(3), np.diag(dynamics.moments)).seen(own)
            self.number[uid, k] = len(self.links)
            self.links.append(Link(name, principal @ simulated.relative(np.eye(4), own), still, inertial))

    def _colliders(self, uid: int, k: int, dynamics: Dynamics, given: Any) -> list[BodyPiece]:  # noqa: ANN401
        material = self.surfaces.material(float(dynamics.friction))
        own = _pose(dynamics.com, dynamics.axes)
        if given is not None:
            shape = as_shape(given, "shapes")
            if isinstance(shape, Compound):
                return [BodyPiece(part.shape, part.pose, material) for part in shape.parts]
            return [BodyPiece(shape, np.eye(4), material)]
        with foreign("shape", "PyBullet does not tell it", "load it without useMaximalCoordinates, or give shapes="):
            shapes_told = self.bullet.getCollisionShapeData(uid, k)
        meshes = sum(each[2] == MESH for each in shapes_told)
        found = []
        for each in shapes_told:
            kind, sizes, pose = each[2], each[3], own @ _pose(each[5], each[6])
            if kind == MESH:
                shape, pose = self._mesh(uid, k, meshes), own
                self.margins.append(float(dynamics.margin))
            elif kind == PLANE:
                shape, pose = HalfSpace(), pose @ plane_frame(np.array(sizes))
            else:
                shape = _simple(kind, sizes)
            found.append(BodyPiece(shape, pose, material))
        return found

    def _mesh(self, uid: int, k: int, meshes: int) -> Solid:
        """Return the convex hull of the only mesh of a link, in the frame of its centre of mass."""
        count, vertices = self.bullet.getMeshData(uid, k)
        if meshes == 1 and count:
            return simulated.hull(np.array(vertices))
        problem = "PyBullet tells the corners of all of its meshes together" if count else "its mesh is not convex"
        raise GeometryError(message("shape", problem, "give its shape in the frame of the link: shapes={name: shape}"))


def _simple(kind: int, sizes: Any) -> Solid:  # noqa: ANN401
    match kind:
        case 2:
            return cached_shape(Sphere, sizes[0])
        case 3:
            return cached_shape(Box, tuple(sizes))
        case 4:
            return cached_shape(Cylinder, sizes[1], sizes[0])
        case 7:
            return cached_shape(Capsule, sizes[1], sizes[0])
    problem = f"is of type {kind}"
    remedy = "needs a sphere, box, cylinder, mesh, plane or capsule, or give shapes="
    raise GeometryError(message("shape", problem, remedy))


def _pose(position: Any, turn: Any) -> Float:  # noqa: ANN401
    x, y, z, w = turn
    return pose_from(np.array(position), np.array([w, x, y, z]))
