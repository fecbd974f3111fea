"""Scenes that fall by statics: towers over their edge, planks that lean below their friction angle."""

from __future__ import annotations

import numpy as np

from holdfast.base.arrays import Float
from holdfast.scene.body import Body
from holdfast.scene.friction import Friction
from holdfast.scene.scene import Scene
from holdfast.scene.shapes import Box

OVER = 0.005  # [m] how far the centre of mass of a tower lies beyond the edge that it stands on
SHARE = 0.8  # slope of a plank, as a share of the smallest one at which it would stay


def placed(x: float, z: float, turn: float = 0.0) -> Float:
    """Return the pose (4, 4) at (x, 0, z) [m], turned by ``turn`` [rad] about the y axis."""
    pose = np.eye(4)
    c, s = np.cos(turn), np.sin(turn)
    pose[:3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    pose[:3, 3] = x, 0.0, z
    return pose


def tower(count: int, width: float, height: float) -> Scene:
    """Return a tower of blocks whose common centre of mass lies OVER beyond the edge of a table, at x = 0."""
    bodies = [Body("table", Box((0.6, 0.6, 0.05)), pose=placed(-0.3, -0.025), fixed=True)]
    for k in range(count):
        pose = placed(OVER, (k + 0.5) * height)
        bodies.append(Body(f"block{k}", Box((width, width, height)), mass=1.0, pose=pose))
    return Scene(bodies, 0.6, name=f"tower of {count}, {width:g} x {height:g} m")


def plank(length: float, floor: float, wall: float) -> Scene:
    """Return a thin plank that leans on a wall too flat for the coefficients of friction of floor and wall.

    A rod at the slope θ slips on both if tan θ < (1 - μ_f μ_w) / (2 μ_f); here tan θ is SHARE of that.
    """
    slope = float(np.arctan(SHARE * (1 - floor * wall) / (2 * floor)))
    thick = 0.01 * length
    corners = np.array([[-length / 2, -thick / 2], [-length / 2, thick / 2], [length / 2, -thick / 2]])
    c, s = np.cos(slope), np.sin(slope)
    turned = corners @ np.array([[c, s], [-s, c]])  # x, z of corners of the plank that rises towards +x
    x, z = -float((turned[:, 0]).max()), -float(turned[:, 1].min())
    bodies = [
        Body("floor", Box((4 * length, 1.0, 0.1)), pose=placed(-length, -0.05), fixed=True),
        Body("wall", Box((0.1, 1.0, 2 * length)), pose=placed(0.05, length), fixed=True),
        Body("plank", Box((length, 0.1, thick)), mass=2.0, pose=placed(x, z, -slope)),
    ]
    mu = Friction(pairs={("plank", "floor"): floor, ("plank", "wall"): wall})
    return Scene(bodies, mu, name=f"plank of {length:g} m, mu {floor:g} and {wall:g}")


def falling_scenes() -> tuple[tuple[Scene, str], ...]:
    """Return 20 scenes that fall, each with the name of a body that must be named."""
    towers = [(n, w, h) for n in (1, 2, 4, 6) for w, h in ((0.1, 0.1), (0.08, 0.05), (0.2, 0.12))][:10]
    planks = [
        (length, f, w) for length in (0.5, 1.0) for f, w in ((0.2, 0.2), (0.3, 0.1), (0.3, 0.3), (0.4, 0.2), (0.5, 0.0))
    ]
    return (*((tower(*t), "block0") for t in towers), *((plank(*p), "plank") for p in planks))
