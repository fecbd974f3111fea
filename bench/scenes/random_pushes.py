"""Random pushes on the exposed surfaces of an assembly, straight and slanted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, message
from holdfast.base.rigid import tangents
from holdfast.geometry.cells import Cells
from holdfast.queries.map import exposed_cells
from holdfast.queries.request import push_columns

CELLS = 8  # along the longest side of a body


class Push(NamedTuple):
    """A push on a body: ``point`` (3,) [m] on its surface and the unit ``direction`` (3,), world frame."""

    body: str
    point: Float
    direction: Float


def random_pushes(assembly: Assembly, rng: Generator, count: int, *, slant: float = 0.0) -> list[Push]:
    """Draw ``count`` pushes at exposed points of random movable bodies.

    Bodies are drawn with equal chances, points of a body in proportion to area. Directions are drawn evenly from the
    cone of those within ``slant`` degrees of the inward normal; with 0, all pushes are straight. Raises HoldfastError
    if the assembly has no exposed surface.
    """
    exposed = {}
    for body in assembly.movable:
        longest = float(np.ptp(body.surface_world.vertices, axis=0).max())
        cells, _ = exposed_cells(assembly, body.name, longest / CELLS)
        if len(cells.points):
            exposed[body.name] = cells
    if not exposed:
        raise HoldfastError(message("random pushes", "no movable body has an exposed surface", "give another assembly"))
    names = list(exposed)
    drawn = [names[k] for k in rng.integers(len(names), size=count)]
    return [_push(name, exposed[name], rng, slant) for name in drawn]


def _push(name: str, cells: Cells, rng: Generator, slant: float) -> Push:
    k = int(rng.choice(len(cells.points), p=cells.areas / cells.areas.sum()))
    inward = -cells.normals[k]
    cosine = rng.uniform(np.cos(np.radians(slant)), 1)  # even in solid angle
    around = rng.uniform(0, 2 * np.pi)
    first, second = tangents(inward)
    sideways = np.cos(around) * first + np.sin(around) * second
    return Push(name, cells.points[k], cosine * inward + np.sqrt(1 - cosine**2) * sideways)


def columns(assembly: Assembly, pushes: Sequence[Push]) -> Float:
    """Return the load columns W (6J, n) of pushes of 1 N."""
    parts = [push_columns(assembly, assembly.index[p.body], p.point[None], p.direction[None]) for p in pushes]
    return np.hstack(parts)
