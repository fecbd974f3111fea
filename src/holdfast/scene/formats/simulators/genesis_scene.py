"""Scenes from a running Genesis simulation.

Genesis takes the larger one of the two coefficients of friction of a pair, and never less than 0.01.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool, Float, checked_truth
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.rigid import pose_from
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Inertial, Solid
from holdfast.scene.formats.links import BodyPiece, plane_frame
from holdfast.scene.formats.simulators import simulated
from holdfast.scene.formats.simulators.simulated import JointState, Link, SimulatedJoint, cached_shape
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.friction import Friction
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Sphere

PLANE, MESH = 0, 6  # gs.GEOM_TYPE; terrains are 7
FIXED, FREE = 0, 4  # gs.JOINT_TYPE
POSITION = 0  # gs.CTRL_MODE
LEAST_FRICTION = 0.01  # below which Genesis takes no pair


def from_genesis(
    simulation: Any,  # noqa: ANN401 - Genesis is not imported
    world: int | None = None,
    *,
    rigid: bool = False,
    name: str = "",
) -> Scene:
    """Return the scene of a Genesis scene ``genesis.Scene`` that is built, as it is now.

    ``world`` is the number of one environment, where the scene has several. Frames are those of Genesis's links, which
    ``get_pos`` and ``get_quat`` give; masses, centres of mass and inertias are its own, in the precision of
    ``genesis.init``. Links that are fixed to the world are fixed, and so is what hangs on them by joints under position
    control. Bodies have the names of their entities; other links than the first are ``arm/link``. Friction of a pair is
    the larger coefficient, at least 0.01.

    With ``rigid=True``, moving bodies that are connected by joints are one rigid body; otherwise such a joint raises
    SceneError. So does gravity compensation. A joint is under position control from the first
    ``control_dofs_position`` on. Meshes are the convex pieces that Genesis makes of them. Entities that are not rigid,
    equality constraints, torsional and rolling friction are left out, with notes.
    """
    if not hasattr(simulation, "rigid_solver") or not hasattr(simulation, "entities"):
        raise SceneError(message("from_genesis", f"got a {type(simulation).__name__}", "needs a genesis.Scene"))
    if not simulation.is_built:
        raise SceneError(message("from_genesis", "the scene is not built", "call scene.build() first"))
    number = simulated.world_of(world, int(simulation.n_envs), "scene")
    read = _GenesisEntities(simulation, number if simulation.n_envs else None)
    bodies, apart, notes = simulated.bodies_of(
        read.links, read.joints, rigid=checked_truth(rigid, "rigid"), touching=read.touching
    )
    pairs = {pair: max(mu, LEAST_FRICTION) for pair, mu in read.surfaces.pairs().items()}
    gravity = read.one(simulation.rigid_solver.get_gravity())
    return Scene(bodies, Friction(pairs=pairs), gravity, name, apart, [*read.notes(), *notes])


class _GenesisEntities:
    """The links of all rigid entities of one environment."""

    def __init__(self, scene: Any, world: int | None) -> None:  # noqa: ANN401
        self.world, self.solver = world, scene.rigid_solver
        self.surfaces = Surfaces("largest")
        self.links: list[Link] = []
        self.joints: list[SimulatedJoint] = []
        self.masks: list[tuple[int, int, int, bool]] = []  # contype, conaffinity, entity and whether for itself alone
        self.number: dict[int, int] = {}  # of a link here, by its own
        self.others: list[str] = []
        self.equalities = 0
        self.hulls = self.resists = False
        self.modes = _array(self.solver.dyn_state.dofs.ctrl_mode.to_numpy()) if scene.entities else np.zeros(0)
        for entity in scene.entities:
            if hasattr(entity, "links") and hasattr(entity, "geoms"):
                if entity.gravity_compensation and not all(link.is_fixed for link in entity.links):
                    problem = f"gravity_compensation lifts {quoted(entity.name)}"
                    raise SceneError(message("gravity", problem, "needs bodies with their whole weight: give 0"))
                self.equalities += int(entity.n_equalities)
                for k, link in enumerate(entity.links):
                    name = str(entity.name) if k == 0 else f"{entity.name}/{link.name}"
                    with located(quoted(name)):
                        self._link(link, name)
                for link in entity.links:
                    if not link.is_fixed:
                        ends = (self.number.get(int(link.parent_idx)), self.number[int(link.idx)])
                        joints = [joint for joint in link.joints if joint.type != FIXED]
                        if not joints:
                            self.joints.append(SimulatedJoint("fixed", ends, JointState.RIGID))
                        for joint in joints:
                            if joint.type != FREE:
                                modes = self.modes[joint.dof_start : joint.dof_end, self.world or 0]
                                state = JointState.HELD if (modes == POSITION).all() else JointState.LOOSE
                                self.joints.append(SimulatedJoint(joint.name, ends, state))
            else:
                self.others.append(str(entity.name))

    def one(self, value: Any) -> Float:  # noqa: ANN401 - a tensor of one environment or of all
        """Return the numbers of this environment."""
        array = np.asarray(_array(value), dtype=np.float64)
        return array if self.world is None else np.asarray(array[self.world])

    def _link(self, link: Any, name: str) -> None:  # noqa: ANN401
        """Add a link; Genesis may keep its shapes and its centre of mass in a frame of its own, which stands apart."""
        description = link.desc
        own = pose_from(_array(description.offset_pos), _array(description.offset_quat))
        pose = pose_from(self.one(link.get_pos()), self.one(link.get_quat()))
        still = bool(link.is_fixed)
        found = Link(name, pose, still)
        if not still:
            axes = pose_from(self._of_link(self.solver.get_links_COM(link.idx)), _array(description.inertial_quat))
            tensor = self._of_link(self.solver.get_links_inertia(link.idx))
            mass = float(self._of_link(self.solver.get_links_mass(link.idx)))
            found.inertial = Inertial(mass, np.zeros(3), tensor).seen(own @ axes)
        self.number[int(link.idx)] = len(self.links)
        self.links.append(found)
        for geom in link.geoms:
            place = own @ pose_from(_array(geom.init_pos), _array(geom.init_quat))
            shape = HalfSpace() if geom.type == PLANE else self._solid(geom)
            if geom.type == PLANE:
                place = place @ plane_frame(np.asarray(_array(geom.data), dtype=np.float64)[:3])
            entity = geom.entity
            mask = (int(geom.contype), int(geom.conaffinity), id(entity), bool(entity.is_local_collision_mask))
            self.masks.append(mask)
            material = self.surfaces.material(float(_array(geom.get_friction())))
            found.colliders.append(BodyPiece(shape, place, material, len(self.masks) - 1))
            self.resists |= bool(_array(geom.get_friction_torsional()) > 0 or _array(geom.get_friction_rolling()) > 0)

    def _of_link(self, value: Any) -> Float:  # noqa: ANN401
        """Return what the solver tells of one link in this environment; it may have one row for all environments."""
        array = np.asarray(_array(value), dtype=np.float64)
        each = self.world is not None and self.solver.is_links_info_batched
        return np.asarray(array[self.world][0] if each else array[0])

    def _solid(self, geom: Any) -> Solid:  # noqa: ANN401
        """Return the shape of a geom other than a plane."""
        kind = int(geom.type)
        x, y, z = np.asarray(_array(geom.data), dtype=np.float64)[:3].tolist()
        match kind:
            case 1:
                return cached_shape(Sphere, x)
            case 2:
                return cached_shape(Ellipsoid, (x, y, z))
            case 3:
                return cached_shape(Cylinder, x, y)
            case 4:
                return cached_shape(Capsule, x, y)
            case 5:
                return cached_shape(Box, (x, y, z))
        if kind < MESH:
            raise GeometryError(message("geom", f"is of type {kind}", "needs one of gs.GEOM_TYPE"))
        vertices = np.asarray(geom.init_verts, dtype=np.float64)
        if geom.is_convex:
            self.hulls = True
            return simulated.hull(vertices)
        return simulated.mesh_as_given(vertices, np.asarray(geom.init_faces))

    def touching(self, a: Sequence[int], b: Sequence[int]) -> Bool:
        """Tell which geoms may touch; masks of entities from MJCF and USD count within the entity alone."""
        may = np.ones((len(a), len(b)), dtype=bool)
        for i, (kind, affine, entity, local) in enumerate(self.masks[g] for g in a):
            for j, (kinds, affines, other, own) in enumerate(self.masks[h] for h in b):
                if entity == other or not (local or own):
                    may[i, j] = bool((kind & affines) | (kinds & affine))
        return may

    def notes(self) -> list[str]:
        """Return notes on what was taken for granted or left out."""
        found = ["friction: of two surfaces it is the larger one, at least 0.01"]
        if self.hulls:
            found.append("meshes are their convex hulls, or several convex pieces, as Genesis collides them")
        if self.others:
            found.append(f"left out, as it is not rigid: {listed(self.others)}")
        if self.equalities:
            found.append(f"ignored, though they act: {self.equalities} equality constraints")
        if self.resists:
            found.append("ignored: torsional and rolling friction, so bodies hold less than in Genesis")
        return found


def _array(value: Any) -> Any:  # noqa: ANN401 - a tensor of PyTorch, or an array
    return np.asarray(value.cpu() if hasattr(value, "cpu") else value)
