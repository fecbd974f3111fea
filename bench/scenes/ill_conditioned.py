"""Ill-conditioned scenes with a largest push that is known to 50 digits: stacks of boxes on a floor.

Masses differ by up to a million, friction coefficients reach 10⁷, and boxes of a tenth of a millimetre lie on, under
and beside ones of ten metres. All lengths are multiples of 2⁻¹⁶ m, so that contacts are given without rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal

import numpy as np
from numpy.random import Generator

from bench.truth.stacked import Joint, Stacked, largest_push
from holdfast.assembly.assembly import Assembly, assemble
from holdfast.base.arrays import Float
from holdfast.base.rigid import wrench_at
from holdfast.contacts.interface import Interface
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box

STEP = 2.0**-16  # [m] all lengths are multiples of it
GRAVITY = 9.81
FLOOR = 64.0  # [m] side of the floor
INSET = 0.1  # share of a support that the centre of mass above it keeps from its edges at least


@dataclass(frozen=True)
class Query:
    """A load column ``load`` (6J,) on ``assembly`` and its largest factor ``truth``, to 50 digits."""

    assembly: Assembly
    load: Float
    truth: Decimal


def queries(family: str, rng: Generator, count: int) -> list[Query]:
    """Draw ``count`` queries of a family; each assembly answers several."""
    found: list[Query] = []
    while len(found) < count:
        found += FAMILIES[family](rng)
    return found[:count]


def _rounded(value: float) -> float:
    return max(round(value / STEP), 2) * STEP


def _stack(rng: Generator, sizes: Float, masses: Float, mu: Float, *, aligned: bool) -> tuple[Assembly, list[Stacked]]:
    """Return boxes of these sizes (n, 3) [m] on top of each other, shifted along x unless they are ``aligned``.

    Each box is put where the centre of mass of all that lies on it leaves it standing.
    """
    centres = np.zeros((len(sizes), 3))
    for k in reversed(range(len(sizes) - 1)):
        above = slice(k + 1, None)
        middle = float(masses[above] @ centres[above, 0] / masses[above].sum())
        half = min(sizes[k, 0], sizes[k + 1, 0]) / 2
        shift = 0.0 if aligned else float(rng.uniform(-1, 1)) * (1 - 2 * INSET) * half
        centres[k, 0] = round((middle + shift) / STEP) * STEP
    centres[:, 2] = np.cumsum(sizes[:, 2]) - sizes[:, 2] / 2
    centres[:, 0] -= centres[0, 0]
    bodies = [Body("floor", Box(np.array([FLOOR, FLOOR, 1.0])), pose=_at(np.array([0, 0, -0.5])), fixed=True)]
    interfaces, stack, pairs = [], [], {}
    low, high, under = np.full(2, -FLOOR / 2), np.full(2, FLOOR / 2), "floor"
    for k, (size, centre) in enumerate(zip(sizes, centres, strict=True)):
        name, z = f"box{k}", float(centre[2] - size[2] / 2)
        bodies.append(Body(name, Box(size), mass=float(masses[k]), pose=_at(centre)))
        mine = centre[:2] - size[:2] / 2, centre[:2] + size[:2] / 2
        first, last = np.maximum(low, mine[0]), np.minimum(high, mine[1])
        corners = [(first[0], first[1], z), (last[0], first[1], z), (last[0], last[1], z), (first[0], last[1], z)]
        interfaces.append(Interface((under, name), np.array(corners), (0, 0, 1)))
        pairs[under, name] = float(mu[k])
        joint = Joint(z, (first[0], first[1]), (last[0], last[1]), float(mu[k]))
        stack.append(Stacked(float(masses[k]), (centre[0], centre[1], centre[2]), joint))
        (low, high), under = mine, name
    scene = Scene(bodies, Friction(0.5, pairs=pairs), np.array([0, 0, -GRAVITY]))
    return assemble(scene, interfaces=interfaces), stack


def _at(centre: Float) -> Float:
    pose = np.eye(4)
    pose[:3, 3] = centre
    return pose


def _drawn(rng: Generator, *, aligned: bool) -> tuple[Assembly, list[Stacked], Float]:
    """Draw a stack: lengths from 10⁻⁴ to 10 m, mass ratios up to 10⁶, friction from 0.01 to 10⁷."""
    count = int(rng.integers(1, 5))
    usual = 10 ** rng.uniform(-4, 1, count)
    kind = rng.choice(3, p=(0.5, 0.3, 0.2))  # alike, the largest below, any order
    usual = (np.full(count, usual[0]), np.sort(usual)[::-1], usual)[kind]
    sizes = np.array([[_rounded(min(s * 10 ** rng.uniform(-0.5, 0.5), 16)) for _ in range(3)] for s in usual])
    masses = 10 ** rng.uniform(-3, 3, count)
    mu = 10 ** np.where(rng.random(count) < 0.5, rng.uniform(-1, 0.3, count), rng.uniform(-2, 7, count))
    assembly, stack = _stack(rng, sizes, masses, mu, aligned=aligned)
    return assembly, stack, sizes


def _asked(assembly: Assembly, stack: list[Stacked], pushed: int, point: Float, direction: Float) -> list[Query]:
    """Return the query of a unit push, or None if the stack does not stand or withstands any push."""
    wrench = wrench_at(direction, point, assembly.com[pushed])
    load = np.zeros(6 * len(assembly.movable))
    load[6 * pushed : 6 * pushed + 6] = wrench
    try:
        truth = largest_push(stack, pushed, wrench[:3].tolist(), wrench[3:].tolist(), GRAVITY)
    except ValueError:
        return []
    return [Query(assembly, load, truth)] if truth.is_finite() else []


def _in_plane(rng: Generator, angles: tuple[float, float]) -> list[Query]:
    """Push a shifted stack in its plane of symmetry, on faces and tops, by ``angles`` [degrees] from the horizontal."""
    assembly, stack, sizes = _drawn(rng, aligned=False)
    found = []
    for pushed in range(len(stack)):
        centre, half = assembly.com[pushed], sizes[pushed] / 2
        for side in (-1.0, 1.0):
            angle = np.radians(rng.uniform(*angles))
            place = round(float(rng.uniform(-1, 1)) * half[2] / STEP) * STEP
            direction = np.array([-side * np.cos(angle), 0.0, np.sin(angle)])
            point = centre + np.array([side * half[0], 0.0, place])
            found += _asked(assembly, stack, pushed, point, direction)
    return found


def level(rng: Generator) -> list[Query]:
    """Level pushes."""
    return _in_plane(rng, (0.0, 0.0))


def oblique(rng: Generator) -> list[Query]:
    """Pushes up to 80 degrees upwards or downwards."""
    return _in_plane(rng, (-80.0, 80.0))


def upright(rng: Generator) -> list[Query]:
    """Presses down and pulls up on the upper faces, anywhere along x."""
    assembly, stack, sizes = _drawn(rng, aligned=False)
    found = []
    for pushed in range(len(stack)):
        centre, half = assembly.com[pushed], sizes[pushed] / 2
        for sign in (-1.0, 1.0):
            along = round(float(rng.uniform(-1, 1)) * half[0] / STEP) * STEP
            point = centre + np.array([along, 0.0, half[2]])
            found += _asked(assembly, stack, pushed, point, np.array([0.0, 0.0, sign]))
    return found


def askew(rng: Generator) -> list[Query]:
    """Pushes in any direction through the common vertical axis of an aligned stack."""
    assembly, stack, sizes = _drawn(rng, aligned=True)
    found = []
    for pushed in range(len(stack)):
        for _ in range(2):
            direction = rng.normal(size=3)
            place = round(float(rng.uniform(-1, 1)) * sizes[pushed, 2] / 2 / STEP) * STEP
            point = assembly.com[pushed] + np.array([0.0, 0.0, place])
            found += _asked(assembly, stack, pushed, point, direction / np.linalg.norm(direction))
    return found


FAMILIES: Mapping[str, Callable[[Generator], list[Query]]] = {
    "level": level,
    "oblique": oblique,
    "upright": upright,
    "askew": askew,
}
