// How the nodes of sheets are cut into runs (``elastic/model.py``).

#pragma once

#include <algorithm>
#include <limits>

#include "span.hpp"

namespace holdfast {

constexpr Int RUN = 7;  // nodes that are examined together: a row of the usual grid, and a whole fraction of a row of
                        // finer grids

// How many runs there are of sheets with nodes from ``first`` (P + 1,) on
inline Int count_runs(InInts first) {
    Int count = 0;
    for (Int p = 0; p < first.size() - 1; ++p) count += (first[p + 1] - first[p] + RUN - 1) / RUN;
    return count;
}

// Write the runs as ``Runs`` (model.hpp) has them: ``begins`` (P + 1,), and ``node`` and ``box`` of as many as there
// are
inline void cut(InInts first, In x, In y, In apart, Ints begins, Ints node, Mat box) {
    constexpr double INF = std::numeric_limits<double>::infinity();
    const Int sheets = first.size() - 1;
    Int count = 0;
    for (Int p = 0; p < sheets; ++p) {
        begins[p] = count;
        for (Int at = first[p]; at < first[p + 1]; at += RUN) {
            node[count] = at;
            const auto around = box[count];
            around[0] = around[2] = around[4] = INF;
            around[1] = around[3] = -INF;
            for (Int i = at; i < std::min(at + RUN, first[p + 1]); ++i) {
                around[0] = std::min(around[0], x[i]);
                around[1] = std::max(around[1], x[i]);
                around[2] = std::min(around[2], y[i]);
                around[3] = std::max(around[3], y[i]);
                around[4] = std::min(around[4], apart[i]);
            }
            ++count;
        }
    }
    begins[sheets] = count;
    node[count] = first[sheets];
}

}  // namespace holdfast
