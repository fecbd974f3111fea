// Coming to rest: from bonded contacts to the elastic law, with ever less drag.
//
//     r(q) = ε D q,   D the stiffness with all contacts bonded,   ε from 1 to 0
//
// is one implicit step, of length 1/ε, of the overdamped motion D q' = r(q) from the undeformed assembly
// (pseudo-transient continuation). Where the assembly stands, q converges as ε falls; where it does not, some bodies
// drift apart at a constant rate: q grows as 1/ε while the force that drives them stays the same. With friction that is
// not associated these single steps can have no solution for some ε, or several; then the motion itself is followed, in
// steps r(q) = ε D (q - q_before) of whatever length 1/ε succeeds.

#pragma once

#include <algorithm>
#include <cmath>

#include "newton.hpp"
#include "outcome.hpp"

namespace holdfast {

constexpr double ON_THE_WAY = 1e-9;  // unbalance of intermediate states, with drag
// Growth of ON_THE_WAY for each size of the bonded displacement that bodies have moved, since rounding errors grow
constexpr double FARTHER = 1e-6;
constexpr double STEADY = 0.01;       // relative change of its rate below which a drift is steady
constexpr double DECADES = 1e4;       // factor by which ε must have fallen while a drift was steady
constexpr double LONG_DRIFT = 1e3;    // factor by which time must have grown while a drift was steady, where the motion
                                      // itself is followed
constexpr double CLEAR = 100.0;       // a force drives a drift if it is at least this many times the rounding error of
                                      // the balance
constexpr double LEAST_DRAG = 1e-13;  // ε below which no rest is sought in single steps
constexpr double SLOWEST = 0.97;      // factor by which ε falls at least from one single step to the next
constexpr double STIFFEST = 1e3;      // ε above which the motion is not followed in still shorter steps

// How the search for rest ended; ``steps`` of Newton's method, and the ``drag`` ε of the last state found
struct Rest {
    RestOutcome outcome;
    Int steps;
    double drag;
};

// Find q (6J,) at rest under ``weight`` times the wrench and no load, with ever less drag.
//
// A state is at rest if its unbalance is at most ``exact``, each body's in units of its own weight.
//
// Each state is sought in a single step from the undeformed assembly, and q is at first the displacement with all
// contacts bonded. Where bodies drift, ``drift`` (6J,) becomes their velocity. The search ends after ``most`` steps of
// Newton's method.
inline Rest lessen_drag(const Elastic& m, Work& work, double weight, Vec q, Vec drift, double exact, Int most,
                        const Fronts* fronts, Breath& breath) {
    const Int n = q.size();
    Array<double, 2> memory({3, n});
    const Vec origin = memory.view()[0], old = memory.view()[1], bonded = memory.view()[2];
    const auto seek = [&](Vec from, double drag, double tolerance, Int steps) {
        return newton(m, work, Balance{weight, drag, 1.0, origin}, from, 0.0, 0.0, tolerance, steps, 0.0, fronts,
                      breath);
    };
    work.w.fill(0.0);
    work.c.fill(0.0);
    put(bonded, q);
    Iteration found = seek(q, 0.0, exact, 30);
    Int taken = found.steps;
    double reached = 1.0;
    if (found.converged) return {RestOutcome::RESTS, taken, reached};
    scale(q, 0.5, bonded);
    double drag = 1.0, factor = 0.5, steady = drag, rate = 0.0;
    Int states = -1;
    while (drag > LEAST_DRAG && taken < most) {
        put(old, q);
        const double spread = largest(q) / std::max(largest(bonded), 1e-300);
        found = seek(q, drag, ON_THE_WAY * std::max(1.0, FARTHER * spread), 25);
        taken += found.steps + 1;
        if (!found.converged) {
            put(q, old);
            if (factor > SLOWEST) break;
            drag /= factor;
            factor = std::sqrt(factor);
            drag *= factor;
            continue;
        }
        reached = drag;
        go(drift, q, -1.0, old);
        const double top = largest(q);
        if (std::abs(drag * top - rate) > STEADY * rate || found.states != states) steady = drag;
        const bool growing = drag * top > 0.5 * rate;
        rate = drag * top;
        states = found.states;
        if (steady >= DECADES * drag) return {RestOutcome::DRIFTS, taken, reached};
        Int steps = found.steps;
        if (!growing || steady > 0.99 * drag) {
            put(old, q);
            found = seek(old, 0.0, exact, 12);
            taken += found.steps + 1;
            if (found.converged) {
                put(q, old);
                return {RestOutcome::RESTS, taken, reached};
            }
            steps = found.steps;
        }
        if (steps < 6 || factor > 0.9) factor = std::max(factor * factor, 0.01);
        drag *= factor;
    }
    return {RestOutcome::LOST, taken, reached};
}

// Find rest as ``lessen_drag`` does, but along the overdamped motion D q' = r(q) from q, by implicit steps.
//
// It drifts where its velocity has been the same for nearly all of the time and of the way, with a force that is no
// rounding error. It gives up after ``most`` steps of Newton's method.
inline Rest move(const Elastic& m, Work& work, double weight, Vec q, Vec drift, double exact, Int most,
                 const Fronts* fronts, Breath& breath) {
    const Int n = q.size();
    Array<double, 2> memory({4, n});
    const Vec origin = memory.view()[0], trial = memory.view()[1], steady = memory.view()[2], first = memory.view()[3];
    const Balance free{weight, 0.0, 1.0, origin};
    put(first, q);
    work.w.fill(0.0);
    work.c.fill(0.0);
    double drag = 1.0, time = 0.0, since = 0.0, before = 0.0, reached = 0.0;
    Int taken = 0;
    while (taken < most && drag < STIFFEST) {
        const double noise = rounding(m, q);
        put(trial, q);
        Iteration found = newton(m, work, Balance{weight, drag, 1.0, q}, trial, 0.0, 0.0, std::max(ON_THE_WAY, noise),
                                 12, 0.0, fronts, breath);
        taken += found.steps + 1;
        reached = drag;
        if (!found.converged) {
            drag *= 4;
            continue;
        }
        const Int steps = found.steps;
        go(drift, trial, -1.0, q);
        scale(drift, drag, drift);
        put(q, trial);
        time += 1 / drag;
        const double rate = largest(steady);
        if (!(farthest(drift, steady) <= STEADY * rate) || rate == 0.0) {
            put(steady, drift);
            since = time;
            before = farthest(q, first);
        }
        unbalance(m, work, free, q, 0.0);
        const bool clear = worst(m, work.r) > CLEAR * std::max(ON_THE_WAY, noise);
        if (clear && time > LONG_DRIFT * since && rate * (time - since) > before) {
            return {RestOutcome::DRIFTS, taken, reached};
        }
        put(trial, q);
        const double tolerance = std::max(exact, std::min(noise, ON_THE_WAY));
        found = newton(m, work, free, trial, 0.0, 0.0, tolerance, clear ? 8 : 30, 0.0, fronts, breath);
        taken += found.steps + 1;
        if (found.converged) {
            put(q, trial);
            return {RestOutcome::RESTS, taken, reached};
        }
        if (steps == 0) break;  // no step is due, and none leads to rest
        if (steps <= 3) {
            drag /= 4;
        } else if (steps <= 6) {
            drag /= 2;
        }
    }
    return {RestOutcome::LOST, taken, reached};
}

// Set q (6J,) to the displacement under a ``load`` (6J,) with all contacts bonded
inline void bond_all(const Elastic& m, Work& work, In load, Vec q, const Fronts* fronts) {
    work.K.fill(0.0);
    work.w.fill(0.0);
    work.c.fill(0.0);
    work.rhs.fill(0.0);
    set_column(work.rhs, 0, load);
    solve(m, work, 1.0, 1.0, fronts);  // drag alone: that of bonds
    get_column(work.rhs, 0, q);
}

}  // namespace holdfast
