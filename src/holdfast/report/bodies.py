"""Convert bodies to the solids of a picture without a map."""

from __future__ import annotations

from collections.abc import Iterable

from holdfast.drawing.picture import Picture, Solid
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene


def solids_of(bodies: Iterable[Body]) -> tuple[Solid, ...]:
    """Return the surfaces of bodies, world frame."""
    return tuple(Solid(b.name, b.surface_world.vertices, b.surface_world.faces, b.fixed) for b in bodies)


def bare_picture(scene: Scene, without: str = "") -> Picture:
    """Return a picture, without a map, of the bodies of a scene except the one named ``without``."""
    return Picture("", "", (), solids_of(body for body in scene.bodies if body.name != without), up=scene.up)
