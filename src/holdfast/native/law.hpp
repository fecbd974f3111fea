// The contact law: elastic, without adhesion, Coulomb friction that is not dilatant; and its consistent Jacobian.
//
// At a node with displacement u = (u_n, u_t) of body b against body a (Nadeau & Kelly, Sec. IV, where a contact is a
// bed of equal springs):
//
//     f_n = k max(0, -u_n - g)                           (no adhesion)
//     f_t = -ρ k u_t, shortened to length μ f_n          (stick, or slip against the displacement)
//
// where g is the clearance of the node: how far its two faces are apart before anything is loaded, negative where they
// would overlap; zero on ideal faces. Units are those of ``elastic/model.py``.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "model.hpp"
#include "twists.hpp"
#include "vectors.hpp"

namespace holdfast {

// Let sheet p, which has no friction and the stiffness D, bond each of its bodies to the world along its plane, not to
// each other.
//
// Bonds are what drag stands for: along ice no body drags another, so none is taken along by what slides off below it.
inline void drag_on_world(const Elastic& m, Int p, Mat D, Vec still) {
    for (int side = 0; side < 2; ++side) {
        const Int body = side == 0 ? m.a[p] : m.b[p];
        if (body < 0) continue;
        const auto arm = side == 0 ? m.arm_a[p] : m.arm_b[p];
        for (int i = 0; i < 3; ++i) {
            still[6 * body + i] += D(1, 1);
            still[6 * body + 3 + i] += D(3, 3) + D(1, 1) * (arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]);
        }
    }
    for (int i = 0; i < 6; ++i) {
        for (int j = 1; j < 4; ++j) D(i, j) = D(j, i) = 0.0;
    }
}

// Fill ``bonded``: the sum over nodes of Bᵀ diag(k, ρk, ρk) B with all of them stuck; and ``still``
inline void bond(const Elastic& m, Ten bonded, Vec still) {
    still.fill(0.0);
    for (Int p = 0; p < m.a.size(); ++p) {
        const auto D = bonded[p];
        D.fill(0.0);
        for (Int i = m.first[p]; i < m.first[p + 1]; ++i) {
            const double x = m.x[i], y = m.y[i], k = m.k[i], t = m.rho * k;
            D(0, 0) += k;
            D(0, 4) += k * y;
            D(0, 5) -= k * x;
            D(4, 4) += k * y * y;
            D(4, 5) -= k * x * y;
            D(5, 5) += k * x * x;
            D(1, 1) += t;
            D(1, 3) -= t * y;
            D(2, 2) += t;
            D(2, 3) += t * x;
            D(3, 3) += t * (x * x + y * y);
        }
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < i; ++j) D(i, j) = D(j, i);
        }
        if (m.mu[p] == 0) drag_on_world(m, p, D, still);
    }
}

// The most that a node of this run can be pressed under the sheet's twist ``v`` (6,).
//
// It is rounded as what a node is pressed, and rounding keeps the order: where it is not positive, no node presses.
inline double nearest(const Runs& runs, Int run, In v, double weight) {
    const double* box = &runs.box(run, 0);
    const double x = v[5] > 0 ? box[1] : box[0], y = v[4] > 0 ? box[2] : box[3];
    return x * v[5] - y * v[4] - v[0] - weight * box[4];
}

// r (6J,) = weight · wrench + G f(Gᵀ q) - hold q, and K (P, 6, 6): minus the derivative of each sheet's wrench.
//
// Clearances are multiplied by ``weight``, too: loads beside which no weight counts make all clearances small.
// ``v``, ``F`` (6,) are scratch. Returns a number that tells which nodes are open, stuck or sliding.
inline Int evaluate(const Elastic& m, double weight, In q, Vec r, Ten K, Vec v, Vec F) {
    scale(r, weight, m.wrench);
    for (Int i = 0; i < r.size(); ++i) r[i] -= m.hold[i] * q[i];
    Int states = 0;
    const double rho = m.rho;
    const double *xs = m.x.data(), *ys = m.y.data(), *ks = m.k.data(), *gaps = m.apart.data();
    const Int *begins = m.runs.first.data(), *nodes = m.runs.node.data();
    for (Int p = 0; p < m.a.size(); ++p) {
        sheet_twist(m, p, q, v);
        const double v0 = v[0], v1 = v[1], v2 = v[2], v3 = v[3], v4 = v[4], v5 = v[5];
        const double mu = m.mu[p], slippery = (mu / rho) * (mu / rho);
        double fn = 0.0, f1 = 0.0, f2 = 0.0, gn = 0.0, g1 = 0.0, g2 = 0.0;
        double nn = 0.0, ny = 0.0, nx = 0.0, nyy = 0.0, nxy = 0.0, nxx = 0.0;  // normal by normal
        double sk = 0.0, sx = 0.0, sy = 0.0, sr = 0.0;  // of nodes that stick: Σ k, Σ k x, Σ k y and Σ k (x² + y²)
        // Tangential by tangential, of nodes that slide
        double t11 = 0.0, t12 = 0.0, t1w = 0.0, t22 = 0.0, t2w = 0.0, tww = 0.0;
        // Tangential by normal
        double c1 = 0.0, c1y = 0.0, c1x = 0.0, c2 = 0.0, c2y = 0.0, c2x = 0.0, cw = 0.0, cwy = 0.0, cwx = 0.0;
        for (Int run = begins[p]; run < begins[p + 1]; ++run) {
            if (nearest(m.runs, run, v, weight) <= 0.0) continue;
            for (Int i = nodes[run]; i < nodes[run + 1]; ++i) {
                const double x = xs[i], y = ys[i], k = ks[i];
                const double pressed = x * v5 - y * v4 - v0 - weight * gaps[i];
                if (pressed <= 0.0) continue;
                const double kx = k * x, ky = k * y, kxx = kx * x, kyy = ky * y;
                nn += k;
                ny += ky;
                nx -= kx;
                nyy += kyy;
                nxy -= ky * x;
                nxx += kxx;
                const double normal = k * pressed;
                fn += normal;
                g1 += y * normal;
                g2 -= x * normal;
                if (mu <= 0.0) continue;  // no friction: nothing sticks, not even where nothing has moved yet
                const double u1 = v1 - y * v3, u2 = v2 + x * v3, square = u1 * u1 + u2 * u2;
                if (square <= slippery * pressed * pressed) {
                    sk += k;
                    sx += kx;
                    sy += ky;
                    sr += kxx + kyy;
                    states += i + 1;
                    continue;
                }
                const double inverse = 1 / std::sqrt(square), e1 = u1 * inverse, e2 = u2 * inverse;
                const double s1 = -mu * normal * e1, s2 = -mu * normal * e2, h = mu * normal * inverse;
                const double d11 = h * e2 * e2, d12 = -h * e1 * e2, d22 = h * e1 * e1;
                t11 += d11;
                t12 += d12;
                t1w += x * d12 - y * d11;
                t22 += d22;
                t2w += x * d22 - y * d12;
                tww += y * y * d11 - 2 * x * y * d12 + x * x * d22;
                const double b1 = -mu * k * e1, b2 = -mu * k * e2;  // less friction where the contact lifts
                const double bw = x * b2 - y * b1;
                c1 += b1;
                c1y += b1 * y;
                c1x -= b1 * x;
                c2 += b2;
                c2y += b2 * y;
                c2x -= b2 * x;
                cw += bw;
                cwy += bw * y;
                cwx -= bw * x;
                states += (i + 1) * 7919;
                f1 += s1;
                f2 += s2;
                gn += x * s2 - y * s1;
            }
        }
        f1 -= rho * (sk * v1 - sy * v3);
        f2 -= rho * (sk * v2 + sx * v3);
        gn -= rho * (sx * v2 - sy * v1 + sr * v3);
        t11 += rho * sk;
        t1w -= rho * sy;
        t22 += rho * sk;
        t2w += rho * sx;
        tww += rho * sr;
        const double wrench[6] = {fn, f1, f2, gn, g1, g2};
        const double D[6][6] = {{nn, 0.0, 0.0, 0.0, ny, nx},   {c1, t11, t12, t1w, c1y, c1x},
                                {c2, t12, t22, t2w, c2y, c2x}, {cw, t1w, t2w, tww, cwy, cwx},
                                {ny, 0.0, 0.0, 0.0, nyy, nxy}, {nx, 0.0, 0.0, 0.0, nxy, nxx}};
        std::copy_n(wrench, 6, F.data());
        for (int i = 0; i < 6; ++i) std::copy_n(D[i], 6, &K(p, i, 0));
        add_wrench(m, p, F, 1.0, r);
    }
    return states;
}

// ``f`` (I, 3) = (f_n, f_t1, f_t2) on body b at every node, in total weights
inline void node_forces(const Elastic& m, In q, Mat f) {
    std::array<double, 6> twist;
    const Vec v(twist.data(), {6});
    for (Int p = 0; p < m.a.size(); ++p) {
        sheet_twist(m, p, q, v);
        for (Int i = m.first[p]; i < m.first[p + 1]; ++i) {
            const double x = m.x[i], y = m.y[i], k = m.k[i];
            const double normal = k * std::max(0.0, x * v[5] - y * v[4] - v[0] - m.apart[i]);
            const double u1 = v[1] - y * v[3], u2 = v[2] + x * v[3];
            const double wanted = m.rho * k * std::sqrt(u1 * u1 + u2 * u2);
            double share = m.rho * k;
            if (wanted > m.mu[p] * normal) share *= m.mu[p] * normal / wanted;
            f(i, 0) = normal;
            f(i, 1) = -share * u1;
            f(i, 2) = -share * u2;
        }
    }
}

// How far a ``body`` would have moved if every contact stuck, as ``slid`` has it; 0 if it is fixed
inline double given(InMat stuck, double s, Int body) {
    if (body < 0) return 0.0;
    double wrench = 0.0, load = 0.0;
    for (Int i = 6 * body; i < 6 * body + 6; ++i) {
        wrench += stuck(0, i) * stuck(0, i);
        load += stuck(1, i) * stuck(1, i);
    }
    return std::sqrt(wrench) + std::abs(s) * std::sqrt(load);
}

// How far the contacts of a body have slid at q (n,) since ``rest`` (n,), over what gives there; the most of all.
//
// A node slides by how far it was moved along its faces beyond what friction springs back. What gives there is what
// one of its bodies would have moved if every contact stuck, the softer one: ``stuck`` (2, n) are those displacements
// under the wrench, and under the load, of which there is s times as much. The mean over the nodes of a body is
// weighted by what they press. ``v``, ``w`` (6,) and ``sums`` (n,) are scratch.
inline double slid(const Elastic& m, In rest, In q, InMat stuck, double s, Vec v, Vec w, Vec sums) {
    sums.fill(0.0);
    const auto sideways = [](In twist, double x, double y) {
        const double u1 = twist[1] - y * twist[3], u2 = twist[2] + x * twist[3];
        return std::sqrt(u1 * u1 + u2 * u2);
    };
    for (Int p = 0; p < m.a.size(); ++p) {
        sheet_twist(m, p, q, v);
        sheet_twist(m, p, rest, w);
        const double springs = m.mu[p] / m.rho;
        double far = 0.0, normal = 0.0;
        for (Int i = m.first[p]; i < m.first[p + 1]; ++i) {
            const double x = m.x[i], y = m.y[i], apart = m.apart[i];
            const double pressed = x * v[5] - y * v[4] - v[0] - apart;
            if (pressed <= 0.0) continue;
            normal += m.k[i] * pressed;
            const double before = springs * std::max(0.0, x * w[5] - y * w[4] - w[0] - apart);
            const double beyond = std::max(0.0, sideways(v, x, y) - springs * pressed);
            const double beyond0 = std::max(0.0, sideways(w, x, y) - before);
            far += m.k[i] * pressed * std::abs(beyond - beyond0);
        }
        const double give = std::max(std::max(given(stuck, s, m.a[p]), given(stuck, s, m.b[p])), 1e-300);
        for (const Int body : {m.a[p], m.b[p]}) {
            if (body < 0) continue;
            sums[6 * body] += springs > 0.0 ? far / give : 0.0;
            sums[6 * body + 1] += normal;
        }
    }
    double most = 0.0;
    for (Int j = 0; j < q.size(); j += 6) {
        if (sums[j + 1] > 0.0) most = std::max(most, sums[j] / sums[j + 1]);
    }
    return most;
}

// The smallest h > 0 at which a node of q + h t begins or ceases to press or to slide; inf if none does
inline double next_change(const Elastic& m, In q, In t) {
    constexpr double INF = std::numeric_limits<double>::infinity();
    double first = INF;
    std::array<double, 12> twists;
    const Vec v(twists.data(), {6}), d(twists.data() + 6, {6});
    for (Int p = 0; p < m.a.size(); ++p) {
        sheet_twist(m, p, q, v);
        sheet_twist(m, p, t, d);
        const double mu = m.mu[p], rho = m.rho;
        for (Int i = m.first[p]; i < m.first[p + 1]; ++i) {
            const double x = m.x[i], y = m.y[i];
            const double n = x * v[5] - y * v[4] - v[0] - m.apart[i], dn = x * d[5] - y * d[4] - d[0];
            if (n * dn < 0) first = std::min(first, -n / dn);
            if (n <= 0 || mu <= 0) continue;
            const double u1 = v[1] - y * v[3], u2 = v[2] + x * v[3], d1 = d[1] - y * d[3], d2 = d[2] + x * d[3];
            // ρ² |u + h d|² = μ² (n + h dn)²
            const double A = rho * rho * (d1 * d1 + d2 * d2) - mu * mu * dn * dn;
            const double B = rho * rho * (u1 * d1 + u2 * d2) - mu * mu * n * dn;
            const double C = rho * rho * (u1 * u1 + u2 * u2) - mu * mu * n * n;
            const double inside = B * B - A * C;
            if (inside < 0) continue;
            const double root = B >= 0 ? -(B + std::sqrt(inside)) : std::sqrt(inside) - B;
            for (const double h : {A != 0 ? root / A : INF, root != 0 ? C / root : INF}) {
                if (h > 0 && n + h * dn > 0) first = std::min(first, h);
            }
        }
    }
    return first;
}

}  // namespace holdfast
