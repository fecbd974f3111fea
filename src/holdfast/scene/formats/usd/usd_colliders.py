"""The colliders of a USD stage as shapes, and masses, given or by density, with the priorities of UsdPhysics."""

from __future__ import annotations

from typing import Any, NamedTuple, NoReturn

import numpy as np

from holdfast.base.arrays import Float, Int, checked, checked_number
from holdfast.base.errors import GeometryError, SceneError, located, message
from holdfast.base.ranges import DENSITY, INERTIA, MASS, SCALE, Range
from holdfast.base.rigid import pose_from
from holdfast.base.text import quoted
from holdfast.scene.compound import Inertial, Solid, together
from holdfast.scene.formats.links import BodyPiece
from holdfast.scene.formats.made_meshes import cone
from holdfast.scene.formats.named_meshes import split
from holdfast.scene.formats.published import triangulated
from holdfast.scene.formats.usd.stage import Stage
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder, Mesh, Sphere

ALIKE = 1e-6  # [-] largest relative difference of factors that are equal in single precision, which USD uses
AS_THEY_ARE = ("none", "convexDecomposition", "meshSimplification", "sdf", "sphereFill")  # the last two are PhysX's
ALONG = {  # poses that rotate the z axis to the axis of a shape
    "X": np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]),
    "Y": np.array([[0.0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1]]),
    "Z": np.eye(4),
}
USUAL_DENSITY = 1000.0  # [kg/m³] default of UsdPhysics


def fail(prim: Any, problem: str, remedy: str) -> NoReturn:  # noqa: ANN401 - of a type of usd-core
    """Raise SceneError about a prim."""
    raise SceneError(message(str(prim.GetPath()), problem, remedy))


def value_of(prim: Any, name: str, usual: Any = None) -> Any:  # noqa: ANN401
    """Return the value of an attribute of a prim at the default time, or ``usual`` if it has none."""
    attribute = prim.GetAttribute(name)
    value = attribute.Get() if attribute else None
    return usual if value is None else value


def number_of(prim: Any, name: str, usual: float) -> float:  # noqa: ANN401
    """Return a number of a prim, or ``usual``; it may be infinite, as some defaults are."""
    value = value_of(prim, name, usual)
    try:
        return float("no number" if isinstance(value, str | bool) else value)
    except (TypeError, ValueError):
        return fail(prim, f"{name} is {quoted(str(value))}", "needs a number")


def numbers_of(prim: Any, name: str, shape: tuple[int | None, ...], within: Range | None = None) -> Float | None:  # noqa: ANN401
    """Return an attribute of a prim as an array of finite numbers of this shape, or None if it has none."""
    value = value_of(prim, name)
    return None if value is None else checked(value, shape, f"{prim.GetPath()}: {name}", within=within)


def along(prim: Any) -> Float:  # noqa: ANN401
    """Return the pose (4, 4) that rotates the z axis to the axis of a prim."""
    axis = str(value_of(prim, "axis", "Z"))
    return ALONG[axis] if axis in ALONG else fail(prim, f"axis is {quoted(axis)}", "needs X, Y or Z")


def piece_of(prim: Any, matrix: Float, material: str, notes: list[str]) -> BodyPiece:  # noqa: ANN401
    """Return the shape of a collider; ``matrix`` (4, 4) maps its frame to the body frame [m]."""
    where, kind = str(prim.GetPath()), str(prim.GetTypeName())
    if kind == "Mesh":
        return _mesh(prim, matrix, material, notes)
    turn = along(prim) if kind in ("Cylinder", "Capsule", "Cone") else np.eye(4)
    pose, stretch = split(matrix @ turn, where)
    factors = np.abs(np.diag(stretch))
    if np.abs(stretch - np.diag(np.diag(stretch))).max() > ALIKE * factors.max():
        fail(prim, f"is a {kind} that is sheared", "needs scale along its own axes")
    x, y, z = factors.tolist()
    return BodyPiece(_solid(prim, kind, (x, y, z)), pose, material)


def _solid(prim: Any, kind: str, scale: tuple[float, float, float]) -> Solid:  # noqa: ANN401
    x, y, z = scale
    if kind == "Cube":
        return Box(number_of(prim, "size", 2.0) * np.array(scale))
    radius = number_of(prim, "radius", 1.0)
    round_about_z, round_all = abs(x - y) <= ALIKE * x, max(scale) - min(scale) <= ALIKE * max(scale)
    if kind == "Sphere":
        return Sphere(radius * x) if round_all else Ellipsoid(radius * np.array(scale))
    height = number_of(prim, "height", 1.0 if kind == "Capsule" else 2.0)
    if kind == "Cylinder" and round_about_z:
        return Cylinder(radius * x, height * z)
    if kind == "Cone" and round_about_z:
        return cone(radius * x, height * z, str(prim.GetPath()))[0]
    if kind == "Capsule" and round_all:
        return Capsule(radius * x, height * x)
    if kind in ("Cylinder", "Capsule", "Cone"):
        fail(prim, f"is a {kind} with the scale {scale}", "needs one that keeps it round")
    return fail(
        prim, f"is a collider of the type {quoted(kind)}", "reads Cube, Sphere, Cylinder, Capsule, Cone, Mesh, Plane"
    )


def _mesh(prim: Any, matrix: Float, material: str, notes: list[str]) -> BodyPiece:  # noqa: ANN401
    """Return a mesh, or the simple shape that replaces it (physics:approximation)."""
    where = str(prim.GetPath())
    pose, stretch = split(matrix, where)
    given = numbers_of(prim, "points", (None, 3), SCALE)
    if given is None or not len(given):
        raise GeometryError(message(where, "has no points", "needs a mesh"))
    points = given @ stretch.T
    kind = str(value_of(prim, "physics:approximation", "none"))
    low, high = points.min(0), points.max(0)
    middle = np.eye(4)
    middle[:3, 3] = (low + high) / 2
    if kind == "boundingCube":
        return BodyPiece(Box(high - low), pose @ middle, material)
    if kind == "boundingSphere":
        radius = float(np.linalg.norm(points - middle[:3, 3], axis=1).max())
        return BodyPiece(Sphere(radius), pose @ middle, material)
    if kind == "convexHull":
        import trimesh

        hull = trimesh.convex.convex_hull(points)
        return BodyPiece(Mesh(np.array(hull.vertices), np.array(hull.faces), label=where), pose, material)
    if kind not in AS_THEY_ARE:
        fail(prim, f"has the approximation {quoted(kind)}", "reads those of UsdPhysics, such as none and convexHull")
    if kind != "none":
        notes.append(f"{where}: the mesh as it is, not its {kind}")
    faces = _triangles(prim, points, where)
    mirrored = (np.linalg.det(stretch) < 0) != (str(value_of(prim, "orientation", "rightHanded")) == "leftHanded")
    return BodyPiece(Mesh(points, faces[:, ::-1] if mirrored else faces, label=where), pose, material)


def _triangles(prim: Any, points: Float, where: str) -> Int:  # noqa: ANN401
    given = [numbers_of(prim, name, (None,), SCALE) for name in ("faceVertexCounts", "faceVertexIndices")]
    counts, corners = (np.zeros(0, np.int64) if each is None else each.astype(np.int64) for each in given)
    if counts.sum() != len(corners) or (counts < 3).any() or not len(counts):
        problem = f"has {len(corners)} corners of {counts.sum()}"
        raise GeometryError(message(where, problem, "needs faces of three corners and more"))
    if corners.min() < 0 or corners.max() >= len(points):
        raise GeometryError(message(where, "a face names a point that is not there", f"there are {len(points)}"))
    if (counts == 3).all():
        return corners.reshape(-1, 3)
    return np.vstack([triangulated(points, face) for face in np.split(corners, np.cumsum(counts)[:-1])])


class Collider(NamedTuple):
    """A collider: its prim, its shape in the body frame, and the physics material to which it is bound, or None."""

    prim: Any
    piece: BodyPiece
    material: Any


def inertial_of(
    stage: Stage,
    body: Any,  # noqa: ANN401 - of a type of usd-core
    colliders: list[Collider],
    stretch: Float,
    density: float | None,
    notes: list[str],
) -> Inertial:
    """Return the inertial of a body in its frame.

    ``stretch`` (3, 3) maps the frame of its prim [stage units] to the body frame [m]. ``density`` [kg/m³] replaces the
    default of UsdPhysics, 1,000, where none is given.
    """
    where = str(body.GetPath())
    with located(where):
        found = together([_weighed(stage, body, each, density, notes) for each in colliders])
        mass = _positive(body, "physics:mass", MASS, stage.kilograms)
        whole = found.weighing(mass)
        centre = body.GetAttribute("physics:centerOfMass")
        given = numbers_of(body, "physics:centerOfMass", (3,), SCALE) if centre and centre.HasAuthoredValue() else None
        if given is not None:
            centre_given = np.asarray(stretch @ given)
            whole = Inertial(whole.mass, centre_given, whole.about(centre_given))
        own = _inertia(stage, body)
        return whole if own is None else whole._replace(inertia=own)


def _inertia(stage: Stage, body: Any) -> Float | None:  # noqa: ANN401
    """Return the given inertia (3, 3) [kg m²] of a body along its axes, or None."""
    given = numbers_of(body, "physics:diagonalInertia", (3,), INERTIA)
    if given is None or not given.any():
        return None
    diagonal = checked(given * stage.kilograms * stage.metres**2, (3,), "diagonalInertia", within=INERTIA)
    axes = value_of(body, "physics:principalAxes")
    turn = np.eye(3)
    if hasattr(axes, "GetReal") and (axes.GetReal() or any(axes.GetImaginary())):
        turn = pose_from(np.zeros(3), np.array([axes.GetReal(), *axes.GetImaginary()], dtype=np.float64))[:3, :3]
    return np.asarray(turn @ np.diag(diagonal) @ turn.T)


def _weighed(stage: Stage, body: Any, collider: Collider, density: float | None, notes: list[str]) -> Inertial:  # noqa: ANN401
    own = collider.piece.shape.mass_properties
    mass = _positive(collider.prim, "physics:mass", MASS, stage.kilograms) if collider.prim != body else None
    per_unit = stage.kilograms / stage.metres**3
    dense = next(
        (
            found
            for prim in (collider.prim, body, collider.material)
            if prim is not None and (found := _positive(prim, "physics:density", DENSITY, per_unit)) is not None
        ),
        None,
    )
    if mass is None and dense is None:
        dense = USUAL_DENSITY if density is None else density
        if _positive(body, "physics:mass", MASS, stage.kilograms) is None:
            notes.append(f"{collider.prim.GetPath()}: density {dense:g} kg/m³, as nothing says it")
    scale = dense if mass is None or own.volume == 0 else mass / own.volume
    assert scale is not None
    return Inertial(scale * own.volume, np.asarray(own.com), scale * np.asarray(own.inertia)).seen(collider.piece.pose)


def _positive(prim: Any, name: str, within: Any, unit: float) -> float | None:  # noqa: ANN401
    """Return an attribute in SI units, or None if it is 0, which in UsdPhysics means that it is not given."""
    value = number_of(prim, name, 0.0)
    if value == 0.0:
        return None
    return checked_number(value * unit, f"{prim.GetPath()}: {name}", above=0, within=within)
