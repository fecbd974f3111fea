"""Loads that nothing squeezes: boxes beside rails, rows between walls, totes with a little air, things on tables."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import holdfast as hf
from holdfast.scene.shipped import shipped_scene

AIR = (0.0, 1e-6, 1e-5, 5e-5, 1e-4, 1e-3)  # m beside each thing
MU = 0.4


def fixed(name: str, size: tuple[float, float, float], at: tuple[float, float, float]) -> hf.Body:
    """Return a fixed box."""
    return hf.Body(name, hf.Box(size), position=at, fixed=True)


def rails(air: float = 0.0, *, length: float = 0.3, mass: float = 3.0) -> hf.Scene:
    """A box on a tray between two rails along x, with ``air`` [m] beside one of them."""
    half = 0.11
    return hf.Scene(
        [
            fixed("tray", (0.6, 0.4, 0.02), (0, 0, -0.01)),
            fixed("left", (0.6, 0.02, 0.05), (0, half + air, 0.025)),
            fixed("right", (0.6, 0.02, 0.05), (0, -half, 0.025)),
            hf.Body("box", hf.Box((length, 0.2, 0.1)), mass=mass, position=(0, 0, 0.05)),
        ],
        MU,
    )


def row(count: int, air: float = 0.0, *, depth: float = 0.17, height: float = 0.24) -> hf.Scene:
    """A row of books on a board between two walls, with ``air`` [m] on either side of each."""
    width = 0.04
    ends = count * (width + air) / 2 + air / 2
    walls = [fixed(f"wall {s:+d}", (0.02, 0.25, 0.3), (s * (ends + 0.01), 0, 0.15)) for s in (-1, 1)]
    books = [
        hf.Body(
            f"book{k}",
            hf.Box((width, depth, height)),
            mass=0.8,
            position=((k - (count - 1) / 2) * (width + air), 0, height / 2),
        )
        for k in range(count)
    ]
    return hf.Scene([fixed("board", (0.6, 0.3, 0.02), (0, 0, -0.01)), *walls, *books], MU)


def tote(air: float = 0.0, *, across: int = 2, along: int = 2) -> hf.Scene:
    """Boxes that fill a tote from side to side, with ``air`` [m] between them and its walls, open along x."""
    size = 0.2
    half = (across * size + (across + 1) * air) / 2
    sides = [fixed(f"side {s:+d}", (0.8, 0.02, 0.08), (0, s * (half + 0.01), 0.04)) for s in (-1, 1)]
    boxes = [
        hf.Body(
            f"b{i}{j}",
            hf.Box((size, size, 0.1)),
            mass=2.0,
            position=((i - (along - 1) / 2) * (size + air), -half + air + size / 2 + j * (size + air), 0.05),
        )
        for i in range(along)
        for j in range(across)
    ]
    return hf.Scene([fixed("tray", (0.8, 0.6, 0.02), (0, 0, -0.01)), *sides, *boxes], MU)


def tabletop(seed: int) -> hf.Scene:
    """Five to nine boxes and tins, each on its own, on a table."""
    rng = np.random.default_rng(seed)
    things = [fixed("table", (2, 2, 0.04), (0, 0, -0.02))]
    for k in range(int(rng.integers(5, 10))):
        size = rng.uniform(0.06, 0.25, 3)
        shape = hf.Box(tuple(size)) if k % 3 else hf.Cylinder(size[0] / 2, size[2])
        at = (0.4 * (k % 3) - 0.4, 0.4 * (k // 3) - 0.4, size[2] / 2)
        things.append(hf.Body(f"thing{k}", shape, mass=rng.uniform(0.2, 3), position=at, rpy_degrees=(0, 0, 30 * k)))
    return hf.Scene(things, MU)


def fitted() -> Iterator[tuple[str, hf.Scene]]:
    """Yield thirty scenes with their names."""
    for air in AIR:
        yield f"rails, {1e3 * air:g} mm", rails(air)
        yield f"row of 3, {1e3 * air:g} mm", row(3, air)
        if air <= 1e-4:
            yield f"tote of 4, {1e3 * air:g} mm", tote(air)
    yield "short box between rails", rails(5e-5, length=0.08)
    yield "row of 5", row(5, 2e-5)
    yield "tote of 2", tote(1e-4, along=1)
    yield "tote of 3 in a row", tote(2e-5, across=3, along=1)
    for seed in range(5):
        yield f"tabletop {seed}", tabletop(seed)
    for name in ("table", "stack", "tabletop", "arch"):
        yield name, shipped_scene(name)
