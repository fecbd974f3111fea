"""The faces of a plane contact, as native/bed.hpp reads them, which finds the pressure on them and their friction."""

from __future__ import annotations

from typing import NamedTuple

from holdfast.base.arrays import Float


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
