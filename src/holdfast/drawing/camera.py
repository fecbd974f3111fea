"""Cameras: orthographic three-quarter views, and how they are fitted into a panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.base.arrays import Float, unit
from holdfast.drawing.picture import Picture, heat_points

_TURN = np.deg2rad(34.0)  # [rad] angle between the view and the short horizontal axis of the bodies
_ABOVE = np.deg2rad(27.0)  # [rad] elevation of the front view
_BELOW = np.deg2rad(-24.0)  # [rad] elevation of the back view


@dataclass(frozen=True)
class View:
    """The direction of a view, as unit vectors (3,): screen right, screen up, and from the scene towards the viewer."""

    right: Float
    up: Float
    toward: Float

    def flat(self, points: Float) -> Float:
        """Return the screen coordinates (N, 2) [m], right and up, of world points (N, 3) [m]."""
        return points @ np.stack([self.right, self.up], axis=1)


@dataclass(frozen=True)
class Camera:
    """A view that is placed on a panel.

    ``scale`` is in pixels per metre, and ``origin`` (2,) [m] is the screen point at the top left corner of the panel.
    """

    view: View
    origin: Float
    scale: float

    def pixels(self, points: Float) -> Float:
        """Return column, row and depth [m] (N, 3) of world points (N, 3) [m]; a smaller depth is nearer."""
        flat = (self.view.flat(points) - self.origin) * np.array([self.scale, -self.scale])
        return np.column_stack([flat, -(points @ self.view.toward)])

    def world(self, pixels: Float) -> Float:
        """Return the world points (N, 3) [m] at these columns, rows and depths (N, 3); the inverse of ``pixels``."""
        x = self.origin[0] + pixels[:, 0] / self.scale
        y = self.origin[1] - pixels[:, 1] / self.scale
        return np.column_stack([x, y, -pixels[:, 2]]) @ np.stack([self.view.right, self.view.up, self.view.toward])


def front_view(picture: Picture) -> View:
    """Return a three-quarter view from above onto the long side of the bodies.

    Of the four corners, it looks from the one that shows most of the weakest pushes.
    """
    vertical = unit(picture.up)
    reference = np.array([1.0, 0.0, 0.0]) if abs(vertical[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    along = unit(reference - (reference @ vertical) * vertical)
    across = np.cross(vertical, along)
    points = heat_points(picture)
    if np.ptp(points @ across) > 1.05 * np.ptp(points @ along):
        along, across = across, -along
    pushes = [unit(a.tail - a.head) for a in picture.weakest if not np.array_equal(a.tail, a.head)]
    corners = ((-1, 1), (-1, -1), (1, 1), (1, -1))
    ways = [side * np.cos(_TURN) * across + turn * np.sin(_TURN) * along for side, turn in corners]
    views = [_view(vertical, way, _ABOVE) for way in ways]
    return max(views, key=lambda view: sum(float(push @ view.toward > 0.15) for push in pushes))


def back_view(picture: Picture, front: View) -> View:
    """Return a view from behind and below, which shows what ``front`` hides."""
    vertical = unit(picture.up)
    level = front.toward - (front.toward @ vertical) * vertical
    return _view(vertical, -level, _BELOW)


def fit(view: View, points: Float, width: float, height: float, margin: float, top: float = 0.0) -> Camera:
    """Return the camera that centres the points in a panel of width by height pixels, with a margin [px].

    The panel begins ``top`` [px] below the row that the camera counts from.
    """
    flat = view.flat(points)
    low, high = flat.min(axis=0), flat.max(axis=0)
    extent = np.maximum(high - low, 1e-9)
    scale = float(min((width - 2 * margin) / extent[0], (height - 2 * margin) / extent[1]))
    origin = (low + high) / 2.0 + np.array([-width, height]) / (2.0 * scale)
    return Camera(view, origin + np.array([0.0, top / scale]), scale)


def _view(vertical: Float, level: Float, elevation: float) -> View:
    toward = np.cos(elevation) * unit(level) + np.sin(elevation) * vertical
    right = unit(np.cross(vertical, toward))
    return View(right, np.cross(toward, right), toward)
