// Which bodies of a scene are near each other, by their bounding boxes.

#pragma once

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "search_mesh.hpp"
#include "span.hpp"

namespace holdfast {

// The pairs (m, 2) of bodies whose ``boxes`` (n, 2, 3) [m] come within ``gap`` [m], sorted, and how far (m,) [m] their
// boxes overlap along the axis of least overlap, negative where they are apart. Pairs of bodies that are both ``fixed``
// (n,) and pairs of which none is ``asked`` (n,) for are left out.
inline std::tuple<Array<Int, 2>, Array<double>> near_bodies(InTen boxes, Span<const bool> fixed, Span<const bool> asked,
                                                            double gap) {
    const Int n = boxes.size();
    Array<double, 2> low({n, 3}), high({n, 3});
    for (Int i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
            low.view()(i, k) = boxes(i, 0, k) - gap / 2;
            high.view()(i, k) = boxes(i, 1, k) + gap / 2;
        }
    }
    const Boxes wider{std::as_const(low).view(), std::as_const(high).view()};
    double extent[3] = {};
    for (int k = 0; k < 3 && n > 0; ++k) {
        double least = wider.low(0, k), largest = least;
        for (Int i = 1; i < n; ++i) {
            least = std::min(least, wider.low(i, k));
            largest = std::max(largest, wider.low(i, k));
        }
        extent[k] = largest - least;
    }
    const Int axis = std::max_element(extent, extent + 3) - extent;
    const auto length = [&](Int i) { return wider.high(i, axis) - wider.low(i, axis); };
    std::vector<Int> all(static_cast<std::size_t>(n)), order;
    std::iota(all.begin(), all.end(), Int{0});
    std::vector<double> lengths;
    for (Int i : all) {
        lengths.push_back(length(i));
        if (asked[i]) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](Int i, Int j) { return wider.low(i, axis) < wider.low(j, axis); });
    const auto middle = lengths.begin() + n / 2;
    std::nth_element(lengths.begin(), middle, lengths.end());
    std::vector<std::pair<Int, Int>> found;
    for (const bool large : {false, true}) {  // a floor is near to everything, so large bodies are searched separately
        std::vector<Int> part;
        for (Int j : order) {
            if ((length(j) > LARGE_BOX * *middle) == large) part.push_back(j);
        }
        each_near(wider, all, wider, part, axis, 0.0, [&](Int i, Int j) {
            if ((i < j || !asked[i]) && !(fixed[i] && fixed[j])) found.emplace_back(std::min(i, j), std::max(i, j));
        });
    }
    std::sort(found.begin(), found.end());
    const Int m = std::ssize(found);
    Array<Int, 2> pairs({m, 2});
    Array<double> shared({m});
    for (Int p = 0; p < m; ++p) {
        const auto [i, j] = found[static_cast<std::size_t>(p)];
        pairs.view()(p, 0) = i;
        pairs.view()(p, 1) = j;
        for (int k = 0; k < 3; ++k) {
            const double along = std::min(boxes(i, 1, k), boxes(j, 1, k)) - std::max(boxes(i, 0, k), boxes(j, 0, k));
            shared.numbers[p] = k == 0 ? along : std::min(shared.numbers[p], along);
        }
    }
    return {std::move(pairs), std::move(shared)};
}

}  // namespace holdfast
