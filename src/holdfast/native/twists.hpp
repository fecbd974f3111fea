// Twists, wrenches and stiffness of sheets, along the axes and about the centres of the bodies that they lie between.
//
// A body's twist is (u, ω), along axes that all bodies share and about its centre. At a sheet whose origin is an
// ``arm`` p away from that centre, and whose axes are the rows of R, its twist is
//
//     T (u, ω) = (R (u + ω x p), R ω)
//
// A product with the 6x6 matrix T takes three times as many multiplications as a turn by R and a shift by p.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "dense.hpp"
#include "model.hpp"

namespace holdfast {

// Fill ``unit`` from ``bonded`` and ``still``, or from ``hold`` where that is more: 1 where nothing resists
inline void set_units(const Elastic& m, Vec unit) {
    for (Int i = 0; i < unit.size(); ++i) unit[i] = m.still[i];
    for (Int p = 0; p < m.a.size(); ++p) {
        const auto R = m.axes[p], D = m.bonded[p];
        for (int side = 0; side < 2; ++side) {
            const Int body = side == 0 ? m.a[p] : m.b[p];
            if (body < 0) continue;
            const auto arm = side == 0 ? m.arm_a[p] : m.arm_b[p];
            for (int k = 0; k < 3; ++k) {
                const int one = (k + 1) % 3, two = (k + 2) % 3;
                for (int i = 0; i < 3; ++i) {
                    const double v =
                        arm[one] * R(i, two) - arm[two] * R(i, one);  // of a turn about axis k, along row i
                    for (int j = 0; j < 3; ++j) {
                        const double w = arm[one] * R(j, two) - arm[two] * R(j, one);
                        unit[6 * body + k] += R(i, k) * D(i, j) * R(j, k);
                        unit[6 * body + 3 + k] += v * D(i, j) * w + 2 * v * D(i, 3 + j) * R(j, k);
                        unit[6 * body + 3 + k] += R(i, k) * D(3 + i, 3 + j) * R(j, k);
                    }
                }
            }
        }
    }
    for (Int i = 0; i < unit.size(); ++i) {
        const double most = std::max(unit[i], m.hold[i]);  // a ball turns on its point, and the hold alone resists
        unit[i] = most > 0 ? 1 / std::sqrt(most) : 1.0;
    }
}

// Write into ``v`` (6,) the twist of sheet p's body b against its body a, under ``q`` (6J,)
inline void sheet_twist(const Elastic& m, Int p, In q, Vec v) {
    double u0 = 0.0, u1 = 0.0, u2 = 0.0, w0 = 0.0, w1 = 0.0, w2 = 0.0;
    for (int side = 0; side < 2; ++side) {
        const Int body = side == 0 ? m.b[p] : m.a[p];
        if (body < 0) continue;
        const double sign = side == 0 ? 1.0 : -1.0;
        const double *arm = &(side == 0 ? m.arm_b : m.arm_a)(p, 0), *own = &q[6 * body];
        const double x = sign * own[3], y = sign * own[4], z = sign * own[5];
        u0 += sign * own[0] + y * arm[2] - z * arm[1];
        u1 += sign * own[1] + z * arm[0] - x * arm[2];
        u2 += sign * own[2] + x * arm[1] - y * arm[0];
        w0 += x;
        w1 += y;
        w2 += z;
    }
    const auto R = m.axes[p];
    for (int i = 0; i < 3; ++i) {
        v[i] = R(i, 0) * u0 + R(i, 1) * u1 + R(i, 2) * u2;
        v[i + 3] = R(i, 0) * w0 + R(i, 1) * w1 + R(i, 2) * w2;
    }
}

// Add to ``r`` (6J,) ``factor`` times sheet p's wrench ``F`` (6,) on body b, and its opposite on body a
inline void add_wrench(const Elastic& m, Int p, In F, double factor, Vec r) {
    const auto R = m.axes[p];
    const double f0 = factor * (R(0, 0) * F[0] + R(1, 0) * F[1] + R(2, 0) * F[2]);
    const double f1 = factor * (R(0, 1) * F[0] + R(1, 1) * F[1] + R(2, 1) * F[2]);
    const double f2 = factor * (R(0, 2) * F[0] + R(1, 2) * F[1] + R(2, 2) * F[2]);
    const double t0 = factor * (R(0, 0) * F[3] + R(1, 0) * F[4] + R(2, 0) * F[5]);
    const double t1 = factor * (R(0, 1) * F[3] + R(1, 1) * F[4] + R(2, 1) * F[5]);
    const double t2 = factor * (R(0, 2) * F[3] + R(1, 2) * F[4] + R(2, 2) * F[5]);
    for (int side = 0; side < 2; ++side) {
        const Int body = side == 0 ? m.b[p] : m.a[p];
        if (body < 0) continue;
        const double sign = side == 0 ? 1.0 : -1.0;
        const double* arm = &(side == 0 ? m.arm_b : m.arm_a)(p, 0);
        double* own = &r[6 * body];
        own[0] += sign * f0;
        own[1] += sign * f1;
        own[2] += sign * f2;
        own[3] += sign * (t0 + arm[1] * f2 - arm[2] * f1);
        own[4] += sign * (t1 + arm[2] * f0 - arm[0] * f2);
        own[5] += sign * (t2 + arm[0] * f1 - arm[1] * f0);
    }
}

// Add [Tb, -Ta]ᵀ (K + ``drag`` · bonded) [Tb, -Ta] of sheet p to a matrix ``A``.
//
// The rows and columns of its bodies begin at ``at_a`` and ``at_b`` there, negative for a fixed one, and are multiplied
// by ``unit``: turns and shifts of small bodies have stiffnesses of other orders.
inline void add_stiffness(const Elastic& m, Int p, InTen K, double drag, Int at_a, Int at_b, Mat A) {
    std::array<double, 36> X;
    std::array<double, 9> R;
    for (int i = 0; i < 6; ++i) {
        const double *own = &K(p, i, 0), *bonded = &m.bonded(p, i, 0);
        for (int j = 0; j < 6; ++j) X[6 * i + j] = own[j] + drag * bonded[j];
    }
    for (int i = 0; i < 3; ++i) std::copy_n(&m.axes(p, i, 0), 3, &R[3 * i]);
    const auto side = [&](Int at, Int body, InMat arm) {
        return dense::Side{at, &arm(p, 0), at < 0 ? nullptr : &m.unit[6 * body]};
    };
    dense::add_turned(X.data(), R.data(), side(at_a, m.a[p], m.arm_a), side(at_b, m.b[p], m.arm_b), A.data(),
                      A.steps()[0]);
}

}  // namespace holdfast
