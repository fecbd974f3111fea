"""Seeded pushes that benchmarks ask every method about."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float
from holdfast.scene.scene import Scene


class Pushes(NamedTuple):
    """Pushes on one body: ``points`` (n, 3) [m] and outward ``normals`` (n, 3), world axes."""

    body: str
    points: Float
    normals: Float


def on_boxes(scene: Scene, names: Sequence[str], count: int, seed: int) -> list[Pushes]:
    """``count`` pushes spread evenly over the surfaces of boxes that are not turned."""
    random = np.random.default_rng(seed)
    surfaces = [scene.body(name).surface_world for name in names]
    boxes = [(s.vertices.min(0), np.ptp(s.vertices, axis=0)) for s in surfaces]
    areas = np.array([2 * (x * y + y * z + z * x) for _, (x, y, z) in boxes])
    found = []
    for name, (low, size), number in zip(names, boxes, random.multinomial(count, areas / areas.sum()), strict=True):
        sides = np.array([size[1] * size[2], size[2] * size[0], size[0] * size[1]])
        axis = random.choice(3, number, p=sides / sides.sum())
        normals = np.zeros((number, 3))
        normals[np.arange(number), axis] = random.choice([-1.0, 1.0], number)
        share = random.random((number, 3))
        share[np.arange(number), axis] = (normals[np.arange(number), axis] + 1) / 2
        found.append(Pushes(name, low + share * size, normals))
    return found
