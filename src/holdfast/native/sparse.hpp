// The entries of the stiffness of a model (``elastic/model.py``), and how far bodies move at rest.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "model.hpp"
#include "twists.hpp"

namespace holdfast {

// Write the entries of the stiffness, in the ``unit`` of the model, sheet by sheet; returns how many there are.
//
// Of each sheet they are those of body b and body a, but for fixed ones.
inline Int write_entries(const Elastic& m, InTen K, Ints rows, Ints columns, Vec values) {
    std::array<double, 144> block;
    const Mat B(block.data(), {12, 12});
    Int count = 0;
    for (Int p = 0; p < m.a.size(); ++p) {
        B.fill(0.0);
        const Int ends[2] = {m.b[p], m.a[p]};
        add_stiffness(m, p, K, 0.0, ends[1] >= 0 ? 6 : -1, ends[0] >= 0 ? 0 : -1, B);
        for (int i = 0; i < 12; ++i) {
            for (int j = 0; j < 12; ++j) {
                const Int one = ends[i / 6], other = ends[j / 6];
                if (one < 0 || other < 0) continue;
                rows[count] = 6 * one + i % 6;
                columns[count] = 6 * other + j % 6;
                values[count] = B(i, j);
                ++count;
            }
        }
    }
    return count;
}

// The largest displacement at rest, q (n,), of the bodies that no hold keeps or that the ``load`` (n,) acts on.
//
// A ball sinks a thousand times as deep into its point as boxes into each other, and says nothing about them.
inline double elastic_size(const Elastic& m, In q, In load) {
    double every = 0.0, found = 0.0;
    for (Int body = 0; body < q.size() / 6; ++body) {
        double far = 0.0;
        bool counts = false;
        for (Int i = 6 * body; i < 6 * body + 6; ++i) {
            far = std::max(far, std::abs(q[i]));
            counts = counts || m.hold[i] == 0.0 || load[i] != 0.0;
        }
        every = std::max(every, far);
        if (counts) found = std::max(found, far);
    }
    return std::max(found > 0.0 ? found : every, 1e-300);
}

}  // namespace holdfast
