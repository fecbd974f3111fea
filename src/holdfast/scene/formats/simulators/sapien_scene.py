"""Scenes from a running SAPIEN simulation.

SAPIEN's engine is PhysX, which takes the mean of the two coefficients of friction of a pair.
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
from holdfast.scene.formats.links import BodyPiece
from holdfast.scene.formats.simulators import simulated
from holdfast.scene.formats.simulators.simulated import JointState, Link, SimulatedJoint, cached_shape
from holdfast.scene.formats.surfaces import Surfaces
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Sphere

# A plane of PhysX has its normal along x, and capsules and cylinders their axis: the frames in which it is z
X_TO_Z = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
UPRIGHT = ("Plane", "Capsule", "Cylinder")
IDENTITY = 0xFFFF  # the bits of the fourth collision group that count


def from_sapien(
    simulation: Any,  # noqa: ANN401 - SAPIEN is not imported
    *,
    rigid: bool = False,
    name: str = "",
) -> Scene:
    """Return the scene of a SAPIEN scene ``sapien.Scene`` as it is now.

    Frames, masses, centres of mass and inertias are those of the entities, in PhysX's single precision. Static and
    kinematic entities are fixed, and so is what hangs on a fixed link by joints with a drive of some stiffness. Bodies
    have the names of their entities; those of articulations are ``robot/arm``. Friction of a pair is the mean of both
    static coefficients, the rule of PhysX that SAPIEN leaves as it is. Poses of a simulation on a GPU are those of the
    last ``sync_poses_gpu_to_cpu``.

    With ``rigid=True``, moving bodies that are connected by joints or drives are one rigid body, and bodies with locked
    axes are fixed; otherwise such a connection raises SceneError. So does a moving body without gravity. Convex meshes
    are their hulls, others as they are; dynamic friction and rest offsets are ignored, with notes. ManiSkill has such
    scenes in ``env.unwrapped.scene.sub_scenes``.
    """
    if not hasattr(simulation, "entities") or not hasattr(simulation, "physx_system"):
        remedy = "needs a sapien.Scene; ManiSkill has them in env.unwrapped.scene.sub_scenes"
        raise SceneError(message("from_sapien", f"got a {type(simulation).__name__}", remedy))
    read = _SapienEntities(simulation)
    bodies, apart, notes = simulated.bodies_of(
        read.links, read.joints, rigid=checked_truth(rigid, "rigid"), touching=read.touching
    )
    gravity = np.asarray(simulation.physx_system.config.gravity, dtype=np.float64)
    return Scene(bodies, read.surfaces.table(), gravity, name, apart, [*read.notes(), *notes])


class _SapienEntities:
    """The rigid bodies of a scene as links, and what joins them."""

    def __init__(self, scene: Any) -> None:  # noqa: ANN401
        self.surfaces = Surfaces("mean")
        self.links: list[Link] = []
        self.joints: list[SimulatedJoint] = []
        self.groups: list[list[int]] = []  # collision groups of each collider, by its number
        self.number: dict[Any, int] = {}  # of the link of each component
        self.hulls = False
        self.kinetic: list[str] = []  # links whose dynamic friction is another than the static one
        self.rest = 0.0
        found = [(entity, component) for entity in scene.entities for component in entity.components]
        for k, (entity, component) in enumerate(found):
            if hasattr(component, "collision_shapes") and component.is_enabled:
                self._add(k, entity, component)
        for _, component in found:
            if component in self.number and hasattr(component, "joint"):
                self._hang(component)
            elif hasattr(component, "pose_in_parent") and not hasattr(component, "collision_shapes"):
                own = [self.number[each] for each in component.entity.components if each in self.number]
                other = component.get_parent()
                kind = type(component).__name__.removeprefix("Physx").removesuffix("Component").lower()
                if own:
                    self.joints.append(SimulatedJoint(kind, (self.number.get(other), own[0]), JointState.LOOSE))

    def _add(self, k: int, entity: Any, component: Any) -> None:  # noqa: ANN401
        """Add a rigid component as a link."""
        name = entity.name or component.name or f"entity {k}"
        if hasattr(component, "joint") and component.articulation.name:
            name = f"{component.articulation.name}/{name}"
        with located(quoted(name)):
            still = not hasattr(component, "mass") or bool(getattr(component, "kinematic", False))
            link = Link(name, _pose(entity.pose), still)
            self.number[component] = len(self.links)
            if not still:
                if component.disable_gravity:
                    raise SceneError(message("gravity", "is off", "needs bodies with their whole weight"))
                axes = _pose(component.cmass_local_pose)
                moments = np.diag(np.asarray(component.inertia, dtype=np.float64))
                link.inertial = Inertial(float(component.mass), np.zeros(3), moments).seen(axes)
                if any(getattr(component, "locked_motion_axes", ())):
                    self.joints.append(SimulatedJoint("locked axes", (None, self.number[component]), JointState.LOOSE))
            self.links.append(link)
            link.colliders = [self._collider(shape, name) for shape in component.collision_shapes]

    def _collider(self, shape: Any, name: str) -> BodyPiece:  # noqa: ANN401
        kind = type(shape).__name__.removeprefix("PhysxCollisionShape")
        pose = _pose(shape.local_pose)
        material = shape.physical_material
        if material.dynamic_friction != material.static_friction and name not in self.kinetic:
            self.kinetic.append(name)
        self.rest = max(self.rest, float(shape.rest_offset))
        self.hulls |= kind == "ConvexMesh"
        self.groups.append([int(group) for group in shape.collision_groups])
        solid = HalfSpace() if kind == "Plane" else _solid(kind, shape)
        label = self.surfaces.material(float(material.static_friction))
        return BodyPiece(solid, pose @ X_TO_Z if kind in UPRIGHT else pose, label, len(self.groups) - 1)

    def _hang(self, link: Any) -> None:  # noqa: ANN401
        """Add the joint between a link of an articulation and its parent, or that of a root that is fixed."""
        joint = link.joint
        parent = None if link.is_root else self.number.get(link.parent)
        if joint.type == "fixed":
            hold = JointState.RIGID
        elif link.is_root:
            return
        else:
            hold = JointState.HELD if joint.stiffness > 0 else JointState.LOOSE
        self.joints.append(SimulatedJoint(joint.name or "joint", (parent, self.number[link]), hold))

    def touching(self, a: Sequence[int], b: Sequence[int]) -> Bool:
        """Tell which colliders may touch, by SAPIEN's four groups of each."""
        first, second = (np.array([self.groups[k] for k in each], dtype=np.int64).reshape(-1, 4) for each in (a, b))
        kind, affine, ignored, own = (first[:, None, k] for k in range(4))
        kinds, affines, ignores, owns = (second[None, :, k] for k in range(4))
        meet = ((kind & affines) | (affine & kinds)) != 0
        same = ((ignored & ignores) != 0) & ((own & IDENTITY) == (owns & IDENTITY))
        return np.asarray(meet & ~same)

    def notes(self) -> list[str]:
        """Return notes on what was taken for granted or left out."""
        found = ["friction: of two surfaces it is the mean of their static coefficients"]
        if self.kinetic:
            found.append(f"ignored: dynamic friction, another than the static one, of {listed(self.kinetic)}")
        if self.hulls:
            found.append("meshes are their convex hulls, as PhysX collides them")
        if self.rest > 0:
            gap = f"{2.2 * self.rest:.2g}"
            found.append(
                f"ignored: rest offsets of {self.rest:g} m, by which bodies rest apart: assemble with gap={gap}"
            )
        return found


def _solid(kind: str, shape: Any) -> Solid:  # noqa: ANN401
    match kind:
        case "Box":
            return cached_shape(Box, tuple((2 * np.asarray(shape.half_size, dtype=np.float64)).tolist()))
        case "Sphere":
            return cached_shape(Sphere, float(shape.radius))
        case "Capsule":
            return cached_shape(Capsule, float(shape.radius), 2 * float(shape.half_length))
        case "Cylinder":
            return cached_shape(Cylinder, float(shape.radius), 2 * float(shape.half_length))
        case "ConvexMesh" | "TriangleMesh":
            scale = np.asarray(shape.scale, dtype=np.float64)
            vertices = np.asarray(shape.vertices, dtype=np.float64)
            return (
                simulated.hull(vertices * scale)
                if kind == "ConvexMesh"
                else simulated.mesh_as_given(vertices, shape.triangles, scale)
            )
    raise GeometryError(message("collision shape", f"is a {kind}", "needs a shape of PhysX that SAPIEN has"))


def _pose(pose: Any) -> Float:  # noqa: ANN401 - a sapien.Pose
    return pose_from(np.asarray(pose.p, dtype=np.float64), np.asarray(pose.q, dtype=np.float64))
