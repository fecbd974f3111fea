"""Plan a placement: with one call, or with a planner that can be asked with many seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from numpy.typing import ArrayLike

from holdfast.applications.placement.options import (
    Options,
    Weights,
    checked_orientations,
    checked_region,
    counted,
    names_of,
)
from holdfast.applications.placement.planner import MOST_ATTEMPTS, Planner
from holdfast.applications.placement.result import Placement
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_direction, checked_number, checked_whole
from holdfast.base.errors import SceneError, message
from holdfast.base.ranges import ANGLE, LENGTH, MOST_SEED, SCALE
from holdfast.base.text import listed, quoted
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.imperfect import covering
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene

SPACING = 0.01  # [m] distance between the points of a robustness map
MASS_MARGIN = 0.1  # share of its weight by which the object may be heavier than stated


def plan_placement(
    assembly: Assembly | Scene,
    body: Body,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    region: ArrayLike | None = None,
    budget: float | None = None,
    seed: int = 0,
    candidates: int = 1,
    attempts: int = MOST_ATTEMPTS,
    supports: Sequence[str] | None = None,
    least_supports: int = 1,
    avoid: Sequence[str] = (),
    orientations: ArrayLike | None = None,
    turn: bool = True,
    tilt: float = 5.0,
    approach: ArrayLike | None = None,
    weights: Weights | None = None,
    friction: Friction | float | None = None,
    mass_margin: float = MASS_MARGIN,
    spacing: float = SPACING,
    confirm: EngineChoice | None = DEFAULT_ENGINE,
    imperfect: Imperfect | None = None,
) -> Placement:
    """Find a pose for ``body`` in which everything stands; the pose that it already has is ignored.

    Where it may be placed:

    - ``region`` [m]: the low and high corner of a box, (2, 3), or (2, 2) for its horizontal coordinates. The points of
      the scene on which the pose is built lie in it and so does, seen from above, the centre of mass.
    - ``supports``: names of the bodies on which the object may be placed; all by default. The pose is built on 1 to 3
      points of these bodies, and the object must touch ``least_supports`` of them. It may also lean on other bodies,
      but must not touch those named in ``avoid``.
    - ``orientations`` (k, 3, 3): the allowed rotations, body frame to world, to within ``tilt`` [deg]. Each may also be
      turned about the vertical, unless ``turn`` is False.
    - ``approach`` (3,): the straight way in along this direction, for example (0, 0, -1), must be free.

    How the search runs:

    - ``budget`` [s], which includes the maps of the scene, and ``attempts`` end the search, but not before one attempt.
    - ``seed``: the same seed gives the same answer, unless the search ran out of time.
    - ``candidates``: the search stops after this many stable poses and returns the best of them.
    - ``weights`` bias the choice; see Weights.
    - ``spacing`` [m]: the distance between the points of all maps.
    - ``imperfect`` faces, as in ``robustness``: stable poses are then compared by ``lower``, which covers the samples,
      and so does ``lower`` of the result; forces stay ideal. With 32 samples each comparison takes about as long as 30
      maps.

    What must hold at the end:

    - ``friction``: the table of the scene with the object. By default it is the scene's own table.
    - ``mass_margin``: everything must stand even if the object were heavier by this share.
    - ``confirm``: a second engine that must also find the pose stable, or None.

    If no place is found, the result says why. Raises SceneError if ``body`` is fixed, is not a Body or has the name of
    another body, and HoldfastError if an option is invalid or ``imperfect`` is asked of another engine than
    ``compliant``.
    """
    return planner(
        assembly, body, engine=engine, region=region, supports=supports, least_supports=least_supports, avoid=avoid,
        orientations=orientations, turn=turn, tilt=tilt, approach=approach, weights=weights,
        friction=friction, mass_margin=mass_margin, spacing=spacing, confirm=confirm, imperfect=imperfect,
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
    orientations: ArrayLike | None = None,
    turn: bool = True,
    tilt: float = 5.0,
    approach: ArrayLike | None = None,
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
    if not isinstance(body, Body):
        raise SceneError(message(where, f"body is a {type(body).__name__}", "needs a holdfast.Body with a mass"))
    if body.fixed:
        raise SceneError(message(where, f"body {quoted(body.name)} is fixed", "needs one that can be moved"))
    if any(other.name == body.name for other in assembly.bodies):
        raise SceneError(
            message(where, f"the scene has a body named {quoted(body.name)}", "give the object another name")
        )
    if weights is not None and not isinstance(weights, Weights):
        raise SceneError(message(f"{where}: weights", f"is {quoted(weights)}", "needs holdfast.Weights(...)"))
    method = engine_of(engine)
    second = None if confirm is None else engine_of(confirm)
    up = assembly.scene.up
    every = tuple(body.name for body in assembly.bodies)
    options = Options(
        region=checked_region(region, up),
        supports=every if supports is None else names_of(assembly, supports, "supports"),
        least_supports=counted(least_supports, "least_supports"),
        avoid=names_of(assembly, avoid, "avoid"),
        orientations=checked_orientations(orientations),
        turn=bool(turn),
        tilt=checked_number(tilt, f"{where}: tilt", minimum=0, within=ANGLE),
        approach=None if approach is None else checked_direction(approach, f"{where}: approach"),
        weights=Weights() if weights is None else weights,
        friction=_friction(assembly, friction),
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


def _friction(assembly: Assembly, given: Friction | float | None) -> Friction:
    if given is None:
        return assembly.scene.friction
    return given if isinstance(given, Friction) else Friction(given)
