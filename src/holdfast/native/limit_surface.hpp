// The friction of an even bed: how much of it a wrench in its plane uses, and along which motion it gives way.
//
// A motion m = (v, w) in the plane, of the origin and about it, meets friction of the power ∫ μ p |v + w e_z x x| dA.
// In polar coordinates about the centre of rotation that is closed form, edge by edge, as are the force, the torque
// (its derivatives by m) and their derivatives: with d the distance of the centre from the line of an edge and
// u = tan φ the place along it, over d, integrals of sec φ, sec³ φ and their like. The parts of the line p = 0 that
// close the cut faces add up from their ends, in any order. If the centre is far from what presses, these sums cancel,
// but the power is so smooth that a rule of 12 points on each triangle is exact to 1e-7.
//
// The forces that friction can carry are the limit surface (Goyal, Ruina, Papadopoulos, Wear 143, 1991): those whose
// power along no motion exceeds that of friction. So a tangential wrench t uses the share max t·m / power(m) of it, and
// the m that attains the maximum is how the body would slide.

#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "bed.hpp"

namespace holdfast {

constexpr double FOUND = 1e-9;  // relative loss of power below which a motion is the one that resists least
// Distance of a centre of rotation, in sizes of what presses, from which on a rule of points is more exact
constexpr double FAR = 8.0;
// Barycentric coordinates and weights, exact to degree 6 (Dunavant, IJNME 21, 1985)
constexpr double RULE[12][3] = {
    {0.249286745170910, 0.249286745170910, 0.116786275726379},
    {0.249286745170910, 0.501426509658179, 0.116786275726379},
    {0.501426509658179, 0.249286745170910, 0.116786275726379},
    {0.063089014491502, 0.063089014491502, 0.050844906370207},
    {0.063089014491502, 0.873821971016996, 0.050844906370207},
    {0.873821971016996, 0.063089014491502, 0.050844906370207},
    {0.310352451033784, 0.636502499121399, 0.082851075618374},
    {0.636502499121399, 0.310352451033784, 0.082851075618374},
    {0.310352451033784, 0.053145049844817, 0.082851075618374},
    {0.053145049844817, 0.310352451033784, 0.082851075618374},
    {0.636502499121399, 0.053145049844817, 0.082851075618374},
    {0.053145049844817, 0.636502499121399, 0.082851075618374},
};

// Add ``mu`` times the integrals from tan φ = u to tan φ = ``to`` over a triangle between a centre and a line. The line
// is at the distance d > 0 of the centre along the normal (n0, n1); ``here`` is p at the centre. The integrals are of
// p r, of p e and of p e eᵀ / r (xx, xy, yy), where r e leads from the centre to x.
inline void add_line(double u, double to, double d, double n0, double n1, double here, const Triple& p, double mu,
                     std::array<double, 6>& about) {
    const double t0 = -n1, t1 = n0;
    double bn = p[1] * n0 + p[2] * n1, bt = p[1] * t0 + p[2] * t1;
    const double sec0 = std::sqrt(1 + u * u), sec1 = std::sqrt(1 + to * to);
    const double before = sec0 + std::abs(u), behind = sec1 + std::abs(to);  // asinh u = log(u + sec)
    const double log = std::log((to > 0.0 ? behind : 1 / behind) * (u > 0.0 ? 1 / before : before));
    const double sec = sec1 - sec0, cos = 1 / sec1 - 1 / sec0, sin = to / sec1 - u / sec0;
    const double cubed = (sec1 * to - sec0 * u + log) / 2;
    const double third = (sec1 * sec1 * sec1 - sec0 * sec0 * sec0) / 3;
    here = mu * d * here;
    bn = mu * d * d * bn;
    bt = mu * d * d * bt;
    about[0] += d * d * (here / 3 * cubed + (bn * cubed + bt * third) / 4);
    const double fn = d * (here / 2 * log + (bn * log + bt * sec) / 3);
    const double ft = d * (here / 2 * sec + (bn * sec + bt * (cubed - log)) / 3);
    about[1] += fn * n0 + ft * t0;
    about[2] += fn * n1 + ft * t1;
    const double nn = here * sin + (bn * sin - bt * cos) / 2;
    const double nt = -here * cos + (bt * (log - sin) - bn * cos) / 2;
    const double tt = here * (log - sin) + (bn * (log - sin) + bt * (sec + cos)) / 2;
    about[3] += nn * n0 * n0 + 2 * nt * n0 * t0 + tt * t0 * t0;
    about[4] += nn * n0 * n1 + nt * (n0 * t1 + n1 * t0) + tt * t0 * t1;
    about[5] += nn * n1 * n1 + 2 * nt * n1 * t1 + tt * t1 * t1;
}

// Write the integrals of ``add_line``, with μ, over where ``pressed`` >= 0, about the centre (cx, cy)
inline void about_centre(const Bed& bed, const Triple& pressed, const Triple& p, double cx, double cy,
                         std::array<double, 6>& about) {
    about.fill(0.0);
    const double here = p[0] + p[1] * cx + p[2] * cy;
    const double slope = std::sqrt(pressed[1] * pressed[1] + pressed[2] * pressed[2]);
    double border = 0.0, z0 = 1.0, z1 = 0.0;  // the line pressed = 0: its distance, and the normal towards it
    if (slope > 0.0) {
        border = (pressed[0] + pressed[1] * cx + pressed[2] * cy) / slope;
        z0 = -pressed[1] / slope;
        z1 = -pressed[2] / slope;
        if (border < 0.0) {
            border = -border;
            z0 = -z0;
            z1 = -z1;
        }
    }
    for (Int k = 0; k < bed.edges.size(); ++k) {
        const double* edge = bed.edge(k);
        const double mu = edge[4], ex = edge[2] - edge[0], ey = edge[3] - edge[1];
        const auto [ax, ay, bx, by, cut] = pressed_part(edge, pressed);
        if (cut < 0) continue;
        const double length = std::sqrt(ex * ex + ey * ey);
        double n0 = ey / length, n1 = -ex / length;
        double d = (edge[0] - cx) * n0 + (edge[1] - cy) * n1;
        if (d < 0.0) {
            d = -d;
            n0 = -n0;
            n1 = -n1;
        }
        if (d > 1e-14 * length) {
            const double from = ((ax - cx) * -n1 + (ay - cy) * n0) / d, to = ((bx - cx) * -n1 + (by - cy) * n0) / d;
            add_line(from, to, d, n0, n1, here, p, mu, about);
        }
        if (cut == 1 && border > 0.0) {  // a part of the border ends here
            add_line(0.0, ((ax - cx) * -z1 + (ay - cy) * z0) / border, border, z0, z1, here, p, mu, about);
        }
        if (cut == 2 && border > 0.0) {  // ... and another begins here
            add_line(((bx - cx) * -z1 + (by - cy) * z0) / border, 0.0, border, z0, z1, here, p, mu, about);
        }
    }
}

// As ``friction``, by a rule of points on each triangle between (x0, y0), or the line pressed = 0, and an edge
inline double friction_by_rule(const Bed& bed, const Triple& pressed, const Triple& p, const Triple& m, double x0,
                               double y0, Triple& f, Triples& K) {
    f = {};
    double power = 0.0, k00 = 0.0, k01 = 0.0, k02 = 0.0, k11 = 0.0, k12 = 0.0, k22 = 0.0;
    const double s0 = pressed[0] + pressed[1] * x0 + pressed[2] * y0;
    const auto [border_x, border_y] = on_the_border(bed, s0, pressed[1], pressed[2], x0, y0);
    const double ox = border_x + x0, oy = border_y + y0;
    for (Int k = 0; k < bed.edges.size(); ++k) {
        const double* edge = bed.edge(k);
        const auto [ax, ay, bx, by, cut] = pressed_part(edge, pressed);
        if (cut < 0) continue;
        const double area = ((ax - ox) * (by - oy) - (bx - ox) * (ay - oy)) / 2;
        for (const auto& [g, h, weight] : RULE) {
            const double x = g * ox + h * ax + (1 - g - h) * bx, y = g * oy + h * ay + (1 - g - h) * by;
            double normal = edge[4] * area * weight * (p[0] + p[1] * x + p[2] * y);
            double vx = m[0] - m[2] * y, vy = m[1] + m[2] * x;
            const double speed = std::sqrt(vx * vx + vy * vy);
            vx /= speed;
            vy /= speed;
            power += normal * speed;
            f[0] += normal * vx;
            f[1] += normal * vy;
            f[2] += normal * (x * vy - y * vx);
            normal /= speed;
            const double turn = vx * x + vy * y;  // of (-vy, vx), across the motion, with e_z x x
            k00 += normal * vy * vy;
            k01 -= normal * vx * vy;
            k11 += normal * vx * vx;
            k02 -= normal * vy * turn;
            k12 += normal * vx * turn;
            k22 += normal * turn * turn;
        }
    }
    K = {Triple{k00, k01, k02}, Triple{k01, k11, k12}, Triple{k02, k12, k22}};
    return power;
}

// Return the power of friction against a motion ``m``, and write its derivatives: ``f`` and ``K``. ``f`` is the force
// and the torque about the origin with which friction at its limit would be overcome. All are integrals with the
// pressure ``p`` over where ``pressed`` >= 0.
inline double friction(const Bed& bed, const Triple& pressed, const Triple& p, const Triple& m, Scratch& s, Triple& f,
                       Triples& K) {
    const double vx = m[0], vy = m[1], w = m[2];
    const double x = s.middle[0], y = s.middle[1], reach = s.middle[2];
    if (std::hypot(vx - w * y, vy + w * x) <= FAR * reach * std::abs(w)) {
        const double cx = -vy / w, cy = vx / w, sign = std::copysign(1.0, w), speed = std::abs(w);
        const auto& about = s.about;
        about_centre(bed, pressed, p, cx, cy, s.about);
        f[0] = -sign * about[2];
        f[1] = sign * about[1];
        f[2] = sign * about[0] + cx * f[1] - cy * f[0];
        const double xx = about[3] / speed, xy = about[4] / speed, yy = about[5] / speed;
        const double k02 = -xx * cy + xy * cx, k12 = -xy * cy + yy * cx;
        const double k22 = xx * cy * cy - 2 * xy * cx * cy + yy * cx * cx;
        K = {Triple{xx, xy, k02}, Triple{xy, yy, k12}, Triple{k02, k12, k22}};
        return speed * about[0];
    }
    return friction_by_rule(bed, pressed, p, m, x, y, f, K);
}

// Scale a motion ``m`` so that t·m = 1, and with it ``K``, and return the factor; 0 where t is 0. One against which
// ``t`` has no power gives way to the motion along it.
inline double pushed(const Triple& t, Triple& m, double size, Triples& K) {
    double along = m[0] * t[0] + m[1] * t[1] + m[2] * t[2];
    if (!(along > 0.0)) {
        m = {t[0], t[1], 2 * t[2] / (size * size)};
        along = m[0] * t[0] + m[1] * t[1] + m[2] * t[2];
        if (!(along > 0.0)) return 0.0;
    }
    for (int i = 0; i < 3; ++i) {
        m[i] /= along;
        for (int j = 0; j < 3; ++j) K[i][j] *= along;
    }
    return 1 / along;
}

// A step of Newton's method: by which share of it the power would fall if it were a parabola, the new power, and
// whether there was a step
struct Descent {
    double gap, power;
    bool moved;
};

// Take a step of Newton's method from ``s.m`` to a motion with t·m = 1 whose power is less. ``power``, ``s.f`` and
// ``s.K`` belong to ``s.m`` and become those of the new one. None is taken for less than FOUND.
inline Descent descend(const Bed& bed, const Triple& t, double power, Scratch& s) {
    const double size = bed.size[0];
    double a = t[0], b = t[1], c = t[2] / size;
    double length = std::sqrt(a * a + b * b + c * c);
    a /= length;
    b /= length;
    c /= length;
    const bool steep = std::abs(c) < 0.7;
    double x = steep ? b : 0.0, y = steep ? -a : c, z = steep ? 0.0 : -b;
    length = std::sqrt(x * x + y * y + z * z);
    x /= length;
    y /= length;
    z /= length;
    auto& across = s.across;
    across[0] = {x, y, z / size};
    across[1] = {b * z - c * y, c * x - a * z, (a * y - b * x) / size};
    double g0 = 0.0, g1 = 0.0, k00 = 0.0, k01 = 0.0, k11 = 0.0;
    for (int i = 0; i < 3; ++i) {
        g0 += across[0][i] * s.f[i];
        g1 += across[1][i] * s.f[i];
        for (int j = 0; j < 3; ++j) {
            k00 += across[0][i] * s.K[i][j] * across[0][j];
            k01 += across[0][i] * s.K[i][j] * across[1][j];
            k11 += across[1][i] * s.K[i][j] * across[1][j];
        }
    }
    const double det = k00 * k11 - k01 * k01;
    if (!(det > 1e-300)) return {1.0, power, false};
    const double d0 = (k01 * g1 - k11 * g0) / det, d1 = (k01 * g0 - k00 * g1) / det;
    const double slope = g0 * d0 + g1 * d1, gap = -slope / power;
    if (gap < FOUND) return {gap, power, false};
    double step = 1.0;
    for (int back = 0; back < 20; ++back) {
        for (int i = 0; i < 3; ++i) s.trial[i] = s.m[i] + step * (d0 * across[0][i] + d1 * across[1][i]);
        const double there = friction(bed, s.p, s.p, s.trial, s, s.g, s.L);
        if (there <= power + 0.1 * step * slope) {
            s.m = s.trial;
            s.f = s.g;
            s.K = s.L;
            return {gap, there, true};
        }
        step /= 2;
    }
    return {gap, power, false};
}

// A share of friction, too small by no more than a relative ``error``
struct Share {
    double share, error;
};

// Return which share of friction a tangential wrench ``t`` uses under the pressure ``s.p``, and its error. It is
// 1 / min power(m) over the motions with t·m = 1, sought from ``s.m``, where the minimum is left. The error is what the
// next step would still gain.
inline Share share_used(const Bed& bed, const Triple& t, Scratch& s) {
    if (pushed(t, s.m, bed.size[0], s.K) == 0.0) return {0.0, 0.0};
    double power = friction(bed, s.p, s.p, s.m, s, s.f, s.K), gap = 1.0;
    if (!(power > 0.0)) return {2.0, 0.0};  // no friction at all
    for (int round = 0; round < 60; ++round) {
        const Descent found = descend(bed, t, power, s);
        gap = found.gap;
        power = found.power;
        if (!found.moved) break;
    }
    return power > 0.0 ? Share{1 / power, gap} : Share{0.0, 1.0};
}

// Return a share of friction under ``s.p`` that a tangential wrench ``t`` uses at most, μ being one for all. Friction
// of a turn about the centre of pressure carries the torque, and that of sliding all together the force that is left:
// what it carries in two motions, it carries in any mixture of both.
inline double share_at_most(const Triple& t, Scratch& s, const Bed& bed) {
    const double sliding = bed.size[1] * s.q[0], x = s.middle[0], y = s.middle[1];
    s.n = {y, -x, 1.0};
    const double most = friction(bed, s.p, s.p, s.n, s, s.g, s.L);
    if (!(most > 0.0)) return 2.0;
    const double turns = (t[2] - x * t[1] + y * t[0]) / most;
    return std::abs(turns) + std::hypot(t[0] - turns * s.g[0], t[1] - turns * s.g[1]) / sliding;
}

// A contact at its limit: the pressure, the motion ``m`` that it gives way to, the linear field of pressure whose
// integrals with (1, x, y), where it presses, are the ``friction`` that a field 1, x or y of pressure adds against m,
// and the power of friction
struct AtLimit {
    Triple pressure, motion, friction;
    double power;
};

// Return how a contact slides that carries the pressure's integrals ``q`` and the tangential wrench ``t``
inline std::optional<AtLimit> sliding_under(const Bed& bed, const Triple& q, const Triple& t) {
    Scratch s;
    if (!find_pressure(bed, q, s, false)) return std::nullopt;
    share_used(bed, t, s);
    Triple fields{};
    for (int i = 0; i < 3; ++i) {
        Triple field{};
        field[i] = 1.0;
        fields[i] = friction(bed, s.p, field, s.m, s, s.f, s.K);
    }
    const double power = friction(bed, s.p, s.p, s.m, s, s.f, s.K);
    second_moments(bed, s.p, 0.0, 0.0, s.M);
    if (!solved(s.M, fields, s.fresh)) return std::nullopt;
    return AtLimit{s.p, s.m, s.fresh, power};
}

}  // namespace holdfast
