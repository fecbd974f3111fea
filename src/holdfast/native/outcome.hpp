// How a load path ends, how coming to rest ends, and what a step along a path meets; the numbers are those of
// ``elastic/system.py``.

#pragma once

#include "span.hpp"

namespace holdfast {

// How a load path ends
enum class PathOutcome : Int {
    LOST = 0,     // no further point was found before the end was clear
    PEAK = 1,     // the load has a largest value
    ENDLESS = 2,  // contact forces balance any multiple of the load
    REACHED = 3,  // it leads to the load up to which it was to be followed
};

// How the search for a state of rest ends
enum class RestOutcome : Int {
    LOST = 0,  // neither of the two was found
    RESTS = 1,
    DRIFTS = 2,  // bodies keep moving at a constant velocity
};

// What a step along a load path met
enum class Event : Int {
    BEGUN = 0,         // the path has a direction at the state of rest
    ADVANCED = 1,      // a new point on the path
    TORN = 2,          // the point may lie on another branch of the path: the step is shortened
    SHORTENED = 3,     // no point ahead was found: the step is shortened
    NODE_CHANGED = 4,  // the path goes on just behind the next change of a node's state
    STUCK = 5,         // no shorter step succeeded either: a node is about to change its state
    PROPORTIONAL = 6,  // the load has long grown in proportion to the length: perhaps without end
    NO_BEGINNING = 7,  // at the state of rest the path has no direction
    RELEASED = 8,      // behind the change of a node a body has no contact left
    ASTRAY = 9,        // too many such changes, or the next one is too far away
    FALLEN = 10,       // the load is clearly below its peak, or has had no new peak for long
    FAR = 11,          // so far from rest that rounding would show
    FLAT = 12,         // the load does not rise any more
    ENDLESS = 13,      // forces that balance the load alone were found
    REACHED = 14,      // the load is as large as was asked for
};

constexpr Event LAST_TO_GO_ON = Event::NODE_CHANGED;

// Whether another step follows
inline bool goes_on(Event event) { return event <= LAST_TO_GO_ON; }

// How a path ends whose last step met ``event``
inline PathOutcome outcome_of(Event event) {
    if (event == Event::ENDLESS) return PathOutcome::ENDLESS;
    if (event == Event::REACHED) return PathOutcome::REACHED;
    if (event == Event::FALLEN || event == Event::FAR || event == Event::FLAT) return PathOutcome::PEAK;
    return PathOutcome::LOST;
}

}  // namespace holdfast
