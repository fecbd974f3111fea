"""Edits of an assembly in the live view: the pose of a body in numbers or by handles that are dragged, and its mass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, checked, checked_number
from holdfast.base.ranges import MASS, PLACE

NODE: Final = "/drag"
UNTURNED: Final = (1.0, 0.0, 0.0, 0.0)  # identity quaternion: the handles are along the axes of the world
UNDRAGGED: Final = 1e-9  # [m] and [-] a smaller motion counts as no drag
UPRIGHT: Final = 1e-7  # [-] below this the level part of a body's x axis has no direction


class BodyPlace(NamedTuple):
    """The pose of a body as numbers.

    ``position`` (3,) [m] is the origin of its frame, and ``turn`` (3,) [degrees] are its rotations about the world's x,
    y and z axes, one after the other.
    """

    position: Float
    turn: Float


def place_of(assembly: Assembly, name: str) -> BodyPlace:
    """Return the place of a body of the assembly."""
    pose = assembly.scene.body(name).pose
    rotation = pose[:3, :3]
    level = np.hypot(rotation[0, 0], rotation[1, 0])
    about_y = np.arctan2(-rotation[2, 0], level)
    if level > UPRIGHT:
        about_x, about_z = np.arctan2(rotation[2, 1], rotation[2, 2]), np.arctan2(rotation[1, 0], rotation[0, 0])
    else:  # gimbal lock
        about_x, about_z = np.arctan2(-rotation[1, 2], rotation[1, 1]), 0.0
    return BodyPlace(pose[:3, 3].copy(), np.degrees([about_x, about_y, about_z]))


def pose_of(place: BodyPlace) -> Float:
    """Return the pose (4, 4) of a body at this place."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", checked(place.turn, (3,), "turn"), degrees=True).as_matrix()
    pose[:3, 3] = checked(place.position, (3,), "position", within=PLACE)
    return pose


def weighing(assembly: Assembly, name: str, mass: float) -> Assembly:
    """Return the assembly with another mass [kg] of a movable body; its contacts stay the same."""
    mass = checked_number(mass, f"mass of {name}", above=0, within=MASS)
    scene = assembly.scene
    bodies = tuple(replace(body, mass=mass, density=None) if body.name == name else body for body in scene.bodies)
    return replace(assembly, scene=replace(scene, bodies=bodies))


class HandleGrip(NamedTuple):
    """The body that a gizmo holds: its name, its ``pose`` (4, 4), and the initial position ``home`` (3,) [m]."""

    name: str
    pose: Float
    home: Float


class Gizmo:
    """The drag handles of one body. They report where the body is dragged, and do not change the model.

    ``dragged`` is called with the name of the body and its transform at every step of a drag, and ``dropped`` with the
    name and the new pose (4, 4) at the end. After that, ``held`` is the transform of the body until ``show`` is called
    with another pose, or ``back`` cancels the drag.
    """

    def __init__(
        self,
        scene: Any,  # noqa: ANN401 - viser's own type
        dragged: Callable[[str, Float], None],
        dropped: Callable[[str, Float], None],
    ) -> None:
        self._scene = scene
        self._dragged, self._dropped = dragged, dropped
        self._node: Any = None
        self._grip: HandleGrip | None = None
        self._going_on = False

    def show(self, name: str, pose: Float, middle: Float, length: float) -> None:
        """Show the handles, of this ``length`` [m], at a body with this ``pose`` (4, 4) and ``middle`` (3,) [m].

        Nothing changes if they are at this body already, and its pose is the same or it is being dragged.
        """
        grip = self._grip
        if grip is not None and grip.name == name and (self._going_on or np.array_equal(grip.pose, pose)):
            return
        if self._node is None:
            self._node = self._scene.add_transform_controls(NODE, depth_test=False)
            self._node.on_update(self._heard)
        self._grip, self._going_on = HandleGrip(name, pose, middle), False
        self.back()
        self._node.scale = length
        self._node.visible = True

    def hide(self) -> None:
        """Hide the handles."""
        if self._node is not None:
            self._node.visible = False
        self._grip, self._going_on = None, False

    def back(self) -> None:
        """Cancel a drag: move the handles back to the body's pose before it."""
        self._going_on = False
        if self._grip is not None:
            self._node.position, self._node.wxyz = tuple(self._grip.home), UNTURNED

    @property
    def held(self) -> dict[str, Float]:
        """The transform (4, 4), world frame, of the dragged body by its name; {} without a drag."""
        grip = self._grip
        if grip is None:
            return {}
        moved = np.eye(4)
        moved[:3, :3] = Rotation.from_quat(np.roll(self._node.wxyz, -1)).as_matrix()
        moved[:3, 3] = self._node.position - moved[:3, :3] @ grip.home
        far = max(np.abs(moved[:3, :3] - np.eye(3)).max(), np.abs(self._node.position - grip.home).max())
        return {grip.name: moved} if far > UNDRAGGED else {}

    async def _heard(self, event: Any) -> None:  # noqa: ANN401 - viser's own type
        """Handle a step of a drag. It is a coroutine because in threads, the steps could arrive in any order."""
        grip, held = self._grip, self.held
        self._going_on = event.phase != "end"
        if grip is None or not held:
            return
        self._dragged(grip.name, held[grip.name])
        if not self._going_on:
            self._dropped(grip.name, held[grip.name] @ grip.pose)
