"""What the compiled core says of a step along a load path, by name (``native/outcome.hpp``)."""

from __future__ import annotations

from enum import IntEnum


class Event(IntEnum):
    """What a step along a load path met."""

    BEGUN = 0  # the path has a direction at the state of rest
    ADVANCED = 1  # a new point on the path
    TORN = 2  # the point may lie on another branch of the path: the step is shortened
    SHORTENED = 3  # no point ahead was found: the step is shortened
    NODE_CHANGED = 4  # the path goes on just behind the next change of a node's state
    STUCK = 5  # no shorter step succeeded either: a node is about to change its state
    PROPORTIONAL = 6  # the load has long grown in proportion to the length: perhaps without end
    NO_BEGINNING = 7  # at the state of rest the path has no direction
    RELEASED = 8  # behind the change of a node a body has no contact left
    ASTRAY = 9  # too many such changes, or the next one is too far away
    FALLEN = 10  # the load is clearly below its peak, or has had no new peak for long
    FAR = 11  # so far from rest that rounding would show
    FLAT = 12  # the load does not rise any more
    ENDLESS = 13  # forces that balance the load alone were found
    REACHED = 14  # the load is as large as was asked for
