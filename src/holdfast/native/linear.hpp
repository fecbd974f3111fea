// The linear systems of a path: the stiffness bordered by a load and by a condition on the displacement.
//
//     [ K + ε D + H   -w ] [x]
//     [     cᵀ         d ] [s]
//
// K is the stiffness of the contacts as they are, D that of bonded contacts; both are sums over sheets of 6x6 blocks,
// and D has a diagonal besides, where bodies on ice are bonded to the world. H is the diagonal of the regularisation
// spring. ε is called ``drag`` and d ``corner``. Small systems are solved by dense elimination, large ones front by
// front (fronts.hpp).

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "dense.hpp"
#include "model.hpp"
#include "twists.hpp"

namespace holdfast {

constexpr Int LINE = 8;            // numbers in a cache line
constexpr double SPARE = 1.3;      // memory for delayed pivots, relative to what is needed if no pivot is delayed
constexpr Int APART = 2 * LINE;    // numbers between the memories of two threads, so that they share no cache line
constexpr double BORDER = 0.01;    // largest entry of the border's row: others are of order one, and pivots are not to
                                   // come from it
constexpr double ROUNDED = 1e-14;  // pivots up to this size are nothing but rounding, where entries are of order one
constexpr double SINGULAR = 0.0;   // the sign of the determinant of a system that has no unique solution

// As many numbers, or a few more, so that they end where a cache line does
inline Int lines(Int count) { return (count + LINE - 1) / LINE * LINE; }

// Memory that begins where a cache line does, and shares none with any other
class Memory {
  public:
    Memory() = default;
    explicit Memory(Int size) { resize(size); }
    Memory(const Memory&) = delete;
    Memory(Memory&&) = delete;

    double* data() const { return data_; }
    Int size() const { return size_; }

    // Make room for as many numbers as are ``needed``, and keep those that are there
    void reach(Int needed) {
        if (needed > size_) resize(2 * needed);
    }

    // Make room for ``size`` numbers, more than before
    void resize(Int size) {
        std::vector<double> larger(static_cast<std::size_t>(size + 3 * APART));
        const auto before = reinterpret_cast<std::uintptr_t>(larger.data()) / sizeof(double) % LINE;
        double* data = larger.data() + APART + (LINE - static_cast<Int>(before)) % LINE;
        std::copy_n(data_, size_, data);
        numbers_.swap(larger);
        data_ = data;
        size_ = size;
    }

  private:
    std::vector<double> numbers_;
    double* data_ = nullptr;
    Int size_ = 0;
};

// Rows or columns of what is left of a front that stay together: where they begin, how many, and where they go
struct Piece {
    Int start, length, to;
};

// What is written down of every front
struct Book {
    Int size = 0;       // its rows
    Int done = 0;       // pivots
    Int waits = 0;      // those that wait
    Int at_left = 0;    // where its matrix begins in the memory of those that stay,
    Int base = 0;       // which is free from here on when it has been taken
    Int at_number = 0;  // where the numbers of its columns begin
    Int at_upper = 0;   // where the rows of its pivots begin,
    Int wide = 0;       // of as many numbers each
};

// A system of n = 6J displacements, and memory to work in.
//
// ``K`` (P, 6, 6); ``w``, ``c`` (n,); ``rhs`` (n + 1, 2) two right-hand sides, which become the solutions. ``A``
// (n + 1, at least n + 3) holds the matrix of dense elimination and both of them; it is empty where there are fronts.
// ``r`` (n,) is the unbalance at a displacement (newton.hpp), ``trial`` (n,) a displacement tried; ``v``, ``F`` (6,) a
// sheet's twist and wrench.
//
// Fronts need memory for what is ``left`` of those that are taken later, for the ``upper`` triangle, for two that are
// worked on, ``front`` and ``other``, and for a ``panel``; and for whole numbers: the ``numbers`` of columns, the
// ``place`` of rows, and ``piece`` by piece what goes where. ``books`` are those of the fronts.
//
// The rows of ``A`` begin where cache lines do: elimination takes half as long again where they begin anywhere. So does
// the memory for fronts.
struct Work {
    Memory block;
    Ten K;
    Vec w, c, r, trial, v, F;
    Mat rhs, A;
    Memory left, upper, front, other, panel;
    std::vector<Int> numbers, place;
    std::vector<Piece> piece;
    std::vector<Book> books;

    Work(Int n, Int sheets, const Fronts* fronts)
        : block(36 * sheets + 4 * n + 2 * (n + 1) + 12 + (fronts == nullptr ? (n + 1) * lines(n + 3) : 0)) {
        double* at = block.data();
        const auto next = [&at](Int count) {
            double* here = at;
            at += count;
            return here;
        };
        const Int rows = fronts == nullptr ? n + 1 : 0, width = fronts == nullptr ? lines(n + 3) : 0;
        A = Mat(next(rows * width), {rows, width});
        K = Ten(next(36 * sheets), {sheets, 6, 6});
        for (Vec* one : {&w, &c, &r, &trial}) *one = Vec(next(n), {n});
        rhs = Mat(next(2 * (n + 1)), {n + 1, 2});
        v = Vec(next(6), {6});
        F = Vec(next(6), {6});
        if (fronts != nullptr) make_room(*fronts);
    }

  private:
    // Room for what fronts need if few pivots wait
    void make_room(const Fronts& e) {
        Int stays = 0, pivots = 0, one = 0, columns = 0, most = 0;
        const Int count = e.owned.size();
        for (Int k = 0; k < count; ++k) {
            const Int bodies = e.first[k + 1] - e.first[k], size = 6 * bodies + 1, kept = 6 * e.owned[k];
            const Int width = size + 3 * LINE;  // what it takes to begin and end where cache lines do
            const bool alone = k + 1 < count && e.begin[k + 1] == e.begin[k + 2];  // before one that takes from none
            stays += alone ? size * width : 0;
            pivots += kept * width;
            one = std::max(one, size * width);
            columns = std::max(columns, kept * size);
            most = std::max(most, bodies);
        }
        const auto spare = [](Int needed) {
            return lines(static_cast<Int>(std::ceil(SPARE * static_cast<double>(needed))));
        };
        left.resize(spare(stays));
        upper.resize(spare(pivots));
        front.resize(spare(one));
        other.resize(spare(one));
        panel.resize(spare(columns));
        numbers.resize(static_cast<std::size_t>(6 * e.body.size() + count));
        place.resize(static_cast<std::size_t>(6 * most + 1));
        piece.resize(static_cast<std::size_t>(most + 2));
        books.resize(static_cast<std::size_t>(count));
    }
};

// What the border's row is multiplied by, besides the ``unit`` of its columns
inline double border_unit(In row, In unit) {
    double top = 0.0;
    for (Int i = 0; i < row.size(); ++i) top = std::max(top, std::abs(unit[i] * row[i]));
    return top > 0 ? BORDER / top : 1.0;
}

// Add to a matrix (t, t + 2 or more) what a body brings besides contacts, in its rows and columns from ``at`` on.
//
// That is its hold, its own share of the drag, the border in row and column t - 1, and the right-hand sides in columns
// t and t + 1; ``border`` is what the border's row is multiplied by.
inline void add_body(const Elastic& m, const Work& work, Int body, double drag, double border, Mat A, Int at) {
    const Int last = A.size() - 1;
    for (Int i = 0; i < 6; ++i) {
        const Int here = 6 * body + i, place = at + i;
        const double unit = m.unit[here];
        A(place, place) += unit * unit * (m.hold[here] + drag * m.still[here]);
        A(place, last) -= unit * work.w[here];
        A(last, place) += border * unit * work.c[here];
        A(place, last + 1) += unit * work.rhs(here, 0);
        A(place, last + 2) += unit * work.rhs(here, 1);
    }
}

// Add to a matrix as ``add_body`` has it what the border's row brings where it meets no body
inline void add_corner(const Work& work, double border, double corner, Mat A) {
    const Int last = A.size() - 1, n = work.w.size();
    A(last, last) += border * corner;
    A(last, last + 1) += border * work.rhs(n, 0);
    A(last, last + 2) += border * work.rhs(n, 1);
}

// Solve the system of ``work`` in place by Gauss elimination with scaling and pivoting.
//
// Returns the sign of the determinant, or SINGULAR where no pivot is above ``least``: 0 where any step will do, ROUNDED
// where a solution that only rounding makes unique is none.
inline double dense_solve(const Elastic& m, Work& work, double drag, double corner, double least) {
    const Mat A = work.A, rhs = work.rhs;
    const Int n = work.w.size();
    std::fill_n(A.data(), A.size(0) * A.size(1), 0.0);
    for (Int p = 0; p < m.a.size(); ++p) add_stiffness(m, p, work.K, drag, 6 * m.a[p], 6 * m.b[p], A);
    const double border = border_unit(work.c, m.unit);
    for (Int body = 0; body < n / 6; ++body) add_body(m, work, body, drag, border, A, 6 * body);
    add_corner(work, border, corner, A);
    const double sign = dense::eliminate_all(A.data(), A.size(1), n + 1, least);
    for (Int i = 0; i < n + 1; ++i) {
        const double scale = i < n ? m.unit[i] : 1.0;
        rhs(i, 0) = scale * A(i, n + 1);
        rhs(i, 1) = scale * A(i, n + 2);
    }
    return sign;
}

}  // namespace holdfast
