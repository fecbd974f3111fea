// Weights of nodes, corrected so that sums over the nodes equal integrals over the face that they represent.

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr double MET = 1e-5;      // largest relative error of an integral that counts as matched
constexpr double RANK = 1e-10;    // eigenvalues below this share of the largest count as zero
constexpr double REGULAR = 1e-6;  // least pivot, relative to the diagonal, of a matrix that is far from singular
constexpr double LEAST_SHARES[] = {0.1, 0.01};  // least ratio of a corrected weight to the given one; the second is
                                                // used if the first fails
constexpr int SWEEPS = 30;                      // most rounds of rotations for eigenvalues; they take about eight

// Find the shortest x with A x = b for a positive semidefinite A (m, m), in place of b, by its eigenvectors (Jacobi's
// rotations). A is lost.
inline void solve_shortest(Mat A, Vec b) {
    const Int m = b.size();
    Array<double, 2> vectors({m, m});
    const Mat V = vectors.view();
    for (Int i = 0; i < m; ++i) V(i, i) = 1.0;
    for (int sweep = 0; sweep < SWEEPS; ++sweep) {
        bool turned = false;
        for (Int p = 0; p < m; ++p) {
            for (Int q = p + 1; q < m; ++q) {
                if (A(p, q) == 0.0 || std::abs(A(p, q)) <= 1e-17 * std::sqrt(std::abs(A(p, p) * A(q, q)))) continue;
                turned = true;
                const double theta = (A(q, q) - A(p, p)) / (2 * A(p, q));
                const double t = (theta < 0.0 ? -1.0 : 1.0) / (std::abs(theta) + std::hypot(1.0, theta));
                const double c = 1 / std::hypot(1.0, t), s = t * c;
                for (Int k = 0; k < m; ++k) {
                    const double x = A(k, p), y = A(k, q);
                    A(k, p) = c * x - s * y;
                    A(k, q) = s * x + c * y;
                }
                for (Int k = 0; k < m; ++k) {
                    const double x = A(p, k), y = A(q, k), u = V(k, p), v = V(k, q);
                    A(p, k) = c * x - s * y;
                    A(q, k) = s * x + c * y;
                    V(k, p) = c * u - s * v;
                    V(k, q) = s * u + c * v;
                }
                A(p, q) = A(q, p) = 0.0;
            }
        }
        if (!turned) break;
    }
    double largest = 0.0;
    for (Int i = 0; i < m; ++i) largest = std::max(largest, A(i, i));
    std::vector<double> x(static_cast<std::size_t>(m));
    for (Int k = 0; k < m; ++k) {
        if (!(A(k, k) > RANK * largest)) continue;
        double along = 0.0;
        for (Int i = 0; i < m; ++i) along += V(i, k) * b[i];
        for (Int i = 0; i < m; ++i) x[i] += V(i, k) * (along / A(k, k));
    }
    std::copy(x.begin(), x.end(), b.begin());
}

// Find the shortest x with A x = b, in place of b: by the Cholesky factor of A (m, m) if its pivots show that it is far
// from singular, which is fast
inline void solve_positive(InMat A, Vec b) {
    const Int m = b.size();
    Array<double, 2> memory({m, m});
    const Mat L = memory.view();
    for (Int i = 0; i < m; ++i) {
        for (Int j = 0; j <= i; ++j) {
            double rest = A(i, j);
            for (Int k = 0; k < j; ++k) rest -= L(i, k) * L(j, k);
            if (i == j && !(rest > REGULAR * A(i, i))) {
                for (Int row = 0; row < m; ++row) {
                    for (Int column = 0; column < m; ++column) L(row, column) = A(row, column);
                }
                return solve_shortest(L, b);
            }
            L(i, j) = i == j ? std::sqrt(rest) : rest / L(j, j);
        }
    }
    for (Int i = 0; i < m; ++i) {
        for (Int k = 0; k < i; ++k) b[i] -= L(i, k) * b[k];
        b[i] /= L(i, i);
    }
    for (Int i = m - 1; i >= 0; --i) {
        for (Int k = i + 1; k < m; ++k) b[i] -= L(k, i) * b[k];
        b[i] /= L(i, i);
    }
}

// Find the weights (n,) nearest to ``given`` (n,) with ``basis`` (m, n) @ weights = ``wanted`` (m,), none below
// ``share`` of the given one; false if there are none
inline bool correct(In given, InMat basis, In wanted, double share, Vec weights) {
    const Int n = given.size(), m = wanted.size();
    std::vector<double> base(given.begin(), given.end()), metric = base, x(static_cast<std::size_t>(m));
    Array<double, 2> A({m, m});
    Int free = n;
    while (free > m) {
        A.view().fill(0.0);
        std::copy(wanted.begin(), wanted.end(), x.begin());
        for (Int i = 0; i < m; ++i) {
            for (Int k = 0; k < n; ++k) x[i] -= basis(i, k) * base[k];
            for (Int j = 0; j <= i; ++j) {
                double sum = 0.0;
                for (Int k = 0; k < n; ++k) sum += basis(i, k) * metric[k] * basis(j, k);
                A.view()(i, j) = A.view()(j, i) = sum;
            }
        }
        solve_positive(A.view(), Vec(x.data(), {m}));
        for (Int k = 0; k < n; ++k) {
            double change = 0.0;
            for (Int i = 0; i < m; ++i) change += x[i] * basis(i, k);
            weights[k] = base[k] + metric[k] * change;
        }
        for (Int i = 0; i < m; ++i) {
            double sum = -wanted[i];
            for (Int k = 0; k < n; ++k) sum += basis(i, k) * weights[k];
            if (!(std::abs(sum) <= MET * std::abs(wanted[i]) + 1e-9 * wanted[0])) return false;
        }
        const Int before = free;
        for (Int k = 0; k < n; ++k) {
            const double floor = share * given[k];
            if (metric[k] == 0.0 || !(weights[k] < floor)) continue;  // held, or large enough
            base[k] = floor;
            metric[k] = 0.0;
            --free;
        }
        if (free == before) return true;
    }
    return false;
}

// The weights (n,) nearest to ``given`` (n,) with ``basis`` (m, n) @ weights = ``wanted`` (m,): as many of the first
// rows as one of the counts ``matched``, the first count that positive weights can match. If there is none, the weights
// remain as they are.
inline Array<double> corrected(In given, InMat basis, In wanted, InInts matched) {
    Array<double> weights({given.size()});
    for (const Int count : matched) {
        for (const double share : LEAST_SHARES) {
            if (correct(given, basis.part(0, count), wanted.part(0, count), share, weights.view())) return weights;
        }
    }
    std::copy(given.begin(), given.end(), weights.numbers.begin());
    return weights;
}

// Tributary areas of nodes (n, 2) [m] in proportion to ``shares`` (n,), corrected as little as possible so that they
// integrate known ``moments`` (6,) of a face exactly: area, first and second moments, which makes linear pressure
// exact. ``arm`` is the integral of the distance to the centroid, which makes uniform friction against twisting exact.
// If the nodes cannot match all of them, fewer are matched. ``scale`` [m] is the size of the face.
inline Array<double> matched_weights(InMat nodes, In shares, In moments, double arm, double scale) {
    const Int n = nodes.size();
    const double area = moments[0], cx = moments[1] / area, cy = moments[2] / area;
    double whole = 0.0;
    for (const double share : shares) whole += share;
    Array<double> given({n});
    Array<double, 2> basis({7, n});
    const Mat rows = basis.view();
    for (Int k = 0; k < n; ++k) {
        given.numbers[k] = shares[k] / whole * area;
        const double x = (nodes(k, 0) - cx) / scale, y = (nodes(k, 1) - cy) / scale;
        const double at[7] = {1.0, x, y, x * x, x * y, y * y, std::hypot(x, y)};
        for (Int i = 0; i < 7; ++i) rows(i, k) = at[i];
    }
    const double second = scale * scale;
    const double wanted[7] = {area,
                              0.0,
                              0.0,
                              (moments[3] - area * (cx * cx)) / second,
                              (moments[4] - area * (cx * cy)) / second,
                              (moments[5] - area * (cy * cy)) / second,
                              arm / scale};
    constexpr Int counts[] = {7, 6, 3};
    return corrected(given.view(), rows, In(wanted, {7}), InInts(counts, {3}));
}

}  // namespace holdfast
