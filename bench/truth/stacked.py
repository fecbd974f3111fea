"""The largest push on a stack of boxes in closed form, in 50-digit arithmetic on the numbers that the engine is given.

At every joint below the pushed box the contact forces have to pass on a force and a moment. Nodes of a joint lie in one
level plane, so these are: a normal force N > 0, a friction force V with |V| <= μ N, and a centre of pressure inside the
support. Where the pushed line passes through the vertical axis of all centres of mass, or lies in the plane of symmetry
of the stack, friction that is spread like the pressure has no moment about the vertical, and the conditions suffice.
Each is linear in the size s of the push, except |V| <= μ N, of which only the direction of V is fixed: so R is the
smallest of a few quotients.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction

DIGITS = 50


@dataclass(frozen=True)
class Joint:
    """The support below a box: its height z, the rectangle it is on, and the friction coefficient."""

    z: float
    low: tuple[float, float]
    high: tuple[float, float]
    mu: float


@dataclass(frozen=True)
class Stacked:
    """A box of a stack: ``mass`` [kg], the centre of mass ``com`` [m], and the joint below it."""

    mass: float
    com: tuple[float, float, float]
    below: Joint


def largest_push(
    stack: Sequence[Stacked], pushed: int, force: Sequence[float], moment: Sequence[float], gravity: float
) -> Decimal:
    """Return the largest factor of a load on box ``pushed`` of a stack, from the lowest box to the highest.

    ``force`` [N] and ``moment`` [N m] about the box's centre of mass are the load, ``gravity`` > 0 [m/s²] points down.
    All numbers are taken as exact. The result is infinite if no factor is too large. Raises ValueError if the stack
    does not stand, or if the moment about the vertical axis is not zero, for which the closed form does not hold.
    """
    if Fraction(moment[2]) != 0:
        raise ValueError("the closed form needs a load without a moment about the vertical axis")
    with localcontext() as context:
        context.prec = DIGITS + 10
        limits = [limit for k in range(len(stack)) for limit in _limits(stack, k, pushed, force, moment, gravity)]
        return min(limits, default=Decimal("Infinity"))


def _limits(
    stack: Sequence[Stacked], k: int, pushed: int, force: Sequence[float], moment: Sequence[float], gravity: float
) -> list[Decimal]:
    """Return the factors at which joint ``k`` slides, lets go or tips about one of its four edges."""
    joint, above = stack[k].below, stack[k:]
    weight = sum((Fraction(box.mass) * Fraction(gravity) for box in above), Fraction(0))
    loaded = [Fraction(f) if k <= pushed else Fraction(0) for f in force]
    found = []
    for axis in (0, 1):
        held = sum((Fraction(box.mass) * Fraction(gravity) * Fraction(box.com[axis]) for box in above), Fraction(0))
        turning = Fraction(moment[1 - axis]) * (1 if axis == 0 else -1) if k <= pushed else Fraction(0)
        arm = [Fraction(stack[pushed].com[c]) for c in range(3)]
        lever = turning + loaded[axis] * (arm[2] - Fraction(joint.z)) - loaded[2] * arm[axis]
        for edge, sign in ((joint.low[axis], -1), (joint.high[axis], 1)):
            # sign (centre of pressure - edge) <= 0 with centre = (held + s lever) / (weight - s f_z)
            room = sign * (Fraction(edge) * weight - held)
            need = sign * (lever + Fraction(edge) * loaded[2])
            found += _quotient(_decimal(room), _decimal(need))
    sliding = (_decimal(loaded[0] ** 2 + loaded[1] ** 2)).sqrt()
    grip = _decimal(Fraction(joint.mu))
    found += _quotient(grip * _decimal(weight), sliding + grip * _decimal(loaded[2]))
    return found + _quotient(_decimal(weight), _decimal(loaded[2]))


def _quotient(room: Decimal, need: Decimal) -> list[Decimal]:
    if room < 0:
        raise ValueError("the stack does not stand")
    return [room / need] if need > 0 else []


def _decimal(value: Fraction) -> Decimal:
    return Decimal(value.numerator) / Decimal(value.denominator)
