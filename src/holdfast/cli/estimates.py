"""Estimate the cost of another engine on a large scene, and print it before the answer."""

from __future__ import annotations

import time
from collections.abc import Sequence

from holdfast.assembly.assembly import Assembly
from holdfast.base.errors import HoldfastError
from holdfast.cli.output import err
from holdfast.engines.contract import Engine
from holdfast.queries.map import expected_points
from holdfast.queries.push import robustness

LARGE = 25  # number of bodies in a group from which load paths may cost several cone programs
SLOW = "compliant"  # the engine whose cost grows fastest with the number of bodies in a group
QUICK = "limit"  # the engine that solves one cone program for each push


def print_cost_of_limit(assembly: Assembly, bodies: Sequence[str] | None, spacing: float, engine: Engine) -> None:
    """Print to stderr what a map would cost by engine ``limit``, if a group is large and the engine is ``compliant``.

    One push is solved twice; only the second time counts, because in a map the group is prepared only once.
    """
    mapped = [body.name for body in assembly.movable] if bodies is None else bodies
    grouped = [(len(group), name) for group in assembly.groups for name in mapped if name in group]
    size, name = max(grouped, default=(0, ""))
    if engine.name != SLOW or size < LARGE:
        return
    place = assembly.scene.body(name).surface_world.vertices[0]
    seconds = 0.0
    for _ in range(2):
        start = time.perf_counter()
        try:
            robustness(assembly, name, place, (1, 0, 0), engine=QUICK)
        except HoldfastError:  # the map may work without the estimate
            return
        seconds = time.perf_counter() - start
    known = [name for name in mapped if name in assembly.scene.names]
    points = expected_points(assembly, known, spacing)
    err.say(
        f"{size} bodies hold each other here: --engine {QUICK} takes about {1000 * seconds:.0f} ms a push, "
        f"{points * seconds:,.0f} s for all {points:,.0f} points, and proves its bounds"
    )
