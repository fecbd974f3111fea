"""The floor below a scene: on request it is added, and the scene is put on it; something must carry a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holdfast.base.arrays import Float, checked_truth
from holdfast.base.errors import SceneError, message
from holdfast.scene.body import Body
from holdfast.scene.halfspace import HalfSpace
from holdfast.scene.scene import Scene, with_notes

FLOOR = "floor"  # name of the body
LEVEL = 0.999  # cosine of the slope up to which a half space is a floor, and no ramp or wall: 2.6 degrees


def with_floor(
    bodies: Sequence[Body], floor: bool, where: str, remedy: str, *, problem: str = "nothing in it is fixed"
) -> list[Body]:
    """Return the bodies of a file and, if ``floor``, the half space below z = 0, which never moves.

    Raises SceneError about ``where``, with the ``problem`` and its ``remedy``, if nothing is fixed, and if a body has
    the name of the floor.
    """
    if checked_truth(floor, "floor") and any(body.name == FLOOR for body in bodies):
        raise SceneError(message(FLOOR, "the file has a body of this name", "leave floor= out"))
    found = [*bodies, Body(FLOOR, HalfSpace(), fixed=True)] if floor else list(bodies)
    if not any(body.fixed for body in found):
        raise SceneError(message(where, problem, remedy))
    return found


def on_the_floor(scene: Scene) -> Scene:
    """Return the scene moved vertically, as one, so that its lowest point is on the floor; a note says how far.

    The floor is the highest level half space, and all but half spaces are moved. Without one it is the top of the only
    fixed body, and what can move is moved. Raises SceneError if there is neither.
    """
    planes = [body for body in scene.bodies if isinstance(body.shape, HalfSpace)]
    tops = [float(body.pose[:3, 3] @ scene.up) for body in planes if body.pose[:3, 2] @ scene.up > LEVEL]
    fixed = [body for body in scene.bodies if body.fixed and body not in planes]
    if not tops and len(fixed) == 1:
        tops, planes = [_heights(fixed[0], scene.up).max()], [*planes, *fixed]
    if not tops:
        problem = f"of {len(fixed)} fixed bodies none is a level half space"
        raise SceneError(message("on_floor", problem, "give floor=True, or one fixed body that carries the others"))
    moved = [body for body in scene.bodies if body not in planes]
    lift = max(tops) - min((_heights(body, scene.up).min() for body in moved), default=max(tops))
    step = np.eye(4)
    step[:3, 3] = lift * scene.up
    way = f"lowered by {-lift:.6g} m" if lift < 0 else f"raised by {lift:.6g} m"
    return with_notes(
        scene.moved({body.name: step @ body.pose for body in moved}),
        [f"on_floor: {way}, so that the lowest point is on the floor"],
    )


def _heights(body: Body, up: Float) -> Float:
    return np.asarray(body.surface_world.vertices @ up)
