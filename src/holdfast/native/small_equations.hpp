// Small dense equations.

#pragma once

#include <cmath>
#include <utility>

#include "span.hpp"

namespace holdfast {

// Solve A x = b by Gauss elimination with the largest pivot of each column. ``A`` (n, n) is overwritten, and ``b`` (n,)
// becomes x; false if A is singular.
inline bool solve_dense(Mat A, Vec b) {
    const Int n = b.size();
    for (Int k = 0; k < n; ++k) {
        Int pivot = k;
        for (Int i = k + 1; i < n; ++i) {
            if (std::abs(A(i, k)) > std::abs(A(pivot, k))) pivot = i;
        }
        if (!(std::abs(A(pivot, k)) > 0.0)) return false;
        if (pivot != k) {
            for (Int j = k; j < n; ++j) std::swap(A(k, j), A(pivot, j));
            std::swap(b[k], b[pivot]);
        }
        const double* row = A[k].data();
        for (Int i = k + 1; i < n; ++i) {
            double* below = A[i].data();
            const double share = below[k] / row[k];
            for (Int j = k + 1; j < n; ++j) below[j] -= share * row[j];
            b[i] -= share * b[k];
        }
    }
    for (Int k = n - 1; k >= 0; --k) {
        for (Int j = k + 1; j < n; ++j) b[k] -= A(k, j) * b[j];
        b[k] /= A(k, k);
    }
    return true;
}

}  // namespace holdfast
