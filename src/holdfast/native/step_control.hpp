// The numbers of a walk along a load path, and what follows from them alone: whether it ends, and the next step.

#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "cubic.hpp"
#include "outcome.hpp"
#include "span.hpp"

namespace holdfast {

// Relative fall from which the highest point so far counts as a maximum, even if the path rises above it later
constexpr double DIP = 2e-3;
constexpr double FALLEN = 0.99;  // share of the peak below which the path has clearly fallen
constexpr double DEEPER = 3.0;   // how many times its estimate the depth of a fall between two points may be
// Share of the slope before a step below which it may hide a maximum, and how high, as a share of the load
constexpr double LEVEL = 0.05, HIDDEN = 0.05;
constexpr double FLAT = 1e-4;    // a path is flat if it would rise by less than this in all, were its slope to fall as
                                 // 1/ℓ²
constexpr double ENOUGH = 1.01;  // extra length of the step that is to show that a path has been flat or lower for
                                 // long enough
constexpr double NEW_PEAK = 1e-4;  // relative rise above the peak so far that counts as a new peak
constexpr double FARTHEST = 1e8;   // largest length of a path, in displacements at rest: beyond it rounding would show
constexpr double SPRING_SHARE = 1e-5;  // share of a body's weight or of the load that the regularisation spring carries
                                       // where a path ends
// How far the contacts of a body may slide, in times what it would move if every contact stuck, before a load counts as
// held only after sliding. In this law friction opposes all of the displacement, in reality the last of it: both agree
// until contacts have slid a few times as far as they give. Of 473 pushes in jams, piles and ordinary scenes, MuJoCo
// and discrete elements both let none go below what is reached at 3, and one at 4 (bench/suites/held.py)
constexpr double SLID = 3.0;
constexpr double RECOVERY = 1.4;  // factor by which the largest growth recovers from one point to the next
// How far behind a peak another one is awaited, in lengths at the peak: if the load fell, and if not
constexpr double SOON = 10.0, LONG = 100.0;

// How closely a path is followed; ``elastic/system.py`` says what each number is
struct StepControl {
    double growth, correction;
    Int patience, most;
    static constexpr auto fields =
        std::tuple{&StepControl::growth, &StepControl::correction, &StepControl::patience, &StepControl::most};
};

// The numbers of a walk along a path.
//
// Constants: those of the StepControl; ``orientation``, the sign of the stiffness's determinant at rest; ``strength``,
// the largest component of the load, each body's in its own weight and size; ``elastic``, the largest displacement at
// rest that counts.
//
// Where it is: ``s`` and the ``slope`` ds/dℓ; what the regularisation spring has carried, ``by_springs``, of each
// body's own weight, and carries at ``rest``; the ``step`` Δℓ to be tried; the ``length`` ℓ so far; ``last``, s of the
// last regular point; ``turned``, the last correction as a share of its step, and the ``sharpest``, the largest of all
// points but the first; ``points`` found, linear ``systems`` solved, node ``changes`` crossed; how often this step
// failed and was ``shortened``, and how often it was ``doubted``; the ``fastest`` growth of the step for now; whether
// a ``corner`` lies just behind the step, and the step to be tried ``beyond`` it; whether its beginning was sought from
// the load (``set_out``); whether the path began to rise (``rises``).
//
// Of the peak: ``highest`` s; ``noted``, the last s that counted as a new peak, at the length ``at_peak``, and the
// points since (``late``); the maximum from which s has ``dipped``, and the ``first`` one above which it has risen
// after that, 0 if there was none; the ``crest``, the highest s between points, as estimated, and the lowest point
// since, the ``trough``; whether the last step ``topped`` what was highest, and whether it hid a maximum (``peaked``).
// The peak lies between a point where s rises (``rising_s``, ``rising_slope``) and one where it does not
// (``falling_s``, ``falling_slope``), once the latter is known: ``closed``. The load ``stored`` of a point on the way
// to it, 0 if there is none.
//
// Of what was reached before contacts have slid far (SLID): how far they had ``slid`` at the last point, or where that
// first was far, and the highest s ``before`` that.
//
// Of the end: the lengths since which the path has been flat (``flat_since``) and since which s has grown in
// proportion to ℓ (``similar_since``); inf if it is not.
struct Progress {
    double growth, correction;
    Int patience, most;
    double orientation = 0.0, strength = 0.0, elastic = 0.0;
    double s = 0.0, slope = 0.0, by_springs = 0.0, rest = 0.0, step = 0.0, length = 0.0, last = 0.0;
    double turned = 0.0, sharpest = 0.0;
    Int points = 0, systems = 0, changes = 0, shortened = 0;
    double fastest, beyond = 0.0;
    bool corner = false, set_out = false;
    Int doubted = 0;
    double highest = 0.0, noted = 0.0, at_peak = 0.0;
    Int late = 0;
    double dipped = 0.0, first = 0.0, crest = 0.0, trough = 0.0;
    double rising_s = 0.0, rising_slope = 0.0, falling_s = 0.0, falling_slope = 0.0;
    bool closed = false;
    double stored = 0.0;
    bool peaked = false, topped = false, rises = false;
    double slid = 0.0, before = 0.0, flat_since = 0.0, similar_since = 0.0;

    explicit Progress(const StepControl& pace)
        : growth(pace.growth),
          correction(pace.correction),
          patience(pace.patience),
          most(pace.most),
          fastest(pace.growth) {}
};

// Take note of the highest s between points and of the lowest point since, where a step leads to ``s``.
//
// ``rise`` is what s would have risen by at the slope before the step, and ``falls`` at the slope behind it.
inline void measure_dip(Progress& now, double rise, double s, double falls) {
    const double x = maximum_at(now.s, rise, s, falls);
    const double between = x > 0 ? cubic(x, now.s, rise, s, falls) : now.s;
    now.peaked = between > std::max(now.s, s);
    const double top = std::max(between, s);
    now.topped = top > now.crest || s > now.highest;
    if (top > now.crest) {
        now.crest = top;
        now.trough = s;
        if (top > now.noted * (1 + NEW_PEAK)) {
            now.at_peak = now.length - (now.peaked ? 1 - x : 0.0) * now.step;
            now.late = 0;
            now.noted = top;
        }
    }
    now.trough = std::min(now.trough, s);
}

// Whether a step to where the path is nearly level, at ``s``, may have passed over a maximum of the load.
//
// That may have gone on as before for a while: by HIDDEN more than it is now, had it done so all the way. The slopes
// at both ends are as ``measure_dip`` has them.
inline bool passes_over(const Progress& now, double rise, double s, double falls) {
    return falls < LEVEL * rise && now.s + rise > s + HIDDEN * std::abs(s);
}

// Take note of the highest s before contacts have slid far, where a step leads to ``s`` and they have ``slid``.
//
// ``rise`` and ``falls`` are as ``measure_dip`` has them. Once they have slid far, what follows does not count.
inline void measure_sliding(Progress& now, double rise, double s, double falls, double slid) {
    const double reached = slid <= SLID ? s : cubic((SLID - now.slid) / (slid - now.slid), now.s, rise, s, falls);
    now.before = std::max(now.before, reached);
    now.slid = slid;
}

// By how much of ``high`` the load has fallen
inline double fall(double low, double high) { return 1 - low / std::max(high, 1e-300); }

// Whether a load may have clearly fallen that did so by ``seen`` from point to point, and between by estimate
inline bool may_have_fallen(double seen, double estimate) {
    return seen + DEEPER * std::max(estimate - seen, 0.0) > 1 - FALLEN;
}

// Whether a step to ``s`` may hide how far the load falls, where that decides about a maximum.
//
// Between the ends it is about as high and low as the cubic with the slopes there, which ``measure_dip`` has, too.
inline bool hides_dip(const Progress& now, double rise, double s, double falls) {
    const double high_at = maximum_at(now.s, rise, s, falls), low_at = minimum_at(now.s, rise, s, falls);
    if (high_at < 0 && low_at < 0) return false;
    double top = now.crest, bottom = now.trough, most = 0.0;
    for (const bool second : {false, true}) {  // a maximum and a minimum, as they follow each other
        if (high_at > 0 && second == (0 < low_at && low_at < high_at)) {
            const double between = cubic(high_at, now.s, rise, s, falls);
            if (between > top) top = bottom = between;
        }
        if (low_at > 0 && second == (0 < high_at && high_at < low_at)) {
            bottom = std::min(bottom, cubic(low_at, now.s, rise, s, falls));
            most = fall(bottom, top);
        }
    }
    most = std::max(most, fall(std::min(bottom, s), top));
    const double seen = fall(s < now.highest ? std::min(now.trough, s) : s, std::max(now.highest, s));
    const bool clearly = seen <= 1 - FALLEN && may_have_fallen(seen, most);
    return clearly || (now.dipped == 0 && seen <= DIP && DIP < most);
}

// Whether the load falls or is below a maximum
inline bool has_fallen(const Progress& now) { return now.slope < 0 || now.s < (1 - DIP) * now.crest; }

// The length up to which a path has to remain flat to have no other end
inline double flat_end(const Progress& now) {
    return std::max(10 * std::min(now.flat_since, now.length), 30 * now.elastic);
}

// Whether the new point is the end of the path: FALLEN, FAR, FLAT, perhaps PROPORTIONAL, or else ADVANCED
inline Event appraise(Progress& now) {
    constexpr double INF = std::numeric_limits<double>::infinity();
    const double s = now.s, slope = now.slope, length = now.length, elastic = now.elastic;
    const double longest = (has_fallen(now) ? SOON : LONG) * now.at_peak;
    if (s < FALLEN * now.highest || length >= longest || now.late > now.patience) return Event::FALLEN;
    if (std::abs(slope) * length > FLAT * std::abs(s)) {
        now.flat_since = INF;
    } else if (length >= flat_end(now)) {
        return Event::FLAT;
    } else {
        now.flat_since = std::min(now.flat_since, length);
    }
    if (slope > 0 && std::abs(slope * length - s) < 0.05 * s) {
        now.similar_since = std::min(now.similar_since, length);
        if (length >= 10 * now.similar_since && length > 100 * elastic) {
            now.similar_since = length;
            return Event::PROPORTIONAL;
        }
    } else {
        now.similar_since = INF;
    }
    const double carried = now.rest + SPRING_SHARE * std::max(1.0, now.strength * std::abs(s));
    if (length > FARTHEST * elastic || now.by_springs > carried) return Event::FAR;
    return Event::ADVANCED;
}

// Make the next step longer or shorter, as the last one needed little correction or much.
//
// Where the load falls it is to be seen how far: a longer step would pass over the dip, and behind a maximum it soon
// may rise to a higher one. One that is longer than it takes to see that a path remains flat, or that the load remains
// below its peak, would lead to where other contacts stop bodies that have long begun to slide.
inline void set_next_step(Progress& now) {
    const double fastest = now.peaked ? 1.0 : now.fastest;
    const double wanted = std::max(now.correction / std::max(now.turned, 1e-9), 0.7);
    now.step = std::min(now.step * std::min(wanted, fastest), 3 * now.length);
    if (now.slope < 0) now.step = std::min(now.step, (1 - FALLEN) * now.highest / -now.slope);
    double end = FARTHEST * now.elastic;
    if (has_fallen(now) && now.length < SOON * now.at_peak) end = std::min(end, SOON * now.at_peak);
    if (now.flat_since < std::numeric_limits<double>::infinity() && now.length < flat_end(now)) {
        end = std::min(end, flat_end(now));
    }
    now.step = std::min(now.step, ENOUGH * (end - now.length));
    now.fastest = std::min(RECOVERY * now.fastest, now.growth);
}

}  // namespace holdfast
