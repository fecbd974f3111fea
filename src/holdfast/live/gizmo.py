"""Arrows, planes and rings about one body in the picture, by which somebody drags it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from holdfast.base.arrays import Float

NODE: Final = "/drag"
UNTURNED: Final = (1.0, 0.0, 0.0, 0.0)  # quaternion of the axes of the world, along and about which a drag goes
STILL: Final = 1e-9  # [m] and [-]: a drag that ends this near to where it began was none


class Grip(NamedTuple):
    """The body that a gizmo is at: its name, its ``pose`` (4, 4), and the ``home`` (3,) [m] of the gizmo."""

    name: str
    pose: Float
    home: Float


class Gizmo:
    """What one body is dragged by: it tells where the body was dragged to, and changes nothing by itself.

    ``dragged`` is called with the name of the body and its transform at every step of a drag, and ``dropped`` with the
    name and the new pose (4, 4) at the end. From then on ``held`` says where the body is, until ``show`` is told that
    it has another pose, or ``back`` that it stays where it was.
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
        self._grip: Grip | None = None
        self._going_on = False

    def show(self, name: str, pose: Float, middle: Float, length: float) -> None:
        """Bring the gizmo, with arms of this ``length`` [m], to a body at this ``pose`` (4, 4) and ``middle`` (3,) [m].

        A body that is shown at the pose that it had, or is being dragged, is left alone.
        """
        grip = self._grip
        if grip is not None and grip.name == name and (self._going_on or np.array_equal(grip.pose, pose)):
            return
        if self._node is None:
            self._node = self._scene.add_transform_controls(NODE, depth_test=False)
            self._node.on_update(self._heard)
        self._grip, self._going_on = Grip(name, pose, middle), False
        self.back()
        self._node.scale = length
        self._node.visible = True

    def hide(self) -> None:
        """Take the gizmo away."""
        if self._node is not None:
            self._node.visible = False
        self._grip, self._going_on = None, False

    def back(self) -> None:
        """Bring the gizmo back to the body, which is where it was before the drag."""
        self._going_on = False
        if self._grip is not None:
            self._node.position, self._node.wxyz = tuple(self._grip.home), UNTURNED

    @property
    def held(self) -> dict[str, Float]:
        """The transform (4, 4) of the world that takes the body from its pose to where it was dragged; {} without."""
        grip = self._grip
        if grip is None:
            return {}
        moved = np.eye(4)
        moved[:3, :3] = Rotation.from_quat(np.roll(self._node.wxyz, -1)).as_matrix()
        moved[:3, 3] = self._node.position - moved[:3, :3] @ grip.home
        far = max(np.abs(moved[:3, :3] - np.eye(3)).max(), np.abs(self._node.position - grip.home).max())
        return {grip.name: moved} if far > STILL else {}

    async def _heard(self, event: Any) -> None:  # noqa: ANN401 - viser's own type
        """Listen to a drag; not in a thread of its own, where the events of one drag come in any order."""
        grip, held = self._grip, self.held
        self._going_on = event.phase != "end"
        if grip is None or not held:
            return
        self._dragged(grip.name, held[grip.name])
        if not self._going_on:
            self._dropped(grip.name, held[grip.name] @ grip.pose)
