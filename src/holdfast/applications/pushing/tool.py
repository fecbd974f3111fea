"""A straight tool, and which points of a body it reaches without touching another body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Bool, Float, checked_number
from holdfast.base.ranges import LENGTH
from holdfast.base.values import Value
from holdfast.geometry.clearance import rod_clearance

LONG = 2.0  # sizes of the assembly: length of the tool
ROUNDING = 1e-9  # of the size of the assembly


@dataclass(frozen=True, eq=False, repr=False)
class Tool(Value):
    """What pushes a body: a straight rod with a round tip.

    - ``radius`` [m]: that of the rod, which must reach a point without touching another body.
    - ``travel`` [m]: how far it pushes the body. Nothing else may move, or be in the way, until then.

    Raises SceneError for a number out of range.
    """

    radius: float = 0.0
    travel: float = 0.005

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "radius", checked_number(self.radius, "Tool: radius", minimum=0, within=LENGTH))
        set_(self, "travel", checked_number(self.travel, "Tool: travel", above=0, within=LENGTH))


def reached(assembly: Assembly, body: str, points: Float, normals: Float, directions: Float, radius: float) -> Bool:
    """Tell which of n pushes a tool can make: a rod with a round tip, both of ``radius`` [m], that pushes lengthwise.

    Its tip touches the ``body`` at ``points`` (n, 3) [m] from outside, along the outward unit ``normals`` (n, 3), and
    it reaches back from there along minus ``directions`` (n, 3). From every other body it stays away by the contact
    tolerance of the two, and nowhere does it enter the pushed body.
    """
    pushed = assembly.scene.body(body)
    apart = assembly.tolerances.of(pushed) + pushed.shape.surface.sagitta
    tip = points + (radius + apart) * normals
    back = -LONG * assembly.size * directions
    slack = ROUNDING * assembly.size
    free = rod_clearance(tip, back, pushed.surface_world) >= max(radius - slack, slack)
    for other in assembly.bodies:
        if other.name != body:
            needed = radius + assembly.tolerances.base(pushed, other)
            free[free] = rod_clearance(tip[free], back[free], other.surface_world) >= needed - slack
    return np.asarray(free)
