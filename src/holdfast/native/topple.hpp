// Toppling axes of a cut, and the torque with which contacts resist a rotation about them (Sec. V-C2, V-C3).
//
// Signs: the moving side turns by +a about the axis through o. ``n`` is the inward normal of the stationary side, ``f``
// is the force of the moving side on the stationary side, and v = (p - o) x a is minus the velocity of the moving side
// at the node p. If v·n < 0, the motion is blocked. If v·n > 0, the contact opens and its preload f·v has to be
// overcome. If v·n = 0, the contact slides.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "graph_slip.hpp"

namespace holdfast {

// Distance of a node from the axis, relative to the assembly's size, below which the node does not move
constexpr double ON_AXIS = 1e-6;
constexpr double SLIDING = 1e-6;  // |v·n| / |v| below which v·n counts as 0

// Write which segments (n,) do not lie on the line of an earlier one
inline void first_of_line(InMat start, InMat direction, double tolerance, Span<bool> fresh) {
    fresh.fill(true);
    for (Int i = 0; i < start.size(); ++i) {
        for (Int j = 0; j < i; ++j) {
            if (!fresh[j]) continue;
            double along = 0.0, arm2 = 0.0, aligned = 0.0;
            for (int k = 0; k < 3; ++k) {
                const double arm = start(i, k) - start(j, k);
                arm2 += arm * arm;
                along += arm * direction(j, k);
                aligned += direction(i, k) * direction(j, k);
            }
            if (std::abs(aligned) > 1 - 1e-9 && arm2 - along * along <= tolerance * tolerance) {
                fresh[i] = false;
                break;
            }
        }
    }
}

// The n nodes of a cut: ``points`` (n, 3) [m], ``frames`` (n, 3, 3) with the rows normal (into body b), t1 and t2,
// ``forces`` (n, 3) [N] on body b in that frame, and ``moving_is_a`` (n,), whether body a is the moving one
struct CutNodes {
    InMat points;
    InTen frames;
    InMat forces;
    In mu;
    Span<const bool> moving_is_a;
};

// Return the resisting torque [N m] about an axis through ``origin`` along the unit vector ``axis``; inf where the
// rotation is blocked. Every node slides about a ``flat`` one. ``size`` [m] is that of the assembly.
inline double axis_torque(const double* origin, const double* axis, double sense, bool flat, const CutNodes& nodes,
                          double size) {
    double torque = 0.0;
    const double a0 = sense * axis[0], a1 = sense * axis[1], a2 = sense * axis[2];
    for (Int i = 0; i < nodes.points.size(); ++i) {
        const double *point = nodes.points[i].data(), *f = nodes.forces[i].data();
        const double *normal = nodes.frames[i].data(), *t1 = normal + nodes.frames.steps()[1];
        const double* t2 = t1 + nodes.frames.steps()[1];
        const double arm0 = point[0] - origin[0], arm1 = point[1] - origin[1], arm2 = point[2] - origin[2];
        const double x = arm1 * a2 - arm2 * a1, y = arm2 * a0 - arm0 * a2, z = arm0 * a1 - arm1 * a0;
        const double speed = std::sqrt(x * x + y * y + z * z);
        if (speed <= ON_AXIS * size) continue;
        const double side = nodes.moving_is_a[i] ? 1.0 : -1.0;  // turns the node's frame into the stationary side's
        const double vn = side * (normal[0] * x + normal[1] * y + normal[2] * z);
        const double v1 = side * (t1[0] * x + t1[1] * y + t1[2] * z);
        const double v2 = side * (t2[0] * x + t2[1] * y + t2[2] * z);
        if (flat || std::abs(vn) <= SLIDING * speed) {
            const double tangential = std::sqrt(v1 * v1 + v2 * v2);
            const double strength = node_slip(f[0], f[1], f[2], nodes.mu[i], 0.0, -v1 / tangential, -v2 / tangential);
            torque += strength * tangential;
        } else if (vn < 0.0) {
            return std::numeric_limits<double>::infinity();
        } else {
            torque += f[0] * vn + f[1] * v1 + f[2] * v2;
        }
    }
    return std::max(torque, 0.0);
}

// Write the resisting torque (2m,) about every axis, given by ``origins`` (m, 3) [m] and unit ``axes`` (m, 3). Entries
// 2k and 2k + 1 are for the positive and the negative sense of axis k.
inline void axis_torques(InMat origins, InMat axes, Span<const bool> flat, const CutNodes& nodes, double size,
                         Vec torque) {
    for (Int k = 0; k < torque.size(); ++k) {
        const Int line = k / 2;
        torque[k] =
            axis_torque(origins[line].data(), axes[line].data(), k % 2 == 0 ? 1.0 : -1.0, flat[line], nodes, size);
    }
}

}  // namespace holdfast
