// Block-sparse elimination of the linear systems of large models, front by front.
//
// The bodies are put into one order for a model, those with few neighbours first (``ordering.hpp``). A front is
// a small dense matrix: the rows and columns of the bodies that it eliminates, and of their neighbours that come later.
// What is left of it after elimination goes to the front in which the first of these neighbours is eliminated
// (passing.hpp; the multifrontal method: Duff & Reid, "The multifrontal solution of indefinite sparse symmetric linear
// equations", ACM Transactions on Mathematical Software 9 (1983)). The border, a load and a condition, is in every
// front and comes last.
//
// A body without resistance has no pivot of its own: pivots that are too small among their columns wait for a later
// front, and at the last one, with the border, all of the matrix that is left is at hand. So what is regular only as a
// whole, as at the peak of a path, is solved as stably as what is regular body by body.

#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "dense.hpp"
#include "elimination.hpp"
#include "linear.hpp"
#include "model.hpp"
#include "passing.hpp"
#include "twists.hpp"

namespace holdfast {

// Add to front k what its own bodies and sheets bring; ``full``: its rows before those that stay
inline void add_own(const Elastic& m, const Work& work, const Fronts& e, Int k, double drag, double corner,
                    double border, Int full, Mat F) {
    const Int owned = e.owned[k], waiting = full - 6 * owned;
    const auto place = [&](Int at) { return 6 * at >= 6 * owned ? 6 * at + waiting : 6 * at; };
    for (Int s = e.since[k]; s < e.since[k + 1]; ++s) {
        add_stiffness(m, e.sheet[s], work.K, drag, place(e.at_a[s]), place(e.at_b[s]), F);
    }
    for (Int slot = 0; slot < owned; ++slot) add_body(m, work, e.body[e.first[k] + slot], drag, border, F, 6 * slot);
    if (k == e.owned.size() - 1) add_corner(work, border, corner, F);
}

// Write the numbers of a front's columns, but for those that wait
inline void number_columns(Int n, const Fronts& e, Int k, Int full, Ints columns) {
    const Int owned = e.owned[k];
    for (Int slot = 0; slot < e.first[k + 1] - e.first[k]; ++slot) {
        const Int at = place_of(slot, owned, full - 6 * owned);
        for (Int i = 0; i < 6; ++i) columns[at + i] = 6 * e.body[e.first[k] + slot] + i;
    }
    columns[columns.size() - 1] = n;
}

// Where the matrix of front k begins in memory: what stays of its rows, if no pivot waits, begins a cache line
inline Int lead(const Fronts& e, Int k) { return lines(6 * e.owned[k]) - 6 * e.owned[k]; }

// Numbers in the rows of front k, of as many as ``size``
inline Int width(const Fronts& e, Int k, Int size) { return lines(lead(e, k) + size + 2); }

// Whether what is left of front k is written to the next front at once: whether that takes from any
inline bool passes_on(const Fronts& e, Int k) { return k + 1 < e.owned.size() && e.begin[k + 1] < e.begin[k + 2]; }

// Add to front k what is left of its children but for the last, and write the numbers of all columns that wait;
// ``own``: its rows before those that stay.
//
// Returns from where on the memory ``left`` is free of these children.
inline Int take_children(const Fronts& e, Int k, Int own, Work& work, Mat F, Ints columns) {
    Int at = 6 * e.owned[k], base = work.left.size();
    for (Int j = e.begin[k]; j < e.begin[k + 1]; ++j) {
        const Int c = e.child[j];
        const Book& book = work.books[c];
        for (Int i = 0; i < book.waits; ++i) columns[at + i] = work.numbers[book.at_number + book.done + i];
        if (c < k - 1) {
            base = std::min(base, book.base);
            const Int pieces = find_pieces(e, c, book.waits, at, k, own, F.size(), work.piece.data());
            add_rows(work.left.data() + book.at_left, width(e, c, book.size), book.size, book.done, F,
                     work.piece.data(), pieces);
        }
        at += book.waits;
    }
    return base;
}

// Copy pivots, and what is above each, from the first rows of ``P`` to a matrix (done, done) in ``into``
inline void keep_pivots(InMat P, double* into, Int done) {
    for (Int c = 0; c < done; ++c) std::copy_n(&P(c, 0), c + 1, into + c * done);
}

// As ``dense_solve``, front by front
inline double fronts_solve(const Elastic& m, Work& work, const Fronts& e, double drag, double corner, double least) {
    const auto reach = [](auto& memory, Int needed) {
        if (needed > static_cast<Int>(memory.size())) memory.resize(static_cast<std::size_t>(2 * needed));
    };
    const Int n = work.w.size(), count = e.owned.size();
    Memory *here = &work.front, *other = &work.other;
    Int top = 0, above = 0, last = 0, full = 0;
    double sign = 1.0;
    const double border = border_unit(work.c, m.unit);
    Mat F, P, X;
    for (Int k = 0; k < count; ++k) {
        Int waiting = 0;
        for (Int j = e.begin[k]; j < e.begin[k + 1]; ++j) waiting += work.books[e.child[j]].waits;
        const Int own = 6 * e.owned[k] + waiting, t = 6 * (e.first[k + 1] - e.first[k]) + waiting + 1;
        const Int row = width(e, k, t), start = lead(e, k), stop = start + t * row;
        const bool last_of_all = k == count - 1, passed = passes_on(e, k) || last_of_all;
        Book& book = work.books[k];
        Mat G;
        if (passed) {
            std::swap(here, other);
            here->reach(stop);
            G = Mat(here->data() + start, {t, row});
        } else {
            book.at_left = top + start;
            book.base = top;
            work.left.reach(top + stop);
            G = Mat(work.left.data() + top + start, {t, row});
            top = lines(top + stop);
        }
        if (e.begin[k] < e.begin[k + 1]) {
            reach(work.place, F.size());
            const Int waits = work.books[k - 1].waits;
            const Int pieces = find_pieces(e, k - 1, waits, own - waits, k, own, t, work.piece.data());
            pass_on(F, P, X, full, G, work.piece.data(), pieces, work.place.data());
        } else {
            std::fill_n(G.data(), t * row, 0.0);
        }
        F = G;
        reach(work.numbers, last + t);
        const Ints columns(work.numbers.data() + last, {t});
        number_columns(n, e, k, own, columns);
        add_own(m, work, e, k, drag, corner, border, own, F);
        const Int free = take_children(e, k, own, work, F, columns);
        if (passed) {
            top = std::min(top, free);
        } else {
            book.base = std::min(book.base, free);
        }
        full = last_of_all ? t : own;
        work.panel.reach(full * t);
        work.upper.reach(above + full * (row + LINE));
        P = Mat(work.panel.data(), {full, t});
        const auto [done, turned] = eliminate(F, P, columns, full, least);
        sign *= turned;
        const Int wide = std::min(lines(t - done + 2), row - done);
        book.size = t;
        book.done = done;
        book.waits = full - done;
        book.wide = wide;
        book.at_number = last;
        book.at_upper = above;
        double* upper = work.upper.data() + above;
        X = Mat(upper, {done, wide});
        finish(F, P, X, full);
        keep_pivots(P, upper + done * wide, done);
        if (!passes_on(e, k)) apply_pivots(F, done, P, X, done, t, full - done);
        last += t;
        above = lines(above + done * (wide + done));
    }
    if (work.books[count - 1].waits > 0) return SINGULAR;
    Int most = 0;
    for (Int k = 0; k < count; ++k) most = std::max(most, work.books[k].size);
    here->reach(2 * most);
    for (Int k = count - 1; k >= 0; --k) {
        const Book& book = work.books[k];
        dense::substitute(work.upper.data() + book.at_upper, book.done, book.wide, work.numbers.data() + book.at_number,
                          book.size, work.rhs.data(), here->data());
    }
    for (Int i = 0; i < n + 1; ++i) {
        const double unit = i < n ? m.unit[i] : 1.0;
        work.rhs(i, 0) *= unit;
        work.rhs(i, 1) *= unit;
        if (!(std::isfinite(work.rhs(i, 0)) && std::isfinite(work.rhs(i, 1)))) return SINGULAR;
    }
    return sign;
}

// Solve the system of ``work`` in place: by ``fronts``, or by dense elimination where there are none.
//
// Returns the sign of the determinant, or SINGULAR; ``least`` is as in ``dense_solve``.
inline double solve(const Elastic& m, Work& work, double drag, double corner, const Fronts* fronts,
                    double least = 0.0) {
    if (fronts == nullptr) return dense_solve(m, work, drag, corner, least);
    return fronts_solve(m, work, *fronts, drag, corner, least);
}

}  // namespace holdfast
