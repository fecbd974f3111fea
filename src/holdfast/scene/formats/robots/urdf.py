"""Read URDF: a robot, or a thing, as one rigid body for each group of links that joints hold together."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from numpy.typing import ArrayLike

from holdfast.base.arrays import Float, checked_items, checked_mapping, checked_name, checked_number, checked_truth
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.ranges import DENSITY
from holdfast.base.text import quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import together
from holdfast.scene.formats.joints import Motors, Torques, joint_hold, never_touching
from holdfast.scene.formats.links import FLOOR, Notes, copies_of, rigid_body, scene_of, with_floor
from holdfast.scene.formats.made_meshes import Collision, MeshRules
from holdfast.scene.formats.references import Packages, References, model_folders
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.robots.urdf_links import (
    ATTRIBUTES,
    KNOWN,
    SLIDING,
    LinkGroup,
    UrdfLinks,
    axis_of,
    groups_of,
)
from holdfast.scene.formats.source import Source
from holdfast.scene.scene import Scene
from holdfast.scene.xml import Element, parsed, root_name

WORLD = "world"


def sniff(source: Source) -> bool:
    """Tell whether the outermost element is <robot>."""
    return root_name(source.text) == "robot"


def read(
    source: Source,
    *,
    pose: ArrayLike | None = None,
    poses: Mapping[str, ArrayLike] | None = None,
    joints: Mapping[str, float] | None = None,
    rigid: bool = False,
    hold_torques: Torques = False,
    fixed: bool | Collection[str] = False,
    floor: bool = False,
    friction: float | None = None,
    density: float | None = None,
    simulator: str | None = None,
    package: Packages | None = None,
    model_path: Iterable[str | Path] | None = None,
    collision: Collision = "mesh",
    up_axis: Literal["y", "z"] | None = None,
    gravity: ArrayLike = (0.0, 0.0, -9.81),
) -> Scene:
    """Return the scene of one URDF file.

    ``pose`` (4, 4) is that of the root link in the world; ``poses`` gives several copies of the file instead, each with
    a name and a pose. Links that fixed joints hold together are one body, named like the robot or its copy; others have
    the name of their first link appended. Movable joints are refused by name, unless ``rigid`` or ``fixed`` is True:
    then they hold at the positions ``joints`` [rad or m], by default zero; a joint that mimics another follows it, and
    a floating one joins nothing. With ``hold_torques`` the links between joints are bodies, each held by the one below
    it: a joint bears any force and moment but along its axis, where its motor gives at most the ``effort`` of the file,
    or what ``hold_torques`` says by name [N m, or N if it slides]; links of one robot never touch each other. ``fixed``
    makes all bodies fixed; as names, it makes these copies and bodies fixed. What is fixed to a root link ``world`` is
    fixed, and a link without a shape is left out, with a note. ``floor`` adds the half space below z = 0, with the
    friction of whatever lies on it. ``friction`` is the coefficient of surfaces and ``density`` [kg/m³] that of links
    for which the file gives none. ``simulator``, one of "bullet", "drake", "gazebo", chooses the friction tags of a
    file that has several kinds. ``package`` maps the names of packages to folders, or is a function that does;
    ``model_path`` are folders in which packages lie. With ``collision="hull"`` meshes are their convex hulls, as in
    Bullet, PhysX and SAPIEN; a mapping says so for single links. ``up_axis`` is the axis that points up in mesh files.

    Raises SceneError or GeometryError if the file is malformed, or leaves out what is needed.
    """
    root = parsed(source.text, source.path)
    pending = [root]
    while pending:
        element = pending.pop()
        if element.tag.startswith("xacro:"):
            element.fail("is a macro", "expand the file first: xacro robot.urdf.xacro > robot.urdf")
        pending += element.children
    if density is not None:
        density = checked_number(density, "density", above=0, within=DENSITY)
    name = checked_name(root.attributes.get("name") or source.path.stem, f"{root.place}: name")
    copies = copies_of(name, pose, poses)
    notes = Notes()
    notes.unread([root], KNOWN, ATTRIBUTES)
    references = References(source.path, package, models=model_folders(model_path, notes))
    meshes = MeshRules(up_axis, collision)
    reader = UrdfLinks(root, references, simulator, friction, meshes, notes)
    links = _links(root)
    meshes.check_names(links)
    if not isinstance(fixed, bool):
        fixed = _names_in(fixed)
    all_fixed = fixed if isinstance(fixed, bool) else {copy for copy, _ in copies} <= set(fixed)
    positions = {} if joints is None else checked_mapping(joints, "joints", '{"elbow": 0.5}')
    locked = checked_truth(rigid, "rigid") or all_fixed
    motors = Motors(hold_torques, welded=locked)
    groups = groups_of(root, links, positions, locked, notes, motors=motors.used)
    motors.check_names([group.joint.name for group in groups if group.joint is not None])
    bodies = [body for group in groups if (body := _body(group, links, reader, density, all_fixed, motors))]
    if not bodies:
        root.fail("has no link with a shape", "needs a <collision> or <visual>")
    several = len(bodies) > 1
    copied = [
        (copy, replace(body, name=f"{copy}/{top}" if several else copy, pose=place @ body.pose))
        for copy, place in copies
        for top, body in bodies
    ]
    placed = _held(copied, fixed)
    remedy = "give floor=True for a floor at z = 0, or fixed=True for what carries others"
    placed = with_floor(placed, floor, root.place, remedy, problem="is a thing that nothing carries")
    scene = scene_of(placed, reader.surfaces.table(FLOOR if floor else None), gravity, name, notes)
    return with_arms(scene, groups, [top for top, _ in bodies], copies, motors) if motors.used else scene


def _names_in(fixed: object) -> list[str]:
    remedy = 'needs True, False, or a list of names, as ["table"]'
    if isinstance(fixed, str) or not isinstance(fixed, Iterable):
        raise SceneError(message("fixed", f"is {quoted(fixed)}", remedy))
    names = checked_items(fixed, "fixed", "names")
    for name in names:
        if not isinstance(name, str):
            raise SceneError(message("fixed", f"holds {quoted(name)}", remedy))
    return names


def _held(placed: list[tuple[str, Body]], fixed: bool | Collection[str]) -> list[Body]:
    """Return the bodies, given with the names of their copies; those that ``fixed`` lists by either name are fixed."""
    bodies = [body for _, body in placed]
    if isinstance(fixed, bool):
        return bodies
    known = [name for copy, body in placed for name in (copy, body.name)]
    for name in fixed:
        if name not in known:
            raise SceneError(
                message("fixed", f"no body is named {quoted(name)}", nearest_of(name, dict.fromkeys(known)))
            )
    return [replace(body, fixed=body.fixed or body.name in fixed or copy in fixed) for copy, body in placed]


def _links(root: Element) -> dict[str, Element]:
    links: dict[str, Element] = {}
    for link in root.all("link"):
        if link.attribute("name") in links:
            link.fail("stands twice", "names of links are unique")
        links[link.attribute("name")] = link
    if not links:
        root.fail("has no links", "needs at least one <link>")
    joints = [*root.all("joint"), *root.all("drake:joint")]
    if any(end.attributes.get("link") == WORLD for joint in joints for end in joint.all("parent")):
        links.setdefault(WORLD, Element("link", {"name": WORLD}, root.file, root.line))  # Drake knows it by its name
    return links


def _body(
    group: LinkGroup,
    links: Mapping[str, Element],
    reader: UrdfLinks,
    density: float | None,
    fixed: bool,
    motors: Motors,
) -> tuple[str, Body] | None:
    """Return the body of a group with the name of its first link, at its pose in the root; None if it has no shape."""
    pieces, inertials, unknown = [], [], []
    for name, at in group.links.items():
        own = reader.pieces(links[name])
        inertial = reader.inertial(links[name], own, density)
        pieces += [piece._replace(pose=at @ piece.pose) for piece in own]
        inertials += [] if inertial is None else [inertial.seen(at)]
        unknown += [links[name]] if own and inertial is None else []
    massive = [inertial for inertial in inertials if inertial.mass]
    if group.joint is not None and not massive and not unknown:
        links[group.top].fail("has no mass, and moves by a joint of its own", "give it a mass in its <inertial>")
    if not pieces and motors.used and massive:
        reader.notes.of(quoted(group.top), "no shape, so it touches nothing")
        return group.top, motors.ball(group.top, group.pose, together(massive))
    if not pieces:
        if massive:
            reader.notes.of(quoted(group.top), "no shape, so it touches nothing and is left out")
        return None
    fixed = fixed or (group.top == WORLD and not links[WORLD].children)
    if unknown and not fixed:
        unknown[0].fail("has no mass", "give density=, or fixed=True")
    if not massive and not fixed:
        reader.notes.of(quoted(group.top), "mass 0, so it is fixed, as in Bullet")
        fixed = True
    mass = together(massive) if massive and not unknown else None
    return group.top, rigid_body(group.top, pieces, pose=group.pose, inertial=mass, fixed=fixed)


URDF = Format("URDF", (".urdf",), sniff, read, mark="<robot>")


def with_arms(
    scene: Scene, groups: Sequence[LinkGroup], tops: Sequence[str], copies: Iterable[tuple[str, Float]], motors: Motors
) -> Scene:
    """Return the scene with the holds of all joints, for each copy of the file at its pose (4, 4) in the world.

    ``tops`` are the first links of the groups that are bodies; what holds on any other is fixed in the world.
    """
    fixed, holds, arms, balls = {body.name: body.fixed for body in scene.bodies}, [], [], []
    for copy, place in copies:
        names = {top: f"{copy}/{top}" if len(tops) > 1 else copy for top in tops}
        arms.append([*names.values()])
        balls += [names[top] for top in motors.balls]
        for group in groups:
            joint, body = group.joint, names.get(group.top)
            if joint is None or body is None or fixed[body]:
                continue
            at, on = place @ group.pose, names.get(group.above)
            limit = joint.element.child("limit")
            effort = 0.0 if limit is None or joint.element.child("mimic") is not None else limit.number("effort", 0.0)
            bounds = motors.of(joint.name, (-effort, effort) if effort > 0 else None)  # files write 0 for none
            axis = at[:3, :3] @ axis_of(joint.element)
            slides = joint.kind in SLIDING
            holds.append(joint_hold(body, on, at[:3, 3], axis, bounds, slides=slides))
    return replace(scene, holds=tuple(holds), excluded=never_touching(arms, balls, [*fixed]))
