"""The arguments of a placement: where objects may be placed, how they get there, and how long to search.

The options of the command ``place`` are the fields of these classes, with help texts from the docstrings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import (
    Float,
    checked,
    checked_direction,
    checked_items,
    checked_number,
    checked_truth,
    checked_whole,
)
from holdfast.base.errors import SceneError, message
from holdfast.base.ranges import BETWEEN, EXPONENT, FRICTION, LENGTH, MANY, MOST_SEED, SCALE
from holdfast.base.rigid import checked_pose, tangents
from holdfast.base.text import quoted
from holdfast.base.values import Value
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction, number_between, refuse_strengths

UPRIGHT, ANY = "upright", "any"  # words for orientations

SECONDS = 60.0  # [s] default time limit of a search
ATTEMPTS = 400  # default limit on the number of attempts of a search
CANDIDATES = 8  # default number of stable poses that are compared
SPACING = 0.01  # [m] distance between the points of a robustness map
MASS_MARGIN = 0.1  # share of its weight by which the object may be heavier than stated
TILT = 5.0  # [deg]


@dataclass(frozen=True)
class Weights:
    """The exponents that bias the choice of a placement; 0 means no influence.

    ``robustness`` applies to R / (R + weight of the object) at a point of the scene, ``level`` to the vertical
    component of the normal there, and ``steadiness`` to the tilt at which the object still stands on a face. Raises
    HoldfastError if an exponent is negative.
    """

    robustness: float = 2.0
    level: float = 1.0
    steadiness: float = 1.0

    def __post_init__(self) -> None:
        for name in ("robustness", "level", "steadiness"):
            checked_number(getattr(self, name), f"Weights: {name}", minimum=0, within=EXPONENT)


def names_of(assembly: Assembly, names: Sequence[str] | None, option: str) -> tuple[str, ...]:
    """Return the names as a tuple, those of all bodies for None; raises SceneError for one that no body has."""
    if names is None:
        return tuple(body.name for body in assembly.bodies)
    found = checked_items(names, f"Where: {option}", "names of bodies")
    if option == "supports" and not found:
        raise SceneError(message(f"Where: {option}", f"is {quoted(names)}", "needs a list of names of bodies"))
    return tuple(assembly.scene.body(name).name for name in found)


def friction_with(
    assembly: Assembly, objects: Sequence[Body], given: Friction | float | None, supports: Sequence[str]
) -> Friction:
    """Return the friction table of the scene with ``objects``.

    If ``given`` is a table, it is returned; otherwise the scene's own table is. If ``given`` is a number, it holds
    between each object and every body with which the table does not pair it, in place of the table's default. Raises
    SceneError if there is no coefficient between an object and one of the ``supports``.
    """
    table = given if isinstance(given, Friction) else assembly.scene.friction
    refuse_strengths(table, "plan_placement", "leave out tension and cohesion")
    bodies = [*assembly.bodies, *objects]
    if given is not None and not isinstance(given, Friction):
        table = with_own(table, bodies, objects, given)
    materials = {body.name: body.material for body in bodies}
    for one in objects:
        for name in supports:
            try:
                table.between(one.name, name, materials)
            except SceneError as error:
                problem = f"the scene has no friction of {quoted(one.name)} with {quoted(name)}"
                remedy = "say --object-friction MU (in Python friction=MU), or add the pair or a default to the scene"
                raise SceneError(message("plan_placement", problem, remedy)) from error
    return table


def with_own(table: Friction, bodies: Sequence[Body], objects: Sequence[Body], mu: float) -> Friction:
    """Return the table in which ``mu`` holds between ``objects`` and all ``bodies`` that it does not pair them with."""
    coefficient = checked_number(mu, "plan_placement: friction", minimum=0, within=FRICTION)
    materials = {body.name: body.material for body in bodies}
    own = {
        (min(one.name, other.name), max(one.name, other.name)): coefficient  # two objects are a pair once
        for one in objects
        for other in bodies
        if other is not one and number_between(table.pairs, one.name, other.name, materials) is None
    }
    return replace(table, pairs={**own, **table.pairs})


def region_of(corners: object, up: Float, where: str) -> Float:
    """Return the low and the high corner (2, 3) [m] of a region, infinite for None; it is named ``where`` in errors.

    A region (2, 2) is horizontal and reaches from minus to plus infinity along the vertical.
    """
    if corners is None:
        return np.array([[-np.inf] * 3, [np.inf] * 3])
    try:
        box = np.array(corners, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise SceneError(
            message(where, f"is {quoted(corners)}", "needs the low and the high corner of a box")
        ) from None
    if box.shape == (2, 2):
        if np.abs(up[:2]).max() > 1e-9:
            raise SceneError(message(where, "has two coordinates, but up is not z", "give three"))
        box = np.column_stack([box, [-np.inf, np.inf]])
    if box.shape != (2, 3) or np.isnan(box).any():
        raise SceneError(message(where, f"has shape {box.shape}", "needs (2, 2) or (2, 3): low and high corner [m]"))
    if not (box[0] < box[1]).all():
        raise SceneError(message(where, f"low {box[0].tolist()}, high {box[1].tolist()}", "needs low < high"))
    return box


@dataclass(frozen=True, eq=False, repr=False)
class Where(Value):
    """Where objects may be placed.

    - ``box`` [m]: the low and the high corner of a region, (2, 3), or (2, 2) for its horizontal coordinates. It must
      contain the points of the scene on which the pose is built and, seen from above, the centre of mass.
    - ``supports``: names of the bodies to place objects on; all bodies of the scene by default. An object may also lean
      on other bodies.
    - ``least_supports``: how many of the supports an object must touch.
    - ``avoid``: names of bodies that no object may touch.
    - ``keep_out`` [m]: regions, each given as ``box`` is, that no object's convex hull may enter.
    - ``next_to``: the name of a body next to which an object must stand. It must be at the same height, and at most
      half the object's own size away.
    - ``stack``: whether ``place_all`` also puts objects on each other. Lower places come first, so layers form.
    - ``apart`` [m]: the smallest distance that ``place_all`` leaves between objects and to other bodies beside them;
      0.005 by default. Without ``stack`` it also holds for edges, and eight, four and two times as much are tried too.
      With 0, objects may touch.

    Names and regions are checked once the scene is known. Raises SceneError for anything else that is invalid.
    """

    box: ArrayLike | None = None
    supports: Sequence[str] | None = None
    least_supports: int = 1
    avoid: Sequence[str] = ()
    keep_out: Sequence[ArrayLike] = ()
    next_to: str | None = None
    stack: bool = False
    apart: float | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "least_supports", checked_whole(self.least_supports, "Where: least_supports", 1, MANY))
        set_(self, "stack", checked_truth(self.stack, "Where: stack"))
        if self.apart is not None:
            set_(self, "apart", checked_number(self.apart, "Where: apart", minimum=0, within=LENGTH))


def regions_to_keep_out_of(where: Where, up: Float) -> list[Float]:
    """Return the low and the high corner (2, 3) [m] of each region of ``keep_out``."""
    place = "Where: keep_out"
    regions = checked_items(where.keep_out, place, "regions, each with a low and a high corner")
    if any(region is None for region in regions):
        raise SceneError(message(place, "holds None, which is everywhere", "give regions, or leave it out"))
    return [region_of(region, up, f"{place}[{k}]") for k, region in enumerate(regions)]


@dataclass(frozen=True, eq=False, repr=False)
class Approach(Value):
    """Which way up objects are put down, and along which way they get there.

    - ``orientations``: "upright" if the object's own third axis must point up, "any", or the allowed rotations
      (k, 3, 3), body frame to world. By default any orientation is allowed, but an upright one has twice the score.
    - ``lean_degrees`` [deg]: how far an object may lean from an allowed orientation.
    - ``free_yaw``: whether each allowed orientation may also be turned about the vertical.
    - ``direction``: the straight way in along this direction (3,) must be free, for example along (0, 0, -1). By
      default the way in is not checked.
    - ``cone_degrees`` [deg]: how far the way in may lean from ``direction``.
    - ``gripper`` [m]: the low and the high corner (2, 3) of a box that holds a gripper or a suction cup, relative to
      the middle of the object's top, with the third coordinate up. It must hit nothing on the way in, which is straight
      down if no direction is given; quarter turns of it are tried.

    Raises SceneError for a value that is invalid.
    """

    orientations: ArrayLike | str | None = None
    lean_degrees: float = TILT
    free_yaw: bool = True
    direction: ArrayLike | None = None
    cone_degrees: float = 0.0
    gripper: ArrayLike | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name in ("lean_degrees", "cone_degrees"):
            set_(self, name, checked_number(getattr(self, name), f"Approach: {name}", minimum=0, within=BETWEEN))
        set_(self, "free_yaw", checked_truth(self.free_yaw, "Approach: free_yaw"))
        if self.direction is not None:
            set_(self, "direction", checked_direction(self.direction, "Approach: direction"))
        if self.gripper is not None:
            box = checked(self.gripper, (2, 3), "Approach: gripper", within=LENGTH)
            if not (box[0] < box[1]).all():
                problem = f"low {box[0].tolist()}, high {box[1].tolist()}"
                raise SceneError(message("Approach: gripper", problem, "needs low < high"))
            set_(self, "gripper", box)

    @property
    def prefers_upright(self) -> bool:
        """Whether an upright orientation counts for more than others: if none is asked for."""
        return self.orientations is None


def allowed_turns(approach: Approach, up: Float) -> Float | None:
    """Return the allowed rotations (k, 3, 3), or None if every rotation is allowed.

    "upright" allows those in which the object's own third axis points along ``up`` (3,). Raises SceneError for any
    other word, and for rotations that are none.
    """
    value: Any = approach.orientations
    if value is None or (isinstance(value, str) and value == ANY):
        return None
    where = "Approach: orientations"
    if isinstance(value, str):
        if value != UPRIGHT:
            raise SceneError(
                message(where, f"is {quoted(value)}", f"needs {UPRIGHT!r}, {ANY!r} or rotations (k, 3, 3)")
            )
        return np.array([np.column_stack([*tangents(up), up])])
    single = np.asarray(value, dtype=object).ndim == 2
    turns = checked([value] if single else value, (None, 3, 3), where)
    if not len(turns):
        raise SceneError(message(where, "is empty", "give rotations (k, 3, 3), or None for any"))
    poses = np.tile(np.eye(4), (len(turns), 1, 1))
    poses[:, :3, :3] = turns
    return np.array([checked_pose(pose, f"{where}[{k}]")[:3, :3] for k, pose in enumerate(poses)])


@dataclass(frozen=True, eq=False, repr=False)
class Search(Value):
    """How long to search for a place, and by what a pose is judged.

    - ``seconds`` [s]: the longest time. Steps for which there is no time are skipped,
      and the result says so. The default is 60 without ``solves``, and no limit with it.
    - ``solves``: the largest number of poses that are tried; 400 by default. For ``place_all`` it is the number for
      each object without a level place, 25 by default. With ``solves`` and without ``seconds``, the same ``seed`` gives
      the same answer on any machine.
    - ``seed``: the seed of the random numbers.
    - ``candidates``: the number of stable poses that ``plan_placement`` compares.
    - ``spacing`` [m]: the distance between the points of all maps.
    - ``weights``: the exponents that bias the choice of ``plan_placement``, see Weights.
    - ``mass_margin``: the share of its mass by which an object may be heavier than stated. Everything must stand even
      with that mass.
    - ``confirm``: a second engine that must also find the pose stable, or None.

    Raises SceneError for a value that is invalid.
    """

    seconds: float | None = None
    solves: int | None = None
    seed: int = 0
    candidates: int = CANDIDATES
    spacing: float = SPACING
    weights: Weights = Weights()
    mass_margin: float = MASS_MARGIN
    confirm: EngineChoice | None = DEFAULT_ENGINE

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        if self.seconds is not None:
            set_(self, "seconds", checked_number(self.seconds, "Search: seconds", above=0))
        if self.solves is not None:
            set_(self, "solves", checked_whole(self.solves, "Search: solves", 1, MANY))
        set_(self, "seed", checked_whole(self.seed, "Search: seed", 0, MOST_SEED))
        set_(self, "candidates", checked_whole(self.candidates, "Search: candidates", 1, MANY))
        set_(self, "spacing", checked_number(self.spacing, "Search: spacing", above=0, within=LENGTH))
        if not isinstance(self.weights, Weights):
            raise SceneError(
                message("Search: weights", f"is {quoted(self.weights)}", "needs holdfast.sets.Weights(...)")
            )
        set_(self, "mass_margin", checked_number(self.mass_margin, "Search: mass_margin", minimum=0, within=SCALE))

    @property
    def limit(self) -> float | None:
        """The time limit [s], or None if there is none."""
        return SECONDS if self.seconds is None and self.solves is None else self.seconds
