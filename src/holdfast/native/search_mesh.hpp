// The surface of a body prepared for the contact search, and the search for pairs of nearby boxes.

#pragma once

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "span.hpp"

namespace holdfast {

// A triangle surface in the world; contacts/search_mesh.py says what the members are
struct SearchMesh {
    InMat vertices;
    InTen triangles;
    InMat normals, low, high, box;
    InIntMat faces, edges, sides;
    In bend;
    InIntMat of_face;
    InInts starts, neighbours;
    InMat mean;
    Span<const bool, 2> owns_vertex, owns_edge;
    InTen outward;
    InInts facet;
    Span<const bool> curved;
    static constexpr auto fields =
        std::tuple{&SearchMesh::vertices,   &SearchMesh::triangles, &SearchMesh::normals,     &SearchMesh::low,
                   &SearchMesh::high,       &SearchMesh::box,       &SearchMesh::faces,       &SearchMesh::edges,
                   &SearchMesh::sides,      &SearchMesh::bend,      &SearchMesh::of_face,     &SearchMesh::starts,
                   &SearchMesh::neighbours, &SearchMesh::mean,      &SearchMesh::owns_vertex, &SearchMesh::owns_edge,
                   &SearchMesh::outward,    &SearchMesh::facet,     &SearchMesh::curved};
};

// ``points`` (V, 3), rotated and shifted by ``pose`` (4, 4): the vertices (V, 3), the triangles (F, 3, 3) of ``faces``
// and their boxes, low and high (F, 3)
inline std::tuple<Array<double, 2>, Array<double, 3>, Array<double, 2>, Array<double, 2>> placed(InMat points,
                                                                                                 InIntMat faces,
                                                                                                 InMat pose) {
    Array<double, 2> vertices({points.size(), 3}), low({faces.size(), 3}), high({faces.size(), 3});
    Array<double, 3> triangles({faces.size(), 3, 3});
    double turn[3][3], shift[3];
    for (int k = 0; k < 3; ++k) {
        for (int m = 0; m < 3; ++m) turn[k][m] = pose(k, m);
        shift[k] = pose(k, 3);
    }
    for (Int v = 0; v < points.size(); ++v) {
        const double x = points(v, 0), y = points(v, 1), z = points(v, 2);
        double* const at = vertices.numbers.data() + 3 * v;
        for (int k = 0; k < 3; ++k) at[k] = shift[k] + turn[k][0] * x + turn[k][1] * y + turn[k][2] * z;
    }
    for (Int f = 0; f < faces.size(); ++f) {
        for (int k = 0; k < 3; ++k) {
            double least = std::numeric_limits<double>::infinity(), largest = -least;
            for (Int corner = 0; corner < 3; ++corner) {
                const double x = vertices.numbers[3 * faces(f, corner) + k];
                triangles.numbers[9 * f + 3 * corner + k] = x;
                least = std::min(least, x);
                largest = std::max(largest, x);
            }
            low.numbers[3 * f + k] = least;
            high.numbers[3 * f + k] = largest;
        }
    }
    return {std::move(vertices), std::move(triangles), std::move(low), std::move(high)};
}

// The pairs (m, 2) of boxes within ``gap`` [m] of each other, without those of which both are marked. ``low_b`` is
// sorted along ``axis``, and ``first`` (of a) is where the search for each box of a begins.
inline Array<Int, 2> near_boxes(InMat low_a, InMat high_a, InMat low_b, InMat high_b, InInts first, Int axis,
                                double gap, Span<const bool> marked_a, Span<const bool> marked_b) {
    Array<Int, 2> found({0, 2});
    for (Int i = 0; i < low_a.size(); ++i) {
        const double low[3] = {low_a(i, 0) - gap, low_a(i, 1) - gap, low_a(i, 2) - gap};
        const double high[3] = {high_a(i, 0) + gap, high_a(i, 1) + gap, high_a(i, 2) + gap};
        for (Int j = first[i]; j < low_b.size(); ++j) {
            const auto from = low_b[j], to = high_b[j];
            if (from[axis] > high[axis]) break;
            bool apart = marked_a[i] && marked_b[j];
            for (int k = 0; k < 3; ++k) apart = apart || from[k] > high[k] || to[k] < low[k];
            if (apart) continue;
            found.numbers.push_back(i);
            found.numbers.push_back(j);
        }
    }
    found.sizes[0] = static_cast<Int>(found.numbers.size()) / 2;
    return found;
}

}  // namespace holdfast
