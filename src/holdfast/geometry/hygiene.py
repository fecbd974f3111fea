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

if TYPE_CHECKING:
    import trimesh

LEAST_ROUND = 0.005  # of area to the power 3/2 (a ball has 0.094): an open piece with less volume has no inside

SCRAP = 0.01  # of the whole area: loose pieces of a scan with less do not put its orientation in doubt


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

    Counts: vertices ``welded``, ``degenerate`` and ``duplicate`` faces left out, faces ``flipped`` to face outward,
    ``open_edges`` with one face, ``crowded_edges`` with more than two, connected ``pieces``. ``oriented``: it is known
    which side is the inside. ``planes`` were fitted where the mesh was said to be noisy.
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
        }
        told = [f"{count} {what}" for what, count in counts.items() if count]
        told += [] if self.oriented else ["which side is the inside is not known"]
        if self.planes:
            worst = max(plane.residual for plane in self.planes)
            told.append(f"{len(self.planes)} planes fitted, residual up to {worst * 1e3:.3g} mm")
        return f"{self.pieces} {'piece' if self.pieces == 1 else 'pieces'}; " + ("; ".join(told) or "nothing to mend")


def cleaned(vertices: Float, faces: Int, where: str) -> tuple[trimesh.Trimesh, MeshReport]:
    """The mesh welded, without degenerate or repeated faces, wound outward as far as that can be told."""
    import trimesh

    solid = trimesh.Trimesh(vertices, faces, process=False)
    solid.merge_vertices(merge_tex=True, merge_norm=True)
    welded = len(np.unique(faces)) - len(np.unique(solid.faces))
    corners = np.sort(solid.faces, axis=1)
    proper, unique = (corners[:, 1:] != corners[:, :-1]).all(1), solid.unique_faces()  # needles hold a mesh together
    solid.update_faces(proper & unique)
    solid.remove_unreferenced_vertices()
    if len(solid.faces) == 0 or not solid.area > 0:
        raise GeometryError(message(where, f"all {len(faces)} triangles are degenerate", "needs a surface with area"))
    report = MeshReport(welded, int((~proper).sum()), int((proper & ~unique).sum()))
    return solid, _oriented(solid, report)


def _oriented(solid: trimesh.Trimesh, report: MeshReport) -> MeshReport:
    """Wind neighbouring faces alike, then every piece outward, in place."""
    faces = np.array(solid.faces)
    half = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = half.min(1) * len(solid.vertices) + half.max(1)
    _, inverse, shared = np.unique(keys, return_inverse=True, return_counts=True)
    order = np.argsort(inverse, kind="stable")
    first = np.concatenate([[0], np.cumsum(shared)[:-1]])[shared == 2]
    one, two = order[first], order[first + 1]
    against = half[one, 0] == half[two, 0]  # neighbours wound alike run along their edge in opposite senses
    count = len(faces)
    graph = coo_matrix((np.ones(len(one)), (one // 3, two // 3)), shape=(count, count)).tocsr()
    pieces, label = connected_components(graph, directed=False)
    labels: Int = label.astype(np.int64)
    flip, sound = np.zeros(count, dtype=bool), True
    if against.any():
        flip = _parity(graph, one // 3, two // 3, against, labels, pieces)
        sound = bool((against == (flip[one // 3] ^ flip[two // 3])).all())
    corners = solid.triangles
    rims = np.bincount(labels[np.arange(count).repeat(3)[(shared[inverse] != 2)]], minlength=pieces)
    sound &= _turn_pieces(corners, flip, labels, pieces, rims == 0)
    faces[flip] = faces[flip][:, ::-1]
    solid.faces = faces
    open_edges, crowded = int((shared == 1).sum()), int((shared > 2).sum())
    return replace(
        report,
        flipped=int(flip.sum()),
        open_edges=open_edges,
        crowded_edges=crowded,
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


def _turn_pieces(corners: Float, flip: Bool, labels: Int, pieces: int, closed: Bool) -> bool:
    """Turn pieces that are inside out, in ``flip`` (F,); whether it is known of all which side is the inside.

    A closed shell inside another stays as it is: it is a cavity. An open piece counts by the volume it nearly bounds.
    """
    sign = np.where(flip, -1.0, 1.0)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(cross, axis=1) / 2
    known = True
    boxes = []
    for piece in range(pieces):
        mine = corners[labels == piece]
        boxes.append((mine.min((0, 1)), mine.max((0, 1))))
    for piece in range(pieces):
        members = labels == piece
        centre = corners[members].mean((0, 1))
        volume = float((sign[members] * ((corners[members, 0] - centre) * cross[members]).sum(1)).sum()) / 6
        low, high = boxes[piece]
        inside = any((lo < low).all() and (high < hi).all() for k, (lo, hi) in enumerate(boxes) if k != piece)
        if not closed[piece]:
            area = float(sizes[members].sum())
            if abs(volume) < LEAST_ROUND * area**1.5:
                known &= area < SCRAP * float(sizes.sum())
                continue
        if volume < 0 and not inside:
            flip[members] ^= True
    return known
