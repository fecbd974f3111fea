"""Scenes, queries and an independent dense G that the tests of engine ``limit`` share."""

from __future__ import annotations

import numpy as np
from engine_scenes import Array, push_wrench, random_pushes
from numpy.typing import ArrayLike

from holdfast import Limit, Load, load_factor, robustness
from holdfast.answers import Assembly, Robustness

BEYOND_DOUBLE = np.finfo(np.longdouble).eps < 2e-19  # whether numpy has more digits, as on most processors


def push(assembly: Assembly, body: str, point: ArrayLike, direction: ArrayLike, **options: object) -> Robustness:
    """One push by ``Limit(**options)``."""
    return robustness(assembly, body, point, direction, engine=Limit(**options))  # type: ignore[arg-type]


def strength(assembly: Assembly, body: str, point: ArrayLike, direction: ArrayLike, **options: object) -> float:
    return float(push(assembly, body, point, direction, **options).force[0])


def transport(assembly: Assembly, direction: Array, engine: str = "limit") -> float:
    """The largest acceleration of the support along ``direction`` [m/s2]."""
    loads = [Load(body.name, body.com_world, -body.mass * direction) for body in assembly.movable]
    return load_factor(assembly, loads, engine=engine).factor


def corners(assembly: Assembly) -> list[tuple[int, int, Array, Array, float]]:
    """(body a, body b, corner, normal into b, μ) of every outline corner of every patch; -1 is fixed."""
    found = []
    for interface in assembly.interfaces:
        a, b = (assembly.index[name] for name in interface.bodies)
        mu = assembly.scene.mu(*interface.bodies)
        found += [(a, b, p, patch.normal, mu) for patch in interface.patches for p in patch.polygon]
    return found


def dense_operator(assembly: Assembly) -> tuple[Array, Array, Array]:
    """World G (6J, 3I), normals (I, 3) and μ (I,), from the definition: force at p on b, its opposite on a."""
    contacts = corners(assembly)
    G = np.zeros((6 * len(assembly.movable), 3 * len(contacts)))
    for i, (a, b, p, _, _) in enumerate(contacts):
        for k, sign in ((a, -1.0), (b, 1.0)):
            if k >= 0:
                x, y, z = p - assembly.movable[k].com_world
                cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                G[6 * k : 6 * k + 6, 3 * i : 3 * i + 3] = sign * np.vstack([np.eye(3), cross])
    return G, np.array([c[3] for c in contacts]), np.array([c[4] for c in contacts])


def weights(assembly: Assembly) -> Array:
    """(6J,) weight of every body."""
    parts = [np.r_[body.mass * assembly.scene.gravity, 0, 0, 0] for body in assembly.movable]
    return np.concatenate(parts)


def columns(assembly: Assembly, count: int, seed: int) -> Array:
    """(6J, count) unit pushes at random."""
    return np.column_stack([push_wrench(assembly, *query) for query in random_pushes(assembly, count, seed)])
