"""The contact law: elastic, without adhesion, Coulomb friction that is not dilatant; and its consistent Jacobian.

At a node with displacement u = (u_n, u_t) of body b against body a (Nadeau & Kelly, Sec. IV, where a contact is a bed
of equal springs):

    f_n = k max(0, -u_n - g)                           (no adhesion)
    f_t = -ρ k u_t, shortened to length μ f_n          (stick, or slip against the displacement)

where g is the clearance of the node: how far its two faces are apart before anything is loaded, negative where they
would overlap; zero on ideal faces. Units are those of model.py.
"""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.base.compiled import compiled, fused, lean
from holdfast.elastic.model import Elastic, Runs
from holdfast.elastic.twists import add_wrench, sheet_twist
from holdfast.elastic.vectors import scale


@compiled
@lean
def bond(m: Elastic) -> None:
    """Fill ``bonded``: the sum over nodes of Bᵀ diag(k, ρk, ρk) B with all of them stuck; and ``still``."""
    m.still[:] = 0.0
    for p in range(len(m.a)):
        D = m.bonded[p]
        D[:] = 0.0
        for i in range(m.first[p], m.first[p + 1]):
            x, y, k = m.x[i], m.y[i], m.k[i]
            t = m.rho * k
            D[0, 0] += k
            D[0, 4] += k * y
            D[0, 5] -= k * x
            D[4, 4] += k * y * y
            D[4, 5] -= k * x * y
            D[5, 5] += k * x * x
            D[1, 1] += t
            D[1, 3] -= t * y
            D[2, 2] += t
            D[2, 3] += t * x
            D[3, 3] += t * (x * x + y * y)
        for i in range(6):
            for j in range(i):
                D[i, j] = D[j, i]
        if m.mu[p] == 0:
            drag_on_world(m, p)


@compiled
@lean
def drag_on_world(m: Elastic, p: int) -> None:
    """Let sheet p, which has no friction, bond each of its bodies to the world along its plane, not to each other.

    Bonds are what drag stands for: along ice no body drags another, so none is taken along by what slides off below it.
    """
    D = m.bonded[p]
    for body, arm in ((m.a[p], m.arm_a[p]), (m.b[p], m.arm_b[p])):
        if body < 0:
            continue
        for i in range(3):
            m.still[6 * body + i] += D[1, 1]
            m.still[6 * body + 3 + i] += D[3, 3] + D[1, 1] * (arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2)
    D[1:4, :] = 0.0
    D[:, 1:4] = 0.0


@compiled
@lean
@fused
def nearest(runs: Runs, run: int, v: Float, weight: float) -> float:
    """The most that a node of this run can be pressed under the sheet's twist ``v`` (6,).

    It is rounded as what a node is pressed, and rounding keeps the order: where it is not positive, no node presses.
    """
    x = runs.box[run, 1] if v[5] > 0 else runs.box[run, 0]
    y = runs.box[run, 2] if v[4] > 0 else runs.box[run, 3]
    return float(x * v[5] - y * v[4] - v[0] - weight * runs.box[run, 4])


@compiled
@lean
@fused
def evaluate(m: Elastic, weight: float, q: Float, r: Float, K: Float, v: Float, F: Float) -> int:
    """r (6J,) = weight · wrench + G f(Gᵀ q) - hold q, and K (P, 6, 6): minus the derivative of each sheet's wrench.

    Clearances are multiplied by ``weight``, too: loads beside which no weight counts make all clearances small.
    ``v``, ``F`` (6,) are scratch. Returns a number that tells which nodes are open, stuck or sliding.
    """
    scale(r, weight, m.wrench)
    for i in range(len(r)):
        r[i] -= m.hold[i] * q[i]
    states, rho = 0, m.rho
    for p in range(len(m.a)):
        sheet_twist(m, p, q, v)
        mu = m.mu[p]
        slippery = (mu / rho) ** 2
        fn = f1 = f2 = gn = g1 = g2 = 0.0
        nn = ny = nx = nyy = nxy = nxx = 0.0  # normal by normal
        sk = sx = sy = sr = 0.0  # of nodes that stick: Σ k, Σ k x, Σ k y and Σ k (x² + y²)
        t11 = t12 = t1w = t22 = t2w = tww = 0.0  # tangential by tangential, of nodes that slide
        c1 = c1y = c1x = c2 = c2y = c2x = cw = cwy = cwx = 0.0  # tangential by normal
        for run in range(m.runs.first[p], m.runs.first[p + 1]):
            if nearest(m.runs, run, v, weight) <= 0.0:
                continue
            for i in range(m.runs.node[run], m.runs.node[run + 1]):
                x, y, k = m.x[i], m.y[i], m.k[i]
                pressed = x * v[5] - y * v[4] - v[0] - weight * m.apart[i]
                if pressed <= 0.0:
                    continue
                kx, ky = k * x, k * y
                kxx, kyy = kx * x, ky * y
                nn += k
                ny += ky
                nx -= kx
                nyy += kyy
                nxy -= ky * x
                nxx += kxx
                normal = k * pressed
                fn += normal
                g1 += y * normal
                g2 -= x * normal
                if mu <= 0.0:  # no friction: nothing sticks, not even where nothing has moved yet
                    continue
                u1, u2 = v[1] - y * v[3], v[2] + x * v[3]
                square = u1 * u1 + u2 * u2
                if square <= slippery * pressed * pressed:
                    sk += k
                    sx += kx
                    sy += ky
                    sr += kxx + kyy
                    states += i + 1
                    continue
                inverse = 1 / np.sqrt(square)
                e1, e2 = u1 * inverse, u2 * inverse
                s1, s2 = -mu * normal * e1, -mu * normal * e2
                h = mu * normal * inverse
                d11, d12, d22 = h * e2 * e2, -h * e1 * e2, h * e1 * e1
                t11 += d11
                t12 += d12
                t1w += x * d12 - y * d11
                t22 += d22
                t2w += x * d22 - y * d12
                tww += y * y * d11 - 2 * x * y * d12 + x * x * d22
                b1, b2 = -mu * k * e1, -mu * k * e2  # less friction where the contact lifts
                bw = x * b2 - y * b1
                c1 += b1
                c1y += b1 * y
                c1x -= b1 * x
                c2 += b2
                c2y += b2 * y
                c2x -= b2 * x
                cw += bw
                cwy += bw * y
                cwx -= bw * x
                states += (i + 1) * 7919
                f1 += s1
                f2 += s2
                gn += x * s2 - y * s1
        f1 -= rho * (sk * v[1] - sy * v[3])
        f2 -= rho * (sk * v[2] + sx * v[3])
        gn -= rho * (sx * v[2] - sy * v[1] + sr * v[3])
        t11 += rho * sk
        t1w -= rho * sy
        t22 += rho * sk
        t2w += rho * sx
        tww += rho * sr
        F[0], F[1], F[2], F[3], F[4], F[5] = fn, f1, f2, gn, g1, g2
        D = K[p]
        D[0, 0], D[0, 1], D[0, 2], D[0, 3], D[0, 4], D[0, 5] = nn, 0.0, 0.0, 0.0, ny, nx
        D[1, 0], D[1, 1], D[1, 2], D[1, 3], D[1, 4], D[1, 5] = c1, t11, t12, t1w, c1y, c1x
        D[2, 0], D[2, 1], D[2, 2], D[2, 3], D[2, 4], D[2, 5] = c2, t12, t22, t2w, c2y, c2x
        D[3, 0], D[3, 1], D[3, 2], D[3, 3], D[3, 4], D[3, 5] = cw, t1w, t2w, tww, cwy, cwx
        D[4, 0], D[4, 1], D[4, 2], D[4, 3], D[4, 4], D[4, 5] = ny, 0.0, 0.0, 0.0, nyy, nxy
        D[5, 0], D[5, 1], D[5, 2], D[5, 3], D[5, 4], D[5, 5] = nx, 0.0, 0.0, 0.0, nxy, nxx
        add_wrench(m, p, F, 1.0, r)
    return states


@compiled
def node_forces(m: Elastic, q: Float, f: Float) -> None:
    """``f`` (I, 3) = (f_n, f_t1, f_t2) on body b at every node, in total weights."""
    v = np.empty(6)
    for p in range(len(m.a)):
        sheet_twist(m, p, q, v)
        for i in range(m.first[p], m.first[p + 1]):
            x, y, k = m.x[i], m.y[i], m.k[i]
            normal = k * max(0.0, x * v[5] - y * v[4] - v[0] - m.apart[i])
            u1, u2 = v[1] - y * v[3], v[2] + x * v[3]
            wanted = m.rho * k * np.sqrt(u1 * u1 + u2 * u2)
            share = m.rho * k
            if wanted > m.mu[p] * normal:
                share *= m.mu[p] * normal / wanted
            f[i, 0], f[i, 1], f[i, 2] = normal, -share * u1, -share * u2


@compiled
@lean
def slid(m: Elastic, rest: Float, q: Float, stuck: Float, s: float, v: Float, w: Float, sums: Float) -> float:
    """How far the contacts of a body have slid at q (n,) since ``rest`` (n,), over what gives there; the most of all.

    A node slides by how far it was moved along its faces beyond what friction springs back. What gives there is what
    one of its bodies would have moved if every contact stuck, the softer one: ``stuck`` (2, n) are those displacements
    under the wrench, and under the load, of which there is s times as much. The mean over the nodes of a body is
    weighted by what they press. ``v``, ``w`` (6,) and ``sums`` (n,) are scratch.
    """
    sums[:] = 0.0
    for p in range(len(m.a)):
        sheet_twist(m, p, q, v)
        sheet_twist(m, p, rest, w)
        springs = m.mu[p] / m.rho
        far = normal = 0.0
        for i in range(m.first[p], m.first[p + 1]):
            x, y, apart = m.x[i], m.y[i], m.apart[i]
            pressed = x * v[5] - y * v[4] - v[0] - apart
            if pressed <= 0.0:
                continue
            normal += m.k[i] * pressed
            before = springs * max(0.0, x * w[5] - y * w[4] - w[0] - apart)
            beyond = max(0.0, np.sqrt((v[1] - y * v[3]) ** 2 + (v[2] + x * v[3]) ** 2) - springs * pressed)
            beyond0 = max(0.0, np.sqrt((w[1] - y * w[3]) ** 2 + (w[2] + x * w[3]) ** 2) - before)
            far += m.k[i] * pressed * abs(beyond - beyond0)
        give = max(given(stuck, s, m.a[p]), given(stuck, s, m.b[p]), 1e-300)
        for body in (m.a[p], m.b[p]):
            if body >= 0:
                sums[6 * body] += far / give if springs > 0.0 else 0.0
                sums[6 * body + 1] += normal
    most = 0.0
    for j in range(0, len(q), 6):
        if sums[j + 1] > 0.0:
            most = max(most, sums[j] / sums[j + 1])
    return most


@compiled
@lean
def given(stuck: Float, s: float, body: int) -> float:
    """How far a ``body`` would have moved if every contact stuck, as ``slid`` has it; 0 if it is fixed."""
    if body < 0:
        return 0.0
    wrench = load = 0.0
    for i in range(6 * body, 6 * body + 6):
        wrench += stuck[0, i] ** 2
        load += stuck[1, i] ** 2
    return float(np.sqrt(wrench) + abs(s) * np.sqrt(load))


@compiled
def next_change(m: Elastic, q: Float, t: Float) -> float:
    """The smallest h > 0 at which a node of q + h t begins or ceases to press or to slide; inf if none does."""
    first = np.inf
    v, d = np.empty(6), np.empty(6)
    for p in range(len(m.a)):
        sheet_twist(m, p, q, v)
        sheet_twist(m, p, t, d)
        mu, rho = m.mu[p], m.rho
        for i in range(m.first[p], m.first[p + 1]):
            x, y = m.x[i], m.y[i]
            n, dn = x * v[5] - y * v[4] - v[0] - m.apart[i], x * d[5] - y * d[4] - d[0]
            if n * dn < 0:
                first = min(first, -n / dn)
            if n <= 0 or mu <= 0:
                continue
            u1, u2, d1, d2 = v[1] - y * v[3], v[2] + x * v[3], d[1] - y * d[3], d[2] + x * d[3]
            # ρ² |u + h d|² = μ² (n + h dn)²
            A = rho * rho * (d1 * d1 + d2 * d2) - mu * mu * dn * dn
            B = rho * rho * (u1 * d1 + u2 * d2) - mu * mu * n * dn
            C = rho * rho * (u1 * u1 + u2 * u2) - mu * mu * n * n
            inside = B * B - A * C
            if inside < 0:
                continue
            root = -(B + np.sqrt(inside)) if B >= 0 else np.sqrt(inside) - B
            for h in (root / A if A != 0 else np.inf, C / root if root != 0 else np.inf):
                if h > 0 and n + h * dn > 0:
                    first = min(first, h)
    return first
