// The innermost loops of elimination, on plain memory: rows of a matrix are ``width`` numbers apart.
//
// They are compiled apart from everything else, for several kinds of processors where that is possible, and products
// and sums may be fused there (one rounding, not two). No two arguments that are written to or read overlap, unless it
// is said.

#pragma once

#include "span.hpp"

namespace holdfast::dense {

constexpr Int BLOCK = 6;  // number of pivots that are applied together

// Take ``factor`` times another row away from one, of ``count`` numbers
void take(double* row, double factor, const double* other, Int count);

// Multiply a row of ``count`` numbers by a ``factor``
void multiply(double* row, double factor, Int count);

// Whether all of a row of ``count`` numbers are at most a ``limit``, and none is NaN
bool all_within(const double* row, double limit, Int count);

// Apply pivots ``first`` to ``done`` - 1 to each other's rows of a ``column``; P holds the factors by columns
void solve_above(const double* P, Int width, Int first, Int done, double* column);

// Apply BLOCK pivots with rows ``x``, of ``count`` numbers, to each other's rows; ``factors`` are a block of P, by
// columns
void take_own(double* x, Int x_width, const double* factors, Int p_width, Int count);

// Apply BLOCK pivots with rows ``x``, of ``count`` numbers, to ``rows`` rows from F on. That of pivot j to row i is
// factors[j * by_pivot + i * by_row]. Four rows come at a time: what is read once serves many products.
void take_block(double* F, Int width, Int rows, const double* factors, Int by_pivot, Int by_row, const double* x,
                Int x_width, Int count);

// Find the unknowns of a front's pivots; those of its later columns are in ``solution`` (n + 1, 2) by then.
//
// ``rows`` (done, width), in one row, are as ``finish`` leaves them, and ``keep_pivots`` what follows; ``memory`` has
// room for twice ``size`` numbers.
void substitute(const double* rows, Int done, Int width, const Int* columns, Int size, double* solution,
                double* memory);

// Solve for the right-hand sides in columns t and t + 1 of a matrix with t rows, in place; what follows is unused.
//
// Returns the sign of the determinant, or 0 where no pivot of a column is above ``least``.
double eliminate_all(double* A, Int width, Int size, double least);

// One of both bodies of a sheet: where its rows and columns begin, negative for a fixed one, its arm (3,) and unit (6,)
struct Side {
    Int at;
    const double *arm, *unit;
};

// Add [Tb, -Ta]ᵀ X [Tb, -Ta] to a matrix ``A``, where R (3, 3) are the axes of the sheet; X (6, 6) is lost
void add_turned(double* X, const double* R, Side a, Side b, double* A, Int width);

}  // namespace holdfast::dense
