"""The limit surface of a patch under linear pressure: least dissipation over power among all plane motions."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled

FAR = 3.0  # [-] times the patch's reach: further away the centre of rotation is integrated by quadrature
STEPS = 100  # most iterations of Newton's method; five to ten are usual
STEP = 1e-4  # [-] of the motion: the difference over which second derivatives are taken
NEAR = 1e-3  # [-] of friction's size: where the slope is smaller, a step is accepted if it reduces the slope
FLAT = 1e-6  # [-] of friction's size: the slope at which the search ends
ENOUGH = 1e-4  # [-] the slope that is accepted where rounding prevents a smaller one; the value errs by its square

# Gauss-Legendre on [0, 1]
NODES = 0.5 + 0.5 * np.polynomial.legendre.leggauss(6)[0]
WEIGHTS = 0.5 * np.polynomial.legendre.leggauss(6)[1]


@compiled
def friction_about(z: Float, part: Float, count: int, cx: float, cy: float) -> Float:
    """∫ p (u_x, u_y, |r|) over a polygon, r = (x, y) - c and u = r / |r|, exactly; p = z0 + z1 x + z2 y.

    In polar coordinates about c the radius is integrated first; what is left runs along the edges. On the edge at the
    distance h (outer normal n, direction d) r = h n + t d, ρ = |r|, and the angle is h dt / ρ²:

        ∫ p |r|  = Σ h ∫ ((p_c / 3 + g_n h / 4) ρ + g_d t ρ / 4) dt
        ∫ p u    = Σ h ∫ (p_c / 2 + (g_n h + g_d t) / 3) (h n + t d) / ρ dt
    """
    total = np.zeros(3)
    at_centre = z[0] + z[1] * cx + z[2] * cy
    for k in range(count):
        ax, ay = part[k, 0] - cx, part[k, 1] - cy
        after = (k + 1) % count
        bx, by = part[after, 0] - cx, part[after, 1] - cy
        length = np.hypot(bx - ax, by - ay)
        if length == 0.0:
            continue
        dx, dy = (bx - ax) / length, (by - ay) / length
        h = ax * dy - ay * dx  # along the outer normal (dy, -dx)
        if abs(h) <= 1e-15 * length:
            continue  # an edge through c spans no angle
        g_n, g_d = z[1] * dy - z[2] * dx, z[1] * dx + z[2] * dy
        s, t = ax * dx + ay * dy, bx * dx + by * dy
        rho_s, rho_t = np.hypot(h, s), np.hypot(h, t)
        turn = np.arcsinh(t / abs(h)) - np.arcsinh(s / abs(h))  # ∫ dt / ρ
        along = rho_t - rho_s  # ∫ t dt / ρ
        square = 0.5 * (t * rho_t - s * rho_s - h * h * turn)  # ∫ t² dt / ρ
        rho = square + h * h * turn  # ∫ ρ dt
        t_rho = (rho_t**3 - rho_s**3) / 3  # ∫ t ρ dt
        level = at_centre / 2 + g_n * h / 3
        on_n = h * h * (level * turn + g_d / 3 * along)
        on_d = h * (level * along + g_d / 3 * square)
        total[0] += on_n * dy + on_d * dx
        total[1] += -on_n * dx + on_d * dy
        total[2] += h * ((at_centre / 3 + g_n * h / 4) * rho + g_d / 4 * t_rho)
    return total


@compiled
def friction(z: Float, part: Float, count: int, reach: float, v: Float) -> Float:
    """F (3,) = (f_x, f_y, m): what friction of coefficient 1 sustains against the motion v = (v_x, v_y, spin).

    F = ∫ p (u_x, u_y, x u_y - y u_x) with u the direction of sliding. Dissipation is F·v, and F its gradient by v.
    ``reach`` [m]: distance of the furthest corner from the origin.
    """
    vx, vy, spin = v
    if np.hypot(vx, vy) <= FAR * reach * abs(spin):
        cx, cy = -vy / spin, vx / spin
        ux, uy, mean = friction_about(z, part, count, cx, cy)
        sense = 1.0 if spin > 0 else -1.0
        return sense * np.array([-uy, ux, mean + cx * ux + cy * uy])
    # about a far centre the exact terms cancel, and the direction of sliding is smooth
    total = np.zeros(3)
    ox, oy = part[0]
    for k in range(1, count - 1):
        ax, ay = part[k, 0] - ox, part[k, 1] - oy
        bx, by = part[k + 1, 0] - part[k, 0], part[k + 1, 1] - part[k, 1]
        twice = ax * by - ay * bx
        for i in range(len(NODES)):
            for j in range(len(NODES)):
                x, y = ox + NODES[i] * (ax + NODES[j] * bx), oy + NODES[i] * (ay + NODES[j] * by)
                share = WEIGHTS[i] * WEIGHTS[j] * NODES[i] * twice * (z[0] + z[1] * x + z[2] * y)
                sx, sy = vx - spin * y, vy + spin * x
                speed = np.hypot(sx, sy)
                total[0] += share * sx / speed
                total[1] += share * sy / speed
                total[2] += share * (x * sy - y * sx) / speed
    return total


@compiled
def sustained(z: Float, part: Float, count: int, load: Float) -> float:
    """The largest factor of ``load`` (f_x, f_y, m) that friction of coefficient 1 holds; NaN if not found.

    It is the least dissipation among the motions v with load·v = 1. Dissipation is convex in v, so every start leads to
    the minimum; further starts are needed only where rounding stops the first on very thin parts. Lengths are divided
    by the part's reach, so that velocities and spins are comparable.
    """
    reach = 0.0
    for k in range(count):
        reach = max(reach, np.hypot(part[k, 0], part[k, 1]))
    scale = np.array([1.0, 1.0, reach])
    e = load / scale
    length = np.linalg.norm(e)
    e /= length
    first = np.zeros(3)
    first[np.argmin(np.abs(e))] = 1.0
    first = np.cross(e, first)
    first /= np.linalg.norm(first)
    second = np.cross(e, first)
    for a, b in ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
        least = least_dissipation(z, part, count, scale, e + a * first + b * second, first, second)
        if not np.isnan(least):
            return float(least / length)
    return np.nan


@compiled
def least_dissipation(z: Float, part: Float, count: int, scale: Float, v: Float, first: Float, second: Float) -> float:
    """The minimum of dissipation over the plane through ``v`` along two unit vectors; NaN if not found.

    ``v`` and the plane are in velocities divided by ``scale`` (3,). Newton's method with halved steps; its second
    derivatives are differences of the gradient F.
    """
    reach = scale[2]
    F = friction(z, part, count, reach, v / scale) / scale
    for _ in range(STEPS):
        slope = np.array([F @ first, F @ second])
        size = np.linalg.norm(F)
        if np.linalg.norm(slope) <= FLAT * size:
            return float(F @ v)
        small = STEP * np.linalg.norm(v)
        d1 = (friction(z, part, count, reach, (v + small * first) / scale) / scale - F) / small
        d2 = (friction(z, part, count, reach, (v + small * second) / scale) / scale - F) / small
        a, b, c = d1 @ first, 0.5 * (d1 @ second + d2 @ first), d2 @ second
        stiff = 1e-9 * size / np.linalg.norm(v)
        a, c = np.maximum(a, 0.0) + stiff, np.maximum(c, 0.0) + stiff
        det = a * c - b * b
        step = -slope / np.array([a, c])
        if det > 0:
            step = -np.array([c * slope[0] - b * slope[1], a * slope[1] - b * slope[0]]) / det
        step *= min(1.0, np.linalg.norm(v) / np.linalg.norm(step))  # where the curvature is next to nothing
        dissipated, falls = F @ v, slope @ step
        share = 1.0
        while share > 1e-9:
            tried = v + share * (step[0] * first + step[1] * second)
            G = friction(z, part, count, reach, tried / scale) / scale
            # close to the minimum rounding hides the fall of the dissipation, not that of the slope
            flatter = np.hypot(G @ first, G @ second) <= 0.5 * np.linalg.norm(slope) <= NEAR * size
            if flatter or G @ tried <= dissipated + 1e-4 * share * falls:
                break
            share *= 0.5
        else:
            break
        v, F = tried, G
    slope = np.array([F @ first, F @ second])
    return float(F @ v) if np.linalg.norm(slope) <= ENOUGH * np.linalg.norm(F) else np.nan
