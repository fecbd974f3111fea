"""Turn triangles into the image of one panel, with soft light, outlines, faded floors and anti-aliasing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import unit
from holdfast.drawing import colours
from holdfast.drawing.camera import Camera, View
from holdfast.drawing.raster import CREASE, OUTLINE, Layer, rasterise
from holdfast.drawing.soup import Soup

SHADE_LOSS: Final = 0.12  # share of the brightness that a face turned away from the light loses
_SAMPLES: Final = 2  # samples per pixel along each side, for anti-aliasing
_INK: Final = np.array([0.10, 0.11, 0.14], dtype=np.float32)  # colour of lines
_HATCH: Final = (10, 0.62)  # distance of hatching lines [px], and their brightness relative to the surface
_LIGHT_INK: Final = np.array([0.85, 0.80, 0.82], dtype=np.float32)  # colour of creases on dark surfaces
_LUMINANCE: Final = np.array([0.30, 0.59, 0.11], dtype=np.float32)  # weights of red, green and blue in the luminance
_DARK: Final = 0.27  # luminance below which a surface counts as dark
_BACKGROUND: Final = np.array([1.0, 1.0, 1.0])
_STRENGTH: Final = {CREASE: 0.42, OUTLINE: 0.85}  # opacity of each kind of line
_FIXED_STRENGTH: Final = 0.30  # opacity of lines on fixed bodies, relative to that on movable ones
_FIXED_VEIL: Final = 0.30  # opacity of a fixed body in front of a movable one
# distances at which fixed bodies begin to fade and have vanished, relative to the size of the movable ones
_FADE: Final = (0.10, 0.75)


@dataclass(frozen=True)
class Panel:
    """A drawn panel: its image (H, W, 3) in 0..1, and what is at each pixel.

    ``depth`` (H, W) [m] is that of movable bodies, inf where there is none; ``body`` (H, W) is the number of the
    movable body, -1 where there is none.
    """

    image: NDArray[np.float64]
    depth: NDArray[np.float64]
    body: NDArray[np.int64]


def render(
    movable: Soup,
    fixed: Soup | None,
    camera: Camera,
    shape: tuple[int, int],
    ghost: bool = False,
    focus: NDArray[np.float64] | None = None,
) -> Panel:
    """Draw movable and fixed bodies into a panel of (rows, columns).

    Fixed bodies fade out with their distance from the movable ones.

    ``ghost`` draws the movable bodies pale, as a backdrop for contacts inside them. If ``focus`` (N, 3) [m] is given,
    the fixed bodies fade out with their distance from these points instead.
    """
    fine = camera.magnified(_SAMPLES)
    size = (shape[0] * _SAMPLES, shape[1] * _SAMPLES)
    front = _layer(movable, fine, size)
    paint = _ghost_paint(movable, camera.view) if ghost else _paint(movable, camera.view)
    image = _lookup(paint, front, _BACKGROUND)
    if not ghost:
        _hatch(image, front, movable)
    image = _ink(image, front, 0.45 if ghost else 1.0)
    if fixed is not None and len(fixed.triangles):
        image = _with_fixed(image, front, fixed, fine, movable.vertices if focus is None else focus)
    rows, columns = shape
    pooled = image.reshape(rows, _SAMPLES, columns, _SAMPLES, 3).mean(axis=(1, 3))
    body = np.append(movable.body, -1)[front.triangle]  # -1 picks the last one
    return Panel(pooled.astype(float), front.depth[::_SAMPLES, ::_SAMPLES], body[::_SAMPLES, ::_SAMPLES])


def light(normals: NDArray[np.float64], view: View) -> NDArray[np.float64]:
    """Return the brightness (T,) of faces by their normals (T, 3), between 1 - SHADE_LOSS and 1.

    The light is beside the viewer.
    """
    lamp = unit(0.55 * view.toward + 0.75 * view.up - 0.45 * view.right)
    return np.asarray(1.0 - SHADE_LOSS * (1.0 - np.clip(normals @ lamp, 0.0, 1.0)), dtype=float)


def _paint(soup: Soup, view: View) -> NDArray[np.float64]:
    away = soup.normals @ view.toward < 0.0
    rgb = np.where(away[:, None], np.asarray(colours.COVERED), soup.rgb)
    return rgb * light(soup.normals, view)[:, None]


def _ghost_paint(soup: Soup, view: View) -> NDArray[np.float64]:
    return np.tile([0.955, 0.96, 0.968], (len(soup.triangles), 1)) * light(soup.normals, view)[:, None] ** 0.5


def _layer(soup: Soup, camera: Camera, size: tuple[int, int]) -> Layer:
    axes = np.stack([camera.view.right, camera.view.up, camera.view.toward], axis=1)
    return rasterise(camera.pixels(soup.vertices), soup.triangles, soup.normals @ axes, soup.body, camera.scale, size)


def _lookup(paint: NDArray[np.float64], layer: Layer, background: NDArray[np.float64]) -> NDArray[np.float32]:
    # The index -1 of empty pixels picks the last row.
    table = np.concatenate([paint, background[None]]).astype(np.float32)
    return table[layer.triangle]


def _hatch(image: NDArray[np.float32], layer: Layer, soup: Soup) -> None:
    """Hatch surfaces in the colour of undecided answers, in place, so that they differ clearly from others."""
    marked = np.append((soup.rgb == colours.UNDECIDED).all(axis=1), False)[layer.triangle]  # -1 picks the last row
    rows, columns = (np.arange(size) for size in image.shape[:2])
    distance, darkness = _HATCH
    lines = (rows[:, None] + columns) // _SAMPLES % distance < distance // 4
    image[marked & lines] *= np.float32(darkness)


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
    image: NDArray[np.float32], front: Layer, fixed: Soup, camera: Camera, focus: NDArray[np.float64]
) -> NDArray[np.float32]:
    size = (image.shape[0], image.shape[1])
    layer = _layer(fixed, camera, size)
    colour = _ink(_lookup(_paint(fixed, camera.view), layer, _BACKGROUND), layer, _FIXED_STRENGTH)
    cover = np.zeros(size, dtype=np.float32)
    rows, columns = np.nonzero(layer.triangle >= 0)
    world = camera.world(np.column_stack([columns + 0.5, rows + 0.5, layer.depth[rows, columns]]))
    cover[rows, columns] = _fade(world, focus)
    hides = (front.triangle >= 0) & (layer.depth < front.depth - 1.0 / camera.scale)
    cover[hides] *= _FIXED_VEIL
    cover[(front.triangle >= 0) & ~hides] = 0.0
    edge = (front.triangle < 0) & (front.line > 0)
    cover[edge] = 0.0
    return image + cover[:, :, None] * (colour - image)


def _fade(world: NDArray[np.float64], focus: NDArray[np.float64]) -> NDArray[np.float64]:
    if not len(focus):  # without movable bodies, fixed ones do not fade
        return np.ones(len(world))
    low, high = focus.min(axis=0), focus.max(axis=0)
    beyond = np.maximum(np.maximum(low - world, world - high), 0.0)
    reach = np.linalg.norm(beyond, axis=1) / max(float(np.linalg.norm(high - low)), 1e-12)
    ramp = np.clip((_FADE[1] - reach) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
    return np.asarray(ramp * ramp * (3.0 - 2.0 * ramp), dtype=float)
