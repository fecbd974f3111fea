// Corners of the regions in which triangles of two surfaces face each other, with distances.

#pragma once

#include <algorithm>
#include <limits>

#include "clipping.hpp"
#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

constexpr Int NEAR_ROW = 7;  // numbers of a near point: point (3), normal (3), distance

// The square of the longest side of a triangle
inline double longest2(const double (&flat)[3][2]) {
    double longest = 0.0;
    for (int i = 0; i < 3; ++i) {
        const double *const p = flat[i], *const q = flat[(i + 1) % 3];
        longest = std::max(longest, (p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]));
    }
    return longest;
}

// Tell whether a point is a corner of a triangle, up to rounding
inline bool is_corner(const double (&flat)[3][2], double x, double y, double size2) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& p : flat) least = std::min(least, (p[0] - x) * (p[0] - x) + (p[1] - y) * (p[1] - y));
    return least <= 1e-20 * size2;
}

// The corners (n, NEAR_ROW) of the regions in which faces of ``pairs`` (m, 2) face each other.
//
// Each row holds the point halfway between the surfaces [m], the normal into b, and the signed distance along it [m],
// which is at most ``margin`` and at least ``-depth``. The normal is that of the face on which a vertex of the other
// surface lies, and the mean of both where two edges cross. The cosine of the angle between the faces is at least
// ``cos_angle``.
inline Array<double, 2> facing_corners(InTen triangles_a, InMat normals_a, InTen triangles_b, InMat normals_b,
                                       InIntMat pairs, double margin, double depth, double cos_angle) {
    Array<double, 2> found({0, NEAR_ROW});
    auto& rows = found.numbers;
    for (Int pair = 0; pair < pairs.size(); ++pair) {
        const Int i = pairs(pair, 0), j = pairs(pair, 1);
        const In normal_a = normals_a[i], normal_b = normals_b[j];
        if (!(dot3(normal_a, normal_b) <= -cos_angle)) continue;
        const auto tri_a = triangles_a[i];
        const Facing facing(tri_a, normal_a, triangles_b[j], normal_b, margin, depth);
        if (facing.ring.count < 3) continue;
        const auto& [normal, t1, t2] = facing.plane.axes;
        const double dx = facing.bx - facing.ax, dy = facing.by - facing.ay;
        const double size2 = std::max(longest2(facing.flat_a), longest2(facing.flat_b));
        for (Int c = 0; c < facing.ring.count; ++c) {
            const double x = facing.ring.at[c][0], y = facing.ring.at[c][1];
            const double height = dx * x + dy * y + facing.level;
            const double middle = facing.ax * x + facing.ay * y + height / 2;
            const bool of_a = is_corner(facing.flat_a, x, y, size2), of_b = is_corner(facing.flat_b, x, y, size2);
            double across[3];
            for (int k = 0; k < 3; ++k) {
                across[k] = of_a && !of_b ? -normal_b[k] : of_b && !of_a ? normal_a[k] : normal[k];
            }
            const double lean = across[0] * normal[0] + across[1] * normal[1] + across[2] * normal[2];
            for (int k = 0; k < 3; ++k) rows.push_back(tri_a(0, k) + x * t1[k] + y * t2[k] + middle * normal[k]);
            rows.insert(rows.end(), across, across + 3);
            rows.push_back(height * lean);
        }
    }
    found.sizes[0] = static_cast<Int>(rows.size()) / NEAR_ROW;
    return found;
}

}  // namespace holdfast
