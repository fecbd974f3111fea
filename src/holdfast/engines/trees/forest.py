"""Which contacts carry what equilibrium alone decides, and the loads at which they give way.

All fixed bodies are one. A contact without which a body and all that is behind it would lose every way to them (a
bridge of the graph of contacts) carries the weights and the loads behind it, whatever is stiff or soft. If it is plane,
an even bed gives its pressure and the friction it has (native/bed.hpp, native/limit_surface.hpp). Pressure does not
depend on what slips there, so a load that grows in proportion holds until the first contact on its way gives way,
whatever happened before (Klarbring, Ciavarella, Barber, Int. J. Solids Struct. 44, 2007, for systems whose normal
reactions do not depend on slip).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from holdfast.assembly.assembly import FIXED, Assembly
from holdfast.assembly.strengths import strengths_of
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.memory import Same
from holdfast.base.rigid import cross
from holdfast.native import core
from holdfast.scene.friction import NOTHING


class Bed(NamedTuple):
    """The faces of a plane contact, in a frame in its plane.

    ``edges`` (E, 5): both ends of each edge of all faces, counter-clockwise around faces and clockwise around holes,
    and the friction coefficient of the face. ``hull`` (H, 3): rows (c, n) with c + n·x >= 0 for all x in the hull of
    the faces, n of length one. ``size`` (2,): the largest distance of a corner from the origin, [m] like all lengths,
    and the friction coefficient of all faces, 0 if they differ.
    """

    edges: Float
    hull: Float
    size: Float


class Beds(NamedTuple):
    """The beds of K plane contacts, one after another, as native/bed_of.hpp makes them of the faces.

    Bed k has ``edges[edge[k]:edge[k + 1]]``, ``hull[side[k]:side[k + 1]]``, ``size[k]``, the ``frame[k]`` and the
    ``origin[k]`` (``Bridge``), and carries the bodies ``beyond[begin[k]:begin[k + 1]]``.
    """

    edge: Int
    side: Int
    edges: Float
    hull: Float
    size: Float
    frame: Float
    origin: Float
    begin: Int
    beyond: Int

    def bed(self, number: int) -> Bed:
        """Return one of them."""
        edges = self.edges[self.edge[number] : self.edge[number + 1]]
        return Bed(edges, self.hull[self.side[number] : self.side[number + 1]], self.size[number])


TIED = 1e-7  # relative difference of θ up to which contacts give way at once: all that is beyond the first moves
SPARE = 1e-6  # share of all friction below which what is left is rounding


class Exit(NamedTuple):
    """How n loads end: ``factor``, ``lower`` and ``upper`` (n,), inf where nothing gives way, nan where not known.

    ``bridge`` (n,) is the number of the contact that gives way, -1 for none, and ``twist`` (n, 6) the motion of all
    that is behind it, about the world's origin. It ``slides`` (n,) or tips, and is ``tied`` (n,) if another contact, or
    another edge, gives way at once. A row is ``proved`` (n,) unless experience was believed between two places on its
    way, where a bed has lifted in part (native/first_exit.hpp).
    """

    factor: Float
    lower: Float
    upper: Float
    bridge: Int
    twist: Float
    slides: Bool
    tied: Bool
    proved: Bool

    def rows(self, which: Bool) -> Exit:
        """Return the rows ``which`` (n,) names."""
        at = self.bridge[which], self.twist[which], self.slides[which], self.tied[which], self.proved[which]
        return Exit(self.factor[which], self.lower[which], self.upper[which], *at)


@dataclass(frozen=True, eq=False)
class Bridge:
    """The plane contact of body ``root`` with the first of the bodies ``beyond`` (k,), which hang on nothing else.

    Its ``bed`` is in a ``frame``. The rows of ``frame`` (3, 3) are two tangents and the normal, which points into what
    is beyond; ``origin`` (3,) is the middle of the faces [m].
    """

    root: int
    beyond: Int
    interfaces: tuple[int, ...]
    origin: Float
    frame: Float
    bed: Bed

    def carried(self, com: Float, wrenches: Float) -> Float:
        """Return what the bed carries (n, 6) of ``wrenches`` (n, J, 6): N, N x, N y, the force and torque in its plane.

        It is what balances those on the bodies beyond, about its origin.
        """
        beyond = wrenches[:, self.beyond]
        force = beyond[..., :3].sum(axis=1) @ self.frame.T
        torque = (beyond[..., 3:] + cross(com[self.beyond] - self.origin, beyond[..., :3])).sum(axis=1) @ self.frame.T
        return np.ascontiguousarray(
            np.stack([-force[:, 2], torque[:, 1], -torque[:, 0], -force[:, 0], -force[:, 1], -torque[:, 2]], axis=1)
        )

    def twists(self, slides: Bool, motions: Float) -> Float:
        """Return the twists (n, 6) about the world's origin of what is beyond, as the contact gives way in n ways.

        ``motions`` (n, 3) are as ``core.first_exits`` tells them. Of a way that ``slides`` (n,), that is the motion of
        the root relative to what is beyond: two velocities along the tangents, and the rate of turning about the
        normal. Of one that tips, it is the number of the edge of ``bed.hull`` about which what is beyond turns, that of
        a second edge that it tips about at once, -1 if there is none, and how fast it does so, over the first.
        """
        twists = np.zeros((len(motions), 6))
        normal = self.frame[2]
        along = -motions[slides]
        twists[slides, :3], twists[slides, 3:] = along[:, :2] @ self.frame[:2], along[:, 2:] * normal
        tips = motions[~slides]
        for number, rate in ((tips[:, 0], np.ones(len(tips))), (tips[:, 1], tips[:, 2])):
            edges = self.bed.hull[number.astype(np.int64)]
            inward = edges[:, 1:] @ self.frame[:2] * np.where(number < 0, 0.0, rate)[:, None]
            turn, arm = cross(inward, normal), -edges[:, :1] * (edges[:, 1:] @ self.frame[:2])
            twists[~slides, :3] -= cross(turn, arm)  # the arm leads to the point of the edge nearest to the origin
            twists[~slides, 3:] += turn
        twists[:, :3] -= cross(twists[:, 3:], self.origin)
        return twists


@dataclass(frozen=True, eq=False)
class Forest:
    """The bridges of an ``assembly`` that is at rest under ``wrench`` (6J,) [N, N m]."""

    assembly: Assembly
    wrench: Float

    @cached_property
    def cuts(self) -> Cuts:
        """The bridges, plane or not; all fixed bodies are one."""
        ends = np.array(self.assembly.ends, dtype=np.int64).reshape(-1, 2)
        return Cuts(*core.cuts_of(len(self.assembly.movable), ends))

    @cached_property
    def _table(self) -> _PlaneBridges:
        """The plane contacts that are bridges, those nearer to the support first."""
        return _table_of(self.assembly, self.cuts)

    @cached_property
    def bridges(self) -> tuple[Bridge, ...]:
        """The plane contacts that are bridges, those nearer to the support first."""
        roots, interfaces, beds = self._table
        return tuple(
            Bridge(
                root,
                beds.beyond[beds.begin[k] : beds.begin[k + 1]],
                interfaces[k],
                beds.origin[k],
                beds.frame[k],
                beds.bed(k),
            )
            for k, root in enumerate(roots)
        )

    @cached_property
    def decided(self) -> Bool:
        """(J,) whether equilibrium alone decides which loads on a body hold: it is at rest by more than rounding.

        All contacts on its way to the support are plane bridges with the share SPARE of their friction to spare, and of
        their size between the centre of pressure and the edge of the hull.
        """
        if not len(self.cuts.root):
            return np.zeros(len(self.assembly.movable), dtype=bool)
        roots, _, beds = self._table
        carried, shares, inside = self._carried
        spare = (shares >= 0) & (shares < 1 - SPARE) & (inside > SPARE * beds.size[:, 0] * carried[:, 0])
        found = [*[False] * len(self.assembly.movable), True]  # the last one is FIXED
        for root, body, one in zip(roots, beds.beyond[beds.begin[:-1]].tolist(), spare.tolist(), strict=True):
            found[body] = found[root] and one
        return np.array(found[:FIXED], dtype=bool)

    @cached_property
    def _carried(self) -> tuple[Float, Float, Float]:
        """What each bridge (B, 6) carries at rest, the share of its friction, and how far inside (B,) its hull."""
        return core.carried_by(self._table.beds, self.assembly.com, self.wrench.reshape(-1, 6))

    @property
    def shares(self) -> Float:
        """The share (B,) of its friction that each bridge uses at rest: 2 if it tips, -1 if not found."""
        return self._carried[1]

    def left_behind(self, sliding: Bridge) -> Int:
        """Return the bodies behind a ``sliding`` bridge that stay where they are, as no friction takes them along."""
        behind = (one.beyond for one in self.bridges if not one.bed.edges[:, 4].any() and one is not sliding)
        nested = [beyond for beyond in behind if np.isin(beyond, sliding.beyond).all()]
        return np.unique(np.concatenate([np.empty(0, dtype=np.int64), *nested]))

    def exits(self, W: Float) -> Exit:
        """Return how the loads end that are the columns of W (6J, n), which load only bodies that are ``decided``."""
        count = W.shape[1]
        wrenches = np.ascontiguousarray(W.T).reshape(count, len(W) // 6, 6)
        at, low, high = np.ones((3, count))
        bridge, twist = np.full(count, -1), np.zeros((count, 6))
        slides, tied, believed = np.zeros((3, count), dtype=bool)
        for number, one in enumerate(self.bridges):
            rows = np.flatnonzero((wrenches[:, one.beyond] != 0).any(axis=(1, 2)) & ~np.isnan(at))
            if not len(rows):
                continue
            load = one.carried(self.assembly.com, wrenches[rows])
            at_rest = self._carried[0][number]
            size = np.abs(load).max(axis=1) / np.abs(at_rest).max()
            rows, load, size = (each[size > 0] for each in (rows, load, size))
            until = at[rows] * size / (at[rows] * size + (1 - at[rows]))  # in the scale of the contact
            out, kinds = core.first_exits(one.bed, at_rest, load / size[:, None], until)
            x = np.where((kinds == core.UNKNOWN)[:, None], np.nan, out[:, :3])
            x = x / (x + (1 - x) * size[:, None])  # in the scale of the load itself
            sooner = (kinds != core.NEVER) & ~(x[:, 0] >= at[rows] * (1 - TIED))  # also where it is not known
            close = (kinds != core.NEVER) & (np.abs(x[:, 0] - at[rows]) <= TIED * at[rows])
            tied[rows] = np.where(sooner, (kinds == core.TIPS) & (out[:, 4] >= 0), tied[rows]) | close
            bridge[rows[sooner]], slides[rows[sooner]] = number, kinds[sooner] == core.SLIDES
            ends = sooner & ((kinds == core.SLIDES) | (kinds == core.TIPS))
            twist[rows[ends]] = one.twists(kinds[ends] == core.SLIDES, out[ends, 3:6])
            believed[rows] |= out[:, 6] > 0
            for theta, new in zip((at, low, high), x.T, strict=True):
                theta[rows] = np.minimum(theta[rows], new)  # not known if one is not
        with np.errstate(divide="ignore"):
            factor, lower, upper = (theta / (1 - theta) for theta in (at, low, high))
        bridge = np.where(np.isfinite(factor), bridge, -1)
        return Exit(factor, lower, upper, bridge, twist, slides, tied, ~believed)

    def how_each_ends(self, found: Exit, W: Float) -> tuple[str, ...]:
        """Say in a text for each of the loads W (6J, n) which contact gives way, and what it carries just before."""
        texts = []
        for number, at, load in zip(found.bridge.tolist(), found.lower.tolist(), W.T, strict=True):
            if number < 0:
                texts.append("")
                continue
            one = self.bridges[number]
            carried = one.carried(self.assembly.com, (self.wrench + at * load).reshape(1, -1, 6))[0]
            pair = "-".join(self.assembly.interfaces[one.interfaces[0]].bodies)
            place = one.origin + carried[1:3] / carried[0] @ one.frame[:2]
            where = ", ".join(f"{x:.3g}" for x in np.where(np.abs(place) < 5e-5, 0.0, place))
            share = core.share_at_rest(one.bed, carried)
            used = f", and uses {100 * min(share, 1.0):.3g} % of its friction" if 0 <= share < 2 else ""
            texts.append(
                f"{pair} gives way: just before, it presses with {carried[0]:.4g} N, centred at ({where}){used}"
            )
        return tuple(texts)


def forest_of(assembly: Assembly, wrench: Float) -> Forest:
    """Return the bridges of an ``assembly`` under ``wrench`` (6J,) [N, N m], which are kept with it."""
    key = ("forest", Same(assembly), wrench.tobytes())
    return assembly.memory.recalled(key, len(assembly.movable), lambda: Forest(assembly, wrench))


class Cuts(NamedTuple):
    """The B bridges of the graph of contacts (native/cuts.hpp), those nearer to the support first.

    Bridge k leads from body ``root[k]`` to those ``beyond[begin[k]:begin[k + 1]]``, the first of which it touches by
    ``interfaces[since[k]:since[k + 1]]``.
    """

    root: Int
    begin: Int
    beyond: Int
    since: Int
    interfaces: Int


class _PlaneBridges(NamedTuple):
    """The ``roots`` and ``interfaces`` of bridges, and their ``beds``."""

    roots: list[int]
    interfaces: list[tuple[int, ...]]
    beds: Beds


def _table_of(assembly: Assembly, cuts: Cuts) -> _PlaneBridges:
    """Return those bridges of an assembly that are plane."""
    roots, begin, beyond, since, numbers = (each.tolist() for each in cuts)
    joins, mu, interfaces = strengths_of(assembly), assembly.mu, assembly.interfaces
    found, faces, normals = list[tuple[int, tuple[int, ...], list[int]]](), list[tuple[float, float]](), list[Float]()
    corners, rings, first = [np.empty((0, 3))], [0], [0]
    for k, root in enumerate(roots):
        own = tuple(numbers[since[k] : since[k + 1]])
        if not all(interfaces[number].certain and joins[number] == NOTHING for number in own):
            continue
        patches = [(patch, number) for number in own for patch in interfaces[number].patches]
        if any(patch.kind != "face" or patch.spots is not None for patch, _ in patches):
            continue
        for patch, number in patches:
            corners += [patch.polygon, *patch.holes]
            rings.append(len(corners) - 1)
            normals.append(patch.normal)
            faces.append((mu[number], 1.0 if assembly.ends[number][0] == root else -1.0))
        first.append(len(faces))
        found.append((root, own, beyond[begin[k] : begin[k + 1]]))
    kept, edge, side, edges, hull, size, frame, origin = core.beds_of(
        (
            np.concatenate(corners),
            np.array([*accumulate(map(len, corners))]),
            np.array(rings),
            np.array(normals).reshape(-1, 3),
            *np.array(faces).reshape(-1, 2).T.copy(),
            np.array(first),
        )
    )
    plane = [found[k] for k in kept.tolist()]
    behind = [bodies for *_, bodies in plane]
    begins = np.array([0, *accumulate(map(len, behind))])
    bodies = np.array([body for each in behind for body in each], dtype=np.int64)
    beds = Beds(edge, side, edges, hull, size, frame, origin, begins, bodies)
    return _PlaneBridges([root for root, *_ in plane], [own for _, own, _ in plane], beds)
