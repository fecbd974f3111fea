// Block-sparse elimination of the linear systems of large models, front by front.

#pragma once

#include "linear.hpp"

namespace holdfast {

// As ``dense_solve``, front by front
double fronts_solve(const Elastic& m, Work& work, const Fronts& e, double drag, double corner, double least);

// Solve the system of ``work`` in place: by ``fronts``, or by dense elimination where there are none.
//
// Returns the sign of the determinant, or SINGULAR; ``least`` is as in ``dense_solve``.
inline double solve(const Elastic& m, Work& work, double drag, double corner, const Fronts* fronts,
                    double least = 0.0) {
    if (fronts == nullptr) return dense_solve(m, work, drag, corner, least);
    return fronts_solve(m, work, *fronts, drag, corner, least);
}

}  // namespace holdfast
