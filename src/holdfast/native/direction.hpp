// The direction of a load path at a point: which way is onwards, and what directions tell of other branches.

#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "linear.hpp"

namespace holdfast {

constexpr double STRAIGHT = 0.9999;  // cosine of the angle between two directions up to which a path went straight on

// The squared motion of the body that moves most along the direction that was found, and that of all together
inline std::pair<double, double> squares(const Work& work) {
    double best = 0.0, whole = 0.0;
    for (Int j = 0; j < (work.rhs.size() - 1) / 6; ++j) {
        double total = 0.0;
        for (Int i = 6 * j; i < 6 * j + 6; ++i) total += work.rhs(i, 1) * work.rhs(i, 1);
        best = std::max(best, total);
        whole += total;
    }
    return {best, whole};
}

// What the direction that was found is multiplied by so that it leads onwards, and the body that moves most moves by
// one; ``best`` as ``squares`` has it.
//
// Onwards is where s rises while the stiffness has the sign of determinant it had at rest, and falls while it has the
// other: the ``sign`` of the bordered determinant tells, whatever the border.
inline double onwards(double sign, double orientation, double best) {
    return orientation * sign / std::max(std::sqrt(best), 1e-300);
}

// Point ``tangent`` (n,) onwards along the path, scale it, set work.c to its plane; returns ds/dℓ.
//
// The plane is across the motion of all bodies: across that of a single one more paths turn back.
inline double turn(Work& work, double sign, double orientation, Vec tangent) {
    const Int n = tangent.size();
    const auto [best, whole] = squares(work);
    const double size = onwards(sign, orientation, best);
    for (Int i = 0; i < n; ++i) {
        tangent[i] = size * work.rhs(i, 1);
        work.c[i] = tangent[i] * best / std::max(whole, 1e-300);
    }
    return size * work.rhs(n, 1);
}

// Whether the path goes on at the point found as it came, along ``tangent`` (n,)
inline bool straight(const Work& work, In tangent) {
    double along = 0.0, here = 0.0, before = 0.0;
    for (Int i = 0; i < tangent.size(); ++i) {
        along += work.rhs(i, 1) * tangent[i];
        here += work.rhs(i, 1) * work.rhs(i, 1);
        before += tangent[i] * tangent[i];
    }
    return along > STRAIGHT * std::sqrt(here * before);
}

// Whether the step from q to ``trial`` ends farther than ``most`` of it from where both ends' directions lead.
//
// Then a nearer solution may lie on the path, and this one on another branch.
inline bool torn(const Work& work, double sign, double orientation, In q, In tangent, In trial, double step,
                 double most) {
    const double size = onwards(sign, orientation, squares(work).first);
    double away = 0.0, far = 0.0;
    for (Int i = 0; i < q.size(); ++i) {
        const double moved = trial[i] - q[i], there = size * work.rhs(i, 1);
        away = std::max(away, std::abs(moved - 0.5 * step * (tangent[i] + there)));
        far = std::max(far, std::abs(moved));
    }
    return away > most * far;
}

}  // namespace holdfast
