"""Read USD stages: rigid bodies, colliders, masses, materials and joints of UsdPhysics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from pathlib import PurePath
from typing import Any

import numpy as np

from holdfast.base.arrays import Float, checked_number, checked_truth, checked_word, unit
from holdfast.base.borders.foreign import foreign
from holdfast.base.errors import SceneError, located, message
from holdfast.base.ranges import FRICTION, SCALE
from holdfast.base.text import listed, quoted
from holdfast.scene.body import Body
from holdfast.scene.compound import together
from holdfast.scene.formats import links
from holdfast.scene.formats.links import FLOOR, BodyParts
from holdfast.scene.formats.named_meshes import split
from holdfast.scene.formats.references import Packages
from holdfast.scene.formats.registry import Format
from holdfast.scene.formats.source import MAX_BYTES, Source
from holdfast.scene.formats.surfaces import RULES, Surfaces
from holdfast.scene.formats.usd.stage import Stage, opened, stage_of
from holdfast.scene.formats.usd.usd_bodies import PrimGroup, excluded_pairs, groups_of, has, unread
from holdfast.scene.formats.usd.usd_colliders import (
    Collider,
    along,
    fail,
    inertial_of,
    number_of,
    numbers_of,
    piece_of,
    value_of,
)
from holdfast.scene.formats.usd.usd_writer import write
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene

MAGIC = (b"#usda", b"PXR-USDC")
ZIP = b"PK\x03\x04"
USUAL_GRAVITY = 9.81  # [m/s²] default of UsdPhysics
MODES = {"average": "mean", "min": "least", "multiply": "product", "max": "largest"}  # PhysX's words for rules


def sniff(source: Source) -> bool:
    """Tell whether the file is USD: text, binary, or a package with the suffix .usdz."""
    return source.head.startswith(MAGIC) or (source.suffix == ".usdz" and source.head.startswith(ZIP))


def read(
    source: Source,
    *,
    friction: float | None = None,
    combine: str | None = None,
    density: float | None = None,
    fixed: Collection[str] = (),
    rigid: bool = False,
    floor: bool = False,
    package: Packages | None = None,
) -> Scene:
    """Return the scene of a USD stage; needs usd-core (extra ``usd``).

    Lengths and masses are converted to metres and kilograms, and the stage is rotated so that z is up. Rigid bodies are
    named like their prims, with the paths if names repeat; colliders outside of them are fixed bodies. ``friction`` is
    the coefficient of colliders without a physics material. UsdPhysics does not say how two coefficients are combined:
    ``combine`` does, with "least" (the default), "product", "mean", "largest" and other means. ``density`` [kg/m³] is
    for shapes for which the file gives none; without it, the default of UsdPhysics, 1,000, is used and noted. ``fixed``
    are names of bodies, ``rigid`` welds joints that can move, ``floor`` adds the half space below z = 0, and
    ``package`` maps names to folders in which layers may lie.

    Raises SceneError or GeometryError if the file is malformed, or leaves out what is needed.
    """
    path, notes = source.path, list[str]()
    if source.given is not None or len(source.content) > MAX_BYTES:
        raise SceneError(message(str(path), "is not a file by itself", "USD is read from files: save it first"))
    friction, density = links.checked_defaults(friction, density)
    surfaces = _surfaces(combine, notes)
    rigid, floor = checked_truth(rigid, "rigid"), checked_truth(floor, "floor")
    with foreign(str(path), "is no USD"), located(str(path)):
        stage = opened(path, package, notes)
        groups = _named(groups_of(stage, rigid, notes))
        return _scene(stage, groups, path.stem, surfaces, friction, density, fixed, floor, notes)


def read_open(
    whole: Any,  # noqa: ANN401 - a stage of USD
    *,
    friction: float | None = None,
    combine: str | None = None,
    rigid: bool = False,
    floor: bool = False,
) -> tuple[Scene, Stage, dict[str, PrimGroup]]:
    """Return the scene of a stage that is open in this program, edits included, and the prims of each body by name.

    The options are those of ``read``. What the program composed is trusted: layers may lie anywhere.

    Raises SceneError or GeometryError if the stage leaves out what is needed.
    """
    notes, where = list[str](), str(whole.GetRootLayer().identifier)
    surfaces, (friction, _) = _surfaces(combine, notes), links.checked_defaults(friction, None)
    with foreign(where, "is no USD"):
        stage = stage_of(whole, where, notes)
        groups = _named(groups_of(stage, rigid, notes))
        name = PurePath(where).stem
        return _scene(stage, groups, name, surfaces, friction, None, (), floor, notes), stage, groups


def _surfaces(combine: str | None, notes: list[str]) -> Surfaces:
    """Return the rule by which two coefficients combine, which is noted."""
    if combine is not None:
        checked_word(combine, RULES, "combine")
    surfaces = Surfaces(combine or "least", sole=combine is not None)
    notes.append(f"friction of a pair: the {surfaces.rule} of both" + ("" if combine else ", as USD does not say"))
    return surfaces


def _named(groups: list[PrimGroup]) -> dict[str, PrimGroup]:
    """Return groups by the names of their bodies: those of their prims, or the paths where names repeat."""
    names = [str(group.prim.GetDisplayName() or group.prim.GetName()) for group in groups]
    count = Counter(names)
    names = [
        name if count[name] == 1 else str(group.prim.GetPath())[1:] for name, group in zip(names, groups, strict=True)
    ]
    named = dict(zip(names, groups, strict=True))
    for name, group in zip(names, groups, strict=True):
        if named[name] is not group:
            fail(group.prim, f"is a body with the name {quoted(name)}, as is another", "give it another display name")
    return named


def _scene(
    stage: Stage,
    groups: dict[str, PrimGroup],
    name: str,
    surfaces: Surfaces,
    friction: float | None,
    density: float | None,
    fixed: Collection[str],
    floor: bool,
    notes: list[str],
) -> Scene:
    """Return the scene of an open stage, whose bodies are ``groups``; the other arguments are those of ``read``."""
    fixed_names = links.checked_fixed(fixed, groups)
    found = []
    for prim_name, group in groups.items():
        body = _body(stage, group, prim_name, surfaces, friction, density, prim_name in fixed_names, notes)
        if body is not None:
            found.append(BodyParts(body, group.colliders))
    if surfaces.own:
        notes.append("friction of a pair whose materials have a frictionCombineMode of PhysX: by that")
    notes += unread(stage)
    excluded = excluded_pairs(stage, found)
    bodies = [parts.body for parts in found]
    remedy = f"give fixed=[name] ({listed([body.name for body in bodies])}), or floor=True"
    table = surfaces.table(FLOOR if floor else None)
    return links.scene_of(
        links.with_floor(bodies, floor, "stage", remedy), table, _gravity(stage, notes), name, notes, excluded
    )


def _gravity(stage: Stage, notes: list[str]) -> Float:
    """Return gravity (3,) [m/s²]; by default it is 9.81 m/s² downwards."""
    scenes = [prim for prim in stage.prims if str(prim.GetTypeName()) == "PhysicsScene"]
    if len(scenes) != 1:
        notes.append(f"{len(scenes)} physics scenes: " + ("gravity of the first" if scenes else "gravity is 9.81 m/s²"))
    direction, magnitude = np.array([0.0, 0.0, -1.0]), USUAL_GRAVITY
    if scenes:
        given = numbers_of(scenes[0], "physics:gravityDirection", (3,), SCALE)
        strength = number_of(scenes[0], "physics:gravityMagnitude", -np.inf)
        if strength >= 0 or np.isnan(strength):
            magnitude = checked_number(strength * stage.metres, f"{scenes[0].GetPath()}: gravityMagnitude", minimum=0)
        if given is not None and given.any():
            direction = stage.turn[:3, :3] @ unit(given)
    return np.asarray(magnitude * direction)


def _body(
    stage: Stage,
    group: PrimGroup,
    name: str,
    surfaces: Surfaces,
    friction: float | None,
    density: float | None,
    fixed_by_name: bool,
    notes: list[str],
) -> Body | None:
    """Return the body of a group; None if it has no collider."""
    from pxr import UsdShade

    if not group.colliders:
        notes.append(f"{group.prim.GetPath()}: has no collider, so it is left out")
        return None
    fixed = group.fixed or fixed_by_name
    frames = [split(stage.placed(prim), str(prim.GetPath())) for prim, _ in group.members]
    pose, pieces, inertials = frames[0][0], [], []
    for (prim, colliders), (member_pose, stretch) in zip(group.members, frames, strict=True):
        shapes = []
        for each in colliders:
            found = UsdShade.MaterialBindingAPI(each).ComputeBoundMaterial("physics")[0]
            material = found.GetPrim() if found else None
            material = material if material is not None and has(material, "PhysicsMaterialAPI") else None
            mode = "" if material is None else str(value_of(material, "physxMaterial:frictionCombineMode", ""))
            if mode and mode not in MODES:
                fail(material, f"frictionCombineMode is {quoted(mode)}", f"needs one of {', '.join(MODES)}")
            surface = surfaces.material(_mu(each, material, friction, notes), MODES.get(mode, ""))
            matrix = np.linalg.inv(member_pose) @ stage.placed(each)
            if str(each.GetTypeName()) == "Plane":
                return _plane(each, group, name, member_pose @ matrix, surface, fixed)
            shapes.append(Collider(each, piece_of(each, matrix, surface, notes), material))
        away = np.asarray(np.linalg.inv(pose) @ member_pose) if prim != group.prim else np.eye(4)
        pieces += [each.piece._replace(pose=away @ each.piece.pose) for each in shapes]
        if not fixed and value_of(prim, "physxRigidBody:disableGravity", False):
            fail(prim, "has no weight (physxRigidBody:disableGravity)", "needs gravity, or a kinematic body")
        if not fixed and shapes:
            inertials.append(inertial_of(stage, prim, shapes, stretch, density, notes).seen(away))
    return links.rigid_body(name, pieces, pose=pose, inertial=None if fixed else together(inertials), fixed=fixed)


def _plane(prim: Any, group: PrimGroup, name: str, matrix: Float, surface: str, fixed: bool) -> Body:  # noqa: ANN401
    if not fixed or len(group.colliders) > 1:
        fail(prim, "is a plane in a body that moves or has other colliders", "needs a static plane of its own")
    pose, _ = split(matrix @ along(prim), str(prim.GetPath()))
    return Body(name, HalfSpace(), pose=pose, material=surface, fixed=True)


def _mu(prim: Any, material: Any, friction: float | None, notes: list[str]) -> float:  # noqa: ANN401
    if material is not None:
        mu = number_of(material, "physics:staticFriction", 0.0)
        return checked_number(mu, f"{material.GetPath()}: staticFriction", minimum=0, within=FRICTION)
    if friction is None:
        fail(prim, "has no physics material, so no friction", "give friction=, for all colliders without one")
    notes.append(f"{prim.GetPath()}: friction {friction:g}, as given by friction=")
    return friction


USD = Format("USD", (".usd", ".usda", ".usdc", ".usdz"), sniff, read, write, mark="UsdPhysics", extra="usd")
