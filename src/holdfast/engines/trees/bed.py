"""An even bed: the pressure on a plane contact.

A bed of springs of the same stiffness everywhere presses with p = max(0, a + b·x) at the place x in its plane. The
three numbers are those for which the pressure has the resultant and the moments that equilibrium asks for: the minimum
of a convex function, by Newton's method. All integrals run over the part where p is positive, the faces cut off at the
line p = 0, and are sums over edges. Seen from a point on that line, its own parts add nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from holdfast.base.arrays import Float, frozen
from holdfast.base.compiled import by_reference, compiled, lean

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
            return (-here * px / slope, -here * py / slope) if slope > 0.0 else (0.0, 0.0)
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
            return bool(-slope <= 1e-10 * abs(value))
        value = at
        for i in range(3):
            p[i] = trial[i]
    return False


@compiled
@lean
def find_pressure(bed: Bed, q: Float, s: Scratch, near: bool) -> bool:
    """Write to ``s.p`` the pressure whose integrals with (1, x, y) are ``q`` (3,); False if none is found.

    If ``near``, the search begins at ``s.p``; else where the bed presses everywhere. If that fails, the resultant is
    led there from the middle of the bed, half of what is left of the way at a time.
    """
    p = s.p
    if not q[0] > 0.0:
        return False
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
