// Patches in canonical form, which does not depend on how they were found, all in one go.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

#include "frame.hpp"
#include "polygon.hpp"
#include "snapped.hpp"
#include "span.hpp"

namespace holdfast {

constexpr int CANONICAL = 40;  // binary digits of the coordinates of a patch in canonical form, about twelve decimals
constexpr int FIRST = 30;      // binary digits of coordinates that decide at which corner an outline begins

// Patches. Patch f has the rings ``ring[f]`` to ``ring[f + 1]`` - 1, its outline first, and ring r the corners (n, 3)
// [m] from ``corner[r]`` to ``corner[r + 1]`` - 1. Those ``flipped`` (F,) are seen from the other body.
struct Patches {
    InMat corners;
    InInts corner, ring;
    InMat normal;
    Span<const bool> flipped;
    static constexpr auto fields =
        std::tuple{&Patches::corners, &Patches::corner, &Patches::ring, &Patches::normal, &Patches::flipped};
};

// The same patches: corners (n, 3), where rings begin, normals (F, 3), and integrals (F, 6) and centroids (F, 3) as
// those of a face (contacts/interface.py)
struct CanonicalPatches {
    std::vector<double> corners, normal, moments, centroid;
    std::vector<Int> corner{0};
};

// The integrals (6,) over a face of 1, x, y, x², xy, y² in the frame of its normal, about the first corner
inline std::array<double, 6> face_moments(InMat corners, InInts ring, const std::array<Axis, 3>& axes) {
    std::array<double, 6> moments{};
    std::vector<double> flat;
    const In origin = corners[ring[0]];
    for (Int r = 0; r + 1 < ring.size(); ++r) {
        flat.clear();
        for (Int i = ring[r]; i < ring[r + 1]; ++i) {
            const double x = corners(i, 0) - origin[0], y = corners(i, 1) - origin[1], z = corners(i, 2) - origin[2];
            for (int k = 0; k < 2; ++k) flat.push_back(x * axes[k][0] + y * axes[k][1] + z * axes[k][2]);
        }
        add_moments(InMat(flat.data(), {ring[r + 1] - ring[r], 2}), Vec(moments.data(), {6}));
    }
    return moments;
}

// The centroid of a face with these ``moments``
inline Axis face_centroid(In origin, const std::array<Axis, 3>& axes, const std::array<double, 6>& moments) {
    const double u = moments[1] / moments[0], v = moments[2] / moments[0];
    Axis found;
    for (int k = 0; k < 3; ++k) found[k] = origin[k] + (u * axes[0][k] + v * axes[1][k]);
    return found;
}

// Coordinates are rounded in the frame with this ``origin`` (3,) and these ``axes`` (3, 3), as rows. Each ring begins
// at its lowest corner there, and holes are in the order of these corners.
inline CanonicalPatches canonical(const Patches& all, In origin, InMat axes) {
    CanonicalPatches found;
    found.corners.reserve(static_cast<std::size_t>(3 * all.corners.size()));
    std::vector<Axis> seen, near;
    for (Int f = 0; f < all.normal.size(); ++f) {
        const Int begin = all.ring[f], end = all.ring[f + 1], first = all.corner[begin], last = all.corner[end];
        seen.clear();
        double size = 0.0;
        for (Int i = first; i < last; ++i) {
            const double x = all.corners(i, 0) - origin[0], y = all.corners(i, 1) - origin[1],
                         z = all.corners(i, 2) - origin[2];
            Axis& at = seen.emplace_back();
            for (int k = 0; k < 3; ++k) {
                at[k] = x * axes(k, 0) + y * axes(k, 1) + z * axes(k, 2);
                if (i < all.corner[begin + 1]) size = std::max(size, std::abs(at[k]));
            }
        }
        const double step = snapping_step(size, CANONICAL), coarse = snapping_step(size, FIRST);
        near.clear();
        for (Axis& at : seen) {
            Axis& rough = near.emplace_back();
            for (int k = 0; k < 3; ++k) {
                at[k] = snapped_number(at[k], step);
                rough[k] = snapped_number(at[k], coarse);
            }
        }
        struct Turned {
            Int from, to, start;
        };
        std::vector<Turned> rings;
        for (Int r = begin; r < end; ++r) {
            const Int from = all.corner[r] - first, to = all.corner[r + 1] - first;
            if (all.flipped[f]) {
                std::reverse(seen.begin() + from, seen.begin() + to);
                std::reverse(near.begin() + from, near.begin() + to);
            }
            Int start = from;
            for (Int i = from + 1; i < to; ++i) {
                if (near[i] < near[start]) start = i;
            }
            rings.push_back({from, to, start});
        }
        std::stable_sort(rings.begin() + 1, rings.end(),
                         [&](const Turned& a, const Turned& b) { return seen[a.start] < seen[b.start]; });
        const Int corner = static_cast<Int>(found.corner.size()) - 1;
        for (const auto& [from, to, start] : rings) {
            for (Int k = 0; k < to - from; ++k) {
                const Axis& at = seen[start + k < to ? start + k : start + k - (to - from)];
                for (int i = 0; i < 3; ++i) {
                    found.corners.push_back(origin[i] + (at[0] * axes(0, i) + at[1] * axes(1, i) + at[2] * axes(2, i)));
                }
            }
            found.corner.push_back(static_cast<Int>(found.corners.size()) / 3);
        }
        Axis own{}, normal{};
        const double sign = all.flipped[f] ? -1.0 : 1.0, unit = snapping_step(1.0, CANONICAL);
        const In n = all.normal[f];
        for (int k = 0; k < 3; ++k) {
            own[k] =
                snapped_number(sign * n[0] * axes(k, 0) + sign * n[1] * axes(k, 1) + sign * n[2] * axes(k, 2), unit);
        }
        for (int i = 0; i < 3; ++i) normal[i] = own[0] * axes(0, i) + own[1] * axes(1, i) + own[2] * axes(2, i);
        const double length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        for (double& each : normal) each /= length;
        found.normal.insert(found.normal.end(), normal.begin(), normal.end());
        const auto frame = frame_on(normal);
        const InMat corners(found.corners.data(), {static_cast<Int>(found.corners.size()) / 3, 3});
        const auto moments = face_moments(corners, InInts(found.corner.data() + corner, {end - begin + 1}), frame);
        const Axis centroid = face_centroid(corners[found.corner[corner]], frame, moments);
        found.moments.insert(found.moments.end(), moments.begin(), moments.end());
        found.centroid.insert(found.centroid.end(), centroid.begin(), centroid.end());
    }
    return found;
}

}  // namespace holdfast
