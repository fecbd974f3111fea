"""The links and joints of a URDF file: groups that move as one, and the shapes, masses and friction of links."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked_number, checked_word, unit
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.ranges import DENSITY, FRICTION, MASS, PLACE
from holdfast.base.text import listed, quoted
from holdfast.scene.compound import Inertial, Solid
from holdfast.scene.formats.joints import check_within
from holdfast.scene.formats.links import BodyPiece, Notes, ball, filled, pose_of
from holdfast.scene.formats.made_meshes import MeshRules, factors_of
from holdfast.scene.formats.references import References
from holdfast.scene.formats.surfaces import DRAKES_FRICTION, Surfaces
from holdfast.scene.round_shapes import Capsule, Ellipsoid
from holdfast.scene.shapes import Box, Cylinder
from holdfast.scene.xml import Element

TURNING, SLIDING = ("revolute", "continuous"), ("prismatic",)
LIMITED, MOVED = ("revolute", *SLIDING), (*TURNING, *SLIDING)
KINDS = ("fixed", "floating", "planar", *TURNING, *SLIDING)
OTHERS = ("spherical", "ball", "universal", "screw", "curvilinear")  # of Bullet, Habitat and Drake; they move, too
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


class UrdfJoint(NamedTuple):
    """A joint: its kind, its parent and child link, and the pose (4, 4) of the child in the parent."""

    name: str
    kind: str
    parent: str
    child: str
    pose: Float
    element: Element


@dataclass(frozen=True)
class LinkGroup:
    """Links that move as one: the first one, its pose (4, 4) in the root, and the pose of each link in the first.

    If a motor holds the group, ``joint`` carries its first link and ``above`` is the first link of the group below it.
    """

    top: str
    pose: Float
    links: Mapping[str, Float]
    joint: UrdfJoint | None = None
    above: str = ""


def origin_of(element: Element) -> Float:
    """Return the pose (4, 4) in the element's <origin>, by default the identity."""
    origin = element.child("origin")
    if origin is None:
        return np.eye(4)
    zero = (0.0, 0.0, 0.0)
    return pose_of(origin.numbers("xyz", 3, zero), origin.numbers("rpy", 3, zero))


def groups_of(
    root: Element,
    links: Mapping[str, Element],
    positions: Mapping[str, float],
    locked: bool,
    notes: list[str],
    *,
    motors: bool = False,
) -> list[LinkGroup]:
    """Return the groups of links, the root's first.

    ``positions`` [rad or m] are those of movable joints, by default zero. Such joints are refused by name unless
    ``locked`` is True: then they hold. With ``motors``, those that turn or slide divide groups. Raises SceneError if
    the links are not a tree.
    """
    joints = _joints(root, links, positions)
    below: dict[str, list[UrdfJoint]] = {name: [] for name in links}
    for joint in joints:
        below[joint.parent].append(joint)
    dividing = ("floating", *(MOVED if motors else ()))
    _check_movable(root, [joint for joint in joints if joint.kind not in ("fixed", *dividing)], locked, notes)
    carried = {joint.child for joint in joints}
    tops = [name for name in links if name not in carried]
    if len(tops) != 1:
        what = f"has {len(tops)} links that no joint carries ({listed(tops)})" if tops else "has joints in a circle"
        root.fail(what, "needs a tree of links with one root")
    found, reached = [], 0
    waiting: list[tuple[str, Float, UrdfJoint | None, str]] = [(tops[0], np.eye(4), None, "")]
    while waiting:
        top, pose, joint_above, above = waiting.pop(0)
        placed, stack = {top: np.eye(4)}, [top]
        while stack:
            link = stack.pop()
            for joint in below[link]:
                if joint.kind in dividing:
                    motor = joint if joint.kind in MOVED else None
                    waiting.append((joint.child, pose @ placed[link] @ joint.pose, motor, top))
                else:
                    placed[joint.child] = placed[link] @ joint.pose
                    stack.append(joint.child)
        found.append(LinkGroup(top, pose, placed, joint_above, above))
        reached += len(placed)
    if reached < len(links):
        root.fail("has joints in a circle", "needs a tree of links with one root")
    return found


def _joints(root: Element, links: Mapping[str, Element], positions: Mapping[str, float]) -> list[UrdfJoint]:
    elements = {}
    for element in [*root.all("joint"), *root.all("drake:joint")]:
        if element.attribute("name") in elements:
            element.fail("stands twice", "names of joints are unique")
        elements[element.attribute("name")] = element
    for name in positions:
        if name not in elements:
            raise SceneError(message(f"joints: {quoted(name)}", "is no joint", nearest_of(name, elements)))
    joints = [_joint(element, links, elements, positions) for element in elements.values()]
    carried: set[str] = set()
    for joint in joints:
        if joint.child in carried:
            joint.element.fail(f"is a second joint to the link {quoted(joint.child)}", "needs a tree of links")
        carried.add(joint.child)
    return joints


def _joint(
    element: Element, links: Mapping[str, Element], elements: Mapping[str, Element], positions: Mapping[str, float]
) -> UrdfJoint:
    name, kind = element.attribute("name"), element.attribute("type")
    if kind not in (*KINDS, *OTHERS):
        element.fail(f"type = {quoted(kind)}", f"needs one of {', '.join((*KINDS, *OTHERS))}")
    ends = [element.needed(end).attribute("link") for end in ("parent", "child")]
    for end in ends:
        if end not in links:
            element.fail(f"names the link {quoted(end)}", nearest_of(end, links))
    with element.located():
        pose = origin_of(element) @ _motion(element, kind, _position(element, elements, positions))
    return UrdfJoint(name, kind, ends[0], ends[1], pose, element)


def _position(element: Element, elements: Mapping[str, Element], positions: Mapping[str, float]) -> float:
    """Return the position [rad or m] of a joint: as given, that of the joint it mimics, or zero."""
    factor, offset = 1.0, 0.0
    if element.attribute("type") == "fixed" and element.attribute("name") not in positions:
        return 0.0  # whatever it is to mimic
    for _ in range(len(elements) + 1):
        name = element.attribute("name")
        if name in positions:
            where = f"joints: {quoted(name)}"
            position = checked_number(positions[name], where, within=PLACE)
            limit, kind = element.child("limit"), element.attribute("type")
            if limit is not None and kind in LIMITED:
                turning = kind in TURNING
                check_within(where, position, limit.number("lower", 0.0), limit.number("upper", 0.0), turning=turning)
            return factor * position + offset
        mimic = element.child("mimic")
        if mimic is None:
            return offset
        offset += factor * mimic.number("offset", 0.0)
        factor *= mimic.number("multiplier", 1.0)
        other = mimic.attribute("joint")
        if other not in elements:
            mimic.fail(f"names the joint {quoted(other)}", nearest_of(other, elements))
        element = elements[other]
    return element.fail("mimics itself, by other joints", "needs one joint at the end that mimics none")


def _motion(element: Element, kind: str, position: float) -> Float:
    """Return the pose (4, 4) of the child at this position of the joint."""
    pose = np.eye(4)
    if position == 0.0:
        return pose
    if kind not in MOVED:
        element.fail(f"is {kind} and has the position {position:g}", "give positions of turning and sliding joints")
    x, y, z = along = axis_of(element)
    if kind in SLIDING:
        pose[:3, 3] = along * position
        return pose
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    pose[:3, :3] = np.eye(3) + np.sin(position) * cross + (1 - np.cos(position)) * cross @ cross
    return pose


def axis_of(element: Element) -> Float:
    """Return the unit vector (3,) of a joint's axis in the frame of its child."""
    axis = element.child("axis")
    along = np.array((1.0, 0.0, 0.0) if axis is None else axis.numbers("xyz", 3))
    if not along.any():
        element.fail("has a zero axis", "needs a direction")
    return unit(along)


def _check_movable(root: Element, movable: list[UrdfJoint], locked: bool, notes: list[str]) -> None:
    """Refuse movable joints by name, unless they hold."""
    if not movable:
        return
    named = listed([f"{quoted(joint.name)} ({joint.kind})" for joint in movable])
    if locked:
        notes.append(f"joints that hold as if welded: {named}")
        return
    remedy = (
        "give rigid=True for one rigid body (at joints={name: position}), fixed=True, or hold_torques=True for joints "
        "that turn or slide and that motors hold"
    )
    root.fail(f"has joints that can move: {named}; a joint between bodies is no contact", remedy)


@dataclass
class UrdfLinks:
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
        found = [
            name
            for name in RULES
            if any(self._coefficients(name, link, each) for link in links for each in _shape_elements(link))
        ]
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

    def _coefficients(self, simulator: str, link: Element, shape: Element) -> list[float]:
        """Return the coefficients of the shapes of a link that the file gives for this simulator."""
        if simulator in ("gazebo", "bullet"):
            return (self._gazebo if simulator == "gazebo" else self._bullet).get(link.attribute("name"), [])
        properties = shape.all("drake:proximity_properties")
        return [each.number("value") for own in properties for each in own.all("drake:mu_static")]

    def pieces(self, link: Element) -> list[BodyPiece]:
        """Return the collision shapes of a link in its frame or, if it has none, the visual ones."""
        if not link.all("collision") and link.all("visual"):
            self.notes.of(_called(link), "no <collision>, its <visual> is taken")
        return [self._piece(link, element) for element in _shape_elements(link)]

    def _piece(self, link: Element, element: Element) -> BodyPiece:
        with element.located():
            shape = self._shape(element.needed("geometry"), link)
            return BodyPiece(shape, origin_of(element), self.surfaces.material(self._mu(link, element)))

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
                    factors = factors_of(shape, shape.numbers("scale", 3, (1.0, 1.0, 1.0)))
                    path = self.references.file(shape.attribute("filename"), shape.place)
                    return self.meshes.read(path, factors, self.notes, link.attribute("name"))
        return shape.fail("is unknown", "reads box, sphere, cylinder, capsule, drake:ellipsoid and mesh")

    def _mu(self, link: Element, element: Element) -> float:
        """Return the coefficient of a surface; raise SceneError if neither the file nor ``friction`` gives one."""
        own = [] if self.simulator is None else self._coefficients(self.simulator, link, element)
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

    def inertial(self, link: Element, pieces: list[BodyPiece], density: float | None) -> Inertial | None:
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


def _shape_elements(link: Element) -> list[Element]:
    """Return the <collision> elements of a link, or its <visual> ones if it has none."""
    return link.all("collision") or link.all("visual")
