"""The links of an SDF file: their shapes, their masses and the friction of their surfaces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked_number
from holdfast.base.ranges import DENSITY, FRICTION, MASS
from holdfast.base.text import quoted
from holdfast.scene.compound import Inertial, Solid, together
from holdfast.scene.formats.links import BodyPiece, LinkContent, Notes, ball, plane_frame
from holdfast.scene.formats.made_meshes import MeshRules, cone, extruded, factors_of
from holdfast.scene.formats.robots.scopes import Scope, posed, truth
from holdfast.scene.formats.surfaces import DRAKES_FRICTION, Surfaces
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder, MassProperties, Mesh
from holdfast.scene.xml import Element

MOST_CORNERS = 1_000  # of a polyline; where they cross, the time grows with the square or more
USUAL_FRICTION = 1.0  # default of SDF
RULES = {"ode": "least", "bullet": "product", "drake": "harmonic mean"}  # how simulators combine two surfaces
USUAL_DENSITY = 1000.0  # [kg/m³] default of SDF for masses that follow from shapes
USUAL_MASK = 0xFFFF  # default of SDF: a shape collides with all others


# Elements that are read, do not matter at rest or have a note of their own; a note lists all other elements
KNOWN = {
    "world": ("model", "include", "frame", "joint", "light", "actor", "gravity", "physics", "scene", "gui", "plugin",
              "audio", "spherical_coordinates", "magnetic_field", "atmosphere", "road", "wind"),
    "model": ("pose", "static", "self_collide", "allow_auto_disable", "frame", "link", "joint", "model", "include",
              "plugin", "light"),
    "link": ("pose", "inertial", "collision", "visual", "sensor", "gravity", "self_collide", "must_be_base_link",
             "velocity_decay", "light", "audio_sink", "audio_source", "projector", "battery", "particle_emitter",
             "plugin"),
    "inertial": ("pose", "mass", "inertia", "density", "auto_inertia_params"),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "geometry": ("box", "sphere", "cylinder", "capsule", "drake:capsule", "ellipsoid", "drake:ellipsoid", "cone",
                 "polyline", "plane", "mesh", "empty"),
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "mesh": ("uri", "scale", "submesh", "convex_decomposition"),
    "collision": ("pose", "geometry", "surface", "density", "auto_inertia_params", "laser_retro", "max_contacts",
                  "drake:proximity_properties", "drake:visual"),
    "surface": ("bounce", "friction", "contact", "soft_contact"),
    "friction": ("ode", "bullet"),
    "ode": ("mu", "mu2", "fdir1"),
    "bullet": ("friction", "friction2", "fdir1"),
    "contact": ("collide_without_contact", "collide_bitmask", "poissons_ratio", "elastic_modulus"),
}  # fmt: skip
# The same for the attributes of these elements
ATTRIBUTES = (
    "name", "type", "version", "canonical_link", "placement_frame", "merge", "auto", "relative_to", "expressed_in",
    "attached_to", "rotation_format", "degrees", "filename", "default", "joint", "delay", "action", "id", "element_id",
)  # fmt: skip


def solid_of(
    scope: Scope, element: Element, link: str, meshes: MeshRules, notes: Notes
) -> tuple[Solid, MassProperties | None]:
    """Return the shape of an element such as <box>, and its mass properties if they differ from those of the shape.

    Assumptions are noted for the ``link``.
    """
    match element.tag:
        case "sphere":
            return ball(_size(element, "radius"), link, notes), None
        case "box":
            return Box(np.array(element.needed("size").values(3))), None
        case "cylinder":
            return Cylinder(_size(element, "radius"), _size(element, "length")), None
        case "capsule" | "drake:capsule":
            return Capsule(_size(element, "radius"), _size(element, "length")), None
        case "ellipsoid":
            return Ellipsoid(np.array(element.needed("radii").values(3))), None
        case "drake:ellipsoid":
            return Ellipsoid([_size(element, axis) for axis in ("a", "b", "c")]), None
        case "cone":
            return cone(_size(element, "radius"), _size(element, "length"), element.place)
        case "mesh":
            if element.child("submesh") is not None:
                element.fail("takes one of several meshes of its file", "give that one a file of its own")
            uri, scale = element.needed("uri"), element.child("scale")
            factors = factors_of(element, (1.0, 1.0, 1.0) if scale is None else scale.values(3))
            path = scope.references.file(uri.text.strip(), uri.place)
            return meshes.read(path, factors, notes, scope.path, link), None
    return element.fail(
        "is not read", "reads box, sphere, cylinder, capsule, ellipsoid, cone, polyline, plane and mesh"
    )


def plane_pose(element: Element) -> Float:
    """Return the pose (4, 4) of a <plane> in its collision, with the normal along z; its size is only visual."""
    normal = element.child("normal")
    up = np.array((0.0, 0.0, 1.0) if normal is None else normal.values(3))
    if not up.any():
        element.fail("has a zero normal", "needs a direction")
    return plane_frame(up)


def _size(element: Element, tag: str) -> float:
    return element.needed(tag).values(1)[0]


def outlined(elements: list[Element]) -> Mesh:
    """Return the solid of the <polyline> elements of a geometry; outlines in others are holes, as in Gazebo."""
    outlines = []
    for element in elements:
        points = [point.values(2) for point in element.all("point")]
        if not 3 <= len(points) <= MOST_CORNERS:
            element.fail(f"has {len(points):,} points", f"needs three and more, up to {MOST_CORNERS:,}")
        outlines.append(np.array(points))
    return extruded(outlines, _size(elements[0], "height"), elements[0].place)


class CollisionShape(NamedTuple):
    """A collision, its shape in the link, and its mass properties at unit density if they differ from the shape's.

    The mark of the piece are the bits that decide what it may touch; a plane has its normal along z.
    """

    element: Element
    piece: BodyPiece
    exact: MassProperties | None


@dataclass
class SdfLinks:
    """Reads links with the friction tags of ``tags``; ``friction`` and ``density`` replace missing values."""

    tags: str
    surfaces: Surfaces
    friction: float | None
    density: float | None
    meshes: MeshRules
    notes: Notes

    def link(self, scope: Scope, element: Element, fixed: bool) -> LinkContent:
        """Return what is in a link: its shapes and, unless it is fixed, its mass."""
        contents, where = list[CollisionShape](), f"{scope.path}::{element.attribute('name')}"
        if element.all("visual") and not element.all("collision"):
            self.notes.of(where, "no <collision>, its <visual> is taken")
        for collision in element.all("collision") or element.all("visual"):
            with collision.located():
                contents += self._collision(scope, collision, element, where)
        pieces = [each.piece for each in contents]
        if fixed:
            return LinkContent(pieces, None)
        if not truth(element, "gravity", True):
            element.fail("has no weight (<gravity>false</gravity>)", "needs gravity, or a static model")
        with element.located():
            solids = [each for each in contents if not isinstance(each.piece.shape, HalfSpace)]
            return LinkContent(pieces, self._inertial(element, solids, where))

    def _collision(self, scope: Scope, element: Element, link: Element, where: str) -> Iterator[CollisionShape]:
        """Yield the shape of a collision, if it has one."""
        geometry = element.needed("geometry")
        outlines = geometry.all("polyline")
        if len(geometry.children) != max(1, len(outlines)):
            geometry.fail(f"has {len(geometry.children)} shapes", "needs one")
        shape, pose = geometry.children[0], _in_link(element, link)
        if shape.tag == "empty":
            return
        mask, material = _mask(element), self.surfaces.material(self._mu(element, where))
        contact = _below(element, "surface", "contact")
        if contact is not None and truth(contact, "collide_without_contact"):
            self.notes.of(where, "touches nothing (collide_without_contact)")
            mask = 0
        if shape.tag == "plane":
            yield CollisionShape(
                element, BodyPiece(HalfSpace(), np.asarray(pose @ plane_pose(shape)), material, mask), None
            )
            return
        with shape.located():
            solid, exact = (
                (outlined(outlines), None) if outlines else solid_of(scope, shape, where, self.meshes, self.notes)
            )
            yield CollisionShape(element, BodyPiece(solid, pose, material, mask), exact)

    def _mu(self, element: Element, where: str) -> float:
        """Return the least coefficient of a surface over its directions; by default ``friction`` or that of SDF."""
        found = coefficients(element, self.tags)
        values = [checked_number(mu, f"{element.place}: friction", minimum=0, within=FRICTION) for mu in found]
        if values:
            if max(values) > min(values):
                self.notes.of(where, f"friction {min(values):g}, the least of its directions")
            return min(values)
        if self.friction is not None:
            self.notes.of(where, f"friction {self.friction:g}, as given by friction=")
            return self.friction
        whose, usual = ("Drake", DRAKES_FRICTION) if self.tags == "drake" else ("SDF", USUAL_FRICTION)
        self.notes.of(where, f"friction {usual:g}, which {whose} says where a file says none")
        return usual

    def _inertial(self, element: Element, contents: list[CollisionShape], where: str) -> Inertial:
        """Return the given inertial, or the sum of those of the shapes, ignoring overlaps, as SDF prescribes."""
        inertial = element.child("inertial")
        auto = inertial is not None and inertial.attributes.get("auto", "").strip().lower() in ("true", "1")
        bare = inertial is None or inertial.child("mass") is None
        if auto or (bare and self.density is not None):
            usual = self.density or USUAL_DENSITY
            usual = usual if inertial is None else _density(inertial, usual)
            each = [_filled(content, _density(content.element, usual)) for content in contents]
            self.notes.of(where, "mass worked out from densities")
            if not each:
                element.fail("has a mass to be worked out, and no shape", "add one")
            found = together(each)
            mass = None if inertial is None else inertial.child("mass")
            if mass is None:
                return found
            return found.weighing(checked_number(mass.values(1)[0], mass.place, above=0, within=MASS))
        if bare:
            self.notes.of(where, "mass 1 kg, which SDF says where a file says none")
        return _stated_inertial(inertial, element)


def coefficients(element: Element, tags: str) -> list[float]:
    """Return the friction coefficients of a collision for the simulator ``tags``: Bullet, Drake or ODE."""
    if tags == "drake":
        properties = element.all("drake:proximity_properties")
        return [each.values(1)[0] for own in properties for each in own.all("drake:mu_static")]
    names = ("friction", "friction2") if tags == "bullet" else ("mu", "mu2")
    found = _below(element, "surface", "friction", tags)
    return [] if found is None else [each.values(1)[0] for name in names if (each := found.child(name)) is not None]


def _below(element: Element, *tags: str) -> Element | None:
    found: Element | None = element
    for tag in tags:
        found = None if found is None else found.child(tag)
    return found


def _in_link(element: Element, link: Element) -> Float:
    pose, frame = posed(element)
    if frame and frame != link.attribute("name"):
        element.fail(f"has a pose relative to {quoted(frame)}", "needs one relative to its link")
    return pose


def _mask(element: Element) -> int:
    mask = _below(element, "surface", "contact", "collide_bitmask")
    if mask is None:
        return USUAL_MASK
    try:
        return int(mask.text.strip(), 0) & USUAL_MASK
    except ValueError:
        return mask.fail(f"is {quoted(mask.text.strip())}", "needs a whole number")


def _density(element: Element, usual: float) -> float:
    child = element.child("density")
    return usual if child is None else checked_number(child.values(1)[0], child.place, above=0, within=DENSITY)


def _filled(content: CollisionShape, density: float) -> Inertial:
    own = content.piece.shape.mass_properties if content.exact is None else content.exact
    return Inertial(density * own.volume, own.com, density * own.inertia).seen(content.piece.pose)


def _stated_inertial(element: Element | None, link: Element) -> Inertial:
    """Return the mass in an <inertial>, with the defaults of SDF: 1 kg, and 1 kg m² about each axis."""
    if element is None:
        return Inertial(1.0, np.zeros(3), np.eye(3))
    pose = _in_link(element, link)
    child, inertia = element.child("mass"), element.child("inertia")
    mass = 1.0 if child is None else checked_number(child.values(1)[0], child.place, above=0, within=MASS)
    usual = {"ixx": 1.0, "iyy": 1.0, "izz": 1.0, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    found = {tag: None if inertia is None else inertia.child(tag) for tag in usual}
    entry = {tag: usual[tag] if each is None else each.values(1)[0] for tag, each in found.items()}
    rows = [["ixx", "ixy", "ixz"], ["ixy", "iyy", "iyz"], ["ixz", "iyz", "izz"]]
    return Inertial(mass, np.zeros(3), np.array([[entry[tag] for tag in row] for row in rows])).seen(pose)
