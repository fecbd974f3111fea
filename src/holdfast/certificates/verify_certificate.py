"""Check a certificate of holdfast in exact arithmetic, by Python alone: python3 verify_certificate.py FILE.

A certificate lists rigid bodies with their masses, the points at which they touch, with normals and friction, and
standing loads. It then proves claims about them, by contact forces or by a motion. Every number in it is exact: an
integer, a decimal such as "0.1" or "2.5e-3", or a quotient such as "1/3". Nothing is rounded, no check has a tolerance.

A contact force f on the second body lies in the friction cone about the normal n, of any length, into that body if
f.n >= 0 and |f|^2 |n|^2 <= (1 + mu^2) (f.n)^2. No such force brakes a velocity u of the second body's point relative to
the first one's if u.n >= 0 and (1 + mu^2) (u.n)^2 >= mu^2 |u|^2 |n|^2: then u.f >= 0.

"stands"  The forces "rest", in their cones, balance weight, standing loads and "resting holds": wrenches on bodies that
          are only balanced, as a ball is, of at most 1e-9 of the body's weight. Larger ones are refused.
"holds"   So they do, and "forces", in their cones, balance these and factor times the load. Cones are convex, so a
          mixture of both sets balances every factor in between. If the factor is "unlimited", "forces" balance the
          load alone, and any multiple of them can be added to "rest".
"moves"   Along the motion, no contact force in a cone can brake (u.f >= 0), the load has power P > 0, and everything
          else the power -Q. In equilibrium all powers add up to 0, so a factor above Q / P leaves none.
"falls"   Along the motion, no contact force can brake, and weight and standing loads have power > 0: no equilibrium.

A load lists forces, "at" a point or with a torque about the centre of mass. "answered" is what was known otherwise.
A file may be a list of certificates, one for each state of a structure: each is checked by itself.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from math import hypot, isqrt, lcm
from typing import Any

FORMAT, OLDER = "holdfast-certificate/2", "holdfast-certificate/1"  # the older one has no points and no answers
NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?(e[+-]?[0-3]?[0-9]{1,2})?|-?[0-9]+/[1-9][0-9]*")
UNCHECKED = "not checked: that bodies, contacts, masses, friction and loads are all there are, and as they really are"
LISTS = ("fixed", "bodies", "standing", "contacts", "rest", "resting holds", "proofs")
MOST, DIGITS, PASSED = 20_000_000, 1_000, 100_000_000  # largest file, number, and points times motions, in bits
FAINT = 10**9  # a hold is at most its body's weight over this, at most as far from the centre as a contact
NAMED = 4  # bodies in a sentence
Vector = tuple[Fraction, ...]
Wrenches = dict[str, Vector]
ZERO: Vector = (Fraction(0),) * 3


class RefusedError(Exception):
    """Says why a certificate proves nothing."""


def number(text: Any) -> Fraction:
    if type(text) is int:
        return Fraction(text)
    if isinstance(text, str) and NUMBER.fullmatch(text):
        above, _, below = text.partition("/")
        return Fraction(int(above), int(below)) if below else Fraction(Decimal(above))
    raise RefusedError(f"{str(text)[:40]!r} is not an exact number")


def vector(values: Any) -> Vector:
    if not isinstance(values, list) or len(values) != 3:
        raise RefusedError(f"{str(values)[:40]!r} is not a list of three numbers")
    return tuple(map(number, values))


def table(value: Any, *keys: str, also: str = "") -> list[Any]:
    """The values of a JSON object with exactly these keys: one that is unknown might change what the file means."""
    if not isinstance(value, dict) or set(value) - {also} != set(keys):
        raise RefusedError(f"needs exactly the entries {', '.join(keys)}; got {str(value)[:80]!r}")
    return [value[key] for key in keys]


def common(values: Iterable[Fraction], unit: int = 1) -> int:
    """The common denominator of some numbers."""
    for value in values:
        unit = lcm(unit, value.denominator)
        if unit.bit_length() > 3.33 * DIGITS:
            raise RefusedError(f"the common denominator of some numbers has more than {DIGITS:,} digits")
    return unit


def whole(values: Iterable[Fraction], unit: int) -> Any:
    """Numbers times their common denominator: whole numbers are added faster, and keep the signs of all products."""
    return tuple(value.numerator * (unit // value.denominator) for value in values)


def dot(a: Vector, b: Vector) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def plus(a: Vector, b: Vector, factor: Fraction | int = 1) -> Vector:
    return tuple(x + factor * y for x, y in zip(a, b, strict=True))


def in_cone(force: Vector, normal: Vector, mu: Fraction) -> bool:
    along, p, q = dot(force, normal), mu.numerator, mu.denominator
    return along >= 0 and q * q * dot(force, force) * dot(normal, normal) <= (q * q + p * p) * along * along


def unbraked(u: Vector, normal: Vector, mu: Fraction) -> bool:
    along, p, q = dot(u, normal), mu.numerator, mu.denominator
    return along >= 0 and (q * q + p * p) * along * along >= p * p * dot(u, u) * dot(normal, normal)


class ExactCertificate:
    """The contents of a file: bodies, contact points, and what acts on the bodies."""

    def __init__(self, data: Any) -> None:
        form, units, gravity, acceleration, *lists = table(data, "format", "units", "gravity", "acceleration", *LISTS)
        if form not in (FORMAT, OLDER) or units != "m, kg, s, N, N m":
            raise RefusedError(f"format {form!r} in {units!r} is not {FORMAT!r} in 'm, kg, s, N, N m'")
        if not all(isinstance(part, list) for part in lists) or not lists[1]:
            raise RefusedError(f"{', '.join(LISTS)} are lists, and there are bodies")
        fixed, bodies, standing, contacts, self.rest, holds, self.proofs = lists
        self.older, self.rests, self.passed, fixed = form == OLDER, False, 0, set(fixed)
        self.accelerated = ", acceleration" if any(vector(acceleration)) else ""
        self.centres, self.weights = dict[str, Vector](), Wrenches()
        pull = plus(vector(gravity), vector(acceleration), -1)
        for name, mass, centre in (table(body, "name", "mass", "centre") for body in bodies):
            if not isinstance(name, str) or not name.isprintable() or len(name) > DIGITS:
                raise RefusedError(f"{str(name)[:40]!r} is no name of a body")
            if name in self.centres or name in fixed or number(mass) <= 0:
                raise RefusedError(f"body {name!r} is there twice, or its mass is not positive")
            self.centres[name] = vector(centre)
            self.weights[name] = tuple(number(mass) * g for g in pull) + ZERO
        self.loaded, self.loads = self.wrenches(standing), dict[frozenset[tuple[str, Vector]], int]()
        self.standing = {name: plus(weight, self.loaded.get(name, 2 * ZERO)) for name, weight in self.weights.items()}
        # First and second body, levers on those that can move in parts of self.unit, normal, friction
        self.points: list[tuple[str, str, dict[str, Vector], Vector, Fraction]] = []
        self.unit, self.near = 1, {name: list[int]() for name in self.centres}
        for (first, second), mu, points in (table(c, "between", "mu", "points") for c in contacts):
            if first == second or any(name not in self.centres and name not in fixed for name in (first, second)):
                raise RefusedError(f"there is no contact between {first!r} and {second!r}")
            for at, normal in (map(vector, table(point, "at", "normal")) for point in points):
                if number(mu) < 0 or not any(normal):
                    raise RefusedError(f"friction between {first!r} and {second!r} is negative, or a normal is zero")
                levers = {name: plus(at, self.centres[name], -1) for name in (first, second) if name in self.centres}
                for name, lever in levers.items():
                    self.near[name].append(len(self.points))
                    self.unit = common(lever, self.unit)
                self.points.append((first, second, levers, whole(normal, common(normal)), number(mu)))
        for _, _, levers, _, _ in self.points:
            levers.update({name: whole(lever, self.unit) for name, lever in levers.items()})
        self.holds = self.faint(holds)

    def wrenches(self, entries: Any, at: dict[str, Vector] | None = None) -> Wrenches:
        """Return force and torque about the centre of mass (6 numbers) of each body, and ``at`` which points."""
        found = Wrenches()
        for entry in entries:
            there = at is not None and "at" in entry
            name, force, more = table(entry, "body", "force", "at" if there else "torque")
            if name in found or name not in self.centres:
                raise RefusedError(f"{name!r} is there twice, or not at all")
            force, more = vector(force), vector(more)
            if at is not None and there:
                at[name], more = more, cross(plus(more, self.centres[name], -1), force)
            found[name] = force + more
        return {name: wrench for name, wrench in found.items() if any(wrench)}

    def faint(self, entries: Any) -> Wrenches:
        """Return what bodies are held with; refuse more than what rounding leaves on one that is only balanced."""
        holds = self.wrenches(entries)
        for name, hold in holds.items():
            levers = [self.points[k][2][name] for k in self.near[name]]
            reach = Fraction(max((dot(lever, lever) for lever in levers), default=0), self.unit**2)
            most = dot(self.weights[name], self.weights[name]) / FAINT**2
            if dot(hold[:3], hold[:3]) > most or dot(hold[3:], hold[3:]) > most * reach:
                raise RefusedError(f"{name!r} is held with more than 1/{FAINT:,} of its weight")
        return holds

    def load(self, entries: Any, at: dict[str, Vector]) -> tuple[int, Wrenches]:
        """Return the number of a load, counted from 1 in the order in which loads come first, and its wrenches."""
        load = self.wrenches(entries, at)
        if not load:
            raise RefusedError("a load is zero")
        return self.loads.setdefault(frozenset(load.items()), len(self.loads) + 1), load

    def balance(self, forces: Any, *parts: tuple[Wrenches, Fraction | int]) -> None:
        """Refuse forces that leave their cones or do not balance the sum of all parts: (wrenches, factor)."""
        if not isinstance(forces, list) or len(forces) != len(self.points):
            raise RefusedError(f"needs {len(self.points)} forces, one for each point")
        left = dict.fromkeys(
            self.centres, ((0,) * 6, 1)
        )  # whole numbers over a denominator; torques over self.unit, too

        def add(name: str, wrench: Any, unit: int) -> None:
            before, old = left[name]
            new = old if old % unit == 0 else common([Fraction(1, unit)], old)
            left[name] = tuple((new // old) * x + (new // unit) * y for x, y in zip(before, wrench, strict=True)), new

        for wrenches, factor in parts:
            for name, wrench in wrenches.items():
                values = [factor * x for x in (*wrench[:3], *(self.unit * x for x in wrench[3:]))]
                add(name, whole(values, common(values)), common(values))
        for (first, second, levers, normal, mu), force in zip(self.points, map(vector, forces), strict=True):
            unit = common(force)
            force = whole(force, unit)
            if not in_cone(force, normal, mu):
                raise RefusedError(f"a force between {first!r} and {second!r} is not in its friction cone")
            for name, lever in levers.items():
                acting = force if name == second else tuple(-x for x in force)
                add(name, (*acting, *cross(lever, acting)), unit)
        if any(any(wrench) for wrench, _ in left.values()):
            raise RefusedError(f"the forces on {next(n for n, (w, _) in left.items() if any(w))!r} do not balance")

    def powers(self, motion: Any, *loads: Wrenches) -> list[Fraction]:
        """Return the power of each of the loads; refuse a motion that a contact force can brake."""
        twists = Wrenches()
        for name, velocity, turn in (table(entry, "body", "velocity", "turn") for entry in motion):
            if name in twists or name not in self.centres:
                raise RefusedError(f"{name!r} moves twice, or is not there")
            twists[name] = vector(velocity) + vector(turn)
        unit = common(x for twist in twists.values() for x in twist)
        twists = {name: whole(twist, unit) for name, twist in twists.items()}
        passed = {k for name in twists for k in self.near[name]}
        self.passed += len(passed) * (self.unit.bit_length() + unit.bit_length())
        if self.passed > PASSED:
            raise RefusedError("motions pass too many points of contact with too long numbers: certify fewer rows")
        for first, second, levers, normal, mu in (self.points[k] for k in passed):
            u: Any = (0, 0, 0)
            for name in levers.keys() & twists.keys():
                way = plus(cross(twists[name][3:], levers[name]), twists[name][:3], self.unit)
                u = plus(u, way, 1 if name == second else -1)
            if not unbraked(u, normal, mu):
                raise RefusedError(f"a contact force between {first!r} and {second!r} can brake the motion")
        powers = [[x * y for n, t in twists.items() for x, y in zip(w.get(n, ZERO * 2), t, strict=True)] for w in loads]
        return [Fraction(sum(whole(power, common(power))), common(power)) for power in powers]

    def proved(self, proof: Any) -> tuple[str, str]:
        """Check one proof, and return the claim that it makes good, in words, and what that is in newtons."""
        kind, at = proof.get("kind") if isinstance(proof, dict) else None, dict[str, Vector]()
        what = f"contact forces balance every body under weight{self.accelerated} and standing loads"
        if kind in ("stands", "holds") and not self.rests:
            self.balance(self.rest, (self.standing, 1), (self.holds, 1))
            self.rests = True
        if kind == "stands":
            table(proof, "kind", "claim", also="answered")
            more = f"; also under {described(self.loaded, at)}" if self.loaded else ""
            return held(self.holds) + what, f": {listed(self.centres)}{more}{beyond(proof, None)}"
        if kind == "holds":
            keys = ("kind", "claim", "load", "factor", "forces", "holds")
            _, _, load, factor, forces, holds = table(proof, *keys, also="answered")
            (which, load), holds = self.load(load, at), self.faint(holds)
            if factor == "unlimited":
                self.balance(forces, (load, 1))
                claim = f"{held(self.holds)}{what} with every multiple of load {which} from 0 on"
                return claim, f"; that is any multiple of {described(load, at)}{beyond(proof, None)}"
            if number(factor) <= 0:
                raise RefusedError("the factor is not positive")
            self.balance(forces, (self.standing, 1), (load, number(factor)), (holds, 1))
            claim = f"{held(self.holds, holds)}{what} with every multiple of load {which} from 0 to {factor}"
            return claim, f"; that is up to {described(load, at, number(factor))}{beyond(proof, number(factor))}"
        if kind == "moves":
            _, _, load, factor, motion = table(proof, "kind", "claim", "load", "factor", "motion")
            which, load = self.load(load, at)
            standing, power = self.powers(motion, self.standing, load)
            if power <= 0 or number(factor) < 0 or -standing > number(factor) * power:
                raise RefusedError("the motion does not prove this factor")
            more = f"; that is above {described(load, at, number(factor), up=True)}, by a motion of {moving(motion)}"
            return f"no {what} with any multiple of load {which} above {factor}", more
        if kind == "falls":
            _, _, motion = table(proof, "kind", "claim", "motion")
            if self.powers(motion, self.standing)[0] <= 0:
                raise RefusedError("weight and standing loads have no power along the motion")
            return f"no {what}", f", by a motion of {moving(motion)}"
        raise RefusedError(f"a proof of kind {kind!r} is unknown")


def held(*parts: Wrenches) -> str:
    """Say which bodies are held and with how much at most, or nothing."""
    names = sorted({name for holds in parts for name in holds})
    most = 1.06 * float(max((abs(x) for holds in parts for w in holds.values() for x in w), default=0)) + 1e-300
    return f"with holds of up to {most:.1e} N, N m along each axis on {', '.join(map(repr, names))}, " if names else ""


def shown(square: Fraction, up: bool) -> str:
    """The root of a number with some 8 digits, rounded up or down."""
    shift = 8 - int((square.numerator.bit_length() - square.denominator.bit_length()) * 0.15)
    large = square * Fraction(100) ** shift
    root = isqrt(large.numerator // large.denominator)
    value = Decimal(root + (up and root * root < large)).scaleb(-shift).normalize()
    return f"{value:f}" if abs(value.adjusted()) < 9 else str(value)


def triple(values: Iterable[Any]) -> str:
    return f"({', '.join(f'{float(value) + 0.0:.6g}' for value in values)})"


def along(values: Vector) -> str:
    parts = [float(value / max(map(abs, values))) for value in values]
    return triple(part / hypot(*parts) for part in parts)


def moving(motion: Any) -> str:
    return listed(entry["body"] for entry in motion)


def listed(names: Iterable[str]) -> str:
    every = [repr(name) for name in names]
    return ", ".join(every[:NAMED]) + (f" and {len(every) - NAMED} more" if len(every) > NAMED else "")


def described(load: Wrenches, at: dict[str, Vector], factor: Fraction = Fraction(1), up: bool = False) -> str:
    """Say what a multiple of a load is: newtons, body, point and direction of each force."""
    found = []
    for name, wrench in list(load.items())[:NAMED]:
        words = []
        for unit, part in (("N", wrench[:3]), ("N m", wrench[3:])):
            if any(part) and (unit == "N" or name not in at):
                words.append(f"{shown(factor**2 * dot(part, part), up)} {unit} along {along(part)}")
        where = f"at {triple(at[name])} m" if name in at else "about its centre of mass"
        found.append(f"{' and '.join(words)} on {name!r} {where}")
    return ", ".join(found) + (f", and more on {len(load) - NAMED} others" if len(load) > NAMED else "")


def beyond(proof: dict[str, Any], factor: Fraction | None) -> str:
    """Say where what exists is more than the answer that the certificate was saved from."""
    engine, answer = table(proof["answered"], "engine", "answer") if "answered" in proof else ("", "unlimited")
    what = answer if answer in ("undecided", "unstable") else ""
    if not what and answer not in ("stable", "unlimited"):
        within = factor is not None and factor <= number(answer) * Fraction(1000001, 1000000)
        what = "" if within else f"{float(number(answer)):.6g} times the load"
    if not what:
        return ""
    return f"; the answer that this was saved from is {what}, by engine {engine!r}: what exists need not come about"


def claims_of(text: str) -> list[str]:
    """Return the claims that the certificate ``text`` proves; raise RefusedError if one of them is not proved."""
    try:
        if len(text) > MOST or re.search(f"[0-9]{{{DIGITS + 1}}}", text):
            raise RefusedError(f"longer than {MOST:,} characters, or a number of more than {DIGITS:,} digits")
        data, found = json.loads(text, object_pairs_hook=once), list[str]()
        for k, part in enumerate(data if isinstance(data, list) and data else [data], 1):
            certificate = ExactCertificate(part)
            claims = [certificate.proved(proof) for proof in certificate.proofs]
            same = [claim if certificate.older else claim + newtons for claim, newtons in claims]
            if not claims or same != [proof["claim"] for proof in certificate.proofs]:
                raise RefusedError(f"what it claims is not what it proves: {'; '.join(same) or 'nothing'}")
            which = "" if part is data else f"state {k}, {listed(certificate.centres)}: "
            found += [which + claim + newtons for claim, newtons in claims]
        return found
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError) as error:
        raise RefusedError(f"not a certificate: {type(error).__name__}: {str(error)[:100]}") from None


def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(dict(pairs)) < len(pairs):
        raise RefusedError("an entry is there twice")
    return dict(pairs)


def main(arguments: list[str]) -> int:
    try:
        (name,) = arguments
        with open(name, encoding="utf-8") as file:
            claims = claims_of(file.read())
    except (ValueError, OSError) as error:
        print(f"give one certificate that can be read: {error}", __doc__, sep="\n")
        return 2
    except RefusedError as why:
        print(f"NOT verified: {why}")
        return 1
    print(*(f"verified: {claim}" for claim in claims), UNCHECKED, sep="\n")
    return 0


if __name__ == "__main__":
    sys.stdout.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    sys.exit(main(sys.argv[1:]))
