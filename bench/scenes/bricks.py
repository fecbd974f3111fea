"""Random models of toy bricks that hold by their studs, and a linear program that knows nothing of holdfast.

Bricks lie on a grid of studs and layers. Where one covers studs of another, a rectangle of them, that face resists
being pulled apart by a tension; all other faces are apart by a gap that nobody counts as a contact.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

import holdfast as hf

PITCH, LAYER, GAP = 8e-3, 9.6e-3, 0.2e-3  # [m]: studs are 8 mm apart, a brick is 9.6 mm high
DENSITY = 570.0  # [kg/m³] of a brick with its hollows: 2 x 4 studs weigh 2.3 g
SIZES = ((2, 4), (4, 2), (2, 2), (1, 2), (2, 1), (1, 4), (4, 1), (2, 6), (6, 2))
MU, GRAVITY = 0.5, 9.81
BASE = 8  # studs along each side of the plate on which all stands


Place: TypeAlias = NDArray[np.float64]


class Brick(NamedTuple):
    """A brick by its first stud, its layer and its number of studs along x and y."""

    x: int
    y: int
    z: int
    wide: int
    deep: int


def random_bricks(rng: np.random.Generator, count: int) -> list[Brick]:
    """Up to ``count`` bricks, each on studs of the plate or above or below one that was there before."""
    found: list[Brick] = []
    taken: set[tuple[int, int, int]] = set()
    for _ in range(50 * count):
        if len(found) == count:
            break
        wide, deep = SIZES[rng.integers(len(SIZES))]
        if not found or rng.random() < 0.1:
            x, y = rng.integers(0, (BASE - wide + 1, BASE - deep + 1))
            brick = Brick(int(x), int(y), 0, wide, deep)
        else:
            other = found[rng.integers(len(found))]
            x = other.x + rng.integers(1 - wide, other.wide)
            y = other.y + rng.integers(1 - deep, other.deep)
            brick = Brick(int(x), int(y), other.z + (1 if rng.random() < 0.7 else -1), wide, deep)
        own = {(brick.x + i, brick.y + j, brick.z) for i in range(wide) for j in range(deep)}
        if brick.z >= 0 and not own & taken:
            found.append(brick)
            taken |= own
    return found


def scene_of(bricks: list[Brick], tension: float) -> hf.Scene:
    """The model on its plate, with this tension [Pa] on all studs."""
    plate = np.array([BASE + 40, BASE + 40, 1]) * (PITCH, PITCH, LAYER)
    middle = np.array([BASE / 2 * PITCH, BASE / 2 * PITCH, -LAYER / 2])
    bodies = [hf.Body("plate", hf.Box(plate), position=middle, fixed=True, material="stud")]
    for k, brick in enumerate(bricks):
        low, high = _corners(brick)
        body = hf.Body(f"brick{k}", hf.Box(high - low), DENSITY * _volume(brick), position=(low + high) / 2)
        bodies.append(hf.Body(body.name, body.shape, body.mass, pose=body.pose, material="stud"))
    table = hf.Friction(MU, tension={("stud", "stud"): tension} if tension > 0 else {})
    return hf.Scene(bodies, table, gravity=(0, 0, -GRAVITY))


def _volume(brick: Brick) -> float:
    return brick.wide * brick.deep * PITCH**2 * LAYER


def _corners(brick: Brick) -> tuple[Place, Place]:
    low = np.array([brick.x * PITCH + GAP / 2, brick.y * PITCH + GAP / 2, brick.z * LAYER])
    size = np.array([brick.wide * PITCH - GAP, brick.deep * PITCH - GAP, LAYER])
    return low, low + size


def least_tension(bricks: list[Brick], sides: int, *, inside: bool) -> float:
    """The least tension [Pa] with which the model stands, inf if none does; ``MU`` as a polygon of ``sides``.

    Forces act at the corners of the rectangles that touch. With a polygon ``inside`` the cone the model needs no less,
    with one around it no more.
    """
    touching = list(_rectangles(bricks))
    count, unit = len(bricks), DENSITY * _volume(Brick(0, 0, 0, 2, 4)) * GRAVITY
    angles = 2 * np.pi * (np.arange(sides) + (0.5 if inside else 0.0)) / sides
    radius = MU if inside else MU / np.cos(np.pi / sides)
    rays = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.ones(sides)])  # generators
    columns, pull = [], np.zeros(6 * count)
    for below, above, low, high in touching:
        middle, area = (low + high) / 2, float(np.prod((high - low)[:2]))
        corners = [np.array([x, y, low[2]]) for x in (low[0], high[0]) for y in (low[1], high[1])]
        columns += [_wrench(bricks, below, above, point, ray) for point in corners for ray in rays]
        pull += _wrench(bricks, below, above, middle, np.array([0, 0, -area]))
    weight = np.zeros((count, 6))
    weight[:, 2] = [-DENSITY * _volume(brick) * GRAVITY for brick in bricks]
    scale = np.tile([1, 1, 1, 1 / PITCH, 1 / PITCH, 1 / PITCH], count) / unit
    tension = unit / PITCH**2
    A = np.column_stack([np.array(columns).T * unit, pull * tension]) * scale[:, None]
    c = np.zeros(A.shape[1])
    c[-1] = 1.0
    found = linprog(c, A_eq=A, b_eq=-weight.ravel() * scale, method="highs")
    if found.status == 2:
        return np.inf
    if found.status != 0 or found.x is None:
        raise RuntimeError(found.message)
    return float(found.x[-1]) * tension


def _rectangles(bricks: list[Brick]) -> Iterator[tuple[int, int, Place, Place]]:
    """Yield what touches: the number of the lower brick (-1: the plate) and of the upper one, and two corners."""
    for k, above in enumerate(bricks):
        low, high = _corners(above)
        if above.z == 0:
            yield -1, k, low, np.array([high[0], high[1], low[2]])
        for j, below in enumerate(bricks):
            if below.z != above.z - 1:
                continue
            its_low, its_high = _corners(below)
            first, last = np.maximum(low, its_low), np.minimum(high, its_high)
            if (last[:2] > first[:2] + GAP).all():
                yield j, k, np.array([first[0], first[1], low[2]]), np.array([last[0], last[1], low[2]])


def _wrench(bricks: list[Brick], below: int, above: int, point: Place, force: Place) -> Place:
    """What a force at a point on the upper brick, and its opposite on the lower one, do to all bricks."""
    found = np.zeros((len(bricks), 6))
    for number, sign in ((above, 1.0), (below, -1.0)):
        if number >= 0:
            low, high = _corners(bricks[number])
            found[number] = sign * np.concatenate([force, np.cross(point - (low + high) / 2, force)])
    return found.ravel()
