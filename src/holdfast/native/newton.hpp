// One point of a path: semi-smooth Newton with line search on the bordered system.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "breath.hpp"
#include "fronts.hpp"
#include "law.hpp"
#include "linear.hpp"
#include "model.hpp"
#include "twists.hpp"
#include "vectors.hpp"

namespace holdfast {

constexpr int HALVINGS = 8;  // largest number of times that a Newton step is halved in search of a smaller unbalance
constexpr double SHORTEST = 0.1;  // share of a Newton step below which a point of a path is given up, where each point
                                  // is expensive
// Of a sum over its largest term, measured on bodies that have drifted far: 5e-17
constexpr double ROUNDING = 0.25 * std::numeric_limits<double>::epsilon();

// Which unbalance is to vanish: r(q, s) = weight · wrench + contact forces + s w - ε D (q - anchor).
//
// ``weight`` scales the model's wrench; ``drag`` is ε; ``corner`` is d of the bordered system (linear.hpp): 0 on a
// path, 1 where s shall stay as it is; ``anchor`` (n,) is the displacement without drag. On a path all of the weight
// acts, without drag.
struct Balance {
    double weight, drag, corner;
    In anchor;
    static constexpr auto fields = std::tuple{&Balance::weight, &Balance::drag, &Balance::corner, &Balance::anchor};
};

// How Newton's method ended.
//
// ``converged``; ``s`` with which it ended; the ``steps`` taken; ``systems`` solved; ``states``: a number that tells
// which nodes are open, stuck or sliding; ``sign`` of the determinant of the last system, 0 (SINGULAR) if there was
// none.
struct Iteration {
    bool converged;
    double s;
    Int steps, systems, states;
    double sign;
};

// Set a column of right-hand sides, but for its last number, to a
inline void set_column(Mat rhs, int column, In a) {
    for (Int i = 0; i < a.size(); ++i) rhs(i, column) = a[i];
}

// Set ``into`` to a column of solutions, but for its last number
inline void get_column(InMat rhs, int column, Vec into) {
    for (Int i = 0; i < into.size(); ++i) into[i] = rhs(i, column);
}

// work.r -= ε D (q - anchor): the drag of bonded contacts, and on the world
inline void add_drag(const Elastic& m, Work& work, double drag, In q, In anchor) {
    for (Int p = 0; p < m.a.size(); ++p) {
        sheet_twist(m, p, q, work.v);
        sheet_twist(m, p, anchor, work.F);
        for (int i = 0; i < 6; ++i) work.v[i] -= work.F[i];
        for (int i = 0; i < 6; ++i) {
            double total = 0.0;
            for (int j = 0; j < 6; ++j) total += m.bonded(p, i, j) * work.v[j];
            work.F[i] = total;
        }
        add_wrench(m, p, work.F, -drag, work.r);
    }
    for (Int i = 0; i < q.size(); ++i) work.r[i] -= drag * m.still[i] * (q[i] - anchor[i]);
}

// Set work.r (n,) to the unbalance at (q, s), work.K to the stiffness there; returns the states of the nodes
inline Int unbalance(const Elastic& m, Work& work, const Balance& balance, In q, double s) {
    const Int states = evaluate(m, balance.weight, q, work.r, work.K, work.v, work.F);
    if (balance.drag > 0) add_drag(m, work, balance.drag, q, balance.anchor);
    for (Int i = 0; i < work.r.size(); ++i) work.r[i] += s * work.w[i];
    return states;
}

// The largest component of r, each body's in units of its own weight and size
inline double worst(const Elastic& m, In r) {
    double top = 0.0;
    for (Int i = 0; i < r.size(); ++i) top = std::max(top, std::abs(m.scale[i] * r[i]));
    return top;
}

// What rounding alone leaves of the balance at q, in the units of ``worst``: forces come from differences
inline double rounding(const Elastic& m, In q) {
    double top = 0.0;
    for (Int p = 0; p < m.a.size(); ++p) {
        double far = 0.0, scale = 0.0, stiff = 0.0;
        for (const Int body : {m.a[p], m.b[p]}) {
            if (body < 0) continue;
            for (Int i = 6 * body; i < 6 * body + 6; ++i) {
                far = std::max(far, std::abs(q[i]));
                scale = std::max(scale, m.scale[i]);
            }
        }
        for (int i = 0; i < 6; ++i) stiff = std::max(stiff, m.bonded(p, i, i));
        top = std::max(top, far * scale * stiff);
    }
    return ROUNDING * top;
}

// The sum of squares of the components of r, each body's in units of its own weight and size
inline double squared(const Elastic& m, In r) {
    double total = 0.0;
    for (Int i = 0; i < r.size(); ++i) {
        const double one = m.scale[i] * r[i];
        total += one * one;
    }
    return total;
}

// Set the right-hand sides to the unbalance, ``off`` the plane, and to a unit of length along the path
inline void set_sides(Work& work, double off) {
    const Int n = work.r.size();
    for (Int i = 0; i < n; ++i) {
        work.rhs(i, 0) = work.r[i];
        work.rhs(i, 1) = 0.0;
    }
    work.rhs(n, 0) = off;
    work.rhs(n, 1) = 1.0;
}

// Improve q (in place) and s until the unbalance is below ``tolerance`` on the plane c·q = ``level``.
//
// It gives up after ``most`` steps, or where less than the share ``least`` of one brings an improvement.
// After success work.rhs[:, 1] is the direction (dq, ds) of the path, dℓ = c·dq = 1, and ``sign`` belongs to it: from
// the system of the last whole step if no node changed its state in that. What such a step leaves of the unbalance is
// of the order of its length times what it changes in the stiffness, and that is below ``tolerance``.
inline Iteration newton(const Elastic& m, Work& work, const Balance& balance, Vec q, double s, double level,
                        double tolerance, Int most, double least, const Fronts* fronts, Breath& breath) {
    const Int n = q.size();
    Int states = unbalance(m, work, balance, q, s), slow = 0;
    double before = std::numeric_limits<double>::infinity(), sign = SINGULAR;
    bool same = false;
    for (Int step = 0;; ++step) {
        breath.take();
        const double error = worst(m, work.r);
        const bool done = error <= tolerance;
        if (done && same) return {true, s, step, step, states, sign};
        set_sides(work, level - dot(work.c, q));
        slow = error > 0.5 * before ? slow + 1 : 0;
        before = error;
        if (!std::isfinite(error) || (!done && (step >= most || slow > std::max<Int>(3, most / 4)))) {
            return {false, s, step, step, states, sign};
        }
        sign = solve(m, work, balance.drag, balance.corner, fronts);
        if (done || sign == SINGULAR) return {sign != SINGULAR, s, step, step + 1, states, sign};
        const Int last = states;
        const double base = squared(m, work.r);
        double share = 1.0;
        for (int halving = 0; halving < HALVINGS; ++halving) {
            for (Int i = 0; i < n; ++i) work.trial[i] = q[i] + share * work.rhs(i, 0);
            states = unbalance(m, work, balance, work.trial, s + share * work.rhs(n, 0));
            if (squared(m, work.r) <= (1 - 0.01 * share) * base || worst(m, work.r) <= tolerance) break;
            share *= 0.5;
            if (share < least) return {false, s, step, step + 1, states, sign};
        }
        put(q, work.trial);
        s += share * work.rhs(n, 0);
        same = share == 1.0 && states == last;
    }
}

}  // namespace holdfast
