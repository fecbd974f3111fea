"""Whether points lie on the surface of a body, and whether directions there point into it."""

from __future__ import annotations

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Int
from holdfast.base.errors import SceneError, message
from holdfast.geometry.distance import distance_to_surface, winding_number
from holdfast.geometry.surface import Surface
from holdfast.scene.body import Body

INSIDE = 0.5  # winding number of a surface about a point, above which the point is inside
# A direction is tested this far ahead of its point and behind it: in sizes of the body, plus distances from it.
WAY, OFF = 1e-3, 10.0
SLANT = 0.5  # sine of the angle to what presses on the faces at a point, above which a direction is a mistake: 30°
GRAZING = 0.01  # sine of the angle between a direction and the surface, below which it neither presses nor pulls


def check_on_surface(assembly: Assembly, name: str, points: Float, where: str) -> None:
    """Raise SceneError, with ``where`` in its message, if a point (n, 3) [m] does not lie on the surface of a body."""
    body = assembly.scene.body(name)
    tolerance = assembly.tolerances.of(body) + body.shape.surface.sagitta
    distance = distance_to_surface(points, body.surface_world)
    worst = int(np.argmax(distance))
    if distance[worst] > tolerance:
        place = np.array2string(points[worst], precision=4, separator=", ")
        away = f"{distance[worst] * 1e3:.3g} mm" if distance[worst] < 1 else f"{distance[worst]:.3g} m"
        problem = f"point {worst} at {place} is {away} from the surface"
        units = "are these millimetres? " if distance[worst] > 10 * body.size else ""  # or of quite another body
        remedy = f"{units}needs points on the body (tolerance {tolerance * 1e3:.3g} mm), in m and world coordinates"
        raise SceneError(message(where, problem, remedy))


def pointing_out(body: Body, points: Float, directions: Float) -> Int:
    """Return the numbers of the unit ``directions`` (n, 3) that point out of a body at ``points`` (n, 3) [m].

    Their line is inside the body just behind the point, and outside just ahead. Those that graze the surface or that
    cross a thin body are not counted.
    """
    surface = body.surface_world
    off = distance_to_surface(points, surface)[:, None]
    step = (WAY * surface.diagonal + OFF * off) * directions
    rows = np.flatnonzero(winding_number(points - step, surface) > INSIDE)
    deep = distance_to_surface((points - step)[rows], surface) > GRAZING * np.linalg.norm(step[rows], axis=1)
    return np.asarray(rows[deep & (winding_number((points + step)[rows], surface) < INSIDE)])


def not_pressing(assembly: Assembly, name: str, points: Float, directions: Float) -> Int:
    """Return the numbers of the unit ``directions`` (n, 3) along which nothing presses on a body at ``points`` (n, 3).

    What does is against the normal of the face there, and at edges and corners between those of several faces.
    """
    from scipy.optimize import nnls  # only here, as it takes long to import

    body = assembly.scene.body(name)
    surface, off = body.surface_world, distance_to_surface(points, body.surface_world)
    near = min(assembly.tolerances.of(body), surface.thickness / 4) + body.shape.surface.sagitta
    corners = surface.vertices[surface.faces]
    found = []
    for k, (point, way, reach) in enumerate(zip(points, directions, off + near, strict=True)):
        around = ((corners.min(1) - reach <= point) & (point <= corners.max(1) + reach)).all(1)
        faces = [
            f
            for f in np.flatnonzero(around).tolist()
            if distance_to_surface(point[None], Surface(surface.vertices, surface.faces[[f]]))[0] <= reach
        ]
        if nnls(-surface.normals[faces].T, way)[1] > SLANT:
            found.append(k)
    return np.array(found, dtype=np.int64)
