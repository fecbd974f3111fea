// Vectors of three numbers.

#pragma once

#include "span.hpp"

namespace holdfast {

inline double dot3(In a, In b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace holdfast
