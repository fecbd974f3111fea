// Flat polygons: exact moments of rings, and convex polygons that half planes clip.

#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr Int MOST_CORNERS = 12;  // two triangles share at most 6 corners, and each limit of a gap adds one

// A convex polygon on the stack. Corners beyond the most, which only rounding can make, are left out.
struct Ring {
    double at[MOST_CORNERS][2];
    Int count = 0;

    void add(double x, double y) {
        if (count == MOST_CORNERS) return;
        at[count][0] = x;
        at[count][1] = y;
        ++count;
    }
};

// Append up to ``most`` corners of a polygon to ``rows``, and zeros where it has fewer; return their number
inline Int append_corners(const Ring& ring, Int most, std::vector<double>& rows) {
    const Int count = std::min(ring.count, most);
    for (Int k = 0; k < most; ++k) {
        rows.push_back(k < count ? ring.at[k][0] : 0.0);
        rows.push_back(k < count ? ring.at[k][1] : 0.0);
    }
    return count;
}

// Clip a polygon in place to a x + b y + c >= 0 (Sutherland-Hodgman)
inline void keep_half_plane(Ring& ring, double a, double b, double c) {
    Ring kept;
    for (Int i = 0; i < ring.count; ++i) {
        const double* const p = ring.at[i];
        const double* const q = ring.at[i + 1 < ring.count ? i + 1 : 0];
        const double di = a * p[0] + b * p[1] + c;
        const double dj = a * q[0] + b * q[1] + c;
        if (di >= 0.0) kept.add(p[0], p[1]);
        if ((di > 0.0 && dj < 0.0) || (di < 0.0 && dj > 0.0)) {
            const double t = di / (di - dj);
            kept.add(p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]));
        }
    }
    for (Int i = 0; i < kept.count; ++i) {
        ring.at[i][0] = kept.at[i][0];
        ring.at[i][1] = kept.at[i][1];
    }
    ring.count = kept.count;
}

// Add the integrals of 1, x, y, x², xy, y² over a ring (k, 2), positive if counter-clockwise, to ``total`` (6,), by
// Green's theorem
inline void add_moments(InMat ring, Vec total) {
    for (Int i = 0; i < ring.size(); ++i) {
        const Int j = i + 1 < ring.size() ? i + 1 : 0;
        const double x = ring(i, 0), y = ring(i, 1), u = ring(j, 0), v = ring(j, 1);
        const double cross = x * v - u * y;
        total[0] += cross / 2;
        total[1] += (x + u) * cross / 6;
        total[2] += (y + v) * cross / 6;
        total[3] += (x * x + x * u + u * u) * cross / 12;
        total[4] += (x * (2 * y + v) + u * (y + 2 * v)) * cross / 24;
        total[5] += (y * y + y * v + v * v) * cross / 12;
    }
}

// The moments (m, 6) of rings (m, k, 2), as ``add_moments`` finds them, and twice the area over the perimeter (m,). Up
// to eight sides are added in the order of NumPy.
inline std::tuple<Array<double, 2>, Array<double>> measures_of(InTen rings) {
    const Int m = rings.size(), k = rings.size(1);
    Array<double, 2> moments({m, 6});
    Array<double> widths({m});
    for (Int r = 0; r < m; ++r) {
        const InMat ring = rings[r];
        add_moments(ring, moments.view()[r]);
        double whole = 0.0, sides[8];
        for (Int i = 0; i < k; ++i) {
            const Int j = i + 1 < k ? i + 1 : 0;
            const double x = ring(i, 0) - ring(j, 0), y = ring(i, 1) - ring(j, 1);
            sides[i % 8] = std::sqrt(x * x + y * y);
            whole += sides[i % 8];
        }
        if (k == 8) {
            whole = ((sides[0] + sides[1]) + (sides[2] + sides[3])) + ((sides[4] + sides[5]) + (sides[6] + sides[7]));
        }
        widths.numbers[r] = whole > 0 ? 2 * moments.view()(r, 0) / whole : 0.0;
    }
    return {std::move(moments), std::move(widths)};
}

}  // namespace holdfast
