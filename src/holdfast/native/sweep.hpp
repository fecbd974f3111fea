// What triangles of two surfaces share, seen along the direction of a motion, and how far apart they are along it.

#pragma once

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "polygon.hpp"
#include "span.hpp"

namespace holdfast {

constexpr Int MOST_SHARED = 8;  // largest number of corners of the intersection of two triangles, clipped by one line

// Twice the signed area of a triangle seen along the third axis
template <class A, class B, class C>
double turn_of(const A& a, const B& b, const C& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Clip a convex polygon where ``side``, given at its corners, is positive
inline void keep_side(Ring& ring, const double* side) {
    Ring kept;
    for (Int k = 0; k < ring.count; ++k) {
        const Int m = k + 1 < ring.count ? k + 1 : 0;
        const double *const p = ring.at[k], *const q = ring.at[m];
        if (side[k] >= 0.0) kept.add(p[0], p[1]);
        if ((side[k] > 0.0 && side[m] < 0.0) || (side[k] < 0.0 && side[m] > 0.0)) {
            const double t = side[k] / (side[k] - side[m]);
            kept.add(p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]));
        }
    }
    for (Int k = 0; k < kept.count; ++k) {
        ring.at[k][0] = kept.at[k][0];
        ring.at[k][1] = kept.at[k][1];
    }
    ring.count = kept.count;
}

// The intersection of two triangles seen along the third axis
inline Ring common_part(InMat ours, InMat theirs) {
    const double turn = turn_of(theirs[0], theirs[1], theirs[2]) > 0 ? 1.0 : -1.0;
    Ring polygon;
    for (Int k = 0; k < 3; ++k) polygon.add(ours(k, 0), ours(k, 1));
    double side[MOST_CORNERS];
    for (Int e = 0; e < 3; ++e) {
        for (Int k = 0; k < polygon.count; ++k) {
            side[k] = turn * turn_of(theirs[e], theirs[(e + 1) % 3], polygon.at[k]);
        }
        keep_side(polygon, side);
    }
    return polygon;
}

// The third coordinate of a triangle's plane at a point (2,), clamped to the range of the triangle
inline double height_of(InMat triangle, const double* point) {
    const double whole = turn_of(triangle[0], triangle[1], triangle[2]);
    const double u = turn_of(triangle[0], point, triangle[2]) / whole;
    const double v = turn_of(triangle[0], triangle[1], point) / whole;
    const double z0 = triangle(0, 2), z1 = triangle(1, 2), z2 = triangle(2, 2);
    const double height = z0 + u * (z1 - z0) + v * (z2 - z0);
    const double low = std::min(z0, std::min(z1, z2)), high = std::max(z0, std::max(z1, z2));
    return std::min(std::max(height, low), high);
}

// Triangles (F, 3, 3) [m] and their boxes ``low``, ``high`` (F, 3) in a frame whose third axis is the direction
struct SweptFaces {
    InTen triangles;
    InMat low, high;
    static constexpr auto fields = std::tuple{&SweptFaces::triangles, &SweptFaces::low, &SweptFaces::high};
};

// The polygons that front and back triangles share, seen along the direction, and how far ahead the back triangles are.
//
// Returns the polygons (m, MOST_SHARED, 2), their numbers of corners (m,) and the least distances (m,) [m]. Only the
// parts count where the back triangle is at least ``least`` [m] ahead.
inline std::tuple<Array<double, 3>, Array<Int>, Array<double>> shared_parts(const SweptFaces& ours,
                                                                            const SweptFaces& theirs, double least) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    std::vector<Int> order(static_cast<std::size_t>(theirs.low.size()));
    std::iota(order.begin(), order.end(), Int{0});
    std::stable_sort(order.begin(), order.end(), [&](Int i, Int j) { return theirs.low(i, 0) < theirs.low(j, 0); });
    std::vector<double> starts;
    double widest = 0.0;
    for (Int j : order) {
        starts.push_back(theirs.low(j, 0));
        widest = std::max(widest, theirs.high(j, 0) - theirs.low(j, 0));
    }
    Array<double, 3> pieces({0, MOST_SHARED, 2});
    Array<Int> corners;
    Array<double> ahead;
    double side[MOST_CORNERS];
    for (Int i = 0; i < ours.low.size(); ++i) {
        const auto low = ours.low[i], high = ours.high[i];
        const auto first = std::lower_bound(starts.begin(), starts.end(), low[0] - widest) - starts.begin();
        for (auto at = static_cast<std::size_t>(first); at < starts.size() && starts[at] < high[0]; ++at) {
            const Int j = order[at];
            const auto low_b = theirs.low[j], high_b = theirs.high[j];
            if (low_b[1] >= high[1] || high_b[1] <= low[1] || high_b[0] <= low[0] || high_b[2] < low[2] + least) {
                continue;
            }
            const auto one = ours.triangles[i], other = theirs.triangles[j];
            Ring polygon = common_part(one, other);
            double farthest = -inf;
            for (Int k = 0; k < polygon.count; ++k) {
                side[k] = height_of(other, polygon.at[k]) - height_of(one, polygon.at[k]) - least;
                farthest = std::max(farthest, side[k]);
            }
            if (polygon.count < 3 || farthest <= 0.0) continue;
            keep_side(polygon, side);
            double nearest = inf;
            for (Int k = 0; k < polygon.count; ++k) {
                nearest = std::min(nearest, height_of(other, polygon.at[k]) - height_of(one, polygon.at[k]));
            }
            if (polygon.count < 3) continue;
            corners.numbers.push_back(append_corners(polygon, MOST_SHARED, pieces.numbers));
            ahead.numbers.push_back(nearest);
        }
    }
    pieces.sizes[0] = corners.sizes[0] = ahead.sizes[0] = static_cast<Int>(corners.numbers.size());
    return {std::move(pieces), std::move(corners), std::move(ahead)};
}

}  // namespace holdfast
