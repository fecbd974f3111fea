"""Loads of a family, ``columns`` @ x, asked along rays from 0: how far each is carried, and what limits it.

The load that goes farthest in a direction (``Support``) is an extreme point of the set of loads that are carried.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from holdfast.base.arrays import Float
from holdfast.base.errors import HoldfastError, SolverError, message
from holdfast.conic.solve import ConeProgram, Prepared
from holdfast.engines.limit.gauge import LoadLimit
from holdfast.engines.limit.proof import TOLERANCE, LoadProgram, Proofs
from holdfast.engines.limit.rounding import DOWN, gamma
from holdfast.engines.verdict import Status


@dataclass(frozen=True, eq=False)
class ExtremeLoad:
    """A load ``x`` (d,) of the family, and contact ``forces`` (3I,) [N] that about balance it and the wrench."""

    x: Float
    forces: Float


class Support:
    """The program max y·x  s.t.  G f + wrench + ``columns`` x = 0, f in the friction cones, |x_k| <= 1, for any y.

    ``program`` has G, the wrench and the cones; ``columns`` (6J, d) are loads.
    """

    def __init__(self, program: LoadProgram, columns: Float) -> None:
        self._program, self._columns = program, columns

    def farthest(self, direction: Float) -> ExtremeLoad | None:
        """Return the x (d,) that goes farthest along ``direction`` (d,), or None if the solver fails."""
        size, count = len(direction), self._cone_program.A.shape[1]
        q = np.zeros(count)
        q[count - size :] = -direction / np.abs(direction).max()
        self._prepared.aim(q)
        found = self._prepared.solve()
        x, forces = found.x[count - size :], self._program.scales.force * found.x[: count - size]
        return ExtremeLoad(x, forces) if np.isfinite(found.x).all() and x.any() else None

    @cached_property
    def _prepared(self) -> Prepared:
        return Prepared(self._cone_program, tolerance=TOLERANCE)

    @cached_property
    def _cone_program(self) -> ConeProgram:
        """The program of single loads, with d columns in the place of one, and the box."""
        single, motion = self._program.cone_program, self._program.scales.motion
        size, forces = self._columns.shape[1], single.A.shape[1] - 1
        loads = sparse.csc_matrix(motion[:, None] * self._columns)
        below = sparse.csc_matrix((single.A.shape[0] - len(motion), size))
        walls = sparse.vstack([sparse.eye(size), -sparse.eye(size)])
        inside = sparse.hstack([sparse.csc_matrix((2 * size, forces)), walls])
        A = sparse.vstack([sparse.hstack([single.A[:, :forces], sparse.vstack([loads, below])]), inside])
        b = np.concatenate([single.b, np.ones(2 * size)])
        none = sparse.csc_matrix((forces + size, forces + size))
        return ConeProgram(
            none, np.zeros(forces + size), sparse.csc_matrix(A), b, (*single.cones, ("nonnegative", 2 * size))
        )


SMALLEST = 1e-6  # share of the box: a set that reaches less far along an axis counts as flat
ENOUGH = 0.999  # share of a corner, up to which it has to be proved to be carried


@dataclass(frozen=True, eq=False)
class Ray:
    """What one solve says of the ray through ``direction`` (d,).

    All its points up to ``reach`` times the direction are carried; ``reach`` is 0 where the solver found no answer, and
    then ``decided`` is False. ``row`` (d,) is a half-space row·x <= 1 that holds for every x that is carried, or None.
    ``twists`` (6J,) is the motion that limits the ray, if it was solved for and has an end.
    """

    direction: Float
    reach: float
    decided: bool
    row: Float | None
    twists: Float | None = None


@dataclass(frozen=True, eq=False)
class Family:
    """The loads ``columns`` (6J, d) @ x on an assembly whose bounds are ``proofs``; ``where`` names the query."""

    where: str
    proofs: Proofs
    columns: Float

    @property
    def dimension(self) -> int:
        """The number d of coordinates."""
        return int(self.columns.shape[1])

    def along(self, directions: Sequence[Float]) -> list[Ray]:
        """Solve along these directions (d,), each with a solve of its own."""
        if not directions:
            return []
        limits = self.proofs.limits(np.column_stack([self.columns @ direction for direction in directions]))
        return [self._ray(direction, limit) for direction, limit in zip(directions, limits, strict=True)]

    def through(self, corners: Sequence[ExtremeLoad]) -> list[Ray]:
        """Return how far the rays through these corners are known to be carried, by the forces that they came with.

        That is about 1. Where the forces prove less, or nothing can be proved, a solve along the ray says more.
        """
        if not corners:
            return []
        x = np.column_stack([corner.x for corner in corners])
        proved = self.proofs.carried(np.column_stack([corner.forces for corner in corners]), self.columns @ x)
        rays = [
            Ray(corner.x, self._certain(float(lower), corner.x), decided=bool(lower > ENOUGH), row=None)
            for corner, lower in zip(corners, proved, strict=True)
        ]
        others = iter(self.along([ray.direction for ray in rays if not ray.decided]))
        return [ray if ray.decided else next(others) for ray in rays]

    def axes(self) -> list[Ray]:
        """Solve along the d positive axes and then the negative ones.

        Raises SolverError if one of them has no answer, and HoldfastError if 0 is not inside the set.
        """
        found = self.along([*np.eye(self.dimension), *-np.eye(self.dimension)])
        for ray in found:
            if not ray.decided:
                problem = f"the solver found no answer along {_shown(ray.direction)}"
                raise SolverError(message(self.where, problem, "ask for load_factor along single loads"))
            if ray.reach < SMALLEST:
                share = f"less than {SMALLEST:g} of the bound along {_shown(ray.direction)} moves it"
                remedy = "the set is flat or ends at 0; ask for load_factor along single loads, or give a smaller bound"
                raise HoldfastError(message(self.where, f"0 is not inside the set: {share}", remedy))
        return found

    def _ray(self, direction: Float, limit: LoadLimit) -> Ray:
        if limit.status is Status.UNDECIDED:
            return Ray(direction, 0.0, decided=False, row=None)
        row = None
        if limit.proof is not None:
            unknown = gamma(len(limit.proof)) * float((np.abs(self.columns.T) @ np.abs(limit.proof)).sum())
            row = self.columns.T @ limit.proof / (limit.upper + unknown)
        return Ray(direction, self._certain(limit.lower, direction), decided=True, row=row, twists=limit.twists)

    def _certain(self, lower: float, direction: Float) -> float:
        """The reach along a direction, less what rounding of the load and of the point may take from ``lower``."""
        if not lower > 0:
            return 0.0
        unknown = gamma(len(direction)) * (np.abs(self.columns) @ np.abs(direction))
        paid = np.where(unknown > 0, unknown, 0.0) @ np.where(unknown > 0, self.proofs.slope, 0.0)
        total = 1 / lower + float(paid)
        return 1 / total * DOWN if total > 0 else np.inf


def _shown(direction: Float) -> str:
    return "(" + ", ".join(f"{v + 0.0:.3g}" for v in direction) + ")"
