// Pairs of faces of two bodies that are near each other and do not face away.

#pragma once

#include "span.hpp"
#include "vec3.hpp"

namespace holdfast {

constexpr double AWAY = 0.3;  // faces whose normals have a larger cosine cannot touch each other

// The boxes, low and high (F, 3) [m], and the unit normals (F, 3) of faces
struct Boxed {
    InMat low, high, normals;
};

// Those of ``pairs`` (m, 2) of faces whose boxes come within ``margin`` [m] and whose normals fit
inline Array<Int, 2> facing_near(InIntMat pairs, const Boxed& a, const Boxed& b, double margin) {
    Array<Int, 2> found({0, 2});
    for (Int pair = 0; pair < pairs.size(); ++pair) {
        const Int i = pairs(pair, 0), j = pairs(pair, 1);
        const In low_a = a.low[i], high_a = a.high[i], low_b = b.low[j], high_b = b.high[j];
        bool near = true;
        for (int k = 0; k < 3; ++k) near = near && low_b[k] <= high_a[k] + margin && high_b[k] >= low_a[k] - margin;
        if (near && dot3(a.normals[i], b.normals[j]) < AWAY) {
            found.numbers.push_back(i);
            found.numbers.push_back(j);
        }
    }
    found.sizes[0] = static_cast<Int>(found.numbers.size()) / 2;
    return found;
}

}  // namespace holdfast
