"""Small pictures of scenes for pages, as PNG files made without matplotlib."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.drawing import colours
from holdfast.drawing.camera import fit, front_view, heat_points
from holdfast.drawing.picture import Picture, Solid
from holdfast.drawing.shade import render
from holdfast.drawing.soup import fixed, forces, movable, soup_of

MOVABLE: Final = (0.83, 0.86, 0.91)
MOVING: Final = (0.93, 0.45, 0.36)
FIXED: Final = (0.72, 0.72, 0.70)
MARGIN: Final = 8.0  # around the bodies [px]


def thumbnail(
    solids: Sequence[Solid], up: NDArray[np.float64], moving: Collection[str], size: tuple[int, int] = (240, 180)
) -> bytes:
    """Return a picture of (width, height) pixels as a PNG file; the bodies whose names are ``moving`` are coloured.

    ``up`` (3,) is the unit vector opposite to gravity. Fixed bodies fade out with their distance from the others.
    """
    free = [solid for solid in solids if not solid.fixed]
    picture = Picture("", "", heat=(), solids=tuple(free or solids), up=up)
    view = front_view(picture)
    points = np.concatenate([solid.vertices for solid in picture.solids])
    camera = fit(view, points, size[0], size[1], MARGIN)
    shown = soup_of(picture.solids, lambda solid: MOVING if solid.name in moving else MOVABLE)
    held = soup_of([solid for solid in solids if solid.fixed], lambda solid: FIXED) if free else None
    image = render(shown, held, camera, (size[1], size[0])).image
    return png_bytes(np.rint(image * 255).astype(np.uint8))


def map_thumbnail(picture: Picture, size: tuple[int, int]) -> bytes:
    """Return the map of a picture from the front, in (width, height) pixels, as a PNG file."""
    camera = fit(front_view(picture), heat_points(picture), size[0], size[1], MARGIN)
    soup = movable(picture, colours.scale_of(forces(picture)))
    image = render(soup, fixed(picture), camera, (size[1], size[0])).image
    return png_bytes(np.rint(image * 255).astype(np.uint8))


def png_bytes(image: NDArray[np.uint8]) -> bytes:
    """Return an image (rows, columns, 3) as a PNG file: 8 bits for each of red, green and blue."""
    rows, columns, _ = image.shape
    # Every line except the first is stored as the difference from the line above (filter 2), zero in flat areas.
    step = np.diff(image.reshape(rows, -1), axis=0, prepend=np.zeros((1, image[0].size), dtype=np.uint8))
    lines = np.concatenate([np.full((rows, 1), 2, dtype=np.uint8), step], axis=1)
    header = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, content) for kind, content in parts)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
