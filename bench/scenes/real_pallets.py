"""Real pallets of 5 to 108 boxes, as published loading plans give them."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

import holdfast as hf
from bench.checkout import CASES
from holdfast.scene.shipped.blocks import at

MU = 0.5  # the plans give no friction
FLOOR = (20.0, 20.0, 0.1)  # [m] sides of the floor


def pallets() -> list[list[dict[str, Any]]]:
    """The boxes of every pallet in ``cases/cargo`` beside the checkout, by number of boxes; none without that file."""
    file = CASES / "cargo" / "pallets.json"
    if not file.is_file():
        return []
    units = json.loads(file.read_text(encoding="utf-8"))["units"]
    return sorted((unit["boxes"] for unit in units), key=len)


def pallet(boxes: list[dict[str, Any]], mu: float = MU) -> hf.Scene:
    """The boxes of one pallet on a floor."""
    bodies = [hf.Body("floor", hf.Box(FLOOR), pose=at(0, 0, -FLOOR[2] / 2), fixed=True)]
    for k, box in enumerate(boxes):
        size = np.array(box["size"])
        middle = np.array(box["corner"]) + size / 2
        bodies.append(hf.Body(f"box{k}", hf.Box(size), mass=box["mass"], pose=at(*middle)))
    return hf.Scene(bodies, mu)
