"""Blocks in a row on the steps of a slope, which topple on each other, and whether they stand by hand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from shared import FOLDER, contents

from holdfast import Body, Box, Scene

FILE = FOLDER / "experiments" / "published.json"
G0 = 9.81  # [m/s²]
DIP = np.radians(30)


class Row(NamedTuple):
    """Blocks of these ``heights`` [m] from the lowest place up, ``width`` [m] wide, on steps of ``step`` [m]."""

    heights: Sequence[float]
    width: float
    step: float

    def scene(self, mu: float) -> Scene:
        """The blocks, which do not touch the risers behind them, with gravity turned by the dip of the slope."""
        bodies, excluded = [], []
        for k, height in enumerate(self.heights):
            x, z = (k + 0.5) * self.width, k * self.step
            bodies.append(_box(f"step{k}", self.width, self.width, (x, z - self.width / 2), fixed=True))
            bodies.append(_box(f"block{k}", self.width, height, (x, z + height / 2)))
            if k:
                excluded.append((f"step{k}", f"block{k - 1}"))
        return Scene(bodies, mu, G0 * np.array([-np.sin(DIP), 0, -np.cos(DIP)]), excluded=excluded)

    def stand(self, mu: float) -> bool:
        """Whether they stand, by Goodman and Bray's recursion from the uppermost down.

        Each presses the next one at the top of their contact, with all its friction, by as much as it would topple
        about its lower edge or slide without.
        """
        heights, width, step = self
        pressed, tops = 0.0, step * np.arange(len(heights)) + heights
        for k in range(len(heights) - 1, -1, -1):
            weight = width * heights[k]
            above, below = (min(tops[k], tops[m]) - k * step if 0 <= m < len(heights) else 1.0 for m in (k + 1, k - 1))
            turning = weight / 2 * (heights[k] * np.sin(DIP) - width * np.cos(DIP))
            topples = (pressed * (above - mu * width) + turning) / below
            slides = pressed - weight * (mu * np.cos(DIP) - np.sin(DIP)) / (1 - mu**2)
            pressed = max(topples, slides, 0.0)
        return pressed == 0.0


FIVE = Row((0.18, 0.36, 0.54, 0.72, 0.9), 0.3, 0.03)


def sixteen() -> Row:
    """Goodman and Bray's blocks, a tenth as large: that changes no verdict."""
    return Row([height / 10 for height in contents(FILE)["goodman_bray"]["heights"]], 1, 0.1)


def _box(name: str, width: float, height: float, centre: tuple[float, float], *, fixed: bool = False) -> Body:
    pose = np.eye(4)
    pose[[0, 2], 3] = centre
    return Body(name, Box((width, 1, height)), density=None if fixed else 1000.0, pose=pose, fixed=fixed)
