// The edges of a triangle surface, the angles at them, and what is connected across them.

#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr double FLAT = 1e-3;   // [rad] a smaller angle between two faces is rounding, not an edge
constexpr double SMOOTH = 0.6;  // [rad] an edge with a smaller angle is smooth: its faces represent a curved surface

// The E edges of F triangles; ``geometry/triangles.py`` says what each array is
struct Edges {
    Array<Int, 2> ends, of_face;
    Array<Int> shared, sides, first;
};

inline Edges edges_of(InIntMat faces) {
    const Int count = faces.size();
    struct Side {
        Int high, number;  // its end with the higher number
        auto operator<=>(const Side&) const = default;
    };
    Int vertices = 0;
    for (Int f = 0; f < count; ++f) vertices = std::max({vertices, faces(f, 0) + 1, faces(f, 1) + 1, faces(f, 2) + 1});
    std::vector<Int> starts(static_cast<std::size_t>(vertices + 1));  // of those whose other end is each vertex
    const auto each_side = [&](const auto& take) {
        for (Int f = 0; f < count; ++f) {
            for (Int k = 0; k < 3; ++k) {
                const auto [low, high] = std::minmax({faces(f, k), faces(f, (k + 1) % 3)});
                take(low, Side{high, 3 * f + k});
            }
        }
    };
    each_side([&](Int low, const Side&) { ++starts[low + 1]; });
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<Side> found(static_cast<std::size_t>(3 * count));
    std::vector<Int> next(starts);
    each_side([&](Int low, const Side& side) { found[next[low]++] = side; });
    Int edges = 0;
    for (Int v = 0; v < vertices; ++v) {
        std::sort(found.begin() + starts[v], found.begin() + starts[v + 1]);
        for (Int i = starts[v]; i < starts[v + 1]; ++i) edges += i == starts[v] || found[i].high != found[i - 1].high;
    }
    Edges e{Array<Int, 2>({edges, 2}), Array<Int, 2>({count, 3}), Array<Int>({edges}), Array<Int>({3 * count}),
            Array<Int>({edges})};
    Int at = -1;
    for (Int v = 0; v < vertices; ++v) {
        for (Int i = starts[v]; i < starts[v + 1]; ++i) {
            if (i == starts[v] || found[i].high != found[i - 1].high) {
                ++at;
                e.ends.view()(at, 0) = v;
                e.ends.view()(at, 1) = found[i].high;
                e.first.view()[at] = i;
            }
            e.shared.view()[at] += 1;
            e.sides.numbers[i] = found[i].number;
            e.of_face.numbers[found[i].number] = at;
        }
    }
    return e;
}

// The two faces (E, 2) at each edge, -1 if there is none
inline Array<Int, 2> faces_beside(const Edges& e) {
    Array<Int, 2> found({e.ends.sizes[0], 2}, -1);
    for (Int i = 0; i < found.sizes[0]; ++i) {
        for (Int k = 0; k < std::min<Int>(e.shared.view()[i], 2); ++k) {
            found.view()(i, k) = e.sides.view()[e.first.view()[i] + k] / 3;
        }
    }
    return found;
}

// The angle (E,) between the unit ``normals`` (F, 3) of the two faces at each edge, positive at a convex edge, and
// infinite at the rim of an open surface
inline Array<double> bends(InMat vertices, InIntMat faces, InMat normals, InIntMat beside) {
    Array<double> found({beside.size()}, std::numeric_limits<double>::infinity());
    for (Int i = 0; i < beside.size(); ++i) {
        const Int one = beside(i, 0), other = beside(i, 1);
        if (other < 0) continue;
        const auto n = normals[one], m = normals[other];
        const double cosine = std::clamp(0.0 + n[0] * m[0] + n[1] * m[1] + n[2] * m[2], -1.0, 1.0);
        const double x = n[1] * m[2] - n[2] * m[1], y = n[2] * m[0] - n[0] * m[2], z = n[0] * m[1] - n[1] * m[0];
        const auto p = vertices[faces(one, 0)], a = vertices[faces(other, 0)];
        const auto b = vertices[faces(other, 1)], c = vertices[faces(other, 2)];
        double away = 0;
        for (int k = 0; k < 3; ++k) away += (a[k] + b[k] + c[k] - 3 * p[k]) * n[k];
        found.view()[i] = (away <= 0 ? 1.0 : -1.0) * std::atan2(std::sqrt(x * x + y * y + z * z), cosine);
    }
    return found;
}

// The vertices that are joined to vertex v are neighbours[starts[v]] to neighbours[starts[v + 1] - 1]
inline std::pair<Array<Int>, Array<Int>> neighbours_of(InIntMat ends, Int vertices) {
    Array<Int> starts({vertices + 1}), found({2 * ends.size()});
    auto first = starts.view(), into = found.view();
    for (Int i = 0; i < ends.size(); ++i) {
        for (int k = 0; k < 2; ++k) ++first[ends(i, k) + 1];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Int> next(starts.numbers.begin(), starts.numbers.end());
    for (int k = 0; k < 2; ++k) {
        for (Int i = 0; i < ends.size(); ++i) into[next[static_cast<std::size_t>(ends(i, k))]++] = ends(i, 1 - k);
    }
    return {std::move(starts), std::move(found)};
}

// The number of the region (F,) of each of ``count`` faces, in the order of their first faces; ``beside`` (E, 2) are
// the faces at an edge, and those at an edge that bends by at most ``angle`` are in one region
inline Array<Int> regions_of(InIntMat beside, In bend, double angle, Int count) {
    std::vector<Int> root(static_cast<std::size_t>(count));
    std::iota(root.begin(), root.end(), Int{0});
    const auto of = [&](Int face) {
        while (root[face] != face) face = root[face] = root[root[face]];
        return face;
    };
    for (Int i = 0; i < beside.size(); ++i) {
        if (!(std::abs(bend[i]) <= angle)) continue;
        const auto [low, high] = std::minmax({of(beside(i, 0)), of(beside(i, 1))});
        root[high] = low;
    }
    Array<Int> found({count});
    Int regions = 0;
    for (Int face = 0; face < count; ++face) {
        const Int first = of(face);  // the first face of its region: roots are the least
        found.view()[face] = first == face ? regions++ : found.view()[first];
    }
    return found;
}

}  // namespace holdfast
