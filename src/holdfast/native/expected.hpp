// Whether a model, its fronts and its memory that Python hands over fit each other: else it is a ValueError.

#pragma once

#include "linear.hpp"
#include "model.hpp"

namespace holdfast {

inline void expect_runs(const Runs& runs, Int sheets, Int nodes) {
    expect(runs.node.size() > 0 && runs.box.size() == runs.node.size() - 1 && runs.box.size(1) == 5,
           "a box of five numbers for each run");
    expect_begins(runs.first, sheets, runs.box.size(), "the runs of each sheet in order");
    expect_begins(runs.node, runs.box.size(), nodes, "the nodes of each run in order");
}

inline void expect_model(const Elastic& m) {
    const Int sheets = m.a.size(), nodes = m.x.size(), n = m.wrench.size();
    expect(n % 6 == 0, "six numbers for each body");
    expect(m.y.size() == nodes && m.k.size() == nodes && m.apart.size() == nodes, "as many numbers as nodes");
    expect(m.b.size() == sheets && m.mu.size() == sheets, "as many numbers as sheets");
    expect(m.axes.sizes() == std::array<Int, 3>{sheets, 3, 3}, "three axes for each sheet");
    expect(m.arm_a.sizes() == std::array<Int, 2>{sheets, 3} && m.arm_b.sizes() == m.arm_a.sizes(),
           "two arms for each sheet");
    expect(m.bonded.sizes() == std::array<Int, 3>{sheets, 6, 6}, "a stiffness for each sheet");
    for (const In one : {m.scale, m.unit, m.hold, m.still}) expect(one.size() == n, "as many numbers as displacements");
    expect_begins(m.first, sheets, nodes, "the nodes of each sheet in order");
    expect_indices(m.a, n / 6, "a known body", -1);
    expect_indices(m.b, n / 6, "a known body", -1);
    expect_runs(m.runs, sheets, nodes);
}

// A vector, or what is made for one displacement of a model
inline void expect_displacement(const Elastic& m, In q) {
    expect(q.size() == m.wrench.size(), "as many numbers as displacements");
}

// Fronts for ``n`` displacements and as many ``sheets``
inline void expect_fronts(const Fronts& e, Int n, Int sheets) {
    const Int count = e.owned.size();
    expect(count > 0, "a front");
    expect_begins(e.first, count, e.body.size(), "the bodies of each front in order");
    expect_begins(e.begin, count, e.child.size(), "the children of each front in order");
    expect_begins(e.since, count, e.sheet.size(), "the sheets of each front in order");
    expect(e.onward.size() == e.body.size(), "a place for each body of a front");
    expect(e.at_a.size() == e.sheet.size() && e.at_b.size() == e.sheet.size(), "two places for each sheet of a front");
    expect_indices(e.body, n / 6, "a known body");
    expect_indices(e.sheet, sheets, "a known sheet");
    expect(e.owned[count - 1] == 0, "a last front without bodies of its own");
    for (Int k = 0; k < count; ++k) {
        const Int bodies = e.first[k + 1] - e.first[k];
        expect(e.owned[k] >= 0 && e.owned[k] <= bodies, "a front's own bodies among its bodies");
        for (Int s = e.since[k]; s < e.since[k + 1]; ++s) {
            expect(e.at_a[s] >= -1 && e.at_a[s] < bodies && e.at_b[s] >= -1 && e.at_b[s] < bodies,
                   "the bodies of a front's sheets among its bodies");
        }
        for (Int j = e.begin[k]; j < e.begin[k + 1]; ++j) {
            const Int c = e.child[j];
            expect(c >= 0 && c < k && (c < k - 1) == (j < e.begin[k + 1] - 1), "a front right after its last child");
            expect(c == k - 1 || e.begin[c + 1] == e.begin[c + 2], "what is left of a child where it was kept");
            for (Int slot = e.first[c] + e.owned[c]; slot < e.first[c + 1]; ++slot) {
                expect(e.onward[slot] >= 0 && e.onward[slot] < bodies,
                       "what is left of a child among a front's bodies");
            }
        }
    }
}

// Memory that was made for a model, and for fronts or none
inline void expect_work(const Work& work, const Elastic& m, const Fronts* fronts) {
    expect(work.w.size() == m.wrench.size() && work.K.size() == m.a.size(), "memory made for a model of this size");
    expect((work.A.size() == 0) == (fronts != nullptr), "memory made for fronts, or for none");
    if (fronts == nullptr) return;
    expect_fronts(*fronts, m.wrench.size(), m.a.size());
    for (Int s = 0; s < fronts->sheet.size(); ++s) {
        const Int p = fronts->sheet[s];
        expect((fronts->at_a[s] < 0) == (m.a[p] < 0) && (fronts->at_b[s] < 0) == (m.b[p] < 0),
               "a place in a front for each free body of a sheet");
    }
    Int most = 0;
    for (Int k = 0; k < fronts->owned.size(); ++k) most = std::max(most, fronts->first[k + 1] - fronts->first[k]);
    expect(
        static_cast<Int>(work.books.size()) == fronts->owned.size() && static_cast<Int>(work.piece.size()) >= most + 2,
        "memory made for these fronts");
}

}  // namespace holdfast
