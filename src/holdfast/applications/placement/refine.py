"""Shift a stable pose on its supports to where there is more room around the object."""

from __future__ import annotations

import numpy as np

from holdfast.applications.pattern_search import AROUND, around, pattern_search
from holdfast.applications.placement.checks import Checks
from holdfast.applications.placement.margins import supporting_bodies
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.rigid import tangents
from holdfast.contacts.interface import Interface
from holdfast.scene.body import Body

FIRST_STEP, LAST_STEP = 4.0, 0.05  # lengths of the longest and the shortest step, as shares of the object's size
GAIN = 0.1  # smallest gain of room for which a step is made, as a share of the step

Place = tuple[Float, Assembly, float]  # a pose (4, 4), the assembly with the object there, the room around it


def refined(checks: Checks, after: Assembly, pose: Float, beneath: tuple[str, ...]) -> tuple[Float, Assembly]:
    """Return a pose with more room, and the assembly with the object in it, by a pattern search over horizontal steps.

    The longest steps lead across neighbours to other free places. The object keeps its orientation, its height and its
    supports, and everything stands at each step; contacts at its sides may open. ``after`` is the assembly with the
    object at ``pose`` (4, 4), where it rests on the bodies ``beneath``.
    """
    ways = around(np.array(tangents(checks.up)))
    name, size = checks.body.name, checks.body.size
    carriers = supporting_bodies(name, after.interfaces, checks.up)

    def room(at: Float) -> tuple[float, Body, tuple[Interface, ...]]:
        fault, placed, contacts = checks.fits(at)
        if fault or supporting_bodies(name, contacts, checks.up) != carriers:
            return -1.0, placed, contacts
        return min(checks.room(placed, contacts, beneath)), placed, contacts

    def better(place: Place, way: int, step: float) -> Place | None:
        new = place[0].copy()
        new[:3, 3] += step * ways[way]
        found, placed, contacts = room(new)
        if found <= place[2] + GAIN * step:
            return None
        stands = checks.judged(checks.with_object(placed, contacts))[1]
        return None if stands is None else (new, stands, found)

    start = pose, after, room(pose)[0]
    return pattern_search(start, better, AROUND, first=FIRST_STEP * size, last=LAST_STEP * size)[:2]
