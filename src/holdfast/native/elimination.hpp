// Elimination within a front (fronts.hpp): pivots by columns, those too small left waiting, and rows in blocks.

#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "dense.hpp"
#include "span.hpp"

namespace holdfast {

constexpr double SMALL_PIVOT = 0.02;  // share of a column's largest entry below which no entry is used as pivot

// Copy rows ``low`` to ``high`` - 1 of a matrix, their columns ``start`` to ``stop`` - 1, to columns of another.
//
// Four rows come at a time, for each line of memory of the other matrix is then fetched less often.
inline void transpose(InMat A, Mat B, Int low, Int high, Int start, Int stop) {
    Int i = low;
    for (; i + 4 <= high; i += 4) {
        const double *a = &A(i, 0), *b = &A(i + 1, 0), *c = &A(i + 2, 0), *d = &A(i + 3, 0);
        for (Int j = start; j < stop; ++j) {
            double* to = &B(j, i);
            to[0] = a[j];
            to[1] = b[j];
            to[2] = c[j];
            to[3] = d[j];
        }
    }
    for (; i < high; ++i) {
        for (Int j = start; j < stop; ++j) B(j, i) = A(i, j);
    }
}

// Apply BLOCK pivots from j on, with rows ``X``, to rows ``low`` to ``high`` - 1 of a front, by their factors: that of
// pivot i to a row is factors[i * by_pivot + row * by_row].
//
// Columns of F from ``shift`` on go with those of X; the first ``skip`` of these are done with.
inline void take_block(Mat F, Int shift, const double* factors, Int by_pivot, Int by_row, InMat X, Int j, Int low,
                       Int high, Int skip) {
    dense::take_block(F.data() + low * F.steps()[0] + shift + skip, F.steps()[0], high - low,
                      factors + j * by_pivot + low * by_row, by_pivot, by_row, X.data() + j * X.steps()[0] + skip,
                      X.steps()[0], X.size(1) - skip);
}

// Apply pivots ``first`` to ``done`` - 1, at most BLOCK, to columns ``ahead`` to ``full`` - 1: rows of ``P``
inline void catch_up(Mat P, Int first, Int done, Int ahead, Int full) {
    const Int size = P.size(1);
    for (Int c = ahead; c < full; ++c) dense::solve_above(P.data(), P.steps()[0], first, done, &P(c, 0));
    if (ahead >= full || first >= done || done >= size) return;
    if (done - first == dense::BLOCK) {
        take_block(P, 0, P.data(), 1, P.steps()[0], P, first, ahead, full, done);
        return;
    }
    for (Int j = first; j < done; ++j) {
        for (Int c = ahead; c < full; ++c) dense::take(&P(c, done), P(c, j), &P(j, done), size - done);
    }
}

// Exchange two rows from column ``start`` on
inline void swap_rows(Mat F, Int start, Int one, Int two) {
    double* a = F.data() + one * F.steps()[0];
    std::swap_ranges(a + start, a + F.size(1), F.data() + two * F.steps()[0] + start);
}

// Eliminate in a front (t, at least t + 2) what its first ``full`` rows and columns allow, pivots above ``least``.
//
// Returns the number of pivots, which come first in the new order of rows and columns, and the sign of their product
// and of the new order. Columns t and t + 1 are right-hand sides. The first ``full`` columns are worked on as rows of
// ``P`` (full, t), along which memory runs: they hold the pivots, what is above them, and the factors of the rows
// below. Other columns have their rows in the new order, and are else as they were.
//
// Pivots are applied at once to as many columns as may follow them in a block, to later ones with their whole block.
inline std::pair<Int, double> eliminate(Mat F, Mat P, Ints columns, Int full, double least) {
    const Int size = F.size();
    transpose(F, P, 0, size, 0, full);
    Int done = 0, last = full, before = 0;
    double sign = 1.0;
    Int first = 0, ahead = std::min(dense::BLOCK, full);  // columns from ``ahead`` on lack the pivots from ``first`` on
    while (done < full) {
        if (done == last) {  // the rest failed: after other pivots they may not
            if (done == before) break;
            before = done;
            last = full;
        }
        if (done == ahead) {
            catch_up(P, first, done, ahead, full);
            first = done;
            ahead = std::min(done + dense::BLOCK, full);
        }
        double* column = &P(done, 0);
        double best = 0.0;
        Int pivot = done;
        for (Int i = done; i < full; ++i) {
            const double here = std::abs(column[i]);
            if (here > best) {
                best = here;
                pivot = i;
            }
        }
        if (!dense::all_within(column + full, best / SMALL_PIVOT, size - full) || !(best > least)) {
            catch_up(P, first, done, ahead, full);
            first = done;
            ahead = std::min(done + dense::BLOCK, full);
            --last;
            if (last != done) {
                swap_rows(P, 0, done, last);
                std::swap(columns[done], columns[last]);
                sign = -sign;
            }
            continue;
        }
        if (pivot != done) {
            for (Int c = 0; c < full; ++c) std::swap(P(c, done), P(c, pivot));
            swap_rows(F, full, done, pivot);
            sign = -sign;
        }
        if (column[done] < 0) sign = -sign;
        const Int rest = size - done - 1;
        double* below = column + done + 1;
        dense::multiply(below, 1 / column[done], rest);
        for (Int c = done + 1; c < ahead; ++c) dense::take(&P(c, 0) + done + 1, P(c, done), below, rest);
        ++done;
    }
    catch_up(P, first, done, ahead, full);
    return {done, sign};
}

// Write the rows of the pivots that ``eliminate`` found to ``X`` (done, at least t + 2 - done), from them on.
//
// Columns that wait are written to the other rows of the front. The rows of pivots come BLOCK by BLOCK, and one by one
// within a block, for each needs those before it.
inline void finish(Mat F, InMat P, Mat X, Int full) {
    const Int size = F.size(), done = X.size(), skip = full - done, many = done - done % dense::BLOCK;
    for (Int i = 0; i < done; ++i) {
        double* into = &X(i, 0);
        for (Int j = 0; j < skip; ++j) into[j] = P(done + j, i);
        std::copy_n(&F(i, full), X.size(1) - skip, into + skip);
    }
    transpose(P, F, done, full, done, size);
    const Int width = X.steps()[0], by_pivot = P.steps()[0];
    for (Int first = 0; first < many; first += dense::BLOCK) {
        dense::take_own(&X(first, skip), width, &P(first, first), by_pivot, X.size(1) - skip);
        take_block(X, 0, P.data(), by_pivot, 1, X, first, first + dense::BLOCK, done, skip);
    }
    for (Int i = many + 1; i < done; ++i) {
        for (Int j = many; j < i; ++j) dense::take(&X(i, skip), P(j, i), &X(j, skip), X.size(1) - skip);
    }
}

// Apply all pivots, with rows ``X``, to rows ``low`` to ``high`` - 1 of a front.
//
// Columns of F from ``shift`` on go with those of X; the first ``skip`` of these are done with.
inline void apply_pivots(Mat F, Int shift, InMat P, InMat X, Int low, Int high, Int skip) {
    const Int done = X.size(), many = done - done % dense::BLOCK;
    for (Int first = 0; first < many; first += dense::BLOCK) {
        take_block(F, shift, P.data(), P.steps()[0], 1, X, first, low, high, skip);
    }
    for (Int j = many; j < done; ++j) {
        for (Int i = low; i < high; ++i) {
            dense::take(&F(i, shift + skip), P(j, i), &X(j, skip), X.size(1) - skip);
        }
    }
}

}  // namespace holdfast
