"""The content of a heat-map picture as plain arrays, for all renderers."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from holdfast.drawing.colours import Kind, kinds_of


@dataclass(frozen=True)
class Solid:
    """A body, or a part of its surface, that is drawn without a value: fixed bodies and covered faces."""

    name: str
    vertices: NDArray[np.float64]  # (V, 3) world [m]
    triangles: NDArray[np.int64]  # (T, 3) indices into vertices, outward winding
    fixed: bool


@dataclass(frozen=True)
class HeatSurface:
    """The exposed surface of one body, cut into cells; each cell shows the answer at its query point."""

    name: str
    vertices: NDArray[np.float64]  # (V, 3) world [m]
    triangles: NDArray[np.int64]  # (T, 3) indices into vertices, outward winding
    cell: NDArray[np.int64]  # (T,) index of the triangle's cell, 0..C-1
    points: NDArray[np.float64]  # (C, 3) query point of each cell, world [m]
    force: NDArray[np.float64]  # (C,) robustness [N]; inf where no push moves anything
    hover: tuple[str, ...]  # (C,) text shown under the pointer, lines separated by "<br>"
    kinds: NDArray[np.int64] | None = None  # (C,) what each answer says; None where all forces are known

    @property
    def kind(self) -> NDArray[np.int64]:
        """The ``Kind`` of the answer of each cell (C,)."""
        return kinds_of(self.force) if self.kinds is None else self.kinds


@dataclass(frozen=True)
class Arrow:
    """An arrow from tail to head (3,) [m], world frame; it acts at its head."""

    tail: NDArray[np.float64]  # (3,)
    head: NDArray[np.float64]  # (3,)
    label: str


@dataclass(frozen=True)
class Picture:
    """A robustness map that is ready to draw.

    ``heat`` holds the coloured surfaces and ``solids`` the neutral ones. ``outlines`` are the contact patches as closed
    polylines (k, 3) [m], and ``contact_points`` (m, 3) [m] the contact nodes. ``contact_forces`` are arrows of the
    contact forces at rest, already scaled to metres. ``weakest`` are arrows of the weakest pushes, with their heads at
    the pushed points. ``up`` (3,) is the unit vector opposite to gravity.
    """

    title: str
    subtitle: str
    heat: tuple[HeatSurface, ...]
    solids: tuple[Solid, ...]
    outlines: tuple[NDArray[np.float64], ...] = ()
    contact_points: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    contact_forces: tuple[Arrow, ...] = ()
    weakest: tuple[Arrow, ...] = ()
    up: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    value_name: str = "largest push [N]"


def kinds(picture: Picture) -> NDArray[np.int64]:
    """Return the kinds (C,) of the answers of all cells of the picture."""
    return np.concatenate([*(surface.kind for surface in picture.heat), np.empty(0, dtype=np.int64)])


def legend(picture: Picture) -> dict[Kind, str]:
    """Return the names of the kinds of answers in the picture that are not on the scale, for its legend."""
    found = kinds(picture)
    unknown = int((found == Kind.UNDECIDED).sum())
    share = 100 * unknown / max(len(found), 1)
    names = {
        Kind.BALANCED: "moves at the smallest push (only balanced)",
        Kind.FALLS: "falls without a push",
        Kind.UNDECIDED: f"undecided: {unknown:,} of {len(found):,} ({share:.3g} %)",
        Kind.ENDLESS: "no push moves it (∞)",
        Kind.NONE: "no value",
    }
    return {kind: name for kind, name in names.items() if (found == kind).any()}
