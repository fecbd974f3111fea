// Upper bounds of the gauge of a convex set from known points, by small linear programs, thousands in a second.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr int MOST_PIVOTS = 400;  // of one program; the bound is valid whenever it stops, as every step is feasible
constexpr double SLIGHT = 1e-9;   // a point that violates a facet by less does not count

// The simplex tableau of one program: the basis, by numbers of known points, and the shares of these
struct Tableau {
    Array<double, 2> inverse;
    std::vector<double> share, column, missing;
    std::vector<Int> basis;

    explicit Tableau(Int size)
        : inverse({size, size}),
          share(static_cast<std::size_t>(size)),
          column(share.size()),
          missing(share.size()),
          basis(share.size()) {}
};

// Replace the basis point whose share becomes zero first by the entering one; return false if none does
inline bool exchanged(Tableau& now, In entering, Int number) {
    const Int size = entering.size();
    const Mat inverse = now.inverse.view();
    auto& [all, share, column, missing, basis] = now;
    double largest = 0.0;
    for (Int k = 0; k < size; ++k) {
        column[k] = 0.0;
        for (Int c = 0; c < size; ++c) column[k] += inverse(k, c) * entering[c];
        largest = std::max(largest, std::abs(column[k]));
    }
    Int leaves = -1;
    double step = std::numeric_limits<double>::infinity();
    for (Int k = 0; k < size; ++k) {
        if (column[k] > 1e-11 * largest) {
            const double ratio = std::max(share[k], 0.0) / column[k];
            if (ratio < step || (ratio == step && leaves >= 0 && column[k] > column[leaves])) {
                leaves = k;
                step = ratio;
            }
        }
    }
    if (leaves < 0) return false;
    for (Int c = 0; c < size; ++c) inverse(leaves, c) /= column[leaves];
    for (Int k = 0; k < size; ++k) {
        if (k == leaves) continue;
        share[k] -= step * column[k];
        for (Int c = 0; c < size; ++c) inverse(k, c) -= column[k] * inverse(leaves, c);
    }
    share[leaves] = step;
    basis[leaves] = number;
    return true;
}

// The price of a point: of its shares of the basis, refined once and not negative, and of the remainder.
// ``rounding`` is the relative error of such sums.
inline double paid(Tableau& now, InMat known, In price, In point, InMat unit_price, double rounding) {
    const Int size = point.size();
    const InMat inverse = now.inverse.view();
    auto& [all, share, column, missing, basis] = now;
    for (Int c = 0; c < size; ++c) {
        share[c] = 0.0;
        missing[c] = point[c];
    }
    for (int pass = 0; pass < 2; ++pass) {
        for (Int k = 0; k < size; ++k) {
            for (Int c = 0; c < size; ++c) share[k] += inverse(k, c) * missing[c];
            share[k] = std::max(share[k], 0.0);
        }
        for (Int c = 0; c < size; ++c) {
            missing[c] = point[c];
            for (Int k = 0; k < size; ++k) missing[c] -= share[k] * known(basis[k], c);
        }
    }
    double total = 0.0;
    for (Int k = 0; k < size; ++k) total += share[k] * price[basis[k]];
    for (Int c = 0; c < size; ++c) {
        double terms = std::abs(point[c]);
        for (Int k = 0; k < size; ++k) terms += share[k] * std::abs(known(basis[k], c));
        total += std::max(missing[c], 0.0) * unit_price(0, c) + std::max(-missing[c], 0.0) * unit_price(1, c);
        total += rounding * terms * std::max(unit_price(0, c), unit_price(1, c));
    }
    return total * (1.0 + rounding);
}

// Upper bounds (n,) of a gauge γ at ``points`` (n, d), and the facets (n, d) that give them.
//
// A gauge is convex and positively homogeneous. So γ(Σ λ x) <= Σ λ γ(x) for every combination of the ``known`` points
// (m, d) with λ >= 0, and γ of each known point is at most its ``price`` (m,): 1 for a point on the boundary of the
// set, 0 for a direction in which the set is unbounded. The first 2 d known points are along the positive and then the
// negative axes; a remainder that a combination does not reach is paid for along these. The simplex method finds the
// least Σ λ price. It begins with the points along the axes and enters the most violated point (Dantzig's rule).
//
// A facet is the dual solution y of that program: y·x <= price at all known points, and y·point is the bound, up to
// rounding. Where the bound is differentiable, y is its derivative by the point. ``rounding`` is the relative error of
// sums, by which the bounds are widened.
inline std::pair<Array<double>, Array<double, 2>> hull_gauge(InMat known, In price, InMat points, double rounding) {
    const Int count = points.size(0), size = points.size(1), total = known.size();
    Array<double> bounds({count});
    Array<double, 2> facets({count, size});
    Array<double, 2> one_unit({2, size});  // price along each axis, in the positive and the negative direction
    const Mat unit_price = one_unit.view();
    for (Int k = 0; k < size; ++k) {
        unit_price(0, k) = price[k] / known(k, k);
        unit_price(1, k) = -price[size + k] / known(size + k, k);
    }
    Tableau now(size);
    const Mat inverse = now.inverse.view();
    for (Int i = 0; i < count; ++i) {
        inverse.fill(0.0);
        for (Int k = 0; k < size; ++k) {
            now.basis[k] = points(i, k) >= 0.0 ? k : size + k;
            inverse(k, k) = 1.0 / known(now.basis[k], k);
            now.share[k] = points(i, k) * inverse(k, k);
        }
        const Vec facet = facets.view()[i];
        for (int pivot = 0; pivot < MOST_PIVOTS; ++pivot) {
            for (Int c = 0; c < size; ++c) {
                facet[c] = 0.0;
                for (Int k = 0; k < size; ++k) facet[c] += price[now.basis[k]] * inverse(k, c);
            }
            Int enters = -1;
            double most = SLIGHT;
            for (Int j = 0; j < total; ++j) {
                double missed = -price[j];
                for (Int c = 0; c < size; ++c) missed += facet[c] * known(j, c);
                if (missed > most) {
                    enters = j;
                    most = missed;
                }
            }
            if (enters < 0 || !exchanged(now, known[enters], enters)) break;
        }
        bounds.numbers[i] = paid(now, known, price, points[i], unit_price, rounding);
    }
    return {std::move(bounds), std::move(facets)};
}

}  // namespace holdfast
