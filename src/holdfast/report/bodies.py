"""Bodies as what a picture draws without a map."""

from __future__ import annotations

from collections.abc import Iterable

from holdfast.drawing.picture import Picture, Solid
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene


def solids_of(bodies: Iterable[Body]) -> tuple[Solid, ...]:
    """Return the whole surfaces of bodies, where they are in the world."""
    return tuple(Solid(b.name, b.surface_world.vertices, b.surface_world.faces, b.fixed) for b in bodies)


def bare_picture(scene: Scene, without: str = "") -> Picture:
    """Return a picture of the bodies of a scene but the one named ``without``, without a map."""
    return Picture("", "", (), solids_of(body for body in scene.bodies if body.name != without), up=scene.up)
