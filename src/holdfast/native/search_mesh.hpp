// The surface of a body prepared for the contact search, and the search for pairs of nearby boxes.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "span.hpp"
#include "topology.hpp"

namespace holdfast {

constexpr double LARGE_BOX = 8;  // [medians] longer boxes are searched separately, as they would widen the search
                                 // window of all others

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

// What ``SearchMesh.of`` computes of a surface in its pose
struct Prepared {
    Array<double, 3> triangles;
    Array<double, 2> low, high, box, mean;
    Array<double, 3> outward;
};

// The unit directions (F, 3, 3) in the plane of each face across its k-th edge, away from it
inline Array<double, 3> outward_of(InMat vertices, InIntMat faces, InMat normals) {
    Array<double, 3> found({faces.size(), 3, 3});
    double* out = found.numbers.data();
    for (Int f = 0; f < faces.size(); ++f) {
        const auto n = normals[f];
        for (Int k = 0; k < 3; ++k, out += 3) {
            const auto p = vertices[faces(f, k)], q = vertices[faces(f, (k + 1) % 3)];
            const double u[] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
            out[0] = u[1] * n[2] - u[2] * n[1];
            out[1] = u[2] * n[0] - u[0] * n[2];
            out[2] = u[0] * n[1] - u[1] * n[0];
            const double length = std::max(std::sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]), 1e-300);
            for (int m = 0; m < 3; ++m) out[m] /= length;
        }
    }
    return found;
}

// The mean normal (V, 3) of the faces at each of ``count`` vertices; zero at the ends of sharp edges and rims
inline Array<double, 2> smooth_normals(Int count, InIntMat faces, InMat normals, InIntMat ends, In bend) {
    Array<double, 2> found({count, 3});
    const auto mean = found.view();
    for (Int corner = 0; corner < 3; ++corner) {
        for (Int f = 0; f < faces.size(); ++f) {
            for (Int k = 0; k < 3; ++k) mean(faces(f, corner), k) += normals(f, k);
        }
    }
    for (Int i = 0; i < ends.size(); ++i) {
        if (bend[i] < SMOOTH) continue;
        for (Int k = 0; k < 3; ++k) mean(ends(i, 0), k) = mean(ends(i, 1), k) = 0;
    }
    for (Int v = 0; v < count; ++v) {
        const auto n = mean[v];
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (Int k = 0; k < 3; ++k) n[k] = length > 0.1 ? n[k] / length : 0.0;
    }
    return found;
}

// Prepare ``faces`` (F, 3) over ``vertices`` (V, 3) with unit ``normals`` (F, 3), and edges between ``ends`` (E, 2)
// that
// ``bend`` (E,)
inline Prepared prepared(InMat vertices, InIntMat faces, InMat normals, InIntMat ends, In bend) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    const Int count = faces.size();
    Prepared p{Array<double, 3>({count, 3, 3}),
               Array<double, 2>({count, 3}),
               Array<double, 2>({count, 3}),
               Array<double, 2>({2, 3}),
               smooth_normals(vertices.size(), faces, normals, ends, bend),
               outward_of(vertices, faces, normals)};
    const auto triangles = p.triangles.view();
    const auto low = p.low.view(), high = p.high.view(), box = p.box.view();
    box[0].fill(inf);
    box[1].fill(-inf);
    for (Int f = 0; f < count; ++f) {
        low[f].fill(inf);
        high[f].fill(-inf);
        for (Int corner = 0; corner < 3; ++corner) {
            const Int v = faces(f, corner);
            for (Int k = 0; k < 3; ++k) {
                triangles(f, corner, k) = vertices(v, k);
                low(f, k) = std::min(low(f, k), vertices(v, k));
                high(f, k) = std::max(high(f, k), vertices(v, k));
            }
        }
        for (Int k = 0; k < 3; ++k) {
            box(0, k) = std::min(box(0, k), low(f, k));
            box(1, k) = std::max(box(1, k), high(f, k));
        }
    }
    return p;
}

// Boxes by their corners, low and high (n, 3) [m]
struct Boxes {
    InMat low, high;
};

// Find the pairs of boxes within ``gap`` [m] of each other, among ``in_a`` and ``in_b``, which is sorted by ``low``
// along ``axis``; tell ``take`` of each
template <class Take>
void each_near(const Boxes& a, const std::vector<Int>& in_a, const Boxes& b, const std::vector<Int>& in_b, Int axis,
               double gap, const Take& take) {
    std::vector<double> starts;
    double widest = 0.0;
    for (Int j : in_b) {
        starts.push_back(b.low(j, axis));
        widest = std::max(widest, b.high(j, axis) - b.low(j, axis));
    }
    for (Int i : in_a) {
        const double low[3] = {a.low(i, 0) - gap, a.low(i, 1) - gap, a.low(i, 2) - gap};
        const double high[3] = {a.high(i, 0) + gap, a.high(i, 1) + gap, a.high(i, 2) + gap};
        const auto first = std::lower_bound(starts.begin(), starts.end(), a.low(i, axis) - widest - gap);
        for (auto at = static_cast<std::size_t>(first - starts.begin()); at < starts.size(); ++at) {
            if (starts[at] > high[axis]) break;
            const In from = b.low[in_b[at]], to = b.high[in_b[at]];
            bool near = true;
            for (int k = 0; k < 3; ++k) near = near && !(from[k] > high[k] || to[k] < low[k]);
            if (near) take(i, in_b[at]);
        }
    }
}

// The pairs (m, 2) of boxes within ``gap`` [m] of each other; those of b are sorted by ``low`` along ``axis``
inline Array<Int, 2> near_boxes(const Boxes& a, const Boxes& b, Int axis, double gap) {
    std::vector<Int> in_a(static_cast<std::size_t>(a.low.size())), in_b(static_cast<std::size_t>(b.low.size()));
    std::iota(in_a.begin(), in_a.end(), Int{0});
    std::iota(in_b.begin(), in_b.end(), Int{0});
    Array<Int, 2> found({0, 2});
    each_near(a, in_a, b, in_b, axis, gap, [&](Int i, Int j) { found.numbers.insert(found.numbers.end(), {i, j}); });
    found.sizes[0] = static_cast<Int>(found.numbers.size()) / 2;
    return found;
}

// The pairs (m, 2) of faces of a and b whose boxes come within ``gap`` [m]: only those of large flat faces ``facet_a``
// and ``facet_b``, where these are not -1, and with ``but_facets`` no pairs in which both belong to large flat faces
inline Array<Int, 2> near_faces(const SearchMesh& a, const SearchMesh& b, double gap, Int facet_a, Int facet_b,
                                bool but_facets) {
    Array<Int, 2> found({0, 2});
    double low[3], high[3];  // the intersection of the boxes of both bodies, widened by the gap
    for (int k = 0; k < 3; ++k) {
        low[k] = std::max(a.box(0, k), b.box(0, k)) - gap;
        high[k] = std::min(a.box(1, k), b.box(1, k)) + gap;
    }
    Int axis = 0;
    for (int k = 1; k < 3; ++k) {
        if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    }
    const auto inside = [&](const SearchMesh& mesh, Int facet) {
        std::vector<Int> faces;
        for (Int f = 0; f < mesh.low.size(); ++f) {
            if (facet >= 0 && mesh.facet[f] != facet) continue;
            const In from = mesh.low[f], to = mesh.high[f];
            bool in = true;
            for (int k = 0; k < 3; ++k) in = in && to[k] >= low[k] && from[k] <= high[k];
            if (in) faces.push_back(f);
        }
        return faces;
    };
    const std::vector<Int> in_a = inside(a, facet_a);
    std::vector<Int> in_b = inside(b, facet_b);
    if (in_a.empty() || in_b.empty()) return found;
    std::stable_sort(in_b.begin(), in_b.end(), [&](Int i, Int j) { return b.low(i, axis) < b.low(j, axis); });
    std::vector<double> lengths;
    for (Int j : in_b) lengths.push_back(b.high(j, axis) - b.low(j, axis));
    const auto middle = lengths.begin() + std::ssize(lengths) / 2;
    std::nth_element(lengths.begin(), middle, lengths.end());
    double median = *middle;
    if (lengths.size() % 2 == 0) median = (*std::max_element(lengths.begin(), middle) + median) / 2;
    const Boxes of_a{a.low, a.high}, of_b{b.low, b.high};
    for (const bool large : {false, true}) {
        std::vector<Int> part;
        for (Int j : in_b) {
            if ((b.high(j, axis) - b.low(j, axis) > LARGE_BOX * median) == large) part.push_back(j);
        }
        each_near(of_a, in_a, of_b, part, axis, gap, [&](Int i, Int j) {
            if (but_facets && a.facet[i] >= 0 && b.facet[j] >= 0) return;
            found.numbers.insert(found.numbers.end(), {i, j});
        });
    }
    found.sizes[0] = static_cast<Int>(found.numbers.size()) / 2;
    return found;
}

}  // namespace holdfast
