// The motion that begins at the peak of a load path.

#pragma once

#include <algorithm>
#include <cmath>

#include "newton.hpp"
#include "stepper.hpp"

namespace holdfast {

constexpr double BEYOND = 1.01;      // times the peak: the load under which motion begins
constexpr double LONG_AFTER = 1e-4;  // at this drag a step leads so far that contacts have changed as they do in the
                                     // motion
constexpr double FALLS = 0.05;       // factor by which the drag decreases at first
constexpr int MOST_MOVES = 16;       // largest number of steps in time
constexpr double DRAG = 1e-9;        // drag in the longest step: contacts that press resist far more
constexpr double FREE = 0.5;         // smallest share of the power of the load that contacts leave to a motion which
                                     // they allow
constexpr Int MOST_FOR_MOVE = 20;    // largest number of Newton steps for one step in time

// Set ``motion`` (n,) to the slow motion from q under the load, (K + ε D) x = w, of which the load's power is 1.
//
// False where it is contacts that resist it, not drag or the regularisation spring.
inline bool moves_freely(const Elastic& m, Work& work, Stepper& stepper, In q, Vec motion, const Fronts* fronts) {
    const Vec found = stepper.scratch;
    unbalance(m, work, stepper.path, q, stepper.now.s);
    work.rhs.fill(0.0);
    set_column(work.rhs, 1, work.w);
    const double sign = solve(m, work, DRAG, 1.0, fronts);
    ++stepper.now.systems;
    get_column(work.rhs, 1, found);
    const double power = dot(work.w, found);
    if (sign == SINGULAR || !std::isfinite(power) || power == 0.0) return false;
    divide(motion, found, power);
    work.r.fill(0.0);
    add_drag(m, work, DRAG, motion, stepper.path.anchor);
    for (Int i = 0; i < q.size(); ++i) work.r[i] -= m.hold[i] * motion[i];
    return std::abs(power * dot(work.r, motion)) > FREE;
}

// Set ``motion`` (n,) to what begins to move under a little more than the highest load; whether contacts allow it.
//
// That is the drift of the overdamped motion from just before the peak, under BEYOND times the load, in ever longer
// implicit steps, as in the search for rest (resting.hpp); where it is not found, what drag alone resists at the end of
// the path. The path's own direction is no answer: where pressure is concentrated on few nodes, no contact resists
// that a body spins about them, so any such spin may be part of it, and no load drives that.
inline bool find_motion(const Elastic& m, Work& work, Stepper& stepper, Vec motion, const Fronts* fronts,
                        Breath& breath) {
    Progress& now = stepper.now;
    const Vec q = stepper.trial, aimed = stepper.aimed, from = stepper.scratch;
    put(q, now.stored > 0 ? stepper.stored_q : stepper.peak_q);
    put(from, q);
    const double s = BEYOND * now.highest, tolerance = TOLERANCE * std::max(1.0, now.strength * std::abs(now.highest));
    const double added = s - (now.stored > 0 ? now.stored : now.highest);
    work.c.fill(0.0);
    double drag = 1.0, factor = FALLS;
    for (int move = 0; move < MOST_MOVES; ++move) {
        put(aimed, q);
        const Balance step{1.0, factor * drag, 1.0, from};
        const double enough = std::max(tolerance, rounding(m, q));
        const Iteration point = newton(m, work, step, q, s, 0.0, enough, MOST_FOR_MOVE, 0.0, fronts, breath);
        now.systems += point.systems;
        if (!point.converged) {
            put(q, aimed);
            factor = std::sqrt(factor);
            continue;
        }
        if (drag < LONG_AFTER && dot(q, motion) < dot(aimed, motion)) {  // softer than drag: on another branch
            put(q, aimed);
            break;
        }
        go(motion, q, -1.0, aimed);
        drag *= factor;
        if (drag <= DRAG) break;
    }
    go(aimed, q, -1.0, from);
    const double power = added * dot(work.w, aimed);
    work.r.fill(0.0);
    add_drag(m, work, -drag, aimed, stepper.path.anchor);
    for (Int i = 0; i < q.size(); ++i) work.r[i] += m.hold[i] * aimed[i];
    const double length = std::sqrt(dot(motion, motion));
    if (drag < LONG_AFTER && power > 0.0 && length > 0.0 && dot(work.r, aimed) > FREE * power) {
        divide(motion, motion, length);
        return true;
    }
    return moves_freely(m, work, stepper, stepper.q, motion, fronts);
}

}  // namespace holdfast
