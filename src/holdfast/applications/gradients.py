"""Compute how answers change with the poses of bodies, friction, masses, and the points and directions of pushes.

R is the largest s with G f + w_g + s w = 0 and f in the friction cones. With the forces f and the dual motion y of its
optimum, y·w = 1, the derivative is that of the Lagrangian with f and y held (envelope theorem):

    dR = -Σ [dF·u + F·(Δω x dp)] - Σ W·(ω x dc) - R d(w·y)

for the forces F (world axes) at nodes p with the relative velocity u and spin Δω, and the weights W at centres c.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from holdfast.applications.transport import TransportLimits
from holdfast.assembly.assembly import Assembly
from holdfast.assembly.node_motion import NodeMotion, node_motion
from holdfast.assembly.strengths import refuse_joined
from holdfast.base.archive import archived, to_dict
from holdfast.base.arrays import Bool, Float
from holdfast.base.errors import HoldfastError, HoldfastWarning, message
from holdfast.base.public import PublicValue, Summary, number
from holdfast.base.rigid import cross
from holdfast.base.values import Table
from holdfast.engines.capabilities import GRADIENTS, Gradient
from holdfast.engines.groups import prepared
from holdfast.engines.verdict import Status
from holdfast.queries.intervals import Pair
from holdfast.queries.push import LoadFactor, Robustness
from holdfast.queries.request import CERTAIN_ENGINE, checked_assembly, engine_of
from holdfast.scene.hold import refuse_holds
from holdfast.scene.scene import Scene

WHERE = "gradients"
Derived = Robustness | LoadFactor | TransportLimits


@archived
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Gradients(PublicValue):
    """The derivatives of n answers ``force`` (n,), in their unit: newtons for pushes.

    ``pose`` maps each body to (n, 6): by its translation [1/m] and its rotation [1/rad] about its origin, world axes.
    A push moves and turns with its body, loads stay in place. ``friction`` (n,) maps the two bodies of each interface
    to the derivative by its coefficient, and ``mass`` (n,) [1/kg] each movable body to that by its mass, with its
    centre of mass in place. ``point`` (n, 3) [1/m] is the derivative by the point of a push, and ``direction`` (n, 3)
    by its unit direction; zero for answers that are not about pushes. Rows whose answer is not finite are zero.
    """

    force: Float
    known: Bool
    pose: Table[str, Float]
    friction: Table[Pair, Float]
    mass: Table[str, Float]
    point: Float
    direction: Float

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        names = ("force", "known", "pose", "friction", "mass", "point", "direction")
        return {name: to_dict(getattr(self, name)) for name in names}

    def summary(self) -> Summary:
        """Summarise the derivatives of the first row."""
        rows = [[f"pose of {name}", *(number(v) for v in value[0])] for name, value in self.pose.items()]
        return Summary(f"derivatives of {len(self.force)} answers", (), ("by", *"xyz", *"abc"), rows)


def gradients(assembly: Assembly | Scene, answer: Derived) -> Gradients:
    """Compute the derivatives of every row of an answer by engine ``limit``, from one solve a row."""
    assembly = checked_assembly(assembly)
    refuse_holds(assembly.scene.holds, WHERE, "ask without holds")
    refuse_joined(assembly, WHERE, "leave out tension and cohesion")
    (question,) = answer.questions
    if question.loads is None:
        raise HoldfastError(message(WHERE, "the answer is about no load", "ask robustness, load_factor or limits"))
    found = _Rows(assembly, answer, question.loads, question.standing, question.acceleration)
    return found.all()


@dataclass(frozen=True, eq=False)
class _Rows:
    """The rows of one answer, whose loads are the columns of ``W`` (6J, n)."""

    assembly: Assembly
    answer: Derived
    W: Float
    standing: Float
    acceleration: Float | None

    def all(self) -> Gradients:
        """Return the derivatives of all rows."""
        assembly, n = self.assembly, self.W.shape[1]
        pose = {body.name: np.zeros((n, 6)) for body in assembly.bodies}
        friction = {i.bodies: np.zeros(n) for i in assembly.interfaces}
        mass = {body.name: np.zeros(n) for body in assembly.movable}
        point, direction = np.zeros((n, 3)), np.zeros((n, 3))
        force = np.array(self.answer.answers.force)
        status = self.answer.answers.status
        known = np.array([s is Status.FINITE and f > 0 for s, f in zip(status, force, strict=True)], dtype=bool)
        by_pair = {frozenset(pair): pair for pair in friction}
        for row in np.flatnonzero(known).tolist():
            one = self._solved(row)
            for name, value in self._by_pose(one, row):
                pose[name][row] += value
            for pair, slope in one.found.d_mu.items():
                friction[by_pair[frozenset(pair)]][row] = slope
            for name, slope in self._by_mass(one, row):
                mass[name][row] = slope
            if isinstance(self.answer, Robustness):
                p, e = self.answer.points[row], self.answer.directions[row]
                velocity, spin = one.at(self.answer.body, p)
                point[row] = -one.force * np.cross(e, spin)
                direction[row] = -one.force * (velocity - (velocity @ e) * e)
        tables = (Table(pose), Table(friction), Table(mass))
        return Gradients(
            force=force,
            known=known,
            pose=tables[0],
            friction=tables[1],
            mass=tables[2],
            point=point,
            direction=direction,
        )

    @cached_property
    def _groups(self) -> Any:
        return prepared(engine_of(CERTAIN_ENGINE), self.assembly, self.standing, self.acceleration)

    def _solved(self, row: int) -> _Motion:
        column = self.W[:, row]
        loaded = np.flatnonzero(column.reshape(-1, 6).any(axis=1)).tolist()
        state, rows = self._groups.together(loaded, WHERE)
        return _Motion(GRADIENTS.of(state, engine="limit", where=WHERE).gradient(column[rows], WHERE))

    def _by_pose(self, one: _Motion, row: int) -> Iterator[tuple[str, Float]]:
        """Yield derivatives (6,) by the pose of one body each, which have to be added up."""
        scene = self.assembly.scene
        for pair, about, first, second in one.by_contacts(self._moved):
            for name, slope in zip(pair, (first, second), strict=True):
                yield name, _about(slope, about, scene.body(name).pose[:3, 3])
        pull = scene.gravity - (0.0 if self.acceleration is None else self.acceleration)
        for k, body in enumerate(one.found.assembly.movable):
            spin, weight = one.found.twists[k, 3:], body.mass * pull
            if isinstance(self.answer, TransportLimits):  # the inertial forces act at the centre of mass, too
                weight = weight + one.force * self.W[6 * self.assembly.index[body.name] :, row][:3]
            slope = -np.cross(weight, spin)
            yield body.name, _moving_with(slope, body.com_world - body.pose[:3, 3])
        if isinstance(self.answer, Robustness):
            body = scene.body(self.answer.body)
            p, e = self.answer.points[row], self.answer.directions[row]
            velocity, spin = one.at(body.name, p)
            slope = _moving_with(-one.force * np.cross(e, spin), p - body.pose[:3, 3])
            slope[3:] -= one.force * np.cross(e, velocity)  # its direction turns with the body
            yield body.name, slope

    def _by_mass(self, one: _Motion, row: int) -> Iterator[tuple[str, float]]:
        pull = self.assembly.scene.gravity - (0.0 if self.acceleration is None else self.acceleration)
        for k, body in enumerate(one.found.assembly.movable):
            each = pull
            if isinstance(self.answer, TransportLimits):
                each = pull + one.force * self.W[6 * self.assembly.index[body.name] :, row][:3] / body.mass
            yield body.name, -float(one.found.twists[k, :3] @ each)

    @cached_property
    def _known_motions(self) -> dict[tuple[str, str], NodeMotion]:
        return {}

    def _moved(self, pair: tuple[str, str], points: Float, normals: Float) -> NodeMotion:
        known = self._known_motions
        if pair not in known:
            with warnings.catch_warnings(action="ignore", category=HoldfastWarning):
                known[pair] = node_motion(self.assembly, pair, points, normals)
        return known[pair]


STILL = 1e-9


@dataclass(frozen=True, eq=False)
class _Motion:
    """The dual motion of one solved load."""

    found: Gradient

    @property
    def force(self) -> float:
        return float(self.found.answers.force[0])

    def at(self, name: str, point: Float) -> tuple[Float, Float]:
        """Return velocity and spin (3,) of a body at a point (3,) [m]."""
        k = self.found.assembly.index[name]
        twist, com = self.found.twists[k], self.found.assembly.com[k]
        return twist[:3] + np.cross(twist[3:], point - com), twist[3:]

    def by_contacts(self, moved: Any) -> Iterator[tuple[tuple[str, str], Float, Float, Float]]:
        """Yield for each pair of bodies with relative motion the derivatives (6,) by the motions of both about a point."""
        nodes, forces = self.found.nodes, self.found.forces
        twists = np.vstack([self.found.twists, np.zeros((1, 6))])  # FIXED is -1
        com = np.vstack([self.found.assembly.com, np.zeros((1, 3))])
        at = [twists[k, :3] + cross(twists[k, 3:], nodes.points - com[k]) for k in (nodes.a, nodes.b)]
        u, spin = at[1] - at[0], twists[nodes.b, 3:] - twists[nodes.a, 3:]
        torque, arm = cross(forces, u), -cross(spin, forces)  # dF·u = turn·(F x u), F·(spin x dp) = dp·(F x spin)
        size = self.found.assembly.size
        acts = np.linalg.norm(forces, axis=1) * (np.linalg.norm(u, axis=1) + size * np.linalg.norm(spin, axis=1))
        pairs = [self.found.assembly.interfaces[k].bodies for k in nodes.interface.tolist()]
        every = dict.fromkeys(pairs)
        for pair in every:
            own = np.array([one == pair for one in pairs])
            if acts[own].max() <= STILL * self.force:
                continue
            motion = moved(pair, nodes.points[own], nodes.normals[own])
            q = torque[own], arm[own]
            both = [
                -(np.einsum("ni,nik->k", q[0], motion.turn[s]) + np.einsum("ni,nik->k", q[1], motion.shift[s]))
                for s in (0, 1)
            ]
            second = (both[0] + both[1]) / 2
            push = q[1].sum(axis=0)
            whole = -np.concatenate(
                [push, q[0].sum(axis=0) + cross(nodes.points[own] - motion.origin, q[1]).sum(axis=0)]
            )
            yield pair, motion.origin, whole - second, second


def _about(slope: Float, origin: Float, other: Float) -> Float:
    """Return a derivative (6,) by motions about ``origin`` (3,) as one by motions about another point (3,)."""
    return np.concatenate([slope[:3], slope[3:] + np.cross(origin - other, slope[:3])])


def _moving_with(slope: Float, arm: Float) -> Float:
    """Return the derivative (6,) by the motion of a body from that (3,) by a point at ``arm`` (3,) from its origin."""
    return np.concatenate([slope, np.cross(arm, slope)])
