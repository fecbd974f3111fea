// Areas and normals of triangles.

#pragma once

#include <algorithm>
#include <cmath>

#include "span.hpp"

namespace holdfast {

constexpr double NO_AREA = 1e-300;  // [m²] a triangle with a smaller area has the normal 0

// The area vectors (F, 3) [m²] of triangles ``faces`` (F, 3) over ``vertices`` (V, 3) [m]. Each is as long as the area
// of its triangle and points along the normal, by the right-hand rule.
inline Array<double, 2> area_vectors(InMat vertices, InIntMat faces) {
    Array<double, 2> found(faces.sizes());
    double* out = found.numbers.data();
    for (Int f = 0; f < faces.size(); ++f, out += 3) {
        const auto a = vertices[faces(f, 0)], b = vertices[faces(f, 1)], c = vertices[faces(f, 2)];
        const double u[] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        out[0] = (u[1] * v[2] - u[2] * v[1]) / 2;
        out[1] = (u[2] * v[0] - u[0] * v[2]) / 2;
        out[2] = (u[0] * v[1] - u[1] * v[0]) / 2;
    }
    return found;
}

// The areas (F,) [m²] of triangles
inline Array<double> areas_of(InMat vertices, InIntMat faces) {
    const Array<double, 2> vectors = area_vectors(vertices, faces);
    Array<double> found({faces.size()});
    const double* v = vectors.numbers.data();
    for (double& area : found.numbers) {
        area = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        v += 3;
    }
    return found;
}

// The unit normals (F, 3) of triangles; 0 for a triangle without area
inline Array<double, 2> normals_of(InMat vertices, InIntMat faces) {
    Array<double, 2> found = area_vectors(vertices, faces);
    double* v = found.numbers.data();
    for (Int f = 0; f < faces.size(); ++f, v += 3) {
        const double length = std::max(std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), NO_AREA);
        for (int k = 0; k < 3; ++k) v[k] /= length;
    }
    return found;
}

}  // namespace holdfast
