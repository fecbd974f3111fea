"""The pairs of bodies whose bounding boxes are near each other, and the groups that pairs connect."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple, TypeVar

import numpy as np

from holdfast.contacts.occlusion import Pair
from holdfast.contacts.tolerances import OfPair, Tolerances
from holdfast.native import core
from holdfast.scene.body import Body, place_cuboids
from holdfast.scene.scene import Scene

T = TypeVar("T")


class NearPair(NamedTuple):
    """Two bodies, or some parts of them, that are near each other, and the tolerances of the whole bodies.

    ``shared`` [m] is how far their bounding boxes overlap, along the axis of least overlap; negative if they are apart.
    """

    a: Body
    b: Body
    shared: float
    limits: OfPair


def near_pairs(scene: Scene, tolerances: Tolerances, gap: float, same: Collection[str] = ()) -> list[NearPair]:
    """Return the pairs of ``neighbours``."""
    whole = _near(scene, gap, same)
    limits = tolerances.of_pairs([(a, b) for a, b, _ in whole])
    return [
        NearPair(one, two, along if one is a and two is b else _shared(one, two), own)
        for (a, b, along), own in zip(whole, limits, strict=True)
        for one, two in scene.touching(a, b)
    ]


def neighbours(scene: Scene, gap: float, same: Collection[str] = ()) -> Iterator[tuple[Body, Body]]:
    """Yield the pairs of bodies, neither both fixed nor excluded, whose bounding boxes come within ``gap`` [m].

    Pairs of two bodies named in ``same`` are left out. If only some parts of two bodies may touch, bodies with only
    these parts are yielded, one pair for each set of parts that may touch each other (``Scene.touching``).
    """
    for a, b, _ in _near(scene, gap, same):
        yield from scene.touching(a, b)


def _near(scene: Scene, gap: float, same: Collection[str]) -> list[tuple[Body, Body, float]]:
    """Return pairs of bodies with all of their parts, and how far [m] their bounding boxes overlap."""
    bodies = scene.bodies
    place_cuboids(bodies)
    boxes = np.array([body.box for body in bodies]).reshape(-1, 2, 3)
    fixed = np.array([body.fixed for body in bodies], dtype=bool)
    wanted = np.array([body.name not in same for body in bodies], dtype=bool)
    pairs, shared = core.near_bodies(boxes, fixed, wanted, gap)
    return [(bodies[i], bodies[j], along) for (i, j), along in zip(pairs.tolist(), shared.tolist(), strict=True)]


def _shared(a: Body, b: Body) -> float:
    """Return how far [m] the bounding boxes of two bodies overlap, along the axis of least overlap."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float((np.minimum(high_a, high_b) - np.maximum(low_a, low_b)).min())


def box_distance(a: Body, b: Body) -> float:
    """Return the distance of the world bounding boxes [m], which is a lower bound of the distance of the bodies."""
    (low_a, high_a), (low_b, high_b) = a.box, b.box
    return float(np.linalg.norm(np.maximum(np.maximum(low_a - high_b, low_b - high_a), 0)))


def in_order(by_pair: Mapping[Pair, T], scene: Scene) -> dict[Pair, T]:
    """Return a dict by pairs of bodies, sorted by the order of the bodies in the scene."""
    place = {body.name: k for k, body in enumerate(scene.bodies)}
    return {pair: by_pair[pair] for pair in sorted(by_pair, key=lambda pair: (place[pair[0]], place[pair[1]]))}


def components(count: int, ends: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Return the connected groups of the numbers 0..count-1 that no path of edges connects to FIXED.

    ``ends`` holds the edges as pairs of numbers; a negative number is FIXED.
    """
    parent = list(range(count + 1))  # the last one is FIXED

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for a, b in ends:
        parent[root(a if a >= 0 else count)] = root(b if b >= 0 else count)
    groups: dict[int, list[int]] = {}
    for k in range(count):
        groups.setdefault(root(k), []).append(k)
    groups.pop(root(count), None)
    return list(groups.values())


def groups_within(scene: Scene, gap: float) -> tuple[tuple[str, ...], ...]:
    """Return the names of the movable bodies in groups; bodies are connected if their boxes come within ``gap`` [m].

    Fixed bodies do not connect groups. Groups and names are in the order of the scene.
    """
    near = [(a.name, b.name) for a, b in neighbours(scene, gap) if not (a.fixed or b.fixed)]
    return joined([body.name for body in scene.movable], near)


def joined(names: Iterable[str], pairs: Iterable[tuple[str, str]]) -> tuple[tuple[str, ...], ...]:
    """Return the groups of ``names`` that ``pairs`` connect, in the order of the names."""
    every = list(names)
    number = {name: k for k, name in enumerate(every)}
    groups = components(len(every), [(number[a], number[b]) for a, b in pairs])
    return tuple(tuple(every[k] for k in group) for group in groups)


def alone(scene: Scene, group: Iterable[str]) -> Scene:
    """Return the scene with the bodies of one group and the fixed bodies only."""
    kept = set(group)
    return scene.without([body.name for body in scene.movable if body.name not in kept])
