"""A small z-buffer rasteriser, which finds the visible triangle at each pixel and the lines to draw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.native import core

PLAIN: Final = 0  # kind of line at a pixel: no line
CREASE: Final = 1  # kind of line at a pixel: the surface bends
OUTLINE: Final = 2  # kind of line at a pixel: the border of a body

# cosine of the smallest bend that is drawn; curved sides bend by less
CREASE_COSINE: Final = float(np.cos(np.deg2rad(24.0)))
_STEP_PIXELS: Final = 3.0  # least difference of depth that is drawn as an edge [px]
_NOTHING: Final = -1  # triangle index of an empty pixel


@dataclass(frozen=True)
class Layer:
    """What is visible at each pixel (H, W): triangle index (-1: nothing), depth [m] (inf: nothing) and kind of line."""

    triangle: NDArray[np.int64]
    depth: NDArray[np.float64]
    line: NDArray[np.uint8]


def rasterise(
    pixels: NDArray[np.float64],
    triangles: NDArray[np.int64],
    normals: NDArray[np.float64],
    body: NDArray[np.int64],
    scale: float,
    shape: tuple[int, int],
) -> Layer:
    """Draw triangles (T, 3) of projected vertices (V, 3: column, row, depth [m]) into a panel of (rows, columns).

    ``normals`` (T, 3) are in screen axes: right, up, towards the viewer. Of two triangles at the same depth, the one
    that faces the viewer is visible. ``body`` (T,) is the number of each triangle's body, for the outlines. ``scale``
    is in pixels per metre.
    """
    depth = np.full(shape, np.inf)
    seen = np.full(shape, _NOTHING, dtype=np.int64)
    behind = np.where(normals[:, 2] < 0.0, 0.5 / scale, 0.0)
    core.fill_triangles(np.ascontiguousarray(pixels), np.ascontiguousarray(triangles), behind, depth, seen)
    line = np.zeros(shape, dtype=np.uint8)
    core.draw_lines(seen, depth, np.ascontiguousarray(normals), body, scale, CREASE_COSINE, _STEP_PIXELS, line)
    return Layer(seen, depth, line)
