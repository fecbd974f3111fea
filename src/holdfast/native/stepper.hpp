// Steps along a load path: the state of the walk, and what a single step meets.
//
// The path is walked plane by plane across its direction (pseudo-arc-length), so that neither a falling load nor a
// point that moves back stops it. Its length ℓ is that of the motion of the body that moves most.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "cubic.hpp"
#include "direction.hpp"
#include "newton.hpp"
#include "outcome.hpp"
#include "resting.hpp"
#include "sparse.hpp"
#include "step_control.hpp"

namespace holdfast {

constexpr double TOLERANCE = 1e-7;  // unbalance of points on the path, each body's in units of its own weight
// Unbalance midway from which a step may hide a maximum, as a share of the load
constexpr double OFF = 0.1, OFF_RISING = 0.4;
constexpr double LEFT = 0.35;     // if the slope stays above this share of what it was before the step, the step hides
                                  // no maximum
constexpr double RISEN = 3e-3;    // least relative rise of the load from one stored point to the next
constexpr double FAINT = 1e-8;    // drag in the search for forces that balance the load alone
constexpr Int MOST_ALONE = 30;    // largest number of Newton steps there
constexpr double CAREFUL = 1.0;   // largest growth after a step that failed
constexpr Int MOST_NEWTON = 16;   // largest number of Newton steps for one point
constexpr Int EASY = 8;           // number up to which a point counts as found easily
constexpr Int FIRST_NEWTON = 60;  // largest number for the first point: which idle faces part is still open
constexpr double FIRST_LOAD = 0.1;    // its largest component, of each body's own weight and size
constexpr double MOST_FIRST = 10.0;   // how far it may lead, in displacements at rest
constexpr double FIRST_SHARE = 0.01;  // least share of one step there
constexpr double AWAY = 0.7;  // distance from where the directions at both ends lead, as a share of the motion, that
                              // hints at a branch
constexpr double HARDLY_AWAY = 0.4;  // the same for points that are not found easily
constexpr Int DOUBTS = 2;          // how often one step is tried again because it may have left its branch or hidden a
                                   // maximum
constexpr double SHORTER = 0.3;    // factor by which a step is shortened
constexpr double NEAR = 0.03;      // share of a failed step from which a corner inside it is approached
constexpr double BEFORE = 0.999;   // share of the way to a corner that is covered before the corner is crossed
constexpr Int SHORTENINGS = 4;     // times that one step is shortened, after which the path continues behind the next
                                   // change of a node
constexpr Int MOST_CHANGES = 200;  // largest number of changes of nodes behind which a path may continue

// A walk along a load path: all that one step hands on to the next.
//
// The point ``q`` (n,) with the path's direction ``tangent``, dq/dℓ; the point ``trial`` that is being tried and where
// it was ``aimed``; displacement and plane of the highest point so far (``peak_q``, ``peak_plane``); displacement,
// tangent and plane of the point before the peak, displacement and tangent of the one behind it; ``start``, the state
// of rest. ``scratch`` is just that. ``path`` is the balance that all points keep. ``stuck`` (2, n) are the
// displacements under the wrench and under the load alone, if every contact stuck.
//
// ``stored_q`` is the displacement of a point on the way to the peak, from which the beginning motion is sought.
struct Stepper {
    Progress now;
    Memory memory;
    Vec q, tangent, trial, aimed, peak_q, peak_plane, rising_q, rising_tangent, rising_plane, falling_q,
        falling_tangent, scratch, start, stored_q;
    Balance path;
    Mat stuck;

    // A walk among n = 6J displacements, which are ``stuck_at`` (n,) under the wrench if every contact sticks
    Stepper(In stuck_at, const StepControl& pace) : now(pace), memory(17 * stuck_at.size()) {
        const Int n = stuck_at.size();
        double* at = memory.data();
        for (Vec* one : {&q, &tangent, &trial, &aimed, &peak_q, &peak_plane, &rising_q, &rising_tangent, &rising_plane,
                         &falling_q, &falling_tangent, &scratch, &start, &stored_q}) {
            *one = Vec(at, {n});
            at += n;
        }
        path = {1.0, 0.0, 0.0, Vec(at, {n})};
        stuck = Mat(at + n, {2, n});
        put(stuck[0], stuck_at);
        put(stuck[1], stuck_at);
    }
};

// What the regularisation spring carries at q (n,), of each body's own weight and size
inline double by_springs(const Elastic& m, In q) {
    double top = 0.0;
    for (Int i = 0; i < q.size(); ++i) top = std::max(top, std::abs(m.scale[i] * m.hold[i] * q[i]));
    return top;
}

// Let the present point be the one before the peak
inline void before_peak(const Work& work, Stepper& stepper) {
    Progress& now = stepper.now;
    put(stepper.rising_q, stepper.q);
    put(stepper.rising_tangent, stepper.tangent);
    put(stepper.rising_plane, work.c);
    now.rising_s = now.s;
    now.rising_slope = now.slope;
}

// Let the present point be the one behind the peak
inline void behind_peak(Stepper& stepper) {
    Progress& now = stepper.now;
    put(stepper.falling_q, stepper.q);
    put(stepper.falling_tangent, stepper.tangent);
    now.falling_s = now.s;
    now.falling_slope = now.slope;
    now.closed = true;
}

// Find the direction of the path at the state of rest ``start`` (n,) under ``load`` (n,)
inline Event begin(const Elastic& m, Work& work, Stepper& stepper, In start, In load, const Fronts* fronts,
                   Breath& breath) {
    constexpr double INF = std::numeric_limits<double>::infinity();
    Progress& now = stepper.now;
    const Vec q = stepper.q;
    put(q, start);
    put(stepper.start, start);
    put(stepper.peak_q, start);
    put(stepper.falling_q, start);
    stepper.falling_tangent.fill(0.0);
    bond_all(m, work, load, stepper.stuck[1], fronts);
    put(work.w, load);
    put(work.c, load);
    now = Progress({now.growth, now.correction, now.patience, now.most});
    now.strength = worst(m, load);
    now.elastic = elastic_size(m, q, load);
    now.rest = by_springs(m, q);
    now.flat_since = now.similar_since = INF;
    const Iteration rest = newton(m, work, stepper.path, q, 0.0, dot(load, q), TOLERANCE, 5, 0.0, fronts, breath);
    if (!rest.converged) return Event::NO_BEGINNING;
    now.s = rest.s;
    now.systems = 1;
    now.orientation = work.rhs(q.size(), 1) > 0 ? rest.sign : -rest.sign;
    now.slope = turn(work, rest.sign, now.orientation, stepper.tangent);
    now.step = now.slope > 0 ? std::min(FIRST_LOAD / (now.strength * now.slope), MOST_FIRST * now.elastic)
                             : 1e-3 * now.elastic;
    before_peak(work, stepper);
    put(stepper.peak_plane, work.c);
    now.rising_s = now.falling_s = now.falling_slope = 0.0;
    now.closed = now.slope <= 0;
    return Event::BEGUN;
}

// The unbalance that a point there may have: more where displacement or load are large
inline double tolerance_at(const Progress& now) {
    return TOLERANCE *
           std::max({1.0, std::min(1e-7 * now.length / now.elastic, 10.0), 0.01 * now.strength * std::abs(now.s)});
}

// Whether the path may be elsewhere midway than where both ends' directions lead, and clearly higher there.
//
// It may be if the slope before the step leads clearly higher, if no more than LEFT of that slope remains somewhere in
// the step, and if the unbalance midway is a large share of the load: OFF, and OFF_RISING times what remains more.
inline bool strays(const Elastic& m, Work& work, Stepper& stepper, const Iteration& point, double rise, double falls) {
    const Progress& now = stepper.now;
    const Vec middle = stepper.scratch;
    const double left = least_slope(now.s, rise, point.s, falls) / std::max(rise, 1e-300);
    if (left > LEFT || now.s + rise < point.s + (1 - FALLEN) * std::abs(point.s)) return false;
    for (Int i = 0; i < middle.size(); ++i) {
        const double bend = 0.125 * now.step * (stepper.tangent[i] - work.rhs(i, 1));
        middle[i] = 0.5 * (stepper.q[i] + stepper.trial[i]) + bend;
    }
    unbalance(m, work, stepper.path, middle, cubic(0.5, now.s, rise, point.s, falls));
    const double share = OFF + OFF_RISING * std::max(left, 0.0);
    return worst(m, work.r) > share * now.strength * std::max(now.highest, point.s);
}

// Whether the ``point`` that was found may lie on another branch, or the step to it may hide a maximum
inline bool doubtful(const Elastic& m, Work& work, Stepper& stepper, const Iteration& point) {
    const Progress& now = stepper.now;
    // Both across the plane of the step
    const double rise = now.slope * now.step, falls = work.rhs(stepper.q.size(), 1) * now.step;
    if (hides_dip(now, rise, point.s, falls)) return true;
    if (now.points > 0 && now.doubted == 0 && strays(m, work, stepper, point, rise, falls)) return true;
    if (!(now.turned > now.correction)) return false;
    const double most = now.points == 0 || point.systems <= EASY ? AWAY : HARDLY_AWAY;
    // Torn once: where the path has a sharp corner every step is
    if (now.doubted == 0 &&
        torn(work, point.sign, now.orientation, stepper.q, stepper.tangent, stepper.trial, now.step, most)) {
        return true;
    }
    return passes_over(now, rise, point.s, falls);
}

// Let the path begin straight towards the point that was tried, with load ``s``, instead of along its direction.
//
// At rest many faces touch without force, and which of them part is not known before the first point is. Up to there
// all displacements are in proportion to the load, as long as nothing else changes.
inline void lead(Work& work, Stepper& stepper, double s) {
    const Vec tangent = stepper.tangent;
    go(tangent, stepper.trial, -1.0, stepper.q);
    set_column(work.rhs, 1, tangent);
    work.rhs(tangent.size(), 1) = s - stepper.now.s;
    stepper.now.slope = turn(work, 1.0, 1.0, tangent);
}

// Let the path begin, once, towards the state that balances a small part of the load, sought without a plane across
// the path; whether there is one.
//
// Which faces that touch without force press or part at rest is up to rounding, and with them where the path seems to
// lead: planes across a wrong direction are met behind the state of rest, or nowhere. A path that does not rise has its
// peak at rest, and bodies that have to move far for so little have moved.
inline bool set_out(const Elastic& m, Work& work, Stepper& stepper, const Fronts* fronts, Breath& breath) {
    Progress& now = stepper.now;
    if (now.points > 0 || now.set_out || now.slope <= 0) return false;
    now.set_out = true;
    const Balance held{1.0, 0.0, 1.0, stepper.path.anchor};
    const double s = FIRST_LOAD / now.strength;
    put(stepper.trial, stepper.q);
    put(stepper.scratch, work.c);
    work.c.fill(0.0);
    const Iteration point =
        newton(m, work, held, stepper.trial, s, 0.0, TOLERANCE, FIRST_NEWTON, FIRST_SHARE, fronts, breath);
    now.systems += point.systems;
    put(work.c, stepper.scratch);
    if (!point.converged || farthest(stepper.trial, stepper.q) > MOST_FIRST * now.elastic) return false;
    lead(work, stepper, s);
    now.step = s / now.slope;
    now.shortened = 0;
    now.corner = false;
    return true;
}

// Shorten a step that failed: to just before the next change of a node if that may be why, else by a factor.
//
// There the path has a corner, and perhaps turns back: then the point found was ``backward``.
inline void shorten(const Elastic& m, Stepper& stepper, bool backward) {
    Progress& now = stepper.now;
    if (now.shortened == 1) now.beyond = SHORTER * now.step;
    const double change = next_change(m, stepper.q, stepper.tangent);
    now.corner = (backward || now.shortened > 1) && NEAR * now.step <= change && change <= now.step;
    now.step *= now.corner ? BEFORE * change / now.step : SHORTER;
    now.fastest = CAREFUL;
}

// Take the point that was tried, with load ``s``, as the present one, and keep the bracket of the peak
inline void land(const Elastic& m, Work& work, Stepper& stepper, double s, double sign) {
    Progress& now = stepper.now;
    const Vec trial = stepper.trial;
    const bool higher = s > now.highest;
    const double rise = now.slope * now.step, falls = work.rhs(trial.size(), 1) * now.step;
    now.shortened = now.doubted = 0;
    ++now.points;
    ++now.late;
    now.length += now.step;
    if (now.dipped == 0 && s < (1 - DIP) * now.highest) now.dipped = now.highest;
    measure_dip(now, rise, s, falls);
    if (now.slid <= SLID) {
        const double far = slid(m, stepper.start, trial, stepper.stuck, s, work.v, work.F, stepper.scratch);
        measure_sliding(now, rise, s, falls, far);
    }
    if (now.topped) before_peak(work, stepper);
    if (higher) {
        if (now.first == 0) now.first = now.dipped;
        now.highest = s;
        put(stepper.peak_q, trial);
    }
    now.slope = turn(work, sign, now.orientation, stepper.tangent);
    put(stepper.q, trial);
    now.s = now.last = s;
    if (higher) {
        put(stepper.peak_plane, work.c);
        if (s > (1 + RISEN) * now.stored) {
            now.stored = s;
            put(stepper.stored_q, stepper.q);
        }
    }
    if (now.topped && !(now.peaked || now.slope <= 0)) {
        now.closed = false;
        before_peak(work, stepper);
    } else if (now.topped || !now.closed) {
        behind_peak(stepper);
    }
}

// Try a step along the path, and take it if it leads to a new point
inline Event advance(const Elastic& m, Work& work, Stepper& stepper, const Fronts* fronts, Breath& breath) {
    Progress& now = stepper.now;
    const Vec q = stepper.q, trial = stepper.trial, aimed = stepper.aimed;
    go(trial, q, now.step, stepper.tangent);
    put(aimed, trial);
    const double s = now.s + now.step * now.slope, level = dot(work.c, trial);
    const bool first = now.points == 0;
    const Iteration point = newton(m, work, stepper.path, trial, s, level, tolerance_at(now),
                                   first ? FIRST_NEWTON : MOST_NEWTON, first ? FIRST_SHARE : SHORTEST, fronts, breath);
    now.systems += point.systems;
    // Behind its plane the path would come back: rather another branch
    bool backward = now.orientation * point.sign < 0;
    now.turned = farthest(trial, aimed) / std::max(farthest(aimed, q), 1e-300);
    if (point.converged && backward && now.shortened > 0 && straight(work, stepper.tangent)) {
        now.orientation = -now.orientation;  // another branch leaves the path, which goes on
        backward = false;
    }
    if (point.converged && !backward && now.doubted < DOUBTS && doubtful(m, work, stepper, point)) {
        ++now.doubted;
        if (first && point.s > now.s) lead(work, stepper, point.s);
        now.step *= SHORTER;
        return Event::TORN;
    }
    if (!point.converged || (backward && now.shortened < SHORTENINGS - 1)) {
        ++now.shortened;
        if (now.shortened == SHORTENINGS) return Event::STUCK;
        shorten(m, stepper, backward);
        return Event::SHORTENED;
    }
    if (!first) now.sharpest = std::max(now.sharpest, now.turned);
    land(m, work, stepper, point.s, point.sign);
    now.by_springs = by_springs(m, q);
    return Event::ADVANCED;
}

// Go straight on to just behind the next change of a node's state, and take the path's direction there
inline Event cross_change(const Elastic& m, Work& work, Stepper& stepper, const Fronts* fronts) {
    Progress& now = stepper.now;
    const Vec q = stepper.q;
    const double tolerance = tolerance_at(now);
    double change = next_change(m, q, stepper.tangent);
    if (now.corner && change > NEAR * now.beyond) {  // it was none: the path goes on without it
        now.corner = false;
        set_next_step(now);
        return Event::ADVANCED;
    }
    ++now.changes;
    // Further out rounding would balance anything
    if (now.changes > MOST_CHANGES || !(now.length + change <= FARTHEST * now.elastic)) return Event::ASTRAY;
    change = change * (1 + 1e-7) + 1e-12 * (now.elastic + now.length);
    go(q, q, change, stepper.tangent);
    now.s += change * now.slope;
    now.length += change;
    unbalance(m, work, stepper.path, q, now.s);
    work.rhs.fill(0.0);
    work.rhs(q.size(), 1) = 1.0;
    // A body that comes to stand on one point may tip and turn in any direction; a level path goes on behind such
    // points
    const bool rises = now.slope * now.length > FLAT * std::abs(now.s);
    const double sign = solve(m, work, 0.0, 0.0, fronts, rises ? ROUNDED : 0.0);
    ++now.systems;
    if (sign == SINGULAR) {
        if (now.s > now.highest && worst(m, work.r) <= tolerance) {
            now.highest = now.s;
            put(stepper.peak_q, q);
        }
        return Event::RELEASED;
    }
    now.slope = turn(work, sign, now.orientation, stepper.tangent);
    now.step = std::min(now.beyond, 0.1 * (now.elastic + now.length));
    now.shortened = 0;
    now.corner = false;
    now.fastest = now.growth;
    return Event::NODE_CHANGED;
}

// ENDLESS if contact forces balance the load without any weight, sought from the present point over s; ADVANCED.
//
// If they do, ``peak_q`` becomes the displacement under the load alone and ``peak_plane`` the present plane; if not,
// ``peak_q`` becomes the present point.
inline Event sought_alone(const Elastic& m, Work& work, Stepper& stepper, const Fronts* fronts, Breath& breath) {
    Progress& now = stepper.now;
    const Vec q = stepper.peak_q, plane = stepper.scratch, anchor = stepper.aimed;
    divide(q, stepper.q, now.s);
    put(plane, work.c);
    put(anchor, q);
    work.c.fill(0.0);
    const Balance held{0.0, FAINT, 1.0, anchor};  // bodies that the load does not reach float: a faint drag holds them
    const Iteration alone =
        newton(m, work, held, q, 1.0, 0.0, TOLERANCE * now.strength, MOST_ALONE, 0.0, fronts, breath);
    unbalance(m, work, Balance{0.0, 0.0, 0.0, anchor}, q, 1.0);
    now.systems += alone.systems;
    if (alone.converged && worst(m, work.r) <= 10 * TOLERANCE * now.strength) {
        put(stepper.peak_plane, plane);
        return Event::ENDLESS;
    }
    put(work.c, plane);
    put(q, stepper.q);
    return Event::ADVANCED;
}

}  // namespace holdfast
