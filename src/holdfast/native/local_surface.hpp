// The surface near a point on it: its normal, the distance of sharp edges, and where it slopes.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "search_mesh.hpp"
#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

// Tolerances of the search for touching edges and vertices; lengths are in metres.
//
// Surfaces touch up to ``gap`` apart and ``depth`` into each other. ``sin_angle`` is the sine of the angle by which the
// surface beside a feature may slope towards the other body; beside a curved face ``sin_curved`` holds instead. Lengths
// up to ``tiny`` are rounding. Contacts within ``strict`` of a sharp edge do not count.
struct FeatureLimits {
    double gap, depth, sin_angle, sin_curved, tiny, strict;
    static constexpr auto fields =
        std::tuple{&FeatureLimits::gap,        &FeatureLimits::depth, &FeatureLimits::sin_angle,
                   &FeatureLimits::sin_curved, &FeatureLimits::tiny,  &FeatureLimits::strict};
};

// How far [m] beyond an edge of a face a point may be and still touch the face; negative at a sharp edge
inline double slack_at(double bend, double height, double tiny, double strict) {
    if (!std::isfinite(bend) || bend <= FLAT) return tiny;
    if (bend < SMOOTH) return tiny + std::abs(height) * std::tan(bend / 2);
    return -strict;
}

// How far [m] a point is beyond the k-th edge of a face, in the plane of the face
inline double beyond_edge(const SearchMesh& mesh, Int face, Int k, In point) {
    const In out = mesh.outward[face][k], p = mesh.triangles[face][k];
    return out[0] * (point[0] - p[0]) + out[1] * (point[1] - p[1]) + out[2] * (point[2] - p[2]);
}

// Write the normal of the surface at a point over a face; return whether it is a mean of several faces.
//
// Near a smooth edge it is the mean normal of the two faces, near a smooth vertex that of the vertex.
inline bool normal_at(const SearchMesh& mesh, Int face, In point, double height, double tiny, double* normal) {
    bool near[3] = {};  // whether the point is at edge k
    for (Int k = 0; k < 3; ++k) {
        const double bend = mesh.bend[mesh.of_face(face, k)];
        near[k] =
            FLAT < bend && bend < SMOOTH && beyond_edge(mesh, face, k, point) >= -slack_at(bend, height, tiny, 0.0);
    }
    for (Int m = 0; m < 3; ++m) normal[m] = mesh.normals(face, m);
    for (Int k = 0; k < 3; ++k) {
        const In mean = mesh.mean[mesh.faces(face, k)];
        if (near[k] && near[(k + 2) % 3] && dot3(mean, mean) > 0) {
            for (Int m = 0; m < 3; ++m) normal[m] = mean[m];
            return true;
        }
    }
    for (Int k = 0; k < 3; ++k) {
        if (!near[k]) continue;
        const Int edge = mesh.of_face(face, k);
        const Int other = mesh.sides(edge, mesh.sides(edge, 0) == face ? 1 : 0);
        if (other >= 0) {
            for (Int m = 0; m < 3; ++m) normal[m] += mesh.normals(other, m);
        }
        break;
    }
    const double length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (length < 1) {  // the two faces have opposite windings, as in a mesh whose inside is unknown: there is no mean
        for (Int m = 0; m < 3; ++m) normal[m] = mesh.normals(face, m);
        return false;
    }
    for (Int m = 0; m < 3; ++m) normal[m] /= length;
    return near[0] || near[1] || near[2];
}

// Tell whether all edges at a vertex lead away along ``normal``, or slope against it by no more than the angle
inline bool vertex_rises(const SearchMesh& mesh, Int vertex, const double* normal, const FeatureLimits& limits) {
    const In v = mesh.vertices[vertex];
    for (Int n = mesh.starts[vertex]; n < mesh.starts[vertex + 1]; ++n) {
        const In w = mesh.vertices[mesh.neighbours[n]];
        const double x = w[0] - v[0], y = w[1] - v[1], z = w[2] - v[2];
        if (x * normal[0] + y * normal[1] + z * normal[2] < -limits.sin_angle * std::sqrt(x * x + y * y + z * z)) {
            return false;
        }
    }
    return true;
}

// Tell whether both faces at an edge lead away along ``normal``, or slope against it by no more than the angle
inline bool edge_rises(const SearchMesh& mesh, Int edge, const double* normal, const FeatureLimits& limits) {
    for (Int side = 0; side < 2; ++side) {
        const Int face = mesh.sides(edge, side);
        if (face < 0) continue;
        const double sin_angle = mesh.curved[face] ? limits.sin_curved : limits.sin_angle;
        for (Int k = 0; k < 3; ++k) {
            if (mesh.of_face(face, k) == edge && dot3(mesh.outward[face][k], In(normal, {3})) > sin_angle) return false;
        }
    }
    return true;
}

// Tell whether a point at ``height`` [m] over the plane of a face projects into the face, within tolerances
inline bool lies_over(const SearchMesh& mesh, Int face, In point, double height, double tiny, double strict) {
    for (Int k = 0; k < 3; ++k) {
        const double beyond = beyond_edge(mesh, face, k, point);
        if (beyond > slack_at(mesh.bend[mesh.of_face(face, k)], height, tiny, strict)) return false;
        if (std::abs(beyond) <= strict) {  // near a sharp corner, even if the edges of this face there are smooth
            const In p = mesh.triangles[face][k], mean = mesh.mean[mesh.faces(face, k)];
            const double x = point[0] - p[0], y = point[1] - p[1], z = point[2] - p[2];
            const bool sharp = dot3(mean, mean) == 0;
            if (sharp && x * x + y * y + z * z - height * height <= strict * strict) return false;
        }
    }
    return true;
}

// The distance [m] of a point over a face to the nearest sharp edge of the face; infinite if it has none
inline double inset_of(const SearchMesh& mesh, Int face, In point) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    double least = inf;
    for (Int k = 0; k < 3; ++k) {
        const double bend = mesh.bend[mesh.of_face(face, k)];
        if (SMOOTH <= bend && bend < inf) least = std::min(least, -beyond_edge(mesh, face, k, point));
    }
    return least;
}

// The height [m] of a point over the plane of a face, negative below it
inline double height_over(const SearchMesh& mesh, Int face, In point) {
    const In p = mesh.triangles[face][0], m = mesh.normals[face];
    return (point[0] - p[0]) * m[0] + (point[1] - p[1]) * m[1] + (point[2] - p[2]) * m[2];
}

}  // namespace holdfast
