"""What an answer can be derived by: poses, friction, masses and pushes, with the question that a small change asks."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.node_motion import displaced
from holdfast.base.arrays import Bool, Float
from holdfast.base.rigid import cross
from holdfast.certificates.question import Question
from holdfast.queries.push import LoadFactor, Robustness
from holdfast.queries.request import push_columns
from holdfast.scene.body import Body

Derived = Robustness | LoadFactor | TransportLimits
Kind = Literal["pose", "friction", "mass", "push"]

LEAST_FRICTION = 0.1  # coefficient whose share is a usual change where friction is less
WAYS = {
    "pose": ("along x", "along y", "along z", "about x", "about y", "about z"),
    "push": ("point x", "point y", "point z", "direction x", "direction y", "direction z"),
}


class Parameter(NamedTuple):
    """One parameter ``of`` one body or of a pair: its ``kind``, and the ``way``, 0 to 5, of a pose or a push."""

    kind: Kind
    of: frozenset[str]
    way: int = 0

    def __str__(self) -> str:
        """Return the parameter in words."""
        words = f"{self.kind} of {' on '.join(sorted(self.of))}"
        return f"{words}, {WAYS[self.kind][self.way]}" if self.kind in WAYS else words


@dataclass(frozen=True, eq=False)
class Parameters:
    """The P parameters of an ``answer`` to a ``question``, as far as they are about the bodies ``named``."""

    answer: Derived
    question: Question
    loads: Float
    named: Collection[str]

    @property
    def assembly(self) -> Assembly:
        """The assembly of the question."""
        return self.question.assembly

    @cached_property
    def every(self) -> tuple[Parameter, ...]:
        """All P: six of the pose of each body, friction of each pair, masses of movable bodies, six of a push."""
        found = [Parameter("pose", frozenset((name,)), way) for name in self._of("pose") for way in range(6)]
        found += [Parameter("friction", frozenset(pair)) for pair in self.pairs]
        found += [Parameter("mass", frozenset((name,))) for name in self._of("mass")]
        if isinstance(self.answer, Robustness):
            found += [Parameter("push", frozenset((self.answer.body,)), way) for way in range(6)]
        return tuple(found)

    def _of(self, kind: Kind) -> list[str]:
        return [b.name for b in self.assembly.bodies if b.name in self.named and not (kind == "mass" and b.fixed)]

    @cached_property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """The pairs of bodies with friction to derive by."""
        every = dict.fromkeys(one.bodies for one in self.assembly.interfaces)
        return tuple(pair for pair in every if any(name in self.named for name in pair))

    @cached_property
    def _first(self) -> dict[tuple[Kind, frozenset[str]], int]:
        return {(one.kind, one.of): place for place, one in reversed(list(enumerate(self.every)))}

    def add(self, total: Float, kind: Kind, names: Iterable[str], slope: Float | float) -> None:
        """Add the derivatives by all parameters of a kind of some bodies to ``total`` (P,), if they are derived by."""
        first = self._first.get((kind, frozenset(names)))
        if first is not None:
            total[first : first + np.size(slope)] += slope

    def add_pose(self, total: Float, name: str, slope: Float, point: Float) -> None:
        """Add a derivative (6,) by motions of a body about a ``point`` (3,) [m], as one about its origin."""
        arm = point - self.assembly.scene.body(name).pose[:3, 3]
        self.add(total, "pose", (name,), np.concatenate([slope[:3], slope[3:] + cross(arm, slope[:3])]))

    @cached_property
    def pull(self) -> Float:
        """What each kilogram at rest is pulled with (3,) [m/s²]."""
        carried = self.question.acceleration
        return np.asarray(self.assembly.scene.gravity - (0.0 if carried is None else carried))

    def inertia(self, name: str, row: int) -> Float:
        """The load (3,) [N] on the centre of mass of a body that moves with it: inertia on an accelerated carrier."""
        first = 6 * self.assembly.index[name]
        own = self.loads[first : first + 3, row]
        return own if isinstance(self.answer, TransportLimits) else np.zeros(3)

    def push(self, row: int) -> tuple[Body, Float, Float] | None:
        """The body, the point (3,) [m] and the unit direction (3,) of the push of a row, if it is one."""
        if not isinstance(self.answer, Robustness):
            return None
        return self.assembly.scene.body(self.answer.body), self.answer.points[row], self.answer.directions[row]

    @cached_property
    def units(self) -> Float:
        """A usual change (P,) of each parameter: a size [m], a turn by it [rad] up to 1, its own value."""
        return np.array([self._unit(one) for one in self.every])

    def _unit(self, one: Parameter) -> float:
        if one.kind == "friction":
            return max(self._mu(one.of), LEAST_FRICTION)
        (name,) = one.of
        body = self.assembly.scene.body(name)
        if one.kind == "mass":
            return float(body.mass or 0.0)
        size = body.size if one.kind == "push" else self._lengths[name]
        return size if one.way < 3 else size / body.size

    @cached_property
    def _lengths(self) -> dict[str, float]:
        """The size [m] of each body, or of the smallest that it touches."""
        size = {body.name: body.size for body in self.assembly.bodies}
        least = dict(size)
        for a, b in (one.bodies for one in self.assembly.interfaces):
            least[a], least[b] = min(least[a], size[b]), min(least[b], size[a])
        return least

    def _mu(self, pair: frozenset[str]) -> float:
        """The coefficient of friction of a pair; the first one, if its parts have several."""
        ends = [frozenset(one.bodies) for one in self.assembly.interfaces]
        return self.assembly.mu[ends.index(pair)]

    def changed(self, place: int, step: float, rows: Bool) -> tuple[Assembly, Float, Float]:
        """Return the assembly, the loads (6J, k) of some ``rows`` (n,) and the standing wrench after a change."""
        one, assembly = self.every[place], self.assembly
        standing, W = self.question.standing.copy(), self.loads[:, rows]
        if one.kind == "friction":
            pair = next(pair for pair in self.pairs if frozenset(pair) == one.of)
            return assembly.with_friction({pair: max(self._mu(one.of) + step, 0.0)}), W, standing
        (name,) = one.of
        index, body = assembly.index[name], assembly.scene.body(name)
        own = slice(6 * index, 6 * index + 6)
        if one.kind == "mass":
            mass = float(body.mass or 0.0)
            if isinstance(self.answer, TransportLimits):
                W[own] *= (mass + step) / mass
            return assembly.with_masses({name: mass + step}), W, standing
        twist = np.eye(6)[one.way] * step
        if one.kind == "push":
            return assembly, self._pushed(assembly, rows, np.zeros(6), body.pose[:3, 3], twist), standing
        moved = assembly.moved({name: displaced(body.pose, twist, body.pose[:3, 3])})
        if index != FIXED:
            away = assembly.com[index] - moved.com[index]
            standing[own][3:] += cross(away, standing[own][:3])  # loads stay in place
            if isinstance(self.answer, LoadFactor):
                W[own][3:] += cross(away, W[own][:3].T).T
            elif isinstance(self.answer, Robustness) and name == self.answer.body:
                W = self._pushed(moved, rows, twist, body.pose[:3, 3], np.zeros(6))
        return moved, W, standing

    def _pushed(self, assembly: Assembly, rows: Bool, twist: Float, origin: Float, shift: Float) -> Float:
        """Return the loads (6J, k) of pushes after a motion about ``origin``, and a shift of point and direction."""
        assert isinstance(self.answer, Robustness)
        motion = displaced(np.eye(4), twist, origin)
        points = self.answer.points[rows] @ motion[:3, :3].T + motion[:3, 3] + shift[:3]
        ways = self.answer.directions[rows] @ motion[:3, :3].T + shift[3:]
        ways = ways / np.linalg.norm(ways, axis=1)[:, None]
        return push_columns(assembly, assembly.index[self.answer.body], points, ways)
