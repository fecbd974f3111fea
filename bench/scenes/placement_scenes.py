"""Scenes to put something down in, after those of Sec. VII-A, whose originals are not public: all of them are ours.

S1 to S6 go from a cube on a flat surface to orientations that matter and several supports; slant, balance and
cantilever are those where a body looks safe as long as what carries it counts as fixed. Standing on the floor is no
answer in any of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from holdfast.applications.placement.conditions import Approach, Where
from holdfast.base.rigid import pose_from
from holdfast.scene.body import Body
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box, Cylinder
from holdfast.scene.shipped.blocks import about_y, box, floor, prism


@dataclass(frozen=True, eq=False)
class PlacementScene:
    """A scene, the object to put down, where it may be placed (never onto the floor) and its way in."""

    scene: Scene
    body: Body
    where: Where
    approach: Approach | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "where", replace(self.where, avoid=("floor",)))


def thing(size: tuple[float, float, float], mass: float) -> Body:
    """The object, a box."""
    return Body("object", Box(np.array(size)), mass=mass)


def s1() -> PlacementScene:
    """A small cube onto a cube on a flat surface."""
    scene = Scene([floor(0.5, 0.5), box("cube", (0.1, 0.1, 0.1), 1, (0, 0, 0.05))], 0.5, name="S1")
    return PlacementScene(scene, thing((0.05, 0.05, 0.05), 0.2), Where(supports=("cube",)))


def s2() -> PlacementScene:
    """A plank across two cubes: two supports."""
    cubes = [box(name, (0.08, 0.08, 0.08), 0.6, (x, 0, 0.04)) for name, x in (("left", -0.09), ("right", 0.09))]
    scene = Scene([floor(0.5, 0.5), *cubes], 0.5, name="S2")
    where = Where(supports=("left", "right"), least_supports=2)
    return PlacementScene(scene, thing((0.28, 0.05, 0.02), 0.4), where)


def s3() -> PlacementScene:
    """A box onto a table that carries one already: legs sway, the slab overhangs them."""
    legs = [box(f"leg_{side}", (0.03, 0.12, 0.1), 0.3, (x, 0, 0.05)) for side, x in (("left", -0.1), ("right", 0.1))]
    slab = box("slab", (0.3, 0.12, 0.02), 0.8, (0, 0, 0.11))
    scene = Scene([floor(0.6, 0.5), *legs, slab, box("box", (0.06, 0.06, 0.06), 0.3, (0.06, 0, 0.15))], 0.5, name="S3")
    return PlacementScene(scene, thing((0.06, 0.05, 0.08), 0.3), Where(supports=("slab", "box")))


def s4() -> PlacementScene:
    """A slab into a slot 25 % wider than it is thick: on edge and along it, from above."""
    base = box("base", (0.2, 0.15, 0.03), 1.5, (0, 0, 0.015))
    walls = [box(name, (0.2, 0.04, 0.06), 0.5, (0, y, 0.06)) for name, y in (("near", -0.04), ("far", 0.04))]
    scene = Scene([floor(0.5, 0.5), base, *walls], 0.5, name="S4")
    where = Where(supports=("base",), box=((-0.1, -0.02), (0.1, 0.02)))
    return PlacementScene(scene, thing((0.14, 0.1, 0.032), 0.4), where, Approach(direction=(0, 0, -1)))


def s5() -> PlacementScene:
    """A cylinder into the trough between two wedges that would slide apart: two slanted supports."""
    left = np.array([[-0.11, 0.0], [-0.004, 0.0], [-0.11, 0.06]])
    right = np.array([[0.004, 0.0], [0.11, 0.0], [0.11, 0.06]])
    wedges = [prism("left", left, 0.14, 1, mass=0.9), prism("right", right, 0.14, 1, mass=0.9)]
    scene = Scene([floor(0.6, 0.5), *wedges], 0.5, name="S5")
    where = Where(supports=("left", "right"), least_supports=2)
    return PlacementScene(scene, Body("object", Cylinder(0.035, 0.12, 32), mass=0.3), where)


def s6() -> PlacementScene:
    """A plate across three columns of different heights: three supports, tilted."""
    columns = [
        box(f"column{k}", (0.06, 0.06, height), 0.5, (x, y, height / 2))
        for k, (x, y, height) in enumerate(((-0.08, -0.06, 0.1), (0.08, -0.06, 0.085), (0, 0.08, 0.115)))
    ]
    scene = Scene([floor(0.5, 0.5), *columns], 0.5, name="S6")
    where = Where(supports=tuple(column.name for column in columns), least_supports=3)
    return PlacementScene(scene, thing((0.24, 0.22, 0.012), 0.4), where)


def slant() -> PlacementScene:
    """A cube onto a ramp whose upper end rests on a post that stands at the very edge of its pedestal."""
    tilt = np.arctan(0.02 / 0.2)
    pedestal = box("pedestal", (0.1, 0.1, 0.05), 1.5, (0.16, 0, 0.025))
    post = box("post", (0.05, 0.1, 0.06), 0.4, (0.115, 0, 0.08))  # its left 0.02 m are over nothing
    stop = box("stop", (0.05, 0.1, 0.09), 0.7, (-0.085, 0, 0.045))
    along, normal = np.array([np.cos(tilt), 0, np.sin(tilt)]), np.array([-np.sin(tilt), 0, np.cos(tilt)])
    foot = np.array([0.09, 0, 0.11])  # the edge of the post under the ramp; the stop's is at (-0.11, 0, 0.09)
    pose = pose_from(foot - 0.09 * along + 0.0075 * normal, about_y(-tilt))
    ramp = Body("ramp", Box(np.array([0.3, 0.08, 0.015])), mass=0.5, pose=pose)
    scene = Scene([floor(0.7, 0.5), pedestal, post, stop, ramp], 0.5, name="slant")
    return PlacementScene(scene, thing((0.05, 0.05, 0.04), 0.5), Where(supports=("ramp",)))


def balance() -> PlacementScene:
    """A cube onto a beam on a fulcrum with a block at either end."""
    bodies = [
        box("fulcrum", (0.06, 0.08, 0.1), 1.5, (0, 0, 0.05)),
        box("beam", (0.4, 0.08, 0.015), 0.5, (0, 0, 0.1075)),
        box("left", (0.06, 0.06, 0.06), 0.25, (-0.16, 0, 0.145)),
        box("right", (0.06, 0.06, 0.06), 0.25, (0.16, 0, 0.145)),
    ]
    scene = Scene([floor(0.7, 0.5), *bodies], 0.5, name="balance")
    return PlacementScene(scene, thing((0.05, 0.05, 0.04), 0.8), Where(supports=("beam", "left", "right")))


def cantilever() -> PlacementScene:
    """A cube onto an arm held down by a counterweight, with a block on its tip."""
    bodies = [
        box("column", (0.08, 0.08, 0.14), 1.5, (0, 0, 0.07)),
        box("arm", (0.3, 0.08, 0.015), 0.4, (0.08, 0, 0.1475)),
        box("counterweight", (0.06, 0.06, 0.06), 0.9, (-0.03, 0, 0.185)),
        box("tip", (0.1, 0.08, 0.04), 0.15, (0.18, 0, 0.175)),
    ]
    scene = Scene([floor(0.7, 0.5), *bodies], 0.5, name="cantilever")
    where = Where(supports=("arm", "counterweight", "tip"))
    return PlacementScene(scene, thing((0.05, 0.05, 0.04), 0.8), where)


TABLE_II: MappingProxyType[str, Callable[[], PlacementScene]] = MappingProxyType(
    {"S1": s1, "S2": s2, "S3": s3, "S4": s4, "S5": s5, "S6": s6}
)
TABLE_III: MappingProxyType[str, Callable[[], PlacementScene]] = MappingProxyType(
    {"slant": slant, "balance": balance, "cantilever": cantilever}
)
