"""Random scenes with pushes: one to five bodies that are stacked, float, overlap, balance on edges or stand in walls.

An input is plain data: ``scene`` in the native format, and ``pushes``, each with a ``body``, a ``place`` on its surface
(a triangle and two shares, all in 0..1) and a ``direction``, or None for a push along the inward normal.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fuzz.draw import Rng, chance, one_of, spread
from fuzz.shapes import LEAST, MOST, clipped, shape

Data = dict[str, Any]
MOST_BODIES = 5
UPRIGHT = [1.0, 0.0, 0.0, 0.0]


def scene(rng: Rng) -> Data:
    """Draw a scene and its pushes."""
    scale = spread(rng, LEAST * 3, MOST / 3)
    alike = chance(rng, 0.6)  # bodies of like sizes, or of any
    weights = spread(rng, 1e-6, 1e6)
    count = min(1 + int(rng.geometric(0.45)), MOST_BODIES)
    arrange = one_of(rng, ARRANGEMENTS)
    bodies: list[Data] = [] if chance(rng, 0.03) else [ground(rng, scale)]
    for k in range(count):
        size = scale * spread(rng, 0.5, 2) if alike else spread(rng, LEAST, MOST)
        drawn, half = shape(rng, size)
        body = {"name": f"b{k}", "shape": drawn, "mass": mass(rng, weights)}
        body |= arrange(rng, bodies, half, scale, k)
        bodies.append(body | {"half": half})
    for body in bodies:
        body.pop("half", None)
    if chance(rng, 0.05):
        one_of(rng, bodies)["fixed"] = True
    found: Data = {"format": "holdfast-scene/1", "friction": friction(rng, bodies), "bodies": bodies}
    if chance(rng, 0.1):
        found["gravity"] = [float(f"{v:.6g}") for v in rng.normal(size=3) * spread(rng, 1e-3, 100)]
    return {"scene": found, "pushes": pushes(rng, bodies)}


def ground(rng: Rng, scale: float) -> Data:
    """A half space, or a fixed block with its top at z = 0: mostly larger than the scene, sometimes a narrow one."""
    width = clipped(scale * (spread(rng, 0.2, 1.5) if chance(rng, 0.2) else spread(rng, 4, 30)))
    height = clipped(width * spread(rng, 0.05, 1))
    tilt = tilted(rng, 0.3) if chance(rng, 0.15) else UPRIGHT
    if chance(rng, 0.2):
        level = {"name": "ground", "shape": {"type": "halfspace"}, "fixed": True}
        return level | {"position": [0.0, 0.0, 0.0], "orientation": tilt, "half": 0.0}
    body = {"name": "ground", "shape": {"type": "box", "size": [width, width, height]}, "fixed": True}
    return body | {"position": [0.0, 0.0, -height / 2], "orientation": tilt, "half": height / 2}


def mass(rng: Rng, middle: float) -> float:
    """Like masses, or any; [kg]."""
    return spread(rng, 1e-6, 1e6) if chance(rng, 0.2) else min(max(middle * spread(rng, 0.3, 3), 1e-6), 1e6)


def friction(rng: Rng, bodies: list[Data]) -> Any:
    """One coefficient, or some pairs of their own."""
    coefficient = one_of(rng, (lambda: 0.0, lambda: spread(rng, 0.05, 2), lambda: spread(rng, 1e-3, 1e3)))
    default = coefficient() if chance(rng, 0.35) else spread(rng, 0.1, 1.2)
    if len(bodies) < 2 or chance(rng, 0.8):
        return default
    a, b = (bodies[int(k)]["name"] for k in rng.choice(len(bodies), 2, replace=False))
    return {"default": default, "pairs": [{"between": [a, b], "mu": coefficient()}]}


def pushes(rng: Rng, bodies: list[Data]) -> list[Data]:
    """One or two pushes."""
    names = [body["name"] for body in bodies if not body.get("fixed")] or [bodies[0]["name"]]
    found = []
    for _ in range(int(rng.integers(1, 3))):
        along = None if chance(rng, 0.5) else [float(f"{v:.6g}") for v in rng.normal(size=3)]
        place = [float(f"{v:.6g}") for v in rng.random(3)]
        if chance(rng, 0.2):
            place[1:] = [float(v) for v in rng.integers(0, 2, 2)]  # a corner
        found.append({"body": one_of(rng, names), "place": place, "direction": along})
    return found


def tilted(rng: Rng, most: float) -> list[float]:
    """A unit quaternion (w, x, y, z) of a rotation by up to ``most`` [rad] about any axis."""
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    angle = rng.uniform(0, most)
    return [float(np.cos(angle / 2)), *(float(v) for v in np.sin(angle / 2) * axis)]


def upright(rng: Rng) -> list[float]:
    angle = one_of(rng, (0.0, 0.0, np.pi / 4, float(rng.uniform(0, 2 * np.pi))))
    return [float(np.cos(angle / 2)), 0.0, 0.0, float(np.sin(angle / 2))]


def top_of(body: Data) -> float:
    return float(body["position"][2] + body["half"])


def stacked(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """Exactly on top of the one before."""
    below = bodies[-1] if bodies else None
    x, y = (rng.normal(size=2) * 0.1 * scale if below else (0.0, 0.0)) if chance(rng, 0.6) else (0.0, 0.0)
    base = (*below["position"][:2], top_of(below)) if below else (0.0, 0.0, 0.0)
    return {"position": [float(base[0] + x), float(base[1] + y), float(base[2] + half)], "orientation": upright(rng)}


def side_by_side(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """On the ground in a row, faces that may be coplanar, touching, overlapping or apart."""
    step = scale * one_of(rng, (1.0, 1.0, 0.999, 1.001, 0.5, 2.0))
    return {"position": [number * step, 0.0, half], "orientation": UPRIGHT}


def floating(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """Above the ground by anything from nothing measurable to the size of the scene."""
    found = stacked(rng, bodies, half, scale, number)
    found["position"][2] += spread(rng, 1e-9, 1.0) * scale
    return found


def overlapping(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """Into the one before by anything from a rounding error to everything."""
    found = stacked(rng, bodies, half, scale, number)
    found["position"][2] -= spread(rng, 1e-9, 1.0) * min(half, scale)
    return found


def balanced(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """On an edge or with its centre exactly over the edge of the one before."""
    found = stacked(rng, bodies, half, scale, 0)
    below = bodies[-1] if bodies else None
    if below and below["shape"]["type"] == "box" and chance(rng, 0.6):
        found["position"][0] = below["position"][0] + below["shape"]["size"][0] / 2
        return found
    turn = float(one_of(rng, (np.pi / 4, np.pi / 3, np.pi / 2, np.arctan(np.sqrt(2)))))
    found["orientation"] = [float(np.cos(turn / 2)), float(np.sin(turn / 2)), 0.0, 0.0]
    found["position"][2] += half * (np.sqrt(2) - 1) if turn == np.pi / 4 else 0.0
    return found


def duplicated(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """At the very place of the one before, or of the first."""
    if number == 0 or not bodies:
        return stacked(rng, bodies, half, scale, number)
    same = bodies[-1]
    copied = {key: same[key] for key in ("position", "orientation")}
    return copied | ({"shape": same["shape"]} if chance(rng, 0.7) and not same.get("fixed") else {})


def scattered(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """Anywhere, turned anyhow."""
    place = rng.normal(size=3) * scale * 0.6
    return {"position": [float(v) for v in place], "orientation": tilted(rng, np.pi)}


def leaning(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """Stacked, and turned a little: contacts between nearly parallel faces."""
    found = stacked(rng, bodies, half, scale, number)
    found["orientation"] = tilted(rng, spread(rng, 1e-9, 0.2))
    return found


def walled(rng: Rng, bodies: list[Data], half: float, scale: float, number: int) -> Data:
    """Between two bodies that stand on either side: a slot that may clamp."""
    x = (0.0, -1.0, 1.0)[number % 3] * scale * one_of(rng, (1.0, 1.0, 0.9999, 1.0001))
    return {"position": [x, 0.0, half], "orientation": UPRIGHT, "fixed": number % 3 > 0 and chance(rng, 0.5)}


Arrangement = Callable[[Rng, list[Data], float, float, int], Data]
ARRANGEMENTS: tuple[Arrangement, ...] = (
    *(stacked, stacked, side_by_side, floating, overlapping, balanced, duplicated, scattered, leaning, walled),
)
