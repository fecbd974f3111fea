// What is left of a front after elimination goes to the front that takes it (fronts.hpp), piece by piece.
//
// The last of the fronts that one takes from comes right before it: what is left of it is written to where the other
// one will stand, row by row while the processor still holds them, and zeros to where nothing goes. What is left of the
// others is kept until then, and added.

#pragma once

#include <algorithm>

#include "elimination.hpp"
#include "linear.hpp"
#include "model.hpp"

namespace holdfast {

constexpr Int ROWS = 32;  // rows that take over all pivots of a block before the next rows are read

// Where the rows of a body begin in a front whose own bodies are followed by ``waiting`` rows
inline Int place_of(Int slot, Int owned, Int waiting) { return slot < owned ? 6 * slot : 6 * slot + waiting; }

// Write one more piece, or make the last one longer; returns their number
inline Int with_piece(Piece* piece, Int count, Int start, Int length, Int to) {
    if (length == 0) return count;
    if (count > 0) {
        Piece& last = piece[count - 1];
        if (last.start + last.length == start && last.to + last.length == to) {
            last.length += length;
            return count;
        }
    }
    piece[count] = {start, length, to};
    return count + 1;
}

// Find which rows and columns of what is left of a ``child`` stay together in front k, of ``size`` rows.
//
// The first ``waits`` wait for a pivot, and go to the place ``at``; ``full``: rows of front k before those that stay.
// Writes into ``piece`` (as many as bodies, and two), and returns their number. The last ends with the border and two
// right-hand sides.
inline Int find_pieces(const Fronts& e, Int child, Int waits, Int at, Int k, Int full, Int size, Piece* piece) {
    const Int owned = e.owned[k];
    Int i = waits, count = with_piece(piece, 0, 0, waits, at);
    for (Int slot = e.first[child] + e.owned[child]; slot < e.first[child + 1]; ++slot) {
        count = with_piece(piece, count, i, 6, place_of(e.onward[slot], owned, full - 6 * owned));
        i += 6;
    }
    return with_piece(piece, count, i, 3, size - 1);
}

// Copy the pieces of a ``row`` to another one, of ``width`` numbers, which is zero but for them
inline void move_row(const double* row, double* into, Int width, const Piece* piece, Int count) {
    std::fill_n(into, width, 0.0);
    for (Int p = 0; p < count; ++p) std::copy_n(row + piece[p].start, piece[p].length, into + piece[p].to);
}

// Apply the pivots of a front to its other rows, and write these, by ``count`` pieces, to another matrix ``G``.
//
// ``F``, ``P`` and ``X`` are as ``eliminate`` and ``finish`` leave them; G holds anything before, and zeros where
// nothing comes to. ``place`` (as many as rows) is scratch.
inline void pass_on(Mat F, InMat P, InMat X, Int full, Mat G, const Piece* piece, Int count, Int* place) {
    const Int done = X.size(), size = F.size();
    Int end = 0;
    for (Int p = 0; p < count; ++p) {
        const auto [start, length, to] = piece[p];
        for (Int i = end; i < to; ++i) G[i].fill(0.0);  // where nothing comes to, or what is written below
        for (Int i = 0; i < std::min(length, size - done - start); ++i) place[start + i] = to + i;
        end = to + length;
    }
    for (Int low = done; low < size; low += ROWS) {
        const Int high = std::min(low + ROWS, size);
        apply_pivots(F, done, P, X, low, high, full - done);
        for (Int i = low; i < high; ++i) move_row(&F(i, done), &G(place[i - done], 0), G.size(1), piece, count);
    }
}

// Add to a front, by ``count`` pieces, what ``done`` pivots left of another one: (size, width), in ``left``
inline void add_rows(const double* left, Int width, Int size, Int done, Mat F, const Piece* piece, Int count) {
    for (Int p = 0; p < count; ++p) {
        const Int start = done + piece[p].start;
        for (Int i = 0; i < std::min(piece[p].length, size - start); ++i) {
            const double* row = left + (start + i) * width + done;
            double* into = &F(piece[p].to + i, 0);
            for (Int q = 0; q < count; ++q) {
                const double* here = row + piece[q].start;
                double* there = into + piece[q].to;
                for (Int j = 0; j < piece[q].length; ++j) there[j] += here[j];
            }
        }
    }
}

}  // namespace holdfast
