"""Blocks, scenes, their motions and pushes on them, which the tests of all engines share."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holdfast import Body, Box, Compliant, Mesh, Scene, assemble
from holdfast.answers import Assembly
from holdfast.scene.shipped import shipped_scene

Array = NDArray[np.float64]

G0 = 9.81  # [m/s2]
X, Y, Z = np.eye(3)


def pose(centre: ArrayLike, rotation: Array | None = None) -> Array:
    result = np.eye(4)
    result[:3, :3] = np.eye(3) if rotation is None else rotation
    result[:3, 3] = centre
    return result


def block(name: str, size: ArrayLike, centre: ArrayLike, mass: float = 1.0, *, fixed: bool = False) -> Body:
    return Body(name, Box(np.asarray(size, dtype=float)), mass=None if fixed else mass, pose=pose(centre), fixed=fixed)


def floor(side: float = 2.0) -> Body:
    return block("floor", (side, side, 0.1), (0, 0, -0.05), fixed=True)


def cube_scene(mu: float = 0.6, mass: float = 1.0, gravity: ArrayLike = (0, 0, -G0), height: float = 0.1) -> Scene:
    body = block("cube", (0.1, 0.1, height), (0, 0, height / 2), mass)
    return Scene([floor(), body], mu, np.asarray(gravity, dtype=float))


def cube(mu: float = 0.6, mass: float = 1.0, gravity: ArrayLike = (0, 0, -G0), height: float = 0.1) -> Assembly:
    return assemble(cube_scene(mu, mass, gravity, height))


@cache
def shipped(name: str) -> Assembly:
    return assemble(shipped_scene(name))


def surface_points(body: Body, count: int, rng: np.random.Generator) -> Array:
    surface = body.surface_world
    corners = surface.vertices[surface.faces[rng.integers(len(surface.faces), size=count)]]
    return np.asarray(np.einsum("nk,nkx->nx", rng.dirichlet([2, 2, 2], count), corners))


def moved(scene: Scene, motion: Array, *, order: Sequence[int] | None = None, prefix: str = "") -> Scene:
    """The scene after a rigid motion, gravity too; optionally its bodies in another order and renamed."""
    bodies = []
    for k in range(len(scene.bodies)) if order is None else order:
        b = scene.bodies[k]
        bodies.append(Body(prefix + b.name, b.shape, mass=b.mass, com=b.com, pose=motion @ b.pose, fixed=b.fixed))
    return Scene(bodies, scene.friction, motion[:3, :3] @ scene.gravity)


def rescaled(scene: Scene, length: float = 1.0, mass: float = 1.0) -> Scene:
    """All lengths and all masses times a factor each."""
    bodies = []
    for b in scene.bodies:
        placed = np.array(b.pose)
        placed[:3, 3] *= length
        shape = Mesh(b.shape.surface.vertices * length, b.shape.surface.faces) if length != 1 else b.shape
        com = None if b.com is None else b.com * length
        bodies.append(Body(b.name, shape, mass=None if b.fixed else mass * b.mass, com=com, pose=placed, fixed=b.fixed))
    return Scene(bodies, scene.friction, scene.gravity)


def random_pushes(assembly: Assembly, count: int, seed: int) -> list[tuple[str, Array, Array]]:
    """(body, point, unit direction): half of them level, where answers are finite."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        body = assembly.movable[rng.integers(len(assembly.movable))]
        direction = rng.normal(size=3) * (1, 1, k % 2)
        found.append((body.name, surface_points(body, 1, rng)[0], direction / np.linalg.norm(direction)))
    return found


def push_wrench(assembly: Assembly, body: str, point: ArrayLike, force: ArrayLike) -> Array:
    """(6J,) of a force at a point."""
    total = np.zeros((len(assembly.movable), 6))
    k = [b.name for b in assembly.movable].index(body)
    total[k, :3] = force
    total[k, 3:] = np.cross(np.asarray(point) - assembly.movable[k].com_world, force)
    return total.ravel()


def by_paths(assembly: Assembly, **options: Any) -> Compliant:
    """Engine compliant where no tree answers in its place: with a stiffness for one pair, which is that of all."""
    return Compliant(stiffness={assembly.interfaces[0].bodies: 1.0}, **options)
