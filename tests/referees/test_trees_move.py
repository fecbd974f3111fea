"""Random towers in a simulation of their own: what trees say slides holds at 0.98 of the load, and moves at 1.03.

Bodies move by small amounts on even beds of springs and dampers, which press only; along the plane, springs remember
where they stuck, and slide at μ times the pressure. The load rises slowly and stays.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from bench.scenes.random_trees import Push, Tower, random_push, random_tower
from holdfast.base.arrays import Float
from holdfast.engines.trees.forest import Forest

pytestmark = pytest.mark.referee

SIZES = np.array([0.98, 1.03])
SINKS = 2e-5  # [m], under its own weight and what it carries
STEP, SETTLES, RISES, STAYS, LAST = 1e-4, 0.1, 0.4, 0.6, 0.1  # [s]
FINE = 6  # places along each side of a triangle, its corners among them


class Bed(NamedTuple):
    """``places`` (n, 3) [m] of springs with ``shares`` (n,) of the stiffness, [N/m] in all, under a body."""

    places: Float
    shares: Float
    stiffness: float
    mu: float


def bed(tower: Tower, k: int) -> Bed:
    corners = tower.contacts[k].triangles()
    lattice = [(i, j) for i in range(FINE + 1) for j in range(FINE + 1 - i)]
    small = [((i, j), (i + 1, j), (i, j + 1)) for i, j in lattice if i + j < FINE]
    small += [((i, j), (i - 1, j), (i, j - 1)) for i, j in lattice if i and j]
    u, v = np.array(lattice).T / FINE
    touching = np.array([sum(at in one for one in small) for at in lattice])
    sides = corners[:, 1:] - corners[:, :1]
    flat = corners[:, :1] + u[:, None] * sides[:, :1] + v[:, None] * sides[:, 1:]
    area = (np.abs(np.linalg.det(sides))[:, None] * touching).ravel()
    height = tower.contacts[k].height
    places = np.column_stack([flat.reshape(-1, 2), np.full(len(area), height)])
    pressed = -float(tower.weights[k:, 2].sum())
    return Bed(places, area / area.sum(), pressed / SINKS, tower.contacts[k].mu)


def moved(tower: Tower, push: Push, force: float) -> Float:
    """Return how far (2,) [m] any body goes in the last LAST seconds, under each of SIZES times a force."""
    beds = [bed(tower, k) for k in range(len(tower.com))]
    mass = np.linalg.norm(tower.weights, axis=1) / 9.81
    inertia = mass * 0.22**2 / 6  # of any use: what holds does not depend on it
    load = force * tower.load(push).reshape(-1, 6)
    place, speed = np.zeros((2, 2, len(mass), 6))
    stuck = [np.zeros((2, len(one.places), 2)) for one in beds]
    count, before = round((SETTLES + RISES + STAYS) / STEP), place
    for step in range(count):
        risen = np.clip((step * STEP - SETTLES) / RISES, 0, 1)
        if step == count - round(LAST / STEP):
            before = place
        total = np.tile(np.pad(tower.weights, ((0, 0), (0, 3))), (2, 1, 1)) + risen * SIZES[:, None, None] * load
        for k, one in enumerate(beds):
            sunk, sinking = np.zeros((2, 2, len(one.places), 3))
            for body, sign in ((k, 1.0), (k - 1, -1.0)):
                if body >= 0:
                    arms = one.places - tower.com[body]
                    for found, of in ((sunk, place), (sinking, speed)):
                        found += sign * (of[:, body, None, :3] + np.cross(of[:, body, None, 3:], arms))
            damping = 2 * np.sqrt(one.stiffness * mass[k:].sum())
            normal = np.maximum(-one.shares * (one.stiffness * sunk[..., 2] + damping * sinking[..., 2]), 0)
            normal[sunk[..., 2] > 0] = 0
            most = one.mu * normal
            stuck[k] += STEP * sinking[..., :2]
            along = -one.shares[:, None] * one.stiffness * stuck[k]
            share = np.minimum(1.0, most / np.maximum(np.linalg.norm(along, axis=2), 1e-300))[..., None]
            stuck[k] *= share
            along = along * share - one.shares[:, None] * damping * sinking[..., :2] * (share == 1)
            forces = np.concatenate([along, normal[..., None]], axis=2)
            for body, sign in ((k, 1.0), (k - 1, -1.0)):
                if body >= 0:
                    total[:, body, :3] += sign * forces.sum(axis=1)
                    total[:, body, 3:] += sign * np.cross(one.places - tower.com[body], forces).sum(axis=1)
        speed[..., :3] += STEP * total[..., :3] / mass[:, None]
        speed[..., 3:] += STEP * total[..., 3:] / inertia[:, None]
        place = place + STEP * speed
    return np.asarray(np.abs(place - before)[..., :3].max(axis=(1, 2)))


@pytest.mark.parametrize("seed", range(12))
def test_what_trees_say_holds_and_moves(seed: int) -> None:
    rng = np.random.default_rng(seed)
    while True:
        tower = random_tower(rng)
        forest = Forest(tower.assembly, tower.assembly.weight_wrench())
        push = random_push(tower, rng)
        found = forest.exits(tower.load(push)[:, None])
        force = float(found.factor[0])
        if len(tower.com) <= 3 and forest.decided.all() and forest.shares.max() < 0.8 and found.slides[0]:
            break
    holds, moves = moved(tower, push, force)
    assert holds < 1e-9
    assert moves > 5e-5
