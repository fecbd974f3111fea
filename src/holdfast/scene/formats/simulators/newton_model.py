"""Scenes from a model of the Newton physics engine and its state.

Newton's solvers combine the two coefficients of friction of a pair in different ways, and the model does not say which
solver it is for.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool, Float, checked_truth, checked_word
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.rigid import pose_from
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Inertial, Solid
from holdfast.scene.formats.links import BodyPiece
from holdfast.scene.formats.simulators import simulated
from holdfast.scene.formats.simulators.simulated import JointState, Link, SimulatedJoint, cached_shape
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Sphere

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH, CONE, CONVEX = range(1, 11)  # newton.GeoType
KINDS = ("plane", "height field", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "cone", "convex mesh")
COLLIDES = 1 << 1  # newton.ShapeFlags.COLLIDE_SHAPES
KINEMATIC = 1 << 1  # newton.BodyFlags.KINEMATIC
BALL, FIXED, FREE = 2, 3, 4  # newton.JointType
DRIVES = (1, 3)  # newton.JointTargetMode: position, position and velocity
GLOBAL = -1  # the world of what all worlds share

# How each solver combines two coefficients; without a solver it is the rule with the least result
RULES = {
    "xpbd": "mean",
    "semiimplicit": "mean",
    "featherstone": "mean",
    "steel": "mean",
    "kamino": "mean",
    "mujoco": "largest",
    "vbd": "geometric mean",
}


def from_newton(
    model: Any,  # noqa: ANN401 - Newton is not imported
    state: Any,  # noqa: ANN401
    world: int | None = None,
    *,
    solver: Any = None,  # noqa: ANN401
    rigid: bool = False,
    name: str = "",
) -> Scene:
    """Return the scene of a Newton model ``newton.Model`` in the state ``newton.State``, with the poses ``body_q``.

    ``world`` is the number of one world, where the model has several; what all worlds share is part of each. Frames,
    masses, centres of mass and inertias are Newton's, in its single precision. Static and kinematic bodies and those
    without mass are fixed, and so is what hangs on them by joints whose every axis has a drive that holds a position.

    ``solver`` decides how the friction of a pair follows from its two coefficients. It is the solver itself or its
    name: "xpbd", "semiimplicit", "featherstone", "steel" and "kamino" take the mean, "vbd" the geometric mean, and
    "mujoco" the larger one. Without it the friction is the geometric mean, the least of these. With "mujoco" meshes are
    their convex hulls, otherwise as they are.

    With ``rigid=True``, moving bodies that are connected by joints are one rigid body; otherwise such a joint raises
    SceneError. docs/from/isaac_newton.md says what is used and what is ignored, and the scene's ``notes`` in this case.
    """
    if not hasattr(model, "shape_body") or not hasattr(state, "body_q"):
        problem = f"got a {type(model).__name__} and a {type(state).__name__}"
        raise SceneError(message("from_newton", problem, "needs newton.Model and newton.State"))
    number = simulated.world_of(world, int(getattr(model, "world_count", 1)), "model")
    used = _name_of(solver)
    read = _NewtonWorld(model, state, number, hulls=used == "mujoco")
    surfaces = Surfaces(_rule(model, used))
    read.add_colliders(surfaces)
    joints = read.joints()
    bodies, apart, notes = simulated.bodies_of(
        read.links, joints, rigid=checked_truth(rigid, "rigid"), touching=read.touching
    )
    gravity = np.asarray(_array(model.gravity), dtype=np.float64).reshape(-1, 3)
    vector = gravity[number if number < len(gravity) else 0]
    said = f"friction: of two surfaces it is their {surfaces.rule}" + (
        "" if used else ", the least of Newton's solvers; solver= says which one"
    )
    return Scene(bodies, surfaces.table(), vector, name, apart, [said, *read.notes(), *notes])


def _array(value: Any) -> Any:  # noqa: ANN401 - an array of Warp, or one of NumPy
    return np.asarray(value.numpy() if hasattr(value, "numpy") else value)


def _name_of(solver: Any) -> str:  # noqa: ANN401
    """Return the name of a solver in small letters, without the word itself; "" for None."""
    if solver is None:
        return ""
    word = solver if isinstance(solver, str) else type(solver).__name__
    return checked_word(word.lower().replace("_", "").replace("-", "").removeprefix("solver"), RULES, "solver")


def _rule(model: Any, solver: str) -> str:  # noqa: ANN401
    """Return the rule of a solver; where priorities decide in MuJoCo, the least of both coefficients."""
    priority = getattr(getattr(model, "mujoco", None), "geom_priority", None)
    if solver == "mujoco" and priority is not None and _array(priority).any():
        return "least"
    return RULES.get(solver, "geometric mean")


class _NewtonWorld:
    """The bodies of one world of a model, as links."""

    def __init__(self, model: Any, state: Any, world: int, *, hulls: bool) -> None:  # noqa: ANN401
        self.model, self.state, self.hulls = model, state, hulls
        self.world = (GLOBAL, world)
        self.links: list[Link] = []
        self.number: dict[int, int] = {}  # of the link of each body
        self.body = _array(model.shape_body)
        self.kind = _array(model.shape_type)
        self.margin = 0.0
        if model.body_count:
            self._add_bodies()

    def _add_bodies(self) -> None:
        model = self.model
        poses, masses, coms = (_array(each) for each in (self.state.body_q, model.body_mass, model.body_com))
        inertias, loose = _array(model.body_inertia), _array(model.body_inv_mass) > 0
        kinematic = (_array(model.body_flags) & KINEMATIC) != 0
        for b in np.flatnonzero(np.isin(_array(model.body_world), self.world)).tolist():
            self.number[b] = len(self.links)
            still = bool(kinematic[b]) or not loose[b]
            inertial = Inertial(float(masses[b]), coms[b].astype(np.float64), inertias[b].astype(np.float64))
            self.links.append(Link(model.body_label[b], _pose(poses[b]), still, None if still else inertial))

    def add_colliders(self, surfaces: Surfaces) -> None:
        """Add the shapes that collide to their links; each shape of the world is a link of its own."""
        model = self.model
        friction, poses = _array(model.shape_material_mu), _array(model.shape_transform)
        margins = _array(model.shape_margin)
        collides = ((_array(model.shape_flags) & COLLIDES) != 0) & (_array(model.shape_collision_group) != 0)
        here = np.isin(_array(model.shape_world), self.world)
        for s in np.flatnonzero(collides & here).tolist():
            with located(f"shape {quoted(model.shape_label[s])}"):
                shape = HalfSpace() if self.kind[s] == PLANE else self._solid(s)
            pose, owner = _pose(poses[s]), int(self.body[s])
            self.margin = max(self.margin, float(margins[s]))
            if owner < 0:
                self.links.append(Link(model.shape_label[s], pose, True))
                pose, link = np.eye(4), self.links[-1]
            else:
                link = self.links[self.number[owner]]
            link.colliders.append(BodyPiece(shape, pose, surfaces.material(float(friction[s])), s))

    def _solid(self, s: int) -> Solid:
        """Return a shape other than a plane."""
        kind, scale = int(self.kind[s]), _array(self.model.shape_scale)[s].astype(np.float64)
        x, y, z = scale.tolist()
        match kind:
            case 3:
                return cached_shape(Sphere, x)
            case 4:
                return cached_shape(Capsule, x, 2 * y)
            case 5:
                return cached_shape(Ellipsoid, (x, y, z))
            case 6 if z in (0.0, x):  # any other number is the radius of a barrel
                return cached_shape(Cylinder, x, 2 * y)
            case 7:
                return cached_shape(Box, (2 * x, 2 * y, 2 * z))
            case 8 | 10:
                source = self.model.shape_source[s]
                vertices = np.asarray(source.vertices, dtype=np.float64)
                convex = kind == CONVEX or self.hulls
                return (
                    simulated.hull(vertices * scale)
                    if convex
                    else simulated.mesh_as_given(vertices, source.indices, scale)
                )
        problem = f"is a {KINDS[kind - 1]}" if 0 < kind <= len(KINDS) else f"is of type {kind}"
        raise GeometryError(
            message("geometry", problem, "needs a plane, box, ball, capsule, straight cylinder or mesh")
        )

    def joints(self) -> list[SimulatedJoint]:
        """Return the joints that hold; a free joint is none."""
        model, found = self.model, []
        if not model.joint_count:
            return []
        kinds, starts = _array(model.joint_type), _array(model.joint_qd_start)
        parents, children = _array(model.joint_parent), _array(model.joint_child)
        modes = _array(model.joint_target_mode)
        driven = np.isin(modes, DRIVES) & (_array(model.joint_target_ke) > 0)
        for j in np.flatnonzero(_array(model.joint_enabled)).tolist():
            if int(children[j]) not in self.number or kinds[j] == FREE:
                continue
            axes = driven[starts[j] : starts[j + 1]]
            hold = JointState.HELD if kinds[j] < BALL or kinds[j] > FREE else JointState.LOOSE
            hold = hold if axes.all() else JointState.LOOSE
            hold = JointState.RIGID if not len(axes) else hold
            ends = (self.number.get(int(parents[j])), self.number[int(children[j])])
            found.append(SimulatedJoint(model.joint_label[j], ends, hold))
        return found

    def touching(self, a: Sequence[int], b: Sequence[int]) -> Bool:
        """Tell which shapes may touch, as Newton's broad phase does: by groups, and by pairs that are left out."""
        group = _array(self.model.shape_collision_group)
        first, second = np.asarray(a, dtype=np.int64)[:, None], np.asarray(b, dtype=np.int64)[None]
        g, h = group[first], group[second]
        may = (g != 0) & (h != 0) & np.where(g > 0, (g == h) | (h < 0), g != h)
        filters = set(map(tuple, self.model.shape_collision_filter_pairs))
        apart = [[(min(s, t), max(s, t)) in filters for t in b] for s in a]
        return np.asarray(may & ~np.array(apart, dtype=bool).reshape(may.shape))

    def notes(self) -> list[str]:
        """Return notes on what was left out, and on what Newton's contacts do otherwise."""
        model, found = self.model, []
        here = np.isin(self.kind, (MESH, CONVEX)) & np.isin(_array(model.shape_world), self.world)
        if self.hulls and here.any():
            found.append("meshes are their convex hulls, as MuJoCo collides them")
        if self.margin > 0:
            gap = f"{2.2 * self.margin:.2g}"
            found.append(f"ignored: margins of {self.margin:g} m, by which bodies rest apart: assemble with gap={gap}")
        if getattr(model, "particle_count", 0):
            found.append(f"left out: {model.particle_count} particles, of which cloth and soft bodies are made")
        enabled = getattr(getattr(model, "mujoco", None), "equality_constraint_enabled", None)
        if enabled is not None and _array(enabled).any():
            found.append(f"ignored, though they act: {int(_array(enabled).sum())} equality constraints")
        pushed = set(np.nonzero(_array(self.state.body_f))[0].tolist()) if self.number else set()
        acting = [self.links[link] for b, link in self.number.items() if b in pushed]
        if names := [link.name for link in acting if not link.fixed]:
            found.append(f"ignored, though it acts: applied forces (body_f) of {listed(names)}")
        return found


def _pose(transform: Any) -> Float:  # noqa: ANN401
    """Return the pose (4, 4) of one of Newton's transforms: a position, and a quaternion with its real part last."""
    px, py, pz, x, y, z, w = np.asarray(transform, dtype=np.float64).tolist()
    return pose_from(np.array([px, py, pz]), np.array([w, x, y, z]))
