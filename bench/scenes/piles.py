"""Random piles of round bodies in closed geometry: rows of pipes, free, in boxes and in troughs, and pyramids of balls.

Gravity is not quite vertical, masses are unlike, and each row lies in the valleys of the one below.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.random import Generator

from bench.scenes.jams import at, floor
from holdfast.base.arrays import Float
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder, Sphere

SLANT = 4.0  # [deg] of gravity from the vertical, at most
MASSES = (0.5, 4.0)  # [kg]
SLIGHT = 1e-12  # [m] by which circles that touch may overlap
SHRINK = 0.97  # of a row's radii, until it fits


def free(rng: Generator) -> Scene:
    """Equal pipes that lie on each other and are held by friction alone."""
    return _finished(rng, _pipes(rng, _rows(rng, int(rng.integers(2, 4)), 0.0)), rough=0.4)


def boxed(rng: Generator) -> Scene:
    """Unlike pipes between two walls."""
    return _between(rng, 90.0)


def trough(rng: Generator) -> Scene:
    """Unlike pipes on a floor between two slanted boards."""
    return _between(rng, float(rng.uniform(40, 80)))


def balls(rng: Generator) -> Scene:
    """Four balls in a square box, and one on them."""
    r = rng.uniform(0.03, 0.06)
    top = r * rng.uniform(0.7, 1.4)
    high = r + np.sqrt((r + top) ** 2 - 2 * r**2)
    places = [(x * r, y * r, r, r) for x in (-1, 1) for y in (-1, 1)] + [(0.0, 0.0, high, top)]
    bodies = [Body(f"b{k}", Sphere(p[3]), mass=rng.uniform(*MASSES), pose=at(*p[:3])) for k, p in enumerate(places)]
    walls = [
        Body(f"wall{k}", Box((0.04, 0.6, 0.2) if x else (0.6, 0.04, 0.2)), pose=at(x, y, 0.1), fixed=True)
        for k, (x, y) in enumerate((2 * r + 0.02) * np.array([(-1, 0), (1, 0), (0, -1), (0, 1)]))
    ]
    return _finished(rng, [*walls, *bodies])


def _between(rng: Generator, slope: float) -> Scene:
    """Pipes between two boards of this slope [deg], each 20 mm thick, the middle beneath where it is touched."""
    rows, boards = _rows(rng, int(rng.integers(1, 4)), 0.1), []
    angle = np.radians(slope)
    for name, side, (foot, _, r) in (("left", -1, rows[0]), ("right", 1, max(rows, key=lambda row: row[0] - row[1]))):
        inward = np.array([-side * np.sin(angle), 0, np.cos(angle)])
        x, y, z = np.array([foot, 0, r]) - (r + 0.01) * inward
        boards.append(Body(name, Box((0.16, 0.8, 0.02)), pose=at(x, y, z, about_y=-side * angle), fixed=True))
    return _finished(rng, [*boards, *_pipes(rng, rows)])


def _rows(rng: Generator, courses: int, unlike: float) -> list[tuple[float, float, float]]:
    """(x, z, radius) [m] of circles in this many rows, whose radii differ by the share ``unlike``."""
    radius = rng.uniform(0.03, 0.06)
    count = int(rng.integers(max(2, courses), 5))
    row: list[tuple[float, float, float]] = []
    for r in radius * (1 - unlike * rng.random(count)):
        row.append((row[-1][0] + 2 * np.sqrt(row[-1][2] * r) if row else 0.0, r, r))
    found = list(row)
    for _ in range(courses - 1):
        radii = radius * (1 - unlike * rng.random(len(row) - 1))
        above = _valleys(row, radii)
        while any(np.hypot(b[0] - a[0], b[1] - a[1]) < a[2] + b[2] - SLIGHT for a, b in pairwise(above)):
            radii *= SHRINK
            above = _valleys(row, radii)
        found += above
        row = above
    return found


def _valleys(row: list[tuple[float, float, float]], radii: Float) -> list[tuple[float, float, float]]:
    """The circles that touch two neighbours of a row from above."""
    found = []
    for (x, z, r), (u, w, s), own in zip(row, row[1:], radii, strict=False):
        a, b, c = r + own, s + own, np.hypot(u - x, w - z)
        along = (a * a - b * b + c * c) / (2 * c)
        up = np.sqrt(a * a - along * along)
        ex, ez = (u - x) / c, (w - z) / c
        found.append((float(x + along * ex - up * ez), float(z + along * ez + up * ex), float(own)))
    return found


def _pipes(rng: Generator, circles: list[tuple[float, float, float]]) -> list[Body]:
    """Pipes along y of unlike lengths and masses."""
    return [
        Body(
            f"p{k}",
            Cylinder(r, rng.uniform(0.3, 0.5)),
            mass=rng.uniform(*MASSES),
            pose=at(x, rng.uniform(-0.03, 0.03), z, about_x=np.pi / 2),
        )
        for k, (x, z, r) in enumerate(circles)
    ]


def _finished(rng: Generator, bodies: list[Body], rough: float = 0.2) -> Scene:
    slant, way = np.radians(rng.uniform(0, SLANT)), rng.uniform(0, 2 * np.pi)
    gravity = 9.81 * np.array([np.sin(slant) * np.cos(way), np.sin(slant) * np.sin(way), -np.cos(slant)])
    return Scene([floor(), *bodies], rng.uniform(rough, 0.8), gravity=gravity)


PILES: tuple[Callable[[Generator], Scene], ...] = (free, boxed, trough, balls)
