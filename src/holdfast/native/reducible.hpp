// Whether fewer triangles can represent a closed surface: what can be told without trying.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "span.hpp"

namespace holdfast {

// The corner of a triangle that is no end of one of its edges
inline Int third_corner(InInts corners, InInts ends) {
    Int k = 0;
    while (k < 2 && (corners[k] == ends[0] || corners[k] == ends[1])) ++k;
    return corners[k];
}

// Tell whether the closed surface of ``faces`` (F, 3) over ``vertices`` (V, 3) may keep its shape, up to ``tolerance``,
// without one of its corners. ``ends`` (E, 2) are its edges, ``beside`` (E, 2) the two faces at each, and ``of_face``
// (F, 3) the edge from the k-th corner of a face to the next one. False is certain.
//
// A corner is needless if its faces lie in one plane, or in two that meet in a straight edge. So each one is needed
// where all edges and triangles are wide and the faces at every corner belong to three or more regions, or to two that
// meet in a bent edge. Two faces beside an edge are in one region if all four corners may be within the tolerance of
// any plane.
inline bool may_lose_corners(InMat vertices, InIntMat faces, InIntMat ends, InIntMat beside, InIntMat of_face,
                             double tolerance) {
    const auto apart2 = [&](Int p, Int q) {
        double square = 0;
        for (int k = 0; k < 3; ++k) square += (vertices(q, k) - vertices(p, k)) * (vertices(q, k) - vertices(p, k));
        return square;
    };
    const double wide = 2 * tolerance;
    const Int count = faces.size();
    std::vector<std::array<double, 3>> vectors(static_cast<std::size_t>(count));  // across, twice the area long
    std::vector<double> twice(vectors.size());
    for (Int f = 0; f < count; ++f) {
        const auto a = vertices[faces(f, 0)], b = vertices[faces(f, 1)], c = vertices[faces(f, 2)];
        const double u[] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        const std::array<double, 3> n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        vectors[f] = n;
        twice[f] = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        const double longest = std::sqrt(std::max(
            {apart2(faces(f, 0), faces(f, 1)), apart2(faces(f, 1), faces(f, 2)), apart2(faces(f, 2), faces(f, 0))}));
        if (!(twice[f] > wide * longest)) return true;  // this bounds the shortest edge, too
    }
    std::vector<Int> root(vectors.size());
    std::iota(root.begin(), root.end(), Int{0});
    const auto of = [&](Int face) {
        while (root[face] != face) face = root[face] = root[root[face]];
        return face;
    };
    for (Int i = 0; i < ends.size(); ++i) {
        if (beside(i, 0) < 0 || beside(i, 1) < 0) return true;
        // the corner of the smaller triangle is near a sum of the corners of the larger one, with these weights
        const Int large = twice[beside(i, 0)] >= twice[beside(i, 1)] ? beside(i, 0) : beside(i, 1);
        const Int small = beside(i, 0) + beside(i, 1) - large;
        const Int p = third_corner(faces[large], ends[i]), q = third_corner(faces[small], ends[i]);
        double height = 0, along_p = 0, along_q = 0, square = 0;
        for (int k = 0; k < 3; ++k) {
            const double from = vertices(ends(i, 0), k), run = vertices(ends(i, 1), k) - from;
            height += (vertices(q, k) - from) * vectors[large][k];
            along_p += (vertices(p, k) - from) * run;
            along_q += (vertices(q, k) - from) * run;
            square += run * run;
        }
        const double of_p = -twice[small] / twice[large], of_end = (along_q - of_p * along_p) / square;
        const double weights = std::abs(of_p) + std::abs(of_end) + std::abs(1 - of_p - of_end);
        if (!(std::abs(height) > wide * (1 + weights) * twice[large])) {
            const auto [low, high] = std::minmax({of(large), of(small)});
            root[high] = low;
        }
    }
    // a corner where several fans of faces meet counts as needless: it may be one corner for each of them
    Array<Int> degrees({vertices.size()}), starts({vertices.size()}, -1);
    const auto degree = degrees.view(), start = starts.view();
    for (Int f = 0; f < count; ++f) {
        for (Int k = 0; k < 3; ++k) {
            ++degree[faces(f, k)];
            start[faces(f, k)] = f;
        }
    }
    for (Int v = 0; v < vertices.size(); ++v) {
        if (start[v] < 0) return true;
        std::array<Int, 2> found{-1, -1};  // the ends of the first two edges between regions
        Int face = start[v], edge = -1, steps = 0, between = 0;
        bool several = false;  // more than two regions
        Int regions[] = {of(face), -1};
        do {
            Int k = 0;
            while (k < 2 && faces(face, k) != v) ++k;
            edge = of_face(face, k) == edge ? of_face(face, (k + 2) % 3) : of_face(face, k);
            const Int before = of(face);
            face = beside(edge, 0) + beside(edge, 1) - face;
            const Int region = of(face);
            if (region != regions[0]) {
                several = several || (regions[1] >= 0 && region != regions[1]);
                regions[1] = region;
            }
            if (region == before) continue;
            if (between < 2) found[between] = ends(edge, 0) + ends(edge, 1) - v;
            ++between;
        } while (++steps < degree[v] && face != start[v]);
        if (steps != degree[v] || face != start[v]) return true;
        if (several) continue;
        if (between != 2) return true;
        const auto p = vertices[found[0]], q = vertices[found[1]], at = vertices[v];
        const double u[] = {p[0] - at[0], p[1] - at[1], p[2] - at[2]};
        const double w[] = {q[0] - at[0], q[1] - at[1], q[2] - at[2]};
        const double across =
            std::hypot(u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]);
        const double longer = std::sqrt(std::max(apart2(v, found[0]), apart2(v, found[1])));
        if (!(across > 2 * wide * longer)) return true;
    }
    return false;
}

}  // namespace holdfast
