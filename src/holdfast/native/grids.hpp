// Grids of nodes over faces that fill their smallest rectangle, all in one go.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "frame.hpp"
#include "hull.hpp"
#include "span.hpp"

namespace holdfast {

constexpr double EXACT_CORNER = 1e-12;  // largest deviation of the corners of a rectangular face, relative to its sides
constexpr double DROPPED = 1e-9;  // distance of corners of a hull from the line through their neighbours, relative
                                  // to the size of the face, that counts as none

// Of each face: the numbers of nodes across and along (F, 2), 0 of one that is no rectangle; its shorter side over the
// longer one (F,); and the nodes (n, 3) [m] of all
struct Grids {
    std::vector<Int> sides;
    std::vector<double> aspect, points;
};

// The unit axes, the low corner along them and the sides of the smallest rectangle around the corners of a hull
struct Rectangle {
    std::array<double, 4> axes;
    Place low, size;
};

inline Rectangle rectangle_around(std::vector<Place>& hull) {
    std::size_t nearest = 0;  // decides between equal rectangles
    for (std::size_t i = 1; i < hull.size(); ++i) {
        if (std::hypot(hull[i][0], hull[i][1]) < std::hypot(hull[nearest][0], hull[nearest][1])) nearest = i;
    }
    std::rotate(hull.begin(), hull.begin() + static_cast<std::ptrdiff_t>(nearest), hull.end());
    const auto axes = rectangle_axes(InMat(hull[0].data(), {static_cast<Int>(hull.size()), 2})).numbers;
    Rectangle found{{axes[0], axes[1], axes[2], axes[3]}, {}, {}};
    for (std::size_t k = 0; k < 2; ++k) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const auto& [x, y] : hull) {
            const double along = x * axes[2 * k] + y * axes[2 * k + 1];
            low = std::min(low, along);
            high = std::max(high, along);
        }
        found.low[k] = low;
        found.size[k] = high - low;
    }
    return found;
}

// Whether the four corners of a hull are those of its rectangle
inline bool fills(const std::vector<Place>& hull, const Rectangle& r) {
    if (hull.size() != 4 || !(r.size[0] > 0.0) || !(r.size[1] > 0.0)) return false;
    constexpr Place SQUARE[] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
    return std::all_of(std::begin(SQUARE), std::end(SQUARE), [&](const Place& corner) {
        return std::any_of(hull.begin(), hull.end(), [&](const Place& at) {
            double off = 0.0;
            for (std::size_t k = 0; k < 2; ++k) {
                const double along = at[0] * r.axes[2 * k] + at[1] * r.axes[2 * k + 1];
                off = std::max(off, std::abs((along - r.low[k]) / r.size[k] - corner[k]));
            }
            return off <= EXACT_CORNER;
        });
    });
}

// The place of node ``k`` of ``count`` at even distances from 0 to 1
inline double evenly(Int k, Int count) {
    return k == count - 1 ? 1.0 : static_cast<double>(k) * (1.0 / static_cast<double>(count - 1));
}

// Lay a grid of about ``count`` (F,) nodes, at least 4, over each of the faces with corners (n, 3) from ``first``
// (F + 1,) on and unit ``normal`` (F, 3)
inline Grids grids_over(InMat corners, InInts first, InMat normal, InInts count) {
    Grids found;
    std::vector<Place> ring;
    for (Int f = 0; f < normal.size(); ++f) {
        const auto frame = frame_on({normal(f, 0), normal(f, 1), normal(f, 2)});
        const In origin = corners[first[f]];
        ring.clear();
        double low[2] = {0.0, 0.0}, high[2] = {0.0, 0.0};
        for (Int i = first[f]; i < first[f + 1]; ++i) {
            const double x = corners(i, 0) - origin[0], y = corners(i, 1) - origin[1], z = corners(i, 2) - origin[2];
            Place& at = ring.emplace_back();
            for (int k = 0; k < 2; ++k) {
                at[k] = x * frame[k][0] + y * frame[k][1] + z * frame[k][2];
                low[k] = std::min(low[k], at[k]);
                high[k] = std::max(high[k], at[k]);
            }
        }
        auto hull = convex_hull(ring, DROPPED * std::max(high[0] - low[0], high[1] - low[1]));
        Rectangle r{};
        if (hull.size() == 4) r = rectangle_around(hull);
        if (!fills(hull, r)) {
            found.sides.insert(found.sides.end(), {0, 0});
            found.aspect.push_back(0.0);
            continue;
        }
        const double nodes = static_cast<double>(count[f]);
        // a very thin patch has only two rows
        const double wide = std::max(2.0, std::nearbyint(std::min(std::sqrt(nodes * r.size[0] / r.size[1]), nodes)));
        const Int across = static_cast<Int>(wide);
        const Int along = static_cast<Int>(std::max(2.0, std::nearbyint(nodes / wide)));
        found.sides.insert(found.sides.end(), {across, along});
        found.aspect.push_back(r.size[1] / r.size[0]);
        for (Int i = 0; i < across; ++i) {
            const double u = r.low[0] + evenly(i, across) * r.size[0];
            for (Int j = 0; j < along; ++j) {
                const double v = r.low[1] + evenly(j, along) * r.size[1];
                const double x = u * r.axes[0] + v * r.axes[2], y = u * r.axes[1] + v * r.axes[3];
                for (int k = 0; k < 3; ++k) {
                    found.points.push_back(origin[k] + (x * frame[0][k] + y * frame[1][k]));
                }
            }
        }
    }
    return found;
}

}  // namespace holdfast
