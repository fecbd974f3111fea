// The outline of what a few convex pieces cover together, which meet and overlap as clipped triangles do.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "span.hpp"

namespace holdfast {

constexpr Int MOST_SIDES = 256;  // of all pieces: each is compared with each

// Rings of a polygon (n, 2), one after the other, with their ``ends``: those around what is covered counter-clockwise,
// those of holes clockwise. ``known`` tells whether they are.
struct Outlines {
    Array<double, 2> corners;
    Array<Int> ends;
    bool known = false;
};

// An arrangement of the sides of pieces: what lies within ``near`` is the same point, or on the same line
class Overlay {
  public:
    explicit Overlay(double near) : near_(near) {}

    // Add a convex piece; tell whether it is one. What is no wider than a line is left out.
    bool add(InMat corners, Int start, Int stop) {
        std::vector<Int> piece;
        for (Int i = start; i < stop; ++i) {
            const Int at = point(corners(i, 0), corners(i, 1));
            if (piece.empty() || piece.back() != at) piece.push_back(at);
        }
        while (piece.size() > 1 && piece.front() == piece.back()) piece.pop_back();
        if (piece.size() < 3) return true;
        double area = 0;
        for (std::size_t i = 1; i + 1 < piece.size(); ++i) area += turn(piece[0], piece[i], piece[i + 1]);
        if (area < 0) std::reverse(piece.begin(), piece.end());
        const Int number = std::ssize(pieces_);
        for (std::size_t i = 0; i < piece.size(); ++i) {
            const Int from = piece[i], to = piece[(i + 1) % piece.size()];
            for (Int corner : piece) {
                if (turn(from, to, corner) < -near_ * length(from, to)) return false;
            }
            sides_.push_back({from, to, number, {}});
        }
        pieces_.push_back(std::move(piece));
        return true;
    }

    Outlines outlines() {
        cross();
        return chained();
    }

  private:
    struct Side {
        Int from, to, piece;
        std::vector<std::pair<double, Int>> between;  // points on it, by their places along it
        bool has(Int p) const {
            return p == from || p == to || std::ranges::any_of(between, [&](auto& on) { return on.second == p; });
        }
    };

    Int point(double x, double y) {
        for (std::size_t i = 0; i < points_.size(); ++i) {
            if (std::hypot(points_[i][0] - x, points_[i][1] - y) <= near_) return static_cast<Int>(i);
        }
        points_.push_back({x, y});
        return std::ssize(points_) - 1;
    }

    double length(Int p, Int q) const {
        return std::hypot(points_[q][0] - points_[p][0], points_[q][1] - points_[p][1]);
    }

    // Twice the area of the triangle of three points, positive if it is counter-clockwise
    double turn(Int p, Int q, Int r) const {
        const auto &a = points_[p], &b = points_[q], &c = points_[r];
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    }

    // Note the point on a side if it is there and not at an end
    void put(Side& side, Int p) const {
        if (side.has(p)) return;
        const auto &a = points_[side.from], &b = points_[side.to], &c = points_[p];
        const double whole = length(side.from, side.to);
        if (std::abs(turn(side.from, side.to, p)) > near_ * whole) return;
        const double at = ((c[0] - a[0]) * (b[0] - a[0]) + (c[1] - a[1]) * (b[1] - a[1])) / whole;
        if (at > 0 && at < whole) side.between.push_back({at, p});
    }

    // Find the corners on sides, and where sides cross
    void cross() {
        for (Side& side : sides_) {
            for (Int p = 0; p < std::ssize(points_); ++p) put(side, p);
        }
        const Int corners = std::ssize(points_);
        for (std::size_t i = 0; i < sides_.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                Side &one = sides_[i], &other = sides_[j];
                if (one.piece == other.piece || one.has(other.from) || one.has(other.to)) continue;
                if (other.has(one.from) || other.has(one.to)) continue;
                const double a = turn(one.from, one.to, other.from), b = turn(one.from, one.to, other.to);
                const double c = turn(other.from, other.to, one.from), d = turn(other.from, other.to, one.to);
                if ((a > 0) == (b > 0) || (c > 0) == (d > 0)) continue;
                const double t = a / (a - b);
                const auto p = points_[other.from], q = points_[other.to];
                const Int at = point(p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]));
                put(one, at);
                put(other, at);
            }
        }
        for (Side& side : sides_) {
            for (Int p = corners; p < std::ssize(points_); ++p) put(side, p);
        }
    }

    // Tell whether the middle between two points is inside one of the pieces, but those ``beside``
    bool inside(Int p, Int q, const std::vector<Int>& beside) const {
        const double x = (points_[p][0] + points_[q][0]) / 2, y = (points_[p][1] + points_[q][1]) / 2;
        for (Int k = 0; k < std::ssize(pieces_); ++k) {
            if (std::ranges::find(beside, k) != beside.end()) continue;
            const auto& piece = pieces_[k];
            bool in = true;
            for (std::size_t i = 0; in && i < piece.size(); ++i) {
                const auto &a = points_[piece[i]], &b = points_[piece[(i + 1) % piece.size()]];
                in = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) > 0;
            }
            if (in) return true;
        }
        return false;
    }

    // Chain the parts of sides that have a piece on one side only
    Outlines chained() {
        std::map<std::pair<Int, Int>, std::array<std::vector<Int>, 2>> parts;  // pieces on the left, on the right
        for (Side& side : sides_) {
            std::sort(side.between.begin(), side.between.end());
            side.between.push_back({0.0, side.to});
            Int from = side.from;
            for (const auto& [at, to] : side.between) {
                parts[std::minmax(from, to)][from < to ? 0 : 1].push_back(side.piece);
                from = to;
            }
        }
        std::vector<std::pair<Int, Int>> found;  // with what is covered on the left
        for (const auto& [ends, pieces] : parts) {
            std::array<bool, 2> on{};  // a piece on both sides is no wider than a line there
            std::vector<Int> beside;
            for (int k = 0; k < 2; ++k) {
                for (Int piece : pieces[k]) {
                    on[k] = on[k] || std::ranges::find(pieces[1 - k], piece) == pieces[1 - k].end();
                    beside.push_back(piece);
                }
            }
            if (on[0] == on[1] || inside(ends.first, ends.second, beside)) continue;
            found.push_back(on[0] ? ends : std::pair{ends.second, ends.first});
        }
        return rings(found);
    }

    // Chain parts to rings. Where several meet at a point, rings pass it so that what is covered is connected there.
    Outlines rings(const std::vector<std::pair<Int, Int>>& parts) const {
        Outlines found{Array<double, 2>({0, 2}), Array<Int>({0})};
        const Int none = -1, count = std::ssize(parts);
        std::vector<std::vector<Int>> leaving(points_.size());
        for (Int k = 0; k < count; ++k) leaving[parts[k].first].push_back(k);
        std::vector<Int> next(parts.size(), none);
        std::vector<bool> follows(parts.size());
        for (Int k = 0; k < count; ++k) {
            const auto [from, at] = parts[k];
            const auto angle = [&](Int p) {
                return std::atan2(points_[p][1] - points_[at][1], points_[p][0] - points_[at][0]);
            };
            double least = std::numeric_limits<double>::infinity();
            for (Int other : leaving[at]) {  // the first counter-clockwise: nothing is covered before it
                double turned = leaving[at].size() > 1 ? angle(parts[other].second) - angle(from) : 1.0;
                if (turned <= 0) turned += 2 * std::numbers::pi;
                if (turned < least) {
                    least = turned;
                    next[k] = other;
                }
            }
            if (next[k] == none || follows[next[k]]) return found;  // not closed
            follows[next[k]] = true;
        }
        for (Int first = 0; first < count; ++first) {
            if (next[first] == none) continue;
            for (Int k = first; next[k] != none; k = std::exchange(next[k], none)) {
                const auto& corner = points_[parts[k].first];
                found.corners.numbers.insert(found.corners.numbers.end(), corner.begin(), corner.end());
                ++found.corners.sizes[0];
            }
            found.ends.numbers.push_back(found.corners.sizes[0]);
        }
        found.ends.sizes[0] = std::ssize(found.ends.numbers);
        found.known = count > 0;
        return found;
    }

    double near_;
    std::vector<std::array<double, 2>> points_;
    std::vector<std::vector<Int>> pieces_;
    std::vector<Side> sides_;
};

// The outlines of the union of pieces, whose corners and sides meet within ``near``;
// piece p has the corners from ``ends[p - 1]`` up to, not including, ``ends[p]``; not known if they are many, if one is
// not convex, or if rounding contradicts itself
inline Outlines outlines_of(InMat corners, InInts ends, double near) {
    Overlay overlay(near);
    if (corners.size() > MOST_SIDES) return {Array<double, 2>({0, 2}), Array<Int>({0})};
    for (Int piece = 0; piece < ends.size(); ++piece) {
        if (!overlay.add(corners, piece > 0 ? ends[piece - 1] : 0, ends[piece])) {
            return {Array<double, 2>({0, 2}), Array<Int>({0})};
        }
    }
    return overlay.outlines();
}

// The number of the group (n,) of each piece; pieces of two groups, as ``outlines_of`` takes them, are more than
// ``apart`` from each other. They are separated by a line along the side of a piece, so there may be fewer groups than
// possible.
inline Array<Int> groups_apart(InMat corners, InInts ends, double apart) {
    const Int count = ends.size();
    const auto start_of = [&](Int piece) { return piece > 0 ? ends[piece - 1] : 0; };
    Array<double, 2> boxes({count, 4});  // least x and y, largest x and y
    const Mat box = boxes.view();
    for (Int piece = 0; piece < count; ++piece) {
        for (Int m = 0; m < 2; ++m) {
            box(piece, m) = std::numeric_limits<double>::infinity();
            box(piece, m + 2) = -box(piece, m);
            for (Int i = start_of(piece); i < ends[piece]; ++i) {
                box(piece, m) = std::min(box(piece, m), corners(i, m));
                box(piece, m + 2) = std::max(box(piece, m + 2), corners(i, m));
            }
        }
    }
    const auto beside = [&](Int one, Int other) {  // tell whether a side of ``one`` has ``other`` beyond ``one``
        const Int start = start_of(one), stop = ends[one];
        for (Int i = start; i < stop; ++i) {
            const Int j = i + 1 < stop ? i + 1 : start;
            const double x = corners(j, 0) - corners(i, 0), y = corners(j, 1) - corners(i, 1);
            double own[] = {0, 0}, theirs[] = {std::numeric_limits<double>::infinity(), 0};
            theirs[1] = -theirs[0];
            for (Int k = start; k < stop; ++k) {
                const double left = x * (corners(k, 1) - corners(i, 1)) - y * (corners(k, 0) - corners(i, 0));
                own[0] = std::min(own[0], left);
                own[1] = std::max(own[1], left);
            }
            for (Int k = start_of(other); k < ends[other]; ++k) {
                const double left = x * (corners(k, 1) - corners(i, 1)) - y * (corners(k, 0) - corners(i, 0));
                theirs[0] = std::min(theirs[0], left);
                theirs[1] = std::max(theirs[1], left);
            }
            if (std::max(theirs[0] - own[1], own[0] - theirs[1]) > apart * std::hypot(x, y)) return true;
        }
        return false;
    };
    std::vector<Int> root(static_cast<std::size_t>(count));
    std::iota(root.begin(), root.end(), Int{0});
    const auto of = [&](Int piece) {
        while (root[piece] != piece) piece = root[piece] = root[root[piece]];
        return piece;
    };
    for (Int one = 0; one < count; ++one) {
        for (Int other = 0; other < one; ++other) {
            if (of(one) == of(other)) continue;
            bool far = false;
            for (Int m = 0; m < 2; ++m) {
                far = far || box(one, m) > box(other, m + 2) + apart || box(other, m) > box(one, m + 2) + apart;
            }
            if (far || beside(one, other) || beside(other, one)) continue;
            const auto [low, high] = std::minmax({of(one), of(other)});
            root[high] = low;
        }
    }
    Array<Int> found({count});
    Int groups = 0;
    for (Int piece = 0; piece < count; ++piece) {
        const Int first = of(piece);  // the first of its group: roots are the least
        found.view()[piece] = first == piece ? groups++ : found.view()[first];
    }
    return found;
}

}  // namespace holdfast
