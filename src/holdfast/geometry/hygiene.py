"""Repair of meshes for contact detection: vertices are welded, repeated faces removed, faces wound outward."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.errors import GeometryError, message
from holdfast.base.public import Record
from holdfast.geometry.solid import joined, parts_as_given, parts_by_winding
from holdfast.geometry.triangles import Edges, area_vectors

if TYPE_CHECKING:
    import trimesh

LEAST_ROUND = 0.005  # volume / area^(3/2), 0.094 for a ball; an open piece with less has no definite inside
SCRAP = 0.01  # share of the total area; smaller pieces without an inside do not make a scan's orientation unknown
FOLD = 1e-5  # share of the total area; a repeated face that bounds nothing is only removed if it is smaller


class PlaneFit(Record):
    """A flat region of a noisy mesh.

    ``normal`` (3,) and ``offset`` [m] define its plane normal · x = offset in the body frame, and ``area`` [m²] is that
    of the region. ``residual`` [m] is the root mean square distance of its vertices from the plane, and ``worst`` [m]
    the largest.
    """

    normal: tuple[float, float, float]
    offset: float
    area: float
    residual: float
    worst: float


class MeshReport(Record):
    """What a mesh was like and what was done about it.

    The counts are: vertices ``welded``, ``degenerate`` and ``duplicate`` faces removed (both faces of a fold), faces
    ``flipped`` to point outward, ``open_edges`` with one face, ``crowded_edges`` with more than two faces, connected
    ``pieces``, and closed parts ``joined`` to one solid because they touched or overlapped; ``shared`` [m³] is the
    volume that they had in common. The other counts are those before parts were joined. ``oriented`` is True if it is
    known which side is the inside. ``planes`` are the flat regions that were fitted if the mesh was given as noisy.
    """

    welded: int = 0
    degenerate: int = 0
    duplicate: int = 0
    flipped: int = 0
    open_edges: int = 0
    crowded_edges: int = 0
    pieces: int = 1
    oriented: bool = True
    planes: tuple[PlaneFit, ...] = ()
    joined: int = 0
    shared: float = 0.0

    @property
    def closed(self) -> bool:
        """Whether the surface bounds a volume."""
        return not self.open_edges and not self.crowded_edges

    def __str__(self) -> str:
        counts = {
            "vertices welded": self.welded,
            "degenerate faces left out": self.degenerate,
            "duplicate faces left out": self.duplicate,
            "faces turned outward": self.flipped,
            "open edges": self.open_edges,
            "edges with more than two faces": self.crowded_edges,
            "closed parts joined": self.joined,
        }
        findings = [f"{count} {what}" for what, count in counts.items() if count]
        findings += [f"they overlapped by {self.shared:.3g} m³"] if self.shared else []
        findings += [] if self.oriented else ["which side is the inside is not known"]
        if self.planes:
            worst = max(plane.residual for plane in self.planes)
            findings.append(f"{len(self.planes)} planes fitted, residual up to {worst * 1e3:.3g} mm")
        return f"{self.pieces} {'piece' if self.pieces == 1 else 'pieces'}; " + (
            "; ".join(findings) or "nothing to mend"
        )


def cleaned(vertices: Float, faces: Int, where: str) -> tuple[trimesh.Trimesh, MeshReport]:
    """Return the mesh welded, without degenerate or repeated faces, wound outward where possible; and a report.

    Closed parts that share edges or faces are separated, and those that touch or overlap are joined to one solid.
    Raises GeometryError if no triangle has an area; ``where`` names the mesh.
    """
    import trimesh

    solid = trimesh.Trimesh(vertices, faces, process=False)
    solid.merge_vertices(merge_tex=True, merge_norm=True)
    points, merged = np.array(solid.vertices), np.array(solid.faces, dtype=np.int64)
    welded = len(np.unique(faces)) - len(np.unique(solid.faces))
    corners = np.sort(solid.faces, axis=1)
    # needles stay, as they connect a mesh
    proper, unique = (corners[:, 1:] != corners[:, :-1]).all(1), solid.unique_faces()
    unique &= ~_folds(corners, proper, unique, np.asarray(solid.area_faces))
    solid.update_faces(proper & unique)
    solid.remove_unreferenced_vertices()
    if len(solid.faces) == 0 or not solid.area > 0:
        raise GeometryError(message(where, f"all {len(faces)} triangles are degenerate", "needs a surface with area"))
    report = MeshReport(welded, int((~proper).sum()), int((proper & ~unique).sum()))
    report = _oriented(solid, report)
    if report.crowded_edges and not report.open_edges:
        solid, report = _separated(points, faces, merged) or (solid, report)
    return (solid, report) if report.pieces < 2 or not report.closed else _joined(solid, report)


def _folds(corners: Int, proper: Bool, unique: Bool, areas: Float) -> Bool:
    """Mark those of the ``unique`` faces (F,) that lie back to back with another face and bound nothing.

    After vertices were merged, a scan may have pairs of needles with the same ``corners`` (F, 3), which hang on an edge
    of a surface that is closed without them. If only one of the two was removed, the other would leave open edges, and
    the body would have no inside.
    """
    folds = np.zeros(len(corners), dtype=bool)
    repeated = set(map(tuple, corners[proper & ~unique].tolist()))
    if not repeated:
        return folds
    once = np.flatnonzero(proper & unique)
    edges = Edges.of(corners[once], int(corners.max()) + 1)
    beside = edges.shared[edges.of_face]
    hanging = (beside != 2).all(1) & (beside == 1).any(1) & (beside == 3).any(1)
    small = areas[once] < FOLD * float(areas[once].sum())
    for face in once[hanging & small].tolist():
        folds[face] = tuple(corners[face].tolist()) in repeated
    return folds


def _separated(points: Float, faces: Int, merged: Int) -> tuple[trimesh.Trimesh, MeshReport] | None:
    """Return the mesh as closed parts that share no vertices, with a report; None if it does not consist of such parts.

    ``faces`` (F, 3) are those given, and ``merged`` (F, 3) the same faces over the welded ``points`` (V, 3). Parts are
    separated by the given vertex numbers or, if that fails, by the winding of the faces.
    """
    import trimesh

    proper = (np.sort(merged, axis=1)[:, 1:] != np.sort(merged, axis=1)[:, :-1]).all(1)
    faces, merged = faces[proper], merged[proper]
    parts = parts_as_given(faces, merged) or parts_by_winding(points, merged)
    if parts is None:
        return None
    origin, numbers = parts
    solid = trimesh.Trimesh(points[origin], numbers, process=False)
    welded = max(len(np.unique(faces)) - len(origin), 0)
    found = _oriented(solid, MeshReport(welded, int((~proper).sum()), len(faces) - len(numbers)))
    return (solid, found) if found.closed else None


def _joined(solid: trimesh.Trimesh, report: MeshReport) -> tuple[trimesh.Trimesh, MeshReport]:
    """Join the closed parts that touch or overlap to one solid."""
    import trimesh

    found = joined(np.array(solid.vertices), np.array(solid.faces, dtype=np.int64))
    if found is None:
        return solid, report
    vertices, faces, parts, shared = found
    return trimesh.Trimesh(vertices, faces, process=False), replace(report, joined=parts, shared=shared)


def _oriented(solid: trimesh.Trimesh, report: MeshReport) -> MeshReport:
    """Wind neighbouring faces consistently, then every piece outward, in place; return the completed report."""
    faces = np.array(solid.faces, dtype=np.int64)
    count = len(faces)
    edges = Edges.of(faces, len(solid.vertices))
    first = edges.first[edges.shared == 2]
    one, two = edges.sides[first], edges.sides[first + 1]
    starts = faces.ravel()
    against = starts[one] == starts[two]  # neighbours that are wound alike traverse their edge in opposite directions
    one, two = one // 3, two // 3
    graph = coo_matrix((np.ones(len(one)), (one, two)), shape=(count, count)).tocsr()
    pieces, label = connected_components(graph, directed=False)
    labels: Int = label.astype(np.int64)
    flip, sound = np.zeros(count, dtype=bool), True
    if against.any():
        flip = _parity(graph, one, two, against, labels, pieces)
        sound = bool((against == (flip[one] ^ flip[two])).all())
    rims = np.bincount(labels[(edges.shared[edges.of_face] != 2).any(1)], minlength=pieces)
    sound &= _turn_pieces(np.array(solid.vertices), faces, flip, labels, rims == 0)
    faces[flip] = faces[flip][:, ::-1]
    solid.faces = faces
    return replace(
        report,
        flipped=int(flip.sum()),
        open_edges=int((edges.shared == 1).sum()),
        crowded_edges=int((edges.shared > 2).sum()),
        pieces=int(pieces),
        oriented=sound,
    )


def _parity(graph: csr_matrix, one: Int, two: Int, against: Bool, labels: Int, pieces: int) -> Bool:
    """Mark the faces (F,) to flip so that neighbours agree; in each piece, the minority is flipped."""
    count = graph.shape[0]
    differ = coo_matrix((np.where(against, 2.0, 1.0), (one, two)), shape=(count, count)).tocsr()
    differ = (differ + differ.T).tocsr()
    flip = np.zeros(count, dtype=bool)
    for piece in range(pieces):
        members = np.flatnonzero(labels == piece)
        order, before = breadth_first_order(differ, members[0], directed=False)
        for face in order[1:]:
            flip[face] = flip[before[face]] ^ (differ[before[face], face] == 2.0)
        if flip[members].sum() > len(members) / 2:
            flip[members] ^= True
    return flip


def _turn_pieces(vertices: Float, faces: Int, flip: Bool, labels: Int, closed: Bool) -> bool:
    """Mark in ``flip`` (F,) the pieces that are inside out; tell whether the inside of all pieces is known.

    ``labels`` (F,) is the piece of each face, and ``closed`` (pieces,) tells which pieces have no rim. A closed shell
    inside another one is a cavity and stays as it is. An open piece is judged by the volume that it nearly encloses.
    """
    sign = np.where(flip, -1.0, 1.0)
    corners = vertices[faces]
    vectors = area_vectors(vertices, faces)
    areas = np.linalg.norm(vectors, axis=1)
    known = True
    boxes = []
    for piece in range(len(closed)):
        mine = corners[labels == piece]
        boxes.append((mine.min((0, 1)), mine.max((0, 1))))
    for piece in range(len(closed)):
        members = labels == piece
        centre = corners[members].mean((0, 1))
        volume = float((sign[members] * ((corners[members, 0] - centre) * vectors[members]).sum(1)).sum()) / 3
        low, high = boxes[piece]
        inside = any((lo < low).all() and (high < hi).all() for k, (lo, hi) in enumerate(boxes) if k != piece)
        if not closed[piece]:
            area = float(areas[members].sum())
            if abs(volume) < LEAST_ROUND * area**1.5:
                known &= area < SCRAP * float(areas.sum())
                continue
        if volume < 0 and not inside:
            flip[members] ^= True
    return known
