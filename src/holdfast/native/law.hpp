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
#include <vector>

#include "model.hpp"
#include "pressing.hpp"
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

// The most that a node of this run can be pressed under the sheet's twist ``v`` (6,), as pressing.hpp has it
inline double nearest(const Runs& runs, Int run, In v, double weight) {
    return nearest(&runs.box(run, 0), v.data(), weight);
}

// r (6J,) = weight · wrench + G f(Gᵀ q) - hold q, and K (P, 6, 6): minus the derivative of each sheet's wrench.
//
// Clearances are multiplied by ``weight``, too: loads beside which no weight counts make all clearances small.
// ``v``, ``F`` (6,) are scratch. Returns a number that tells which nodes are open, stuck or sliding.
inline Int evaluate(const Elastic& m, double weight, In q, Vec r, Ten K, Vec v, Vec F) {
    scale(r, weight, m.wrench);
    for (Int i = 0; i < r.size(); ++i) r[i] -= m.hold[i] * q[i];
    Int states = 0;
    const Pressing nodes{m.x.data(),         m.y.data(),        m.k.data(),           m.apart.data(),
                         m.runs.node.data(), m.runs.box.data(), m.runs.box.steps()[0]};
    for (Int p = 0; p < m.a.size(); ++p) {
        sheet_twist(m, p, q, v);
        states += press(nodes, m.runs.first[p], m.runs.first[p + 1], v.data(), weight, m.mu[p], m.rho, F.data(),
                        &K(p, 0, 0), K.steps()[1]);
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

// The clearances (I,) of nodes at displacements ``q`` (6J,), wider than they are pressed where two bodies just touch:
// where the force of springs that pull, too, is nothing but ``rounding``, as a share of the largest on each of both
inline Array<double> without_touching(const Elastic& m, In q, double rounding) {
    std::array<double, 6> twist;
    const Vec v(twist.data(), {6});
    Array<double> apart({m.k.size()});
    std::vector<double> pressed(apart.numbers.size()), largest(m.scale.size() / 6);
    for (Int p = 0; p < m.a.size(); ++p) {
        sheet_twist(m, p, q, v);
        double most = 0.0;
        for (Int i = m.first[p]; i < m.first[p + 1]; ++i) {
            pressed[i] = m.x[i] * v[5] - m.y[i] * v[4] - v[0] - m.apart[i];
            most = std::max(most, m.k[i] * pressed[i]);
        }
        for (const Int body : {m.a[p], m.b[p]}) {
            if (body >= 0) largest[body] = std::max(largest[body], most);
        }
    }
    for (Int p = 0; p < m.a.size(); ++p) {
        double least = std::numeric_limits<double>::infinity();
        for (const Int body : {m.a[p], m.b[p]}) {
            if (body >= 0) least = std::min(least, largest[body]);
        }
        for (Int i = m.first[p]; i < m.first[p + 1]; ++i) {
            const double off = std::abs(pressed[i]);
            apart.numbers[i] = m.apart[i] + (m.k[i] * off <= rounding * least ? 2 * off + 1 : 0.0);
        }
    }
    return apart;
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
