"""The faces of a plane contact, as native/bed.hpp reads them, which finds the pressure on them and their friction."""

from __future__ import annotations

from typing import NamedTuple

from holdfast.base.arrays import Float, Int


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
