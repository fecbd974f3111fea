// How cuboids lie, and the intersections of the faces of those that are flush, for all pairs of a scene at once.

#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "clipping.hpp"
#include "frame.hpp"
#include "polygon.hpp"
#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

constexpr Int RECTANGLE_CORNERS = 8;  // largest number of corners of the intersection of two rectangles
constexpr double SAME = 1e-3;         // relative to the negligible width: corners that are closer are merged

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

enum class Lying { OTHER, APART, FLUSH };

// How two cuboids lie, and the axes of each along which they touch if they are flush
struct Lie {
    Lying how;
    Int k, m;
};

// Classify two cuboids; whether the rectangles of flush ones intersect is not tested. ``gap``, ``size`` and
// ``negligible`` are as in ``cuboid_contacts``.
inline Lie lie_of(InMat a, InMat b, double gap, double size, double negligible, double rounding, double wide) {
    const double tiny = rounding * size;
    double arm[3], slopes[3][3], overlap[3], back[3], leaning[3];  // along the axes of a and of b
    Int nearest[3];
    for (int k = 0; k < 3; ++k) arm[k] = b(0, k) - a(0, k);
    const In between(arm, {3});
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) slopes[i][j] = std::abs(dot3(a[1 + i], b[1 + j]));
    }
    double off = 0.0, longest = 0.0, least = 0.0;
    Int beside = 0, along = -1;
    for (int i = 0; i < 3; ++i) {
        const double *const s = slopes[i], half = a(4, i);
        const double reach = s[0] * b(4, 0) + s[1] * b(4, 1) + s[2] * b(4, 2);
        const double reach_back = slopes[0][i] * a(4, 0) + slopes[1][i] * a(4, 1) + slopes[2][i] * a(4, 2);
        overlap[i] = half + reach - std::abs(dot3(a[1 + i], between));
        back[i] = b(4, i) + reach_back - std::abs(dot3(b[1 + i], between));
        leaning[i] = std::max(std::min(s[0], s[1]), std::min(std::max(s[0], s[1]), s[2]));  // the middle one
        nearest[i] = s[0] >= s[1] && s[0] >= s[2] ? 0 : s[1] >= s[2] ? 1 : 2;
        const double thickness = 2 * std::min(half, b(4, nearest[i]));
        const bool level = leaning[i] <= rounding && std::abs(overlap[i]) <= tiny && thickness > gap + tiny;
        if (level && along < 0) along = i;
        if (overlap[i] <= negligible / 4) ++beside;
        off = std::max(off, leaning[i]);  // 0 if all axes of a are parallel to those of b
        longest = std::max(longest, std::max(half, b(4, i)));
        const double less = std::min(overlap[i], back[i]);
        least = i == 0 ? less : std::min(least, less);
    }
    const bool parallel = off <= rounding && off * longest < negligible / 16;
    if (least < -gap - tiny || (beside > 1 && parallel)) return {Lying::APART, 0, 0};
    if (beside == 1 && along >= 0 && gap >= wide * size) return {Lying::FLUSH, along, nearest[along]};
    return {Lying::OTHER, 0, 0};
}

// What pairs of cuboids share: for each pair how many corners (m,) its patch has, -1 if they are apart and 0 if neither
// is certain; these corners (m, RECTANGLE_CORNERS, 3); the normal, the least and the largest separation (m, 5); and two
// tangents (m, 2, 3)
using CuboidContacts = std::tuple<Array<Int>, Array<double, 3>, Array<double, 2>, Array<double, 3>>;

// Where ``pairs`` (m, 2) of ``bodies`` (n, 5, 3) touch. The rows of a cuboid are its centre, its three axes and its
// half lengths. ``limits`` (m, 3) are how far apart surfaces may be, the size of the smaller body, and the width up to
// which contacts are rounding; SAME times that apart, corners are merged. ``rounding`` is relative to the size, and so
// is
// ``wide``, the least gap for which flush faces explain everything.
inline CuboidContacts cuboid_contacts(InTen bodies, InIntMat pairs, InMat limits, double rounding, double wide) {
    const Int m = pairs.size();
    Array<Int> counts({m});
    Array<double, 3> corners({m, RECTANGLE_CORNERS, 3}), tangents({m, 2, 3});
    Array<double, 2> planes({m, 5});
    for (Int pair = 0; pair < m; ++pair) {
        const InMat a = bodies[pairs(pair, 0)], b = bodies[pairs(pair, 1)];
        const double negligible = limits(pair, 2);
        const Lie lie = lie_of(a, b, limits(pair, 0), limits(pair, 1), negligible, rounding, wide);
        if (lie.how == Lying::APART) counts.numbers[pair] = -1;
        if (lie.how != Lying::FLUSH) continue;
        const Vec plane = planes.view()[pair];
        counts.numbers[pair] = share_faces(a, b, lie.k, lie.m, SAME * negligible, corners.view()[pair], plane);
        const auto frame = frame_on({plane[0], plane[1], plane[2]});
        for (Int i = 0; i < 2; ++i) std::copy_n(frame[i].data(), 3, tangents.view()[pair][i].data());
    }
    return {std::move(counts), std::move(corners), std::move(planes), std::move(tangents)};
}

}  // namespace holdfast
