"""The content of a heat-map picture as plain arrays, which both renderers take."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


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
    the pushed points. ``up`` (3,) is the unit vector opposite to gravity, and ``zero_name`` says what a force of 0
    means here.
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
    zero_name: str = "moves without a push (0)"
