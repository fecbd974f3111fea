// Recognition of convex polygons that a few pieces tile, such as the overlap of two faces of two triangles each.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "hull.hpp"
#include "span.hpp"

namespace holdfast {

// Write the hull of corners (n, 2), counter-clockwise, into ``out`` (2 n + 2, 2); return its number of corners.
// ``order`` (n,) sorts the corners along x. Corners within ``tolerance`` of a side or of another corner are left out.
inline Int hull_within(InMat corners, InInts order, double tolerance, Mat out) {
    const Int count = order.size();
    Int size = 0;
    for (int side = 0; side < 2; ++side) {
        const Int floor = size + 1;
        for (Int step = 0; step < count; ++step) {
            const auto p = corners[side == 0 ? order[step] : order[count - 1 - step]];
            while (size > floor) {
                const double ax = out(size - 2, 0), ay = out(size - 2, 1);
                const double cx = p[0] - ax, cy = p[1] - ay;
                const double turn = (out(size - 1, 0) - ax) * cy - (out(size - 1, 1) - ay) * cx;
                if (turn > tolerance * std::hypot(cx, cy)) break;
                --size;
            }
            if (size == 0 || std::hypot(out(size - 1, 0) - p[0], out(size - 1, 1) - p[1]) > tolerance) {
                out(size, 0) = p[0];
                out(size, 1) = p[1];
                ++size;
            }
        }
        --size;
    }
    return std::max(size, Int{0});
}

// Tell whether an edge of polygon ``one`` has all corners of polygon ``other`` on its outer side. With ``every``, tell
// instead whether every edge has all corners on its inner side; for ``one`` = ``other`` that means that the polygon is
// convex.
inline bool beyond(InMat corners, InInts ends, Int one, Int other, double tolerance, bool every) {
    const Int start = one > 0 ? ends[one - 1] : 0, first = other > 0 ? ends[other - 1] : 0;
    for (Int i = start; i < ends[one]; ++i) {
        const Int j = i + 1 < ends[one] ? i + 1 : start;
        const double length = std::hypot(corners(j, 0) - corners(i, 0), corners(j, 1) - corners(i, 1));
        bool outside = length > tolerance;
        for (Int k = first; k < ends[other]; ++k) {
            const double left = twice_area(corners, i, j, k);
            if (every && left < -tolerance * length) return false;
            outside = outside && left <= tolerance * length;
        }
        if (outside && !every) return true;
    }
    return every;
}

// The hull (k, 2), counter-clockwise, of the corners (n, 2) of all pieces, or nothing if the pieces do not tile it.
// Piece p has the corners from ``ends[p - 1]`` up to, not including, ``ends[p]``. ``order`` (n,) sorts them along x.
inline Array<double, 2> tiled_hull(InMat given, InInts ends, InInts order, double tolerance) {
    Array<double, 2> own(given.sizes()), found({2 * given.size() + 2, 2});
    const Mat corners = own.view(), out = found.view();
    for (Int i = 0; i < given.size(); ++i) {
        corners(i, 0) = given(i, 0);
        corners(i, 1) = given(i, 1);
    }
    const Array<double, 2> none({0, 2});
    const Int count = hull_within(corners, order, tolerance, out);
    double total = 0.0;
    for (Int piece = 0; piece < ends.size(); ++piece) {
        const Int first = piece > 0 ? ends[piece - 1] : 0;
        double area = 0.0;
        for (Int i = first + 1; i < ends[piece] - 1; ++i) area += twice_area(corners, first, i, i + 1) / 2;
        if (area < 0) {  // make all of them counter-clockwise
            for (Int i = first, j = ends[piece] - 1; i < j; ++i, --j) {
                for (int m = 0; m < 2; ++m) std::swap(corners(i, m), corners(j, m));
            }
        }
        total += std::abs(area);
    }
    double hull = 0.0, around = 0.0;
    for (Int i = 0; i < count; ++i) {
        const Int j = i + 1 < count ? i + 1 : 0;
        around += std::hypot(out(j, 0) - out(i, 0), out(j, 1) - out(i, 1));
        hull += twice_area(out, 0, i, j) / 2;
    }
    if (std::abs(hull - total) > tolerance * around) return none;
    for (Int one = 0; one < ends.size(); ++one) {
        for (Int other = 0; other <= one; ++other) {
            const bool fits = one == other ? beyond(corners, ends, one, one, tolerance, true)
                                           : beyond(corners, ends, one, other, tolerance, false) ||
                                                 beyond(corners, ends, other, one, tolerance, false);
            if (!fits) return none;
        }
    }
    found.sizes[0] = count;
    found.numbers.resize(static_cast<std::size_t>(2 * count));
    return found;
}

// The number of the group (n,) of each piece; pieces of two groups, as ``tiled_hull`` takes them, are more than
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
