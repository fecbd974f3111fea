// Convex hulls of points in a plane: within a tolerance, the smallest rectangle around one, and the numbers of its
// corners.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr double SAME_CORNER = 1e-7;  // in a unit square: closer points are the same corner; a corner that spans less
                                      // area is dropped

using Place = std::array<double, 2>;

// Drop the corners of a ring that are within ``tolerance`` of the line through their neighbours, as
// ``without_collinear`` of geometry/polygon.py does
inline void drop_collinear(std::vector<Place>& ring, double tolerance) {
    std::size_t i = 0;
    while (i < ring.size() && ring.size() > 3) {
        const auto [ax, ay] = ring[i == 0 ? ring.size() - 1 : i - 1];
        const auto [bx, by] = ring[i];
        const auto [cx, cy] = ring[i + 1 < ring.size() ? i + 1 : 0];
        const double length = std::hypot(cx - ax, cy - ay);
        const double height = length > 0.0 ? std::abs((cx - ax) * (by - ay) - (cy - ay) * (bx - ax)) / length : 0.0;
        if (height > tolerance && std::hypot(bx - ax, by - ay) > tolerance) {
            ++i;
            continue;
        }
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
        i = i == ring.size() || i == 0 ? 0 : i - 1;  // only the corner before has a new neighbour
    }
}

// The corners of the convex hull of at least one point, counter-clockwise (monotone chain). Those within ``tolerance``
// of the line through their neighbours are dropped.
inline std::vector<Place> convex_hull(std::vector<Place> points, double tolerance) {
    const auto less = [](double a, double b) { return a < b || (a == a && b != b); };  // an order for NaN, too
    std::sort(points.begin(), points.end(), [&](const Place& a, const Place& b) {
        return less(a[0], b[0]) || (!less(b[0], a[0]) && less(a[1], b[1]));
    });
    std::vector<Place> found;
    found.reserve(points.size() + 2);
    for (int side = 0; side < 2; ++side) {
        const std::size_t floor = found.size();
        for (const auto& [x, y] : points) {
            while (found.size() >= floor + 2) {
                const auto [ax, ay] = found[found.size() - 2];
                const auto [bx, by] = found.back();
                if ((bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0) break;
                found.pop_back();
            }
            found.push_back({x, y});
        }
        found.pop_back();
        std::reverse(points.begin(), points.end());
    }
    drop_collinear(found, tolerance);
    return found;
}

// The extent of the hull along (x, y)
inline double extent(InMat hull, double x, double y) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (Int i = 0; i < hull.size(); ++i) {
        const double along = x * hull(i, 0) + y * hull(i, 1);
        low = std::min(low, along);
        high = std::max(high, along);
    }
    return high - low;
}

// The unit axes (2, 2), as rows, of the smallest rectangle around a hull (m, 2), that of the longer side first. Of
// rectangles that are equal up to rounding, it is the one along the first edge.
inline Array<double, 2> rectangle_axes(InMat hull) {
    const Int count = hull.size();
    std::vector<std::array<double, 3>> each(static_cast<std::size_t>(count));
    double largest = 0.0;
    for (Int e = 0; e < count; ++e) {
        const Int other = e + 1 < count ? e + 1 : 0;
        double x = hull(other, 0) - hull(e, 0), y = hull(other, 1) - hull(e, 1);
        const double norm = std::sqrt(x * x + y * y);
        x /= norm;
        y /= norm;
        each[e] = {x, y, extent(hull, x, y) * extent(hull, -y, x)};
        largest = std::max(largest, each[e][2]);
    }
    Int best = 0;
    for (Int e = 0; e < count; ++e) {
        if (std::rint(each[e][2] / largest * 1e9) < std::rint(each[best][2] / largest * 1e9)) best = e;
    }
    double x = each[best][0], y = each[best][1];
    if (extent(hull, x, y) < extent(hull, -y, x) * (1 - 1e-9)) {
        const double across = -y;
        y = x;
        x = across;
    }
    Array<double, 2> axes({2, 2});
    axes.numbers = {x, y, -y, x};
    return axes;
}

// Twice the signed area of the triangle of points a, b and c
inline double twice_area(InMat points, Int a, Int b, Int c) {
    return (points(b, 0) - points(a, 0)) * (points(c, 1) - points(a, 1)) -
           (points(b, 1) - points(a, 1)) * (points(c, 0) - points(a, 0));
}

// The numbers of the points (n, 2) that are corners of their hull, counter-clockwise, by going through the points in
// ``order`` (n,), along x, and back (Andrew)
inline Array<Int> corner_numbers(InMat points, InInts order) {
    const Int count = order.size();
    Array<Int> found({2 * count + 1});
    auto& chain = found.numbers;
    Int size = 0;
    for (int side = 0; side < 2; ++side) {
        const Int floor = size + 1;
        for (Int step = 0; step < count; ++step) {
            const Int k = side == 0 ? order[step] : order[count - 1 - step];
            while (size > floor && twice_area(points, chain[size - 2], chain[size - 1], k) <= SAME_CORNER) --size;
            const Int last = chain[std::max(size - 1, Int{0})];
            if (size == 0 || std::max(std::abs(points(last, 0) - points(k, 0)),
                                      std::abs(points(last, 1) - points(k, 1))) > SAME_CORNER) {
                chain[size] = k;
                ++size;
            }
        }
        --size;
    }
    found.sizes[0] = std::max(size, Int{0});
    chain.resize(static_cast<std::size_t>(found.sizes[0]));
    return found;
}

}  // namespace holdfast
