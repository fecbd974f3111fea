"""The friction of an even bed: how much of it a wrench in its plane uses, and along which motion it gives way.

A motion m = (v, w) in the plane, of the origin and about it, meets friction of the power ∫ μ p |v + w e_z x x| dA. In
polar coordinates about the centre of rotation that is closed form, edge by edge, as are the force, the torque (its
derivatives by m) and their derivatives: with d the distance of the centre from the line of an edge and u = tan φ the
place along it, over d, integrals of sec φ, sec³ φ and their like. The parts of the line p = 0 that close the cut faces
add up from their ends, in any order. If the centre is far from what presses, these sums cancel, but the power is so
smooth that a rule of 12 points on each triangle is exact to 1e-7.

The forces that friction can carry are the limit surface (Goyal, Ruina, Papadopoulos, Wear 143, 1991): those whose power
along no motion exceeds that of friction. So a tangential wrench t uses the share max t·m / power(m) of it, and the m
that attains the maximum is how the body would slide.
"""

from __future__ import annotations

import math

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, lean
from holdfast.engines.trees.bed import Bed, Scratch, on_the_border, pressed_part

FOUND = 1e-9  # relative loss of power below which a motion is the one that resists least
FAR = 8.0  # distance of a centre of rotation, in sizes of what presses, from which on a rule of points is more exact


@compiled
@lean
def _add_line(
    u: float, to: float, d: float, n0: float, n1: float, here: float, p: Float, mu: float, about: Float
) -> None:
    """Add ``mu`` times the integrals from tan φ = u to tan φ = ``to`` over a triangle between a centre and a line.

    The line is at the distance d > 0 of the centre along the normal (n0, n1); ``here`` is p at the centre. The
    integrals are of p r, of p e and of p e eᵀ / r (xx, xy, yy), where r e leads from the centre to x.
    """
    t0, t1 = -n1, n0
    bn, bt = p[1] * n0 + p[2] * n1, p[1] * t0 + p[2] * t1
    sec0, sec1 = math.sqrt(1 + u * u), math.sqrt(1 + to * to)
    before, behind = sec0 + abs(u), sec1 + abs(to)  # asinh u = log(u + sec)
    log = math.log((behind if to > 0.0 else 1 / behind) * (1 / before if u > 0.0 else before))
    sec, cos, sin = sec1 - sec0, 1 / sec1 - 1 / sec0, to / sec1 - u / sec0
    cubed = (sec1 * to - sec0 * u + log) / 2
    third = (sec1 * sec1 * sec1 - sec0 * sec0 * sec0) / 3
    here, bn, bt = mu * d * here, mu * d * d * bn, mu * d * d * bt
    about[0] += d * d * (here / 3 * cubed + (bn * cubed + bt * third) / 4)
    fn = d * (here / 2 * log + (bn * log + bt * sec) / 3)
    ft = d * (here / 2 * sec + (bn * sec + bt * (cubed - log)) / 3)
    about[1] += fn * n0 + ft * t0
    about[2] += fn * n1 + ft * t1
    nn = here * sin + (bn * sin - bt * cos) / 2
    nt = -here * cos + (bt * (log - sin) - bn * cos) / 2
    tt = here * (log - sin) + (bn * (log - sin) + bt * (sec + cos)) / 2
    about[3] += nn * n0 * n0 + 2 * nt * n0 * t0 + tt * t0 * t0
    about[4] += nn * n0 * n1 + nt * (n0 * t1 + n1 * t0) + tt * t0 * t1
    about[5] += nn * n1 * n1 + 2 * nt * n1 * t1 + tt * t1 * t1


@compiled
@lean
def _about_centre(bed: Bed, pressed: Float, p: Float, cx: float, cy: float, about: Float) -> None:
    """Write the integrals of ``_add_line`` (6,), with μ, over where ``pressed`` >= 0, about the centre (cx, cy)."""
    for k in range(6):
        about[k] = 0.0
    here, slope = p[0] + p[1] * cx + p[2] * cy, math.sqrt(pressed[1] * pressed[1] + pressed[2] * pressed[2])
    border, z0, z1 = 0.0, 1.0, 0.0  # the line pressed = 0: its distance from the centre, and the normal towards it
    if slope > 0.0:
        border = (pressed[0] + pressed[1] * cx + pressed[2] * cy) / slope
        z0, z1 = -pressed[1] / slope, -pressed[2] / slope
        if border < 0.0:
            border, z0, z1 = -border, -z0, -z1
    for k in range(len(bed.edges)):
        ax, ay, bx, by = bed.edges[k, 0], bed.edges[k, 1], bed.edges[k, 2], bed.edges[k, 3]
        mu, ex, ey = bed.edges[k, 4], bx - ax, by - ay
        ax, ay, bx, by, cut = pressed_part(
            *(ax, ay, bx, by),
            pressed[0] + pressed[1] * ax + pressed[2] * ay,
            pressed[0] + pressed[1] * bx + pressed[2] * by,
        )
        if cut < 0:
            continue
        length = math.sqrt(ex * ex + ey * ey)
        n0, n1 = ey / length, -ex / length
        d = (bed.edges[k, 0] - cx) * n0 + (bed.edges[k, 1] - cy) * n1
        if d < 0.0:
            d, n0, n1 = -d, -n0, -n1
        if d > 1e-14 * length:
            from_, to = ((ax - cx) * -n1 + (ay - cy) * n0) / d, ((bx - cx) * -n1 + (by - cy) * n0) / d
            _add_line(from_, to, d, n0, n1, here, p, mu, about)
        if cut == 1 and border > 0.0:  # a part of the border ends here
            _add_line(0.0, ((ax - cx) * -z1 + (ay - cy) * z0) / border, border, z0, z1, here, p, mu, about)
        if cut == 2 and border > 0.0:  # ... and another begins here
            _add_line(((bx - cx) * -z1 + (by - cy) * z0) / border, 0.0, border, z0, z1, here, p, mu, about)


@compiled
@lean
def friction(bed: Bed, pressed: Float, p: Float, m: Float, s: Scratch, f: Float, K: Float) -> float:
    """Return the power of friction against a motion ``m`` (3,), and write its derivatives: ``f`` (3,) and ``K`` (3, 3).

    ``f`` is the force and the torque about the origin with which friction at its limit would be overcome. All are
    integrals with the pressure ``p`` over where ``pressed`` >= 0.
    """
    vx, vy, w = m[0], m[1], m[2]
    x, y, reach = s.middle[0], s.middle[1], s.middle[2]
    if math.hypot(vx - w * y, vy + w * x) <= FAR * reach * abs(w):
        cx, cy, sign, speed, about = -vy / w, vx / w, math.copysign(1.0, w), abs(w), s.about
        _about_centre(bed, pressed, p, cx, cy, about)
        f[0], f[1] = -sign * about[2], sign * about[1]
        f[2] = sign * about[0] + cx * f[1] - cy * f[0]
        xx, xy, yy = about[3] / speed, about[4] / speed, about[5] / speed
        K[0, 0], K[0, 1], K[1, 1] = xx, xy, yy
        K[0, 2], K[1, 2] = -xx * cy + xy * cx, -xy * cy + yy * cx
        K[2, 2] = xx * cy * cy - 2 * xy * cx * cy + yy * cx * cx
        K[1, 0], K[2, 0], K[2, 1] = K[0, 1], K[0, 2], K[1, 2]
        return float(speed * about[0])
    return _friction_by_rule(bed, pressed, p, m, x, y, f, K)


@compiled
@lean
def _friction_by_rule(bed: Bed, pressed: Float, p: Float, m: Float, x0: float, y0: float, f: Float, K: Float) -> float:
    for i in range(3):
        f[i] = 0.0
        for j in range(3):
            K[i, j] = 0.0
    power = 0.0
    s0 = pressed[0] + pressed[1] * x0 + pressed[2] * y0
    ox, oy = on_the_border(bed, s0, pressed[1], pressed[2], x0, y0)
    ox, oy = ox + x0, oy + y0
    for k in range(len(bed.edges)):
        ax, ay, bx, by = bed.edges[k, 0], bed.edges[k, 1], bed.edges[k, 2], bed.edges[k, 3]
        ax, ay, bx, by, cut = pressed_part(
            *(ax, ay, bx, by),
            pressed[0] + pressed[1] * ax + pressed[2] * ay,
            pressed[0] + pressed[1] * bx + pressed[2] * by,
        )
        if cut < 0:
            continue
        area = ((ax - ox) * (by - oy) - (bx - ox) * (ay - oy)) / 2
        for j in range(len(bed.rule)):
            g, h = bed.rule[j, 0], bed.rule[j, 1]
            x, y = g * ox + h * ax + (1 - g - h) * bx, g * oy + h * ay + (1 - g - h) * by
            normal = bed.edges[k, 4] * area * bed.rule[j, 2] * (p[0] + p[1] * x + p[2] * y)
            vx, vy = m[0] - m[2] * y, m[1] + m[2] * x
            speed = math.sqrt(vx * vx + vy * vy)
            vx, vy = vx / speed, vy / speed
            power += normal * speed
            f[0] += normal * vx
            f[1] += normal * vy
            f[2] += normal * (x * vy - y * vx)
            normal /= speed
            turn = vx * x + vy * y  # of (-vy, vx), across the motion, with e_z x x
            K[0, 0] += normal * vy * vy
            K[0, 1] -= normal * vx * vy
            K[1, 1] += normal * vx * vx
            K[0, 2] -= normal * vy * turn
            K[1, 2] += normal * vx * turn
            K[2, 2] += normal * turn * turn
    K[1, 0], K[2, 0], K[2, 1] = K[0, 1], K[0, 2], K[1, 2]
    return power


@compiled
@lean
def pushed(t: Float, m: Float, size: float, K: Float) -> float:
    """Scale a motion ``m`` (3,) so that t·m = 1, and with it ``K``, and return the factor; 0 where t is 0.

    One against which ``t`` (3,) has no power gives way to the motion along it.
    """
    along = m[0] * t[0] + m[1] * t[1] + m[2] * t[2]
    if not along > 0.0:
        m[0], m[1], m[2] = t[0], t[1], 2 * t[2] / (size * size)
        along = m[0] * t[0] + m[1] * t[1] + m[2] * t[2]
        if not along > 0.0:
            return 0.0
    for i in range(3):
        m[i] /= along
        for j in range(3):
            K[i, j] *= along
    return float(1 / along)


@compiled
@lean
def descend(bed: Bed, t: Float, power: float, s: Scratch) -> tuple[float, float, bool]:
    """Take a step of Newton's method from ``s.m`` to a motion with t·m = 1 whose power is less.

    ``power``, ``s.f`` and ``s.K`` belong to ``s.m`` and become those of the new one. Returns by which share of it the
    power would fall if it were a parabola, the new power, and whether there was a step: none is taken for less than
    FOUND.
    """
    m, f, K, across, size = s.m, s.f, s.K, s.across, bed.size[0]
    a, b, c = t[0], t[1], t[2] / size
    length = math.sqrt(a * a + b * b + c * c)
    a, b, c = a / length, b / length, c / length
    x, y, z = (b, -a, 0.0) if abs(c) < 0.7 else (0.0, c, -b)
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    across[0, 0], across[0, 1], across[0, 2] = x, y, z / size
    across[1, 0], across[1, 1], across[1, 2] = b * z - c * y, c * x - a * z, (a * y - b * x) / size
    g0, g1, k00, k01, k11 = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        g0 += across[0, i] * f[i]
        g1 += across[1, i] * f[i]
        for j in range(3):
            k00 += across[0, i] * K[i, j] * across[0, j]
            k01 += across[0, i] * K[i, j] * across[1, j]
            k11 += across[1, i] * K[i, j] * across[1, j]
    det = k00 * k11 - k01 * k01
    if not det > 1e-300:
        return 1.0, power, False
    d0, d1 = (k01 * g1 - k11 * g0) / det, (k01 * g0 - k00 * g1) / det
    slope = g0 * d0 + g1 * d1
    gap, step = -slope / power, 1.0
    if gap < FOUND:
        return gap, power, False
    for _ in range(20):
        for i in range(3):
            s.trial[i] = m[i] + step * (d0 * across[0, i] + d1 * across[1, i])
        there = friction(bed, s.p, s.p, s.trial, s, s.g, s.L)
        if there <= power + 0.1 * step * slope:
            for i in range(3):
                m[i], f[i] = s.trial[i], s.g[i]
                for j in range(3):
                    K[i, j] = s.L[i, j]
            return gap, there, True
        step /= 2
    return gap, power, False


@compiled
@lean
def share_used(bed: Bed, t: Float, s: Scratch) -> tuple[float, float]:
    """Return which share of friction a tangential wrench ``t`` (3,) uses under the pressure ``s.p``, and its error.

    It is 1 / min power(m) over the motions with t·m = 1, sought from ``s.m``, where the minimum is left. The share
    is too small by no more than that error (relative): what the next step would still gain.
    """
    if pushed(t, s.m, bed.size[0], s.K) == 0.0:
        return 0.0, 0.0
    power, gap = friction(bed, s.p, s.p, s.m, s, s.f, s.K), 1.0
    if not power > 0.0:  # no friction at all
        return 2.0, 0.0
    for _ in range(60):
        gap, power, moved = descend(bed, t, power, s)
        if not moved:
            break
    return (1 / power, gap) if power > 0.0 else (0.0, 1.0)


@compiled
@lean
def share_at_most(t: Float, s: Scratch, bed: Bed) -> float:
    """Return a share of friction under ``s.p`` that a tangential wrench ``t`` (3,) uses at most, μ being one for all.

    Friction of a turn about the centre of pressure carries the torque, and that of sliding all together the force that
    is left: what it carries in two motions, it carries in any mixture of both.
    """
    sliding, x, y = bed.size[1] * s.q[0], s.middle[0], s.middle[1]
    s.n[0], s.n[1], s.n[2] = y, -x, 1.0
    most = friction(bed, s.p, s.p, s.n, s, s.g, s.L)
    if not most > 0.0:
        return 2.0
    turns = (t[2] - x * t[1] + y * t[0]) / most
    return float(abs(turns) + math.hypot(t[0] - turns * s.g[0], t[1] - turns * s.g[1]) / sliding)
