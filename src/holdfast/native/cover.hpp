// Which touching features lie on patches that were found before.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

// The least share of the distance by which a polygon is widened that its drawn corners reach: sixteen chords a round,
// about an outline from which shallow notches are gone
constexpr double DRAWN = 0.96;

// A patch in its frame: its rings, one after the other, closed, with the ``ends`` of each
struct FlatPatch {
    std::vector<std::array<double, 2>> corners;
    std::vector<Int> ends;
    double low[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    double high[2] = {-low[0], -low[0]};

    // Call ``take`` with both ends of each side
    template <class Take>
    void each_side(const Take& take) const {
        Int start = 0;
        for (Int end : ends) {
            for (Int i = start; i + 1 < end; ++i) take(corners[i], corners[i + 1]);
            if (end - start > 2) take(corners[end - 1], corners[start]);
            start = end;
        }
    }

    // The distance of a point; 0 inside
    double away(const double* at) const {
        bool inside = false;
        double least = std::numeric_limits<double>::infinity();  // squared
        each_side([&](const auto& p, const auto& q) {
            const double x = q[0] - p[0], y = q[1] - p[1], u = at[0] - p[0], v = at[1] - p[1];
            const double square = x * x + y * y;
            const double t = square > 0 ? std::clamp((u * x + v * y) / square, 0.0, 1.0) : 0.0;
            least = std::min(least, (u - t * x) * (u - t * x) + (v - t * y) * (v - t * y));
            if ((p[1] > at[1]) != (q[1] > at[1]) && u < x * v / y) inside = !inside;
        });
        return inside ? 0.0 : std::sqrt(least);
    }

    // Tell whether a point of the segment from ``a`` to ``b`` is inside or within ``near`` of a side
    bool meets(const double* a, const double* b, double near) const {
        if (away(a) <= near || away(b) <= near) return true;
        FlatPatch segment{{{a[0], a[1]}, {b[0], b[1]}}, {2}};
        if (std::ranges::any_of(corners, [&](const auto& corner) { return segment.away(corner.data()) <= near; }))
            return true;
        bool crossed = false;
        const auto left = [](const double* p, const double* q, const double* r) {
            return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0;
        };
        each_side([&](const auto& p, const auto& q) {
            crossed = crossed || (left(a, b, p.data()) != left(a, b, q.data()) &&
                                  left(p.data(), q.data(), a) != left(p.data(), q.data(), b));
        });
        return crossed;
    }

    // Tell whether each point of the segment from ``a`` to ``b`` is inside or within ``near`` of a side
    bool holds(const double* a, const double* b, double near) const {
        const double run[] = {b[0] - a[0], b[1] - a[1]};
        const double length = std::hypot(run[0], run[1]);
        if (!(length > 0)) return away(a) <= near;
        const double along[] = {run[0] / length, run[1] / length};
        std::vector<std::pair<double, double>> held;  // from and to, along the segment
        std::vector<double> crossings{0.0, length};
        each_side([&](const auto& p, const auto& q) {
            const double side[] = {q[0] - p[0], q[1] - p[1]}, whole = std::hypot(side[0], side[1]);
            std::pair<double, double> span{std::numeric_limits<double>::infinity(), 0};
            span.second = -span.first;
            const auto add = [&](double from, double to) {
                span.first = std::min(span.first, from);
                span.second = std::max(span.second, to);
            };
            for (const auto& end : {p, q}) {  // within reach of an end
                const double u = end[0] - a[0], v = end[1] - a[1];
                const double at = u * along[0] + v * along[1], off = u * along[1] - v * along[0];
                if (std::abs(off) > near) continue;
                const double half = std::sqrt(near * near - off * off);
                add(at - half, at + half);
            }
            if (whole > 0) {  // beside the side
                const double x = side[0] / whole, y = side[1] / whole, u = a[0] - p[0], v = a[1] - p[1];
                double from = -std::numeric_limits<double>::infinity(), to = -from;
                const auto keep = [&](double start, double slope, double least, double most) {
                    if (slope == 0) {
                        if (start < least || start > most) to = from;
                        return;
                    }
                    const auto [one, other] = std::minmax({(least - start) / slope, (most - start) / slope});
                    from = std::max(from, one);
                    to = std::min(to, other);
                };
                keep(u * x + v * y, along[0] * x + along[1] * y, 0.0, whole);
                keep(v * x - u * y, along[1] * x - along[0] * y, -near, near);
                if (from < to) add(from, to);
            }
            if (span.first < span.second) held.push_back(span);
            const double turn = along[0] * side[1] - along[1] * side[0];
            if (turn != 0) {
                const double at = ((p[0] - a[0]) * side[1] - (p[1] - a[1]) * side[0]) / turn;
                if (at > 0 && at < length) crossings.push_back(at);
            }
        });
        std::sort(crossings.begin(), crossings.end());
        for (std::size_t i = 1; i < crossings.size(); ++i) {
            const double at = (crossings[i - 1] + crossings[i]) / 2;
            const double middle[] = {a[0] + at * along[0], a[1] + at * along[1]};
            if (away(middle) == 0) held.push_back({crossings[i - 1], crossings[i]});
        }
        std::sort(held.begin(), held.end());
        double upto = 0;
        for (const auto& [from, to] : held) {
            if (from > upto) break;
            upto = std::max(upto, to);
        }
        return upto >= length;
    }
};

// Patches as Python hands them over. Patch k has the normal ``facing[k]`` and the unit tangents ``frames[k]``, and the
// rings from ``rings[k - 1]`` up to, not including, ``rings[k]``; ring i has the ``corners`` from ``stops[i - 1]`` up
// to, not including, ``stops[i]``.
struct Patches {
    InMat corners;
    InInts stops, rings;
    InMat facing;
    InTen frames;

    Int start_of(Int k) const {
        const Int first = k > 0 ? rings[k - 1] : 0;
        return first > 0 ? stops[first - 1] : 0;
    }

    // Write where a point is in the frame of patch k; return its height over it
    double seen(Int k, In point, double* at) const {
        const In origin = corners[start_of(k)];
        const double arm[] = {point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]};
        for (Int m = 0; m < 2; ++m) {
            at[m] = arm[0] * frames(k, m, 0) + arm[1] * frames(k, m, 1) + arm[2] * frames(k, m, 2);
        }
        return arm[0] * facing(k, 0) + arm[1] * facing(k, 1) + arm[2] * facing(k, 2);
    }

    FlatPatch flat(Int k) const {
        FlatPatch patch;
        const Int start = start_of(k);
        for (Int ring = k > 0 ? rings[k - 1] : 0; ring < rings[k]; ++ring) {
            for (Int i = ring > 0 ? stops[ring - 1] : 0; i < stops[ring]; ++i) {
                std::array<double, 2> at;
                seen(k, corners[i], at.data());
                for (int m = 0; m < 2; ++m) {
                    patch.low[m] = std::min(patch.low[m], at[m]);
                    patch.high[m] = std::max(patch.high[m], at[m]);
                }
                patch.corners.push_back(at);
            }
            patch.ends.push_back(stops[ring] - start);
        }
        return patch;
    }
};

// What ``covered`` finds: 1 for each feature that is covered, and pairs (m, 2) of other features and patches that may
// cover them
struct Covered {
    Array<unsigned char> marks;
    Array<Int, 2> open;
};

// Tell which features with ``ends`` (n, 2, 3) and ``normals`` (n, 3) lie on patches, up to ``gap`` [m]; the cosine of
// the angle between both normals is ``alike`` (n,) or more
inline Covered covered(InTen ends, InMat normals, In alike, const Patches& patches, double gap) {
    Covered found{Array<unsigned char>({ends.size()}), Array<Int, 2>({0, 2})};
    for (Int k = 0; k < patches.rings.size(); ++k) {
        const FlatPatch patch = patches.flat(k);
        for (Int i = 0; i < ends.size(); ++i) {
            if (found.marks.numbers[i] || !(dot3(normals[i], patches.facing[k]) >= alike[i])) continue;
            double at[2][2];
            bool near = true;
            for (Int end = 0; near && end < 2; ++end) {
                near = std::abs(patches.seen(k, ends[i][end], at[end])) <= 2 * gap;
                for (int m = 0; near && m < 2; ++m) {
                    near = at[end][m] >= patch.low[m] - gap && at[end][m] <= patch.high[m] + gap;
                }
                near = near && patch.away(at[end]) <= gap;
            }
            if (!near) continue;
            const bool point = at[0][0] == at[1][0] && at[0][1] == at[1][1];
            if (point || patch.holds(at[0], at[1], DRAWN * gap)) {
                found.marks.numbers[i] = 1;
            } else {
                found.open.numbers.insert(found.open.numbers.end(), {i, k});
                ++found.open.sizes[0];
            }
        }
    }
    return found;
}

// The numbers of the patches that may cover a part of the line between ``ends`` (2, 3) with a ``normal`` (3,), as in
// ``covered``
inline Array<Int> patches_along(InMat ends, In normal, double alike, const Patches& patches, double gap) {
    Array<Int> found({0});
    for (Int k = 0; k < patches.rings.size(); ++k) {
        double at[2][2];
        if (!(dot3(normal, patches.facing[k]) >= alike)) continue;
        double height[2];
        for (Int end = 0; end < 2; ++end) height[end] = std::abs(patches.seen(k, ends[end], at[end]));
        if (std::min(height[0], height[1]) > 2 * gap) continue;
        const FlatPatch patch = patches.flat(k);
        bool apart = false;
        for (int m = 0; m < 2; ++m) {
            apart = apart || std::max(at[0][m], at[1][m]) < patch.low[m] - gap;
            apart = apart || std::min(at[0][m], at[1][m]) > patch.high[m] + gap;
        }
        if (!apart && patch.meets(at[0], at[1], gap)) found.numbers.push_back(k);
    }
    found.sizes[0] = std::ssize(found.numbers);
    return found;
}

}  // namespace holdfast
