"""Plan a placement with one call, or with a planner that can be used with many seeds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from holdfast.applications.placement.conditions import ATTEMPTS, Approach, Search, Where, checked_value
from holdfast.applications.placement.options import (
    Options,
    checked_keep_out,
    checked_orientations,
    checked_region,
    names_of,
)
from holdfast.applications.placement.placed_friction import friction_with
from holdfast.applications.placement.planner import Planner
from holdfast.applications.placement.result import Placement
from holdfast.assembly.assembly import Assembly
from holdfast.base.errors import SceneError, hinting, message
from holdfast.base.text import listed, quoted
from holdfast.engines.imperfect import Imperfect
from holdfast.queries.imperfect_bounds import covering
from holdfast.queries.request import DEFAULT_ENGINE, EngineChoice, checked_assembly, engine_of
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

NAME = "plan_placement"


@hinting(where=Where, approach=Approach, search=Search)
def plan_placement(
    assembly: Assembly | Scene,
    obj: Body,
    where: Where | None = None,
    approach: Approach | None = None,
    search: Search | None = None,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    friction: Friction | float | None = None,
    imperfect: Imperfect | None = None,
) -> Placement:
    """Find a good pose for ``obj`` in which everything stands; the pose that it already has is ignored.

    Several stable poses are compared: by the smallest push that moves the object or its supports, and by the room to
    edges and neighbours (``Placement.rating``). Poses on flat faces rank before poses on a facet of a round side, from
    which a round body would roll.

    - ``where``, ``approach`` and ``search`` say where the object may be placed, how it gets there, and how long to
      search: see Where, Approach and Search. By default any place, orientation and way in is allowed, and the search
      takes at most 60 s.
    - ``friction``: the coefficient of the object with all bodies with which the scene's table does not pair it, or
      the whole table of the scene with the object. By default it is the scene's own table.
    - ``imperfect``: imperfect faces, as in ``robustness``. Stable poses are then compared by ``lower``, which holds on
      the samples, as does ``lower`` of the result; forces remain those of ideal faces. With 32 samples, a comparison
      takes about as long as 30 maps.

    If no place is found, the result says why. Raises SceneError if ``obj`` is fixed, is not a Body or has the name of
    another body, and HoldfastError if an option is invalid or ``imperfect`` is given for an engine other than
    ``compliant``.
    """
    place, how = checked_value(where, Where, f"{NAME}: where"), checked_value(search, Search, f"{NAME}: search")
    if place.apart is not None:
        raise SceneError(message(f"{NAME}: where", "has apart", "it is the distance between several: ask place_all"))
    return planner(
        assembly, obj, place, approach, how, engine=engine, friction=friction, imperfect=imperfect
    ).plan(
        seed=how.seed,
        seconds=how.limit,
        candidates=how.candidates,
        attempts=ATTEMPTS if how.solves is None else how.solves,
    )  # fmt: skip


def planner(
    assembly: Assembly | Scene,
    obj: Body,
    where: Where | None = None,
    approach: Approach | None = None,
    search: Search | None = None,
    *,
    engine: EngineChoice = DEFAULT_ENGINE,
    friction: Friction | float | None = None,
    imperfect: Imperfect | None = None,
) -> Planner:
    """Return a planner that can be used with many seeds; the arguments are those of ``plan_placement``."""
    assembly = checked_assembly(assembly)
    refuse_holds(assembly.scene.holds, "plan_placement", "place into the scene without them")
    place = checked_value(where, Where, f"{NAME}: where")
    way = checked_value(approach, Approach, f"{NAME}: approach")
    how = checked_value(search, Search, f"{NAME}: search")
    _check_object(assembly, obj)
    method = engine_of(engine)
    second = None if how.confirm is None else engine_of(how.confirm)
    up = assembly.scene.up
    every = tuple(body.name for body in assembly.bodies)
    supports = every if place.supports is None else names_of(assembly, place.supports, "supports")
    options = Options(
        box=checked_region(place.box, up),
        supports=supports,
        least_supports=place.least_supports,
        avoid=names_of(assembly, place.avoid, "avoid"),
        orientations=checked_orientations(way.orientations, up),
        free_yaw=way.free_yaw,
        lean_degrees=way.lean_degrees,
        approach=way.way,
        prefer_upright=way.orientations is None,
        keep_out=checked_keep_out(place.keep_out, up),
        next_to=None if place.next_to is None else names_of(assembly, [place.next_to], "next_to")[0],
        cone=float(np.radians(way.cone_degrees)),
        gripper=way.hand,
        weights=how.weights,
        friction=friction_with(assembly, [obj], friction, supports),
        mass_margin=how.mass_margin,
        spacing=how.spacing,
        imperfect=imperfect,
    )
    covering(imperfect, method, assembly)  # raises an error if the engine does not take imperfect faces
    if options.least_supports > len(options.supports):
        problem = f"least_supports is {options.least_supports}, supports are {listed(options.supports)}"
        raise SceneError(message("Where", problem, "ask for no more than there are"))
    names = {obj.name} if obj.material is None else {obj.name, obj.material}
    assembly = replace(
        assembly, absent=tuple(sorted({*assembly.absent, *names}))
    )  # an engine may have options that name the new body
    return Planner(assembly, obj, method, None if second == method else second, options)


def _check_object(assembly: Assembly, obj: Any) -> None:  # noqa: ANN401 - any argument of a caller
    """Raise SceneError unless ``obj`` can be placed in the scene."""
    where = NAME
    if not isinstance(obj, Body):
        raise SceneError(message(where, f"obj is a {type(obj).__name__}", "needs a holdfast.Body with a mass"))
    if obj.fixed:
        raise SceneError(message(where, f"body {quoted(obj.name)} is fixed", "needs one that can be moved"))
    if any(other.name == obj.name for other in assembly.bodies):
        raise SceneError(
            message(where, f"the scene has a body named {quoted(obj.name)}", "give the object another name")
        )
