"""Ask for a placement: one call, or a planner that is asked with many seeds."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from holdfast.applications.placement.options import (
    Options,
    Weights,
    checked_direction,
    checked_orientations,
    checked_region,
    counted,
    names_of,
)
from holdfast.applications.placement.planner import MOST_ATTEMPTS, Planner
from holdfast.applications.placement.result import Placement
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import checked_number
from holdfast.base.errors import SceneError, message
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene

SPACING = 0.01  # [m] between the points of a map
MASS_MARGIN = 0.1  # share of its weight by which the object may be heavier than it was said to be


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
) -> Placement:
    """Find a pose for ``body`` in which everything stands; its own pose is of no account.

    ``region`` [m]: low and high corner of a box, (2, 2) horizontal or (2, 3): the points of the scene that the pose is
    built on lie in it, and, seen from above, the centre of mass. ``budget`` [s], maps of the scene included, and
    ``attempts`` end the search, after one try at the earliest; the same ``seed`` gives the same answer unless the time
    cut it short. ``candidates``: the best of that many stable poses. ``supports``: names of the bodies it may be built
    on (all unless given), of which it must touch ``least_supports`` (1 to 3 points are built on; it may lean on others
    besides, but for those named in ``avoid``).
    ``orientations`` (k, 3, 3): allowed rotations, body to world, each turned about the vertical as may be unless
    ``turn`` is False, to within ``tilt`` [deg]. ``approach`` (3,): the straight way in, for instance (0, 0, -1), must
    be free. ``weights`` bias the choice. ``friction``: the table of the scene with the object, where the scene's own
    does not name it. Everything must stand even if the object were heavier by the share ``mass_margin``. ``spacing``
    [m] is that of all maps. ``confirm``: the engine that also has to find the pose stable, or None.
    """
    return planner(
        assembly, body, engine=engine, region=region, supports=supports, least_supports=least_supports, avoid=avoid,
        orientations=orientations, turn=turn, tilt=tilt, approach=approach, weights=weights,
        friction=friction, mass_margin=mass_margin, spacing=spacing, confirm=confirm,
    ).plan(
        seed=seed,
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
) -> Planner:
    """A planner to be asked with many seeds; arguments as of ``plan_placement``."""
    assembly = checked_assembly(assembly)
    where = "plan_placement"
    if not isinstance(body, Body):
        raise SceneError(message(where, f"body is a {type(body).__name__}", "needs a holdfast.Body with a mass"))
    if body.fixed:
        raise SceneError(message(where, f"body {body.name!r} is fixed", "needs one that can be moved"))
    if any(other.name == body.name for other in assembly.bodies):
        raise SceneError(message(where, f"the scene has a body named {body.name!r}", "give the object another name"))
    if weights is not None and not isinstance(weights, Weights):
        raise SceneError(message(f"{where}: weights", f"is {weights!r:.60}", "needs holdfast.Weights(...)"))
    method = engine_of(engine)
    second = None if confirm is None else engine_of(confirm)
    up = assembly.scene.up
    options = Options(
        checked_region(region, up),
        tuple(body.name for body in assembly.bodies) if supports is None else names_of(assembly, supports, "supports"),
        counted(least_supports, "least_supports"),
        names_of(assembly, avoid, "avoid"),
        checked_orientations(orientations),
        bool(turn),
        checked_number(tilt, f"{where}: tilt", minimum=0),
        None if approach is None else checked_direction(approach),
        Weights() if weights is None else weights,
        _friction(assembly, friction),
        checked_number(mass_margin, f"{where}: mass_margin", minimum=0),
        checked_number(spacing, f"{where}: spacing", above=0),
    )
    if options.least_supports > len(options.supports):
        problem = f"least_supports is {options.least_supports}, supports are {', '.join(options.supports)}"
        raise SceneError(message(where, problem, "ask for no more than there are"))
    return Planner(assembly, body, method, None if second == method else second, options)


def _friction(assembly: Assembly, given: Friction | float | None) -> Friction:
    if given is None:
        return assembly.scene.friction
    return given if isinstance(given, Friction) else Friction(given)
