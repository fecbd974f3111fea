"""One rectangular contact under load: linear pressure without tension, the friction that it sustains, first motion.

Pressure is integrated by exact moments of the part in touch. The limit surface of that part is the least dissipation
over power among all plane motions.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float

# Pressure
EDGE = 1e-4  # [-] of half a side: a resultant nearer to the edge is moved to this distance from it
RESIDUAL = 1e-12  # [-] of the resultant: the imbalance at which Newton's method ends
ENERGY_ROUNDING = 1e-13  # [-] of the energy: a rise that is attributed to rounding
PRESSURE_STEPS = 200  # most iterations of Newton's method; about ten are usual, thirty at the edge

# Friction
FAR = 3.0  # [-] times the patch's reach: further away the centre of rotation is integrated by quadrature
STEPS = 100  # most iterations of Newton's method; five to ten are usual
STEP = 1e-4  # [-] of the motion: the difference over which second derivatives are taken
NEAR = 1e-3  # [-] of friction's size: where the slope is smaller, a step is accepted if it reduces the slope
FLAT = 1e-6  # [-] of friction's size: the slope at which the search ends
ENOUGH = 1e-4  # [-] the slope that is accepted where rounding prevents a smaller one; the value errs by its square

# Gauss-Legendre on [0, 1]
NODES = 0.5 + 0.5 * np.polynomial.legendre.leggauss(6)[0]
WEIGHTS = 0.5 * np.polynomial.legendre.leggauss(6)[1]

# First motion
NOTHING = 1e-12  # [-] of the weight: a smaller load along the contact counts as zero
ROUNDING = 1e-9  # [-] by which the use of friction may exceed 1 in a contact that still holds
STATIONS = 96  # values of the load parameter τ at which the use of friction is evaluated
HALVINGS = 50  # bisections between two stations
SECTIONS = 25  # golden sections towards a maximum between two stations


# The pressure does not depend on the sides: up to ``corner_pressure`` all is on the square [0, 2] x [0, 2] whose origin
# is the corner nearest the resultant. From there the strips and triangles of a nearly toppled block keep their digits.


def touching(z: Float) -> tuple[Float, int]:
    """The part of the square [0, 2]² where z0 + z1 u + z2 v > 0: corners (5, 2) counter-clockwise, and how many."""
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    part = np.empty((5, 2))
    count = 0
    for k in range(4):
        a, b = square[k], square[(k + 1) % 4]
        pa, pb = z[0] + z[1] * a[0] + z[2] * a[1], z[0] + z[1] * b[0] + z[2] * b[1]
        if pa > 0:
            part[count] = a
            count += 1
        if (pa > 0) != (pb > 0):
            part[count] = a + pa / (pa - pb) * (b - a)
            count += 1
    return part, count


def moments(part: Float, count: int) -> Float:
    """(3, 3) integral of φ φᵀ with φ = (1, u, v) over a polygon, exactly: mid-side rule on the triangles of a fan."""
    A = np.zeros((3, 3))
    phi = np.ones(3)
    for k in range(1, count - 1):
        o, a, b = part[0], part[k], part[k + 1]
        area = 0.5 * ((a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]))
        for p, q in ((o, a), (a, b), (b, o)):
            phi[1], phi[2] = 0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])
            for i in range(3):
                for j in range(3):
                    A[i, j] += area / 3 * phi[i] * phi[j]
    return A


def corner_pressure(u: float, v: float) -> Float:
    """z (3,) of a pressure max(0, z0 + z1 u + z2 v) on [0, 2]² with resultant 1 at (u, v), 0 < u, v <= 1.

    z is the minimum of the convex ψ(z) = ½ ∫ max(0, z·φ)² - z·(1, u, v): its gradient is the imbalance. Newton's method
    with the Hessian of the part in touch, shortened until ψ falls; NaN if it fails.
    """
    wanted = np.array([1.0, u, v])
    z = np.array([0.25, 0.0, 0.0])
    part, count = touching(z)
    A = moments(part, count)
    for _ in range(PRESSURE_STEPS):
        left = wanted - A @ z
        if abs(left[0]) <= RESIDUAL and abs(left[1]) <= RESIDUAL * u and abs(left[2]) <= RESIDUAL * v:
            return z
        step = np.linalg.solve(A, left)
        energy, falls = 0.5 * z @ A @ z - wanted @ z, left @ step
        share = 1.0
        while True:
            tried = z + share * step
            part, count = touching(tried)
            A = moments(part, count)
            most = energy - 1e-4 * share * falls + ENERGY_ROUNDING * abs(energy)
            if 0.5 * tried @ A @ tried - wanted @ tried <= most:
                break
            share *= 0.5
            if share < 1e-10:  # at the limit of rounding: good enough, or not found
                fine = abs(left[0]) <= 1e-9 and abs(left[1]) <= 1e-9 * u and abs(left[2]) <= 1e-9 * v
                return z if fine else np.full(3, np.nan)
        z = tried
    return np.full(3, np.nan)


def linear_pressure(half: Float, x: float, y: float) -> tuple[Float, Float, int, Float]:
    """Pressure with resultant 1 at (x, y) on the rectangle |x| <= half[0], |y| <= half[1]: what equilibrium leaves.

    Returns z (3,), p = z0 + z1 ξ + z2 η, the part in touch as corners (5, 2) counter-clockwise, both in coordinates
    (ξ, η) about the resultant, the number of corners, and the resultant's place (2,): (x, y), but not nearer to the
    edge than ``EDGE``.
    """
    hx, hy = half[0], half[1]
    sx, sy = (1.0 if x >= 0 else -1.0), (1.0 if y >= 0 else -1.0)
    u, v = max(1 - abs(x) / hx, EDGE), max(1 - abs(y) / hy, EDGE)
    corner = corner_pressure(u, v)
    part, count = touching(corner)
    # the square's u = 1 - sx x / hx and v = 1 - sy y / hy, and a pressure of resultant 1 is 1 / (hx hy) as large here
    level = corner[0] + corner[1] * u + corner[2] * v
    z = np.array([level, -sx * corner[1] / hx, -sy * corner[2] / hy]) / (hx * hy)
    placed = np.empty((5, 2))
    for k in range(count):
        source = k if sx * sy > 0 else count - 1 - k  # a mirror image runs clockwise
        placed[k, 0], placed[k, 1] = sx * hx * (u - part[source, 0]), sy * hy * (v - part[source, 1])
    return z, placed, count, np.array([sx * hx * (1 - u), sy * hy * (1 - v)])


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


def friction(z: Float, part: Float, count: int, reach: float, v: Float) -> Float:
    """``f`` (3,) = (f_x, f_y, m): what friction of coefficient 1 sustains against the motion v = (v_x, v_y, spin).

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


def use(load: Float, mu: float, half: Float) -> float:
    """The share of its friction that a contact uses under a load (6,) as in ``contact_load``; it holds up to 1.

    The resultant of the pressure must lie inside the rectangle.
    """
    normal, along = load[3], load[:3].copy()
    if np.hypot(np.hypot(along[0], along[1]), along[2] / np.hypot(half[0], half[1])) <= NOTHING:
        return 0.0
    if normal <= 0 or mu == 0:
        return np.inf
    z, part, count, at = linear_pressure(half, load[4] / normal, load[5] / normal)
    along[2] -= at[0] * along[1] - at[1] * along[0]  # about the resultant of pressure: the scale of a small part
    factor = sustained(z, part, count, along / normal)
    return 1 / (mu * factor) if factor > 0 else np.nan if np.isnan(factor) else np.inf


def first_motion(rest: Float, push: Float, mu: float, half: Float, most: float) -> float:
    """The first s at which a contact gives way under rest + s push, at most ``most``; 0 if it does not hold at s = 0.

    Friction and pressure are homogeneous, so s from 0 to infinity is the way (1 - τ) rest + τ push, 0 <= τ <= 1, whose
    end is the push alone. Toppling, where the pressure's resultant reaches a side, is linear in τ.
    """
    tip = most / (1 + most) if np.isfinite(most) else 1.0
    for axis in range(2):
        for sign in (-1.0, 1.0):
            inside = half[axis] * rest[3] + sign * rest[4 + axis]
            change = half[axis] * push[3] + sign * push[4 + axis]
            if inside <= 0:
                return 0.0
            if change < -NOTHING * half[axis]:
                tip = min(tip, inside / (inside - change))
    end = tip
    before = worst = use(rest, mu, half)
    if before > 1 + ROUNDING:
        return 0.0
    earlier = before
    for k in range(1, STATIONS + 1):
        tau = end * k / STATIONS
        now = use((1 - tau) * rest + tau * push, mu, half)
        if np.isnan(now):
            return np.nan
        low, high = tau - end / STATIONS, tau
        if now <= 1 + ROUNDING and before > earlier and before > now and k > 1:
            # a maximum lies between: it may reach beyond friction and come back
            high, worst = highest(rest, push, mu, half, tau - 2 * end / STATIONS, tau)
            low = tau - 2 * end / STATIONS
        else:
            worst = now
        if worst > 1 + ROUNDING:
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if use((1 - middle) * rest + middle * push, mu, half) > 1 + ROUNDING:
                    high = middle
                else:
                    low = middle
            return low / (1 - low)
        earlier, before = before, now
    return tip / (1 - tip) if tip < 1 else np.inf


def highest(rest: Float, push: Float, mu: float, half: Float, low: float, high: float) -> tuple[float, float]:
    """(τ, use) at the maximum of ``use`` between two stations."""
    golden = 0.5 * (np.sqrt(5.0) - 1)
    a, b = high - golden * (high - low), low + golden * (high - low)
    at_a, at_b = use((1 - a) * rest + a * push, mu, half), use((1 - b) * rest + b * push, mu, half)
    for _ in range(SECTIONS):
        if at_a > at_b:
            high, b, at_b = b, a, at_a
            a = high - golden * (high - low)
            at_a = use((1 - a) * rest + a * push, mu, half)
        else:
            low, a, at_a = a, b, at_b
            b = low + golden * (high - low)
            at_b = use((1 - b) * rest + b * push, mu, half)
    return (a, at_a) if at_a > at_b else (b, at_b)
