// An even bed: the pressure on a plane contact.
//
// A bed of springs of the same stiffness everywhere presses with p = max(0, a + b·x) at the place x in its plane. The
// three numbers are those for which the pressure has the resultant and the moments that equilibrium asks for: the
// minimum of a convex function, by Newton's method. All integrals run over the part where p is positive, the faces cut
// off at the line p = 0, and are sums over edges. Seen from a point on that line, its own parts add nothing.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "span.hpp"

namespace holdfast {

using Triple = std::array<double, 3>;
using Triples = std::array<Triple, 3>;

// The faces of a plane contact, in a frame in its plane, as the named tuple of engines/trees/forest.py says. Rows of
// ``edges`` and of ``hull`` are read by pointer.
struct Bed {
    InMat edges;  // (E, 5)
    InMat hull;   // (H, 3)
    In size;      // (2,)
    static constexpr auto fields = std::tuple{&Bed::edges, &Bed::hull, &Bed::size};

    const double* edge(Int k) const { return edges.data() + k * edges.steps()[0]; }
};

// The pressure p = ``p``·(1, x, y) (3,), the motion ``m`` (3,) that resists last, and memory to work in.
struct Scratch {
    Triple p{}, m{};
    Triples M{};                     // integrals of (1, x, y)(1, x, y)ᵀ where the bed presses
    Triples K{}, L{};                // derivatives by the motion of the friction ``f``, ``g``
    Triple f{}, g{};                 // the force and the torque of friction
    std::array<double, 6> about{};   // integrals about a centre of rotation
    std::array<Triple, 2> across{};  // motions along which the load has no power
    Triple middle{};  // the centre of pressure, and the distance from it of the farthest place that presses
    Triple fresh{}, trial{}, carried{}, q{}, t{}, p0{}, p1{}, n{};
};

// The ends of the part of an edge on which p > 0, and how it was ``cut``: 0 for not at all, 1 at its beginning, 2 at
// its end, and -1 if nothing is left of it. An end at which p is 0 counts as a cut, so that the line p = 0 has both of
// its ends.
struct PressedPart {
    double ax, ay, bx, by;
    int cut;
};

inline PressedPart pressed_part(double ax, double ay, double bx, double by, double pa, double pb) {
    if (pa <= 0.0 && pb <= 0.0) return {ax, ay, bx, by, -1};
    if (pa <= 0.0) {
        const double t = pa / (pa - pb);
        return {ax + t * (bx - ax), ay + t * (by - ay), bx, by, 1};
    }
    if (pb <= 0.0) {
        const double t = pa / (pa - pb);
        return {ax, ay, ax + t * (bx - ax), ay + t * (by - ay), 2};
    }
    return {ax, ay, bx, by, 0};
}

// The part of an edge, both ends of which are given, on which the pressure ``p`` is positive
inline PressedPart pressed_part(const double* edge, const Triple& p) {
    const double ax = edge[0], ay = edge[1], bx = edge[2], by = edge[3];
    return pressed_part(ax, ay, bx, by, p[0] + p[1] * ax + p[2] * ay, p[0] + p[1] * bx + p[2] * by);
}

// Return a point on the line p = 0 if it meets the faces, else the origin: seen from there that line adds nothing.
// Coordinates are those about (x0, y0), where p is ``here``, and (px, py) is its gradient.
inline std::array<double, 2> on_the_border(const Bed& bed, double here, double px, double py, double x0, double y0) {
    for (Int k = 0; k < bed.edges.size(); ++k) {
        const double* edge = bed.edge(k);
        if (here + px * (edge[0] - x0) + py * (edge[1] - y0) <= 0.0) {
            const double slope = px * px + py * py;
            if (slope > 0.0) return {-here * px / slope, -here * py / slope};
            return {0.0, 0.0};
        }
    }
    return {0.0, 0.0};
}

// Write the integrals of (1, x, y)(1, x, y)ᵀ over where p >= 0 to ``M``, in coordinates about (x0, y0)
inline void second_moments(const Bed& bed, const Triple& p, double x0, double y0, Triples& M) {
    double m00 = 0.0, m01 = 0.0, m02 = 0.0, m11 = 0.0, m12 = 0.0, m22 = 0.0;
    const auto [cx, cy] = on_the_border(bed, p[0], p[1], p[2], x0, y0);
    for (Int k = 0; k < bed.edges.size(); ++k) {
        const double* edge = bed.edge(k);
        const double moved[] = {edge[0] - x0, edge[1] - y0, edge[2] - x0, edge[3] - y0};
        const auto [ax, ay, bx, by, cut] = pressed_part(moved, p);
        if (cut < 0) continue;
        const double area = ((ax - cx) * (by - cy) - (bx - cx) * (ay - cy)) / 2;
        const double sx = cx + ax + bx, sy = cy + ay + by;
        m00 += area;
        m01 += area * sx / 3;
        m02 += area * sy / 3;
        m11 += area * (cx * cx + ax * ax + bx * bx + sx * sx) / 12;
        m12 += area * (cx * cy + ax * ay + bx * by + sx * sy) / 12;
        m22 += area * (cy * cy + ay * ay + by * by + sy * sy) / 12;
    }
    M = {Triple{m00, m01, m02}, Triple{m01, m11, m12}, Triple{m02, m12, m22}};
}

// Write x with M x = ``right`` for a symmetric M; false if M is singular
inline bool solved(const Triples& M, const Triple& right, Triple& x) {
    const double a = M[0][0], b = M[0][1], c = M[0][2], d = M[1][1], e = M[1][2], f = M[2][2];
    const double A = d * f - e * e, B = c * e - b * f, C = b * e - c * d;
    const double D = a * f - c * c, E = b * c - a * e, F = a * d - b * b;
    const double det = a * A + b * B + c * C;
    if (!(std::abs(det) > 1e-300)) return false;
    const double u = right[0], v = right[1], w = right[2];
    x = {(A * u + B * v + C * w) / det, (B * u + D * v + E * w) / det, (C * u + E * v + F * w) / det};
    return true;
}

// Find the pressure with resultant 1 at (x0, y0), in coordinates about that point, from ``s.p`` by Newton's method. It
// is the minimum of ∫ max(0, p)² / 2 - p(x0, y0), whose derivatives by p are the resultant and the moments.
inline bool pressing_at(const Bed& bed, double x0, double y0, Scratch& s) {
    Triple &p = s.p, &trial = s.trial, &carried = s.carried, &right = s.t;
    const Triples& M = s.M;
    const Triple& fresh = s.fresh;
    right = {1.0, 0.0, 0.0};
    second_moments(bed, p, x0, y0, s.M);
    double value = 0.0;
    for (int i = 0; i < 3; ++i) {
        carried[i] = M[i][0] * p[0] + M[i][1] * p[1] + M[i][2] * p[2];
        value += carried[i] * p[i] / 2;
    }
    value -= p[0];
    for (int round = 0; round < 60; ++round) {
        if (!solved(M, right, s.fresh)) return false;
        double slope = 0.0;
        for (int i = 0; i < 3; ++i) slope -= (right[i] - carried[i]) * (fresh[i] - p[i]);
        if (-slope <= 1e-13 * std::abs(value)) return true;
        double step = 1.0, at = 0.0;
        bool falls = false;
        for (int back = 0; back < 30; ++back) {
            for (int i = 0; i < 3; ++i) trial[i] = p[i] + step * (fresh[i] - p[i]);
            second_moments(bed, trial, x0, y0, s.M);
            at = -trial[0];
            for (int i = 0; i < 3; ++i) {
                carried[i] = M[i][0] * trial[0] + M[i][1] * trial[1] + M[i][2] * trial[2];
                at += carried[i] * trial[i] / 2;
            }
            falls = M[0][0] > 0.0 && at <= value + 1e-4 * step * slope + 1e-15 * std::abs(value);
            if (falls) break;
            step /= 2;
        }
        if (!falls) return -slope <= 1e-10 * std::abs(value);
        value = at;
        p = trial;
    }
    return false;
}

// Write to ``s.p`` the pressure whose integrals with (1, x, y) are ``q``; false if none is found. If ``near``, the
// search begins at ``s.p``; else where the bed presses everywhere. If that fails, the resultant is led there from the
// middle of the bed, half of what is left of the way at a time.
inline bool find_pressure(const Bed& bed, const Triple& q, Scratch& s, bool near) {
    Triple& p = s.p;
    if (!(q[0] > 0.0)) return false;
    const double x0 = q[1] / q[0], y0 = q[2] / q[0];
    bool found = false;
    if (near) {
        p = {(p[0] + p[1] * x0 + p[2] * y0) / q[0], p[1] / q[0], p[2] / q[0]};
        found = pressing_at(bed, x0, y0, s);
    }
    if (!found) {
        p = {1.0, 0.0, 0.0};
        second_moments(bed, p, x0, y0, s.M);
        if (!(s.M[0][0] > 0.0)) return false;
        const double area = s.M[0][0], mx = x0 + s.M[0][1] / s.M[0][0], my = y0 + s.M[0][2] / s.M[0][0];
        s.t = {1.0, 0.0, 0.0};
        found = solved(s.M, s.t, p) && pressing_at(bed, x0, y0, s);
        if (!found) {
            p = {1 / area, 0.0, 0.0};
            double left = 1.0, x = mx, y = my;
            for (int k = 0; k < 40; ++k) {
                left = k < 30 ? left / 2 : 0.0;
                const double to_x = x0 + left * (mx - x0), to_y = y0 + left * (my - y0);
                p[0] += p[1] * (to_x - x) + p[2] * (to_y - y);
                x = to_x;
                y = to_y;
                found = pressing_at(bed, x, y, s);
                if (left == 0.0 || !found) break;
            }
        }
    }
    p = {q[0] * (p[0] - p[1] * x0 - p[2] * y0), q[0] * p[1], q[0] * p[2]};
    double farthest = 0.0;
    for (Int k = 0; k < bed.edges.size(); ++k) {
        const auto [ax, ay, bx, by, cut] = pressed_part(bed.edge(k), p);
        if (cut < 0) continue;
        farthest = std::max(farthest, std::hypot(ax - x0, ay - y0));
        farthest = std::max(farthest, std::hypot(bx - x0, by - y0));
    }
    s.middle = {x0, y0, farthest};
    return found;
}

}  // namespace holdfast
