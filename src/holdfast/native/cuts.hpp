// The pairs of bodies that are bridges of the graph of contacts.

#pragma once

#include <algorithm>
#include <tuple>
#include <vector>

#include "span.hpp"

namespace holdfast {

// Bridges, those nearer to the fixed bodies first: the body ``root`` (B,) on the way to them, those ``beyond``, which
// hang on nothing else, that of the contact first, and the ``interfaces``. Those of bridge k begin at ``begin[k]`` and
// at ``since[k]``.
struct Cuts {
    std::vector<Int> root, begin{0}, beyond, since{0}, interface;
};

// The bridges between ``count`` bodies that interfaces with these ``ends`` (I, 2) connect; all fixed bodies are -1.
//
// Depth first from the fixed bodies: a pair is a bridge if nothing behind it leads back past it (Tarjan, 1974).
inline Cuts cuts_of(Int count, InIntMat ends) {
    using Pair = std::tuple<Int, Int, Int>;  // of an interface: both bodies, the smaller number first, and its own
    std::vector<Pair> pairs(static_cast<std::size_t>(ends.size()));
    for (Int k = 0; k < ends.size(); ++k) {
        pairs[k] = {std::min(ends(k, 0), ends(k, 1)), std::max(ends(k, 0), ends(k, 1)), k};
    }
    std::sort(pairs.begin(), pairs.end());
    struct Group {
        Int first, low, high;
        std::size_t from, to;
    };
    std::vector<Group> groups;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const auto [low, high, number] = pairs[k];
        if (groups.empty() || groups.back().low != low || groups.back().high != high) {
            groups.push_back({number, low, high, k, k});
        }
        groups.back().to = k + 1;
    }
    std::sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.first < b.first; });
    struct Way {
        Int other;
        const Group* pair;
    };
    std::vector<std::vector<Way>> near(static_cast<std::size_t>(count) + 1);  // the fixed bodies come first
    for (const Group& each : groups) {
        near[each.low + 1].push_back({each.high, &each});
        near[each.high + 1].push_back({each.low, &each});
    }
    struct Step {
        Int body, before;
        const Group* by;
        std::size_t next;
    };
    struct Bridge {
        Int order, root;
        const Group* pair;
        Int behind;  // how many bodies
    };
    std::vector<Int> order(near.size(), -1), low(near.size(), -1), visited{-1};
    std::vector<Bridge> found;
    std::vector<Step> path{{-1, -1, nullptr, 0}};
    order[0] = low[0] = 0;
    while (!path.empty()) {
        Step& here = path.back();
        const Int body = here.body, before = here.before;
        if (here.next == near[body + 1].size()) {
            const Group* by = here.by;
            path.pop_back();
            if (path.empty()) break;
            low[before + 1] = std::min(low[before + 1], low[body + 1]);
            if (low[body + 1] > order[before + 1]) {
                found.push_back({order[body + 1], before, by, static_cast<Int>(visited.size()) - order[body + 1]});
            }
            continue;
        }
        const auto [other, pair] = near[body + 1][here.next++];
        if (order[other + 1] < 0) {
            order[other + 1] = low[other + 1] = static_cast<Int>(visited.size());
            visited.push_back(other);
            path.push_back({other, body, pair, 0});
        } else if (other != before) {
            low[body + 1] = std::min(low[body + 1], order[other + 1]);
        }
    }
    std::sort(found.begin(), found.end(), [](const Bridge& a, const Bridge& b) { return a.order < b.order; });
    Cuts cuts;
    for (const auto& [first, root, pair, behind] : found) {
        cuts.root.push_back(root);
        cuts.beyond.insert(cuts.beyond.end(), visited.begin() + first, visited.begin() + first + behind);
        cuts.begin.push_back(static_cast<Int>(cuts.beyond.size()));
        for (std::size_t k = pair->from; k < pair->to; ++k) cuts.interface.push_back(std::get<2>(pairs[k]));
        cuts.since.push_back(static_cast<Int>(cuts.interface.size()));
    }
    return cuts;
}

}  // namespace holdfast
