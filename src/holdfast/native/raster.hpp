// Which triangle is visible at each pixel, and which lines are drawn there.

#pragma once

#include <algorithm>
#include <cmath>

#include "span.hpp"

namespace holdfast {

constexpr int CREASE = 1;   // kind of line at a pixel: the surface bends
constexpr int OUTLINE = 2;  // kind of line at a pixel: the border of a body

// The whole number of pixels in [low, high] that is nearest to a place, which may be anything, and even NaN
inline Int pixel(double place, Int low, Int high) {
    if (!(place > static_cast<double>(low))) return low;
    return place >= static_cast<double>(high) ? high : static_cast<Int>(place);
}

// Write the triangles (T, 3) of projected vertices (V, 3: column, row, depth) into ``depth`` and ``seen`` (rows,
// columns).
// ``behind`` (T,) is added to the depth of each.
inline void fill_triangles(InMat pixels, InIntMat triangles, In behind, Mat depth, IntMat seen) {
    const Int rows = depth.size(0), columns = depth.size(1);
    for (Int t = 0; t < triangles.size(); ++t) {
        const auto a = pixels[triangles(t, 0)], b = pixels[triangles(t, 1)], c = pixels[triangles(t, 2)];
        const double ax = a[0], ay = a[1], az = a[2], bx = b[0], by = b[1], bz = b[2], cx = c[0], cy = c[1], cz = c[2];
        const double area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if (!(std::abs(area) >= 1e-12)) continue;
        const Int top = pixel(std::ceil(std::min({ay, by, cy}) - 0.5), 0, rows);
        const Int bottom = pixel(std::floor(std::max({ay, by, cy}) - 0.5), -1, rows - 1);
        const Int left = pixel(std::ceil(std::min({ax, bx, cx}) - 0.5), 0, columns);
        const Int right = pixel(std::floor(std::max({ax, bx, cx}) - 0.5), -1, columns - 1);
        for (Int row = top; row <= bottom; ++row) {
            const double y = static_cast<double>(row) + 0.5;
            for (Int column = left; column <= right; ++column) {
                const double x = static_cast<double>(column) + 0.5;
                const double u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area;
                const double v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area;
                const double w = 1.0 - u - v;
                if (u < -1e-9 || v < -1e-9 || w < -1e-9) continue;
                const double z = u * az + v * bz + w * cz + behind[t];
                if (z < depth(row, column)) {
                    depth(row, column) = z;
                    seen(row, column) = t;
                }
            }
        }
    }
}

// Write the kind of line at each pixel into ``line``: between what is ``seen`` there, and right of it or below it
inline void draw_lines(InIntMat seen, InMat depth, InMat normals, InInts body, double scale, double crease_cosine,
                       double step_pixels, Span<unsigned char, 2> line) {
    const Int rows = seen.size(0), columns = seen.size(1);
    for (Int row = 0; row < rows; ++row) {
        for (Int column = 0; column < columns; ++column) {
            for (int down = 0; down < 2; ++down) {
                const int right = 1 - down;
                if (row + down >= rows || column + right >= columns) continue;
                const Int s = seen(row, column), t = seen(row + down, column + right);
                if (s == t) continue;
                int kind = 0;
                if (s < 0 || t < 0 || body[s] != body[t]) {
                    kind = OUTLINE;
                } else {
                    const auto n = normals[s], m = normals[t];
                    const double along = std::max(std::abs(n[2]), 0.05), sign = n[2] > 0 ? 1.0 : n[2] < 0 ? -1.0 : 0.0;
                    const double slope = (right * n[0] - down * n[1]) / along * sign;
                    const double jump = depth(row + down, column + right) - depth(row, column) - slope / scale;
                    if (std::abs(jump) * scale * along > step_pixels) {
                        kind = OUTLINE;
                    } else if (n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < crease_cosine) {
                        kind = CREASE;
                    }
                }
                for (auto* at : {&line(row, column), &line(row + down, column + right)}) {
                    *at = std::max(*at, static_cast<unsigned char>(kind));
                }
            }
        }
    }
}

}  // namespace holdfast
