"""Random scenes in which pushes jam bodies: under ceilings, in wedges, in cradles, leaning, and between books."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.random import Generator
from scipy.spatial import ConvexHull

from bench.scenes.random_pushes import Push, random_pushes
from holdfast import Body, Box, Cylinder, Mesh, Scene, assemble
from holdfast.answers import Assembly
from holdfast.base.arrays import Float

GAPS = (0.0, 1e-5, 1e-4)  # [m] of air under a ceiling and between books
PUSHES = 6  # of each scene, of which the hardest is looked at
SLANT = 75.0  # [deg] of a push from the normal, at most


def at(x: float, y: float, z: float, about_y: float = 0.0, about_x: float = 0.0) -> Float:
    """A pose at this place [m], turned about x and then about y [rad]."""
    pose = np.eye(4)
    c, s = np.cos(about_y), np.sin(about_y)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    c, s = np.cos(about_x), np.sin(about_x)
    pose[:3, :3] = turn @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    pose[:3, 3] = x, y, z
    return pose


def floor() -> Body:
    """A fixed floor, the top at z = 0."""
    return Body("floor", Box((4, 4, 0.2)), pose=at(0, 0, -0.1), fixed=True)


def prism(outline: list[tuple[float, float]], half: float) -> Mesh:
    """A prism along y, of a convex outline in x and z."""
    points = np.array([[x, y, z] for y in (-half, half) for x, z in outline])
    faces, middle = ConvexHull(points).simplices, points.mean(0)
    for face in faces:
        a, b, c = points[face]
        if np.cross(b - a, c - a) @ (a - middle) < 0:
            face[1:] = face[:0:-1]
    return Mesh(points, faces)


def ceiling(rng: Generator) -> Scene:
    """A box under a fixed ceiling."""
    size, gap = rng.uniform((0.05, 0.05, 0.08), (0.15, 0.15, 0.25)), rng.choice(GAPS)
    under = Body("a", Box(size), mass=rng.uniform(0.5, 4), pose=at(0, 0, size[2] / 2))
    above = Body("ceiling", Box((0.6, 0.6, 0.1)), pose=at(0, 0, size[2] + gap + 0.05), fixed=True)
    return Scene([floor(), above, under], rng.uniform(0.15, 0.7))


def walls(rng: Generator) -> Scene:
    """A wedge between a wall and a block, both on the floor."""
    slope, foot, height = np.tan(np.radians(rng.uniform(12, 32))), rng.uniform(0.02, 0.06), rng.uniform(0.06, 0.13)
    half, tall = rng.uniform(0.03, 0.07), rng.uniform(0.7, 1.3) * height
    far = foot + slope * max(height, tall) + rng.uniform(0.03, 0.08)
    wedge = [(0.0, 0.0), (foot, 0.0), (foot + slope * height, height), (0.0, height)]
    block = [(foot, 0.0), (far, 0.0), (far, tall), (foot + slope * tall, tall)]
    bodies = [
        Body("wall", Box((0.1, 0.4, 0.3)), pose=at(-0.05, 0, 0.1), fixed=True),
        Body("wedge", prism(wedge, half), mass=rng.uniform(0.5, 2)),
        Body("block", prism(block, half), mass=rng.uniform(1, 4)),
    ]
    return Scene([floor(), *bodies], rng.uniform(0.3, 0.7))


def cradle(rng: Generator) -> Scene:
    """A pipe in a V of two boards."""
    radius, length, angle = rng.uniform(0.03, 0.06), rng.uniform(0.2, 0.4), np.radians(rng.uniform(30, 65))
    boards = []
    for name, side in (("left", -1), ("right", 1)):
        normal = np.array([-side * np.sin(angle), 0, np.cos(angle)])  # towards the pipe
        x, y, z = np.array([0, 0, 0.3]) - (radius + 0.01) * normal
        boards.append(Body(name, Box((0.2, 0.5, 0.02)), pose=at(x, y, z, about_y=-side * angle), fixed=True))
    lying = Body("pipe", Cylinder(radius, length), mass=rng.uniform(0.5, 3), pose=at(0, 0, 0.3, about_x=np.pi / 2))
    return Scene([*boards, lying], rng.uniform(0.2, 0.7))


def leaning(rng: Generator) -> Scene:
    """A plank that leans against the upper edge of a block."""
    long, wide, thick = rng.uniform((0.3, 0.08, 0.01), (0.5, 0.2, 0.03))
    angle, deep = np.radians(rng.uniform(55, 78)), rng.uniform(0.1, 0.3)
    tall = rng.uniform(0.5, 0.85) * long * np.sin(angle)
    along, across = np.array([np.cos(angle), 0, np.sin(angle)]), np.array([-np.sin(angle), 0, np.cos(angle)])
    middle = long / 2 * along + thick / 2 * across
    middle[2] = long / 2 * np.sin(angle) + thick / 2 * np.cos(angle)  # the lowest edge is on the floor
    x, y, z = middle
    plank = Body("plank", Box((long, wide, thick)), mass=rng.uniform(0.3, 1.5), pose=at(x, y, z, about_y=-angle))
    under = middle - thick / 2 * across  # a point of the face that looks down, which the edge touches
    edge = under + along * (tall - under[2]) / along[2]
    block = Body("block", Box((deep, 0.3, tall)), mass=rng.uniform(1, 5), pose=at(edge[0] + deep / 2, 0, tall / 2))
    return Scene([floor(), plank, block], rng.uniform(0.3, 0.7))


def books(rng: Generator) -> Scene:
    """A row of books between two fixed ends, with air that all gaps share."""
    count, gap, x = int(rng.integers(2, 6)), rng.choice(GAPS), 0.0
    bodies = [Body("end", Box((0.05, 0.3, 0.3)), pose=at(-0.025, 0, 0.15), fixed=True)]
    for k in range(count):
        size = rng.uniform((0.015, 0.12, 0.17), (0.05, 0.2, 0.28))
        mass = rng.uniform(400, 900) * float(np.prod(size))
        bodies.append(Body(f"book{k}", Box(size), mass=mass, pose=at(x + gap + size[0] / 2, 0, size[2] / 2)))
        x += gap + size[0]
    bodies.append(Body("other end", Box((0.05, 0.3, 0.3)), pose=at(x + gap + 0.025, 0, 0.15), fixed=True))
    return Scene([floor(), *bodies], rng.uniform(0.25, 0.7))


FAMILIES: tuple[Callable[[Generator], Scene], ...] = (ceiling, walls, cradle, leaning, books)


def jam(number: int) -> tuple[Assembly, list[Push]]:
    """Scene and pushes of this number."""
    rng = np.random.default_rng([48, number])
    assembly = assemble(FAMILIES[number % len(FAMILIES)](rng))
    return assembly, random_pushes(assembly, rng, PUSHES, slant=SLANT)
