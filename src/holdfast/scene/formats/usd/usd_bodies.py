"""Rigid bodies of a USD stage, groups that joints hold together, excluded pairs, and what is not read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool
from holdfast.base.text import listed, one_line, quoted
from holdfast.scene.excluded import Excluded
from holdfast.scene.formats.links import BodyParts, Welded, kept_apart, not_read, weld
from holdfast.scene.formats.usd.stage import Stage
from holdfast.scene.formats.usd.usd_colliders import fail, number_of, value_of

RIGID, COLLIDER, FILTER = "PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsFilteredPairsAPI"
SHAPES = ("Cube", "Sphere", "Cylinder", "Cylinder_1", "Capsule", "Capsule_1", "Cone", "Plane", "Mesh")
# Properties that are read, or do not matter at rest; namespaces end with a colon and stand for all within them
KNOWN = frozenset((
    "size", "radius", "height", "axis", "points", "faceVertexCounts", "faceVertexIndices", "orientation", "extent",
    "width", "length", "radiusBottom", "radiusTop", "normals", "visibility", "purpose", "doubleSided", "proxyPrim",
    "subdivisionScheme", "interpolateBoundary", "faceVaryingLinearInterpolation", "triangleSubdivisionRule",
    "cornerIndices", "cornerSharpnesses", "creaseIndices", "creaseLengths", "creaseSharpnesses", "extentsHint",
    "velocities", "accelerations", "familyName", "elementType", "indices", "type",
    "xformOpOrder", "xformOp:", "primvars:", "material:", "collection:", "inputs:", "outputs:", "info:", "ui:",
    "semantic:", "semantics:", "omni:", "refinementEnableOverride", "refinementLevel", "userProperties:", "model:",
    "subsetFamily:", "skel:",
    "physics:rigidBodyEnabled", "physics:kinematicEnabled", "physics:collisionEnabled", "physics:approximation",
    "physics:mass", "physics:density", "physics:centerOfMass", "physics:diagonalInertia", "physics:principalAxes",
    "physics:staticFriction", "physics:dynamicFriction", "physics:restitution", "physics:velocity",
    "physics:angularVelocity", "physics:startsAsleep", "physics:simulationOwner", "physics:gravityDirection",
    "physics:gravityMagnitude", "physics:filteredPairs", "physics:filteredGroups", "physics:invertFilteredGroups",
    "physics:mergeGroup", "physics:body0", "physics:body1", "physics:jointEnabled", "physics:axis",
    "physics:localPos0", "physics:localPos1", "physics:localRot0", "physics:localRot1", "physics:lowerLimit",
    "physics:upperLimit", "physics:excludeFromArticulation", "physics:minDistance", "physics:maxDistance",
    "physics:coneAngle0Limit", "physics:coneAngle1Limit", "drive:", "limit:", "state:",
    "physxScene:", "physxArticulation:", "physxJoint:", "physxLimit:", "physxConvexHullCollision:",
    "physxConvexDecompositionCollision:", "physxTriangleMeshCollision:", "physxTriangleMeshSimplificationCollision:",
    "physxSDFMeshCollision:", "physxContactReport:", "physxCollision:contactOffset",
    "physxMaterial:frictionCombineMode", "physxMaterial:restitutionCombineMode", "physxMaterial:improvePatchFriction",
    "physxMaterial:dampingCombineMode", "physxRigidBody:disableGravity", "physxRigidBody:linearDamping",
    "physxRigidBody:angularDamping", "physxRigidBody:maxLinearVelocity", "physxRigidBody:maxAngularVelocity",
    "physxRigidBody:maxDepenetrationVelocity", "physxRigidBody:sleepThreshold", "physxRigidBody:retainAccelerations",
    "physxRigidBody:stabilizationThreshold", "physxRigidBody:solverPositionIterationCount",
    "physxRigidBody:solverVelocityIterationCount", "physxRigidBody:enableCCD", "physxRigidBody:enableSpeculativeCCD",
    "physxRigidBody:enableGyroscopicForces",
))  # fmt: skip
UNBREAKABLE = ("physics:breakForce", "physics:breakTorque")  # which do not matter while they are infinite
UNBROKEN = float(np.finfo(np.float32).max)  # which some programs write for infinity
# Kinds of prims that only look, and schemas of PhysX whose properties are looked at one by one
LOOKING = ("Shader", "NodeGraph", "Camera", "GeomSubset", "Skeleton", "SkelAnimation", "OmniGraph", "SpatialAudio")
LOOKING_ENDS = ("Light", "Settings", "Product", "Var")
SCHEMAS = frozenset((
    "PhysxRigidBodyAPI", "PhysxCollisionAPI", "PhysxMaterialAPI", "PhysxSceneAPI", "PhysxArticulationAPI",
    "PhysxJointAPI", "PhysxLimitAPI", "PhysxConvexHullCollisionAPI", "PhysxConvexDecompositionCollisionAPI",
    "PhysxTriangleMeshCollisionAPI", "PhysxTriangleMeshSimplificationCollisionAPI", "PhysxSDFMeshCollisionAPI",
    "PhysxContactReportAPI",
))  # fmt: skip


class PrimGroup(Welded[tuple[Any, list[Any]]]):
    """Rigid bodies that move as one, each with its colliders."""

    @property
    def prim(self) -> Any:  # noqa: ANN401 - of a type of usd-core
        """The prim of the first body."""
        return self.members[0][0]

    @property
    def colliders(self) -> list[Any]:
        """The colliders of all bodies."""
        return [collider for _, colliders in self.members for collider in colliders]


def has(prim: Any, schema: str) -> bool:  # noqa: ANN401
    """Say whether a schema is applied to a prim."""
    return schema in prim.GetAppliedSchemas()


def groups_of(stage: Stage, rigid: bool, notes: list[str]) -> list[PrimGroup]:
    """Return the groups of bodies of a stage; a collider outside of rigid bodies is a fixed body by itself.

    Movable joints are refused by name, unless all bodies that they join are fixed, or ``rigid`` is True: then they
    hold.
    """
    group: dict[Any, PrimGroup] = {}
    for prim in stage.prims:
        if str(prim.GetTypeName()) == "PointInstancer":
            fail(prim, "is a PointInstancer", "needs its instances as prims")
        if _is_rigid(prim):
            group[prim.GetPath()] = PrimGroup([(prim, [])], bool(value_of(prim, "physics:kinematicEnabled", False)))
        if not has(prim, COLLIDER) or not value_of(prim, "physics:collisionEnabled", True):
            continue
        if str(prim.GetTypeName()) not in SHAPES:
            notes.append(f"{prim.GetPath()}: a collider without a shape of its own ({prim.GetTypeName()}), so nothing")
            continue
        owner = _owner(prim)  # itself or above, so it is in a group already
        if owner is None:
            group[prim.GetPath()] = PrimGroup([(prim, [prim])], True)
        else:
            group[owner.GetPath()].members[0][1].append(prim)
    _join(stage, group, rigid, notes)
    return list(dict.fromkeys(group.values()))


def _is_rigid(prim: Any) -> bool:  # noqa: ANN401
    return has(prim, RIGID) and bool(value_of(prim, "physics:rigidBodyEnabled", True))


def _owner(prim: Any) -> Any:  # noqa: ANN401
    """Return the rigid body to which a prim belongs: itself, its nearest ancestor that is one, or None."""
    while prim and not prim.IsPseudoRoot():
        if _is_rigid(prim):
            return prim
        prim = prim.GetParent()
    return None


def _join(stage: Stage, group: dict[Any, PrimGroup], rigid: bool, notes: list[str]) -> None:
    from pxr import UsdPhysics

    joints = [prim for prim in stage.prims if prim.IsA(UsdPhysics.Joint)]
    loose = []
    for joint in joints:
        if not value_of(joint, "physics:jointEnabled", True):
            continue
        ends = [_end(joint, name, group) for name in ("physics:body0", "physics:body1")]
        is_fixed = str(joint.GetTypeName()) == "PhysicsFixedJoint"
        if is_fixed or rigid:
            weld(group, ends, lambda member: member[0].GetPath())
        if not is_fixed:
            loose.append((joint, ends))
    loose = [(joint, ends) for joint, ends in loose if rigid or not all(end is None or end.fixed for end in ends)]
    named = listed([f"{joint.GetPath()} ({joint.GetTypeName()})" for joint, _ in loose])
    if loose and not rigid:
        problem = f"can move; joints that can: {named}; a joint between bodies is no contact"
        fail(loose[0][0], problem, "give rigid=True")
    if loose:
        notes.append(f"joints that hold as if welded: {named}")


def _end(joint: Any, name: str, group: dict[Any, PrimGroup]) -> PrimGroup | None:  # noqa: ANN401
    """Return the group at an end of a joint; None is the world."""
    targets = joint.GetRelationship(name).GetTargets() if joint.GetRelationship(name) else []
    if not targets:
        return None
    prim = joint.GetStage().GetPrimAtPath(targets[0])
    if not prim:
        fail(joint, f"joins {quoted(str(targets[0]))}, which is not there", "check its bodies")
    owner = _owner(prim)
    return None if owner is None else group[owner.GetPath()]


def excluded_pairs(stage: Stage, bodies: Sequence[BodyParts]) -> list[Excluded]:
    """Return the pairs of bodies, marked with their colliders, that collision groups and filtered pairs keep apart."""
    from pxr import UsdPhysics

    groups = [prim for prim in stage.prims if prim.IsA(UsdPhysics.CollisionGroup)]
    filtering = [prim for prim in stage.prims if has(prim, FILTER)]
    filters = [(prim.GetPath(), prim.GetRelationship("physics:filteredPairs").GetTargets()) for prim in filtering]
    if not groups and not filters:
        return []
    names = {str(group.GetPath()): _merged(group) for group in groups}
    found = set()
    for group in groups:
        targets = group.GetRelationship("physics:filteredGroups").GetTargets()
        filtered = {names[str(target)] for target in targets if str(target) in names}
        if value_of(group, "physics:invertFilteredGroups", False):
            filtered = set(names.values()) - filtered
        found |= {pair for other in filtered for pair in ((_merged(group), other), (other, _merged(group)))}
    queries = [
        (_merged(prim), UsdPhysics.CollisionGroup(prim).GetCollidersCollectionAPI().ComputeMembershipQuery())
        for prim in groups
    ]

    def of(prim: Any) -> list[str]:  # noqa: ANN401
        return [name for name, query in queries if query.IsPathIncluded(prim.GetPath())]

    def may(a: Any, b: Any) -> bool:  # noqa: ANN401
        for path, others in filters:
            for x, y in ((a.GetPath(), b.GetPath()), (b.GetPath(), a.GetPath())):
                if x.HasPrefix(path) and any(y.HasPrefix(other) for other in others):
                    return False
        return not any((x, y) in found for x in of(a) for y in of(b))

    def touching(of_a: Sequence[Any], of_b: Sequence[Any]) -> Bool:
        return np.array([[may(x, y) for y in of_b] for x in of_a], dtype=bool)

    return kept_apart(combinations(bodies, 2), touching)


def _merged(group: Any) -> str:  # noqa: ANN401
    """Return the name of the merge group of a collision group, or its path if it has none."""
    return str(value_of(group, "physics:mergeGroup", "")) or str(group.GetPath())


def unread(stage: Stage) -> list[str]:
    """Return notes on what USD could not compose, and on properties, schemas and kinds of prims that are not known."""
    found: Counter[str] = Counter()
    for prim in stage.prims:
        kind = str(prim.GetTypeName())
        if kind in LOOKING or kind.endswith(LOOKING_ENDS):
            continue
        if _is_foreign(kind):
            found[kind] += 1
        applied = [str(each).partition(":")[0] for each in prim.GetPrimTypeInfo().GetAppliedAPISchemas()]
        found.update(name for name in applied if _is_foreign(name))
        found.update(str(each.GetName()) for each in prim.GetAuthoredProperties() if not _is_known(each))
    lost = [one_line(str(error)) for error in stage.whole.GetCompositionErrors()]
    notes = [f"not in the stage, as USD could not compose it: {listed(lost, 3)}"] if lost else []
    return [*notes, *not_read(found)]


def _is_foreign(name: str) -> bool:
    """Tell whether a schema or a kind of prim is one of physics that is not known."""
    return name.startswith(("Physx", "Newton", "Mjc")) and name not in SCHEMAS


def _is_known(given: Any) -> bool:  # noqa: ANN401 - a property
    name = str(given.GetName())
    if name in UNBREAKABLE and number_of(given.GetPrim(), name, np.inf) >= UNBROKEN:
        return True
    return name in KNOWN or f"{name.partition(':')[0]}:" in KNOWN
