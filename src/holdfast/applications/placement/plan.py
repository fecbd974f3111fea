"""Plan a placement: with one call, or with a planner that can be asked with many seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holdfast.applications.placement.friction import friction_with
from holdfast.applications.placement.options import (
    Options,
    Weights,
    checked_gripper,
    checked_keep_out,
    checked_orientations,
    checked_region,
    counted,
    names_of,
)
from holdfast.applications.placement.planner import CANDIDATES, MOST_ATTEMPTS, Planner
from holdfast.applications.placement.result import Placement
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_direction, checked_number, checked_truth, checked_whole
from holdfast.base.errors import SceneError, message
from holdfast.base.ranges import BETWEEN, LENGTH, MOST_SEED, SCALE
from holdfast.base.text import listed, quoted
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.imperfect import covering
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene

SPACING = 0.01  # [m] distance between the points of a robustness map
BUDGET = 60.0  # [s] the longest time that a plan takes by default
MASS_MARGIN = 0.1  # share of its weight by which the object may be heavier than stated


def plan_placement(
    assembly: Assembly | Scene,
    body: Body,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    region: ArrayLike | None = None,
    budget: float | None = BUDGET,
    seed: int = 0,
    candidates: int = CANDIDATES,
    attempts: int = MOST_ATTEMPTS,
    supports: Sequence[str] | None = None,
    least_supports: int = 1,
    avoid: Sequence[str] = (),
    keep_out: Sequence[ArrayLike] = (),
    next_to: str | None = None,
    orientations: ArrayLike | str | None = None,
    turn: bool = True,
    tilt: float = 5.0,
    approach: ArrayLike | None = None,
    cone: float = 0.0,
    gripper: ArrayLike | None = None,
    weights: Weights | None = None,
    friction: Friction | float | None = None,
    mass_margin: float = MASS_MARGIN,
    spacing: float = SPACING,
    confirm: EngineChoice | None = DEFAULT_ENGINE,
    imperfect: Imperfect | None = None,
) -> Placement:
    """Find a good pose for ``body`` in which everything stands; the pose that it already has is ignored.

    Several stable poses are compared: by the least push on the object and on what it rests on, and by the room about it
    to edges and neighbours (``Placement.rating``). A pose on a flat face comes before one on a facet of a round side,
    from which a round body would roll.

    Where it may be placed:

    - ``region`` [m]: the low and high corner of a box, (2, 3), or (2, 2) for its horizontal coordinates. The points of
      the scene on which the pose is built lie in it and so does, seen from above, the centre of mass.
    - ``supports``: names of the bodies on which the object may be placed; all by default. The pose is built on 1 to 3
      points of these bodies, and the object must touch ``least_supports`` of them. It may also lean on other bodies,
      but must not touch those named in ``avoid``.
    - ``keep_out``: regions [m], each given as ``region`` is, into which the object's convex hull must not reach.
    - ``next_to``: the name of a body beside which it must stand: at the same height, half its own size away at most.
    - ``orientations``: "upright" if the object's own third axis must point up, "any", or the allowed rotations
      (k, 3, 3), body frame to world, to within ``tilt`` [deg]. Each may also be turned about the vertical, unless
      ``turn`` is False. By default any orientation will do, but an upright one counts double.

    How it gets there:

    - ``approach`` (3,): the straight way in along this direction, for example (0, 0, -1), or along one within ``cone``
      [deg] of it, must be free.
    - ``gripper`` (2, 3) [m]: the low and the high corner of a box about the middle of the object's top, with the third
      coordinate up, which holds a gripper or a suction cup. On the same way in, straight down if none is given, it must
      meet nothing; it may be turned by quarter turns.

    How the search runs:

    - ``budget`` [s]: the longest time, everything included but what is compiled on first use. What there was no time
      for is left out, and the result says so. None means as long as it takes.
    - ``attempts`` end the search, and so do ``candidates`` stable poses; the best of them is returned.
    - ``seed``: the same seed gives the same answer, unless the budget ended the search.
    - ``weights`` bias the choice; see Weights.
    - ``spacing`` [m]: the distance between the points of all maps.
    - ``imperfect`` faces, as in ``robustness``: stable poses are then compared by ``lower``, which covers the samples,
      and so does ``lower`` of the result; forces stay ideal. With 32 samples each comparison takes about as long as 30
      maps.

    What must hold at the end:

    - ``friction``: the coefficient of the object with all bodies with which the scene's table does not pair it, or
      the whole table of the scene with the object. By default it is the scene's own table.
    - ``mass_margin``: everything must stand even if the object were heavier by this share.
    - ``confirm``: a second engine that must also find the pose stable, or None.

    If no place is found, the result says why. Raises SceneError if ``body`` is fixed, is not a Body or has the name of
    another body, and HoldfastError if an option is invalid or ``imperfect`` is asked of another engine than
    ``compliant``.
    """
    return planner(
        assembly, body, engine=engine, region=region, supports=supports, least_supports=least_supports, avoid=avoid,
        keep_out=keep_out, next_to=next_to, orientations=orientations, turn=turn, tilt=tilt, approach=approach,
        cone=cone, gripper=gripper, weights=weights, friction=friction,
        mass_margin=mass_margin, spacing=spacing, confirm=confirm, imperfect=imperfect,
    ).plan(
        seed=checked_whole(seed, "plan_placement: seed", 0, MOST_SEED),
        budget=None if budget is None else checked_number(budget, "plan_placement: budget", above=0),
        candidates=counted(candidates, "candidates"),
        attempts=counted(attempts, "attempts"),
    )  # fmt: skip


def planner(
    assembly: Assembly | Scene,
    body: Body,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    region: ArrayLike | None = None,
    supports: Sequence[str] | None = None,
    least_supports: int = 1,
    avoid: Sequence[str] = (),
    keep_out: Sequence[ArrayLike] = (),
    next_to: str | None = None,
    orientations: ArrayLike | str | None = None,
    turn: bool = True,
    tilt: float = 5.0,
    approach: ArrayLike | None = None,
    cone: float = 0.0,
    gripper: ArrayLike | None = None,
    weights: Weights | None = None,
    friction: Friction | float | None = None,
    mass_margin: float = MASS_MARGIN,
    spacing: float = SPACING,
    confirm: EngineChoice | None = DEFAULT_ENGINE,
    imperfect: Imperfect | None = None,
) -> Planner:
    """Return a planner that can be asked with many seeds; the arguments are those of ``plan_placement``."""
    assembly = checked_assembly(assembly)
    where = "plan_placement"
    _check_object(assembly, body)
    if weights is not None and not isinstance(weights, Weights):
        raise SceneError(message(f"{where}: weights", f"is {quoted(weights)}", "needs holdfast.sets.Weights(...)"))
    method = engine_of(engine)
    second = None if confirm is None else engine_of(confirm)
    up = assembly.scene.up
    every = tuple(body.name for body in assembly.bodies)
    options = Options(
        region=checked_region(region, up),
        supports=every if supports is None else names_of(assembly, supports, "supports"),
        least_supports=counted(least_supports, "least_supports"),
        avoid=names_of(assembly, avoid, "avoid"),
        orientations=checked_orientations(orientations, up),
        turn=checked_truth(turn, f"{where}: turn"),
        tilt=checked_number(tilt, f"{where}: tilt", minimum=0, within=BETWEEN),
        approach=None if approach is None else checked_direction(approach, f"{where}: approach"),
        prefer_upright=orientations is None,
        keep_out=checked_keep_out(keep_out, up),
        next_to=None if next_to is None else names_of(assembly, [next_to], "next_to")[0],
        cone=float(np.radians(checked_number(cone, f"{where}: cone", minimum=0, within=BETWEEN))),
        gripper=checked_gripper(gripper),
        weights=Weights() if weights is None else weights,
        friction=friction_with(assembly, [body], friction, every if supports is None else supports),
        mass_margin=checked_number(mass_margin, f"{where}: mass_margin", minimum=0, within=SCALE),
        spacing=checked_number(spacing, f"{where}: spacing", above=0, within=LENGTH),
        imperfect=imperfect,
    )
    covering(imperfect, method, assembly)  # which refuses what no map could be asked
    if options.least_supports > len(options.supports):
        problem = f"least_supports is {options.least_supports}, supports are {listed(options.supports)}"
        raise SceneError(message(where, problem, "ask for no more than there are"))
    names = {body.name} if body.material is None else {body.name, body.material}
    assembly = replace(assembly, absent=tuple(sorted({*assembly.absent, *names})))  # engines may be told of the body
    return Planner(assembly, body, method, None if second == method else second, options)


def _check_object(assembly: Assembly, body: Any) -> None:  # noqa: ANN401 - whatever the caller gave
    """Raise SceneError unless ``body`` can be placed in the scene."""
    where = "plan_placement"
    if not isinstance(body, Body):
        raise SceneError(message(where, f"body is a {type(body).__name__}", "needs a holdfast.Body with a mass"))
    if body.fixed:
        raise SceneError(message(where, f"body {quoted(body.name)} is fixed", "needs one that can be moved"))
    if any(other.name == body.name for other in assembly.bodies):
        raise SceneError(
            message(where, f"the scene has a body named {quoted(body.name)}", "give the object another name")
        )
