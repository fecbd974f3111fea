// Rounding to binary digits relative to a size, as ``snapped`` of base/rigid.py does.

#pragma once

#include <algorithm>
#include <cmath>

namespace holdfast {

constexpr double BESIDE = 1.2345;  // sizes are multiplied by it before their exponent is taken: many are powers of two
// The least size: steps of 2^-54 of it are normal numbers, where a simulator lets the processor take others for zero
constexpr double NOTHING = 1e-280;

// The step between numbers of ``bits`` binary digits relative to ``size``
inline double snapping_step(double size, int bits) {
    int power = 0;
    std::frexp(std::max(BESIDE * size, NOTHING), &power);
    return std::ldexp(1.0, power - (bits + 1));
}

inline double snapped_number(double value, double step) { return std::rint(value / step) * step + 0.0; }

}  // namespace holdfast
