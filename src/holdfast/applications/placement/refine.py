"""Shift a stable pose on its supports to where there is more room around the object."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from holdfast.applications.placement.checks import Checks
from holdfast.applications.placement.margins import supporting_bodies
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.rigid import tangents

FIRST_STEP, LAST_STEP = 4.0, 0.05  # lengths of the longest and the shortest step, as shares of the object's size
AROUND = 8  # number of directions of a step
GAIN = 0.1  # smallest gain of room for which a step is made, as a share of the step


def refined(checks: Checks, after: Assembly, pose: Float, beneath: tuple[str, ...]) -> tuple[Float, Assembly]:
    """Return a pose with more room, and the assembly with the object in it, by a pattern search over horizontal steps.

    The longest steps lead across neighbours to other free places. The object keeps its orientation, its height and its
    supports, and everything stands at each step; contacts at its sides may open. ``after`` is the assembly with the
    object at ``pose`` (4, 4), where it rests on the bodies ``beneath``.
    """
    axes = np.array(tangents(checks.up))
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    ways = np.column_stack([np.cos(angles), np.sin(angles)]) @ axes
    name, size = checks.body.name, checks.body.size
    carriers = supporting_bodies(name, after.interfaces, checks.up)

    def room(new: Float) -> tuple[float, Callable[[], Assembly | None]]:
        fault, placed, contacts = checks.fits(new)
        if fault or supporting_bodies(name, contacts, checks.up) != carriers:
            return -1.0, lambda: None
        least = min(checks.room(placed, contacts, beneath))
        return least, lambda: checks.judged(checks.with_object(placed, contacts))[1]

    best, _ = room(pose)
    step = FIRST_STEP * size
    while step >= LAST_STEP * size:
        moved = False
        for way in ways:
            new = pose.copy()
            new[:3, 3] += step * way
            found, judge = room(new)
            if found > best + GAIN * step:
                stands = judge()
                if stands is not None:
                    pose, after, best, moved = new, stands, found, True
                    break
        if not moved:
            step /= 2
    return pose, after
