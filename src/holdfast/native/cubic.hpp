// The cubic between two points of a load path: how high or low the load was between, as far as slopes tell.
//
// It leads from (0, ``start``) to (1, ``end``) with slopes ``a`` and ``b`` there, per unit of that share of the step.

#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

namespace holdfast {

constexpr double ONCE = 0.1;      // share of the step within which a bend counts as lying at one of its ends
constexpr double NOWHERE = -1.0;  // the place of an extremum that the cubic does not have between its ends

// Its height at x
inline double cubic(double x, double start, double a, double end, double b) {
    const double rise = end - start;
    return start + x * (a + x * (3 * rise - 2 * a - b + x * (a + b - 2 * rise)));
}

// Where it is highest between its ends, 0 < x < 1, as far as it falls on both sides there; else NOWHERE.
//
// Nor does it count where the slopes have the same sign and a single bend, ONCE from either end, would explain them.
inline double maximum_at(double start, double a, double end, double b) {
    const double rise = end - start;
    if (a * b >= 0) {
        const double bend = (rise - b) / (a != b ? a - b : 1e-300);
        if (ONCE < bend && bend < 1 - ONCE) return NOWHERE;
    }
    const double B = 3 * rise - 2 * a - b, C = 3 * (a + b - 2 * rise);  // its slope is a + 2 B x + C x²
    const double inside = B * B - a * C;
    if (inside <= 0 || (B > 0 && C >= 0)) return NOWHERE;
    const double root = std::sqrt(inside);
    const double x = B > 0 ? -(B + root) / C : a / (root - B);
    return 0 < x && x < 1 ? x : NOWHERE;
}

// Where it is lowest between its ends, 0 < x < 1, as far as it rises on both sides there; else NOWHERE
inline double minimum_at(double start, double a, double end, double b) { return maximum_at(-start, -a, -end, -b); }

// Its least slope between the ends
inline double least_slope(double start, double a, double end, double b) {
    const double rise = end - start;
    const double B = 3 * rise - 2 * a - b, C = 3 * (a + b - 2 * rise);
    return B < 0 && C > -B ? a - B * B / C : std::min(a, b);
}

// Where the load is highest between two points, 0 < x < 1, and how high, as far as both ends tell.
//
// It is where their tangents meet, if it rises at the first and falls at the other: no higher, if it bends downwards
// all the way. Where they meet elsewhere it does not, and the cubic tells. If that has no maximum, it is midway, and
// not above where the first tangent leads.
inline std::pair<double, double> summit(double start, double a, double end, double b) {
    if (a > 0 && 0 > b) {
        const double x = (end - b - start) / (a - b);
        if (0 < x && x < 1) return {x, start + a * x};
    }
    const double x = maximum_at(start, a, end, b);
    if (x > 0) return {x, cubic(x, start, a, end, b)};
    return {0.5, start + a};
}

}  // namespace holdfast
