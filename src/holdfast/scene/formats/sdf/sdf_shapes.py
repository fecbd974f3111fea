"""The shapes of an SDF file."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float, unit
from holdfast.base.rigid import tangents
from holdfast.scene.compound import Solid
from holdfast.scene.formats.made_meshes import MeshRules, cone, extruded
from holdfast.scene.formats.rigid_parts import Notes, ball
from holdfast.scene.formats.sdf.scopes import Scope
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder, MassProperties, Mesh
from holdfast.scene.xml import Element

MOST_CORNERS = 1_000  # of a polyline; where they cross, the time grows with the square or more


def solid_of(
    scope: Scope, element: Element, link: str, meshes: MeshRules, notes: Notes
) -> tuple[Solid, MassProperties | None]:
    """Return the shape of an element such as <box>, and its mass properties if they differ from those of the shape.

    Assumptions are noted for the ``link``.
    """
    match element.tag:
        case "sphere":
            return ball(_number(element, "radius"), link, notes), None
        case "box":
            return Box(np.array(element.needed("size").values(3))), None
        case "cylinder":
            return Cylinder(_number(element, "radius"), _number(element, "length")), None
        case "capsule" | "drake:capsule":
            return Capsule(_number(element, "radius"), _number(element, "length")), None
        case "ellipsoid":
            return Ellipsoid(np.array(element.needed("radii").values(3))), None
        case "drake:ellipsoid":
            return Ellipsoid([_number(element, axis) for axis in ("a", "b", "c")]), None
        case "cone":
            return cone(_number(element, "radius"), _number(element, "length"), element.place)
        case "mesh":
            return _mesh(scope, element, link, meshes, notes), None
    return element.fail(
        "is not read", "reads box, sphere, cylinder, capsule, ellipsoid, cone, polyline, plane and mesh"
    )


def plane_pose(element: Element) -> Float:
    """Return the pose (4, 4) of a <plane> in its collision, with the normal along z; its size is only visual."""
    normal = element.child("normal")
    up = np.array((0.0, 0.0, 1.0) if normal is None else normal.values(3))
    if not up.any():
        element.fail("has a zero normal", "needs a direction")
    up, pose = unit(up), np.eye(4)
    if up[2] < 1:  # otherwise the axes stay as they are
        pose[:3, 0], pose[:3, 1] = tangents(up)
        pose[:3, 2] = up
    return pose


def _number(element: Element, tag: str) -> float:
    return element.needed(tag).values(1)[0]


def outlined(elements: list[Element]) -> Mesh:
    """Return the solid of the <polyline> elements of a geometry; outlines in others are holes, as in Gazebo."""
    outlines = []
    for element in elements:
        points = [point.values(2) for point in element.all("point")]
        if not 3 <= len(points) <= MOST_CORNERS:
            element.fail(f"has {len(points):,} points", f"needs three and more, up to {MOST_CORNERS:,}")
        outlines.append(np.array(points))
    return extruded(outlines, _number(elements[0], "height"), elements[0].place)


def _mesh(scope: Scope, element: Element, link: str, meshes: MeshRules, notes: Notes) -> Mesh:
    if element.child("submesh") is not None:
        element.fail("takes one of several meshes of its file", "give that one a file of its own")
    uri, scale = element.needed("uri"), element.child("scale")
    sx, sy, sz = (1.0, 1.0, 1.0) if scale is None else scale.values(3)
    if min(sx, sy, sz) < 0:
        element.fail(f"scale = {sx:g} {sy:g} {sz:g} mirrors the mesh", "needs factors > 0: mirror it in its file")
    path = scope.references.file(uri.text.strip(), uri.place)
    return meshes.read(path, (sx, sy, sz), notes, scope.path, link)
