"""Scenes with changed values, which the tests of sensitivity and of the worst case share."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import holdfast as hf
from holdfast.scene.shipped import shipped_scene

PUSHES: list[tuple[str, str, list[float], list[float]]] = [
    ("cube", "cube", [-0.05, 0.045, 0.02], [1, 0, 0]),  # slides and turns
    ("cube", "cube", [-0.05, 0.0, 0.098], [1, 0.02, 0]),  # topples
    ("stack", "cube3", [-0.05, 0.03, 0.23], [1, 0.1, -0.2]),
    ("stack", "cube2", [-0.05, 0.013, 0.16], [1, 0.05, 0.1]),
    ("table", "slab", [-0.25, 0.02, 0.225], [1, 0.03, 0.0]),  # sways
    ("table", "slab", [0.2, -0.1, 0.225], [0.02, 1, 0]),
    ("table", "slab", [-0.24, 0.01, 0.25], [0.0, 0, -1]),  # tips about a leg
    ("table", "leg_left", [-0.2, 0.03, 0.1], [1, 0, 0]),
]


def scene_with(
    name: str,
    mu: dict[Any, float] | None = None,
    mass: dict[str, float] | None = None,
    com: dict[str, Any] | None = None,
) -> hf.Scene:
    """A shipped scene with changed values; com is an offset in the world (the bodies here stand upright)."""
    scene = shipped_scene(name)
    bodies = []
    for body in scene.bodies:
        if not body.fixed:
            shift = np.zeros(3) if com is None else np.asarray(com.get(body.name, np.zeros(3)))
            body = replace(body, mass=body.mass + (mass or {}).get(body.name, 0.0), com=body.com_body + shift)
        bodies.append(body)
    pairs = {tuple(sorted(p)): v for p, v in (mu or {}).items()}
    return hf.Scene(bodies, hf.Friction(default=scene.friction.default, pairs=pairs))


def pushed(scene: hf.Scene, body: str, point: Any, direction: Any) -> float:
    return float(hf.robustness(hf.assemble(scene), body, point, direction, engine="limit").force[0])
