"""Arches of voussoirs between fixed ends."""

from __future__ import annotations

import numpy as np

import holdfast as hf


def arch_of(count: int, thickness: float = 0.15, mu: float = 0.7) -> hf.Scene:
    """A semicircular arch of the mean radius 1 m, with straight sides and radial joints; ``thickness`` in radii."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, count + 1)
    inner, outer = ((1 + side * thickness / 2) * np.column_stack([np.sin(angles), np.cos(angles)]) for side in (-1, 1))
    bodies = []
    for k in range(count):
        corners = np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]])
        points = np.vstack([np.column_stack([corners[:, 0], np.full(4, y), corners[:, 1]]) for y in (-0.2, 0.2)])
        sides = [t for i in range(4) for t in ([i, 4 + i, 4 + (i + 1) % 4], [i, 4 + (i + 1) % 4, (i + 1) % 4])]
        faces = np.array([[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6], *sides])
        bodies.append(hf.Body(f"v{k}", hf.Mesh(points, faces), density=2000.0))
    for name, x in (("left", -1.0), ("right", 1.0)):
        bodies.append(hf.Body(name, hf.Box((0.4, 0.6, 0.2)), fixed=True, position=(x, 0, -0.1)))
    return hf.Scene(bodies, mu, name=f"arch of {count}")
