"""Nodes: the points that stand for a patch, with weights that integrate over it."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from holdfast.arrays import Float
from holdfast.contacts import polygon as flat
from holdfast.contacts.interface import Interface, Patch
from holdfast.errors import HoldfastError, message

Sampling = Literal["hull", "quadrature", "corners"]

LATTICE = 24  # candidate points across the longer side of a patch
LEAST_SHARE = 0.1  # no corrected weight falls below this share of its tributary area


def interface_nodes(interface: Interface, count: int, sampling: Sampling) -> list[tuple[Float, Float]]:
    """For each patch its nodes (n, 3) [m] and weights (n,) [m²]; ``count`` nodes are shared out by area.

    "hull": hull corners, then farthest points; "quadrature": a grid; "corners": the hull's corners alone.
    """
    if sampling not in get_args(Sampling):
        raise HoldfastError(message("nodes", f"sampling = {sampling!r}", "needs 'hull', 'quadrature' or 'corners'"))
    if count < 4:
        raise HoldfastError(message("nodes", f"{count} nodes an interface", "needs at least 4"))
    result = []
    for patch in interface.patches:
        share = max(4, round(count * patch.area / interface.area))
        points, weights = _SAMPLES[sampling](patch, share)
        result.append((patch.lifted(points), weights))
    return result


def corner_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """All corners of the hull, whatever ``count``: they carry every force that the whole patch could carry."""
    corners = flat.convex_hull(patch.rings[0], 1e-9 * patch.size)
    return corners, np.full(len(corners), patch.area / len(corners))


def hull_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """Hull corners first, then farthest points: nodes (n, 2) in the patch's frame and weights (n,).

    Corners are taken as far as half the nodes go (at least four), so that a disc keeps nodes inside.
    """
    corners = flat.convex_hull(patch.rings[0], 1e-9 * patch.size)
    candidates = _lattice(patch)
    limit = len(corners) if len(corners) <= count // 2 else max(4, count // 2)
    chosen = _farthest(corners, corners[:1], min(limit, count))
    chosen = _farthest(candidates, chosen, count)
    return chosen, _weights(patch, chosen, candidates)


def tensor_sample(patch: Patch, count: int) -> tuple[Float, Float]:
    """A grid of about ``count`` nodes over the smallest rectangle around the patch, its boundary included.

    On a rectangle the weights are close to Simpson's; elsewhere nodes outside the patch give way to its hull corners.
    """
    corners = flat.convex_hull(patch.rings[0], 1e-9 * patch.size)
    axes, low, high = flat.smallest_rectangle(corners)
    size = high - low
    across = max(2, round(float(np.sqrt(count * size[0] / size[1]))))
    along = max(2, round(count / across))
    u, v = np.linspace(low[0], high[0], across), np.linspace(low[1], high[1], along)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2) @ axes
    polygon = flat.shapely_polygon(patch.rings).buffer(1e-9 * patch.size)
    inner = grid[flat.inside(polygon, grid)]
    spacing = float(size.max()) / max(across - 1, along - 1)
    apart = np.array([len(inner) == 0 or np.linalg.norm(inner - c, axis=1).min() > 0.3 * spacing for c in corners])
    kept = corners[apart]
    if len(kept) > count // 2:
        kept = _farthest(kept, kept[:1], max(4, count // 2))
    nodes = np.vstack([kept, inner])
    return nodes, _weights(patch, nodes, _lattice(patch))


def _lattice(patch: Patch) -> Float:
    """Points (n, 2) spread evenly inside the patch, each standing for the same area."""
    axes, low, high = flat.smallest_rectangle(flat.convex_hull(patch.rings[0], 1e-9 * patch.size))
    size = high - low
    step = float(size.max()) / LATTICE
    counts = np.maximum(np.ceil(size / step), 6).astype(int)
    u, v = (low[k] + (np.arange(counts[k]) + 0.5) * size[k] / counts[k] for k in range(2))
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), -1).reshape(-1, 2) @ axes
    kept = grid[flat.inside(flat.shapely_polygon(patch.rings), grid)]
    return kept if len(kept) >= 8 else np.vstack([kept, patch.rings[0]])


def _farthest(candidates: Float, chosen: Float, count: int) -> Float:
    """``chosen`` grown to ``count`` points, each the candidate farthest from those before it."""
    distance = np.min(((candidates[:, None] - chosen) ** 2).sum(-1), axis=1)
    points = list(chosen)
    while len(points) < count:
        nearest = int(np.argmax(np.round(distance / max(distance.max(), 1e-300), 9)))
        if distance[nearest] <= 0:
            break
        points.append(candidates[nearest])
        distance = np.minimum(distance, ((candidates - candidates[nearest]) ** 2).sum(1))
    return np.array(points)


def _weights(patch: Patch, nodes: Float, lattice: Float) -> Float:
    """Tributary areas, corrected as little as possible so that they integrate known moments of the patch exactly.

    The moments are area, first and second moments (linear pressure is then carried exactly) and the distance to the
    centroid (so is uniform friction against twisting). Fewer are matched where the nodes cannot.
    """
    distances = ((lattice[:, None] - nodes) ** 2).sum(-1)
    cells = np.bincount(np.argmin(distances, axis=1), minlength=len(nodes)) + 0.5
    tributary: Float = cells / cells.sum() * patch.area
    raw = flat.polynomial_moments(patch.rings)
    centre = raw[1:3] / raw[0]
    scale = patch.size
    x, y = ((nodes - centre) / scale).T
    rows = np.array([np.ones_like(x), x, y, x * x, x * y, y * y, np.hypot(x, y)])
    cx, cy = centre
    second = [raw[3] - raw[0] * cx * cx, raw[4] - raw[0] * cx * cy, raw[5] - raw[0] * cy * cy]
    arm = flat.distance_moment(patch.rings, centre)
    wanted = np.array([raw[0], 0, 0, *(m / scale**2 for m in second), arm / scale])
    for matched in (7, 6, 3):
        corrected = _corrected(tributary, rows[:matched], wanted[:matched])
        if corrected is not None:
            return corrected
    return tributary


def _corrected(tributary: Float, basis: Float, wanted: Float) -> Float | None:
    """The weights nearest to ``tributary`` with ``basis @ weights = wanted``; None where some would be too small."""
    floor = LEAST_SHARE * tributary
    free = np.ones(len(tributary), dtype=bool)
    weights = tributary
    while free.sum() > len(wanted):
        base = np.where(free, tributary, floor)
        metric = np.where(free, tributary, 0.0)
        multipliers, *_ = np.linalg.lstsq((basis * metric) @ basis.T, wanted - basis @ base, rcond=1e-10)
        weights = base + metric * (basis.T @ multipliers)
        if not np.allclose(basis @ weights, wanted, atol=1e-9 * wanted[0]):
            return None
        low = free & (weights < floor)
        if not low.any():
            return np.asarray(weights)
        free &= ~low
    return None


_SAMPLES = {"hull": hull_sample, "quadrature": tensor_sample, "corners": corner_sample}
