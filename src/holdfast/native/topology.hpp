// The edges of a triangle surface, the angles at them, and what is connected across them.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "span.hpp"

namespace holdfast {

// The E edges of F triangles; ``geometry/topology.py`` says what each array is
struct Edges {
    Array<Int, 2> ends, of_face;
    Array<Int> shared, sides, first;
};

inline Edges edges_of(InIntMat faces) {
    const Int count = faces.size();
    std::vector<std::pair<std::pair<Int, Int>, Int>> found;  // ends, and a side that runs along them
    found.reserve(static_cast<std::size_t>(3 * count));
    for (Int f = 0; f < count; ++f) {
        for (Int k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(faces(f, k), faces(f, (k + 1) % 3));
            found.push_back({{low, high}, 3 * f + k});
        }
    }
    std::sort(found.begin(), found.end());
    Int edges = 0;
    for (std::size_t i = 0; i < found.size(); ++i) edges += i == 0 || found[i].first != found[i - 1].first;
    Edges e{Array<Int, 2>({edges, 2}), Array<Int, 2>({count, 3}), Array<Int>({edges}), Array<Int>({3 * count}),
            Array<Int>({edges})};
    Int at = -1;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const auto& [ends, side] = found[i];
        if (i == 0 || ends != found[i - 1].first) {
            ++at;
            e.ends.view()(at, 0) = ends.first;
            e.ends.view()(at, 1) = ends.second;
            e.first.view()[at] = static_cast<Int>(i);
        }
        e.shared.view()[at] += 1;
        e.sides.numbers[i] = side;
        e.of_face.numbers[static_cast<std::size_t>(side)] = at;
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
