"""Nodes: the points that stand for a patch, with weights that integrate over it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal, get_args

import numpy as np
from scipy.spatial import cKDTree

from holdfast.base.arrays import Float, frozen
from holdfast.base.errors import HoldfastError, message
from holdfast.base.memory import Memory, Same
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.spots import Spots, nearest_spot
from holdfast.contacts.weights import corrected
from holdfast.geometry import polygon as flat

Sampling = Literal["hull", "quadrature", "corners", "paper"]

CANDIDATES = 10  # random points of which the paper takes the farthest
CELLS = 6  # a grid step, to count tributary areas by; even, so that none lies halfway between two nodes
MANY, FEW_CELLS = 2000, 2  # grids with at least MANY nodes are counted by FEW_CELLS a step: they are fine enough
EXACT = 1e-12  # share of a rectangle's sides by which a patch may miss its corners and still be all of it
CURVED = np.radians(20)  # the most by which an outline turns at a corner that tessellates a curve
NEAR = 0.3  # of a grid step from a node on the outline, within which nodes of the grid give way to it
LATTICE = 19  # candidate points along each side of a patch; odd, so that the middle is among them
LEAST = 0.02  # of the mean weight that every node of spots gets before weights are corrected
KEPT = 1000  # grids, and shares of rectangles, at most
MOST_BENT = 64  # the most spots of a bent patch that stand for its corners
MOST_SAMPLED = 10_000  # interfaces whose nodes are remembered: similar assemblies share them

_REMEMBERED = Memory(MOST_SAMPLED)


def interface_nodes(interface: Interface, count: int, sampling: Sampling, seed: int = 0) -> list[tuple[Float, Float]]:
    """For each patch its nodes (n, 3) [m] and weights (n,) [m²]; ``count`` nodes are shared out by area.

    "hull": hull corners, then farthest points; "quadrature": a grid; "corners": the hull's corners alone; "paper": at
    random, from ``seed``, each the farthest of ten candidates, all of one weight.
    """
    if not isinstance(sampling, str) or sampling not in get_args(Sampling):
        raise HoldfastError(
            message("nodes", f"sampling = {sampling!r}", f"needs one of {', '.join(get_args(Sampling))}")
        )
    if count < 4:
        raise HoldfastError(message("nodes", f"{count} nodes an interface", "needs at least 4"))
    key = Same(interface), count, sampling, seed
    return _REMEMBERED.recalled(key, 1, lambda: _sampled(interface, count, sampling, seed))


def _sampled(interface: Interface, count: int, sampling: Sampling, seed: int) -> list[tuple[Float, Float]]:
    random = np.random.default_rng(seed) if sampling == "paper" else None
    result = []
    total = sum(patch.measure for patch in interface.patches)
    for patch in interface.patches:
        share = max(4, round(count * patch.measure / total))
        if patch.spots is not None and patch.spots.bent:
            result.append(bent_sample(patch.spots, MOST_BENT if sampling == "corners" else share))
            continue
        if patch.kind != "face":
            points, weights = thin_sample(patch, share)
        elif random is not None:
            points, weights = paper_sample(patch, share, random)
        else:
            points, weights = _SAMPLES[sampling](patch, share)
        result.append((frozen(patch.lifted(points)), frozen(np.array(weights))))
    return result


def corner_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """All corners of the hull, whatever ``count``: they carry every force that the whole patch could carry."""
    return patch.corners, np.full(len(patch.corners), patch.measure / len(patch.corners))


def bent_sample(spots: Spots, count: int) -> tuple[Float, Float]:
    """The first spots of a bent patch (n, 3), which are far from each other, and what they stand for (n,) [m²].

    Their weights have the sum, the first moments and the resultant and moment of unit pressure of all spots.
    """
    if count >= len(spots.points):
        return spots.points, spots.shares
    owner = nearest_spot(spots.points, spots.normals, np.arange(count))
    tributary: Float = np.bincount(owner, spots.shares, minlength=count) * np.ones(count)
    scale = float(np.linalg.norm(np.ptp(spots.points, axis=0)))
    at = (spots.points - spots.shares @ spots.points / spots.shares.sum()) / scale
    rows = np.column_stack([np.ones(len(at)), at, spots.normals, np.cross(at, spots.normals)]).T
    weights = corrected(tributary, rows[:, :count], rows @ spots.shares, (10, 7, 4))
    return frozen(spots.points[:count].copy()), frozen(weights)


def paper_sample(patch: Patch, count: int, random: np.random.Generator) -> tuple[Float, Float]:
    """The paper's nodes (Sec. VI-A2): each the one of ten random points that is farthest from all chosen before."""
    polygon = flat.shapely_polygon(patch.rings)
    low, high = patch.rings[0].min(0), patch.rings[0].max(0)

    def candidates(wanted: int) -> Float:
        if patch.spots is not None:
            some = random.choice(len(patch.spots.points), wanted, p=patch.spots.shares / patch.measure)
            return _seen(patch, patch.spots)[some]
        found = np.empty((0, 2))
        while len(found) < wanted:
            tried = random.uniform(low, high, (4 * wanted, 2))
            found = np.vstack([found, tried[flat.inside(polygon, tried)]])
        return found[:wanted]

    chosen = candidates(1)
    while len(chosen) < count:
        tried = candidates(CANDIDATES)
        distance = np.linalg.norm(tried[:, None] - chosen, axis=2).min(1)
        chosen = np.vstack([chosen, tried[np.argmax(distance)]])
    return chosen, np.full(count, patch.measure / count)


def thin_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """A point itself; a line's ends with evenly spaced nodes between, at the weights of Simpson's rule.

    A linear pressure along the line, which is all that a rigid body can press, is then carried exactly.
    """
    ends = patch.rings[0]
    if patch.kind == "point":
        return ends, np.array([patch.measure])
    count += 1 - count % 2
    weights = np.where(np.arange(count) % 2, 4.0, 2.0)
    weights[[0, -1]] = 1.0
    t = np.linspace(0, 1, count)[:, None]
    return (1 - t) * ends[0] + t * ends[1], weights / weights.sum() * patch.measure


@dataclass(frozen=True)
class _Sheet:
    """A patch seen in the coordinates of its smallest rectangle, (0, 1) along both sides, the longer one first.

    Distances are taken here: along a narrow strip farthest points would otherwise line up in its middle and miss how
    it carries across.
    """

    patch: Patch
    axes: Float
    low: Float
    size: Float
    corners: Float

    @classmethod
    def of(cls, patch: Patch) -> _Sheet:
        axes, low, high, hull = patch.rectangle
        return cls(patch, axes, low, high - low, (hull @ axes.T - low) / (high - low))

    def flat(self, unit: Float) -> Float:
        """Points (n, 2) in the patch's frame."""
        return np.asarray((self.low + unit * self.size) @ self.axes)

    def kept(self, unit: Float, margin: float = 0.0) -> Float:
        """Those of the points (n, 2) that lie on the patch, or within ``margin`` [m] of it."""
        polygon = flat.shapely_polygon(self.patch.rings)
        return unit[flat.inside(polygon.buffer(margin) if margin else polygon, self.flat(unit))]

    def outline(self, steps: Float) -> Float:
        """Corners of the hull, and points on the patch along its edges, none farther than a step from the next.

        ``steps`` (2,) are the numbers of steps along both sides of the rectangle. Edges that tessellate a curve get no
        points between their corners: a round rim has no edge on which a body could stand.
        """
        ahead = np.roll(self.corners, -1, axis=0)
        along = (ahead - self.corners) * self.size
        angle = np.arctan2(along[:, 1], along[:, 0])
        turn = np.abs((angle - np.roll(angle, 1) + np.pi) % (2 * np.pi) - np.pi)  # at the corner where an edge begins
        straight = np.maximum(turn, np.roll(turn, -1)) > CURVED
        pieces = np.ceil(np.linalg.norm((ahead - self.corners) * steps, axis=1) - 0.01).astype(int)
        between = [
            one + np.arange(1, count)[:, None] / count * (other - one)
            for one, other, count in zip(self.corners, ahead, np.where(straight, pieces, 1), strict=True)
        ]
        return np.vstack([self.corners, self.kept(np.vstack(between), 1e-9 * self.patch.size)])

    @property
    def whole(self) -> bool:
        """Whether the patch is all of its rectangle."""
        corners = np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
        if len(self.patch.rings) > 1 or len(self.corners) != 4:
            return False
        return bool((np.abs(self.corners[:, None] - corners).max(2).min(0) <= EXACT).all())

    @property
    def aspect(self) -> float:
        """The shorter side over the longer one, the same for equal rectangles, however they lie."""
        return float(f"{self.size[1] / self.size[0]:.12g}")

    @cached_property
    def lattice(self) -> Float:
        """Points (n, 2) spread over the patch: its spots, or such that each stands for the same area."""
        if self.patch.spots is not None:
            return np.asarray((_seen(self.patch, self.patch.spots) @ self.axes.T - self.low) / self.size)
        return self.spread(LATTICE, LATTICE)

    def spread(self, along: int, across: int) -> Float:
        """Middles (n, 2) of so many equal cells along either side of the rectangle, those on the patch."""
        kept = self.kept(_middles(along, across))
        return kept if len(kept) >= 8 else np.vstack([kept, self.corners])


def hull_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """Hull corners first, then farthest points: nodes (n, 2) in the patch's frame and weights (n,).

    Corners are taken as far as half the nodes go (at least four), so that a disc keeps nodes inside.
    """
    sheet = _Sheet.of(patch)
    if sheet.whole and patch.spots is None:
        chosen = _hull_nodes(tuple(np.rint(sheet.corners).ravel().tolist()), count)
        return sheet.flat(chosen), _hull_shares(tuple(chosen.ravel().tolist()), sheet.aspect) * patch.measure
    chosen = _hull_chosen(sheet.corners, sheet.lattice, count)
    owned = _owned(chosen, sheet.lattice, None if patch.spots is None else patch.spots.shares)
    return sheet.flat(chosen), _weights(sheet, chosen, owned)


def _hull_chosen(corners: Float, lattice: Float, count: int) -> Float:
    """Corners (n, 2) first, then the farthest of the points of a lattice (m, 2)."""
    limit = len(corners) if len(corners) <= count // 2 else max(4, count // 2)
    return _farthest(lattice, _farthest(corners, corners[:1], min(limit, count)), count)


@lru_cache(maxsize=KEPT)
def _hull_nodes(corners: tuple[float, ...], count: int) -> Float:
    """The nodes (n, 2) of a unit square by its corners, of which the first one decides between equally far points."""
    return frozen(_hull_chosen(np.array(corners).reshape(-1, 2), _middles(LATTICE, LATTICE), count))


@lru_cache(maxsize=KEPT)
def _hull_shares(unit: tuple[float, ...], aspect: float) -> Float:
    """What each of these nodes has of the area of a rectangle (n,), whose sides are as 1 to ``aspect``."""
    nodes = np.array(unit).reshape(-1, 2)
    return _rectangle_shares(nodes, _owned(nodes, _middles(LATTICE, LATTICE)), aspect)


def tensor_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """A grid of about ``count`` nodes over the smallest rectangle around the patch, its boundary included.

    On a rectangle the weights are close to Simpson's. Elsewhere the hull's corners are nodes, with others along its
    straight edges a step of the grid apart (of too many, those that are farthest from each other): a body tips over
    them, and must twist on the whole edge, not on its two ends. Where the patch is known by its spots, they are chosen
    from these.
    """
    if patch.spots is not None:
        return hull_sample(patch, count)
    sheet = _Sheet.of(patch)
    across = max(2, round(min(float(np.sqrt(count * sheet.size[0] / sheet.size[1])), count)))  # a hair has no more
    along = max(2, round(count / across))
    # cells that no line between two nodes cuts: each belongs to one node, and equal nodes get equal areas
    between = CELLS if count < MANY else FEW_CELLS
    grid = _grid(across, along)
    if sheet.whole:
        return sheet.flat(grid), _grid_shares(across, along, between, sheet.aspect) * patch.measure
    steps = np.array([across - 1, along - 1])
    edge = sheet.outline(steps)
    if len(edge) > count // 2:
        edge = _farthest(edge, edge[:1], max(4, count // 2))
    inner = sheet.kept(grid, 1e-9 * patch.size)
    apart = np.asarray(cKDTree(edge * steps).query(inner * steps, p=np.inf)[0]) > NEAR
    nodes = np.vstack([edge, inner[apart]])
    cells = sheet.spread(between * (across - 1), between * (along - 1))
    return sheet.flat(nodes), _weights(sheet, nodes, _owned(nodes, cells))


def _middles(along: int, across: int) -> Float:
    """The middles (n, 2) of so many equal cells along either side of the unit square."""
    u, v = (np.arange(along) + 0.5) / along, (np.arange(across) + 0.5) / across
    return np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2)


@lru_cache(maxsize=KEPT)
def _grid(across: int, along: int) -> Float:
    """So many nodes (n, 2) along either side of the unit square, its boundary included."""
    u, v = np.linspace(0, 1, across), np.linspace(0, 1, along)
    return frozen(np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2))


@lru_cache(maxsize=KEPT)
def _grid_shares(across: int, along: int, between: int, aspect: float) -> Float:
    """What each node of a grid has of the area of a rectangle (n,), whose sides are as 1 to ``aspect``.

    Walls and pallets have hundreds of equal rectangles, so these are kept. Each node owns the cells around it,
    ``between`` of them from one node to the next, and half of them at a side.
    """
    grid = _grid(across, along)
    return _rectangle_shares(grid, between**2 * np.where((grid > 0) & (grid < 1), 1.0, 0.5).prod(1), aspect)


def _rectangle_shares(unit: Float, owned: Float, aspect: float) -> Float:
    """What nodes at ``unit`` (n, 2), which own so many equal cells (n,), have of the area of a rectangle.

    Its sides are 1 and the ``aspect`` a, its diagonal is d. The distance to its centre has the integral
    [2 a d + a³ asinh(1/a) + asinh(a)] / 12.
    """
    a, d = aspect, math.hypot(1.0, aspect)
    moments = np.array([a, a / 2, a * a / 2, a / 3, a * a / 4, a**3 / 3])
    arm = (2 * a * d + a**3 * math.asinh(1 / a) + math.asinh(a)) / 12
    return frozen(_matched(unit * [1.0, a], owned + 0.5, moments, arm, d) / a)


def _owned(unit: Float, cells: Float, shares: Float | None = None) -> Float:
    """How many of the ``cells`` (n, 2) are nearest to each node, or the sum of their ``shares`` (n,)."""
    return np.bincount(np.asarray(cKDTree(unit).query(cells)[1]), shares, len(unit)).astype(float)


def _farthest(candidates: Float, chosen: Float, count: int) -> Float:
    """``chosen`` grown to ``count`` points, each the candidate farthest from those before it.

    Where the candidates are symmetric about the sheet's middle points come in opposite pairs: which of equally far
    points is taken depends on how the patch is turned, and pairs keep that from showing.
    """
    opposite = np.asarray(cKDTree(candidates).query(1 - candidates)[1])
    paired = np.abs(candidates[opposite] - (1 - candidates)).max() < 1e-6
    distance = np.min(((candidates[:, None] - chosen) ** 2).sum(-1), axis=1)
    points = list(chosen)
    while len(points) < count:
        next_ = int(np.argmax(np.round(distance, 9)))
        if distance[next_] <= 0:
            break
        for index in (next_, int(opposite[next_])) if paired else (next_,):
            if len(points) < count and distance[index] > 0:
                points.append(candidates[index])
                distance = np.minimum(distance, ((candidates - candidates[index]) ** 2).sum(1))
    return np.array(points)


def _weights(sheet: _Sheet, unit: Float, owned: Float) -> Float:
    """Weights of nodes (n, 2) that have ``owned`` (n,) equal cells each, or as much of the area of spots."""
    patch, spots = sheet.patch, sheet.patch.spots
    centre = patch.moments[1:3] / patch.moments[0]
    if spots is None:
        shares, arm = owned + 0.5, flat.distance_moment(patch.rings, centre)
    else:
        shares = owned + LEAST * patch.measure / len(owned)
        arm = float(spots.shares @ np.linalg.norm(_seen(patch, spots) - centre, axis=1))
    return _matched(sheet.flat(unit), shares, patch.moments, arm, patch.size)


def _matched(nodes: Float, shares: Float, moments: Float, arm: float, scale: float) -> Float:
    """Tributary areas, corrected as little as possible so that they integrate known moments of a patch exactly.

    They are in proportion to ``shares`` (n,). The moments are area, first and second ``moments`` (6,) (linear pressure
    is then carried exactly) and the distance to the centroid, ``arm`` (so is uniform friction against twisting). Fewer
    are matched where the nodes (n, 2) cannot. ``scale`` [m] is the size of the patch.
    """
    tributary: Float = shares / shares.sum() * moments[0]
    cx, cy = centre = moments[1:3] / moments[0]
    x, y = ((nodes - centre) / scale).T
    rows = np.array([np.ones_like(x), x, y, x * x, x * y, y * y, np.hypot(x, y)])
    second = (moments[3:] - moments[0] * np.array([cx * cx, cx * cy, cy * cy])) / scale**2
    return corrected(tributary, rows, np.array([moments[0], 0, 0, *second, arm / scale]), (7, 6, 3))


def _seen(patch: Patch, spots: Spots) -> Float:
    """The spots of a patch (n, 2) in its frame."""
    return np.asarray((spots.points - patch.polygon[0]) @ patch.frame.T)


_SAMPLES = {"hull": hull_sample, "quadrature": tensor_sample, "corners": corner_sample}
