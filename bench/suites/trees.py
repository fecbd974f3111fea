"""Trees beside a quadrature of their own: 1,000 pushes on 200 random towers, and what they cost.

The reference knows outlines, weights and coefficients alone. It balances each contact by hand, finds the pressure of an
even bed on triangles that are cut off where nothing presses, and the least friction of all motions by a general
minimizer on points in what is left of them, and seeks the least push with which a contact tips or slides. Beside it
stands engine ``compliant`` on 28 nodes a side where no tree helps it, coarse where a contact slides that presses on a
narrow strip, as next to tipping. Rates are pushes a second of processor time.
"""

from __future__ import annotations

import time
from functools import cache, partial
from itertools import pairwise

import numpy as np
import shapely
from scipy.optimize import brentq, minimize

import holdfast as hf
from bench.scenes.random_trees import NOTHING, Contact, Push, Tower, random_push, random_tower
from bench.suite import Row, Suite
from holdfast.base.arrays import Float
from holdfast.engines.answers import Bound
from holdfast.engines.compliant.engine import state_on
from holdfast.engines.trees.tree_state import with_trees

TOWERS, PUSHES, CASES = 200, 5, 10
ALONG = 28  # nodes a side of ``compliant``
POINTS = 20_000  # about as many in the pressed part of a contact
SIZES = (0.3, 0.6, 0.8, 0.9, 0.98, 1.02, 1.1, 1.5, 3.0)  # of the force, at which contacts are looked at
ENDLESS = (0.1, 0.3, 1, 3, 10, 100, 10_000)  # of the weight, where there is no such force
OFF = 2e-5  # of the force: three times as many points change the reference by at most 1.8e-5
NEAR = 1e-6  # of half the length of a contact: next to the border, friction is that at this distance from it


@cache
def _points(k: int) -> tuple[Float, Float]:
    """Return k² points (n, 3) in barycentric coordinates, those of Gauss along and across a triangle, and weights."""
    x, weights = np.polynomial.legendre.leggauss(k)
    u, v = np.repeat(x + 1, k) / 2, np.tile(x + 1, k) / 2
    return np.column_stack([1 - u, u * (1 - v), u * v]), u * np.outer(weights, weights).ravel() / 2


def _areas(triangles: Float) -> Float:
    (x1, y1), (x2, y2) = (triangles[:, 1] - triangles[:, 0]).T, (triangles[:, 2] - triangles[:, 0]).T
    return np.asarray(np.abs(x1 * y2 - x2 * y1) / 2)


def pressed(triangles: Float, p: Float) -> Float:
    """Return triangles (m, 3, 2) that fill the part of ``triangles`` on which p·(1, x, y) is positive."""
    values = p[0] + triangles @ p[1:]
    count = (values > 0).sum(axis=1)
    kept = [triangles[count == 3]]
    for some in (1, 2):  # corners that press
        rows = np.flatnonzero(count == some)
        alone = np.argmax((values[rows] > 0) == (some == 1), axis=1)  # the corner unlike the other two comes first
        order = (alone[:, None] + np.arange(3)) % 3
        (a, b, c), (va, vb, vc) = (np.moveaxis(each[rows[:, None], order], 1, 0) for each in (triangles, values))
        ab, ac = (a + (to - a) * (va / (va - v))[:, None] for to, v in ((b, vb), (c, vc)))
        kept += [np.stack([a, ab, ac], 1)] if some == 1 else [np.stack([ab, b, c], 1), np.stack([ab, c, ac], 1)]
    return np.concatenate(kept)


def _newton(triangles: Float, p: Float) -> tuple[float, float, Float]:
    """Return ∫ max(0, p)² / 2 - p(0, 0), by how much it begins to fall along Newton's step from there, and that (3,).

    Coordinates are along and across the part that presses, in its own lengths: it may be a sliver.
    """
    part = pressed(triangles, p)
    _, lengths, axes = np.linalg.svd(np.vstack([part.reshape(-1, 2), np.zeros((2, 2))]), full_matrices=False)
    if not lengths[1] > 1e-13:
        return np.inf, 0.0, np.zeros(3)
    D = axes.T / lengths
    middles = (part + np.roll(part, -1, axis=1)).reshape(-1, 2) / 2  # of sides, exact to degree 2
    A = np.column_stack([np.ones(len(middles)), middles @ D])
    M = A.T @ (A * np.repeat(_areas(part) / 3, 3)[:, None])
    q = np.append(p[0], np.linalg.solve(D, p[1:]))
    way = np.linalg.solve(M, np.array([1.0, 0, 0])) - q
    return float(q @ M @ q) / 2 - p[0], float(way @ M @ way), np.append(way[0], D @ way[1:])


def _settled(triangles: Float) -> Float:
    """Return the p for which the pressure max(0, p·(1, x, y)) has the resultant 1 at the origin, by Newton's method."""
    p = np.array([1.0, 0, 0])
    value, fall, way = _newton(triangles, p)
    while fall > 1e-9 * abs(value):
        step, trial = 1.0, _newton(triangles, p + way)
        while trial[0] > value - 1e-4 * step * fall + 1e-12 * abs(value):
            step /= 2
            if step < 1e-9:
                raise ArithmeticError("the reference finds no pressure")
            trial = _newton(triangles, p + step * way)
        p = p + step * way
        value, fall, way = trial
    return np.asarray(p + way)


class Bed:
    """An even bed under a contact, about the middle of its outlines, with half the length of their box as the unit."""

    def __init__(self, contact: Contact, points: int = POINTS) -> None:
        every = np.vstack(contact.outlines)
        low, high = every.min(axis=0), every.max(axis=0)
        self.mu, self.middle, self.unit, self.points = contact.mu, (low + high) / 2, (high - low).max() / 2, points
        self.triangles = (contact.triangles() - self.middle) / self.unit
        self.hull = shapely.MultiPoint((every - self.middle) / self.unit).convex_hull
        self.inner = self.hull.buffer(-NEAR)

    def share(self, carried: Float) -> float:
        """Return the share of friction that N, N x, N y, and a force and torque in the plane (6,) use; inf: tips."""
        place = carried[1:3] / carried[0] / self.unit
        if carried[0] <= 0 or not self.hull.contains(shapely.Point(place)):
            return np.inf
        place = np.array(shapely.shortest_line(self.inner, shapely.Point(place)).coords[0])
        p = _settled(self.triangles - place)
        triangles = pressed(self.triangles - place, p)
        reach = float(np.hypot(*triangles.reshape(-1, 2).T).max())
        points, weights = _points(int(np.ceil(np.sqrt(self.points / len(triangles)))))
        x, y = (points @ triangles[:, :, i].T / reach for i in (0, 1))
        q = (p[0] + reach * (p[1] * x + p[2] * y)) * weights[:, None] * _areas(triangles)
        t = carried[3:] / (self.mu * carried[0])
        t = np.array([t[0], t[1], (t[2] / self.unit - place[0] * t[1] + place[1] * t[0]) / reach])
        size = float(np.linalg.norm(t))
        across = np.linalg.svd(t[None])[2][1:]

        def power(z: Float) -> tuple[float, Float]:
            m = t / size + z @ across
            vx, vy = m[0] - m[2] * y, m[1] + m[2] * x
            speed = np.maximum(np.hypot(vx, vy), 1e-300)
            fx, fy = q * vx / speed, q * vy / speed
            return float((q * speed).sum()), across @ np.array([fx.sum(), fy.sum(), (fy * x - fx * y).sum()])

        found = minimize(power, np.array([1e-3, -1e-3]), jac=True, method="BFGS", options={"gtol": 1e-8})
        return size / float(found.fun)


def fine_factor(tower: Tower, beds: list[Bed], push: Push, near: float) -> float:
    """Return the factor of a push up to which no contact slides or tips; inf if it is far above ``near``."""
    unit, shares = (near, SIZES) if np.isfinite(near) else (np.linalg.norm(tower.weights.sum(axis=0)), ENDLESS)
    sizes, first = [float(unit * share) for share in shares], np.inf
    for k in range(push.body + 1):

        def beyond(size: float, k: int = k) -> float:
            return min(beds[k].share(tower.carried(k, beds[k].middle, push, size)), 2.0) - 1

        for before, size in pairwise([0.0, *sizes]):
            if beyond(size) > 0:
                first = float(brentq(beyond, before, size, xtol=1e-12, rtol=1e-7))
                sizes = [*(each for each in sizes if each < first), first]
                break
    return first


def _rows(seed: int) -> list[Row]:
    rng = np.random.default_rng(seed)
    ratios, nodes, above, unknown, kept, spent = list[float](), list[float](), 0, 0, 0, 0.0
    while kept < TOWERS // CASES:
        tower = random_tower(rng)
        beds = [Bed(contact) for contact in tower.contacts]
        if any(bed.share(tower.carried(k, bed.middle, NOTHING, 0.0)) > 0.95 for k, bed in enumerate(beds)):
            continue
        kept += 1
        pushes = [random_push(tower, rng) for _ in range(PUSHES)]
        W = np.column_stack([tower.load(push) for push in pushes])
        state = with_trees(hf.Compliant(), tower.assembly, None, None)
        state.load_factor(W)
        begun = time.process_time()
        found = state.load_factor(W)
        spent += time.process_time() - begun
        grid = state_on(tower.assembly, tower.assembly.weight_wrench(), hf.Compliant(nodes=ALONG).springs)
        beside = grid.load_factor(W).force
        unknown += sum(state.load_factor(one[:, None]).lower_bound is not Bound.PROVED for one in W.T)
        for force, lower, other, push in zip(found.force, found.lower, beside, pushes, strict=True):
            fine = fine_factor(tower, beds, push, float(force))
            above += bool(lower > fine * (1 + OFF))
            ratios.append(_off(force, fine))
            nodes.append(_off(force, other))
    return [
        {
            "case": f"seed {seed}",
            "pushes": len(ratios),
            "not proved": unknown,
            "worst %": 100 * max(ratios),
            "median %": 100 * float(np.median(ratios)),
            "lower too high": above,
            f"{ALONG} nodes: worst %": 100 * max(nodes),
            f"{ALONG} nodes: median %": 100 * float(np.median(nodes)),
            f"{ALONG} nodes: beyond 0.3 %": sum(off > 0.003 for off in nodes),
            "pushes a second": len(ratios) / spent,
        }
    ]


def _off(force: float, other: float) -> float:
    """Return by what share of the other two forces differ; none if both are infinite."""
    return 0.0 if np.isinf(force) and np.isinf(other) else abs(force / other - 1) if other > 0 else np.inf


SUITE = Suite("trees", __doc__, lambda: {f"seed {seed}": partial(_rows, seed) for seed in range(CASES)})
