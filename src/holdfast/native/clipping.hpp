// Clipping of opposing triangles of two surfaces against each other, within a gap and an angle.

#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "polygon.hpp"
#include "search_mesh.hpp"
#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

// The mean normal of two faces, pointing from a to b, and two tangents, as rows
struct Plane {
    double axes[3][3];

    Plane(In normal_a, In normal_b) {
        double *const normal = axes[0], *const t1 = axes[1], *const t2 = axes[2];
        double length = 0.0;
        for (int k = 0; k < 3; ++k) {
            normal[k] = normal_a[k] - normal_b[k];
            length += normal[k] * normal[k];
        }
        const int seed = std::abs(normal[0]) < 0.9 * std::sqrt(length) ? 0 : 1;
        for (int k = 0; k < 3; ++k) normal[k] /= std::sqrt(length);
        for (int k = 0; k < 3; ++k) t1[k] = (k == seed ? 1.0 : 0.0) - normal[seed] * normal[k];
        length = std::sqrt(t1[0] * t1[0] + t1[1] * t1[1] + t1[2] * t1[2]);
        for (int k = 0; k < 3; ++k) t1[k] /= length;
        t2[0] = normal[1] * t1[2] - normal[2] * t1[1];
        t2[1] = normal[2] * t1[0] - normal[0] * t1[2];
        t2[2] = normal[0] * t1[1] - normal[1] * t1[0];
    }

    In axis(int k) const { return In(axes[k], {3}); }
};

// Two triangles seen along their mean normal, in a frame at the first corner of a: what they share there within limits
// of the gap, and the planes of both
struct Facing {
    Plane plane;
    double flat_a[3][2], flat_b[3][2];
    double ax, ay, bx, by, level;  // heights along the normal: ax x + ay y for a, and bx x + by y + level for b
    Ring ring;                     // fewer than three corners if they do not meet

    Facing(InMat tri_a, In normal_a, InMat tri_b, In normal_b, double gap, double depth) : plane(normal_a, normal_b) {
        for (Int i = 0; i < 3; ++i) {
            for (int m = 0; m < 2; ++m) {
                flat_a[i][m] = flat_b[i][m] = 0.0;
                for (Int k = 0; k < 3; ++k) {
                    flat_a[i][m] += (tri_a(i, k) - tri_a(0, k)) * plane.axes[m + 1][k];
                    flat_b[i][m] += (tri_b(i, k) - tri_a(0, k)) * plane.axes[m + 1][k];
                }
            }
            ring.add(flat_a[i][0], flat_a[i][1]);
        }
        ax = ay = bx = by = level = 0.0;
        for (int i = 0; i < 3; ++i) {  // b is seen from below along the normal, so its corners are in clockwise order
            const double *const p = flat_b[i], *const q = flat_b[(i + 2) % 3];
            const double ex = q[0] - p[0], ey = q[1] - p[1];
            keep_half_plane(ring, -ey, ex, ey * p[0] - ex * p[1]);
            if (ring.count < 3) return;
        }
        const In normal = plane.axis(0), t1 = plane.axis(1), t2 = plane.axis(2);
        const double slope_a = dot3(normal_a, normal), slope_b = dot3(normal_b, normal);
        ax = -dot3(normal_a, t1) / slope_a;
        ay = -dot3(normal_a, t2) / slope_a;
        bx = -dot3(normal_b, t1) / slope_b;
        by = -dot3(normal_b, t2) / slope_b;
        for (Int k = 0; k < 3; ++k) level += (tri_b(0, k) - tri_a(0, k)) * normal_b[k] / slope_b;
        keep_half_plane(ring, -1.0 * (bx - ax), -1.0 * (by - ay), -1.0 * level + gap);
        if (ring.count < 3) return;
        keep_half_plane(ring, bx - ax, by - ay, level + depth);
    }
};

// Where faces meet, halfway between the bodies: the corners of all pieces one after another, and for each piece its
// number of corners, the mean normal, the least and the largest separation, and whether one of the faces is curved
struct Pieces {
    Array<double, 2> corners{{0, 3}};
    Array<Int> counts;
    Array<double, 2> normals{{0, 3}}, heights{{0, 2}};
    Array<unsigned char> curved;
};

// Where faces of ``pairs`` (m, 2) face each other, up to ``gap`` apart or ``depth`` into each other [m]. The cosines
// are those of the angle for two flat faces and for pairs with a curved face.
inline Pieces clip_faces(const SearchMesh& a, const SearchMesh& b, InIntMat pairs, double gap, double depth,
                         double flat_cosine, double curved_cosine) {
    Pieces found;
    for (Int pair = 0; pair < pairs.size(); ++pair) {
        const Int i = pairs(pair, 0), j = pairs(pair, 1);
        const bool bent = a.curved[i] || b.curved[j];
        const In normal_a = a.normals[i], normal_b = b.normals[j];
        if (dot3(normal_a, normal_b) > -(bent ? curved_cosine : flat_cosine)) continue;
        const auto tri_a = a.triangles[i];
        const Facing facing(tri_a, normal_a, b.triangles[j], normal_b, gap, depth);
        if (facing.ring.count < 3) continue;
        const auto& [normal, t1, t2] = facing.plane.axes;
        double least = 0.0, largest = 0.0;
        for (Int c = 0; c < facing.ring.count; ++c) {
            const double x = facing.ring.at[c][0], y = facing.ring.at[c][1];
            const double middle = ((facing.ax + facing.bx) * x + (facing.ay + facing.by) * y + facing.level) / 2;
            const double apart = (facing.bx - facing.ax) * x + (facing.by - facing.ay) * y + facing.level;
            least = c == 0 ? apart : std::min(least, apart);
            largest = c == 0 ? apart : std::max(largest, apart);
            for (int k = 0; k < 3; ++k) {
                found.corners.numbers.push_back(tri_a(0, k) + x * t1[k] + y * t2[k] + middle * normal[k]);
            }
        }
        found.counts.numbers.push_back(facing.ring.count);
        for (int k = 0; k < 3; ++k) found.normals.numbers.push_back(normal[k]);
        found.heights.numbers.push_back(least);
        found.heights.numbers.push_back(largest);
        found.curved.numbers.push_back(bent);
    }
    found.corners.sizes[0] = static_cast<Int>(found.corners.numbers.size()) / 3;
    found.counts.sizes[0] = found.normals.sizes[0] = found.heights.sizes[0] = found.curved.sizes[0] =
        static_cast<Int>(found.counts.numbers.size());
    return found;
}

}  // namespace holdfast
