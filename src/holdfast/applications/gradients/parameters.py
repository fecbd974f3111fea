"""What an answer can be derived by: poses, friction, masses and pushes, with the question that a small change asks."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.node_motion import displaced
from holdfast.base.arrays import Bool, Float
from holdfast.base.rigid import cross
from holdfast.certificates.question import Question
from holdfast.queries.intervals import Pair
from holdfast.queries.push import LoadFactor, Robustness
from holdfast.queries.request import push_columns
from holdfast.scene.body import Body

Derived = Robustness | LoadFactor | TransportLimits

PUSHES = 6  # parameters of a push: its point and its direction


@dataclass(frozen=True, eq=False)
class Parameters:
    """The P parameters of an ``answer`` to a ``question``: poses and masses of the bodies ``named``, friction, pushes.

    In this order: 6 for the pose of each body, one for the friction of each pair, one for the mass of each movable
    body, and 6 for the point and the direction of a push, if the answer is about pushes.
    """

    answer: Derived
    question: Question
    named: Collection[str]

    @property
    def assembly(self) -> Assembly:
        """The assembly of the question."""
        return self.question.assembly

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The bodies with a pose to derive by."""
        return tuple(body for body in self.assembly.bodies if body.name in self.named)

    @cached_property
    def pairs(self) -> tuple[Pair, ...]:
        """The pairs of bodies with friction to derive by."""
        every = dict.fromkeys(one.bodies for one in self.assembly.interfaces)
        return tuple(pair for pair in every if not self.named_none(pair))

    def named_none(self, names: Collection[str]) -> bool:
        """Tell whether none of the bodies is among those that are derived by."""
        return not any(name in self.named for name in names)

    @cached_property
    def movable(self) -> tuple[Body, ...]:
        """The bodies with a mass to derive by."""
        return tuple(body for body in self.bodies if not body.fixed)

    @cached_property
    def _places(self) -> dict[object, slice]:
        found: dict[object, slice] = {}
        for kind, keys, size in (("pose", self.bodies, 6), ("friction", self.pairs, 1), ("mass", self.movable, 1)):
            for key in keys:
                name = frozenset(key) if isinstance(key, tuple) else key.name
                start = max((place.stop for place in found.values()), default=0)
                found[kind, name] = slice(start, start + size)
        return found

    @cached_property
    def count(self) -> int:
        """The number P of parameters."""
        last = max((place.stop for place in self._places.values()), default=0)
        return last + (PUSHES if isinstance(self.answer, Robustness) else 0)

    def pose(self, name: str) -> slice | None:
        """The places of the pose of a body."""
        return self._places.get(("pose", name))

    def friction(self, pair: Pair) -> slice | None:
        """The place of the friction of a pair of bodies."""
        return self._places.get(("friction", frozenset(pair)))

    def mass(self, name: str) -> slice | None:
        """The place of the mass of a body."""
        return self._places.get(("mass", name))

    @property
    def of_push(self) -> slice | None:
        """The places of the point and the direction of the push."""
        return slice(self.count - PUSHES, self.count) if isinstance(self.answer, Robustness) else None

    def add_pose(self, total: Float, name: str, slope: Float) -> None:
        """Add a derivative (6,) by the pose of a body."""
        at = self.pose(name)
        if at is not None:
            total[at] += slope

    def add_push(self, total: Float, by_point: Float, by_way: Float) -> None:
        """Add the derivatives (3,) by the point and the direction of the push."""
        total[self.of_push] += np.concatenate([by_point, by_way])

    def origin(self, name: str) -> Float:
        """The origin (3,) [m] of a body, about which it turns."""
        return np.asarray(self.assembly.scene.body(name).pose[:3, 3])

    @cached_property
    def pull(self) -> Float:
        """What each kilogram at rest is pulled with (3,) [m/s²]."""
        carried = self.question.acceleration
        return np.asarray(self.assembly.scene.gravity - (0.0 if carried is None else carried))

    def inertia(self, name: str, row: int) -> Float:
        """The load (3,) [N] on the centre of mass of a body that moves with it: inertia on an accelerated carrier."""
        if not isinstance(self.answer, TransportLimits) or self.question.loads is None:
            return np.zeros(3)
        first = 6 * self.assembly.index[name]
        return np.asarray(self.question.loads[first : first + 3, row])

    def push(self, row: int) -> tuple[Body, Float, Float] | None:
        """The body, the point (3,) [m] and the unit direction (3,) of the push of a row, if it is one."""
        if not isinstance(self.answer, Robustness):
            return None
        body = self.assembly.scene.body(self.answer.body)
        return body, self.answer.points[row], self.answer.directions[row]

    @cached_property
    def lengths(self) -> dict[str, float]:
        """The size [m] of each body or of the smallest that it touches."""
        size = {body.name: body.size for body in self.assembly.bodies}
        least = dict(size)
        for a, b in (one.bodies for one in self.assembly.interfaces):
            least[a], least[b] = min(least[a], size[b]), min(least[b], size[a])
        return least

    @cached_property
    def units(self) -> Float:
        """A usual change (P,) of each parameter: a size [m], one radian, its own value."""
        found = np.ones(self.count)
        size = {body.name: body.size for body in self.assembly.bodies}
        for body in self.bodies:
            at = self.pose(body.name)
            assert at is not None
            found[at] = [self.lengths[body.name]] * 3 + [min(1.0, self.lengths[body.name] / size[body.name])] * 3
        for pair in self.pairs:
            found[self.friction(pair)] = max(self.mu(pair), 0.1)
        for body in self.movable:
            found[self.mass(body.name)] = body.mass
        if isinstance(self.answer, Robustness):
            at = self.of_push
            found[at] = [size[self.answer.body]] * 3 + [1.0] * 3
        return found

    def mu(self, pair: Pair) -> float:
        """The coefficient of friction of a pair; the first one, if its parts have several."""
        numbers = [k for k, one in enumerate(self.assembly.interfaces) if one.bodies == pair]
        return self.assembly.mu[numbers[0]]

    def name(self, place: int) -> str:
        """What a parameter is, in words."""
        for (kind, key), at in self._places.items():  # type: ignore[misc]
            if at.start <= place < at.stop:
                if kind == "pose":
                    return f"pose of {key}, {_WAYS[place - at.start]}"
                return f"{kind} of {key if isinstance(key, str) else ' on '.join(sorted(key))}"
        return f"push, {_PUSHED[place - self.count + PUSHES]}"

    def changed(self, place: int, step: float, rows: Bool) -> tuple[Assembly, Float, Float]:
        """Return the assembly, the loads (6J, n) of some rows and the standing wrench, with one parameter changed."""
        assembly, held, W = self.assembly, self.question.standing, self.question.loads
        assert W is not None
        W = W[:, rows]
        for (kind, key), at in self._places.items():  # type: ignore[misc]
            way = place - at.start
            if not 0 <= way < at.stop - at.start:
                continue
            if kind == "friction":
                pair = next(pair for pair in self.pairs if frozenset(pair) == key)
                return assembly.with_friction({pair: max(self.mu(pair) + step, 0.0)}), W, held
            if kind == "mass":
                mass, index = assembly.scene.body(key).mass, assembly.index[key]
                if isinstance(self.answer, TransportLimits):
                    W = W.copy()
                    W[6 * index : 6 * index + 6] *= (mass + step) / mass
                return assembly.with_masses({key: mass + step}), W, held
            return self._moved(key, np.eye(6)[way] * step, rows)
        p, e = self.answer.points[rows].copy(), self.answer.directions[rows].copy()
        way = place - self.count + PUSHES
        (p if way < 3 else e)[:, way % 3] += step
        e /= np.linalg.norm(e, axis=1)[:, None]
        return assembly, push_columns(assembly, assembly.index[self.answer.body], p, e), held

    def _moved(self, name: str, twist: Float, rows: Bool) -> tuple[Assembly, Float, Float]:
        """Return the same with a body moved by ``twist`` (6,) about its origin, and pushes on it with it."""
        old, held, W = self.assembly, self.question.standing, self.question.loads[:, rows]
        pose, index = old.scene.body(name).pose, old.index[name]
        assembly = old.moved({name: displaced(pose, twist, pose[:3, 3])})
        if index == FIXED:
            return assembly, W, held
        mine, away = slice(6 * index, 6 * index + 6), old.com[index] - assembly.com[index]
        held = held.copy()
        held[mine][3:] += cross(away, held[mine][:3])  # loads stay in place
        if isinstance(self.answer, Robustness):
            if name == self.answer.body:
                motion = displaced(np.eye(4), twist, pose[:3, 3])
                points = self.answer.points[rows] @ motion[:3, :3].T + motion[:3, 3]
                return (
                    assembly,
                    push_columns(assembly, index, points, self.answer.directions[rows] @ motion[:3, :3].T),
                    held,
                )
        elif isinstance(self.answer, LoadFactor):
            W = W.copy()
            W[mine][3:] += cross(away, W[mine][:3].T).T
        return assembly, W, held


_WAYS = ("along x", "along y", "along z", "about x", "about y", "about z")
_PUSHED = (*(f"point {axis}" for axis in "xyz"), *(f"direction {axis}" for axis in "xyz"))
