"""Write USD stages with UsdPhysics: bodies, colliders, masses, materials and pairs that do not touch.

Everything is in metres and kilograms with z up. UsdPhysics keeps masses, moments and coefficients in single precision,
and so does USD the points of meshes; poses and sizes are in double precision.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from holdfast.base.arrays import Bool, Float
from holdfast.base.errors import SceneError, message
from holdfast.base.rigid import quaternion_of
from holdfast.base.text import quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import Solid, solids_in
from holdfast.scene.excluded import End
from holdfast.scene.formats.surfaces import PHYSX, RULES, table_of, units_of
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere

ROOT, LOOKS = "/World", "/World/Looks"
MODES = dict(zip(PHYSX, ("average", "min", "multiply", "max"), strict=True))  # PhysX's words for its rules
EXACT = 1e-9  # largest difference of a coefficient from that of its pair


def write(scene: Scene, path: Path) -> bytes:
    """Return the content of a stage: of text for the suffix .usda, of a binary file for .usd and .usdc.

    Bodies that never move are kinematic rigid bodies. Raises SceneError for a package, which holds files, and for
    friction of pairs that no rule of PhysX makes of a coefficient for each surface.
    """
    from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics

    if path.suffix.lower() == ".usdz":
        raise SceneError(message(str(path), "is a package", "write .usda or .usdc, and pack it with USD's own tools"))
    layer: Any = Sdf.Layer.CreateAnonymous(path.suffix.lower())
    stage: Any = Usd.Stage.Open(layer)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, ROOT).GetPrim())
    physics = UsdPhysics.Scene.Define(stage, f"{ROOT}/physicsScene")
    size = float(np.linalg.norm(scene.gravity))
    physics.CreateGravityDirectionAttr(Gf.Vec3f(*(scene.gravity / size).tolist()))
    physics.CreateGravityMagnitudeAttr(size)
    materials = _materials(stage, scene)
    prims: dict[End, Any] = {}
    for number, body in enumerate(scene.bodies):
        where = f"{ROOT}/{Tf.MakeValidIdentifier(body.name)!s}"
        free = not stage.GetPrimAtPath(where)
        _write_body(stage, body, where if free else f"{where}_{number}", materials, prims)
    for a, b in scene.excluded:
        pairs = UsdPhysics.FilteredPairsAPI.Apply(prims[a])
        pairs.CreateFilteredPairsRel().AddTarget(prims[b].GetPath())
    if path.suffix.lower() == ".usda":
        return str(layer.ExportToString()).encode()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"stage{path.suffix.lower()}"
        layer.Export(str(file))
        return file.read_bytes()


def _materials(stage: Any, scene: Scene) -> dict[tuple[str, int], Any]:  # noqa: ANN401 - types of usd-core
    """Write the physics materials; return that of each part of a body."""
    from pxr import Sdf, UsdPhysics, UsdShade

    units = units_of(scene)
    rule, own = _coefficients(scene, *table_of(scene, units))
    found, made = {}, dict[float, Any]()
    for mu, unit in zip(own.tolist(), units, strict=True):
        if mu not in made:
            made[mu] = UsdShade.Material.Define(stage, f"{LOOKS}/friction_{len(made)}")
            prim = made[mu].GetPrim()
            said = UsdPhysics.MaterialAPI.Apply(prim)
            said.CreateStaticFrictionAttr(mu)
            said.CreateDynamicFrictionAttr(mu)
            prim.AddAppliedSchema("PhysxMaterialAPI")
            prim.CreateAttribute("physxMaterial:frictionCombineMode", Sdf.ValueTypeNames.Token, False).Set(MODES[rule])
        found.update({(unit.body.name, part): made[mu] for part in unit.parts})
    return found


def _coefficients(scene: Scene, mu: Float, touch: Bool) -> tuple[str, Float]:
    """Return a rule of PhysX and coefficients (U,) by which it gives those of all pairs (U, U) that ``touch``."""
    i, j = np.nonzero(np.triu(touch))
    rows = np.zeros((len(i), len(mu)))
    rows[np.arange(len(i)), i], rows[np.arange(len(i)), j] = 1, 1
    tried = {
        "least": np.where(touch, mu, 0.0).max(1, initial=0.0),
        "largest": np.where(touch, mu, np.inf).min(1, initial=np.inf),
        "mean": np.linalg.lstsq(rows, 2 * mu[i, j], rcond=None)[0] if len(i) else np.zeros(len(mu)),
    }
    if (mu[i, j] > 0).all() and len(i):
        tried["product"] = np.exp(np.linalg.lstsq(rows, np.log(mu[i, j]), rcond=None)[0])
    wrong = {}
    for rule, own in tried.items():
        own[~np.isfinite(own)] = 0.0
        made = np.array([RULES[rule](a, b) for a, b in zip(own[i].tolist(), own[j].tolist(), strict=True)])
        off = np.abs(made - mu[i, j])
        if (own >= -EXACT).all() and (off <= EXACT).all():
            return rule, np.maximum(own, 0.0)
        wrong[rule] = int(off.argmax())
    units = units_of(scene)
    k = wrong["least"]
    names = f"{quoted(units[i[k]].body.name)} and {quoted(units[j[k]].body.name)}"
    problem = f"{mu[i[k], j[k]]:g} between {names} is no least, largest, mean or product of coefficients of surfaces"
    raise SceneError(message("friction", problem, "USD has no friction of pairs: write .yaml, .xml or .glb"))


def _write_body(
    stage: Any,  # noqa: ANN401
    body: Body,
    where: str,
    materials: dict[tuple[str, int], Any],
    prims: dict[End, Any],
) -> None:
    """Write a body with its colliders, and enter their prims."""
    from pxr import Gf, UsdGeom, UsdPhysics

    if isinstance(body.shape, HalfSpace):
        plane = UsdGeom.Plane.Define(stage, where)
        plane.CreateAxisAttr("Z")
        prims[body.name] = plane.GetPrim()
        _place(plane, body.pose)
        _collide(plane.GetPrim(), materials[body.name, 0])
        plane.GetPrim().SetDisplayName(body.name)
        return
    prim = prims[body.name] = UsdGeom.Xform.Define(stage, where).GetPrim()
    prim.SetDisplayName(body.name)
    _place(UsdGeom.Xformable(prim), body.pose)
    rigid = UsdPhysics.RigidBodyAPI.Apply(prim)
    if body.fixed:
        rigid.CreateKinematicEnabledAttr(True)
    else:
        moments, axes = np.linalg.eigh(body.inertia_com)
        w, x, y, z = quaternion_of(axes * [1.0, 1.0, float(np.linalg.det(axes))]).tolist()
        weight = UsdPhysics.MassAPI.Apply(prim)
        weight.CreateMassAttr(float(body.mass or 0.0))
        weight.CreateCenterOfMassAttr(Gf.Vec3f(*body.com_body.tolist()))
        weight.CreateDiagonalInertiaAttr(Gf.Vec3f(*moments.tolist()))
        weight.CreatePrincipalAxesAttr(Gf.Quatf(w, x, y, z))
    for k, (shape, pose) in enumerate(solids_in(body.shape)):
        part = _solid(stage, f"{where}/collider_{k}", shape, pose)
        _collide(part, materials[body.name, k])
        prims[body.name, k] = part


def _collide(prim: Any, material: Any) -> None:  # noqa: ANN401
    from pxr import UsdPhysics, UsdShade

    UsdPhysics.CollisionAPI.Apply(prim)
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, materialPurpose="physics")


def _place(prim: Any, pose: Float, scale: Float | None = None) -> None:  # noqa: ANN401
    """Write the pose (4, 4) of a prim, and a scale (3,) along its own axes."""
    from pxr import Gf, UsdGeom

    double = UsdGeom.XformOp.PrecisionDouble
    w, x, y, z = quaternion_of(pose[:3, :3]).tolist()
    prim.AddTranslateOp(double).Set(Gf.Vec3d(*pose[:3, 3].tolist()))
    prim.AddOrientOp(double).Set(Gf.Quatd(w, x, y, z))
    if scale is not None:
        prim.AddScaleOp(double).Set(Gf.Vec3d(*scale.tolist()))


def _solid(stage: Any, where: str, shape: Solid, pose: Float) -> Any:  # noqa: ANN401
    """Write a shape at ``pose`` (4, 4) in its body; return its prim."""
    from pxr import UsdGeom

    scale = None
    match shape:
        case Box():
            made = UsdGeom.Cube.Define(stage, where)
            made.CreateSizeAttr(1.0)
            scale = shape.size
        case Sphere():
            made = UsdGeom.Sphere.Define(stage, where)
            made.CreateRadiusAttr(shape.radius)
        case Ellipsoid():
            made = UsdGeom.Sphere.Define(stage, where)
            made.CreateRadiusAttr(1.0)
            scale = shape.radii
        case Cylinder():
            made = UsdGeom.Cylinder.Define(stage, where)
            made.CreateRadiusAttr(shape.radius)
            made.CreateHeightAttr(shape.height)
        case Capsule():
            made = UsdGeom.Capsule.Define(stage, where)
            made.CreateRadiusAttr(shape.radius)
            made.CreateHeightAttr(shape.length)
        case Mesh():
            made = UsdGeom.Mesh.Define(stage, where)
            surface = shape.surface
            made.CreatePointsAttr(surface.vertices.astype(np.float32))
            made.CreateFaceVertexCountsAttr(np.full(len(surface.faces), 3, dtype=np.int32))
            made.CreateFaceVertexIndicesAttr(surface.faces.ravel().astype(np.int32))
            made.CreateSubdivisionSchemeAttr("none")
    _place(made, pose, scale)
    return made.GetPrim()
