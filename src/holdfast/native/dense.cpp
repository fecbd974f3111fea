// The innermost loops of elimination. Products and sums may be fused in this file alone (CMakeLists.txt).

#include "dense.hpp"

#include <cmath>
#include <utility>

#include "wide.hpp"

#if defined(_MSC_VER)
#define HOLDFAST_INLINE __forceinline
#define HOLDFAST_ALONE __restrict
#else
#define HOLDFAST_INLINE inline __attribute__((always_inline))
#define HOLDFAST_ALONE __restrict__
#endif

// Before a loop: what one turn of it writes, no other reads. Some compilers would check it for a few rows and give up
// for more.
#if defined(__clang__)
#define HOLDFAST_APART _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define HOLDFAST_APART _Pragma("GCC ivdep")
#else
#define HOLDFAST_APART __pragma(loop(ivdep))
#endif

namespace holdfast::dense {

namespace {

// Memory that is written to or read by this name alone
using Row = double* HOLDFAST_ALONE;
using Other = const double* HOLDFAST_ALONE;

// Write into ``Y`` (6, 6) ``X`` (6, 6) times a body's shift by an ``arm`` (3,), columns in its ``unit`` (6,)
HOLDFAST_INLINE void shift_columns(Other X, Other arm, Other unit, Row Y) {
    const double x = arm[0], y = arm[1], z = arm[2];
    for (int i = 0; i < 6; ++i) {
        const double one = X[6 * i], two = X[6 * i + 1], three = X[6 * i + 2];
        Y[6 * i] = one * unit[0];
        Y[6 * i + 1] = two * unit[1];
        Y[6 * i + 2] = three * unit[2];
        Y[6 * i + 3] = (X[6 * i + 3] + y * three - z * two) * unit[3];
        Y[6 * i + 4] = (X[6 * i + 4] + z * one - x * three) * unit[4];
        Y[6 * i + 5] = (X[6 * i + 5] + x * two - y * one) * unit[5];
    }
}

// Add ``sign`` times a body's transposed shift times ``Y`` (6, 6), rows in its ``unit`` (6,), to part of a matrix
HOLDFAST_INLINE void add_shifted_rows(Other Y, Other arm, Other unit, double sign, Row A, Int width) {
    const double x = arm[0], y = arm[1], z = arm[2];
    const double u0 = sign * unit[0], u1 = sign * unit[1], u2 = sign * unit[2];
    const double u3 = sign * unit[3], u4 = sign * unit[4], u5 = sign * unit[5];
    for (int j = 0; j < 6; ++j) {
        const double one = Y[j], two = Y[6 + j], three = Y[12 + j];
        A[j] += u0 * one;
        A[width + j] += u1 * two;
        A[2 * width + j] += u2 * three;
        A[3 * width + j] += u3 * (Y[18 + j] + y * three - z * two);
        A[4 * width + j] += u4 * (Y[24 + j] + z * one - x * three);
        A[5 * width + j] += u5 * (Y[30 + j] + x * two - y * one);
    }
}

}  // namespace

HOLDFAST_WIDE
void take(double* row_, double factor, const double* other_, Int count) {
    const Row row = row_;
    const Other other = other_;
    if (factor == 0.0) return;
    HOLDFAST_APART
    for (Int c = 0; c < count; ++c) row[c] -= factor * other[c];
}

HOLDFAST_WIDE
void multiply(double* row, double factor, Int count) {
    HOLDFAST_APART
    for (Int c = 0; c < count; ++c) row[c] *= factor;
}

HOLDFAST_WIDE
bool all_within(const double* row, double limit, Int count) {
    Int beyond = 0;
    HOLDFAST_APART
    for (Int c = 0; c < count; ++c) beyond += !(std::abs(row[c]) <= limit);
    return beyond == 0;
}

HOLDFAST_WIDE
void solve_above(const double* P, Int width, Int first, Int done, double* column) {
    for (Int i = first + 1; i < done; ++i) {
        double here = column[i];
        for (Int j = first; j < i; ++j) here -= column[j] * P[j * width + i];
        column[i] = here;
    }
}

HOLDFAST_WIDE
void take_own(double* x, Int x_width, const double* factors, Int p_width, Int count) {
    const Other x0 = x;
    const Row x1 = x + x_width, x2 = x1 + x_width, x3 = x2 + x_width, x4 = x3 + x_width, x5 = x4 + x_width;
    const double *f0 = factors, *f1 = f0 + p_width, *f2 = f1 + p_width, *f3 = f2 + p_width, *f4 = f3 + p_width;
    const double b0 = f0[1], c0 = f0[2], d0 = f0[3], e0 = f0[4], g0 = f0[5];
    const double c1 = f1[2], d1 = f1[3], e1 = f1[4], g1 = f1[5];
    const double d2 = f2[3], e2 = f2[4], g2 = f2[5];
    const double e3 = f3[4], g3 = f3[5], g4 = f4[5];
    HOLDFAST_APART
    for (Int k = 0; k < count; ++k) {
        const double y0 = x0[k];
        const double y1 = x1[k] - b0 * y0;
        const double y2 = x2[k] - (c0 * y0 + c1 * y1);
        const double y3 = x3[k] - (d0 * y0 + d1 * y1 + d2 * y2);
        const double y4 = x4[k] - (e0 * y0 + e1 * y1 + e2 * y2 + e3 * y3);
        x1[k] = y1;
        x2[k] = y2;
        x3[k] = y3;
        x4[k] = y4;
        x5[k] -= g0 * y0 + g1 * y1 + g2 * y2 + g3 * y3 + g4 * y4;
    }
}

HOLDFAST_WIDE
void take_block(double* F, Int width, Int rows, const double* factors, Int by_pivot, Int by_row, const double* x,
                Int x_width, Int count) {
    const Other x0 = x, x1 = x0 + x_width, x2 = x1 + x_width, x3 = x2 + x_width, x4 = x3 + x_width, x5 = x4 + x_width;
    Int i = 0;
    for (; i + 4 <= rows; i += 4) {
        const Row a = F + i * width, b = a + width, c = b + width, d = c + width;
        const double* f = factors + i * by_row;
        const double a0 = f[0], a1 = f[by_pivot], a2 = f[2 * by_pivot];
        const double a3 = f[3 * by_pivot], a4 = f[4 * by_pivot], a5 = f[5 * by_pivot];
        f += by_row;
        const double b0 = f[0], b1 = f[by_pivot], b2 = f[2 * by_pivot];
        const double b3 = f[3 * by_pivot], b4 = f[4 * by_pivot], b5 = f[5 * by_pivot];
        f += by_row;
        const double c0 = f[0], c1 = f[by_pivot], c2 = f[2 * by_pivot];
        const double c3 = f[3 * by_pivot], c4 = f[4 * by_pivot], c5 = f[5 * by_pivot];
        f += by_row;
        const double d0 = f[0], d1 = f[by_pivot], d2 = f[2 * by_pivot];
        const double d3 = f[3 * by_pivot], d4 = f[4 * by_pivot], d5 = f[5 * by_pivot];
        HOLDFAST_APART
        for (Int k = 0; k < count; ++k) {
            const double y0 = x0[k], y1 = x1[k], y2 = x2[k], y3 = x3[k], y4 = x4[k], y5 = x5[k];
            a[k] -= a0 * y0 + a1 * y1 + a2 * y2 + a3 * y3 + a4 * y4 + a5 * y5;
            b[k] -= b0 * y0 + b1 * y1 + b2 * y2 + b3 * y3 + b4 * y4 + b5 * y5;
            c[k] -= c0 * y0 + c1 * y1 + c2 * y2 + c3 * y3 + c4 * y4 + c5 * y5;
            d[k] -= d0 * y0 + d1 * y1 + d2 * y2 + d3 * y3 + d4 * y4 + d5 * y5;
        }
    }
    for (; i < rows; ++i) {
        const Row a = F + i * width;
        const double* f = factors + i * by_row;
        const double a0 = f[0], a1 = f[by_pivot], a2 = f[2 * by_pivot];
        const double a3 = f[3 * by_pivot], a4 = f[4 * by_pivot], a5 = f[5 * by_pivot];
        HOLDFAST_APART
        for (Int k = 0; k < count; ++k) {
            a[k] -= a0 * x0[k] + a1 * x1[k] + a2 * x2[k] + a3 * x3[k] + a4 * x4[k] + a5 * x5[k];
        }
    }
}

HOLDFAST_WIDE
void substitute(const double* rows, Int done, Int width, const Int* columns, Int size, double* solution,
                double* memory) {
    const Int rest = size - done;
    const Row one = memory, two = memory + size;
    for (Int j = done; j < size; ++j) {
        one[j] = solution[2 * columns[j]];
        two[j] = solution[2 * columns[j] + 1];
    }
    const double *x = one + done, *y = two + done;
    Int i = 0;
    for (; i + 4 <= done; i += 4) {
        const double *p = rows + i * width, *q = p + width, *r = q + width, *s = r + width;
        double p0 = p[rest], q0 = q[rest], r0 = r[rest], s0 = s[rest];
        double p1 = p[rest + 1], q1 = q[rest + 1], r1 = r[rest + 1], s1 = s[rest + 1];
        for (Int j = 0; j < rest; ++j) {
            p0 -= p[j] * x[j];
            q0 -= q[j] * x[j];
            r0 -= r[j] * x[j];
            s0 -= s[j] * x[j];
            p1 -= p[j] * y[j];
            q1 -= q[j] * y[j];
            r1 -= r[j] * y[j];
            s1 -= s[j] * y[j];
        }
        one[i] = p0;
        one[i + 1] = q0;
        one[i + 2] = r0;
        one[i + 3] = s0;
        two[i] = p1;
        two[i + 1] = q1;
        two[i + 2] = r1;
        two[i + 3] = s1;
    }
    for (; i < done; ++i) {
        const double* p = rows + i * width;
        double p0 = p[rest], p1 = p[rest + 1];
        for (Int j = 0; j < rest; ++j) {
            p0 -= p[j] * x[j];
            p1 -= p[j] * y[j];
        }
        one[i] = p0;
        two[i] = p1;
    }
    for (Int c = done - 1; c >= 0; --c) {
        const double* above = rows + done * width + c * done;
        const double a = one[c] / above[c], b = two[c] / above[c];
        for (Int k = 0; k < c; ++k) {
            one[k] -= above[k] * a;
            two[k] -= above[k] * b;
        }
        solution[2 * columns[c]] = a;
        solution[2 * columns[c] + 1] = b;
    }
}

HOLDFAST_WIDE
double eliminate_all(double* A, Int width, Int size, double least) {
    double sign = 1.0;
    for (Int c = 0; c < size; ++c) {
        Int pivot = c;
        double best = std::abs(A[c * width + c]);
        for (Int i = c + 1; i < size; ++i) {
            const double here = std::abs(A[i * width + c]);
            if (here > best) {
                best = here;
                pivot = i;
            }
        }
        if (!(best > least)) return 0.0;
        const Int count = width - c;
        const Row above = A + c * width + c;
        if (pivot != c) {
            sign = -sign;
            const Row other = A + pivot * width + c;
            HOLDFAST_APART
            for (Int j = 0; j < count; ++j) std::swap(above[j], other[j]);
        }
        if (above[0] < 0) sign = -sign;
        const double inverse = 1 / above[0];
        for (Int i = c + 1; i < size; ++i) {
            const Row row = A + i * width + c;
            const double factor = row[0] * inverse;
            if (factor != 0.0) {
                HOLDFAST_APART
                for (Int j = 0; j < count; ++j) row[j] -= factor * above[j];
            }
        }
    }
    for (Int c = size - 1; c >= 0; --c) {
        double* own = A + c * width;
        const double one = own[size] / own[c], two = own[size + 1] / own[c];
        own[size] = one;
        own[size + 1] = two;
        for (Int i = 0; i < c; ++i) {
            double* row = A + i * width;
            row[size] -= row[c] * one;
            row[size + 1] -= row[c] * two;
        }
    }
    return sign;
}

HOLDFAST_WIDE
void add_turned(double* X, const double* R, Side a, Side b, double* A, Int width) {
    double Y[36];
    for (int half = 0; half < 6; half += 3) {  // Y = Rᵀ X, and X = Y R
        const double* rows = X + 6 * half;
        for (int i = 0; i < 3; ++i) {
            const double one = R[i], two = R[3 + i], three = R[6 + i];
            double* into = Y + 6 * (half + i);
            for (int j = 0; j < 6; ++j) into[j] = one * rows[j] + two * rows[6 + j] + three * rows[12 + j];
        }
    }
    for (int i = 0; i < 6; ++i) {
        for (int half = 0; half < 6; half += 3) {
            const double* from = Y + 6 * i + half;
            const double one = from[0], two = from[1], three = from[2];
            for (int j = 0; j < 3; ++j) X[6 * i + half + j] = one * R[j] + two * R[3 + j] + three * R[6 + j];
        }
    }
    if (b.at >= 0) {
        shift_columns(X, b.arm, b.unit, Y);
        add_shifted_rows(Y, b.arm, b.unit, 1.0, A + b.at * width + b.at, width);
        if (a.at >= 0) add_shifted_rows(Y, a.arm, a.unit, -1.0, A + a.at * width + b.at, width);
    }
    if (a.at >= 0) {
        shift_columns(X, a.arm, a.unit, Y);
        add_shifted_rows(Y, a.arm, a.unit, 1.0, A + a.at * width + a.at, width);
        if (b.at >= 0) add_shifted_rows(Y, b.arm, b.unit, -1.0, A + b.at * width + a.at, width);
    }
}

}  // namespace holdfast::dense
