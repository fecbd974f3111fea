"""Check a certificate of holdfast in exact arithmetic, by Python alone: python3 verify_certificate.py FILE.

A certificate lists rigid bodies with their masses, the points at which they touch, with normals and friction, and
standing loads. It then proves claims about them, by contact forces or by a motion. Every number in it is exact: an
integer, a decimal such as "0.1" or "2.5e-3", or a quotient such as "1/3". Nothing is rounded, no check has a tolerance.

A contact force f on the second body lies in the friction cone about the normal n, of any length, into that body if
f.n >= 0 and |f|^2 |n|^2 <= (1 + mu^2) (f.n)^2. No such force brakes a velocity u of the second body's point relative to
the first one's if u.n >= 0 and (1 + mu^2) (u.n)^2 >= mu^2 |u|^2 |n|^2: then u.f >= 0.

"stands"  The forces "rest", in their cones, balance weight, standing loads and "resting holds": wrenches on bodies that
          are only balanced, as a ball is. How large these are is part of what is claimed.
"holds"   So they do, and "forces", in their cones, balance these and factor times the load. Cones are convex, so a
          mixture of both sets balances every factor in between. If the factor is "unlimited", "forces" balance the
          load alone, and any multiple of them can be added to "rest".
"moves"   Along the motion, no contact force in a cone can brake (u.f >= 0), the load has power P > 0, and everything
          else the power -Q. In equilibrium all powers add up to 0, so a factor above Q / P leaves none.
"falls"   Along the motion, no contact force can brake, and weight and standing loads have power > 0: no equilibrium.

A file may be a list of certificates, one for each state of a structure: each is checked by itself.
"""

from __future__ import annotations

import json
import re
import sys
from fractions import Fraction
from typing import Any

FORMAT = "holdfast-certificate/1"
NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+)?(e[+-]?[0-3]?[0-9]{1,2})?|-?[0-9]+/[1-9][0-9]*")
UNCHECKED = "not checked: that bodies, contacts, masses, friction and loads are all there are, and as they really are"
LISTS = ("fixed", "bodies", "standing", "contacts", "rest", "resting holds", "proofs")
Vector = tuple[Fraction, ...]
Wrenches = dict[str, Vector]
ZERO: Vector = (Fraction(0),) * 3


class RefusedError(Exception):
    """Says why a certificate proves nothing."""


def number(text: Any) -> Fraction:
    if type(text) is int or (isinstance(text, str) and NUMBER.fullmatch(text)):
        return Fraction(text)
    raise RefusedError(f"{str(text)[:40]!r} is not an exact number")


def vector(values: Any) -> Vector:
    if not isinstance(values, list) or len(values) != 3:
        raise RefusedError(f"{str(values)[:40]!r} is not a list of three numbers")
    return tuple(number(value) for value in values)


def table(value: Any, *keys: str) -> list[Any]:
    """The values of a JSON object with exactly these keys: one that is unknown might change what the file means."""
    if not isinstance(value, dict) or set(value) != set(keys):
        raise RefusedError(f"needs exactly the entries {', '.join(keys)}; got {str(value)[:80]!r}")
    return [value[key] for key in keys]


def dot(a: Vector, b: Vector) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def plus(a: Vector, b: Vector, factor: Fraction | int = 1) -> Vector:
    return tuple(x + factor * y for x, y in zip(a, b, strict=True))


def in_cone(force: Vector, normal: Vector, mu: Fraction) -> bool:
    along = dot(force, normal)
    return along >= 0 and dot(force, force) * dot(normal, normal) <= (1 + mu * mu) * along * along


def unbraked(u: Vector, normal: Vector, mu: Fraction) -> bool:
    along = dot(u, normal)
    return along >= 0 and (1 + mu * mu) * along * along >= mu * mu * dot(u, u) * dot(normal, normal)


class Certificate:
    """The contents of a file: bodies, contact points, and what acts on the bodies."""

    def __init__(self, data: Any) -> None:
        form, units, gravity, acceleration, *lists = table(data, "format", "units", "gravity", "acceleration", *LISTS)
        if form != FORMAT or units != "m, kg, s, N, N m":
            raise RefusedError(f"format {form!r} in {units!r} is not {FORMAT!r} in 'm, kg, s, N, N m'")
        if not all(isinstance(part, list) for part in lists) or not lists[1]:
            raise RefusedError(f"{', '.join(LISTS)} are lists, and there are bodies")
        fixed, bodies, standing, contacts, self.rest, holds, self.proofs = lists
        self.accelerated = ", acceleration" if any(vector(acceleration)) else ""
        self.centres, weights = dict[str, Vector](), Wrenches()
        pull = plus(vector(gravity), vector(acceleration), -1)
        for name, mass, centre in (table(body, "name", "mass", "centre") for body in bodies):
            if not isinstance(name, str) or not name.isprintable():
                raise RefusedError(f"{str(name)[:40]!r} is no name of a body")
            if name in self.centres or name in fixed or number(mass) <= 0:
                raise RefusedError(f"body {name!r} is there twice, or its mass is not positive")
            self.centres[name] = vector(centre)
            weights[name] = tuple(number(mass) * g for g in pull) + ZERO
        self.standing = {name: plus(load, weights[name]) for name, load in self.wrenches(standing).items()}
        self.holds, self.rests, self.loads = self.wrenches(holds), False, list[Wrenches]()
        self.points: list[tuple[str, str, Vector, Vector, Fraction]] = []  # first body, second body, point, normal, mu
        for (first, second), mu, points in (table(c, "between", "mu", "points") for c in contacts):
            if first == second or any(name not in self.centres and name not in fixed for name in (first, second)):
                raise RefusedError(f"there is no contact between {first!r} and {second!r}")
            for at, normal in (table(point, "at", "normal") for point in points):
                if number(mu) < 0 or not any(vector(normal)):
                    raise RefusedError(f"friction between {first!r} and {second!r} is negative, or a normal is zero")
                self.points.append((first, second, vector(at), vector(normal), number(mu)))

    def wrenches(self, entries: Any) -> Wrenches:
        """Return force and torque about the centre of mass (6 numbers) of each body."""
        found = dict.fromkeys(self.centres, ZERO + ZERO)
        for name, force, torque in (table(entry, "body", "force", "torque") for entry in entries):
            if any(found[name]):
                raise RefusedError(f"{name!r} is there twice")
            found[name] = (*vector(force), *vector(torque))
        return found

    def load(self, entries: Any) -> int:
        """Return the number of a load, counted from 1 in the order in which loads come first."""
        load = self.wrenches(entries)
        if not any(map(any, load.values())):
            raise RefusedError("a load is zero")
        self.loads += [] if load in self.loads else [load]
        return self.loads.index(load) + 1

    def balance(self, forces: Any, *parts: tuple[Wrenches, Fraction | int]) -> None:
        """Refuse forces that leave their cones or do not balance the sum of all parts: (wrenches, factor)."""
        if not isinstance(forces, list) or len(forces) != len(self.points):
            raise RefusedError(f"needs {len(self.points)} forces, one for each point")
        left = dict.fromkeys(self.centres, ZERO + ZERO)
        for wrenches, factor in parts:
            left = {name: plus(left[name], wrench, factor) for name, wrench in wrenches.items()}
        for (first, second, at, normal, mu), force in zip(self.points, map(vector, forces), strict=True):
            if not in_cone(force, normal, mu):
                raise RefusedError(f"a force between {first!r} and {second!r} is not in its friction cone")
            for name, sign in ((first, -1), (second, 1)):
                if name in self.centres:
                    left[name] = plus(left[name], (*force, *cross(plus(at, self.centres[name], -1), force)), sign)
        if any(map(any, left.values())):
            raise RefusedError(f"the forces on {next(n for n, w in left.items() if any(w))!r} do not balance")

    def powers(self, motion: Any, *loads: Wrenches) -> list[Fraction]:
        """Return the power of each of the loads; refuse a motion that a contact force can brake."""
        twists = dict.fromkeys(self.centres, ZERO + ZERO)
        for name, velocity, turn in (table(entry, "body", "velocity", "turn") for entry in motion):
            twists[name] = plus(twists[name], (*vector(velocity), *vector(turn)))
        for first, second, at, normal, mu in self.points:
            u = ZERO
            for name, sign in ((first, -1), (second, 1)):
                if name in twists:
                    u = plus(u, plus(twists[name][:3], cross(twists[name][3:], plus(at, self.centres[name], -1))), sign)
            if not unbraked(u, normal, mu):
                raise RefusedError(f"a contact force between {first!r} and {second!r} can brake the motion")
        return [sum((dot(w[n][k:], t[k:]) for n, t in twists.items() for k in (0, 3)), ZERO[0]) for w in loads]

    def proved(self, proof: Any) -> str:
        """Check one proof, and return the claim that it makes good, in words."""
        kind = proof.get("kind") if isinstance(proof, dict) else None
        what = f"contact forces balance every body under weight{self.accelerated} and standing loads"
        if kind in ("stands", "holds") and not self.rests:
            self.balance(self.rest, (self.standing, 1), (self.holds, 1))
            self.rests = True
        if kind == "stands":
            table(proof, "kind", "claim")
            return held(self.holds) + what
        if kind == "holds":
            _, _, load, factor, forces, holds = table(proof, "kind", "claim", "load", "factor", "forces", "holds")
            which, load, holds = self.load(load), self.wrenches(load), self.wrenches(holds)
            if factor == "unlimited":
                self.balance(forces, (load, 1))
                return f"{held(self.holds)}{what} with every multiple of load {which} from 0 on"
            if number(factor) <= 0:
                raise RefusedError("the factor is not positive")
            self.balance(forces, (self.standing, 1), (load, number(factor)), (holds, 1))
            return f"{held(self.holds, holds)}{what} with every multiple of load {which} from 0 to {factor}"
        if kind == "moves":
            _, _, load, factor, motion = table(proof, "kind", "claim", "load", "factor", "motion")
            standing, power = self.powers(motion, self.standing, self.wrenches(load))
            if power <= 0 or number(factor) < 0 or -standing > number(factor) * power:
                raise RefusedError("the motion does not prove this factor")
            return f"no {what} with any multiple of load {self.load(load)} above {factor}"
        if kind == "falls":
            _, _, motion = table(proof, "kind", "claim", "motion")
            if self.powers(motion, self.standing)[0] <= 0:
                raise RefusedError("weight and standing loads have no power along the motion")
            return f"no {what}"
        raise RefusedError(f"a proof of kind {kind!r} is unknown")


def held(*parts: Wrenches) -> str:
    """Say which bodies are held and with how much at most, or nothing."""
    names = sorted({name for holds in parts for name, wrench in holds.items() if any(wrench)})
    most = 1.06 * float(max(abs(x) for holds in parts for wrench in holds.values() for x in wrench)) + 1e-300  # rounded
    return f"with holds of up to {most:.1e} N, N m along each axis on {', '.join(map(repr, names))}, " if names else ""


def claims_of(text: str) -> list[str]:
    """Return the claims that the certificate ``text`` proves; raise RefusedError if one of them is not proved."""
    try:
        data, found = json.loads(text, object_pairs_hook=once), list[str]()
        for k, part in enumerate(data if isinstance(data, list) and data else [data], 1):
            certificate = Certificate(part)
            claims = [certificate.proved(proof) for proof in certificate.proofs]
            if not claims or claims != [proof["claim"] for proof in certificate.proofs]:
                raise RefusedError(f"what it claims is not what it proves: {'; '.join(claims) or 'nothing'}")
            which = "" if part is data else f"state {k}, {', '.join(map(repr, certificate.centres))}: "
            found += [which + claim for claim in claims]
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
