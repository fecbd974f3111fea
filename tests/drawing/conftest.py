"""Small made-up pictures: a table on a floor, and the odd cases."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from holdfast.drawing.picture import Arrow, HeatSurface, Picture, Solid

Values = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def box_faces(
    low: tuple[float, float, float], high: tuple[float, float, float], cut: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Vertices, triangles and cells of a box whose faces are cut into squares of about ``cut`` [m]."""
    lo, hi = np.asarray(low), np.asarray(high)
    vertices, triangles, cell = [], [], []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        na, nb = (max(1, round((hi[k] - lo[k]) / cut)) for k in (a, b))
        for side in (0, 1):
            for i in range(na):
                for j in range(nb):
                    corner = np.zeros((4, 3))
                    corner[:, axis] = (lo, hi)[side][axis]
                    corner[:, a] = lo[a] + (hi[a] - lo[a]) * np.array([i, i + 1, i + 1, i]) / na
                    corner[:, b] = lo[b] + (hi[b] - lo[b]) * np.array([j, j, j + 1, j + 1]) / nb
                    start = 4 * len(vertices)
                    quad = np.array([[0, 1, 2], [0, 2, 3]]) if side else np.array([[0, 2, 1], [0, 3, 2]])
                    cell += [len(vertices)] * 2
                    vertices.append(corner)
                    triangles.append(quad + start)
    return np.concatenate(vertices), np.concatenate(triangles), np.array(cell)


def make_box(
    name: str, low: tuple[float, float, float], high: tuple[float, float, float], values: Values, cut: float = 0.05
) -> HeatSurface:
    """A box coloured by ``values`` of its cell centres."""
    vertices, triangles, cell = box_faces(low, high, cut)
    points = vertices.reshape(-1, 4, 3).mean(axis=1)
    force = values(points)
    pairs = zip(force, points, strict=True)
    hover = tuple(f"{name}<br>R = {f:.3g} N<br>at {np.round(p, 3).tolist()}" for f, p in pairs)
    return HeatSurface(name, vertices, triangles, cell, points, force, hover)


def solid_box(
    name: str, low: tuple[float, float, float], high: tuple[float, float, float], fixed: bool = True
) -> Solid:
    """A box without values."""
    vertices, triangles, _ = box_faces(low, high, 1e9)
    return Solid(name, vertices, triangles, fixed)


def rectangle(low: tuple[float, float], high: tuple[float, float], z: float) -> NDArray[np.float64]:
    """A closed polyline (5, 3) at height z."""
    (a, b), (c, d) = low, high
    return np.array([[a, b, z], [c, b, z], [c, d, z], [a, d, z], [a, b, z]])


def forces_at(outline: NDArray[np.float64], length: float) -> tuple[Arrow, ...]:
    """Upward arrows at the corners of an outline."""
    up = np.array([0.0, 0.0, length])
    return tuple(Arrow(corner - up, corner, f"{100 * length:.1f} N") for corner in outline[:-1])


def make_table() -> Picture:
    """A slab on two legs on a floor."""
    slab = make_box("slab", (-0.8, -0.4, 0.7), (0.8, 0.4, 0.78), lambda p: 140.0 * np.exp(-4.0 * np.abs(p[:, 0])) + 4.0)
    legs = []
    for side in (-1, 1):
        x = 0.45 * side
        legs.append(
            make_box(
                f"leg {'left' if side < 0 else 'right'}",
                (x - 0.06, -0.35, 0.0),
                (x + 0.06, 0.35, 0.7),
                lambda p: np.where(np.abs(p[:, 1]) > 0.34, np.inf, 20.0 + 90.0 * (0.75 - p[:, 2])),
            )
        )
    floor = solid_box("floor", (-6, -6, -0.1), (6, 6, 0.0))
    outlines = [rectangle((x - 0.06, -0.35), (x + 0.06, 0.35), z) for x in (-0.45, 0.45) for z in (0.0, 0.7)]
    arrows = tuple(arrow for outline in outlines for arrow in forces_at(outline, 0.12 if outline[0, 2] else 0.16))
    down = np.array([0.0, 0.0, 0.18])
    tips = [(0.79, 0.38, 0.78), (-0.79, 0.38, 0.78), (-0.79, -0.38, 0.78), (0.79, -0.38, 0.78)]
    weakest = [
        Arrow(np.array(t) + down, np.array(t), f"slab: {9.7 + k:.1f} N straight down") for k, t in enumerate(tips)
    ]
    side_on = np.array([-0.51, 0.1, 0.6])
    weakest.append(Arrow(side_on - np.array([0.2, 0, 0]), side_on, "leg left: 33.1 N inwards"))
    below = np.array([0.1, 0.2, 0.7])
    weakest.append(Arrow(below - np.array([0, 0, 0.18]), below, "slab: 98.4 N straight up"))
    return Picture(
        "Table: a slab on two legs",
        "largest push anywhere before something slips, tips or lifts; friction 0.5, gravity 9.81 m/s², 4608 points",
        (slab, *legs),
        (floor,),
        tuple(outlines),
        np.concatenate([o[:-1] for o in outlines]),
        arrows,
        tuple(weakest),
    )


def make_single(value: float) -> Picture:
    """One triangle, one cell, without a name, which would stand on it."""
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    surface = HeatSurface(
        "", vertices, np.array([[0, 1, 2]]), np.array([0]), vertices.mean(axis=0)[None], np.array([value]), ("R",)
    )
    return Picture("one cell", "", (surface,), ())


@pytest.fixture
def table() -> Picture:
    return make_table()


@pytest.fixture
def single() -> Callable[[float], Picture]:
    return make_single


@pytest.fixture
def heat_box() -> Callable[..., HeatSurface]:
    return make_box
