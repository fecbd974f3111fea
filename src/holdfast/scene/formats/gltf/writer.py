"""Writes glTF scenes: a coloured node for each body, with all data that the reader needs to restore the scene."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from holdfast.base.colour import Rgb, rgb_of
from holdfast.geometry.gltf import Gltf, Primitive
from holdfast.scene.compound import Shape
from holdfast.scene.formats.gltf.extras import Drawn, body_data, drawn, scene_data
from holdfast.scene.scene import Scene

FIXED: Final = rgb_of("#d3d2ce")
# colours of movable bodies, in their order, repeated if there are more bodies
COLOURS: Final = tuple(
    map(rgb_of, ("#4f7cac", "#e08e45", "#5aa469", "#c65b5b", "#8a6fb3", "#c9a227", "#3f9aa6", "#b0688f"))
)
TEXT: Final = ".gltf"


def write(scene: Scene, path: Path) -> bytes:
    """Return the content of a binary file or, for the suffix .gltf, of a text file that includes its buffer.

    The reader restores shapes, masses, poses, friction and everything else exactly, but meshes in single precision.
    """
    file = Gltf()
    meshes: dict[tuple[Shape, Rgb], tuple[int, Drawn]] = {}
    moving = 0
    for body in scene.bodies:
        colour = FIXED if body.fixed else COLOURS[moving % len(COLOURS)]
        moving += not body.fixed
        if (body.shape, colour) not in meshes:  # equal shapes with the same colour share a mesh
            shown = drawn(body.shape)
            primitive = Primitive(shown.vertices, shown.faces, file.material(colour))
            meshes[body.shape, colour] = file.mesh([primitive]), shown
        number, shown = meshes[body.shape, colour]
        there = np.eye(4)
        there[:3, 3] = shown.origin
        file.node(body.name, number, body.pose @ there if shown.origin.any() else body.pose, body_data(body, shown))
    return file.content(scene_data(scene), binary=path.suffix.lower() != TEXT)
