"""The tree of links and joints of a URDF file, divided into groups of links that move as one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, checked_number, unit
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.ranges import PLACE
from holdfast.base.text import listed, quoted
from holdfast.scene.formats.joints import check_within
from holdfast.scene.formats.links import pose_of
from holdfast.scene.xml import Element

TURNING, SLIDING = ("revolute", "continuous"), ("prismatic",)
LIMITED, MOVED = ("revolute", *SLIDING), (*TURNING, *SLIDING)
KINDS = ("fixed", "floating", "planar", *TURNING, *SLIDING)
OTHERS = ("spherical", "ball", "universal", "screw", "curvilinear")  # of Bullet, Habitat and Drake; they move, too


class Joint(NamedTuple):
    """A joint: its kind, its parent and child link, and the pose (4, 4) of the child in the parent."""

    name: str
    kind: str
    parent: str
    child: str
    pose: Float
    element: Element


@dataclass(frozen=True)
class Group:
    """Links that move as one: the first one, its pose (4, 4) in the root, and the pose of each link in the first.

    If a motor holds the group, ``joint`` carries its first link and ``above`` is the first link of the group below it.
    """

    top: str
    pose: Float
    links: Mapping[str, Float]
    joint: Joint | None = None
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
) -> list[Group]:
    """Return the groups of links, the root's first.

    ``positions`` [rad or m] are those of movable joints, by default zero. Such joints are refused by name unless
    ``locked`` is True: then they hold. With ``motors``, those that turn or slide divide groups. Raises SceneError if
    the links are not a tree.
    """
    joints = _joints(root, links, positions)
    below: dict[str, list[Joint]] = {name: [] for name in links}
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
    waiting: list[tuple[str, Float, Joint | None, str]] = [(tops[0], np.eye(4), None, "")]
    while waiting:
        top, pose, held, above = waiting.pop(0)
        placed, stack = {top: np.eye(4)}, [top]
        while stack:
            link = stack.pop()
            for joint in below[link]:
                if joint.kind in dividing:
                    held_by = joint if joint.kind in MOVED else None
                    waiting.append((joint.child, pose @ placed[link] @ joint.pose, held_by, top))
                else:
                    placed[joint.child] = placed[link] @ joint.pose
                    stack.append(joint.child)
        found.append(Group(top, pose, placed, held, above))
        reached += len(placed)
    if reached < len(links):
        root.fail("has joints in a circle", "needs a tree of links with one root")
    return found


def _joints(root: Element, links: Mapping[str, Element], positions: Mapping[str, float]) -> list[Joint]:
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
) -> Joint:
    name, kind = element.attribute("name"), element.attribute("type")
    if kind not in (*KINDS, *OTHERS):
        element.fail(f"type = {quoted(kind)}", f"needs one of {', '.join((*KINDS, *OTHERS))}")
    ends = [element.needed(end).attribute("link") for end in ("parent", "child")]
    for end in ends:
        if end not in links:
            element.fail(f"names the link {quoted(end)}", nearest_of(end, links))
    with element.located():
        pose = origin_of(element) @ _motion(element, kind, _position(element, elements, positions))
    return Joint(name, kind, ends[0], ends[1], pose, element)


def _position(element: Element, elements: Mapping[str, Element], positions: Mapping[str, float]) -> float:
    """Return the position [rad or m] of a joint: as given, that of the joint it mimics, or zero."""
    factor, offset = 1.0, 0.0
    if element.attribute("type") == "fixed" and element.attribute("name") not in positions:
        return 0.0  # whatever it is to mimic
    for _ in range(len(elements) + 1):
        name = element.attribute("name")
        if name in positions:
            return factor * _given(element, name, positions[name]) + offset
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


def _given(element: Element, name: str, value: float) -> float:
    """Return the given position [rad or m] of a joint; raise SceneError if it is outside the limits."""
    where = f"joints: {quoted(name)}"
    position = checked_number(value, where, within=PLACE)
    limit, kind = element.child("limit"), element.attribute("type")
    if limit is not None and kind in LIMITED:
        turning = kind in TURNING
        check_within(where, position, limit.number("lower", 0.0), limit.number("upper", 0.0), turning=turning)
    return position


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


def _check_movable(root: Element, movable: list[Joint], locked: bool, notes: list[str]) -> None:
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
