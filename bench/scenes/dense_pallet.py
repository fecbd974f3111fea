"""A dense pallet: a single group, which must be solved as a whole whichever box moves."""

from __future__ import annotations

import holdfast as hf
from holdfast.scene.shipped.blocks import at


def pallet(across: int, deep: int, high: int) -> hf.Scene:
    """Layers of boxes on a floor, ``across`` x ``deep`` in each, every other layer shifted by a third of a box."""
    bodies = [hf.Body("floor", hf.Box((10, 10, 0.1)), pose=at(0, 0, -0.05), fixed=True)]
    box = hf.Box((0.3, 0.2, 0.15))
    for z in range(high):
        for y in range(deep):
            for x in range(across):
                pose = at(0.3 * x + 0.1 * (z % 2), 0.2 * y, 0.075 + 0.15 * z)
                bodies.append(hf.Body(f"box{x}_{y}_{z}", box, mass=5.0, pose=pose))
    return hf.Scene(bodies, 0.5)
