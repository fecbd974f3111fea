"""Meshes as they come, made fit for contact: welded, without doubles, wound outward; and what was done to them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from holdfast.base.archive import archived
from holdfast.base.arrays import Bool, Float, Int
from holdfast.base.errors import GeometryError, message
from holdfast.base.values import Value
from holdfast.geometry.area import area_vectors
from holdfast.geometry.closed_parts import joined, parts_as_given, parts_by_winding
from holdfast.geometry.topology import Edges

if TYPE_CHECKING:
    import trimesh

LEAST_ROUND = 0.005  # volume over area^(3/2), 0.094 for a ball: an open piece with less has no inside to speak of
SCRAP = 0.01  # share of the whole area: smaller pieces that have no inside do not put a scan's orientation in doubt
FOLD = 1e-5  # share of the whole area: a repeated face that bounds nothing is a sheet of its own if it is larger


@archived
@dataclass(frozen=True, eq=False, repr=False)
class PlaneFit(Value):
    """A flat region found in a noisy mesh.

    ``normal`` (3,) and ``offset`` [m] of the plane normal · x = offset in the body frame, the region's ``area`` [m²],
    and how far its vertices were from the plane: root mean square ``residual`` and ``worst`` [m].
    """

    normal: tuple[float, float, float]
    offset: float
    area: float
    residual: float
    worst: float


@archived
@dataclass(frozen=True, eq=False, repr=False)
class MeshReport(Value):
    """What a mesh was like and what was done about it.

    Counts: vertices ``welded``, ``degenerate`` and ``duplicate`` faces left out (of a fold both), faces ``flipped`` to
    face outward, ``open_edges`` with one face, ``crowded_edges`` with more than two, connected ``pieces``.
    ``oriented``: it is known which side is the inside. ``planes`` were fitted where the mesh was said to be noisy.
    ``joined`` closed parts that touched or overlapped were made one solid, which has ``shared`` [m³] less volume than
    they had together; the other counts are those before that.
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
        told = [f"{count} {what}" for what, count in counts.items() if count]
        told += [f"they overlapped by {self.shared:.3g} m³"] if self.shared else []
        told += [] if self.oriented else ["which side is the inside is not known"]
        if self.planes:
            worst = max(plane.residual for plane in self.planes)
            told.append(f"{len(self.planes)} planes fitted, residual up to {worst * 1e3:.3g} mm")
        return f"{self.pieces} {'piece' if self.pieces == 1 else 'pieces'}; " + ("; ".join(told) or "nothing to mend")


def cleaned(vertices: Float, faces: Int, where: str) -> tuple[trimesh.Trimesh, MeshReport]:
    """The mesh welded, without degenerate or repeated faces, wound outward as far as that can be told.

    Closed parts that share edges or faces are told apart, and those that touch or overlap are joined to one solid.
    """
    import trimesh

    solid = trimesh.Trimesh(vertices, faces, process=False)
    solid.merge_vertices(merge_tex=True, merge_norm=True)
    points, merged = np.array(solid.vertices), np.array(solid.faces, dtype=np.int64)
    welded = len(np.unique(faces)) - len(np.unique(solid.faces))
    corners = np.sort(solid.faces, axis=1)
    proper, unique = (corners[:, 1:] != corners[:, :-1]).all(1), solid.unique_faces()  # needles hold a mesh together
    unique &= ~_folds(corners, proper, unique, np.asarray(solid.area_faces))
    solid.update_faces(proper & unique)
    solid.remove_unreferenced_vertices()
    if len(solid.faces) == 0 or not solid.area > 0:
        raise GeometryError(message(where, f"all {len(faces)} triangles are degenerate", "needs a surface with area"))
    report = MeshReport(welded, int((~proper).sum()), int((proper & ~unique).sum()))
    report = _oriented(solid, report)
    if report.crowded_edges and not report.open_edges:
        solid, report = _told_apart(points, faces, merged) or (solid, report)
    return (solid, report) if report.pieces < 2 or not report.closed else _joined(solid, report)


def _folds(corners: Int, proper: Bool, unique: Bool, areas: Float) -> Bool:
    """(F,) those of the ``unique`` faces that lie back to back with another one and bound nothing.

    A scan whose vertices were merged has pairs of needles with the same ``corners`` (F, 3), which hang on an edge of a
    surface that is closed without them. One of the two alone would leave open edges there, and the body no inside.
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


def _told_apart(points: Float, faces: Int, merged: Int) -> tuple[trimesh.Trimesh, MeshReport] | None:
    """The mesh as closed parts that share no vertices, and a report on it; None if it is not made of such parts.

    ``faces`` (F, 3) are those given, and ``merged`` (F, 3) the same after ``points`` (V, 3) at the same place were
    welded. The parts are those that the given vertex numbers hold together or, failing that, what the winding tells.
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
    """One solid of the closed parts that touch or overlap."""
    import trimesh

    found = joined(np.array(solid.vertices), np.array(solid.faces, dtype=np.int64))
    if found is None:
        return solid, report
    one = trimesh.Trimesh(found.vertices, found.faces, process=False)
    return one, replace(report, joined=found.parts, shared=found.shared)


def _oriented(solid: trimesh.Trimesh, report: MeshReport) -> MeshReport:
    """Wind neighbouring faces alike, then every piece outward, in place."""
    faces = np.array(solid.faces, dtype=np.int64)
    count = len(faces)
    edges = Edges.of(faces, len(solid.vertices))
    first = edges.first[edges.shared == 2]
    one, two = edges.sides[first], edges.sides[first + 1]
    starts = faces.ravel()
    against = starts[one] == starts[two]  # neighbours wound alike run along their edge in opposite senses
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
    """(F,) faces to turn so that neighbours agree; in each piece those that are fewer."""
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
    """Turn pieces that are inside out, in ``flip`` (F,); whether it is known of all which side is the inside.

    ``labels`` (F,) number the pieces, ``closed`` (pieces,) those without a rim. A closed shell inside another stays as
    it is: it is a cavity. An open piece is turned by the volume that it nearly bounds.
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
