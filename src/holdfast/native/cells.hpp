// Cells of a surface: cuts of flat facets by a grid, and what is in front of points.

#pragma once

#include <algorithm>
#include <tuple>

#include "polygon.hpp"
#include "span.hpp"

namespace holdfast {

constexpr Int CELL_CORNERS = 8;  // more than a triangle has after cuts along the four sides of a grid cell

// Mark in ``result`` (n,) the points from which the segment of this ``length`` [m] along the normal meets a triangle.
// The method is that of Möller and Trumbore (1997).
inline void mark_hits(InMat points, InMat normals, InTen triangles, double length, Span<bool> result) {
    for (Int i = 0; i < points.size(); ++i) {
        const double d0 = normals(i, 0), d1 = normals(i, 1), d2 = normals(i, 2);
        const double x = points(i, 0), y = points(i, 1), z = points(i, 2);
        result[i] = false;
        for (Int t = 0; t < triangles.size(); ++t) {
            const auto triangle = triangles[t];
            const auto a = triangle[0], b = triangle[1], c = triangle[2];
            const double e0 = b[0] - a[0], e1 = b[1] - a[1], e2 = b[2] - a[2];
            const double f0 = c[0] - a[0], f1 = c[1] - a[1], f2 = c[2] - a[2];
            const double p0 = d1 * f2 - d2 * f1, p1 = d2 * f0 - d0 * f2, p2 = d0 * f1 - d1 * f0;
            const double det = e0 * p0 + e1 * p1 + e2 * p2;
            if (det == 0.0) continue;
            const double s0 = x - a[0], s1 = y - a[1], s2 = z - a[2];
            const double u = (s0 * p0 + s1 * p1 + s2 * p2) / det;
            const double q0 = s1 * e2 - s2 * e1, q1 = s2 * e0 - s0 * e2, q2 = s0 * e1 - s1 * e0;
            const double v = (d0 * q0 + d1 * q1 + d2 * q2) / det;
            const double along = (f0 * q0 + f1 * q1 + f2 * q2) / det;
            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && 0.0 <= along && along <= length) {
                result[i] = true;
                break;
            }
        }
    }
}

// Cut triangle t (n, 3, 2) by the cells of a grid from ``first[t]`` up to, not including, ``last[t]``. ``step`` (2,)
// is the size of a cell, and the grid has this number of ``columns``. Returns the pieces (m, CELL_CORNERS, 2), their
// numbers of corners (m,) and those of their cells (m,).
inline std::tuple<Array<double, 3>, Array<Int>, Array<Int>> cut_by_grid(InTen triangles, In step, Int columns,
                                                                        InIntMat first, InIntMat last) {
    Array<double, 3> pieces({0, CELL_CORNERS, 2});
    Array<Int> sizes, cells;
    for (Int t = 0; t < triangles.size(); ++t) {
        for (Int i = first(t, 0); i < last(t, 0); ++i) {
            for (Int j = first(t, 1); j < last(t, 1); ++j) {
                Ring now;
                for (Int c = 0; c < 3; ++c) now.add(triangles(t, c, 0), triangles(t, c, 1));
                keep_half_plane(now, 1.0, 0.0, static_cast<double>(-i) * step[0]);
                keep_half_plane(now, -1.0, 0.0, static_cast<double>(i + 1) * step[0]);
                keep_half_plane(now, 0.0, 1.0, static_cast<double>(-j) * step[1]);
                keep_half_plane(now, 0.0, -1.0, static_cast<double>(j + 1) * step[1]);
                if (now.count < 3) continue;
                sizes.numbers.push_back(append_corners(now, CELL_CORNERS, pieces.numbers));
                cells.numbers.push_back(i * columns + j);
            }
        }
    }
    pieces.sizes[0] = sizes.sizes[0] = cells.sizes[0] = static_cast<Int>(sizes.numbers.size());
    return {std::move(pieces), std::move(sizes), std::move(cells)};
}

}  // namespace holdfast
