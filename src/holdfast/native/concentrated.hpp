// Whether what presses a contact is concentrated on few of its nodes (``engines/compliant/grid.py``).

#pragma once

#include <algorithm>
#include <limits>

#include "law.hpp"
#include "model.hpp"

namespace holdfast {

constexpr double COUNTS =
    1e-3;  // smallest share of the largest force on either body that a contact must carry to count

// Write into ``found`` (k, C) whether C contacts of bodies ``a`` and ``b`` (C,) count and are concentrated at each of
// the displacements ``q`` (k, 6J): fewer nodes than ``most`` (C,) are few.
//
// The nodes of contact c are those from ``first[c]`` to ``first[c + 1] - 1``.
inline void concentrated(const Elastic& m, InInts first, InInts a, InInts b, In most, InMat q,
                         Span<unsigned char, 2> found) {
    const Int count = a.size();
    Array<double, 2> forces({m.k.size(), 3});
    Array<double> totals({count}), all_squares({count}), most_of_body({q.size(1) / 6});
    const Mat f = forces.view();
    const Vec total = totals.view(), squares = all_squares.view(), largest = most_of_body.view();
    for (Int row = 0; row < q.size(); ++row) {
        node_forces(m, q[row], f);
        for (const Vec& one : {total, squares, largest}) one.fill(0.0);
        for (Int c = 0; c < count; ++c) {
            for (Int i = first[c]; i < first[c + 1]; ++i) {
                total[c] += f(i, 0);
                squares[c] += f(i, 0) * f(i, 0);
            }
            for (const Int body : {a[c], b[c]}) {
                if (body >= 0) largest[body] = std::max(largest[body], total[c]);
            }
        }
        for (Int c = 0; c < count; ++c) {
            double least = std::numeric_limits<double>::infinity();
            for (const Int body : {a[c], b[c]}) {
                if (body >= 0) least = std::min(least, largest[body]);
            }
            found(row, c) = total[c] > COUNTS * least && total[c] * total[c] < most[c] * squares[c];
        }
    }
}

}  // namespace holdfast
