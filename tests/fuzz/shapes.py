"""Random shapes as plain data of the native scene format, with their half heights."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from fuzz.draw import Rng, chance, one_of, spread

Data = dict[str, Any]
LEAST, MOST = 1e-4, 10.0  # [m] sizes


def shape(rng: Rng, size: float) -> tuple[Data, float]:
    """Draw a shape of about ``size`` [m] and return it with half its height [m]; its frame is at half the height."""
    draw = one_of(rng, (box, box, box, cylinder, ball, cone, hull, wedge, ell, capsule, ellipsoid, compound))
    return draw(rng, size)


def box(rng: Rng, size: float) -> tuple[Data, float]:
    flat = spread(rng, 0.02, 1.0) if chance(rng, 0.3) else 1.0
    edges = [clipped(size * spread(rng, 0.3, 3)) for _ in range(2)] + [clipped(size * flat * spread(rng, 0.3, 3))]
    return {"type": "box", "size": edges}, edges[2] / 2


def cylinder(rng: Rng, size: float) -> tuple[Data, float]:
    height = clipped(size * spread(rng, 0.1, 3))
    segments = int(one_of(rng, (3, 4, 5, 8, 16, 32)))
    return {"type": "cylinder", "radius": clipped(size / 2), "height": height, "segments": segments}, height / 2


def ball(rng: Rng, size: float) -> tuple[Data, float]:
    return {"type": "sphere", "radius": clipped(size / 2), "subdivisions": int(rng.integers(0, 3))}, clipped(size / 2)


def capsule(rng: Rng, size: float) -> tuple[Data, float]:
    radius, length = clipped(size / 2), clipped(size * spread(rng, 0.1, 3))
    found = {"type": "capsule", "radius": radius, "length": length, "segments": int(one_of(rng, (4, 8, 12)))}
    return found, radius + length / 2


def ellipsoid(rng: Rng, size: float) -> tuple[Data, float]:
    radii = [clipped(size * spread(rng, 0.1, 1)) for _ in range(3)]
    return {"type": "ellipsoid", "radii": radii, "subdivisions": int(rng.integers(0, 3))}, radii[2]


def compound(rng: Rng, size: float) -> tuple[Data, float]:
    """A column of parts, exactly on top of each other, with a gap, or overlapping; some share a material."""
    parts: list[Data] = []
    height = 0.0
    for _ in range(int(rng.integers(1, 4))):
        drawn, half = one_of(rng, (box, cylinder, hull))(rng, size)
        pose = np.eye(4)
        pose[:3, 3] = rng.normal() * 0.2 * size, 0, height + half
        height += 2 * half * one_of(rng, (1.0, 1.0, 0.8, 1.1))
        parts.append({"shape": drawn, "pose": pose.tolist()} | ({"material": "m"} if chance(rng, 0.3) else {}))
    for part in parts:
        part["pose"][2][3] -= height / 2
    return {"type": "compound", "parts": parts}, height / 2


def cone(rng: Rng, size: float) -> tuple[Data, float]:
    """A cone or pyramid; half of them stand on their tips."""
    count, height = int(rng.integers(3, 12)), size * spread(rng, 0.3, 3)
    turn = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.full(count, -height / size)]) * size / 2
    tip = np.array([[0, 0, height / 2]])
    points = np.vstack([rim, tip]) * (1 if chance(rng, 0.5) else -1)
    return hulled(points), height / 2


def hull(rng: Rng, size: float) -> tuple[Data, float]:
    """The hull of random points, some of which share the lowest level."""
    points = rng.uniform(-0.5, 0.5, (int(rng.integers(4, 20)), 3)) * size
    points[: 3 + len(points) // 4, 2] = points[:, 2].min()
    points[:, 2] -= (points[:, 2].min() + points[:, 2].max()) / 2
    return hulled(points), float(np.ptp(points[:, 2]) / 2)


def wedge(rng: Rng, size: float) -> tuple[Data, float]:
    x, y, z = size * np.array([spread(rng, 0.3, 3) for _ in range(3)]) / 2
    points = np.array([(u * x, v * y, -z) for u in (-1, 1) for v in (-1, 1)] + [(-x, -y, z), (-x, y, z)])
    return hulled(points), float(z)


def ell(rng: Rng, size: float) -> tuple[Data, float]:
    """An L, which is not convex, extruded along y."""
    a, b = sorted(float(v) for v in rng.uniform(0.15, 0.85, 2))
    outline = np.array([(0, 0), (1, 0), (1, a), (b, a), (b, 1), (0, 1)]) - 0.5
    near, far = (np.column_stack([outline[:, 0], np.full(6, y), outline[:, 1]]) for y in (-0.5, 0.5))
    caps = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)])
    i = np.arange(6)
    j = (i + 1) % 6
    sides = np.vstack([np.column_stack([i, i + 6, j + 6]), np.column_stack([i, j + 6, j])])
    return mesh(np.vstack([near, far]) * size, np.vstack([caps, caps[:, ::-1] + 6, sides])), size / 2


def hulled(points: np.ndarray) -> Data:
    """The convex hull as a mesh, faces wound outwards."""
    found = ConvexHull(points, qhull_options="QJ")
    faces = found.simplices.copy()
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * found.equations[:, :3]).sum(1) < 0
    faces[inward] = faces[inward, ::-1]
    return mesh(points, faces)


def mesh(points: np.ndarray, faces: np.ndarray) -> Data:
    rounded = [[float(f"{v:.9g}") for v in point] for point in points.tolist()]
    return {"type": "mesh", "vertices": rounded, "faces": [[int(k) for k in face] for face in faces]}


def clipped(length: float) -> float:
    return float(f"{min(max(length, LEAST), MOST):.6g}")
