// The first load at which a plane contact on an even bed gives way: it tips about an edge, or slides and turns.
//
// The wrench on the contact is that at rest plus a multiple of the load's. Both are mixed, (1 - θ) rest + θ load, so
// that θ from 0 to 1 takes the multiple θ / (1 - θ) from nothing to no end; what a contact can carry does not depend on
// the size of the wrench. It tips where the centre of pressure reaches the border of the hull: a line of θ for each of
// its edges. Before that it slides where the friction asked for is all that there is. While the bed presses everywhere,
// its pressure and with it its friction are linear in θ, and the wrenches that it carries are a convex set: what holds
// at one θ holds at all before. Once a part has lifted, the share of friction is looked at in places on the way to
// tipping, so close to each other that between two of them it stays below 1, by a bound (most_between) or by experience
// (RISES).

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "bed.hpp"
#include "limit_surface.hpp"

namespace holdfast {

constexpr int NEVER = 0, TIPS = 1, SLIDES = 2, UNKNOWN = 3;  // how a contact gives way
// Logarithms of the ratio of the distances from tipping of two places that follow each other: the longest, log 16, and
// one from which on none is put between
constexpr double LONGEST = 4 * std::numbers::ln2, FINEST = 0.02;
// Between two places the share of friction rises above both by at most this, times the logarithm where that is below 1.
// Measured on 20,000 loads on random beds, of which the worst, where a narrow foot lifts, has 0.45
constexpr double RISES = 0.5;
// Share of the load that tips it which is not looked at, where the bed presses on next to nothing; at most LONG, if no
// pressure is found there
constexpr double SHORT = 1e-5, LONG = 1e-3;
constexpr double SMALL = 0.01;     // of what a step would gain, from which on it tells how much all steps would gain
constexpr double ROUNDING = 1e-9;  // relative difference of two θ that is none
constexpr double CERTAIN = 1e-6;   // relative error of a share of friction above which it counts as not found

using Six = std::array<double, 6>;  // what a bed carries: N, N x, N y of its pressure, the force and torque along it

// Return the θ at which the load is smaller by the share ``shorter`` than at θ = ``tips``
inline double sooner_than(double tips, double shorter) { return tips * (1 - shorter) / (1 - tips * shorter); }

// Return the share of friction that is used at θ = ``at``; -1 if it is not found. If ``bound``, a bound of it does
// where that is less than 1. If ``near``, ``s.p`` is from a θ near by.
inline double share_at(const Bed& bed, const Six& rest, const Six& load, double at, Scratch& s, bool near, bool bound) {
    for (int i = 0; i < 3; ++i) s.q[i] = (1 - at) * rest[i] + at * load[i];
    if (!find_pressure(bed, s.q, s, near)) return -1.0;
    for (int i = 0; i < 3; ++i) s.t[i] = (1 - at) * rest[3 + i] + at * load[3 + i];
    if (bound && bed.size[1] > 0.0) {
        const double most = share_at_most(s.t, s, bed);
        if (most < 1 - CERTAIN) return most;
    }
    const auto [share, error] = share_used(bed, s.t, s);
    return error <= CERTAIN ? share : -1.0;
}

// Return a share of friction, μ being one for all, that is used at most between θ = ``low`` and θ = ``at``. ``squares``
// are ∫ p² dA there, a convex function of what is carried, at most. A pressure with the force N and the integral S of
// its square resists a turn about any point with μ N R / 2 at least, R = N √(3 / (2 π S)): a cone of that radius does.
// It resists as well the force μ N in the centre of pressure, and any mixture of both.
inline double most_between(const Bed& bed, const Six& rest, const Six& load, double low, double at, double squares) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    double least = inf, force = 0.0, torque = 0.0;
    Six d{};
    for (int i = 0; i < 6; ++i) d[i] = load[i] - rest[i];
    for (const double theta : {low, at}) {
        const double n = rest[0] + theta * d[0], x = rest[1] + theta * d[1], y = rest[2] + theta * d[2];
        const double tx = rest[3] + theta * d[3], ty = rest[4] + theta * d[4], tz = rest[5] + theta * d[5];
        least = std::min(least, n);
        force = std::max(force, std::hypot(tx, ty));
        torque = std::max(torque, std::abs(n * tz - x * ty + y * tx));
    }
    if (!(least > 0.0)) return inf;
    // between both it is a parabola
    torque += std::abs(d[0] * d[5] - d[1] * d[4] + d[2] * d[3]) * ((at - low) * (at - low)) / 4;
    const double radius = std::sqrt(1.5 / (std::numbers::pi * squares)) * least;
    return (2 * torque / (radius * least) + force) / (bed.size[1] * least);
}

// Return the derivative by θ of the ``share`` of friction used, where ``share_at`` found it. The motion stays (it is a
// minimum), and the pressure changes by a linear field where the bed presses.
inline double slope_at(const Bed& bed, const Six& rest, const Six& load, double share, Scratch& s) {
    for (int i = 0; i < 3; ++i) s.q[i] = load[i] - rest[i];
    second_moments(bed, s.p, 0.0, 0.0, s.M);
    if (!solved(s.M, s.q, s.fresh)) return 0.0;
    double gained = 0.0;
    for (int i = 0; i < 3; ++i) gained += s.m[i] * (load[3 + i] - rest[3 + i]);
    return share * (gained - share * friction(bed, s.p, s.fresh, s.m, s, s.g, s.L));
}

// Return the θ up to which the bed presses everywhere, 0 if it does not do so at rest. ``s.p0`` and ``s.p1`` are then
// its pressures at rest and under the load alone.
inline double lifts_at(const Bed& bed, const Six& rest, const Six& load, Scratch& s) {
    s.p = {1.0, 0.0, 0.0};
    second_moments(bed, s.p, 0.0, 0.0, s.M);
    for (int i = 0; i < 3; ++i) {
        s.q[i] = rest[i];
        s.t[i] = load[i];
    }
    if (!(solved(s.M, s.q, s.p0) && solved(s.M, s.t, s.p1))) return 0.0;
    double until = 1.0;
    for (Int k = 0; k < bed.edges.size(); ++k) {
        const double x = bed.edge(k)[0], y = bed.edge(k)[1];
        const double before = s.p0[0] + s.p0[1] * x + s.p0[2] * y, behind = s.p1[0] + s.p1[1] * x + s.p1[2] * y;
        if (before <= 0.0) return 0.0;
        if (behind < 0.0) until = std::min(until, before / (before - behind));
    }
    return until;
}

// Write the pressure ``s.p`` of a bed that presses everywhere, and the tangential wrench ``s.t``, at θ = ``at``
inline void mix(const Six& rest, const Six& load, double at, Scratch& s) {
    for (int i = 0; i < 3; ++i) {
        s.p[i] = (1 - at) * s.p0[i] + at * s.p1[i];
        s.t[i] = (1 - at) * rest[3 + i] + at * load[3 + i];
    }
}

// A θ, and by how much it may be too large
struct Around {
    double at, around;
};

// Return the θ before ``end`` at which a bed that presses everywhere slides. Its pressure, and with it its friction, is
// linear in θ: ``s.p0`` at rest and ``s.p1`` under the load alone. So each motion is overcome at a θ that follows from
// its powers, and the least of them is sought. The θ is ``end`` where nothing slides before, and -1 where that is not
// found.
inline Around slides_evenly(const Bed& bed, const Six& rest, const Six& load, double end, Scratch& s) {
    double at = end, spare = 0.0;
    s.middle = {0.0, 0.0, bed.size[0]};
    mix(rest, load, at, s);
    if (pushed(s.t, s.m, bed.size[0], s.K) == 0.0) return {end, 0.0};
    double power = friction(bed, s.p0, s.p, s.m, s, s.f, s.K);
    for (int round = 0; round < 60; ++round) {
        if (power < 1.0) {
            spare = friction(bed, s.p0, s.p0, s.m, s, s.g, s.L);
            for (int i = 0; i < 3; ++i) spare -= rest[3 + i] * s.m[i];
            if (!(spare > 0.0)) return {-1.0, 0.0};
            const double sooner = spare / (spare + 1 - power);
            at *= sooner;
            for (int i = 0; i < 3; ++i) {
                s.f[i] = s.g[i] + sooner * (s.f[i] - s.g[i]);
                for (int j = 0; j < 3; ++j) s.K[i][j] = s.L[i][j] + sooner * (s.K[i][j] - s.L[i][j]);
            }
            mix(rest, load, at, s);
            spare *= pushed(s.t, s.m, bed.size[0], s.K);
            power = 1.0;
        }
        const double before = power;
        const Descent found = descend(bed, s.t, power, s);
        power = found.power;
        if (spare == 0.0 && found.gap < SMALL && before * (1 - 2 * found.gap) > 1 + CERTAIN) return {end, 0.0};
        if (!found.moved) {
            if (!(found.gap < FOUND)) return {-1.0, 0.0};
            return {at, spare > 0.0 ? CERTAIN * at / spare : 0.0};
        }
    }
    return {-1.0, 0.0};
}

// Tell how a contact gives way under ``rest`` plus a growing multiple of ``load``, and write when to ``out``: θ, a θ
// that is certainly not too large and one that is not too small, and the motion with which it slides or, if it tips,
// the number of the edge of the hull, that of another one that it reaches at once, or -1, and how fast it does so, over
// the first; then 1 if between two places on the way experience was believed (RISES), not a bound, else 0. From θ =
// ``until`` on, something else gives way: NEVER says that this contact does not before.
inline int first_exit(const Bed& bed, const Six& rest, const Six& load, double until, Scratch& s, double* out) {
    for (int i = 0; i < 6; ++i) {
        if (!std::isfinite(rest[i]) || !std::isfinite(load[i])) return UNKNOWN;
    }
    double tips = until, rate = 0.0, slower = 0.0;
    Int edge = -1, other = -1;
    for (Int k = 0; k < bed.hull.size(); ++k) {
        const double* row = bed.hull.data() + k * bed.hull.steps()[0];
        double before = 0.0, behind = 0.0;
        for (int i = 0; i < 3; ++i) {
            before += row[i] * rest[i];
            behind += row[i] * load[i];
        }
        if (behind >= 0.0 || before >= (before - behind) * tips * (1 + ROUNDING)) continue;
        if (edge >= 0 && before > (before - behind) * tips * (1 - ROUNDING)) {  // the corner between two edges
            other = k;
            slower = behind;
        } else {
            tips = before / (before - behind);
            edge = k;
            other = -1;
            rate = behind;
        }
    }
    bool believed = false;
    const auto write = [out, &believed](double at, double low, double high, double a, double b, double c) {
        const double all[] = {at, low, high, a, b, c, believed ? 1.0 : 0.0};
        std::copy_n(all, 7, out);
    };
    const double end = edge < 0 ? tips : sooner_than(tips, SHORT);
    const double lifted = std::min(lifts_at(bed, rest, load, s), end);
    if (lifted > 0.0) {
        const auto [at, around] = slides_evenly(bed, rest, load, lifted, s);
        if (at < 0.0) return UNKNOWN;
        if (around > 0.0) {
            write(at, std::max(at - around, 0.0), at, s.m[0], s.m[1], s.m[2]);
            return SLIDES;
        }
    }
    double low = lifted, high = -1.0, before = -1.0, step = 0.0, squares = 0.0, share = 0.0;
    bool near = false;
    const double last = edge >= 0 ? tips : tips + (tips - lifted) / 15;
    while (low < end * (1 - ROUNDING)) {
        const double at = std::min(last - (last - low) * std::exp(-step), end);
        share = share_at(bed, rest, load, at, s, near, true);
        if (!(share >= 0.0)) {
            if (edge >= 0 && low >= sooner_than(tips, LONG)) break;
            if (step <= FINEST) return UNKNOWN;
            step /= 2;
            near = false;
            continue;
        }
        near = true;
        if (share > 1.0) {
            high = at;
            break;
        }
        const double most = s.p[0] * s.q[0] + s.p[1] * s.q[1] + s.p[2] * s.q[2];
        bool sure = false;
        if (bed.size[1] > 0.0 && step > 0.0) {
            sure = most_between(bed, rest, load, low, at, std::max(squares, most)) < 1.0;
        }
        if (!sure && step > FINEST && std::max(before, share) > 1 - RISES * std::min(step, 1.0)) {
            step /= 2;
        } else {
            believed |= !sure && step > 0.0;
            low = at;
            before = share;
            squares = most;
            step = step > 0.0 ? std::min(2 * step, LONGEST) : LONGEST;
        }
    }
    if (high < 0.0) {
        write(tips, low, tips, static_cast<double>(edge), static_cast<double>(other),
              rate != 0.0 ? slower / rate : 0.0);
        return edge < 0 ? NEVER : TIPS;
    }
    const double below = low;
    double at = high;
    for (int round = 0; round < 60; ++round) {  // Newton's method between two places of which one holds
        const double slope = slope_at(bed, rest, load, share, s);
        const double fresh = slope > 0.0 ? at - (share - 1) / slope : -1.0;
        const bool between = low < fresh && fresh < high;
        const double close = CERTAIN * high * (1 - low) + 1e-15;
        if (high - low <= close || (between && std::abs(fresh - at) <= close)) break;
        at = between ? fresh : (low + high) / 2;
        share = share_at(bed, rest, load, at, s, true, false);
        if (share < 0.0) return UNKNOWN;
        (share > 1.0 ? high : low) = at;
    }
    const double around = 10 * CERTAIN * at * (1 - at), most = s.p[0] * s.q[0] + s.p[1] * s.q[1] + s.p[2] * s.q[2];
    // that friction does not run out, come back and run out again
    believed |=
        at - around > below && !(most_between(bed, rest, load, below, at - around, std::max(squares, most)) < 1.0);
    write(at, std::max(at - around, 0.0), std::min(at + around, tips), s.m[0], s.m[1], s.m[2]);
    return SLIDES;
}

// Return which share of its friction a contact uses under ``rest``: -1 if not found, 2 if it tips
inline double share_at_rest(const Bed& bed, const Six& rest) {
    for (Int k = 0; k < bed.hull.size(); ++k) {
        const double* row = bed.hull.data() + k * bed.hull.steps()[0];
        if (row[0] * rest[0] + row[1] * rest[1] + row[2] * rest[2] <= 0.0) return 2.0;
    }
    Scratch s;
    return share_at(bed, rest, rest, 0.0, s, false, false);
}

}  // namespace holdfast
