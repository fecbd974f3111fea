"""Two cylinders on a plane, all but touching, and a third on top: the friction that textbooks ask for."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

import holdfast as hf
from bench.experiments.source import Source, threshold
from bench.suite import Case, Row

RADIUS, GAP = 0.05, 0.003  # [m]
ANGLE = float(np.arcsin((2 * RADIUS + GAP) / (4 * RADIUS)))  # of the line of centres from the vertical
BETWEEN, GROUND = "0.2773", "0.09243"  # tan(t/2) between the cylinders, a third of it with the ground


def cylinders(t: float, mu: float, mu_ground: float) -> hf.Scene:
    """The three, with their axes along y and the line of centres at an angle ``t`` from the vertical."""

    def one(name: str, x: float, z: float) -> hf.Body:
        return hf.Body(
            name, hf.Cylinder(RADIUS, 0.2), mass=1.0, position=(x, 0, z), rpy_degrees=(90, 0, 0), material="log"
        )

    half, high = 2 * RADIUS * np.sin(t), 2 * RADIUS * np.cos(t)
    bodies = [one("left", -half, RADIUS), one("right", half, RADIUS), one("top", 0, RADIUS + high)]
    friction = hf.Friction(pairs={("log", "log"): mu, ("log", "ground"): mu_ground})
    return hf.Scene([hf.Body("ground", hf.HalfSpace(), fixed=True), *bodies], friction=friction)


def _least(where: str, printed: str) -> list[Row]:
    def build(mu: float) -> hf.Scene:
        return cylinders(ANGLE, mu, 1.0) if where == "between them" else cylinders(ANGLE, 1.0, mu)

    ends = (0.8 * float(printed), 1.2 * float(printed))
    return [threshold(f"three cylinders: friction {where}", printed, build, ends)]


def cases() -> Mapping[str, Case]:
    """Friction between the cylinders, and with the ground."""
    printed = {"between them": BETWEEN, "with the ground": GROUND}
    return {f"cylinders {where}": partial(_least, where, text) for where, text in printed.items()}


SOURCE = Source(
    "three cylinders",
    "textbooks of statics: tan(t/2) between the cylinders and tan(t/2)/3 with the ground",
    "the least friction at which they stand",
    "radius 50 mm, the lower two 3 mm apart",
    cases,
)
