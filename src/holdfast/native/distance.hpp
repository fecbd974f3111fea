// Distances of points from triangles, and winding numbers, which tell whether points are inside a surface.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

constexpr double TINY_PRODUCT = 1e-100;  // a running product is rescaled when its size leaves the range from this to
                                         // its inverse

// How often (n,) the surface winds around points (n, 3).
//
// Half of each solid angle is the argument of a complex number, so half of their sum is the argument of the product.
// It is enough to count how often the product crosses the negative real axis, with one arctangent for each point.
inline Array<double> winding_numbers(InMat points, InMat vertices, InIntMat faces) {
    const Int count = vertices.size();
    Array<double> total({points.size()});
    Array<double, 2> room({count, 4});  // arm from the point to each vertex, and its length
    double* const arms = room.numbers.data();
    for (Int i = 0; i < points.size(); ++i) {
        for (Int k = 0; k < count; ++k) {
            const double x = vertices(k, 0) - points(i, 0), y = vertices(k, 1) - points(i, 1),
                         z = vertices(k, 2) - points(i, 2);
            double* const arm = arms + 4 * k;
            arm[0] = x;
            arm[1] = y;
            arm[2] = z;
            arm[3] = std::sqrt(x * x + y * y + z * z);
        }
        double real = 1.0, imaginary = 0.0;
        Int turns = 0;
        for (Int j = 0; j < faces.size(); ++j) {
            const double *const a = arms + 4 * faces(j, 0), *const b = arms + 4 * faces(j, 1),
                                *const c = arms + 4 * faces(j, 2);
            const double sine = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                                a[2] * (b[0] * c[1] - b[1] * c[0]);
            const double ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2], bc = b[0] * c[0] + b[1] * c[1] + b[2] * c[2],
                         ca = c[0] * a[0] + c[1] * a[1] + c[2] * a[2];
            const double cosine = a[3] * b[3] * c[3] + ab * c[3] + bc * a[3] + ca * b[3];
            if (sine == 0.0 && cosine == 0.0) continue;  // at a corner of the triangle
            const double product = real * sine + imaginary * cosine;
            if (imaginary >= 0.0 && sine >= 0.0 && product < 0.0) {
                ++turns;
            } else if (imaginary < 0.0 && sine < 0.0 && product >= 0.0) {
                --turns;
            }
            real = real * cosine - imaginary * sine;
            imaginary = product;
            const double size = std::max(std::abs(real), std::abs(imaginary));
            if (!(TINY_PRODUCT < size && size < 1 / TINY_PRODUCT)) {
                real /= size;
                imaginary /= size;
            }
        }
        constexpr double full = 2 * std::numbers::pi;
        total.numbers[i] = (full * static_cast<double>(turns) + std::atan2(imaginary, real)) / full;
    }
    return total;
}

// A triangle with what the distance of a point from it needs
struct Reach {
    double corner[3][3], edge[3][3], length2[3], normal[3], area2;

    explicit Reach(InMat triangle) {
        for (Int k = 0; k < 3; ++k) {
            const Int m = k < 2 ? k + 1 : 0;
            for (Int x = 0; x < 3; ++x) {
                corner[k][x] = triangle(k, x);
                edge[k][x] = triangle(m, x) - triangle(k, x);
            }
            length2[k] = edge[k][0] * edge[k][0] + edge[k][1] * edge[k][1] + edge[k][2] * edge[k][2];
        }
        const double ux = edge[0][0], uy = edge[0][1], uz = edge[0][2];
        const double wx = triangle(2, 0) - triangle(0, 0), wy = triangle(2, 1) - triangle(0, 1),
                     wz = triangle(2, 2) - triangle(0, 2);
        normal[0] = uy * wz - uz * wy;
        normal[1] = uz * wx - ux * wz;
        normal[2] = ux * wy - uy * wx;
        area2 = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    }

    // The squared distance of a point: from the plane inside the prism of the triangle, from the nearest edge outside
    double squared(double x, double y, double z) const {
        bool inside = area2 > 0;
        double best = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k) {
            const double ex = edge[k][0], ey = edge[k][1], ez = edge[k][2];
            const double ax = x - corner[k][0], ay = y - corner[k][1], az = z - corner[k][2];
            const double t =
                length2[k] > 0 ? std::min(std::max((ax * ex + ay * ey + az * ez) / length2[k], 0.0), 1.0) : 0.0;
            const double dx = ax - t * ex, dy = ay - t * ey, dz = az - t * ez;
            best = std::min(best, dx * dx + dy * dy + dz * dz);
            inside = inside && (ey * az - ez * ay) * normal[0] + (ez * ax - ex * az) * normal[1] +
                                       (ex * ay - ey * ax) * normal[2] >=
                                   0;
        }
        if (inside) {
            const double height =
                (x - corner[0][0]) * normal[0] + (y - corner[0][1]) * normal[1] + (z - corner[0][2]) * normal[2];
            best = std::min(best, height * height / area2);
        }
        return best;
    }
};

// The least squared distance among ``pairs`` (m, 2) of points (n, 3) and triangles (k, 3, 3)
inline double nearest_of_pairs(InMat points, InTen triangles, InIntMat pairs) {
    std::vector<Reach> all;
    all.reserve(static_cast<std::size_t>(triangles.size()));
    for (Int k = 0; k < triangles.size(); ++k) all.emplace_back(triangles[k]);
    double best = std::numeric_limits<double>::infinity();
    for (Int k = 0; k < pairs.size(); ++k) {
        const auto p = points[pairs(k, 0)];
        best = std::min(best, all[static_cast<std::size_t>(pairs(k, 1))].squared(p[0], p[1], p[2]));
    }
    return best;
}

// The squared distances (n,) of points (n, 3) from the nearest of triangles (k, 3, 3)
inline Array<double> squared_distances(InMat points, InTen triangles) {
    Array<double> best({points.size()}, std::numeric_limits<double>::infinity());
    for (Int j = 0; j < triangles.size(); ++j) {
        const Reach triangle(triangles[j]);
        for (Int i = 0; i < points.size(); ++i) {
            best.numbers[i] = std::min(best.numbers[i], triangle.squared(points(i, 0), points(i, 1), points(i, 2)));
        }
    }
    return best;
}

}  // namespace holdfast
