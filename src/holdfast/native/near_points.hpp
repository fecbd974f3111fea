// Near points of two bodies, as rows (n, NEAR_ROW): those that others explain, and a few that lie far apart.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "facing_triangles.hpp"
#include "span.hpp"

namespace holdfast {

constexpr double TURNED = 0.3;  // relative to the smaller body: distance that a unit difference of normals counts as
constexpr double LEAN = 0.05;   // [rad] a point with a gap is chosen if a smaller rotation would close the gap
constexpr Int MOST_CHOSEN = 5;  // near points of two bodies that are chosen: the corners of a face and one more
constexpr double BESIDE = 1.5;  // [depths of the overlap] distance up to which another point may explain an overlap
constexpr double SAME_DEPTH = 1.05;  // largest ratio of two depths of one overlap, or of its depth to the extent of the
                                     // solid along it

// Tell in ``good`` (n,) which near points, the deepest first, are not explained by a smaller overlap or gap nearby.
//
// If a corner is inside another body, it has an overlap with every face nearby, but only the nearest face should push
// it out. At a thin wall, the far side would push a body the wrong way, so only the nearer side counts. Scans have
// folded triangles that face inwards on the outside; their overlap is about as deep as the gap to which it belongs.
// ``alike`` is the cosine of the largest angle between normals of the same contact.
inline void mark_unexplained(InMat rows, double alike, Span<bool> good) {
    for (Int i = 0; i < rows.size(); ++i) {
        const In one = rows[i];
        good[i] = true;
        const double depth = -one[6];
        if (depth <= 0) continue;
        const double reach = BESIDE * depth;
        for (Int j = i + 1; j < rows.size(); ++j) {
            const In other = rows[j];
            if (other[6] > SAME_DEPTH * depth) break;
            double cosine = 0.0, apart2 = 0.0;
            for (int k = 0; k < 3; ++k) {
                cosine += one[3 + k] * other[3 + k];
                apart2 += (one[k] - other[k]) * (one[k] - other[k]);
            }
            const bool beside = other[6] >= 0 ? cosine < -alike : -other[6] < 0.999 * depth;
            if (beside && cosine < alike && apart2 <= reach * reach) {
                good[i] = false;
                break;
            }
        }
    }
}

// The numbers of at most MOST_CHOSEN near points that are far from each other and nearly touch, the deepest first.
//
// Each further point has the largest distance from those before it, minus its gap over LEAN. Points with different
// normals count as farther apart. No two of them are closer than ``same``. ``size`` [m] is that of the smaller body.
inline Array<Int> spread_points(InMat rows, double size, double same) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    std::vector<double> apart(static_cast<std::size_t>(rows.size()), inf);
    Array<Int> kept;
    const double turned2 = (TURNED * size) * (TURNED * size);
    for (Int chosen = 0; rows.size() > 0 && chosen >= 0 && std::ssize(kept.numbers) < MOST_CHOSEN;) {
        kept.numbers.push_back(chosen);
        const In before = rows[chosen];
        double best = -inf;
        chosen = -1;
        for (Int i = 0; i < rows.size(); ++i) {
            const In here = rows[i];
            double place2 = 0.0, turn2 = 0.0;
            for (int k = 0; k < 3; ++k) {
                place2 += (here[k] - before[k]) * (here[k] - before[k]);
                turn2 += (here[3 + k] - before[3 + k]) * (here[3 + k] - before[3 + k]);
            }
            apart[i] = std::min(apart[i], std::sqrt(place2 + turn2 * turned2));
            const double worth = apart[i] - std::max(here[6], 0.0) / LEAN;
            if (apart[i] > same && worth > best) {
                best = worth;
                chosen = i;
            }
        }
    }
    kept.sizes[0] = std::ssize(kept.numbers);
    return kept;
}

}  // namespace holdfast
