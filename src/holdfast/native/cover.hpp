// Which touching features lie on patches that were found before.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "search_mesh.hpp"
#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

// From and to, along a segment [m]
using Stretch = std::pair<double, double>;

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

    // Tell whether a point is inside or within ``near`` of a side; a line has no inside
    bool covers(const double* at, double near) const {
        bool inside = false, beside = false;
        each_side([&](const auto& p, const auto& q) {
            if (std::max(p[1], q[1]) < at[1] - near || std::min(p[1], q[1]) > at[1] + near) return;
            const double x = q[0] - p[0], y = q[1] - p[1], u = at[0] - p[0], v = at[1] - p[1];
            if ((p[1] > at[1]) != (q[1] > at[1]) && u < x * v / y) inside = !inside;
            const double square = x * x + y * y;
            const double t = square > 0 ? std::clamp((u * x + v * y) / square, 0.0, 1.0) : 0.0;
            beside = beside || std::hypot(u - t * x, v - t * y) <= near;
        });
        return beside || (inside && corners.size() > 2);
    }

    // The parts of the segment from ``a`` to ``b`` [m] that are inside or within ``near`` of a side, which may overlap.
    // All that is within a distance of a side is convex: what a line has of it is one part.
    std::vector<Stretch> covered(const double* a, const double* b, double near) const {
        const double run[] = {b[0] - a[0], b[1] - a[1]};
        const double length = std::hypot(run[0], run[1]);
        std::vector<Stretch> found;
        if (!(length > 0)) {
            if (covers(a, near)) found.push_back({0.0, 0.0});
            return found;
        }
        const double along[] = {run[0] / length, run[1] / length};
        std::vector<double> crossings{0.0, length};
        each_side([&](const auto& p, const auto& q) {
            for (int m = 0; m < 2; ++m) {
                if (std::max(p[m], q[m]) < std::min(a[m], b[m]) - near) return;
                if (std::min(p[m], q[m]) > std::max(a[m], b[m]) + near) return;
            }
            const double side[] = {q[0] - p[0], q[1] - p[1]}, whole = std::hypot(side[0], side[1]);
            Stretch span{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
            const auto add = [&](double from, double to) {
                span = {std::min(span.first, from), std::max(span.second, to)};
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
            if (span.first <= span.second) found.push_back(span);
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
            if (covers(middle, 0)) found.push_back({crossings[i - 1], crossings[i]});
        }
        return found;
    }
};

// What a line of this ``length`` [m] has beside parts of it that are covered; gaps up to ``slack`` [m] do not count
inline std::vector<Stretch> uncovered(std::vector<Stretch> parts, double length, double slack) {
    std::sort(parts.begin(), parts.end());
    std::vector<Stretch> left;
    double upto = 0;
    for (const auto& [from, to] : parts) {
        if (from > upto + slack) left.push_back({upto, std::min(from, length)});
        upto = std::max(upto, to);
    }
    if (length > upto + slack) left.push_back({upto, length});
    return left;
}

// Patches that cover features: as ``Cover`` in contacts/patches.py
struct Cover {
    double gap;
    std::vector<FlatPatch> flats;
    Array<double, 2> origins, facing, low, high;
    Array<double, 3> frames;

    // Patch k has the normal ``normals[k]`` and the unit ``tangents[k]``, and the rings from ``rings[k - 1]`` up to,
    // not including, ``rings[k]``; ring i has the ``corners`` from ``stops[i - 1]`` up to, not including, ``stops[i]``.
    Cover(InMat corners, InInts stops, InInts rings, InMat normals, InTen tangents, double within)
        : gap(within),
          flats(static_cast<std::size_t>(rings.size())),
          origins({rings.size(), 3}),
          facing({rings.size(), 3}),
          low({rings.size(), 3}, std::numeric_limits<double>::infinity()),
          high({rings.size(), 3}, -std::numeric_limits<double>::infinity()),
          frames({rings.size(), 2, 3}) {
        Int ring = 0, corner = 0;
        for (Int k = 0; k < rings.size(); ++k) {
            for (int m = 0; m < 3; ++m) {
                origins.view()(k, m) = corners(corner, m);
                facing.view()(k, m) = normals(k, m);
                for (Int t = 0; t < 2; ++t) frames.view()(k, t, m) = tangents(k, t, m);
                for (Int i = corner; i < stops[ring]; ++i) {
                    low.view()(k, m) = std::min(low.view()(k, m), corners(i, m));
                    high.view()(k, m) = std::max(high.view()(k, m), corners(i, m));
                }
            }
            FlatPatch& flat = flats[k];
            for (; ring < rings[k]; ++ring) {
                for (; corner < stops[ring]; ++corner) {
                    std::array<double, 2> at;
                    seen(k, corners[corner], at.data());
                    for (int m = 0; m < 2; ++m) {
                        flat.low[m] = std::min(flat.low[m], at[m]);
                        flat.high[m] = std::max(flat.high[m], at[m]);
                    }
                    flat.corners.push_back(at);
                }
                flat.ends.push_back(std::ssize(flat.corners));
            }
        }
    }

    // Write where a point is in the frame of patch k; return its height over it
    double seen(Int k, In point, double* at) const {
        const In origin = origins.view()[k], normal = facing.view()[k];
        const auto frame = frames.view()[k];
        const double arm[] = {point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]};
        for (Int m = 0; m < 2; ++m) at[m] = arm[0] * frame(m, 0) + arm[1] * frame(m, 1) + arm[2] * frame(m, 2);
        return arm[0] * normal[0] + arm[1] * normal[1] + arm[2] * normal[2];
    }

    // Which features with ``ends`` (n, 2, 3) and ``normals`` (n, 3) lie on one of the patches, up to the gap, as 1; the
    // cosine of the angle between both normals is ``alike`` (n,) or more
    Array<unsigned char> covered(InTen ends, InMat normals, In alike) const {
        const Int count = ends.size();
        Array<unsigned char> marks({count});
        Array<double, 2> from({count, 3}), to({count, 3});
        double least[3], most[3];
        std::fill_n(least, 3, std::numeric_limits<double>::infinity());
        std::fill_n(most, 3, -std::numeric_limits<double>::infinity());
        for (Int i = 0; i < count; ++i) {
            for (int m = 0; m < 3; ++m) {
                const auto [one, other] = std::minmax(ends(i, 0, m), ends(i, 1, m));
                from.view()(i, m) = one;
                to.view()(i, m) = other;
                least[m] = std::min(least[m], one);
                most[m] = std::max(most[m], one);
            }
        }
        Int axis = 0;
        for (int m = 1; m < 3; ++m) {
            if (most[m] - least[m] > most[axis] - least[axis]) axis = m;
        }
        std::vector<Int> order(static_cast<std::size_t>(count)), numbers(flats.size());
        std::iota(order.begin(), order.end(), Int{0});
        std::iota(numbers.begin(), numbers.end(), Int{0});
        const InMat starts = std::as_const(from).view();
        std::stable_sort(order.begin(), order.end(), [&](Int i, Int j) { return starts(i, axis) < starts(j, axis); });
        const Boxes patches{low.view(), high.view()}, features{starts, std::as_const(to).view()};
        each_near(patches, numbers, features, order, axis, 3 * gap, [&](Int k, Int i) {
            if (marks.numbers[i] || !(dot3(normals[i], facing.view()[k]) >= alike[i])) return;
            const FlatPatch& patch = flats[k];
            double at[2][2];
            for (Int end = 0; end < 2; ++end) {
                if (!(std::abs(seen(k, ends[i][end], at[end])) <= 2 * gap)) return;
                for (int m = 0; m < 2; ++m) {
                    if (!(at[end][m] >= patch.low[m] - gap && at[end][m] <= patch.high[m] + gap)) return;
                }
            }
            const double length = std::hypot(at[1][0] - at[0][0], at[1][1] - at[0][1]);
            const auto parts = patch.covered(at[0], at[1], gap);
            if (!parts.empty() && uncovered(parts, length, 0.0).empty()) marks.numbers[i] = 1;
        });
        return marks;
    }

    // The parts of the line between ``ends`` (2, 3) with a ``normal`` (3,) that lie on none of the patches, as shares
    // (n, 2) of it; up to ``slack`` [m] between two patches does not count
    Array<double, 2> left(InMat ends, In normal, double alike, double slack) const {
        std::vector<Stretch> parts;
        double square = 0;
        for (int m = 0; m < 3; ++m) square += (ends(1, m) - ends(0, m)) * (ends(1, m) - ends(0, m));
        const double length = std::sqrt(square);
        for (Int k = 0; k < std::ssize(flats); ++k) {
            if (!(dot3(normal, facing.view()[k]) >= alike)) continue;
            double at[2][2], height[2];
            for (Int end = 0; end < 2; ++end) height[end] = std::abs(seen(k, ends[end], at[end]));
            if (std::min(height[0], height[1]) > 2 * gap) continue;
            const FlatPatch& patch = flats[k];
            bool apart = false;
            for (int m = 0; m < 2; ++m) {
                apart = apart || std::max(at[0][m], at[1][m]) < patch.low[m] - gap;
                apart = apart || std::min(at[0][m], at[1][m]) > patch.high[m] + gap;
            }
            if (apart) continue;
            const double drawn = std::hypot(at[1][0] - at[0][0], at[1][1] - at[0][1]);
            const double scale = drawn > 0 ? length / drawn : 1.0;  // a line that leans is longer than it looks
            for (const auto& [from, to] : patch.covered(at[0], at[1], gap)) parts.push_back({scale * from, scale * to});
        }
        Array<double, 2> found({0, 2});
        for (const auto& [from, to] : uncovered(std::move(parts), length, slack)) {
            found.numbers.insert(found.numbers.end(), {from / length, to / length});
            ++found.sizes[0];
        }
        return found;
    }
};

}  // namespace holdfast
