"""Dual motions brought into the dual cone, whatever the solver left over: what an upper bound is proved by.

For forces f in the cones and a motion y with relative velocities u = Gᵀy, 0 = y · (G f + w_g + s w_e) gives

    s (y·w_e) = -y·w_g - u·f <= -y·w_g    if u_n >= μ |u_t| at every node, because then u·f >= 0.

A solver's y misses that by an excess μ |u_t| - u_n > 0, which every contact force multiplies; at μ = 1e6 the last
digits of u_t are a large one. Adding the excess times a motion that opens every node by 1 (u_n >= μ |u_t| + 1) mends
it, because the dual cone is convex, and costs what that motion lifts. There is one exactly where no self-stress can
clamp contacts, so that their forces are bounded. Where some are clamped, the bodies that rest are held still and only
the contacts of the others are opened. If these are clamped too, nothing bounds what an excess may hide.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse

from holdfast.assembly.assembly import Assembly
from holdfast.assembly.nodes import ContactNodes
from holdfast.base.arrays import Bool, Float
from holdfast.conic.program import ConeProgram
from holdfast.conic.solve import solve
from holdfast.engines.cones import FrictionCone
from holdfast.engines.mechanism import AT_REST

ROUNDING = 1e-15  # of the fastest contact: what a velocity is known to


@dataclass(frozen=True, eq=False)
class Repair:
    """Mends motions (6J,) of one assembly; ``gather`` (3I, 6J) takes them to relative velocities at the nodes."""

    assembly: Assembly
    nodes: ContactNodes
    cone: FrictionCone
    gather: sparse.csr_matrix
    openings: dict[bytes, Float | None] = field(default_factory=dict)

    def mended(self, motion: Float) -> Float | None:
        """A motion (6J,) in the dual cone close to this one; None where there is no way into it."""
        everything = np.ones(len(self.assembly.movable), dtype=bool)
        missing = self._excess(motion, self._touched(everything))
        if missing <= 0:
            return motion
        opening = self._opening(everything)
        if opening is not None:
            return motion + missing * opening
        speeds = np.abs(motion / self.assembly.equation_scale).reshape(-1, 6).max(axis=1)
        moving = np.asarray(speeds > AT_REST * speeds.max())
        opening = self._opening(moving)
        if opening is None:
            return None
        motion = np.where(np.repeat(moving, 6), motion, 0.0)
        return np.asarray(motion + max(self._excess(motion, self._touched(moving)), 0.0) * opening)

    def _touched(self, moving: Bool) -> Bool:
        """(I,) the nodes of these bodies (J,)."""
        moves = np.append(moving, False)  # FIXED is -1
        return np.asarray(moves[self.nodes.a] | moves[self.nodes.b])

    def _excess(self, motion: Float, touched: Bool) -> float:
        """By how much it leaves the dual cone at worst: the largest -u·f of forces with f_n = 1, rounding included."""
        u = (self.gather @ motion).reshape(-1, 3)
        unknown = ROUNDING * (1 + self.nodes.mu) * float(np.abs(u).max(initial=0))
        excess = self.cone.resistance(self.nodes.mu, u[:, 1:]) - u[:, 0] + unknown
        return float(excess[touched].max(initial=-np.inf))

    def _opening(self, moving: Bool) -> Float | None:
        """A motion (6J,) of these bodies that opens each of their nodes by at least 1, if there is one."""
        key = moving.tobytes()
        if key not in self.openings:
            self.openings[key] = self._least_opening(moving)
        return self.openings[key]

    def _least_opening(self, moving: Bool) -> Float | None:
        """Min |y|² in units of the equations  s.t.  (u_n - 1, μ u_t) in the second-order cone; judged on the data."""
        touched, columns = self._touched(moving), np.repeat(moving, 6)
        scale = np.where(columns, self.assembly.equation_scale, 0.0)
        weight = np.ones((len(self.nodes), 3))
        weight[:, 1:] = self.cone.corner * self.nodes.mu[:, None]
        rows = sparse.diags(weight.ravel()) @ self.gather @ sparse.diags(scale)
        A = sparse.csc_matrix(-sparse.csr_matrix(rows)[np.repeat(touched, 3)])
        count = int(touched.sum())
        b = np.tile([-1.0, 0.0, 0.0], count)
        P = sparse.csc_matrix(sparse.identity(len(scale)))
        motion = (
            scale * solve(ConeProgram(P, np.zeros(len(scale)), A, b, (("second_order", 3),) * count), tolerance=1e-6).x
        )
        opened = -self._excess(motion, touched) if np.isfinite(motion).all() else 0.0
        return np.asarray(motion / opened) if opened > 0.5 else None
