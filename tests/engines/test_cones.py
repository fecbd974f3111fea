"""Friction cones as rows of a program: what they allow is what Coulomb's law allows, node by node."""

from __future__ import annotations

import numpy as np
import pytest

from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.engines.forces import ConeChoice, FrictionCone, size_of

MU = np.array([0.0, 0.5, 2.0, 0.0, 0.3])


def nodes(mu: np.ndarray[tuple[int], np.dtype[np.float64]]) -> ContactNodes:
    count = len(mu)
    axes = np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
    zeros = np.zeros(count, dtype=np.int64)
    return ContactNodes(np.zeros((count, 3)), axes, mu, np.ones(count), zeros, zeros - 1, zeros, np.zeros(count))


@pytest.mark.parametrize(("kind", "sides"), [("exact", 8), ("inscribed", 8), ("circumscribed", 5)])
def test_rows_allow_what_friction_allows_at_every_node(kind: ConeChoice, sides: int) -> None:
    cone, given = FrictionCone(kind, sides), nodes(MU)
    matrix, cones = cone.rows(given)
    assert matrix.shape == (size_of(cones), 3 * len(MU))
    random = np.random.default_rng(3)
    told = [0, 0]
    for node, mu in enumerate(MU):
        for _ in range(60):
            forces = np.zeros((len(MU), 3))
            forces[:, 0] = 1.0  # all others are well inside
            angle, share = random.uniform(0, 2 * np.pi), random.uniform(0, 2)
            forces[node] = 1.0, *(share * mu * np.array([np.cos(angle), np.sin(angle)]))
            if random.random() < 0.2:
                forces[node] *= -1
            if mu == 0 and random.random() < 0.5:
                forces[node, 1] = 0.1
            allowed = within(-matrix @ forces.ravel(), cones)
            assert allowed == expected(forces[node], mu, kind, sides), (node, forces[node])
            told[allowed] += 1
    assert min(told) > 60


def within(slack: np.ndarray[tuple[int], np.dtype[np.float64]], cones: tuple[tuple[str, int], ...]) -> bool:
    row = 0
    for kind, size in cones:
        part = slack[row : row + size]
        row += size
        if kind == "zero" and np.abs(part).max() > 1e-12:
            return False
        if kind == "nonnegative" and part.min() < -1e-12:
            return False
        if kind == "second_order" and np.hypot(part[1], part[2]) > part[0] + 1e-12:
            return False
    return True


def expected(force: np.ndarray[tuple[int], np.dtype[np.float64]], mu: float, kind: str, sides: int) -> bool:
    """By geometry: the tangential force lies in a circle, or in the polygon in or around it."""
    normal, sliding = force[0], force[1:]
    if normal < 0:
        return False
    if mu == 0:
        return not sliding.any()
    radius = mu * normal
    if kind == "exact":
        return bool(np.hypot(*sliding) <= radius)
    apothem = radius * np.cos(np.pi / sides) if kind == "inscribed" else radius
    directions = 2 * np.pi * np.arange(sides) / sides
    return bool((np.cos(directions) * sliding[0] + np.sin(directions) * sliding[1]).max() <= apothem)
