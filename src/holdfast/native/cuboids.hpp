// Intersections of the faces of cuboids that are flush, for all pairs of a scene at once.

#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "clipping.hpp"
#include "polygon.hpp"
#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

constexpr Int RECTANGLE_CORNERS = 8;  // largest number of corners of the intersection of two rectangles

// Drop corners within ``same`` of the next one or of the line through their neighbours; rotate to the lowest
inline void tidy(Ring& ring, double same) {
    Ring kept;
    for (int pass = 0; pass < 2; ++pass) {
        kept.count = 0;
        for (Int i = 0; i < ring.count; ++i) {
            const double* const here = ring.at[i];
            const double* const after = ring.at[i + 1 < ring.count ? i + 1 : 0];
            bool keep;
            if (pass == 0) {
                keep = std::hypot(after[0] - here[0], after[1] - here[1]) > same;
            } else {
                const double* const before = ring.at[(i > 0 ? i : ring.count) - 1];
                const double cx = after[0] - before[0], cy = after[1] - before[1];
                const double turn = cx * (here[1] - before[1]) - cy * (here[0] - before[0]);
                keep = std::abs(turn) > same * std::hypot(cx, cy);
            }
            if (keep) kept.add(here[0], here[1]);
        }
        ring = kept;
    }
    Int first = 0;
    for (Int i = 1; i < ring.count; ++i) {
        const double ahead = ring.at[first][0] - ring.at[i][0];
        if (ahead > same || (ahead >= -same && ring.at[i][1] < ring.at[first][1])) first = i;
    }
    for (Int i = 0; i < ring.count; ++i) {
        const Int j = (first + i) % ring.count;
        kept.at[i][0] = ring.at[j][0];
        kept.at[i][1] = ring.at[j][1];
    }
    ring = kept;
}

// Write the corners in the world frame, halfway between the faces, and the normal and separation of the faces
inline void lift(InMat a, InMat b, Int k, Int m, double side, const Plane& between, const Ring& ring, Mat corners,
                 Vec plane) {
    const auto& [normal, t1, t2] = between.axes;
    const In along = between.axis(0);
    const double level_a = side * a(4, k) * dot3(a[1 + k], along);
    double level_b = -b(4, m) * std::abs(dot3(b[1 + m], along));
    for (int i = 0; i < 3; ++i) {
        level_b += (b(0, i) - a(0, i)) * normal[i];
        plane[i] = normal[i];
    }
    plane[3] = plane[4] = level_b - level_a;
    for (Int i = 0; i < ring.count; ++i) {
        for (int j = 0; j < 3; ++j) {
            const double height = (level_a + level_b) / 2 * normal[j];
            corners(i, j) = a(0, j) + ring.at[i][0] * t1[j] + ring.at[i][1] * t2[j] + height;
        }
    }
}

// Intersect the face of a along its k-th axis with that of b along its m-th; return the number of corners. The first
// corner is the lowest along the first tangent of the plane.
inline Int share_faces(InMat a, InMat b, Int k, Int m, double same, Mat corners, Vec plane) {
    double normal_a[3], normal_b[3], arm[3];
    for (int i = 0; i < 3; ++i) arm[i] = b(0, i) - a(0, i);
    const In between(arm, {3});
    const double side = dot3(a[1 + k], between) > 0 ? 1.0 : -1.0;
    const double other = dot3(b[1 + m], between) > 0 ? -1.0 : 1.0;
    for (int i = 0; i < 3; ++i) {
        normal_a[i] = side * a(1 + k, i);
        normal_b[i] = other * b(1 + m, i);
    }
    const Plane axes(In(normal_a, {3}), In(normal_b, {3}));
    const In t1 = axes.axis(1), t2 = axes.axis(2);
    const Int one = (k + 1) % 3, two = (k + 2) % 3;
    Ring ring;
    for (int corner = 0; corner < 4; ++corner) {  // counter-clockwise seen from outside if ``side`` is +1
        const double x = corner == 0 || corner == 3 ? a(4, one) : -a(4, one);
        const double y = side * (corner < 2 ? a(4, two) : -a(4, two));
        ring.add(x * dot3(a[1 + one], t1) + y * dot3(a[1 + two], t1),
                 x * dot3(a[1 + one], t2) + y * dot3(a[1 + two], t2));
    }
    for (Int edge = 1; edge < 3; ++edge) {
        const Int axis = (m + edge) % 3;
        const double u = dot3(b[1 + axis], t1), v = dot3(b[1 + axis], t2);
        const double at = dot3(b[1 + axis], between), half = b(4, axis);
        keep_half_plane(ring, u, v, half - at);
        keep_half_plane(ring, -u, -v, half + at);
    }
    tidy(ring, same);
    ring.count = std::min(ring.count, RECTANGLE_CORNERS);
    lift(a, b, k, m, side, axes, ring, corners, plane);
    return ring.count;
}

// Intersect the flush faces of ``pairs`` (m, 2) of ``bodies`` (n, 5, 3), given by their axes ``along`` (m, 2). The rows
// of a cuboid are its centre, its three axes and its half lengths. Corners closer than ``same`` (m,) are merged.
// Returns how many (m,) of the corners (m, RECTANGLE_CORNERS, 3) each pair has, these, and for each (m, 5) the normal,
// the least and the largest separation.
inline std::tuple<Array<Int>, Array<double, 3>, Array<double, 2>> flush_faces(InTen bodies, InIntMat pairs,
                                                                              InIntMat along, In same) {
    Array<Int> counts({pairs.size()});
    Array<double, 3> corners({pairs.size(), RECTANGLE_CORNERS, 3});
    Array<double, 2> planes({pairs.size(), 5});
    for (Int pair = 0; pair < pairs.size(); ++pair) {
        counts.numbers[pair] = share_faces(bodies[pairs(pair, 0)], bodies[pairs(pair, 1)], along(pair, 0),
                                           along(pair, 1), same[pair], corners.view()[pair], planes.view()[pair]);
    }
    return {std::move(counts), std::move(corners), std::move(planes)};
}

}  // namespace holdfast
