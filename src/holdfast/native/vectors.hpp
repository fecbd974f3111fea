// Vectors in hot loops, as short calls.

#pragma once

#include <algorithm>
#include <cmath>

#include "span.hpp"

namespace holdfast {

// A · b
inline double dot(In a, In b) {
    double total = 0.0;
    for (Int i = 0; i < a.size(); ++i) total += a[i] * b[i];
    return total;
}

// The largest |a_i|
inline double largest(In a) {
    double top = 0.0;
    for (Int i = 0; i < a.size(); ++i) top = std::max(top, std::abs(a[i]));
    return top;
}

// The largest |a_i - b_i|
inline double farthest(In a, In b) {
    double top = 0.0;
    for (Int i = 0; i < a.size(); ++i) top = std::max(top, std::abs(a[i] - b[i]));
    return top;
}

// Set ``into`` to a + far · b; it may be one of them
inline void go(Vec into, In a, double far, In b) {
    for (Int i = 0; i < a.size(); ++i) into[i] = a[i] + far * b[i];
}

// Set ``into`` to (1 - share) a + share b; it may be one of them
inline void mix(Vec into, In a, double share, In b) {
    for (Int i = 0; i < a.size(); ++i) into[i] = (1 - share) * a[i] + share * b[i];
}

// Set ``into`` to a
inline void put(Vec into, In a) {
    for (Int i = 0; i < a.size(); ++i) into[i] = a[i];
}

// Set ``into`` to factor · a; it may be a
inline void scale(Vec into, double factor, In a) {
    for (Int i = 0; i < a.size(); ++i) into[i] = factor * a[i];
}

// Set ``into`` to a / by; it may be a
inline void divide(Vec into, In a, double by) {
    for (Int i = 0; i < a.size(); ++i) into[i] = a[i] / by;
}

}  // namespace holdfast
