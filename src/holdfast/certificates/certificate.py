"""Certificates: files that prove an answer to anybody, by ``verify_certificate.py`` and without holdfast.

What engine ``limit`` found is turned into exact numbers: contact forces are corrected until they balance to the last
digit (exact_forces.py), and motions opened until no contact force can brake them. A claim is written only if the
checker finds it proved by what is in the file.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.strengths import with_pull
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import HoldfastError, message
from holdfast.certificates.exact_forces import NONE, ExactContacts, Vector, exact
from holdfast.certificates.question import Answered, Question
from holdfast.certificates.verify_certificate import FORMAT, ExactCertificate, RefusedError, cross, dot, in_cone, plus
from holdfast.engines.contract import State
from holdfast.engines.doubts.doubtful_contacts import as_detected
from holdfast.engines.groups import PreparedGroup, prepared
from holdfast.engines.limit.limit_state import LimitState
from holdfast.engines.limit.proof import UNKNOWN, LoadLimit
from holdfast.engines.limit_engine import Limit
from holdfast.engines.verdict import Status, Verdict
from holdfast.scene.body import Body

UNITS = "m, kg, s, N, N m"
# Shares of a factor that are given up, in turn, until forces are in their cones
GIVEN_UP = (0.0, 1e-9, 1e-7, 1e-5, 1e-3)
OPENED = tuple(10.0**k for k in range(-16, -8))  # shares of an opening that are added to a motion, likewise
FAINT = 1e-12  # share of its weight, in N and N m, that a body which is only balanced may be held with at most
MULTIPLES = (1e6, 1e3, 1.0)  # of the weight, up to which a load is proved where it is not proved that it has no limit

Proof = dict[str, Any]
Motion = list[tuple[Vector, Vector]]  # velocity of the centre of mass and angular velocity of each body


class Balanced(NamedTuple):
    """Contact ``forces`` that balance exactly, together with the ``holds`` on bodies, by name, that need them."""

    forces: list[Vector]
    holds: dict[str, Vector]

    def mixed(self, other: Balanced, kept: Fraction | int, share: Fraction | int) -> Balanced:
        """Return ``kept`` times these forces plus ``share`` times the others."""
        forces = [plus(tuple(kept * x for x in a), b, share) for a, b in zip(self.forces, other.forces, strict=True)]
        nothing = (*NONE, *NONE)
        holds = {
            name: plus(tuple(kept * x for x in self.holds.get(name, nothing)), other.holds.get(name, nothing), share)
            for name in {**self.holds, **other.holds}
        }
        return Balanced(forces, holds)


@dataclass(frozen=True, eq=False)
class _Exact:
    """One group of bodies in exact numbers: its part of the assembly as engine ``limit`` prepared it.

    ``state`` is None for bodies that no chain of contacts connects to a fixed body. ``standing`` holds six numbers a
    body: force and torque about the centre of mass. ``rows`` are those of its bodies in loads on the whole assembly.
    """

    assembly: Assembly
    rows: Int
    state: LimitState | None
    verdict: Verdict
    standing: Sequence[Vector]

    @cached_property
    def contacts(self) -> ExactContacts:
        """The points of contact."""
        centres = [exact(centre) for centre in self.assembly.com]
        if self.state is None:
            return ExactContacts(centres, [], [], [], [], [])
        nodes = self.state.rest.nodes
        return ExactContacts(
            centres,
            nodes.a.tolist(),
            nodes.b.tolist(),
            [exact(point) for point in nodes.points],
            [exact(normal) for normal in nodes.normals],
            list(exact(nodes.mu)),
        )

    def balanced(self, forces: Float, wrenches: Sequence[Vector]) -> Balanced | None:
        """Return forces like the local ones (3I,) [N] that balance exactly and are within their cones; None if none."""
        assert self.state is not None
        world = [exact(force) for force in self.state.rest.nodes.world(forces.reshape(-1, 3))]
        found = self.contacts.balanced(world, wrenches)
        if found is None or not all(map(in_cone, found[0], self.contacts.normals, self.contacts.mu)):
            return None
        weights = (self.assembly.mass * np.linalg.norm(self.assembly.scene.gravity)).tolist()
        if any(max(map(abs, hold)) > FAINT * weights[k] for k, hold in found[1].items()):
            return None
        return Balanced(found[0], {self.assembly.movable[k].name: hold for k, hold in found[1].items()})

    @cached_property
    def rest(self) -> Balanced | None:
        """Forces that balance weight and standing loads; None if none are found."""
        resting = None if self.state is None else self.state.proofs.resting
        return None if resting is None else self.balanced(resting, self.standing)

    def held(
        self, column: Float, size: float, load: Sequence[Vector], limit: LoadLimit
    ) -> tuple[Fraction | None, Balanced] | None:
        """Return a factor of a load and forces that balance it; without a factor, forces for the load alone.

        ``load`` are the exact wrenches on the bodies, and ``column`` (6K,) is the same in floating-point numbers and
        over its ``size``, as is what the ``limit`` was found for.
        """
        if self.state is None or self.rest is None:
            return None
        if limit.status is Status.INFINITE and limit.ray is not None:
            ray = size * np.einsum("ikx,ix->ik", self.state.rest.nodes.axes, limit.ray).ravel()
            alone = self.balanced(ray, load)
            if alone is not None and not alone.holds:  # they would have to grow with the load
                return None, alone
            candidates = self._multiples(ray, size * column)
        else:
            candidates = ((forces, factor / size) for forces, factor in self._mixed(column))
        for forces, factor in candidates:
            (share,) = exact([factor])
            wrenches = [plus(standing, own, share) for standing, own in zip(self.standing, load, strict=True)]
            found = self.balanced(forces, wrenches) if factor > 0 else None
            if found is not None:
                return share, found
        return None

    def _mixed(self, column: Float) -> Iterator[tuple[Float, float]]:
        assert self.state is not None
        for forces, inside, share in self.state.proofs.mixtures(column):
            for given_up in GIVEN_UP:
                rest = share + (1 - share) * given_up
                mixed = (1 - rest) * forces.forces + rest * inside.forces
                yield mixed, (1 - rest) * forces.factor + rest * inside.factor

    def _multiples(self, ray: Float, column: Float) -> Iterator[tuple[Float, float]]:
        assert self.state is not None
        usual, resting = self.assembly.weight / float(np.abs(column).max()), self.state.proofs.resting
        if resting is not None:
            for multiple in MULTIPLES:
                yield resting + multiple * usual * ray, multiple * usual

    def moved(self, load: Sequence[Vector], limit: LoadLimit) -> tuple[Fraction, Motion] | None:
        """Return a factor of a load above which no forces balance, and the motion that proves it."""
        for twists in () if limit.proof is None else self._unbraked(limit.proof):
            power = _power(load, twists)
            if power > 0:
                return max(-_power(self.standing, twists) / power, Fraction(0)), twists
        return None

    def fall(self) -> Motion | None:
        """Return a motion along which what stands gains power and that no contact force can brake."""
        mechanism = self.verdict.mechanism
        if mechanism is None:
            return None
        motion = mechanism.twists.ravel()[self.rows]
        mended = motion if self.state is None else self.state.proofs.repair.gaining(motion)
        for twists in () if mended is None else self._unbraked(mended):
            if _power(self.standing, twists) > 0:
                return twists
        return None

    def _unbraked(self, motion: Float) -> Iterator[Motion]:
        """Yield motions like this one (6K,) that no contact force can brake."""
        opening: Float | None = None
        for share in (0.0, *OPENED):
            if share and opening is None:
                opening = None if self.state is None else self.state.proofs.repair.opened(motion)
                if opening is None:
                    return
                opening = opening / np.abs(opening).max() * np.abs(motion).max()
            rows = (motion if opening is None else motion + share * opening).reshape(-1, 2, 3)
            twists = [(exact(velocity), exact(turn)) for velocity, turn in rows]
            if self.contacts.not_braking(twists):
                yield twists


def _rows(column: Float) -> list[Vector]:
    return [exact(own) for own in column.reshape(-1, 6)]


def _power(wrenches: Sequence[Vector], twists: Motion) -> Fraction:
    found = (dot(w[:3], t[0]) + dot(w[3:], t[1]) for w, t in zip(wrenches, twists, strict=True))
    return sum(found, Fraction(0))


@dataclass(frozen=True, eq=False)
class Provable:
    """A question whose answer can be proved."""

    question: Question

    def data(self, where: str, rows: Sequence[int], answered: Answered | None = None) -> dict[str, Any]:
        """Return the certificate, as JSON has it, of some ``rows`` of the loads, or of rest where there are none.

        ``answered`` is what the answer says that is to be proved. Raises HoldfastError, with ``where`` in its message,
        if one of the rows cannot be proved exactly.
        """
        loads = self.question.loads
        parts = self._parts([] if loads is None else [loads[:, k] for k in rows])
        falling = [part for part in parts if part.verdict.status is Status.UNSTABLE]
        proofs: list[Proof | None]
        if falling:
            parts, motion = falling[:1], falling[0].fall()
            proofs = [None if motion is None else {"kind": "falls", "motion": self._motion(parts[0], motion)}]
        elif not parts or any(part.rest is None for part in parts):
            proofs = [None]
        else:
            said = {} if answered is None else answered.entry(answered.status.value)
            proofs = [{"kind": "stands", **said}, *(proof for k in rows for proof in self._proofs(parts, k, answered))]
        if None in proofs:
            problem = "no exact proof was found: what is known rests on rounding, or is undecided"
            raise HoldfastError(message(where, problem, "ask for other rows: row="))
        contents = {
            "format": FORMAT,
            "units": UNITS,
            "acceleration": _texts(self._accelerated),
            **self._scene(parts),
            **_shown("rest", "resting holds", [part.rest for part in parts if part.rest is not None]),
            "proofs": proofs,
        }
        try:  # the claims are those that the checker finds proved in what will be written
            data = dict(json.loads(json.dumps(contents)))
            certificate = ExactCertificate(data)
            for proof in data["proofs"]:
                proof["claim"] = "".join(certificate.proved({**proof, "claim": ""}))
            return data
        except (RefusedError, ValueError) as error:
            raise HoldfastError(message(where, f"the certificate does not check: {error}", "report it")) from error

    def _proofs(self, parts: Sequence[_Exact], row: int, answered: Answered | None) -> Iterator[Proof | None]:
        """Yield what is proved of one load: up to which factor it is held, and above which something moves."""
        assert self.question.loads is not None
        column = self.question.loads[:, row]
        loaded = [part for part in parts if column[part.rows].any()]
        if not loaded:  # a push on a fixed body
            return
        point = None if self.question.points is None else self.question.points[row]
        load, held, moved = list[dict[str, Any]](), {}, []
        for part in loaded:
            own = column[part.rows]
            wrenches = []
            for body, values in zip(part.assembly.movable, _rows(own), strict=True):
                entry, wrench = _force(body, values, point)
                wrenches.append(wrench)
                load += [entry] if any(wrench) else []
            size = float(part.assembly.load_sizes(own[:, None])[0])
            limit = UNKNOWN if part.state is None else part.state.solve(own / size)
            held[id(part)], found = part.held(own / size, size, wrenches, limit), part.moved(wrenches, limit)
            if found is not None:
                moved.append((*found, part))
        if None not in held.values():
            factor, forces = _together(parts, {key: one for key, one in held.items() if one is not None})
            shown = "unlimited" if factor is None else _text(factor)
            said = {} if answered is None else answered.entry(answered.value(row))
            yield {"kind": "holds", "load": load, "factor": shown, **_shown("forces", "holds", forces), **said}
        elif not moved:
            yield None
        if moved:
            factor, motion, part = min(moved, key=lambda one: one[0])
            above = _text(_decimal_above(factor))
            yield {"kind": "moves", "load": load, "factor": above, "motion": self._motion(part, motion)}

    def contents(self) -> dict[str, Any]:
        """Return what the certificate of all bodies lists of the scene, as JSON has it, without forces and proofs."""
        return self._scene(self._parts([]))

    def _parts(self, columns: Sequence[Float]) -> list[_Exact]:
        """Return the groups of bodies that any of the load columns (6J,) loads, or all groups without columns."""
        groups = prepared(Limit(), self.question.assembly, self.question.standing, self.question.acceleration)
        numbers = list(range(len(self.question.assembly.groups)))
        if columns:
            loaded = np.flatnonzero(np.any([column.reshape(-1, 6).any(axis=1) for column in columns], axis=0))
            numbers = sorted(set(self.question.assembly.group_of[loaded].tolist()))
        return [self._exact(groups.group(k)) for k in numbers]

    def _exact(self, group: PreparedGroup) -> _Exact:
        state: State | None = None
        if group.part is not None and group.state is not None:
            assembly, state, rows = group.part.assembly, as_detected(group.state), group.part.rows
        else:
            numbers = np.array([self.question.assembly.index[name] for name in group.names])
            assembly = self.question.assembly.without(
                {b.name for b in self.question.assembly.movable} - set(group.names)
            )
            rows = (6 * numbers[:, None] + np.arange(6)).ravel()
        pull = plus(exact(assembly.scene.gravity), self._accelerated, -1)
        standing = []
        for body, own in zip(assembly.movable, _rows(self._standing[rows]), strict=True):
            mass = _mass(body)
            standing.append(plus((*(mass * g for g in pull), *NONE), own))
        return _Exact(assembly, rows, state if isinstance(state, LimitState) else None, group.verdict, standing)

    @cached_property
    def _standing(self) -> Float:
        """What acts beside the weight (6J,): standing loads, and the pull of tension, beside which cones are plain."""
        return with_pull(self.question.assembly, self.question.standing)

    @property
    def _accelerated(self) -> Vector:
        return NONE if self.question.acceleration is None else exact(self.question.acceleration)

    def _scene(self, parts: Sequence[_Exact]) -> dict[str, Any]:
        """Return what a certificate lists of some parts of the scene; loads that are zero are left out."""
        bodies = [body for part in parts for body in part.assembly.movable]
        standing = [own for part in parts for own in _rows(self._standing[part.rows])]
        return {
            "standing": [_wrench(body.name, own) for body, own in zip(bodies, standing, strict=True) if any(own)],
            "gravity": _texts(exact(self.question.assembly.scene.gravity)),
            "fixed": [body.name for body in self.question.assembly.fixed],
            "bodies": [
                {"name": body.name, "mass": _text(_mass(body)), "centre": _texts(exact(body.com_world))}
                for body in bodies
            ],
            "contacts": [contact for part in parts for contact in _contacts(part)],
        }

    @staticmethod
    def _motion(part: _Exact, motion: Motion) -> list[dict[str, Any]]:
        return [
            {"body": body.name, "velocity": _texts(velocity), "turn": _texts(turn)}
            for body, (velocity, turn) in zip(part.assembly.movable, motion, strict=True)
            if any(velocity) or any(turn)
        ]


def _force(body: Body, values: Vector, point: Float | None) -> tuple[dict[str, Any], Vector]:
    """Return the entry of a load on one body, and its exact wrench: of a force at a point, or at the centre of mass."""
    centre, force = exact(body.com_world), values[:3]
    if any(values[3:]) and point is None:
        return _wrench(body.name, values), values
    place = centre if point is None or not any(force) else exact(point)
    wrench = (*force, *cross(plus(place, centre, -1), force))
    return {"body": body.name, "at": _texts(place), "force": _texts(force)}, wrench


def _mass(body: Body) -> Fraction:
    return exact([body.mass or 0.0])[0]


def _contacts(part: _Exact) -> Iterator[dict[str, Any]]:
    """Yield the points of contact, interface by interface, in the order of the nodes."""
    if part.state is None:
        return
    interface = part.state.rest.nodes.interface
    for number in dict.fromkeys(interface.tolist()):
        nodes = np.flatnonzero(interface == number).tolist()
        yield {
            "between": list(part.assembly.interfaces[number].bodies),
            "mu": _text(part.contacts.mu[nodes[0]]),
            "points": [
                {"at": _texts(part.contacts.points[k]), "normal": _texts(part.contacts.normals[k])} for k in nodes
            ],
        }


def _together(
    parts: Sequence[_Exact], held: Mapping[int, tuple[Fraction | None, Balanced]]
) -> tuple[Fraction | None, list[Balanced]]:
    """Return the least factor that the loaded parts hold, and forces of all parts at it.

    A part that holds more mixes in its forces at rest, one without a limit adds its forces to them. Parts that are not
    loaded need nothing for a load alone, and else rest.
    """
    least = min((factor for factor, _ in held.values() if factor is not None), default=None)
    found = []
    for part in parts:
        rest = part.rest or Balanced([], {})
        factor, own = held.get(id(part), (None, None))
        if least is None:
            found.append(own or rest.mixed(rest, 0, 0))
        elif own is None:
            found.append(rest)
        elif factor is None:
            found.append(rest.mixed(own, 1, least))
        else:
            found.append(rest.mixed(own, 1 - least / factor, least / factor))
    return least, found


def _shown(forces_key: str, holds_key: str, parts: Sequence[Balanced]) -> dict[str, Any]:
    """Return forces and holds of all parts under these two keys."""
    return {
        forces_key: [_texts(force) for part in parts for force in part.forces],
        holds_key: [_wrench(name, hold) for part in parts for name, hold in part.holds.items() if any(hold)],
    }


def _wrench(name: str, wrench: Vector) -> dict[str, Any]:
    return {"body": name, "force": _texts(wrench[:3]), "torque": _texts(wrench[3:])}


def _decimal_above(value: Fraction) -> Fraction:
    """Return the least number of some 17 digits that is not below ``value``."""
    number = float(value)
    while exact([number])[0] < value:
        number = float(np.nextafter(number, np.inf))
    return exact([number])[0]


def _text(value: Fraction) -> str:
    short = repr(float(value))
    return short if Fraction(short) == value else str(value)


def _texts(values: Vector) -> list[str]:
    return [_text(value) for value in values]
