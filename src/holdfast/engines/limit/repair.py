"""Dual motions brought into the dual cone, whatever the solver left over: what an upper bound is proved by.

For forces f in the cones and a motion y with relative velocities u = Gᵀy, 0 = y · (G f + w_g + s w_e) gives

    s (y·w_e) = -y·w_g - u·f <= -y·w_g    if u_n >= μ |u_t| at every node, because then u·f >= 0.

A solver's y misses that by an excess μ |u_t| - u_n > 0, which every contact force multiplies; at μ = 1e6 the last
digits of u_t are a large one. Adding the excess times a motion that opens every node (u_n > μ |u_t|) mends it, because
the dual cone is convex, and costs what that motion lifts. There is one exactly where no self-stress can clamp contacts,
so that their forces are bounded. Where some are clamped, the bodies that rest are held still and only the contacts of
the others are opened. If these are clamped too, nothing bounds what an excess may hide.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
from scipy import sparse

from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.base.arrays import Bool, Float
from holdfast.base.entries import Entries, diagonal
from holdfast.conic.solve import ConeProgram, solve
from holdfast.engines.forces import FrictionCone
from holdfast.engines.limit.balance import DOWN, EXTENDED, LEAST, UP, Balance, Equilibrium, gamma, inner
from holdfast.engines.mechanism import moving_bodies

TIGHT = 5e-7  # a bound that mending raises by a smaller share needs no better motion
FAINT = 1e-100  # of the largest component of a motion: smaller ones are zero, so that products do not underflow
LARGEST = 100  # components of a motion above which sticking takes more time than a solve
STICKING = (1e-8, 1e-5)  # speeds, relative to the speeds that they are differences of, up to which a node sticks
ROUNDS = 150  # of motions and velocities that open the nodes, each of which costs far less than a program
BEYOND = 1.9  # a node is opened by this multiple of what it lacks, which takes fewer rounds
WELL_OPEN = 0.5  # of 1 / tau, by which every node opens then
SPARES = (0.02, 0.5, 5.0)  # of the rounding of an excess, opened in addition to it, until nothing is left


@dataclass(frozen=True, eq=False)
class Opening:
    """A ``motion`` (6J,) that opens every node of some bodies; ``room`` (I,) is by how much each one proves to open.

    It is infinite at the nodes of bodies that rest.
    """

    motion: Float
    room: Float


@dataclass(frozen=True, eq=False)
class MotionRepair:
    """Upper bounds of the largest factors of loads under ``wrench`` (6J,), from motions (6J,) of a solver.

    ``tau`` (I,) [N] are the usual normal forces of the nodes, ``scale`` (6J,) units of the motion of every body.
    ``balance`` knows the corrections of forces at all nodes, if it is proved.
    """

    equilibrium: Equilibrium
    nodes: ContactNodes
    cone: FrictionCone
    wrench: Float
    tau: Float
    scale: Float
    balance: Balance | None
    openings: dict[bytes, Opening | None] = field(default_factory=dict)

    def upper(self, motions: Float, loads: Float) -> tuple[Float, Float]:
        """Return bounds (k,) of the factors of loads (6J, k), and the motions (6J, k) at unit power that prove them.

        The ``motions`` (6J, k) may be wrong; a bound is infinite where they cannot be mended.
        """
        sound = np.isfinite(motions).all(0)
        motions = _normalised(np.where(sound, motions, 0.0))
        everything = np.ones(len(self.wrench) // 6, dtype=bool)
        with np.errstate(all="ignore"):
            plain = -(self.wrench @ motions) / (motions * loads).sum(0)
            bounds, proofs = self._bounds(loads, *self._mended(motions, everything, self._usual_opening))
            for k in np.flatnonzero(sound & ~(bounds <= plain * (1 + TIGHT))):
                first = [] if self._usual_opening is None else [(motions[:, k], everything)]
                for motion, moving in chain(first, self._alternatives(motions[:, k])):
                    mended = self._mended(motion[:, None], moving)
                    bound, proof = self._bounds(loads[:, k : k + 1], *mended)
                    if bound[0] < bounds[k]:
                        bounds[k], proofs[:, k] = bound[0], proof[:, 0]
                    if bounds[k] <= plain[k] * (1 + TIGHT):
                        break
                else:
                    self._finer(motions[:, k], loads[:, k : k + 1], bounds[k : k + 1], proofs[:, k : k + 1])
        return bounds, proofs

    def _finer(self, motion: Float, load: Float, bound: Float, proof: Float) -> None:
        """Lower one ``bound`` (1,) by a motion in extended precision in which nodes that hardly move stick exactly.

        In double precision, μ times the last digit of a motion is a speed. The ``proof`` (6J, 1) stays the motion in
        double precision, at a power for which it is still valid.
        """
        if not EXTENDED or len(motion) > LARGEST:
            return
        for share in STICKING:
            fine: Any = motion.astype(np.longdouble)
            for _ in range(2):
                fine = fine - self._sliding(fine, self._stuck(motion, share))
            found: Any = self._bounds(load, *self._mended(fine[:, None], np.ones(len(motion) // 6, dtype=bool)))[0]
            lower = np.nextafter(found.astype(np.float64), np.inf)
            if lower[0] < bound[0]:
                proof *= lower / bound * DOWN
                bound[:] = lower

    def gaining(self, motion: Float) -> Float | None:
        """Return a motion (6J,), mended so that no contact force resists it, if ``wrench`` gains power along it."""
        if not np.isfinite(motion).all():
            return None
        everything = np.ones(len(self.wrench) // 6, dtype=bool)
        with np.errstate(all="ignore"):
            mended, inside = self._mended(_normalised(motion[:, None]), everything)
            power, unknown = inner(mended, self.wrench[:, None])
            return mended[:, 0] if inside[0] and power[0] > unknown[0] else None

    def opened(self, motion: Float) -> Float | None:
        """Return a motion (6J,) that opens all nodes of the bodies that ``motion`` (6J,) moves, if there is one."""
        opening = self._opening((motion.reshape(-1, 6) != 0).any(axis=1))
        return None if opening is None else opening.motion

    def _alternatives(self, motion: Float) -> Iterator[tuple[Float, Bool]]:
        """Yield motions (6J,) close to this one that may need less mending, and the bodies (J,) whose nodes are opened.

        First those in which nodes that hardly move stick; then that in which bodies that hardly move rest.
        """
        for share in STICKING if len(motion) <= LARGEST else ():
            yield motion - self._sliding(motion, self._stuck(motion, share)), np.ones(len(motion) // 6, dtype=bool)
        moving = moving_bodies(motion, self.scale)
        moving[len(self.equilibrium.com) :] = True  # fasteners
        yield np.where(np.repeat(moving, 6), motion, 0.0), moving

    def _stuck(self, motion: Float, share: float) -> Bool:
        """Return (3I,) which nodes hardly move: this ``share`` of the speeds that cancel each other there, or less."""
        u, unknown = (v.reshape(-1, 3) for v in self.equilibrium.velocities(motion[:, None]))
        return np.repeat(np.linalg.norm(u, axis=1) <= share * np.linalg.norm(unknown, axis=1) / gamma(12), 3)

    def _sliding(self, motion: Float, stuck: Bool) -> Float:
        """Return the part (6J,) of a motion, as small as can be, that moves the ``stuck`` (3I,) nodes."""
        if not stuck.any():
            return np.zeros(len(motion))
        u = self.equilibrium.velocities(motion[:, None])[0][stuck, 0]
        rows = (sparse.csr_matrix(self.equilibrium.gather)[stuck] @ sparse.diags(self.scale)).toarray()
        weight, size = np.repeat(self.tau, 3)[stuck], max(float(np.abs(u).max()), 1e-300)
        found = np.linalg.lstsq(weight[:, None] * rows, weight * (u / size).astype(np.float64), rcond=1e-11)[0]
        return np.asarray(self.scale * found * size)

    def _bounds(self, loads: Float, motions: Float, inside: Bool) -> tuple[Float, Float]:
        """Return gravity over load power of the motions, rounded up, and the motions at unit power."""
        power, unknown = inner(motions, loads)
        held, more = inner(motions, -self.wrench[:, None])
        least = power - unknown
        bounds = np.maximum(np.maximum(held + more, 0.0) / least * UP, 0.0)
        proved = (least > 0) & inside & np.isfinite(bounds)
        return np.where(proved, bounds, np.inf), np.where(proved, motions / power, 0.0)

    def _mended(self, motions: Float, moving: Bool, opening: Opening | None = None) -> tuple[Float, Bool]:
        """Return the motions with as much of an opening as they need, and which (k,) are in the dual cone for certain.

        The opening is the least one of the bodies that are ``moving`` (J,), unless another is given. The excess of the
        sum is computed anew, for rounding may leave a rest of it.
        """
        excess, unknown = self._excess(motions)
        for spare in SPARES:
            if not (excess > 0).any():
                break
            opening = opening or self._opening(moving)
            if opening is None:
                break
            needed = np.where(excess > 0, (1 + 1e-6) * excess + spare * unknown, 0.0)
            motions = motions + (needed / opening.room[:, None]).max(0) * opening.motion[:, None]
            excess, unknown = self._excess(motions)
        return motions, np.asarray((excess <= 0).all(0))

    def _excess(self, motions: Float) -> tuple[Float, Float]:
        """Return (I, k) by how much motions may leave the dual cone: the largest -u·f of forces with f_n = 1.

        Also returns how much of it is due to what rounding may have done.
        """
        u, unknown = self.equilibrium.velocities(motions)
        count, mu = len(self.nodes), self.nodes.mu[:, None]
        u, unknown = u.reshape(count, 3, -1), unknown.reshape(count, 3, -1)
        sliding = self.cone.resistance(self.nodes.mu, u[:, 1:].transpose(0, 2, 1))
        rounding = (mu * (unknown[:, 1] + unknown[:, 2]) + unknown[:, 0]) * UP
        still = (unknown <= LEAST).all(1)  # a node between bodies that rest
        return np.where(still, 0.0, sliding * UP - u[:, 0] + rounding), rounding

    def _opening(self, moving: Bool) -> Opening | None:
        """Return a motion of these bodies (J,) that opens all of their nodes, if there is one."""
        key = moving.tobytes()
        if key not in self.openings:
            self.openings[key] = self._least_opening(moving)
        return self.openings[key]

    @cached_property
    def _usual_opening(self) -> Opening | None:
        """A motion of all bodies that opens every node by about 1 / tau, if one is found without a program.

        Motions closest to velocities that open the nodes, and velocities that open closest to those of the motion, are
        taken in turn, with the momentum of accelerated gradients (Nesterov).
        """
        if self.balance is None:
            return None
        mu, velocities = self.nodes.mu, np.zeros((len(self.tau), 3))
        velocities[:, 0] = 1 / self.tau
        before, weight = velocities, 1.0
        for _ in range(ROUNDS):
            motion = self.balance.motion_for(velocities.ravel())
            u = np.asarray(self.equilibrium.gather @ motion).reshape(-1, 3)
            speed = np.hypot(u[:, 1], u[:, 2])
            lacking = 1 / self.tau - (u[:, 0] - mu * speed)
            if (lacking * self.tau).max() <= 1 - WELL_OPEN:
                opened = -self._excess(motion[:, None])[0][:, 0]
                return Opening(motion, opened) if (opened > 0).all() else None
            lacking = BEYOND * np.maximum(lacking, 0.0)
            slower = np.minimum(mu * lacking / (1 + mu * mu), speed)
            u[:, 0] += lacking - mu * slower
            u[:, 1:] *= (1 - np.divide(slower, speed, out=np.zeros(len(speed)), where=speed > 0))[:, None]
            heavier = (1 + np.sqrt(1 + 4 * weight * weight)) / 2
            velocities, before, weight = u + (weight - 1) / heavier * (u - before), u, heavier
        return None

    def _least_opening(self, moving: Bool) -> Opening | None:
        """Min the power against the weights  s.t.  every node opens by 1 / tau; the result is checked on the data."""
        moves = np.append(moving, False)  # FIXED is -1
        touched, columns = moves[self.nodes.a] | moves[self.nodes.b], np.repeat(moving, 6)
        scale = np.where(columns, self.scale, 0.0)
        weight = np.repeat(self.tau[:, None], 3, axis=1)
        weight[:, 1:] *= self.cone.corner * self.nodes.mu[:, None]
        count, rows = int(touched.sum()), np.repeat(touched, 3)
        opening = Entries.of(self.equilibrium.gather).scaled(-weight.ravel(), scale).within(rows)
        A = opening.matrix((3 * count, len(scale)))
        b = np.tile([-1.0, 0.0, 0.0], count)
        q = -scale * self.wrench
        P = diagonal(np.full(len(scale), 1e-3 * max(float(np.abs(q).max(initial=0)), 1e-300)))
        found = solve(ConeProgram(P, q, A, b, (("second_order", 3),) * count), tolerance=1e-6).x
        motion = scale * found
        if not np.isfinite(motion).all():
            return None
        opened = -self._excess(motion[:, None])[0][:, 0]
        return Opening(motion, np.where(touched, opened, np.inf)) if (opened[touched] > 0).all() else None


def _normalised(motions: Float) -> Float:
    """Return the motions (6J, k) at the size 1, without components that might underflow."""
    motions = motions / np.maximum(np.abs(motions).max(0, initial=0.0), 1e-300)
    return np.where(np.abs(motions) < FAINT, 0.0, motions)
