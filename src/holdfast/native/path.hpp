// The load path, from rest to its peak and beyond, by arc length.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "beginning.hpp"
#include "cubic.hpp"
#include "direction.hpp"
#include "newton.hpp"
#include "outcome.hpp"
#include "step_control.hpp"
#include "stepper.hpp"

namespace holdfast {

constexpr double REFINED = 5e-5;  // relative accuracy of the peak
constexpr int REFINEMENTS = 20;   // largest number of points that are tried to reach that accuracy
constexpr int MOST_FAILURES = 5;  // largest number of these points in a row that may fail
constexpr double CLOSER = 0.2;    // factor by which the next one is closer to the point before the peak
constexpr Int MOST_REFINED = 12;  // largest number of Newton steps for one of them
constexpr Int MOST_SOUGHT = 20;   // largest number of Newton steps in search of a point on another grid
constexpr double TINY = 0.02;     // share of a Newton step below which the search for a load is given up there; states
                                  // in balance use SHORTEST

// What k load paths gave, among n = 6J displacements; ``elastic/system.py`` says what each array is
struct PathResult {
    Ints outcome;
    Vec peak, first, before, sharpest, last;
    Ints systems;
    Mat q, motion, plane;
    static constexpr auto fields = std::tuple{
        &PathResult::outcome, &PathResult::peak,    &PathResult::first, &PathResult::before, &PathResult::sharpest,
        &PathResult::last,    &PathResult::systems, &PathResult::q,     &PathResult::motion, &PathResult::plane};
};

// Aim at the mean of the points ``x`` ahead of one end of the bracket and ``back`` from the other, by ``share``
inline void aim_between(Stepper& stepper, double share, double x, double back) {
    const Vec ahead = stepper.aimed, behind = stepper.trial;
    go(ahead, stepper.rising_q, x, stepper.rising_tangent);
    go(behind, stepper.falling_q, -back, stepper.falling_tangent);
    mix(stepper.trial, ahead, share, behind);
}

// Let the point that was tried, with load ``s``, replace one end of the bracket of the peak.
//
// The maximum remains between: in front of a point that is lower than where s still rose, and behind one in a dip.
inline void narrow(Work& work, Stepper& stepper, double s, double sign) {
    Progress& now = stepper.now;
    const Vec q = stepper.trial, tangent = stepper.tangent;
    const double slope = turn(work, sign, now.orientation, tangent);
    if (s > now.highest) {
        now.highest = s;
        put(stepper.peak_q, q);
        put(stepper.peak_plane, work.c);
    }
    const bool in_dip = now.rising_slope <= 0 && s < now.falling_s;
    if (in_dip || (slope > 0 && s >= now.rising_s)) {
        put(stepper.rising_q, q);
        put(stepper.rising_tangent, tangent);
        put(stepper.rising_plane, work.c);
        now.rising_s = s;
        now.rising_slope = slope;
    } else {
        put(stepper.falling_q, q);
        put(stepper.falling_tangent, tangent);
        now.falling_s = s;
        now.falling_slope = slope;
    }
}

// Close in on the peak from both sides, where there is a point behind it.
//
// Its place and height are estimated from s and slope at both ends (``summit``).
inline void refine(const Elastic& m, Work& work, Stepper& stepper, const Fronts* fronts, Breath& breath) {
    Progress& now = stepper.now;
    const Vec q = stepper.trial, plane = stepper.rising_plane;
    int failed = 0;
    for (int refinement = 0; refinement < REFINEMENTS; ++refinement) {
        const double apart = dot(plane, stepper.falling_q) - dot(plane, stepper.rising_q);
        const double along = dot(plane, stepper.falling_tangent);
        if (!now.closed || apart <= 0 || failed > MOST_FAILURES) break;
        const double falling = along > 0 ? now.falling_slope / along : 0.0;
        const auto [place, estimate] = summit(now.rising_s, now.rising_slope * apart, now.falling_s, falling * apart);
        if (estimate - now.highest <= REFINED * now.highest) break;
        const double x = std::min(std::max(place, 0.1), 0.9) * apart * std::pow(CLOSER, failed);
        const double share = failed == 0 ? x / apart : 0.0, back = along > 0 ? (apart - x) / along : 0.0;
        aim_between(stepper, share, x, back);
        const double s = (1 - share) * (now.rising_s + now.rising_slope * x) + share * now.falling_s;
        put(work.c, plane);
        const double level = dot(plane, stepper.rising_q) + x;
        const Iteration point =
            newton(m, work, stepper.path, q, s, level, TOLERANCE, MOST_REFINED, 0.0, fronts, breath);
        now.systems += point.systems;
        if (!point.converged) {
            ++failed;
            continue;
        }
        failed = 0;
        narrow(work, stepper, point.s, point.sign);
    }
}

// Whether the load has clearly fallen since its peak, which lies between points: if that decides, it is refined
inline bool fell_from_crest(const Elastic& m, Work& work, Stepper& stepper, const Fronts* fronts, Breath& breath) {
    Progress& now = stepper.now;
    if (!now.closed || now.crest <= now.highest) return false;
    if (!may_have_fallen(fall(now.trough, now.highest), fall(now.trough, now.crest))) return false;
    put(stepper.scratch, stepper.tangent);
    refine(m, work, stepper, fronts, breath);
    now.crest = now.highest;
    put(stepper.tangent, stepper.scratch);
    divide(work.c, stepper.tangent, dot(stepper.tangent, stepper.tangent));  // as ``turn`` sets it
    return now.trough < FALLEN * now.crest;
}

// Step along a path until it falls, is flat, far or endless, is lost, or leads to ``most`` times the load
inline Event walk(const Elastic& m, Work& work, Stepper& stepper, In start, In load, double most, const Fronts* fronts,
                  Breath& breath) {
    Progress& now = stepper.now;
    Event event = begin(m, work, stepper, start, load, fronts, breath);
    now.rises = now.slope > 0;
    while (goes_on(event) && now.points < now.most) {
        event = advance(m, work, stepper, fronts, breath);
        if (event == Event::STUCK) {
            const bool begins = set_out(m, work, stepper, fronts, breath);
            event = begins ? Event::TORN : cross_change(m, work, stepper, fronts);
        } else if (event == Event::ADVANCED) {
            event = now.s < most ? appraise(now) : Event::REACHED;
            if (event == Event::ADVANCED && fell_from_crest(m, work, stepper, fronts, breath)) event = Event::FALLEN;
            if (event == Event::PROPORTIONAL) event = sought_alone(m, work, stepper, fronts, breath);
            if (event == Event::ADVANCED && now.corner) {
                event = cross_change(m, work, stepper, fronts);
            } else {
                set_next_step(now);
            }
        }
    }
    return event;
}

// Raise s from 0 at the rest state ``start`` (n,) along the path r(q) + s load = 0; the result goes ``into`` a row.
//
// 1. Find the direction in which the path begins, and 2. step along it, as ``walk`` does. 3. If it has a peak, refine
// that.
inline void follow(const Elastic& m, Work& work, Stepper& stepper, In start, In load, const PathResult& into, Int row,
                   double most, const Fronts* fronts, Breath& breath) {
    const Progress& now = stepper.now;
    const Event event = walk(m, work, stepper, start, load, most, fronts, breath);
    PathOutcome outcome = outcome_of(event);
    if (outcome == PathOutcome::PEAK && now.rises && now.highest <= 0) {  // it was left at the first step
        outcome = PathOutcome::LOST;
    }
    put(into.q[row], stepper.peak_q);
    if (event == Event::NO_BEGINNING) return;
    if (outcome == PathOutcome::PEAK || outcome == PathOutcome::LOST) {
        const Vec motion = into.motion[row];
        put(motion, stepper.tangent);
        if (!find_motion(m, work, stepper, motion, fronts, breath) && outcome == PathOutcome::LOST) motion.fill(0.0);
    }
    if (outcome == PathOutcome::PEAK) {
        refine(m, work, stepper, fronts, breath);
        put(into.q[row], stepper.peak_q);
    }
    put(into.plane[row], stepper.peak_plane);
    into.outcome[row] = static_cast<Int>(outcome);
    into.peak[row] = outcome == PathOutcome::ENDLESS ? std::numeric_limits<double>::infinity() : now.highest;
    into.first[row] = now.first > 0 ? now.first : into.peak[row];
    into.sharpest[row] = now.sharpest;
    into.last[row] = now.last;
    into.systems[row] = now.systems;
    into.before[row] = now.slid > SLID ? std::min(now.before, into.peak[row]) : into.peak[row];
}

// ``follow`` the ``rows`` of ``loads`` (k, n), each up to ``most`` (k,) times the load
inline void follow_each(const Elastic& m, Work& work, Stepper& stepper, In start, InMat loads, const PathResult& into,
                        InInts rows, In most, const Fronts* fronts, Breath& breath) {
    for (const Int row : rows) {
        follow(m, work, stepper, start, loads[row], into, row, most[row], fronts, breath);
    }
}

// The load at plane · q on paths of another model, from points (s, q) of this one's; -1 where not found.
//
// The other model has the same bodies and other nodes. Of ``rows`` of ``loads`` (k, n), ``s`` (k,), ``q`` and ``plane``
// (k, n), it goes ``into`` (k,).
inline void loads_nearby(const Elastic& m, Work& work, InMat loads, In s, InMat q, InMat plane, Vec into, InInts rows,
                         const Fronts* fronts, Breath& breath) {
    Array<double, 2> memory({2, q.size(1)});
    const Vec origin = memory.view()[0], there = memory.view()[1];
    const Balance path{1.0, 0.0, 0.0, origin};
    for (const Int k : rows) {
        put(work.w, loads[k]);
        put(work.c, plane[k]);
        put(there, q[k]);
        const double tolerance = TOLERANCE * std::max(1.0, worst(m, loads[k]) * s[k]), level = dot(plane[k], there);
        const Iteration point = newton(m, work, path, there, s[k], level, tolerance, MOST_SOUGHT, TINY, fronts, breath);
        into[k] = point.converged ? point.s : -1.0;
    }
}

// Tell whether the model rests in a state near ``q`` (n,), which becomes that state, without any motion to it
inline bool rests_near(const Elastic& m, Work& work, Vec q, const Fronts* fronts, Breath& breath) {
    Array<double> origin({q.size()});
    const Balance held{1.0, 0.0, 1.0, origin.view()};
    work.c.fill(0.0);
    work.w.fill(0.0);
    return newton(m, work, held, q, 0.0, 0.0, TOLERANCE, MOST_SOUGHT, SHORTEST, fronts, breath).converged;
}

}  // namespace holdfast
