"""The links of a URDF file: their shapes, their masses and the friction of their surfaces."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from holdfast.base.arrays import checked_number, checked_word
from holdfast.base.ranges import DENSITY, FRICTION, MASS
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Inertial, Solid
from holdfast.scene.formats.links import Notes, Piece, ball, filled
from holdfast.scene.formats.made_meshes import MeshRules
from holdfast.scene.formats.references import References
from holdfast.scene.formats.surfaces import DRAKES_FRICTION, Surfaces
from holdfast.scene.formats.urdf.tree import origin_of
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder, Mesh
from holdfast.scene.xml import Element

# Elements that are read, do not matter at rest or have a note of their own; a note lists all other elements
KNOWN = {
    "robot": ("link", "joint", "drake:joint", "material", "transmission", "gazebo", "sensor", "version"),
    "link": ("inertial", "visual", "collision", "contact", "sensor", "drake:self_collision_filter_group"),
    "inertial": ("origin", "mass", "inertia", "density"),
    "geometry": ("box", "sphere", "cylinder", "capsule", "drake:capsule", "drake:ellipsoid", "mesh"),
    "collision": ("origin", "geometry", "verbose", "drake:proximity_properties", "material"),
    "contact": ("lateral_friction", "rolling_friction", "spinning_friction", "stiffness", "damping", "restitution",
                "inertia_scaling", "contact_cfm", "contact_erp", "friction_anchor", "collision_margin"),
    "joint": ("origin", "parent", "child", "axis", "calibration", "dynamics", "limit", "mimic", "safety_controller",
              "drake:acceleration", "drake:rotor_inertia", "drake:gear_ratio", "hardwareInterface"),
    "gazebo": ("mu1", "mu2", "kp", "kd", "material", "plugin", "sensor", "selfCollide", "minDepth", "maxVel", "fdir1",
               "maxContacts", "implicitSpringDamper", "dampingFactor", "laserRetro", "visual", "provideFeedback",
               "disableFixedJointLumping", "preserveFixedJoint", "light"),
}  # fmt: skip
# The same for the attributes of these elements
ATTRIBUTES = (
    "name", "type", "version", "link", "reference", "xyz", "rpy", "value", "filename", "joint", "multiplier", "offset",
    "lower", "upper", "effort", "velocity", "damping", "friction", "rising", "falling", "k_position", "k_velocity",
    "soft_lower_limit", "soft_upper_limit", "ixx", "ixy", "ixz", "iyy", "iyz", "izz", "size", "radius", "length",
    "scale", "a", "b", "c",
)  # fmt: skip
# How each simulator combines the coefficients of two surfaces
RULES = {"bullet": "product", "drake": "harmonic mean", "gazebo": "least"}


@dataclass
class LinkReader:
    """Reads the links of a file. Friction is read from the tags of ``simulator``, and is ``friction`` without them.

    What is assumed or left out is added to ``notes``.
    """

    root: Element
    references: References
    simulator: str | None
    friction: float | None
    meshes: MeshRules
    notes: Notes
    surfaces: Surfaces = field(init=False)

    def __post_init__(self) -> None:
        if self.friction is not None:
            self.friction = checked_number(self.friction, "friction", minimum=0, within=FRICTION)
        self._gazebo: dict[str, list[float]] = {}
        for element in self.root.all("gazebo"):
            for each in [*element.all("mu1"), *element.all("mu2")]:
                value = each.number("value") if "value" in each.attributes else each.values(1)[0]
                self._gazebo.setdefault(element.attributes.get("reference", ""), []).append(value)
        links = self.root.all("link")
        self._bullet = {
            link.attribute("name"): [
                each.number("value") for own in link.all("contact") for each in own.all("lateral_friction")
            ]
            for link in links
        }
        found = [name for name in RULES if any(self._of(name, link, each) for link in links for each in _seen(link))]
        if self.simulator is not None:
            checked_word(self.simulator, RULES, "simulator")
        if len(found) > 1 and self.simulator is None:
            problem = f"has friction for {' and '.join(found)}, which combine it in different ways"
            self.root.fail(problem, f"give simulator={found[0]!r}, or another")
        self.simulator = self.simulator or (found[0] if found else None)
        rule = "least" if self.simulator is None else RULES[self.simulator]
        self.surfaces = Surfaces(rule)
        if found:
            self.notes.append(f"friction: tags of {self.simulator}; of two surfaces it is their {rule}")

    def _of(self, simulator: str, link: Element, shape: Element) -> list[float]:
        """Return the coefficients of the shapes of a link that the file gives for this simulator."""
        if simulator in ("gazebo", "bullet"):
            return (self._gazebo if simulator == "gazebo" else self._bullet).get(link.attribute("name"), [])
        properties = shape.all("drake:proximity_properties")
        return [each.number("value") for own in properties for each in own.all("drake:mu_static")]

    def pieces(self, link: Element) -> list[Piece]:
        """Return the collision shapes of a link in its frame or, if it has none, the visual ones."""
        if not link.all("collision") and link.all("visual"):
            self.notes.of(_called(link), "no <collision>, its <visual> is taken")
        return [self._piece(link, element) for element in _seen(link)]

    def _piece(self, link: Element, element: Element) -> Piece:
        with element.located():
            shape = self._shape(element.needed("geometry"), link)
            return Piece(shape, origin_of(element), self.surfaces.material(self._mu(link, element)))

    def _shape(self, geometry: Element, link: Element) -> Solid:
        if len(geometry.children) != 1:
            geometry.fail(f"has {len(geometry.children)} shapes", "needs one")
        shape = geometry.children[0]
        with shape.located():
            match shape.tag:
                case "box":
                    size = np.array(shape.numbers("size", 3))
                    return Box(size) if size.any() else ball(0.0, _called(link), self.notes)
                case "sphere":
                    return ball(shape.number("radius"), _called(link), self.notes)
                case "cylinder":
                    return Cylinder(shape.number("radius"), shape.number("length"))
                case "capsule" | "drake:capsule":
                    return Capsule(shape.number("radius"), shape.number("length"))
                case "drake:ellipsoid":
                    return Ellipsoid([shape.number(axis) for axis in ("a", "b", "c")])
                case "mesh":
                    return self._mesh(shape, link.attribute("name"))
        return shape.fail("is unknown", "reads box, sphere, cylinder, capsule, drake:ellipsoid and mesh")

    def _mesh(self, shape: Element, link: str) -> Mesh:
        sx, sy, sz = shape.numbers("scale", 3, (1.0, 1.0, 1.0))
        if min(sx, sy, sz) < 0:
            shape.fail(f"scale = {sx:g} {sy:g} {sz:g} mirrors the mesh", "needs factors > 0: mirror it in its file")
        path = self.references.file(shape.attribute("filename"), shape.place)
        return self.meshes.read(path, (sx, sy, sz), self.notes, link)

    def _mu(self, link: Element, element: Element) -> float:
        """Return the coefficient of a surface; raise SceneError if neither the file nor ``friction`` gives one."""
        own = [] if self.simulator is None else self._of(self.simulator, link, element)
        if own:
            values = [checked_number(value, f"{link.place}: friction", minimum=0, within=FRICTION) for value in own]
            if max(values) > min(values):
                each = listed([f"{value:g}" for value in values])
                self.notes.of(_called(link), f"the least of its coefficients {each}")
            return min(values)
        if self.friction is None and self.simulator == "drake":
            self.notes.of(_called(link), f"friction {DRAKES_FRICTION:g}, which Drake says where a file says none")
            return DRAKES_FRICTION
        if self.friction is None:
            link.fail("has no friction", "give friction=, for all surfaces without one")
        self.notes.of(_called(link), f"friction {self.friction:g}, as given by friction=")
        return self.friction

    def inertial(self, link: Element, pieces: list[Piece], density: float | None) -> Inertial | None:
        """Return the inertial of a link in its frame, by ``density`` [kg/m³] if the file has none; None if unknown."""
        element = link.child("inertial")
        mass_element = None if element is None else element.child("mass")
        if element is None or mass_element is None:
            given = None if element is None else element.child("density")  # as Isaac Gym reads it
            if given is not None:
                density = checked_number(given.number("value"), f"{given.place}: value", above=0, within=DENSITY)
            if not pieces or density is None:
                return None
            said = "" if given is None else ", as the file says"
            self.notes.of(_called(link), f"mass from density {density:g} kg/m³{said}")
            with link.located():
                return filled(pieces, density)
        place = f"{mass_element.place}: value"
        mass = checked_number(mass_element.number("value"), place, minimum=0, within=MASS)
        origin = origin_of(element)
        inertia = element.child("inertia")
        if inertia is not None:
            xx, xy, xz, yy, yz, zz = (inertia.number(f"i{k}", 0.0) for k in ("xx", "xy", "xz", "yy", "yz", "zz"))
            own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            return Inertial(mass, np.zeros(3), own).seen(origin)
        if not pieces:
            element.fail("has no <inertia>", "add it")
        with link.located():
            shape = filled(pieces, 1.0)
        self.notes.of(_called(link), "inertia of its shape")
        middle = origin[:3, 3]
        return Inertial(mass, middle, Inertial(mass, shape.com, mass / shape.mass * shape.inertia).about(middle))


def _called(link: Element) -> str:
    return quoted(link.attribute("name"))


def _seen(link: Element) -> list[Element]:
    """Return the <collision> elements of a link, or its <visual> ones if it has none."""
    return link.all("collision") or link.all("visual")
