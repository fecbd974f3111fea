"""Brute force for the coupled truth: a dense grid of points on a square patch, and searches that know no formula.

Pressure is linear where the patch presses, p = max(0, a + b x + c y), and found by minimising its energy on the grid.
For that pressure the friction of a motion v is -μ p v/|v|, and the largest load factor is the least of dissipation over
power among all plane motions, by Nelder-Mead. A load that equals its own capacity is R; below it the block may also
tip, where no pressure balances any more. No displacement, no stiffness, no path, no exact integral.
"""

import numpy as np
from scipy.optimize import brentq, minimize

MU, HALF, SIDE = 0.6, 0.05, 61
_u = np.linspace(-HALF, HALF, SIDE)
_share = np.where(np.abs(_u) < HALF, 1.0, 0.5) * 2 * HALF / (SIDE - 1)
POINTS = np.stack(np.meshgrid(_u, _u, indexing="ij"), -1).reshape(-1, 2)
AREA = np.outer(_share, _share).ravel()
BASIS = np.column_stack([np.ones(len(POINTS)), POINTS])


def pressure(normal: float, first: np.ndarray) -> np.ndarray | None:
    """The pressure with resultant ``normal`` and first moments (2,), by minimising its energy; None if it tips."""
    wanted = np.r_[normal, first]
    z = np.array([normal / (4 * HALF**2), 0, 0])
    for _ in range(200):
        p = np.maximum(BASIS @ z, 0)
        left = wanted - BASIS.T @ (AREA * p)
        if np.abs(left).max() <= 1e-10 * normal:
            return p
        pressed = p > 0
        if pressed.sum() < 3:
            return None
        try:
            step = np.linalg.solve((BASIS[pressed].T * AREA[pressed]) @ BASIS[pressed], left)
        except np.linalg.LinAlgError:
            return None
        tried = [z + t * step for t in (1, 0.5, 0.25, 0.1)]
        z = min(tried, key=lambda z: 0.5 * AREA @ np.maximum(BASIS @ z, 0) ** 2 - wanted @ z)
    return None


def capacity(p: np.ndarray, load: np.ndarray) -> float:
    """The least of dissipation over power: load (f_x, f_y, m_z) in the plane, about the patch's centre."""
    scale = np.array([1, 1, HALF])
    e = load * np.r_[1, 1, 1 / HALF]
    base = e / (e @ e)
    across = np.linalg.svd(e[None])[2][1:]

    def dissipation(free: np.ndarray) -> float:
        vx, vy, spin = (base + free @ across) / scale
        speed = np.hypot(vx - spin * POINTS[:, 1], vy + spin * POINTS[:, 0])
        return MU * float((AREA * p) @ speed)

    starts = [np.zeros(2), *(0.7 * np.linalg.norm(base) * np.array(s) for s in ((1, 0), (-1, 0), (0, 1), (0, -1)))]
    best = min(starts, key=dissipation)
    return float(minimize(dissipation, best, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-9}).fun)


def brute_force(weight: float, point: np.ndarray, force: np.ndarray) -> float:
    """R of blocks that move as one on a square patch, pushed at ``point`` relative to the patch's centre."""
    moment = np.cross(point, force)

    def excess(s: float) -> float:
        p = pressure(weight - s * force[2], s * np.array([moment[1], -moment[0]]))
        plane = np.array([force[0], force[1], moment[2]])
        if p is None:
            return -1.0
        return capacity(p, plane) - s if np.linalg.norm(plane) > 1e-9 else 1.0

    # tipping: the resultant of pressure leaves the patch, |first moment| >= half side x normal force
    tips = np.inf
    for m in (moment[0], moment[1]):
        for sign in (1, -1):
            rate = sign * m + HALF * force[2]
            if rate > 0:
                tips = min(tips, HALF * weight / rate)
    if force[2] > 0:
        tips = min(tips, weight / force[2])
    top = min(tips, 50 * weight)
    grid = np.linspace(0, 0.999, 25) * top
    before = grid[0]
    for s in grid[1:]:
        if excess(s) < 0:
            return float(brentq(excess, before, s, rtol=1e-5))
        before = s
    return tips if tips < 50 * weight else np.inf
