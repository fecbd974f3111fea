"""Random scenes of which many all but fall: boxes over edges between neighbours, slopes of blocks, and pallets.

All bodies are boxes that touch exactly, so a simulator can find the contacts by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.random import Generator

from holdfast import Body, Box, Scene

G0 = 9.81  # [m/s²]
DENSITY = (300.0, 2500.0)  # [kg/m³]


def box(name: str, low: Any, size: Any, rng: Generator | None = None) -> Body:
    """A box from its lowest corner; of random density, or fixed if there is no ``rng``."""
    pose = np.eye(4)
    pose[:3, 3] = np.asarray(low) + np.asarray(size) / 2
    if rng is None:
        return Body(name, Box(size), pose=pose, fixed=True)
    return Body(name, Box(size), pose=pose, density=float(rng.uniform(*DENSITY)))


def over_an_edge(rng: Generator) -> Scene:
    """A box whose centre lies near an edge, between neighbours that touch its sides, and one behind or on top."""
    length, width, height = rng.uniform((0.2, 0.1, 0.1), (0.5, 0.4, 0.4))
    x = float(rng.choice([rng.uniform(-0.05, 0.08), rng.uniform(-0.003, 0.003)])) * length
    bodies = [
        box("plate", (-2, -2, -0.1), (2, 4, 0.1)),
        box("over", (x - length / 2, 0, 0), (length, width, height), rng),
    ]
    for k in range(int(rng.integers(1, 3))):
        size = rng.uniform((0.2, 0.1, 0.5 * height), (0.8, 0.5, 1.5 * height))
        back = -rng.uniform(0.0, 0.4) * size[0]  # where its front face lies
        bodies.append(box(f"beside{k}", (back - size[0], width if k else -size[1], 0), size, rng))
    if rng.random() < 0.5:
        size = np.array([0.4, width, 0.4]) * rng.uniform((0.3, 0.5, 0.3), 1)
        bodies.append(box("behind", (x - length / 2 - size[0], 0, 0), size, rng))
    if rng.random() < 0.3:
        size = (length, width, height) * rng.uniform(0.3, 0.9, 3)
        bodies.append(box("top", (x - length / 2, 0.05 * width, height), size, rng))
    return Scene(bodies, float(rng.uniform(0.2, 0.9)))


def slope(rng: Generator) -> Scene:
    """Blocks in a row on a slope or on its steps, of which tall ones lean on short ones below."""
    count, dip = int(rng.integers(2, 9)), np.radians(rng.uniform(10, 40))
    width, depth = rng.uniform((0.1, 0.1), (0.3, 0.4))
    step = width * float(rng.choice([0.0, rng.uniform(0.02, 0.2)]))
    tall = rng.uniform(0.8, 3.0) / np.tan(dip)  # those above 1 / tan dip would topple alone
    shape = np.clip(np.sin(np.pi * (np.arange(count) + rng.uniform(0.3, 1)) / (count + 1)), 0.2, 1)
    heights = np.maximum(width * tall * shape, 1.2 * step)
    bodies = [] if step else [box("base", (-1, -1, -0.1), (count * width + 2, 2, 0.1))]
    for k, height in enumerate(heights):
        x, z, free = k * width, k * step, 0.002 * width  # blocks do not touch the riser behind them
        if step:
            bodies.append(box(f"step{k}", (x + free, -1, z - 1), (width - free, 2, 1)))
        bodies.append(box(f"block{k}", (x, -depth / 2, z), (width, depth, height), rng))
    return Scene(bodies, float(np.tan(dip) * rng.uniform(0.95, 1.8)), G0 * np.array([-np.sin(dip), 0, -np.cos(dip)]))


def pallet(rng: Generator) -> Scene:
    """Layers of equal boxes side by side, some of which are missing or lie across, that a vehicle brakes."""
    size, bodies = rng.uniform((0.2, 0.2, 0.1), (0.5, 0.4, 0.4)), [box("deck", (-0.3, -0.3, -0.1), (2.5, 2.5, 0.1))]
    across, along, layers = (int(n) for n in rng.integers((1, 1, 1), (4, 3, 4)))
    lean = rng.uniform(0.0, 0.6)
    for level in range(layers):
        shift = size[0] * rng.uniform(-0.45, 0.45) * (level % 2)
        for i in range(across):
            for j in range(along):
                if rng.random() < 0.85 or not level:
                    low = (i * size[0] + shift, j * size[1], level * size[2])
                    bodies.append(box(f"b{level}_{i}_{j}", low, size, rng))
    way = rng.uniform(0, 2 * np.pi)
    return Scene(bodies, float(rng.uniform(0.2, 0.8)), G0 * np.array([lean * np.cos(way), lean * np.sin(way), -1]))


FAMILIES: Mapping[str, Callable[[Generator], Scene]] = MappingProxyType(
    {"over_an_edge": over_an_edge, "slope": slope, "pallet": pallet}
)


def drawn(family: str, number: int) -> Scene:
    """Scene ``number`` of a family."""
    return FAMILIES[family](np.random.default_rng([20261126, list(FAMILIES).index(family), number]))
