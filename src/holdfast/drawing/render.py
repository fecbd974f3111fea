"""Bodies as pixels: triangles are rasterised with the lines of their surfaces, and shaded; small pictures as PNG."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import Float, Int, unit
from holdfast.drawing import colours
from holdfast.drawing.camera import Camera, View, fit, front_view
from holdfast.drawing.picture import Picture, Solid, Soup, fixed, forces, heat_points, movable, soup_of
from holdfast.native import core

PLAIN: Final = 0  # kind of line at a pixel: no line
CREASE: Final = 1  # kind of line at a pixel: the surface bends
OUTLINE: Final = 2  # kind of line at a pixel: the border of a body

# cosine of the smallest bend that is drawn; curved sides bend by less
CREASE_COSINE: Final = float(np.cos(np.deg2rad(24.0)))
_STEP_PIXELS: Final = 3.0  # least difference of depth that is drawn as an edge [px]
_NOTHING: Final = -1  # triangle index of an empty pixel
SHADE_LOSS: Final = 0.12  # share of the brightness that a face turned away from the light loses
_SAMPLES: Final = 2  # samples per pixel along each side, for anti-aliasing
_INK: Final = np.array([0.10, 0.11, 0.14], dtype=np.float32)  # colour of lines
_HATCH: Final = (10, 0.62)  # distance of hatching lines [px], and their brightness relative to the surface
_LIGHT_INK: Final = np.array([0.85, 0.80, 0.82], dtype=np.float32)  # colour of creases on dark surfaces
_LUMINANCE: Final = np.array([0.30, 0.59, 0.11], dtype=np.float32)  # weights of red, green and blue in the luminance
_DARK: Final = 0.27  # luminance below which a surface counts as dark
_STRENGTH: Final = {CREASE: 0.42, OUTLINE: 0.85}  # opacity of each kind of line
_FIXED_STRENGTH: Final = 0.30  # opacity of lines on fixed bodies, relative to that on movable ones
_FIXED_VEIL: Final = 0.30  # opacity of a fixed body in front of a movable one
# distances at which fixed bodies begin to fade and have vanished, relative to the size of the movable ones
_FADE: Final = (0.10, 0.75)
# of the bodies in small pictures
_MOVABLE: Final = (0.83, 0.86, 0.91)
_MOVING: Final = (0.93, 0.45, 0.36)
_FIXED: Final = (0.72, 0.72, 0.70)
_MARGIN: Final = 8.0  # around the bodies [px]


@dataclass(frozen=True)
class Layer:
    """What is visible at each pixel (H, W): triangle index (-1: nothing), depth [m] (inf: nothing) and kind of line."""

    triangle: Int
    depth: Float
    line: NDArray[np.uint8]


def rasterise(
    pixels: Float,
    triangles: Int,
    normals: Float,
    body: Int,
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


@dataclass(frozen=True)
class Panel:
    """A drawn panel: its image (H, W, 3) in 0..1, and what is at each pixel.

    ``depth`` (H, W) [m] is that of movable bodies, inf where there is none; ``body`` (H, W) is the number of the
    movable body, -1 where there is none.
    """

    image: Float
    depth: Float
    body: Int


def render(
    movable: Soup,
    fixed: Soup | None,
    camera: Camera,
    shape: tuple[int, int],
    ghost: bool = False,
    focus: Float | None = None,
) -> Panel:
    """Draw movable and fixed bodies into a panel of (rows, columns).

    Fixed bodies fade out with their distance from the movable ones.

    ``ghost`` draws the movable bodies pale, as a backdrop for contacts inside them. If ``focus`` (N, 3) [m] is given,
    the fixed bodies fade out with their distance from these points instead.
    """
    fine = Camera(camera.view, camera.origin, camera.scale * _SAMPLES)
    size = (shape[0] * _SAMPLES, shape[1] * _SAMPLES)
    front = _layer(movable, fine, size)
    if ghost:
        pale = np.tile([0.955, 0.96, 0.968], (len(movable.triangles), 1))
        image = _lookup(pale * light(movable.normals, camera.view)[:, None] ** 0.5, front)
    else:
        image = _lookup(_paint(movable, camera.view), front)
        undecided = np.append((movable.rgb == colours.UNDECIDED).all(axis=1), False)
        down, across = (np.arange(size) for size in image.shape[:2])
        distance, darkness = _HATCH
        lines = (down[:, None] + across) // _SAMPLES % distance < distance // 4
        image[undecided[front.triangle] & lines] *= np.float32(darkness)  # -1 picks the last row
    image = _ink(image, front, 0.45 if ghost else 1.0)
    if fixed is not None and len(fixed.triangles):
        image = _with_fixed(image, front, fixed, fine, movable.vertices if focus is None else focus)
    rows, columns = shape
    pooled = image.reshape(rows, _SAMPLES, columns, _SAMPLES, 3).mean(axis=(1, 3))
    body = np.append(movable.body, -1)[front.triangle]  # -1 picks the last one
    return Panel(pooled.astype(float), front.depth[::_SAMPLES, ::_SAMPLES], body[::_SAMPLES, ::_SAMPLES])


def light(normals: Float, view: View) -> Float:
    """Return the brightness (T,) of faces by their normals (T, 3), between 1 - SHADE_LOSS and 1.

    The light is beside the viewer.
    """
    lamp = unit(0.55 * view.toward + 0.75 * view.up - 0.45 * view.right)
    return np.asarray(1.0 - SHADE_LOSS * (1.0 - np.clip(normals @ lamp, 0.0, 1.0)), dtype=float)


def _paint(soup: Soup, view: View) -> Float:
    away = soup.normals @ view.toward < 0.0
    rgb = np.where(away[:, None], np.asarray(colours.COVERED), soup.rgb)
    return rgb * light(soup.normals, view)[:, None]


def _layer(soup: Soup, camera: Camera, size: tuple[int, int]) -> Layer:
    axes = np.stack([camera.view.right, camera.view.up, camera.view.toward], axis=1)
    return rasterise(camera.pixels(soup.vertices), soup.triangles, soup.normals @ axes, soup.body, camera.scale, size)


def _lookup(paint: Float, layer: Layer) -> NDArray[np.float32]:
    """Return the colour of what is at each pixel: that of its triangle, or white."""
    table = np.concatenate([paint, np.ones((1, 3))]).astype(np.float32)
    return table[layer.triangle]  # the index -1 of empty pixels picks the last row


def _ink(image: NDArray[np.float32], layer: Layer, amount: float) -> NDArray[np.float32]:
    for kind, strength in _STRENGTH.items():
        drawn = layer.line == kind
        under = image[drawn]
        # Creases are drawn light on dark surfaces, where dark lines would not be visible.
        dark = (under @ _LUMINANCE < _DARK) & (kind == CREASE)
        ink = np.where(dark[:, None], _LIGHT_INK, _INK)
        image[drawn] = under + np.float32(strength * amount) * (ink - under)
    return image


def _with_fixed(
    image: NDArray[np.float32], front: Layer, fixed: Soup, camera: Camera, focus: Float
) -> NDArray[np.float32]:
    """Return the image with fixed bodies around those in ``front``, fading away from ``focus`` (N, 3) [m].

    Before movable bodies they are a veil; behind them, and under their outlines, they are hidden.
    """
    size = (image.shape[0], image.shape[1])
    layer = _layer(fixed, camera, size)
    colour = _ink(_lookup(_paint(fixed, camera.view), layer), layer, _FIXED_STRENGTH)
    cover = np.zeros(size, dtype=np.float32)
    rows, columns = np.nonzero(layer.triangle >= 0)
    world = camera.world(np.column_stack([columns + 0.5, rows + 0.5, layer.depth[rows, columns]]))
    cover[rows, columns] = _fade(world, focus)
    veils = (front.triangle >= 0) & (layer.depth < front.depth - 1.0 / camera.scale)
    cover[veils] *= _FIXED_VEIL
    cover[(front.triangle >= 0) & ~veils] = 0.0
    edge = (front.triangle < 0) & (front.line > 0)
    cover[edge] = 0.0
    return image + cover[:, :, None] * (colour - image)


def _fade(world: Float, focus: Float) -> Float:
    if not len(focus):  # without movable bodies, fixed ones do not fade
        return np.ones(len(world))
    low, high = focus.min(axis=0), focus.max(axis=0)
    beyond = np.maximum(np.maximum(low - world, world - high), 0.0)
    reach = np.linalg.norm(beyond, axis=1) / max(float(np.linalg.norm(high - low)), 1e-12)
    ramp = np.clip((_FADE[1] - reach) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
    return np.asarray(ramp * ramp * (3.0 - 2.0 * ramp), dtype=float)


def thumbnail(solids: Sequence[Solid], up: Float, moving: Collection[str], size: tuple[int, int] = (240, 180)) -> bytes:
    """Return a picture of (width, height) pixels as a PNG file; the bodies whose names are ``moving`` are coloured.

    ``up`` (3,) is the unit vector opposite to gravity. Fixed bodies fade out with their distance from the others.
    """
    free = [solid for solid in solids if not solid.fixed]
    picture = Picture("", "", heat=(), solids=tuple(free or solids), up=up)
    shown = soup_of(picture.solids, lambda solid: _MOVING if solid.name in moving else _MOVABLE)
    still = soup_of([solid for solid in solids if solid.fixed], lambda solid: _FIXED) if free else None
    return _from_front(picture, shown, still, size)


def map_thumbnail(picture: Picture, size: tuple[int, int]) -> bytes:
    """Return the map of a picture from the front, in (width, height) pixels, as a PNG file."""
    return _from_front(picture, movable(picture, colours.scale_of(forces(picture))), fixed(picture), size)


def _from_front(picture: Picture, shown: Soup, still: Soup | None, size: tuple[int, int]) -> bytes:
    camera = fit(front_view(picture), heat_points(picture), size[0], size[1], _MARGIN)
    image = render(shown, still, camera, (size[1], size[0])).image
    return png_bytes(np.rint(image * 255).astype(np.uint8))


def png_bytes(image: NDArray[np.uint8]) -> bytes:
    """Return an image (rows, columns, 3) as a PNG file: 8 bits for each of red, green and blue."""
    rows, columns, _ = image.shape
    # Every line except the first is stored as the difference from the line above (filter 2), zero in flat areas.
    step = np.diff(image.reshape(rows, -1), axis=0, prepend=np.zeros((1, image[0].size), dtype=np.uint8))
    lines = np.concatenate([np.full((rows, 1), 2, dtype=np.uint8), step], axis=1)
    header = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 9)), (b"IEND", b""))
    chunks = (
        struct.pack(">I", len(text)) + kind + text + struct.pack(">I", zlib.crc32(kind + text)) for kind, text in parts
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
