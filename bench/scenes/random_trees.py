"""Random towers in which every body hangs on its support by one plane contact of any outline, under tilted gravity.

Contacts are given, so that outlines may be rectangles, polygons, discs, rings, and four feet; bodies are boxes.
"""

from __future__ import annotations

from itertools import zip_longest
from typing import NamedTuple

import numpy as np
import shapely
from numpy.random import Generator
from scipy.spatial import ConvexHull

import holdfast as hf
from holdfast.base.arrays import Float

KINDS = ("rectangle", "polygon", "disc", "ring", "feet")
G = 9.81  # [m/s²]


class Contact(NamedTuple):
    """The level contact of body k with what is below: its ``outlines``, ``holes``, ``height`` [m], and friction."""

    outlines: list[Float]
    holes: list[Float]
    height: float
    mu: float

    def triangles(self) -> Float:
        """Return triangles (n, 3, 2) that fill it; outlines are convex, and each hole is its outline, but smaller."""
        parts = list[Float]()
        for ring, hole in zip_longest(self.outlines, self.holes):
            inner = np.tile(ring.mean(axis=0), (len(ring), 1)) if hole is None else hole
            after, beyond = np.roll(ring, -1, axis=0), np.roll(inner, -1, axis=0)
            parts.append(np.stack([ring, after, inner], axis=1))
            if hole is not None:
                parts.append(np.stack([after, beyond, inner], axis=1))
        return np.concatenate(parts)


class Push(NamedTuple):
    """A push on a ``body`` at a ``point`` [m], in a ``direction`` of length one."""

    body: int
    point: Float
    direction: Float


NOTHING = Push(0, np.zeros(3), np.zeros(3))


class Tower(NamedTuple):
    """An ``assembly`` of bodies one upon the other, with what a reference needs to know of it.

    ``weights`` (J, 3) [N] act at ``com`` (J, 3) [m]; ``contacts`` are from the floor up.
    """

    assembly: hf.answers.Assembly
    contacts: list[Contact]
    weights: Float
    com: Float

    def load(self, push: Push) -> Float:
        """Return the wrenches (6J,) of a push of 1 N about the centres of mass."""
        load = np.zeros((len(self.com), 6))
        load[push.body] = [*push.direction, *np.cross(push.point - self.com[push.body], push.direction)]
        return load.ravel()

    def carried(self, k: int, middle: Float, push: Push, size: float) -> Float:
        """Return what contact k carries about ``middle`` (2,) under all weights above it and ``size`` times a push.

        That is N, N x, N y, and the force and the torque in its plane (6,).
        """
        at = np.append(middle, self.contacts[k].height)
        force, torque = self.weights[k:].sum(axis=0), np.cross(self.com[k:] - at, self.weights[k:]).sum(axis=0)
        if push.body >= k:
            force, torque = force + size * push.direction, torque + size * np.cross(push.point - at, push.direction)
        return np.array([-force[2], torque[1], -torque[0], -force[0], -force[1], -torque[2]])


def _round(radius: float, corners: int) -> Float:
    angles = np.arange(corners) * 2 * np.pi / corners
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def _rectangle(half: Float, middle: Float) -> Float:
    return middle + np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]]) * half


def outline(kind: str, rng: Generator) -> tuple[list[Float], list[Float]]:
    """Return the outlines and the holes of a contact, counter-clockwise all of them, around the origin."""
    if kind == "rectangle":
        return [_rectangle(rng.uniform(0.02, 0.1, 2), np.zeros(2))], []
    if kind == "polygon":
        points = rng.uniform(-0.1, 0.1, (9, 2))
        ring = points[ConvexHull(points).vertices]
        return [ring - np.array(shapely.Polygon(ring).centroid.coords[0])], []
    if kind == "disc":
        return [_round(rng.uniform(0.02, 0.1), 32)], []
    if kind == "ring":
        radius = rng.uniform(0.04, 0.1)
        return [_round(radius, 32)], [_round(rng.uniform(0.5, 0.9) * radius, 32)]
    reach, half = rng.uniform(0.04, 0.09, 2), rng.uniform(0.005, 0.02, 2)
    return [_rectangle(half, np.array([x, y]) * reach) for x in (-1, 1) for y in (-1, 1)], []


def random_tower(rng: Generator) -> Tower:
    """Draw a tower of 1 to 10 bodies that may or may not stand."""
    count, side, height = int(rng.integers(1, 11)), 0.22, float(rng.uniform(0.02, 0.08))
    down = np.append(rng.uniform(-0.1, 0.1, 2), -1.0)
    gravity = G * down / np.linalg.norm(down)
    floor = hf.Body("floor", hf.Box((2, 2, 0.1)), fixed=True, pose=_at(0, 0, -0.05))
    bodies, contacts, interfaces, middle = [floor], list[Contact](), [], np.zeros(2)
    for k in range(count):
        middle = middle + rng.uniform(-0.01, 0.01, 2)
        pose = _at(middle[0], middle[1], (k + 0.5) * height)
        offset = np.append(rng.uniform(-0.01, 0.01, 2), rng.uniform(-0.2, 0.2) * height)
        bodies.append(
            hf.Body(f"b{k}", hf.Box((side, side, height)), mass=float(rng.uniform(0.1, 3)), pose=pose, com=offset)
        )
        outlines, holes = outline(str(rng.choice(KINDS)), rng)
        at = middle + rng.uniform(-0.005, 0.005, 2)
        contacts.append(Contact([r + at for r in outlines], [r + at for r in holes], k * height, 0.0))
        lifted = [np.column_stack([r, np.full(len(r), k * height)]) for r in contacts[-1].outlines]
        cut = [np.column_stack([r, np.full(len(r), k * height)])[::-1] for r in contacts[-1].holes]
        patches = [hf.answers.Patch(r, np.array([0.0, 0, 1]), holes=tuple(cut)) for r in lifted]
        interfaces.append(hf.answers.Interface((bodies[-2].name, bodies[-1].name), patches=patches))
    pairs = {interface.bodies: float(rng.uniform(0.2, 1.0)) for interface in interfaces}
    friction = hf.Friction(0.5, pairs=pairs)
    assembly = hf.assemble(hf.Scene(bodies, friction, gravity=tuple(gravity)), interfaces=interfaces)
    known = [contact._replace(mu=mu) for contact, mu in zip(contacts, pairs.values(), strict=True)]
    com = np.array([body.pose[:3, 3] + body.com_body for body in bodies[1:]])
    weights = np.array([body.mass * gravity for body in bodies[1:]])
    return Tower(assembly, known, weights, com)


def random_push(tower: Tower, rng: Generator) -> Push:
    """Return a push into a body at a point on one of its sides or its top."""
    body = int(rng.integers(len(tower.weights)))
    box = tower.assembly.movable[body]
    assert isinstance(box.shape, hf.Box)
    half = np.asarray(box.shape.size) / 2
    normal = np.zeros(3)
    axis = int(rng.integers(3))
    normal[axis] = 1.0 if axis == 2 else rng.choice([-1.0, 1.0])
    point = rng.uniform(-0.9, 0.9, 3) * half
    point[axis] = normal[axis] * half[axis]
    slant = -normal + 0.5 * rng.uniform(-1, 1, 3)
    return Push(body, point + box.pose[:3, 3], slant / np.linalg.norm(slant))


def _at(x: float, y: float, z: float) -> Float:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose
