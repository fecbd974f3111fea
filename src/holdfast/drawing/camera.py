"""Cameras: orthographic three-quarter views, and how they are fitted into a panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holdfast.base.arrays import unit
from holdfast.drawing.picture import Picture

_TURN = np.deg2rad(34.0)  # [rad] angle between the view and the short horizontal axis of the bodies
_ABOVE = np.deg2rad(27.0)  # [rad] elevation of the front view
_BELOW = np.deg2rad(-24.0)  # [rad] elevation of the back view


@dataclass(frozen=True)
class View:
    """The direction of a view, as unit vectors (3,): screen right, screen up, and from the scene towards the viewer."""

    right: NDArray[np.float64]
    up: NDArray[np.float64]
    toward: NDArray[np.float64]

    def flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the screen coordinates (N, 2) [m], right and up, of world points (N, 3) [m]."""
        return points @ np.stack([self.right, self.up], axis=1)


@dataclass(frozen=True)
class Camera:
    """A view that is placed on a panel.

    ``scale`` is in pixels per metre, and ``origin`` (2,) [m] is the screen point at the top left corner of the panel.
    """

    view: View
    origin: NDArray[np.float64]
    scale: float

    def pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return column, row and depth [m] (N, 3) of world points (N, 3) [m]; a smaller depth is nearer."""
        flat = (self.view.flat(points) - self.origin) * np.array([self.scale, -self.scale])
        return np.column_stack([flat, -(points @ self.view.toward)])

    def world(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the world points (N, 3) [m] at these columns, rows and depths (N, 3); the inverse of ``pixels``."""
        x = self.origin[0] + pixels[:, 0] / self.scale
        y = self.origin[1] - pixels[:, 1] / self.scale
        return np.column_stack([x, y, -pixels[:, 2]]) @ np.stack([self.view.right, self.view.up, self.view.toward])

    def magnified(self, factor: int) -> Camera:
        """Return the same camera for a panel with ``factor`` times as many pixels per side."""
        return Camera(self.view, self.origin, self.scale * factor)


def heat_points(picture: Picture) -> NDArray[np.float64]:
    """Return the vertices (N, 3) [m] that must be in view: of the coloured surfaces or, without any, of all bodies."""
    meshes = [surface.vertices for surface in picture.heat] or [solid.vertices for solid in picture.solids]
    points = np.concatenate([*meshes, np.empty((0, 3))])
    return points if len(points) else np.array([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]])


def stacked(points: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the points as an array (N, 3), which is empty if there are none."""
    return np.array(points, dtype=float).reshape(-1, 3)


def front_view(picture: Picture) -> View:
    """Return a three-quarter view from above onto the long side of the bodies.

    Of the four corners, it looks from the one that shows most of the weakest pushes.
    """
    vertical, along, across = _frame(picture)
    pushes = [unit(a.tail - a.head) for a in picture.weakest if not np.array_equal(a.tail, a.head)]
    best, best_score = None, -np.inf
    for side, turn in ((-1, 1), (-1, -1), (1, 1), (1, -1)):
        view = _view(vertical, side * np.cos(_TURN) * across + turn * np.sin(_TURN) * along, _ABOVE)
        score = sum(float(push @ view.toward > 0.15) for push in pushes)
        if score > best_score:
            best, best_score = view, score
    assert best is not None
    return best


def back_view(picture: Picture, front: View) -> View:
    """Return a view from behind and below, which shows what ``front`` hides."""
    vertical = unit(picture.up)
    level = front.toward - (front.toward @ vertical) * vertical
    return _view(vertical, -level, _BELOW)


def fit(view: View, points: NDArray[np.float64], width: float, height: float, margin: float) -> Camera:
    """Return the camera that centres the points in a panel of width by height pixels, with a margin [px]."""
    flat = view.flat(points)
    low, high = flat.min(axis=0), flat.max(axis=0)
    extent = np.maximum(high - low, 1e-9)
    scale = float(min((width - 2 * margin) / extent[0], (height - 2 * margin) / extent[1]))
    centre = (low + high) / 2.0
    origin = centre + np.array([-width, height]) / (2.0 * scale)
    return Camera(view, origin, scale)


def _frame(picture: Picture) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    vertical = unit(picture.up)
    reference = np.array([1.0, 0.0, 0.0]) if abs(vertical[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = unit(reference - (reference @ vertical) * vertical)
    second = np.cross(vertical, first)
    points = heat_points(picture)
    if np.ptp(points @ second) > 1.05 * np.ptp(points @ first):
        return vertical, second, -first
    return vertical, first, second


def _view(vertical: NDArray[np.float64], level: NDArray[np.float64], elevation: float) -> View:
    toward = np.cos(elevation) * unit(level) + np.sin(elevation) * vertical
    right = unit(np.cross(vertical, toward))
    return View(right, np.cross(toward, right), toward)
