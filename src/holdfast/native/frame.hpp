// Two tangents beside a normal.

#pragma once

#include <array>
#include <cmath>

namespace holdfast {

using Axis = std::array<double, 3>;

// Rows t1, t2 and the unit ``normal``, with t1 x t2 = normal, as ``tangents`` of base/rigid.py has them
inline std::array<Axis, 3> frame_on(const Axis& normal) {
    const auto [x, y, z] = normal;
    const double sx = std::abs(x) < 0.9 ? 1.0 : 0.0, sy = 1.0 - sx;
    const double along = sx * x + sy * y + 0.0 * z;
    double ax = sx - along * x, ay = sy - along * y, az = 0.0 - along * z;
    const double length = std::sqrt(ax * ax + ay * ay + az * az);
    ax /= length;
    ay /= length;
    az /= length;
    return {Axis{ax, ay, az}, Axis{y * az - z * ay, z * ax - x * az, x * ay - y * ax}, normal};
}

}  // namespace holdfast
