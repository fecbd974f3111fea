"""Cut a body's surface into cells of about one spacing, each with one query point on it."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Bool, Float, Int, frozen, unit
from holdfast.base.public import Record, column
from holdfast.base.ranges import COORDINATES
from holdfast.base.rigid import tangents
from holdfast.geometry.hull import convex_hull, search_tree, smallest_rectangle
from holdfast.geometry.surface import Surface
from holdfast.geometry.triangles import SMOOTH, areas_of
from holdfast.native import core

# [rad] largest angle between neighbouring triangles of one facet. It is wider than that of ``Facets``, because
# coordinates in files have six or seven digits, and a grid does not need so exact an outline as a contact.
COPLANAR = float(np.arccos(1 - 1e-8))
SMALL = 1.5  # [spacings] a facet that is smaller than this in every direction gets no grid of its own
WHOLE = 0.999  # share of a grid square; the centroid of a cell that covers less may lie outside the surface
WAYS = 1.2  # normals whose components round to the same multiples of 1 / WAYS count as alike
SCAN = 5000  # a surface with at least this many small triangles on curved parts is treated as a scan
PACKED = 0.9  # [spacings] least distance of two seeds; cells then have about the area of a square spacing
FACING = 1.2  # [spacings] distance that a unit difference of normals counts as: seeds 45 degrees apart may coincide
LEAST_MEAN = 0.1  # a mean normal of a cell that is shorter than this is not used


class Cells(Record):
    """The C cells of a surface, each with a query point.

    ``points`` (C, 3) [m] are the query points, with outward unit ``normals`` (C, 3). The cells consist of ``triangles``
    (T, 3) over ``vertices`` (V, 3) [m], and ``cell`` (T,) is the number of the cell to which each triangle belongs. On
    scans, the normal of a cell is the mean over its triangles, and ``turned`` (C,) [deg] is its angle to the normal of
    the triangle on which the point lies.
    """

    points: Float = column("C 3")
    normals: Float = column("C 3")
    vertices: Float = column("V 3")
    triangles: Int = column("T 3")
    cell: Int = column("T")
    turned: Float = column("C")

    @property
    def areas(self) -> Float:
        """The area (C,) [m²] of each cell."""
        areas = areas_of(self.vertices, self.triangles)
        return frozen(np.asarray(np.bincount(self.cell, areas, minlength=len(self.points)), dtype=np.float64))

    def chosen(self, keep: Bool) -> Cells:
        """Return only the cells for which ``keep`` (C,) is true."""
        number = np.cumsum(keep) - 1
        kept = keep[self.cell]
        cell = number[self.cell[kept]]
        return Cells(
            self.points[keep], self.normals[keep], self.vertices, self.triangles[kept], cell, self.turned[keep]
        )


def surface_cells(surface: Surface, spacing: float) -> Cells:
    """Divide a surface into cells of about ``spacing`` [m].

    Large flat facets are cut by a grid along their smallest rectangle, and small triangles are clustered. On curved
    parts of a scan (SCAN or more small triangles), points are spread evenly and normals are smoothed.
    """
    facet = surface.topology.regions(COPLANAR)
    parts: list[Cells] = []
    small = np.zeros(len(surface.faces), dtype=bool)
    order = np.argsort(facet, kind="stable")
    bounds = np.flatnonzero(np.diff(facet[order], prepend=-1, append=facet.max() + 1))
    corners = surface.vertices[surface.faces[order]]
    low, high = np.minimum.reduceat(corners.min(1), bounds[:-1]), np.maximum.reduceat(corners.max(1), bounds[:-1])
    tiny = (high - low).max(1) < SMALL * spacing
    small[order] = np.repeat(tiny, np.diff(bounds))
    for k in np.flatnonzero(~tiny).tolist():
        own = slice(bounds[k], bounds[k + 1])
        parts.append(_gridded(corners[own], surface.normals[order[bounds[k]]], spacing))
    bend = np.abs(surface.topology.bend)[surface.topology.of_face]
    curved = small & ((bend > COPLANAR) & (bend < SMOOTH)).any(1)
    curved &= curved.sum() >= SCAN
    for divide, members in ((_smoothed, curved), (_clustered, small & ~curved)):
        if members.any():
            parts.append(divide(surface, np.flatnonzero(members), spacing))
    return _joined(parts)


def blocked(cells: Cells, obstacle: Surface, room: float) -> Bool:
    """Tell for each cell (C,) whether ``obstacle`` is less than ``room`` [m] in front of its point."""
    result = np.zeros(len(cells.points), dtype=bool)
    low, high = obstacle.vertices.min(0) - room, obstacle.vertices.max(0) + room
    near = np.flatnonzero(((cells.points >= low) & (cells.points <= high)).all(1))
    if not len(near):
        return result
    triangles = obstacle.vertices[obstacle.faces]
    bottom, top = cells.points[near].min(0) - room, cells.points[near].max(0) + room
    triangles = triangles[((triangles.max(1) >= bottom) & (triangles.min(1) <= top)).all(1)]
    hit = np.zeros(len(near), dtype=bool)
    core.mark_hits(cells.points[near], cells.normals[near], triangles, room, hit)
    result[near] = hit
    return result


def _gridded(corners: Float, normal: Float, spacing: float) -> Cells:
    """Return the cells of one flat facet, given as triangles (n, 3, 3): grid squares, clipped at the outline.

    The point of a cell is its centroid or, if the cell is clipped, the centroid of its largest piece.
    """
    origin = corners[0, 0]
    frame = np.array(tangents(normal))
    plane = (corners - origin) @ frame.T
    axes, low, high = smallest_rectangle(convex_hull(plane.reshape(-1, 2), COORDINATES * spacing))
    aligned = plane @ axes.T - low
    counts = np.maximum(np.ceil((high - low) / spacing - COORDINATES), 1).astype(np.int64)
    step = (high - low) / counts
    pieces, sizes, cell = _grid_pieces(aligned, step, counts)
    areas, centres = _centroids(pieces, sizes)
    kept = areas > COORDINATES * step.prod()
    pieces, sizes, cell, areas, centres = pieces[kept], sizes[kept], cell[kept], areas[kept], centres[kept]
    used, cell = np.unique(cell, return_inverse=True)
    total = np.bincount(cell, areas)
    point = np.column_stack([np.bincount(cell, areas * centres[:, k]) for k in range(2)]) / total[:, None]
    ragged = total < WHOLE * step.prod()
    largest = np.lexsort((areas, cell))[np.append(np.flatnonzero(np.diff(np.sort(cell))), len(cell) - 1)]
    point[ragged] = centres[largest[ragged]]

    def lift(flat: Float) -> Float:
        return np.asarray(origin + ((flat + low) @ axes) @ frame)

    starts = np.cumsum(sizes) - sizes
    vertices = lift(pieces[np.arange(pieces.shape[1]) < sizes[:, None]])
    fans, owner = [], []
    for k in range(1, pieces.shape[1] - 1):
        live = sizes > k + 1
        fans.append(np.column_stack([starts[live], starts[live] + k, starts[live] + k + 1]))
        owner.append(cell[live])
    count = len(used)
    triangles, cells = np.vstack(fans), np.concatenate(owner)
    return Cells(lift(point), np.tile(normal, (count, 1)), vertices, triangles, cells, np.zeros(count))


def _centroids(pieces: Float, sizes: Int) -> tuple[Float, Float]:
    """Return the areas (m,) and centroids (m, 2) of convex pieces (m, 8, 2) with ``sizes`` (m,) corners."""
    areas, centres = np.zeros(len(pieces)), np.zeros((len(pieces), 2))
    base = pieces[:, 0]
    for k in range(1, pieces.shape[1] - 1):
        live = k + 1 < sizes
        p, q = pieces[:, k] - base, pieces[:, k + 1] - base
        area = np.where(live, (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) / 2, 0)
        areas += area
        centres += np.where(live[:, None], area[:, None] * (p + q) / 3, 0)
    return np.abs(areas), base + centres / np.where(areas == 0, 1, areas)[:, None]


def _grid_pieces(triangles: Float, step: Float, counts: Int) -> tuple[Float, Int, Int]:
    """Cut triangles (n, 3, 2) by a grid; return the pieces (m, 8, 2), corner counts (m,) and cell numbers (m,)."""
    first = np.maximum(np.floor(triangles.min(1) / step - COORDINATES), 0).astype(np.int64)
    last = np.minimum(np.ceil(triangles.max(1) / step + COORDINATES), counts).astype(np.int64)
    return core.cut_by_grid(triangles, step, int(counts[1]), first, last)


def _clustered(surface: Surface, members: Int, spacing: float) -> Cells:
    """Return cells of triangles that are in the same cube of a lattice and have similar normals.

    The point of a cell is the centre of the triangle that is nearest to the centroid of the cell.
    """
    corners = surface.vertices[surface.faces[members]]
    normals = surface.normals[members]
    centres = corners.mean(1)
    keys = np.hstack([np.floor(centres / spacing + COORDINATES), np.round(normals * WAYS)]).astype(np.int64)
    _, cell = np.unique(keys, axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    _, nearest = _central(cell, surface.areas[members], centres)
    triangles = np.arange(3 * len(members)).reshape(-1, 3)
    return Cells(
        centres[nearest], unit(normals[nearest]), corners.reshape(-1, 3), triangles, cell, np.zeros(len(nearest))
    )


def _smoothed(surface: Surface, members: Int, spacing: float) -> Cells:
    """Return cells of triangles around evenly spread seeds; each belongs to the seed nearest in place and normal.

    The normal of a cell is the mean of its triangles, weighted by area. Its point is the centre of the triangle that is
    nearest to the centroid of the cell.
    """
    corners = surface.vertices[surface.faces[members]]
    normals, areas = surface.normals[members], surface.areas[members]
    centres = corners.mean(1)
    places = np.hstack([centres, FACING * spacing * normals])
    seeds = _spread(places, PACKED * spacing)
    _, cell = np.unique(search_tree(places[seeds]).query(places)[1], return_inverse=True)
    total, nearest = _central(cell, areas, centres)
    summed = np.column_stack([np.bincount(cell, areas * normals[:, k]) for k in range(3)])
    own = normals[nearest]
    smooth = unit(np.where(np.linalg.norm(summed, axis=1, keepdims=True) > LEAST_MEAN * total[:, None], summed, own))
    turned = np.degrees(np.arccos(np.clip((smooth * own).sum(1), -1, 1)))
    triangles = np.arange(3 * len(members)).reshape(-1, 3)
    return Cells(centres[nearest], smooth, corners.reshape(-1, 3), triangles, cell, turned)


def _central(cell: Int, areas: Float, centres: Float) -> tuple[Float, Int]:
    """Return the area (C,) [m²] of each cell, and the number (C,) of the triangle that is nearest to its centroid."""
    total = np.maximum(np.bincount(cell, areas), 1e-300)
    middle = np.column_stack([np.bincount(cell, areas * centres[:, k]) for k in range(3)]) / total[:, None]
    away = np.linalg.norm(centres - middle[cell], axis=1)
    order = np.lexsort((away, cell))
    return total, order[np.flatnonzero(np.diff(cell[order], prepend=-1))]


def _spread(places: Float, apart: float) -> Int:
    """Return the numbers of a maximal subset of the points (n, d) in which all distances exceed ``apart``.

    Points are tried in the order of their coordinates, which packs the subset densely.
    """
    tree = search_tree(places)
    free = np.ones(len(places), dtype=bool)
    chosen = []
    for k in np.lexsort(places.T[::-1]).tolist():
        if free[k]:
            chosen.append(k)
            free[tree.query_ball_point(places[k], apart)] = False
    return np.array(chosen, dtype=np.int64)


def _joined(parts: list[Cells]) -> Cells:
    """Join several sets of cells into one; vertices and cells are renumbered."""
    offsets = np.cumsum([0] + [len(part.vertices) for part in parts])
    numbers = np.cumsum([0] + [len(part.points) for part in parts])
    return Cells(
        np.vstack([part.points for part in parts]),
        np.vstack([part.normals for part in parts]),
        np.vstack([part.vertices for part in parts]),
        np.vstack([part.triangles + offset for part, offset in zip(parts, offsets, strict=False)]),
        np.concatenate([part.cell + number for part, number in zip(parts, numbers, strict=False)]),
        np.concatenate([part.turned for part in parts]),
    )
