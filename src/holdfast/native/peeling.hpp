// Contacts that cannot press without a load, found body by body, with no program to solve.
//
// The forces on a body at rest without any load have the sum zero. Where all the forces that its contacts can take lie
// on one side of a plane, each of them is zero, then. Such contacts are as good as gone, which may leave others
// one-sided: a stack of boxes is peeled from its corners. What is left may be clamped, or not.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr double CLEAR = 1e-6;  // sine of the angle by which every force must be off the plane
constexpr int TRIALS = 100;  // planes that are tried for a body; as many find any that every force is off by 6 degrees

// Whether all forces on a body, at those of its nodes that are ``left``, lie on one side of a plane. A plane is sought
// by turning it towards the force that is farthest behind it, until none is (the perceptron). Where its normal
// vanishes, there is none: some forces balance each other.
inline bool one_sided(InMat inward, In mu, InInts node, Span<const bool> left) {
    const Int count = node.size(), step_of_row = inward.steps()[0];
    double x = 0.0, y = 0.0, z = 0.0;  // along the normal of the plane
    for (Int k = 0; k < count; ++k) {
        if (!left[node[k]]) continue;
        const double* n = inward.data() + k * step_of_row;
        x += n[0];
        y += n[1];
        z += n[2];
    }
    const double step = std::sqrt(x * x + y * y + z * z);  // of a turn
    for (int trial = 0; trial < TRIALS; ++trial) {
        const double size = std::sqrt(x * x + y * y + z * z);
        if (size < CLEAR) return false;
        const double ux = x / size, uy = y / size, uz = z / size;
        double worst = std::numeric_limits<double>::infinity(), fx = 0.0, fy = 0.0, fz = 0.0;
        for (Int k = 0; k < count; ++k) {
            if (!left[node[k]]) continue;
            const double* n = inward.data() + k * step_of_row;
            const double nx = n[0], ny = n[1], nz = n[2];
            const double ahead = (nx * x + ny * y + nz * z) / size;
            const double tx = ux - ahead * nx, ty = uy - ahead * ny, tz = uz - ahead * nz;
            const double across = std::sqrt(tx * tx + ty * ty + tz * tz);
            const double length = std::sqrt(1 + mu[k] * mu[k]);
            const double room = (ahead - mu[k] * across) / length;
            if (room < worst) {
                worst = room;
                const double back =
                    mu[k] / std::max(across, 1e-300);  // friction acts against the part along the surface
                fx = (nx - back * tx) / length;
                fy = (ny - back * ty) / length;
                fz = (nz - back * tz) / length;
            }
        }
        if (worst > CLEAR) return true;
        x += step * fx;
        y += step * fy;
        z += step * fz;
    }
    return false;
}

// Clear ``left`` (I,) at nodes of one-sided bodies. Body j has the entries ``first[j]`` to ``first[j + 1]`` - 1. Each
// of them is a ``node`` with its normal ``inward`` (3,), its friction coefficient and the ``other`` body, -1 if that is
// fixed.
inline void peel(InMat inward, In mu, InInts node, InInts other, InInts first, Span<bool> left) {
    const Int count = first.size() - 1;
    std::vector<unsigned char> waiting(count, 1);
    std::vector<Int> stack(count);
    for (Int body = 0; body < count; ++body) stack[body] = body;
    Int size = count;
    while (size > 0) {
        const Int body = stack[--size];
        waiting[body] = 0;
        const Int low = first[body], high = first[body + 1];
        if (!one_sided(inward.part(low, high), mu.part(low, high), node.part(low, high), left)) continue;
        for (Int k = low; k < high; ++k) {
            if (left[node[k]] && other[k] >= 0 && !waiting[other[k]]) {
                waiting[other[k]] = 1;
                stack[size++] = other[k];
            }
            left[node[k]] = false;
        }
    }
}

}  // namespace holdfast
