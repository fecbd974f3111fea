"""Trees beside a quadrature of their own on cells: 1,000 pushes on 200 random towers, and what they cost.

The reference knows outlines, weights and coefficients alone. It balances each contact by hand, lays cells over its
outlines, finds the pressure of an even bed on them, and the least motion's friction by a general minimizer; where a
contact gives way between 0.98 and 1.02 of ``force`` is then sought by bisection. Beside it stands engine ``compliant``
on 28 nodes a side where no tree helps it. Rates are pushes a second of processor time.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial

import numpy as np
import shapely
from numpy.random import Generator
from scipy.optimize import minimize

import holdfast as hf
from bench.scenes.random_trees import Contact, Tower, random_tower
from bench.suite import Case, Row, Suite
from holdfast.base.arrays import Float
from holdfast.engines.compliant.engine import state_on
from holdfast.engines.trees.tree_state import with_trees

TOWERS, PUSHES = 200, 5
GROUPS = 10  # cases
ACROSS = 200  # cells across a contact
ALONG = 28  # nodes a side of ``compliant``
FEWEST = 3_000  # cells that have to press, else they are looked at closer
WIDE = 0.02
EXACT = 1e-4  # of the force, to which a border is bisected


class Cells:
    """An even bed under a contact, on cells about the middle of its outlines."""

    def __init__(self, contact: Contact, box: tuple[Float, Float] | None = None) -> None:
        every = np.vstack(contact.outlines)
        low, high = (every.min(0), every.max(0)) if box is None else box
        self.contact, self.mu, self.middle = contact, contact.mu, (every.min(0) + every.max(0)) / 2
        self.step = (high - low) / ACROSS
        x, y = (a + d * (np.arange(ACROSS) + 0.5) for a, d in zip(low, self.step, strict=True))
        x, y = (each.ravel() for each in np.meshgrid(x, y))
        inside = np.any([shapely.contains_xy(shapely.Polygon(ring), x, y) for ring in contact.outlines], axis=0)
        for hole in contact.holes:
            inside &= ~shapely.contains_xy(shapely.Polygon(hole), x, y)
        self.x, self.y, self.area = x[inside] - self.middle[0], y[inside] - self.middle[1], float(self.step.prod())
        self.reach = float(np.hypot(*(every - self.middle).T).max())
        self.hull = shapely.convex_hull(shapely.MultiPoint(every - self.middle))

    def closer(self, p: Float) -> Cells:
        """Return as many cells over the box of those that press (n,) [N]."""
        pressed = np.column_stack([self.x, self.y])[p > 0] + self.middle
        return Cells(self.contact, (pressed.min(0) - 1.5 * self.step, pressed.max(0) + 1.5 * self.step))

    def pressures(self, carried: Float) -> Float | None:
        """Return what each cell presses [N] to carry N, N x, N y (3,) about the middle; None where nothing does."""
        A = np.column_stack([np.ones_like(self.x), self.x, self.y])

        def value(s: Float) -> float:
            p = np.maximum(A @ s, 0)
            return float((p * p).sum() / 2 * self.area - s @ carried)

        s = np.linalg.solve(A.T @ A * self.area, carried)
        for _ in range(200):
            on = A @ s > 0
            H = A[on].T @ A[on] * self.area
            if on.sum() < 3 or np.linalg.cond(H) > 1e14:
                return None
            new, step = np.linalg.solve(H, carried), 1.0
            while value(s + step * (new - s)) > value(s) + 1e-12 * abs(value(s)) and step > 1e-8:
                step /= 2
            ended = np.abs(new - s).max() < 1e-10 * np.abs(s).max()
            s = s + step * (new - s)
            if ended:
                return np.asarray(np.maximum(A @ s, 0) * self.area)
        return None

    def share(self, carried: Float, closer: int = 8) -> float:
        """Return the share of friction that N, N x, N y, and a force and torque in the plane (6,) use; inf: tips."""
        centre = shapely.Point(carried[1:3] / carried[0])
        if carried[0] <= 0 or not self.hull.contains(centre):
            return np.inf
        place, inner, p = carried[1:3] / carried[0], np.array(self.hull.centroid.coords[0]), None
        moved = 0
        while p is None or (p > 0).sum() < FEWEST:  # what presses is within what presses if the centre is farther in
            p = self.pressures(carried[0] * np.append(1.0, place))
            place, moved = place + 0.1 * (inner - place), moved + 1
        if moved > 1 or (p > 0).mean() < 0.5:
            return self.closer(p).share(carried, closer - 1) if closer else np.nan
        t = carried[3:] / np.array([1, 1, self.reach])
        size = float(np.linalg.norm(t))
        across = np.linalg.svd(t[None])[2][1:]

        def power(z: Float) -> tuple[float, Float]:
            m = (t / size + z @ across) / np.array([1, 1, self.reach])
            vx, vy = m[0] - m[2] * self.y, m[1] + m[2] * self.x
            speed = np.maximum(np.hypot(vx, vy), 1e-300)
            fx, fy = self.mu * p * vx / speed, self.mu * p * vy / speed
            by_m = np.array([fx.sum(), fy.sum(), (fy * self.x - fx * self.y).sum()]) / np.array([1, 1, self.reach])
            return float(self.mu * (p * speed).sum()), across @ by_m

        found = minimize(power, np.array([1e-3, -1e-3]), jac=True, method="BFGS", options={"gtol": 1e-9 * self.mu})
        return size / float(found.fun)


def carried(tower: Tower, k: int, middle: Float, push: tuple[int, Float, Float], size: float) -> Float:
    """Return what contact k carries (6,) about its middle under all weights above it and ``size`` times a push."""
    body, point, direction = push
    at = np.append(middle, tower.contacts[k].height)
    force, torque = np.zeros(3), np.zeros(3)
    for j in range(k, len(tower.weights)):
        force += tower.weights[j]
        torque += np.cross(tower.com[j] - at, tower.weights[j])
    if body >= k:
        force, torque = force + size * direction, torque + size * np.cross(point - at, direction)
    return np.array([-force[2], torque[1], -torque[0], -force[0], -force[1], -torque[2]])


def fine_factor(tower: Tower, cells: list[Cells], push: tuple[int, Float, Float], near: float) -> float:
    """Return the factor of a push, within WIDE of ``near``, up to which no contact slides or tips; nan if not there."""
    low, high = near * (1 - WIDE), near * (1 + WIDE)

    def used(k: int, size: float) -> float:
        return cells[k].share(carried(tower, k, cells[k].middle, push, size))

    doubtful = [k for k in range(push[0] + 1) if used(k, high) > 1]
    if not doubtful or any(used(k, low) > 1 for k in doubtful):
        return np.nan
    while high - low > EXACT * near:
        middle = (low + high) / 2
        low, high = (low, middle) if any(used(k, middle) > 1 for k in doubtful) else (middle, high)
    return (low + high) / 2


def random_push(tower: Tower, rng: Generator) -> tuple[int, Float, Float]:
    """Return a body, a point on one of its sides or its top, and a direction into it."""
    body = int(rng.integers(len(tower.weights)))
    box = tower.assembly.movable[body]
    half = np.asarray(box.shape.size) / 2
    normal = np.zeros(3)
    axis = int(rng.integers(3))
    normal[axis] = 1.0 if axis == 2 else rng.choice([-1.0, 1.0])
    point = rng.uniform(-0.9, 0.9, 3) * half
    point[axis] = normal[axis] * half[axis]
    slant = -normal + 0.5 * rng.uniform(-1, 1, 3)
    return body, point + box.pose[:3, 3], slant / np.linalg.norm(slant)


def cases() -> Mapping[str, Case]:
    """A case for each seed."""
    return {f"seed {seed}": partial(_rows, seed) for seed in range(GROUPS)}


def _rows(seed: int) -> list[Row]:
    rng = np.random.default_rng(seed)
    ratios, above, nodes, spent, asked, unknown, kept = list[float](), 0, list[float](), 0.0, 0, 0, 0
    while kept < TOWERS // GROUPS:
        tower = random_tower(rng)
        beds = [Cells(contact) for contact in tower.contacts]
        nothing = (0, np.zeros(3), np.zeros(3))
        if any(bed.share(carried(tower, k, bed.middle, nothing, 0.0)) > 0.95 for k, bed in enumerate(beds)):
            continue
        kept += 1
        pushes = [random_push(tower, rng) for _ in range(PUSHES)]
        W = np.zeros((6 * len(tower.weights), PUSHES))
        for column, (body, point, direction) in enumerate(pushes):
            W[6 * body : 6 * body + 3, column] = direction
            W[6 * body + 3 : 6 * body + 6, column] = np.cross(point - tower.com[body], direction)
        state = with_trees(hf.Compliant(), tower.assembly, None, None)
        state.load_factor(W)
        begun = time.process_time()
        found = state.load_factor(W)
        spent, asked = spent + time.process_time() - begun, asked + PUSHES
        grid = state_on(tower.assembly, tower.assembly.weight_wrench(), hf.Compliant(nodes=ALONG).springs)
        beside = grid.load_factor(W)
        for row, push in enumerate(pushes):
            if not np.isfinite(found.force[row]):
                continue
            unknown += str(found.lower_bound) != "proved"
            fine = fine_factor(tower, beds, push, float(found.force[row]))
            ratios.append(found.force[row] / fine)
            above += bool(found.lower[row] > fine * (1 + 1e-3))
            if np.isfinite(beside.force[row]) and beside.force[row] > 0:
                nodes.append(found.force[row] / beside.force[row])
    worst = np.abs(np.array(ratios) - 1)
    return [
        {
            "case": f"seed {seed}",
            "pushes": len(ratios),
            "not proved": unknown,
            "not within 2 % of cells": int(np.isnan(worst).sum()),
            "cells: worst %": 100 * float(np.nanmax(worst)),
            "cells: median %": 100 * float(np.nanmedian(worst)),
            "lower above cells by .1 %": above,
            f"{ALONG} nodes: worst %": 100 * float(np.abs(np.array(nodes) - 1).max()),
            f"{ALONG} nodes: median %": 100 * float(np.median(np.abs(np.array(nodes) - 1))),
            "pushes a second": asked / spent,
        }
    ]


SUITE = Suite("trees", __doc__, cases)
