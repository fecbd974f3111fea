// Nodes over a face of any outline: a grid on its smallest rectangle, and points far apart. Places are in the unit
// square of that rectangle, the longer side first.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "grids.hpp"
#include "hull.hpp"
#include "span.hpp"

namespace holdfast {

constexpr double CURVED = 20 * (std::numbers::pi / 180);  // [rad] largest angle of an outline at a corner that belongs
                                                          // to a tessellated curve
constexpr double NEAR_OUTLINE = 0.3;  // [grid steps] grid nodes this near to a node on the outline are dropped
constexpr Int FEWEST_CELLS = 8;       // where fewer are on a face, the corners of its hull count as well
constexpr double SAME_RANK = 1e9;     // squared distances are compared in whole multiples of one over it
constexpr double OPPOSITE = 1e-6;     // how far off the opposite of a point may be

// A face: the corners (n, 2) [m] of its outline and its holes, which begin at ``first`` (R + 1,); the two axes of its
// rectangle, its low corner along them and its sides as rows of ``rectangle`` (4, 2); and the corners (m, 2) of its
// hull in the unit square
struct Face {
    InMat corners;
    InInts first;
    InMat rectangle, hull;
    static constexpr auto fields = std::tuple{&Face::corners, &Face::first, &Face::rectangle, &Face::hull};

    Place flat(const Place& unit) const {
        const double u = rectangle(2, 0) + unit[0] * rectangle(3, 0), v = rectangle(2, 1) + unit[1] * rectangle(3, 1);
        return {u * rectangle(0, 0) + v * rectangle(1, 0), u * rectangle(0, 1) + v * rectangle(1, 1)};
    }
};

// The sign of twice the area of the triangle a, b, c, to twice the digits of a double where those do not tell
inline int turn_of(const Place& a, const Place& b, const Place& c) {
    const double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]);
    const double area = left - right;
    if (std::abs(area) > 4e-16 * (std::abs(left) + std::abs(right))) return area > 0.0 ? 1 : -1;
    using Pair = std::pair<double, double>;  // a number and the rest that rounding took from it
    const auto less = [](double x, double y) {
        const double d = x - y, back = d - x;
        return Pair{d, (x - (d - back)) - (y + back)};
    };
    const auto times = [](const Pair& x, const Pair& y) {
        const double p = x.first * y.first;
        return Pair{p, std::fma(x.first, y.first, -p) + (x.first * y.second + x.second * y.first)};
    };
    const Pair one = times(less(a[0], c[0]), less(b[1], c[1])), other = times(less(a[1], c[1]), less(b[0], c[0]));
    const Pair difference = less(one.first, other.first);
    const double exact = difference.first + (difference.second + (one.second - other.second));
    return (exact > 0.0) - (exact < 0.0);
}

// Whether a point [m] is on a face, or on its outline (by the crossings of a ray to the right), or within ``margin``
inline bool on_face(const Face& face, const Place& at, double margin) {
    bool odd = false;
    double nearest = std::numeric_limits<double>::infinity();
    for (Int ring = 0; ring + 1 < face.first.size(); ++ring) {
        for (Int i = face.first[ring]; i < face.first[ring + 1]; ++i) {
            const Int j = i + 1 < face.first[ring + 1] ? i + 1 : face.first[ring];
            const Place p{face.corners(i, 0), face.corners(i, 1)}, q{face.corners(j, 0), face.corners(j, 1)};
            if (margin > 0.0) {
                const double x = q[0] - p[0], y = q[1] - p[1], length = x * x + y * y;
                const double along = length > 0.0 ? ((at[0] - p[0]) * x + (at[1] - p[1]) * y) / length : 0.0;
                const double t = std::clamp(along, 0.0, 1.0);
                nearest = std::min(nearest, std::hypot(at[0] - (p[0] + t * x), at[1] - (p[1] + t * y)));
            }
            if (p[0] < at[0] && q[0] < at[0]) continue;
            if (at == q) return true;
            if (p[1] == at[1] && q[1] == at[1]) {
                if (std::min(p[0], q[0]) <= at[0] && at[0] <= std::max(p[0], q[0])) return true;
                continue;
            }
            if ((p[1] > at[1]) == (q[1] > at[1])) continue;
            const int turn = turn_of(p, q, at);
            if (turn == 0) return true;
            if ((turn > 0) == (q[1] > p[1])) odd = !odd;
        }
    }
    return odd || nearest <= margin;
}

// Points in the order of their first coordinates, to find the nearest of them
class Sorted {
  public:
    explicit Sorted(InMat points) : points_(points), order_(static_cast<std::size_t>(points.size())) {
        std::iota(order_.begin(), order_.end(), Int{0});
        // one that merges stays inside whatever the numbers are, NaN, too
        std::stable_sort(order_.begin(), order_.end(), [&](Int a, Int b) { return points(a, 0) < points(b, 0); });
    }

    // The number of the point nearest to a place, and whether no other is as near
    std::pair<Int, bool> nearest(double x, double y) const {
        const auto middle = first_from(x);
        double best = std::numeric_limits<double>::infinity();
        Int found = 0;
        bool alone = true;
        const auto look = [&](Int k) {
            const double dx = points_(k, 0) - x, dy = points_(k, 1) - y, d = dx * dx + dy * dy;
            if (d <= best) {
                alone = d < best;
                best = d;
                found = k;
            }
            return dx * dx <= best;
        };
        auto down = middle;
        for (auto up = middle; up != order_.end() && look(*up);) ++up;
        while (down != order_.begin() && look(*--down)) {
        }
        return {found, alone};
    }

    // Whether some point is within ``most`` of a place along both axes
    bool any_within(double x, double y, double most) const {
        for (auto up = first_from(x - 2 * most); up != order_.end() && points_(*up, 0) <= x + 2 * most; ++up) {
            if (std::max(std::abs(points_(*up, 0) - x), std::abs(points_(*up, 1) - y)) <= most) return true;
        }
        return false;
    }

  private:
    std::vector<Int>::const_iterator first_from(double x) const {
        return std::lower_bound(order_.begin(), order_.end(), x, [&](Int k, double at) { return points_(k, 0) < at; });
    }

    InMat points_;
    std::vector<Int> order_;
};

inline InMat rows_of(const std::vector<Place>& places) {
    return {places.empty() ? nullptr : places[0].data(), {static_cast<Int>(places.size()), 2}};
}

// Which of at least one ``point`` (n, 2) is nearest to each of the ``places`` (m, 2), -1 where two are equally near
inline Array<Int> nearest_of(InMat points, InMat places) {
    const Sorted sorted(points);
    Array<Int> found({places.size()});
    for (Int i = 0; i < places.size(); ++i) {
        const auto [nearest, alone] = sorted.nearest(places(i, 0), places(i, 1));
        found.numbers[i] = alone ? nearest : -1;
    }
    return found;
}

// Extend ``chosen`` (k, 2) to ``count`` points; each new one is the candidate (n, 2) farthest from those before it. If
// the candidates are symmetric about the centre, points are added in opposite pairs: otherwise the choice among equally
// distant points, and with it the answer, would depend on how the face is turned.
inline std::vector<Place> farthest_of(InMat candidates, InMat chosen, Int count) {
    const Int n = candidates.size();
    std::vector<Int> opposite(n);
    std::vector<double> distance(n, std::numeric_limits<double>::infinity());
    const Sorted sorted(candidates);
    bool paired = true;
    const auto come_near = [&](double x, double y) {
        for (Int i = 0; i < n; ++i) {
            const double dx = candidates(i, 0) - x, dy = candidates(i, 1) - y;
            distance[i] = std::min(distance[i], dx * dx + dy * dy);
        }
    };
    for (Int i = 0; i < n; ++i) {
        const double x = 1 - candidates(i, 0), y = 1 - candidates(i, 1);
        opposite[i] = sorted.nearest(x, y).first;
        paired = paired && std::max(std::abs(candidates(opposite[i], 0) - x),
                                    std::abs(candidates(opposite[i], 1) - y)) < OPPOSITE;
    }
    std::vector<Place> found;
    for (Int k = 0; k < chosen.size(); ++k) {
        found.push_back({chosen(k, 0), chosen(k, 1)});
        come_near(chosen(k, 0), chosen(k, 1));
    }
    while (static_cast<Int>(found.size()) < count) {
        Int next = 0;
        double most = -1.0;
        for (Int i = 0; i < n; ++i) {
            const double rank = std::nearbyint(distance[i] * SAME_RANK);
            if (rank > most) {
                most = rank;
                next = i;
            }
        }
        if (!(distance[next] > 0.0)) break;
        for (const Int i : {next, opposite[next]}) {
            if (static_cast<Int>(found.size()) < count && distance[i] > 0.0) {
                found.push_back({candidates(i, 0), candidates(i, 1)});
                come_near(candidates(i, 0), candidates(i, 1));
            }
            if (!paired) break;
        }
    }
    return found;
}

// The centres of a grid of ``along`` x ``across`` cells that are on a face, with the corners of the hull if they are
// few
inline std::vector<Place> cells_on(const Face& face, Int along, Int across) {
    std::vector<Place> found;
    for (Int i = 0; i < along; ++i) {
        for (Int j = 0; j < across; ++j) {
            const Place unit{(static_cast<double>(i) + 0.5) / static_cast<double>(along),
                             (static_cast<double>(j) + 0.5) / static_cast<double>(across)};
            if (on_face(face, face.flat(unit), 0.0)) found.push_back(unit);
        }
    }
    if (static_cast<Int>(found.size()) < FEWEST_CELLS) {
        for (Int k = 0; k < face.hull.size(); ++k) found.push_back({face.hull(k, 0), face.hull(k, 1)});
    }
    return found;
}

// The corners of the hull, and points along its edges on the face, at most one of the ``steps`` along both sides of the
// rectangle apart. Edges of a tessellated curve get no points between their corners, because a round rim has no edge on
// which a body could stand.
inline std::vector<Place> outline_of(const Face& face, const Place& steps, double margin) {
    const Int n = face.hull.size();
    std::vector<Place> found;
    std::vector<double> angle(n), turn(n);
    for (Int k = 0; k < n; ++k) {
        const Int next = k + 1 < n ? k + 1 : 0;
        found.push_back({face.hull(k, 0), face.hull(k, 1)});
        angle[k] = std::atan2((face.hull(next, 1) - face.hull(k, 1)) * face.rectangle(3, 1),
                              (face.hull(next, 0) - face.hull(k, 0)) * face.rectangle(3, 0));
    }
    for (Int k = 0; k < n; ++k) {  // the angle at the corner where each edge begins
        constexpr double whole = 2 * std::numbers::pi;
        double by = std::fmod(angle[k] - angle[k > 0 ? k - 1 : n - 1] + std::numbers::pi, whole);
        if (by < 0.0) by += whole;
        turn[k] = std::abs(by - std::numbers::pi);
    }
    for (Int k = 0; k < n; ++k) {
        const Int next = k + 1 < n ? k + 1 : 0;
        if (!(std::max(turn[k], turn[next]) > CURVED)) continue;
        const double x = face.hull(next, 0) - face.hull(k, 0), y = face.hull(next, 1) - face.hull(k, 1);
        const double wide = x * steps[0], high = y * steps[1];
        const double pieces = std::ceil(std::sqrt(wide * wide + high * high) - 0.01);
        for (double i = 1; i < pieces; ++i) {
            const Place at{face.hull(k, 0) + i / pieces * x, face.hull(k, 1) + i / pieces * y};
            if (on_face(face, face.flat(at), margin)) found.push_back(at);
        }
    }
    return found;
}

// A grid of ``across`` x ``along`` nodes on a face or within ``margin`` [m] of it, with nodes on its outline, of which
// those farthest from each other are left if there are more than ``most``
inline std::vector<Place> nodes_on(const Face& face, Int across, Int along, Int most, double margin) {
    const Place steps{static_cast<double>(across - 1), static_cast<double>(along - 1)};
    auto nodes = outline_of(face, steps, margin);
    if (static_cast<Int>(nodes.size()) > most) {
        nodes = farthest_of(rows_of(nodes), rows_of({nodes[0]}), std::max<Int>(4, most));
    }
    auto stepped = nodes;
    for (auto& [x, y] : stepped) {
        x *= steps[0];
        y *= steps[1];
    }
    const Sorted outline(rows_of(stepped));
    for (Int i = 0; i < across; ++i) {
        for (Int j = 0; j < along; ++j) {
            const Place at{evenly(i, across), evenly(j, along)};
            if (on_face(face, face.flat(at), margin) &&
                !outline.any_within(at[0] * steps[0], at[1] * steps[1], NEAR_OUTLINE)) {
                nodes.push_back(at);
            }
        }
    }
    return nodes;
}

// The same places as numbers (n, 2)
inline Array<double, 2> as_rows(const std::vector<Place>& places) {
    Array<double, 2> found({static_cast<Int>(places.size()), 2});
    for (std::size_t i = 0; i < places.size(); ++i) {
        found.numbers[2 * i] = places[i][0];
        found.numbers[2 * i + 1] = places[i][1];
    }
    return found;
}

}  // namespace holdfast
