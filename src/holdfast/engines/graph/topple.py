"""Toppling robustness R_top (Algorithm 1): the weakest turn of any feasible cut c about any of its axes A_c.

Axes are those of Sec. V-C2 and V-C3; native/topple.hpp finds the torque a_τ_c that resists a turn about one (26).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from holdfast.base.arrays import Float, Int, frozen
from holdfast.base.progress import report
from holdfast.base.rigid import cross, rotation_about, shift_twist
from holdfast.engines.graph.cuts import InterfaceGraph
from holdfast.geometry.hull import hull_edges, outline_numbers
from holdfast.native import core

KEPT = 2000  # sets of points whose axes are kept
NO_MOMENT = 1e-5  # smallest lever arm of a load, relative to the assembly's size; poses are not known more accurately


@dataclass(frozen=True, eq=False)
class CutAxes:
    """One feasible cut c and the k axes A_c about which it can turn. An axis counts once for each sense of rotation.

    ``members`` are the numbers of its bodies. ``twists`` (k, 6) are the unit-rate rotations of the whole cut, taken at
    the assembly's centre. ``torque`` (k,) [N m] is a_τ_c, with which contacts resist each of them.
    """

    members: Int
    twists: Float
    torque: Float


@dataclass(frozen=True, eq=False)
class Toppling:
    """The toppling robustness of a contact interface graph G."""

    G: InterfaceGraph

    def robustness(self, wrenches: Float) -> tuple[Float, Int]:
        """Return R_top (n,) and the cut and axis that limit it (n, 2), for wrenches (n, J, 6) (Algorithm 1)."""
        count, assembly = len(wrenches), self.G.assembly
        R_top = np.full(count, np.inf)
        which = np.full((count, 2), -1)
        scale = np.linalg.norm(wrenches[:, :, :3], axis=2).sum(1) * assembly.size
        threshold = NO_MOMENT * (scale + np.linalg.norm(wrenches[:, :, 3:], axis=2).sum(1))
        loaded = (wrenches != 0).any((0, 2))
        central = wrenches.copy()
        central[:, :, 3:] += cross(assembly.com - self._centre, wrenches[:, :, :3])
        for number, c in enumerate(self.axes):
            members = c.members[loaded[c.members]]
            if not len(c.torque) or not len(members):
                continue
            power = c.twists @ central[:, members].sum(1).T
            factor = np.divide(c.torque[:, None], power, out=np.full(power.shape, np.inf), where=power > threshold)
            a = np.argmin(factor, axis=0)
            lowest = factor[a, np.arange(count)]
            better = lowest < R_top
            R_top[better] = lowest[better]  # (27)
            which[better, 0], which[better, 1] = number, a[better]
        return R_top, which

    @cached_property
    def axes(self) -> list[CutAxes]:
        """The axes A_c of every feasible cut."""
        cuts, found = self.G.cuts, []
        for number, c in enumerate(cuts):
            found.append(self.axes_of(c))
            if number % 50 == 0:
                report("toppling axes of all cuts", number, len(cuts))
        report("toppling axes of all cuts", len(cuts), len(cuts))
        return found

    def axes_of(self, c: int) -> CutAxes:
        """Return the axes A_c of one cut, given as a bit mask."""
        assembly, nodes = self.G.assembly, self.G.nodes
        inside, (tails, heads) = self.G.members(c), self.G.ends
        severed = np.flatnonzero(inside[tails] != inside[heads])
        spans = nodes.spans
        cut = np.concatenate([np.arange(spans[i], spans[i + 1]) for i in severed])
        # axes run along the edges of polygons, not between nodes
        corners = np.vstack([patch.hull for i in severed for patch in self.G.assembly.interfaces[i].patches])
        size = float(np.linalg.norm(np.ptp(corners, axis=0)))
        origins, axes = toppling_axes(corners, size)
        flat = np.zeros(len(axes), dtype=bool)
        points, forces = nodes.points[cut], self.G.forces[cut]
        if all_parallel(nodes.normals[cut], assembly.tolerances.angle):
            centre, axis = friction_axis(points, nodes.normals[cut], nodes.mu[cut], forces[:, 0])
            origins, axes, flat = np.vstack([origins, centre]), np.vstack([axes, axis]), np.append(flat, True)
        moving_is_a = inside[tails][nodes.interface[cut]]
        torque = core.axis_torques(
            origins, axes, flat, points, np.ascontiguousarray(nodes.axes[cut]), forces, nodes.mu[cut], moving_is_a, size
        )
        free = np.flatnonzero(np.isfinite(torque))  # nodes that all lie on the axis neither slide nor open, nor resist
        senses = np.where(free % 2 == 0, 1.0, -1.0)[:, None] * axes[free // 2]
        twists = rotation_about(senses, origins[free // 2], self._centre)
        return CutAxes(np.flatnonzero(inside[:-1]), twists, torque[free])

    def twists(self, number: int, axis: int) -> Float:
        """Return the twists (J, 6) with which the cut of this number turns about one of its axes."""
        com, c = self.G.assembly.com, self.axes[number]
        twists = np.zeros((len(com), 6))
        for body in c.members:
            twists[body] = shift_twist(c.twists[axis], self._centre, com[body])
        return twists

    @cached_property
    def _centre(self) -> Float:
        """The reference point (3,) [m] of the twists of all cuts, in the world frame."""
        com = self.G.assembly.com
        return np.asarray(com.mean(0)) if len(com) else np.zeros(3)


def toppling_axes(points: Float, size: float) -> tuple[Float, Float]:
    """Return origins (m, 3) and unit directions (m, 3) of the edges of the convex hull of contact ``points`` (n, 3).

    Facets in one plane count as one facet, and edges on one line as one edge. Points in one plane give the edges of a
    polygon, and points on one line give that line. A single point gives three orthogonal lines, because every rotation
    about it is a sum of rotations about these. Points are in [m], and ``size`` [m] is that of the assembly. The axes of
    the last KEPT sets of points are kept: most cuts of an edited assembly are as they were.
    """
    return _cached_axes(np.ascontiguousarray(points, dtype=np.float64).tobytes(), size)


@lru_cache(maxsize=KEPT)
def _cached_axes(coordinates: bytes, size: float) -> tuple[Float, Float]:
    """Return what ``toppling_axes`` does, of points given as the bytes of ``coordinates``: arrays have no hash."""
    points = np.frombuffer(coordinates).reshape(-1, 3)
    tolerance = core.ON_AXIS * size
    centred = points - points.mean(0)
    _, extents, directions = np.linalg.svd(centred, full_matrices=False)
    spread = extents / np.sqrt(len(points))  # along the directions in which the points reach farthest, next, and least
    if spread[0] <= tolerance:
        return frozen(np.repeat(points[:1], 3, axis=0)), frozen(np.eye(3))
    if len(spread) < 2 or spread[1] <= tolerance:
        return frozen(points[:1]), frozen(directions[:1])
    if len(spread) < 3 or spread[2] <= tolerance:
        corners = outline_numbers(centred @ directions[:2].T)
        segments = np.column_stack([corners, np.roll(corners, -1)])
    else:
        segments = hull_edges(centred, core.SLIDING)
    start = points[segments[:, 0]]
    direction = points[segments[:, 1]] - start
    length = np.linalg.norm(direction, axis=1)
    keep = length > tolerance
    start, direction = start[keep], direction[keep] / length[keep, None]
    new = np.empty(len(start), dtype=bool)  # each line once
    core.first_of_line(start, direction, tolerance, new)
    return frozen(start[new]), frozen(direction[new])


def friction_axis(points: Float, normals: Float, mu: Float, normal_force: Float) -> tuple[Float, Float]:
    """Return origin (1, 3) and direction (1, 3) of the axis about which a cut with parallel normals twists.

    The axis is normal to the contacts and goes through Mason's centre of friction Σ μ f_n p / Σ μ f_n, or through the
    centroid of the ``points`` (n, 3) if no node presses. ``normal_force`` (n,) is f_n [N].
    """
    share = mu * np.maximum(normal_force, 0)
    if not share.sum() > 0:
        share = np.ones(len(points))
    return (share @ points / share.sum())[None], normals[:1]


def all_parallel(normals: Float, angle: float) -> bool:
    """Say whether all unit normals (n, 3) are parallel to the first, up to sign and within ``angle`` [deg]."""
    return bool(np.abs(normals @ normals[0]).min() >= np.cos(np.radians(angle)))
