// The flat sheets that contact nodes form, in the units of the elastic model.
//
// Bodies' displacements are along the assembly's own axes, and all numbers are rounded to BITS digits: where a load
// path branches, as under a symmetric push, the last digits decide which way it goes, and they would depend on the
// world's axes and on the units of length.

#pragma once

#include <algorithm>
#include <cmath>

#include "snapped.hpp"
#include "span.hpp"

namespace holdfast {

constexpr int BITS = 30;  // binary digits of the model's numbers, each relative to those of the same sheet or body
constexpr double TURNED = 1e-12;  // largest difference of an entry of the axes of a sheet's nodes

// Return the numbers (P + 1,) of the nodes at which the P sheets begin, and the number of nodes. ``flat`` [m] is the
// largest distance of a sheet's nodes from its plane.
inline Array<Int> sheets_begin(InMat points, InTen axes, InInts interface, double flat) {
    Array<Int> found;
    for (Int i = 0; i < points.size(); ++i) {
        bool begins = i == 0 || interface[i] != interface[i - 1];
        if (!begins) {
            const auto point = points[i], last = points[i - 1];
            const auto here = axes[i], before = axes[i - 1];
            double step = 0.0, turn = 0.0;
            for (int k = 0; k < 3; ++k) {
                step += (point[k] - last[k]) * here(0, k);
                for (int row = 0; row < 3; ++row) turn = std::max(turn, std::abs(here(row, k) - before(row, k)));
            }
            begins = turn > TURNED || std::abs(step) > flat;
        }
        if (begins) found.numbers.push_back(i);
    }
    found.numbers.push_back(points.size());
    found.sizes = {static_cast<Int>(found.numbers.size())};
    return found;
}

// Where the sheets of an assembly are written: places ``x``, ``y`` of all nodes, and axes (``turned``) and arms of all
// sheets, as ``Sheets`` of engines/compliant/elastic_model.py has them
struct Placed {
    Vec x, y;
    Ten turned;
    Mat arm_a, arm_b;
};

// Place the sheets of the nodes ``first[p]`` to ``first[p + 1]`` - 1 between bodies ``a`` and ``b`` (P,). Arms of fixed
// bodies remain as they are.
inline void place_sheets(InMat points, InTen axes, InInts first, InInts a, InInts b, InMat com, InMat own, double size,
                         const Placed& placed) {
    const double unit = snapping_step(1.0, BITS);
    for (Int p = 0; p < a.size(); ++p) {
        const Int begin = first[p], end = first[p + 1];
        double c0 = 0.0, c1 = 0.0, c2 = 0.0;
        for (Int i = begin; i < end; ++i) {
            const auto point = points[i];
            c0 += point[0];
            c1 += point[1];
            c2 += point[2];
        }
        const auto count = static_cast<double>(end - begin);
        c0 /= count;
        c1 /= count;
        c2 /= count;
        const InMat R = axes[begin];
        double most = 0.0;
        for (Int i = begin; i < end; ++i) {
            const auto point = points[i];
            const double d0 = point[0] - c0, d1 = point[1] - c1, d2 = point[2] - c2;
            placed.x[i] = (R(1, 0) * d0 + R(1, 1) * d1 + R(1, 2) * d2) / size;
            placed.y[i] = (R(2, 0) * d0 + R(2, 1) * d1 + R(2, 2) * d2) / size;
            most = std::max(std::max(most, std::abs(placed.x[i])), std::abs(placed.y[i]));
        }
        const double step = snapping_step(most, BITS);
        for (Int i = begin; i < end; ++i) {
            placed.x[i] = snapped_number(placed.x[i], step);
            placed.y[i] = snapped_number(placed.y[i], step);
        }
        for (int row = 0; row < 3; ++row) {
            for (int k = 0; k < 3; ++k) {
                const double along = R(row, 0) * own(k, 0) + R(row, 1) * own(k, 1) + R(row, 2) * own(k, 2);
                placed.turned(p, row, k) = snapped_number(along, unit);
            }
        }
        for (const bool second : {false, true}) {
            const Int body = second ? b[p] : a[p];
            if (body < 0) continue;
            const Vec arm = (second ? placed.arm_b : placed.arm_a)[p];
            const double d0 = c0 - com(body, 0), d1 = c1 - com(body, 1), d2 = c2 - com(body, 2);
            double longest = 0.0;
            for (int k = 0; k < 3; ++k) {
                arm[k] = (d0 * own(k, 0) + d1 * own(k, 1) + d2 * own(k, 2)) / size;
                longest = std::max(longest, std::abs(arm[k]));
            }
            const double finest = snapping_step(longest, BITS);
            for (int k = 0; k < 3; ++k) arm[k] = snapped_number(arm[k], finest);
        }
    }
}

}  // namespace holdfast
