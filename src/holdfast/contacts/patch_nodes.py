"""Nodes: points that represent a patch, with weights that integrate over it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from itertools import accumulate
from typing import Literal, get_args

import numpy as np

from holdfast.base.arrays import Float, Int, frozen
from holdfast.base.errors import HoldfastError, message
from holdfast.base.values import sealed
from holdfast.contacts.interface import Interface, Patch
from holdfast.contacts.spots import LEAST, Spots, corrected, nearest_spot
from holdfast.geometry import polygon as flat
from holdfast.geometry.hull import search_tree
from holdfast.native import core

Sampling = Literal["hull", "quadrature", "corners", "paper"]

CANDIDATES = 10  # number of random points from which the paper chooses the farthest
CELLS = 6  # cells for each grid step, to measure tributary areas; even, so that none is halfway between two nodes
MANY, FEW_CELLS = 2000, 2  # for grids with at least MANY nodes, FEW_CELLS for each step are enough
EXACT = 1e-12  # largest deviation of the corners of a rectangular patch, relative to its sides
LATTICE = 19  # candidate points along each side of a patch; odd, so that the middle is among them
MOST_CACHED = 1000  # largest number of grids, and of shares of rectangles, in the caches
MOST_BENT = 64  # largest number of spots of a bent patch that are used as its corners


def interface_nodes(interface: Interface, count: int, sampling: Sampling, seed: int = 0) -> list[tuple[Float, Float]]:
    """Return the nodes (n, 3) [m] and weights (n,) [m²] of each patch; ``count`` nodes are distributed by area.

    With "hull", nodes are the corners of the hull, then farthest points; with "quadrature", a grid; with "corners",
    only the corners of the hull; with "paper", random points from ``seed``, each the farthest of ten candidates, with
    equal weights. Raises HoldfastError for another ``sampling`` or fewer than four nodes.
    """
    return nodes_of([interface], [count], sampling, [seed])[0]


def nodes_of(
    interfaces: Sequence[Interface], counts: Sequence[int], sampling: Sampling, seeds: Sequence[int]
) -> list[list[tuple[Float, Float]]]:
    """Return what ``interface_nodes`` does of each interface, for all in one go; others than grids are kept with it."""
    if not isinstance(sampling, str) or sampling not in get_args(Sampling):
        raise HoldfastError(
            message("nodes", f"sampling = {sampling!r}", f"needs one of {', '.join(get_args(Sampling))}")
        )
    if min(counts, default=4) < 4:
        raise HoldfastError(message("nodes", f"{min(counts)} nodes an interface", "needs at least 4"))
    grids: list[tuple[Float, Float] | None] = [None] * len(interfaces)
    if sampling == "quadrature":
        alone = [k for k, interface in enumerate(interfaces) if len(interface.patches) == 1]
        found = _grids([interfaces[k].patches[0] for k in alone], [counts[k] for k in alone])
        for k, grid in zip(alone, found, strict=True):
            grids[k] = grid
    return [
        [grid]
        if grid is not None
        else one.memory.recalled((count, sampling, seed), 1, partial(_sampled, one, count, sampling, seed))
        for one, count, seed, grid in zip(interfaces, counts, seeds, grids, strict=True)
    ]


def _sampled(interface: Interface, count: int, sampling: Sampling, seed: int) -> list[tuple[Float, Float]]:
    random = np.random.default_rng(seed) if sampling == "paper" else None
    result = []
    total = sum(patch.measure for patch in interface.patches)
    shares = [max(4, round(count * patch.measure / total)) for patch in interface.patches]
    grids = _grids(interface.patches, shares) if sampling == "quadrature" else [None] * len(shares)
    for patch, share, grid in zip(interface.patches, shares, grids, strict=True):
        if patch.spots is not None and patch.spots.bent:
            result.append(bent_sample(patch.spots, MOST_BENT if sampling == "corners" else share))
        elif patch.kind != "face":
            result.append(thin_sample(patch, share))
        elif grid is not None:
            result.append(grid)
        else:
            sample = _SAMPLES[sampling] if random is None else partial(paper_sample, random=random)
            points, weights = sample(patch, share)
            result.append(sealed((patch.lifted(points), np.array(weights))))
    return result


def _grids(patches: Sequence[Patch], counts: Sequence[int]) -> list[tuple[Float, Float] | None]:
    """Return grids of about ``counts`` nodes over patches that fill their smallest rectangles; None of others.

    The boundary is included, and the weights are close to Simpson's.
    """
    found: list[tuple[Float, Float] | None] = [None] * len(patches)
    faces = [k for k, one in enumerate(patches) if one.kind == "face" and one.spots is None and not one.holes]
    if not faces:
        return found
    outlines = [patches[k].polygon for k in faces]
    first, normals = np.cumsum([0, *map(len, outlines)]), np.array([patches[k].normal for k in faces])
    sides, aspects, points = core.grids_over(
        np.concatenate(outlines), first, normals, np.array([counts[k] for k in faces], dtype=np.int64)
    )
    weights = np.empty(len(points))
    last = 0
    for k, (across, along), aspect in zip(faces, sides.tolist(), aspects.tolist(), strict=True):
        if across:
            here = slice(last, last + across * along)
            # no cell is cut by the line halfway between two nodes, so equivalent nodes get equal areas
            shares = _grid_shares(across, along, CELLS if counts[k] < MANY else FEW_CELLS, _rounded(aspect))
            weights[here] = shares * patches[k].area
            found[k] = points[here], weights[here]
            last = here.stop
    sealed((points, weights, found))
    return found


def corner_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """Return all corners of the hull, whatever ``count``; they can carry every force that the whole patch can carry."""
    return patch.corners, np.full(len(patch.corners), patch.measure / len(patch.corners))


def bent_sample(spots: Spots, count: int) -> tuple[Float, Float]:
    """Return the first ``count`` spots (n, 3) of a bent patch, which are far apart, and their weights (n,) [m²].

    The weights preserve the total weight, the first moments, and the resultant and moment of a unit pressure.
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
    """Return the nodes of the paper (Sec. VI-A2): each is the one of ten random points farthest from all before it."""
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
    """Return a point itself, or evenly spaced nodes (n, 3) on a line, with its ends, and the weights of Simpson's rule.

    Then a linear pressure along the line, the only one that a rigid body can exert, is represented exactly. The nodes
    are on the line itself, which may lean a little against the plane of the patch, whichever of its ends comes first.
    """
    ends = patch.polygon
    if patch.kind == "point":
        return ends, frozen(np.array([patch.measure]))
    count += 1 - count % 2
    weights = np.where(np.arange(count) % 2, 4.0, 2.0)
    weights[[0, -1]] = 1.0
    t = np.linspace(0, 1, count)[:, None]
    return frozen((1 - t) * ends[0] + t * ends[1]), frozen(weights / weights.sum() * patch.measure)


@dataclass(frozen=True)
class _Sheet:
    """A patch in the coordinates of its smallest rectangle, from 0 to 1 along both sides, the longer one first.

    Distances are measured in these coordinates. On a narrow strip, farthest points would otherwise all lie along its
    middle, and moments across the strip would be lost.
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
        """Return points (n, 2) [m] in the frame of the patch."""
        return np.asarray((self.low + unit * self.size) @ self.axes)

    @cached_property
    def face(self) -> tuple[Float, Int, Float, Float]:
        """The same as native/even_nodes.hpp reads it."""
        rings = self.patch.rings
        first = np.array([0, *accumulate(map(len, rings))], dtype=np.int64)
        return np.concatenate(rings), first, np.vstack([self.axes, self.low, self.size]), self.corners

    @property
    def whole(self) -> bool:
        """Whether the patch fills its rectangle."""
        corners = np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
        if len(self.patch.rings) > 1 or len(self.corners) != 4:
            return False
        return bool((np.abs(self.corners[:, None] - corners).max(2).min(0) <= EXACT).all())

    @cached_property
    def lattice(self) -> Float:
        """Points (n, 2) on the patch that represent equal areas, or its spots if it is a merged patch."""
        if self.patch.spots is not None:
            return np.asarray((_seen(self.patch, self.patch.spots) @ self.axes.T - self.low) / self.size)
        return core.cells_on(self.face, LATTICE, LATTICE)


def hull_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """Return nodes (n, 2) in the frame of the patch, corners of the hull first, then farthest points, and weights (n,).

    At most half the nodes, but at least four, are corners, so that a disc has nodes inside, too.
    """
    sheet = _Sheet.of(patch)
    if sheet.whole and patch.spots is None:
        chosen = _hull_nodes(tuple(np.rint(sheet.corners).ravel().tolist()), count)
        aspect = _rounded(sheet.size[1] / sheet.size[0])
        return sheet.flat(chosen), _hull_shares(tuple(chosen.ravel().tolist()), aspect) * patch.measure
    chosen = _hull_chosen(sheet.corners, sheet.lattice, count)
    owned = _owned(chosen, sheet.lattice, None if patch.spots is None else patch.spots.shares)
    return sheet.flat(chosen), _weights(sheet, chosen, owned)


def _hull_chosen(corners: Float, lattice: Float, count: int) -> Float:
    """Return ``count`` nodes (n, 2): corners first, then the farthest points of a lattice (m, 2)."""
    limit = len(corners) if len(corners) <= count // 2 else max(4, count // 2)
    return core.farthest_of(lattice, core.farthest_of(corners, corners[:1], min(limit, count)), count)


@lru_cache(maxsize=MOST_CACHED)
def _hull_nodes(corners: tuple[float, ...], count: int) -> Float:
    """Return the nodes (n, 2) of a unit square; the order of its corners decides between equally distant points."""
    return frozen(_hull_chosen(np.array(corners).reshape(-1, 2), _middles(LATTICE, LATTICE), count))


@lru_cache(maxsize=MOST_CACHED)
def _hull_shares(unit: tuple[float, ...], aspect: float) -> Float:
    """Return the share (n,) of the area that each of these nodes has in a rectangle with sides 1 and ``aspect``."""
    nodes = np.array(unit).reshape(-1, 2)
    return _rectangle_shares(nodes, _owned(nodes, _middles(LATTICE, LATTICE)), aspect)


def cut_grid_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """Return nodes (n, 2) in the frame of a patch that does not fill its smallest rectangle, and their weights (n,).

    They are those of a grid of about ``count`` nodes over the rectangle that lie on the patch. Nodes are also at the
    corners of the hull and along its straight edges, a grid step apart (if there are too many, only those farthest from
    each other). A body tips over these edges, and it must twist on the whole edge, not only on its two ends. On a
    merged patch the nodes are chosen from its spots.
    """
    if patch.spots is not None:
        return hull_sample(patch, count)
    sheet = _Sheet.of(patch)
    # a very thin patch has only two rows
    across = max(2, round(min(float(np.sqrt(count * sheet.size[0] / sheet.size[1])), count)))
    along = max(2, round(count / across))
    # no cell is cut by the line halfway between two nodes, so equivalent nodes get equal areas
    between = CELLS if count < MANY else FEW_CELLS
    # at most half as many corners and points of edges as nodes are wanted
    nodes = core.nodes_on(sheet.face, across, along, count // 2, 1e-9 * patch.size)
    cells = core.cells_on(sheet.face, between * (across - 1), between * (along - 1))
    return sheet.flat(nodes), _weights(sheet, nodes, _owned(nodes, cells))


def _rounded(aspect: float) -> float:
    """Return an aspect rounded so that equal rectangles in any pose have the same."""
    return float(f"{aspect:.12g}")


def _middles(along: int, across: int) -> Float:
    """Return the centres (n, 2) of a grid of ``along`` x ``across`` equal cells on the unit square."""
    u, v = (np.arange(along) + 0.5) / along, (np.arange(across) + 0.5) / across
    return np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2)


@lru_cache(maxsize=MOST_CACHED)
def _grid_shares(across: int, along: int, between: int, aspect: float) -> Float:
    """Return the share (n,) of the area that each node of a grid has in a rectangle with sides 1 and ``aspect``.

    The grid has ``across`` x ``along`` nodes, with its boundary. Results are cached, because walls and pallets have
    hundreds of equal rectangles. Each node owns the cells around it: ``between`` of them along either axis, and half as
    many on the boundary.
    """
    u, v = np.linspace(0, 1, across), np.linspace(0, 1, along)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2)
    return _rectangle_shares(grid, between**2 * np.where((grid > 0) & (grid < 1), 1.0, 0.5).prod(1), aspect)


def _rectangle_shares(unit: Float, owned: Float, aspect: float) -> Float:
    """Return the shares (n,) of the area of a rectangle at nodes ``unit`` (n, 2) that own ``owned`` (n,) cells each.

    The sides are 1 and the ``aspect`` a, and the diagonal is d. The integral of the distance to the centre is
    [2 a d + a³ asinh(1/a) + asinh(a)] / 12.
    """
    a, d = aspect, math.hypot(1.0, aspect)
    moments = np.array([a, a / 2, a * a / 2, a / 3, a * a / 4, a**3 / 3])
    arm = (2 * a * d + a**3 * math.asinh(1 / a) + math.asinh(a)) / 12
    return frozen(core.matched_weights(unit * [1.0, a], owned + 0.5, moments, arm, d) / a)


def _owned(unit: Float, cells: Float, shares: Float | None = None) -> Float:
    """Return how many of the ``cells`` (m, 2) are nearest to each node (n,), or the sum of their ``shares`` (m,)."""
    nearest = core.nearest_of(unit, cells)
    tied = nearest < 0
    if tied.any():
        nearest[tied] = search_tree(unit).query(cells[tied])[1]
    return np.bincount(nearest, shares, len(unit)).astype(float)


def _weights(sheet: _Sheet, unit: Float, owned: Float) -> Float:
    """Return weights of nodes (n, 2) that own ``owned`` (n,) equal cells or, on a merged patch, such shares of it."""
    patch, spots = sheet.patch, sheet.patch.spots
    centre = patch.moments[1:3] / patch.moments[0]
    if spots is None:
        shares, arm = owned + 0.5, flat.distance_moment(patch.rings, centre)
    else:
        shares = owned + LEAST * patch.measure / len(owned)
        arm = float(spots.shares @ np.linalg.norm(_seen(patch, spots) - centre, axis=1))
    return core.matched_weights(sheet.flat(unit), shares, patch.moments, arm, patch.size)


def _seen(patch: Patch, spots: Spots) -> Float:
    """Return the spots (n, 2) [m] of a patch in its frame."""
    return np.asarray((spots.points - patch.polygon[0]) @ patch.frame.T)


_SAMPLES = {"hull": hull_sample, "quadrature": cut_grid_sample, "corners": corner_sample}
