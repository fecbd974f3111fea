"""What uncertain poses take from bounds, besides contacts: tilted contacts, bodies that lean, other levers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.base.rigid import tangents
from holdfast.contacts.tolerances import SIGMAS
from holdfast.engines.answers import Answers
from holdfast.engines.contract import Accuracy
from holdfast.engines.limit.limit_state import LimitState
from holdfast.engines.limit_engine import Limit

STEEPEST = 1.5  # [rad] largest friction angle
DIRECTIONS = 8  # horizontal directions in which all bodies may lean


@dataclass(frozen=True, eq=False)
class PoseAllowance:
    """How much smaller answers may be because the poses of an assembly are off, to first order.

    A body that rests flat is seen tilted by up to ``tilt`` [rad], which is SIGMAS standard deviations, and seen nearer
    or further than it is by up to the gap of its contacts. Three things follow, all relative to the true scene:

    - Normals of contacts, and directions of pushes against them, are off by ``tilt``. A friction cone that is narrower
      by that angle lies inside the true one (``narrowed``).
    - Bodies lean: the weight of each acts off its place by ``tilt`` times its height over its contacts. If the assembly
      could lean by φ before it moves, a share 1 - tilt / φ of every answer is left, because what contacts can carry is
      a convex set.
    - A contact lies halfway between its surfaces, so the lever of a push is off by up to half the gap. The pushes are
      asked again at both ends.

    ``assembly`` is the one with the changed friction cones, ``state`` its limit analysis under the same loads, and
    ``share`` the share 1 - tilt / φ, 0 where the assembly may not stand so.
    """

    assembly: Assembly
    state: LimitState
    share: float

    @classmethod
    def of(
        cls, part: Assembly, standing: Float | None, acceleration: Float | None, *, wider: bool = False
    ) -> PoseAllowance:
        """Return the allowance of ``part``, an assembly with uncertain poses, under these loads (``Engine.prepare``).

        ``wider`` is for upper bounds: friction cones are then wider instead of narrower.
        """
        tilt = float(np.radians(SIGMAS * part.tolerances.tilt))
        changed = narrowed(part, -tilt if wider else tilt)
        state = Limit().prepare(changed, standing, acceleration)
        if tilt == 0:
            return cls(changed, state, 1.0)
        steepest = float(state.load_factor(_leans(part)).lower.min(initial=np.inf))  # φ [rad], as loads are per radian
        return cls(changed, state, max(0.0, 1 - tilt / steepest) if steepest > 0 else 0.0)

    def lowered(self, lower: Float, W: Float, accuracy: Accuracy) -> Float:
        """Return what is left of lower bounds (n,) of ``assembly`` for the load columns W (6J, n).

        The levers are judged by limit analysis: by the share by which it falls, or as it finds them where it finds no
        limit otherwise.
        """
        plain, *moved = (answers.lower for answers in self._with_levers(W, accuracy))
        least = np.minimum.reduce(moved)
        known = np.isfinite(plain) & (plain > 0)
        ratio = np.minimum(np.divide(least, plain, out=np.zeros(len(plain)), where=known), 1.0)
        left = np.where(np.isinf(plain), np.minimum(lower, least), np.where(ratio > 0, lower, 0.0) * ratio)
        return self.share * left if self.share > 0 else np.zeros(len(lower))

    def raised(self, upper: Float, W: Float, accuracy: Accuracy) -> Float:
        """Return upper bounds (n,) of ``assembly`` for the load columns W (6J, n), raised in the same way."""
        plain, *moved = (answers.upper for answers in self._with_levers(W, accuracy))
        most = np.maximum.reduce(moved)
        known = np.isfinite(most) & (plain > 0)
        ratio = np.divide(most, plain, out=np.full(len(plain), np.inf), where=known)
        if self.share == 0:
            return np.full(len(upper), np.inf)
        factor = np.maximum(ratio, 1.0) / self.share
        return np.asarray(np.multiply(upper, factor, out=np.zeros(len(upper)), where=upper > 0))

    def _with_levers(self, W: Float, accuracy: Accuracy) -> list[Answers]:
        """Return the answers to the loads W (6J, n) as they are, with longer levers, and with shorter ones."""
        # moments (6J, n) of the forces of W, if contacts lie higher by half of the gap of their bodies
        half_gap = np.zeros(len(self.assembly.movable))
        for interface, ends in zip(self.assembly.interfaces, self.assembly.ends, strict=True):
            gap = self.assembly.tolerances.between(*(self.assembly.scene.body(name) for name in interface.bodies)).gap
            for k in ends:
                if k >= 0:
                    half_gap[k] = max(half_gap[k], gap / 2)
        loads = W.reshape(-1, 6, W.shape[1])
        moments = np.zeros_like(loads)
        offsets = half_gap[:, None] * self.assembly.scene.up
        moments[:, 3:, :] = np.cross(offsets[:, None, :], loads[:, :3].transpose(0, 2, 1)).transpose(0, 2, 1)
        levers, state = moments.reshape(W.shape), self.state.fresh()
        return [state.load_factor(load, accuracy) for load in (W, W + levers, W - levers)]


def narrowed(assembly: Assembly, angle: float) -> Assembly:
    """Return the assembly with all friction angles smaller by ``angle`` [rad], which may be negative."""
    angles = np.clip(np.arctan(assembly.mu) - angle, 0.0, STEEPEST)
    return assembly.with_mu(np.tan(angles).tolist())


def _leans(assembly: Assembly) -> Float:
    """Return columns (6J, DIRECTIONS): the moments of the weights when all bodies lean by one radian, one way each."""
    up = assembly.scene.up
    first, second = tangents(up)
    turns = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    axes = np.cos(turns)[:, None] * first + np.sin(turns)[:, None] * second
    pull = assembly.mass * np.linalg.norm(assembly.scene.gravity)
    height = np.zeros(len(assembly.movable))
    for interface, ends in zip(assembly.interfaces, assembly.ends, strict=True):
        for patch in interface.patches:
            for k in ends:
                if k >= 0:
                    height[k] = max(height[k], abs(float((patch.centroid - assembly.com[k]) @ up)))
    columns = np.zeros((len(assembly.movable), 6, DIRECTIONS))
    columns[:, 3:, :] = (pull * height)[:, None, None] * axes.T
    return columns.reshape(-1, DIRECTIONS)
