"""An even bed: the pressure on a plane contact, and the motion that its friction resists with all it has.

A bed of springs of the same stiffness everywhere presses with p = max(0, a + b·x) at the place x in its plane. The
three numbers are those for which the pressure has the resultant and the moments that equilibrium asks for: the minimum
of a convex function, by Newton's method. All integrals run over the part where p is positive, the faces cut off at the
line p = 0, and are sums over edges. Seen from a point on that line, its own parts add nothing.

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
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, frozen
from holdfast.base.compiled import by_reference, compiled, lean

FOUND = 1e-9  # relative loss of power below which a motion is the one that resists least
FAR = 8.0  # distance of a centre of rotation, in sizes of what presses, from which on a rule of points is more exact
RULE = frozen(  # barycentric coordinates and weights, exact to degree 6 (Dunavant, IJNME 21, 1985)
    np.array(
        [
            (0.249286745170910, 0.249286745170910, 0.116786275726379),
            (0.249286745170910, 0.501426509658179, 0.116786275726379),
            (0.501426509658179, 0.249286745170910, 0.116786275726379),
            (0.063089014491502, 0.063089014491502, 0.050844906370207),
            (0.063089014491502, 0.873821971016996, 0.050844906370207),
            (0.873821971016996, 0.063089014491502, 0.050844906370207),
            (0.310352451033784, 0.636502499121399, 0.082851075618374),
            (0.636502499121399, 0.310352451033784, 0.082851075618374),
            (0.310352451033784, 0.053145049844817, 0.082851075618374),
            (0.053145049844817, 0.310352451033784, 0.082851075618374),
            (0.636502499121399, 0.053145049844817, 0.082851075618374),
            (0.053145049844817, 0.636502499121399, 0.082851075618374),
        ]
    )
)


@by_reference
class Bed(NamedTuple):
    """The faces of a plane contact, in a frame in its plane.

    ``edges`` (E, 5): both ends of each edge of all faces, counter-clockwise around faces and clockwise around holes,
    and the friction coefficient of the face. ``hull`` (H, 3): rows (c, n) with c + n·x >= 0 for all x in the hull of
    the faces, n of length one. ``size`` (2,): the largest distance of a corner from the origin, [m] like all lengths,
    and the friction coefficient of all faces, 0 if they differ.
    """

    edges: Float
    hull: Float
    size: Float
    rule: Float


@by_reference
class Scratch(NamedTuple):
    """The pressure p = ``p``·(1, x, y) (3,), the motion ``m`` (3,) that resists last, and memory to work in.

    ``M`` (3, 3): integrals of (1, x, y)(1, x, y)ᵀ where the bed presses. ``K``, ``L`` (3, 3): derivatives of the
    friction ``f``, ``g`` (3,) by the motion. ``about`` (6,): integrals about a centre of rotation. ``across``
    (2, 3): motions along which the load has no power. ``middle`` (3,): the centre of pressure, and the distance from it
    of the farthest place that presses. ``new``, ``trial``, ``carried``, ``q``, ``t``, ``p0``, ``p1``, ``n`` (3,).
    """

    p: Float
    m: Float
    M: Float
    K: Float
    L: Float
    f: Float
    g: Float
    about: Float
    across: Float
    middle: Float
    new: Float
    trial: Float
    carried: Float
    q: Float
    t: Float
    p0: Float
    p1: Float
    n: Float

    @classmethod
    def make(cls) -> Scratch:
        """Return memory that anything may be written to."""
        shapes = [3, 3, (3, 3), (3, 3), (3, 3), 3, 3, 6, (2, 3), 3, 3, 3, 3, 3, 3, 3, 3, 3]
        return cls(*(np.zeros(shape) for shape in shapes))


@compiled
@lean
def pressed_part(
    ax: float, ay: float, bx: float, by: float, pa: float, pb: float
) -> tuple[float, float, float, float, int]:
    """Return the ends of the part of an edge on which p > 0, given p at its ends, and how it was cut.

    That is 0 for not at all, 1 at its beginning, 2 at its end, and -1 if nothing is left of it. An end at which p is 0
    counts as a cut, so that the line p = 0 has both of its ends.
    """
    if pa <= 0.0 and pb <= 0.0:
        return ax, ay, bx, by, -1
    if pa <= 0.0:
        t = pa / (pa - pb)
        return ax + t * (bx - ax), ay + t * (by - ay), bx, by, 1
    if pb <= 0.0:
        t = pa / (pa - pb)
        return ax, ay, ax + t * (bx - ax), ay + t * (by - ay), 2
    return ax, ay, bx, by, 0


@compiled
@lean
def on_the_border(bed: Bed, here: float, px: float, py: float, x0: float, y0: float) -> tuple[float, float]:
    """Return a point on the line p = 0 if it meets the faces, else the origin: seen from there that line adds nothing.

    Coordinates are those about (x0, y0), where p is ``here``, and (px, py) is its gradient.
    """
    for k in range(len(bed.edges)):
        if here + px * (bed.edges[k, 0] - x0) + py * (bed.edges[k, 1] - y0) <= 0.0:
            slope = px * px + py * py
            return -here * px / slope, -here * py / slope
    return 0.0, 0.0


@compiled
@lean
def second_moments(bed: Bed, p: Float, x0: float, y0: float, M: Float) -> None:
    """Write the integrals of (1, x, y)(1, x, y)ᵀ over where p >= 0 to ``M`` (3, 3), in coordinates about (x0, y0)."""
    for i in range(3):
        for j in range(3):
            M[i, j] = 0.0
    cx, cy = on_the_border(bed, p[0], p[1], p[2], x0, y0)
    for k in range(len(bed.edges)):
        ax, ay, bx, by = bed.edges[k, 0] - x0, bed.edges[k, 1] - y0, bed.edges[k, 2] - x0, bed.edges[k, 3] - y0
        ax, ay, bx, by, cut = pressed_part(ax, ay, bx, by, p[0] + p[1] * ax + p[2] * ay, p[0] + p[1] * bx + p[2] * by)
        if cut < 0:
            continue
        area = ((ax - cx) * (by - cy) - (bx - cx) * (ay - cy)) / 2
        sx, sy = cx + ax + bx, cy + ay + by
        M[0, 0] += area
        M[0, 1] += area * sx / 3
        M[0, 2] += area * sy / 3
        M[1, 1] += area * (cx * cx + ax * ax + bx * bx + sx * sx) / 12
        M[1, 2] += area * (cx * cy + ax * ay + bx * by + sx * sy) / 12
        M[2, 2] += area * (cy * cy + ay * ay + by * by + sy * sy) / 12
    M[1, 0], M[2, 0], M[2, 1] = M[0, 1], M[0, 2], M[1, 2]


@compiled
@lean
def solved(M: Float, right: Float, x: Float) -> bool:
    """Write x (3,) with M x = right for a symmetric M (3, 3); False if M is singular."""
    a, b, c, d, e, f = M[0, 0], M[0, 1], M[0, 2], M[1, 1], M[1, 2], M[2, 2]
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    D, E, F = a * f - c * c, b * c - a * e, a * d - b * b
    det = a * A + b * B + c * C
    if not abs(det) > 1e-300:
        return False
    u, v, w = right[0], right[1], right[2]
    x[0], x[1], x[2] = (A * u + B * v + C * w) / det, (B * u + D * v + E * w) / det, (C * u + E * v + F * w) / det
    return True


@compiled
@lean
def _pressing_at(bed: Bed, x0: float, y0: float, s: Scratch) -> bool:
    """Find the pressure with resultant 1 at (x0, y0), in coordinates about that point, from ``s.p`` by Newton's method.

    It is the minimum of ∫ max(0, p)² / 2 - p(x0, y0), whose derivatives by p are the resultant and the moments.
    """
    p, M, new, trial, carried, right = s.p, s.M, s.new, s.trial, s.carried, s.t
    right[0], right[1], right[2] = 1.0, 0.0, 0.0
    second_moments(bed, p, x0, y0, M)
    value = 0.0
    for i in range(3):
        carried[i] = M[i, 0] * p[0] + M[i, 1] * p[1] + M[i, 2] * p[2]
        value += carried[i] * p[i] / 2
    value -= p[0]
    for _ in range(60):
        if not solved(M, right, new):
            return False
        slope = 0.0
        for i in range(3):
            slope -= (right[i] - carried[i]) * (new[i] - p[i])
        if -slope <= 1e-13 * abs(value):
            return True
        step, falls = 1.0, False
        for _back in range(30):
            for i in range(3):
                trial[i] = p[i] + step * (new[i] - p[i])
            second_moments(bed, trial, x0, y0, M)
            at = -trial[0]
            for i in range(3):
                carried[i] = M[i, 0] * trial[0] + M[i, 1] * trial[1] + M[i, 2] * trial[2]
                at += carried[i] * trial[i] / 2
            falls = M[0, 0] > 0.0 and at <= value + 1e-4 * step * slope + 1e-15 * abs(value)
            if falls:
                break
            step /= 2
        if not falls:
            return -slope <= 1e-10 * abs(value)
        value = at
        for i in range(3):
            p[i] = trial[i]
    return False


@compiled
@lean
def find_pressure(bed: Bed, q: Float, s: Scratch, near: bool) -> bool:
    """Write to ``s.p`` the pressure whose integrals with (1, x, y) are ``q`` (3,), q[0] > 0; False if none is found.

    If ``near``, the search begins at ``s.p``; else where the bed presses everywhere. If that fails, the resultant is
    led there from the middle of the bed, half of what is left of the way at a time.
    """
    p = s.p
    x0, y0 = q[1] / q[0], q[2] / q[0]
    found = False
    if near:
        p[0], p[1], p[2] = (p[0] + p[1] * x0 + p[2] * y0) / q[0], p[1] / q[0], p[2] / q[0]
        found = _pressing_at(bed, x0, y0, s)
    if not found:
        p[0], p[1], p[2] = 1.0, 0.0, 0.0
        second_moments(bed, p, x0, y0, s.M)
        if not s.M[0, 0] > 0.0:
            return False
        area, mx, my = s.M[0, 0], x0 + s.M[0, 1] / s.M[0, 0], y0 + s.M[0, 2] / s.M[0, 0]
        s.t[0], s.t[1], s.t[2] = 1.0, 0.0, 0.0
        found = solved(s.M, s.t, p) and _pressing_at(bed, x0, y0, s)
        if not found:
            p[0], p[1], p[2] = 1 / area, 0.0, 0.0
            left, x, y = 1.0, mx, my
            for k in range(40):
                left = left / 2 if k < 30 else 0.0
                to_x, to_y = x0 + left * (mx - x0), y0 + left * (my - y0)
                p[0] += p[1] * (to_x - x) + p[2] * (to_y - y)
                x, y = to_x, to_y
                found = _pressing_at(bed, x, y, s)
                if left == 0.0 or not found:
                    break
    p[0], p[1], p[2] = q[0] * (p[0] - p[1] * x0 - p[2] * y0), q[0] * p[1], q[0] * p[2]
    s.middle[0], s.middle[1], s.middle[2] = x0, y0, 0.0
    for k in range(len(bed.edges)):
        ax, ay, bx, by = bed.edges[k, 0], bed.edges[k, 1], bed.edges[k, 2], bed.edges[k, 3]
        ax, ay, bx, by, cut = pressed_part(ax, ay, bx, by, p[0] + p[1] * ax + p[2] * ay, p[0] + p[1] * bx + p[2] * by)
        if cut >= 0:
            s.middle[2] = max(s.middle[2], math.hypot(ax - x0, ay - y0), math.hypot(bx - x0, by - y0))
    return found


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
        return speed * about[0]
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
    return 1 / along


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
    return 1 / power, gap
