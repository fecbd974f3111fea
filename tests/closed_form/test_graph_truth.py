"""Engine ``graph`` against the decoupled truth (bench/truth/decoupled.py) on random normal pushes from outside."""

from __future__ import annotations

import numpy as np
import pytest

import holdfast as hf
from bench.scenes.pushes import on_boxes
from bench.truth import decoupled
from holdfast.scene.shipped import shipped_scene

EDGE = 1e-3  # [m] closer to an edge the class of a push may differ by rounding


def nearby(body: hf.Body, point: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Points (8, 3) on the same face of a box, about EDGE around ``point``."""
    steps = EDGE * np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    local = np.clip(point + steps - body.pose[:3, 3], -body.shape.size / 2, body.shape.size / 2)
    return np.where(np.abs(normal) > 0, point, local + body.pose[:3, 3])


@pytest.mark.parametrize(
    ("scene", "names", "limit"),
    [
        ("cube", ["cube"], 0.002),
        ("stack", ["cube1", "cube2", "cube3"], 0.010),
        ("table", ["slab"], 0.012),
        ("table", ["leg_left", "leg_right"], 0.012),
    ],
)
def test_mean_error_and_class_of_a_thousand_pushes(scene: str, names: list[str], limit: float) -> None:
    built = shipped_scene(scene)
    assembly = hf.assemble(built)
    errors, clear_mismatches = [], 0
    for name, points, normals in on_boxes(built, names, 1000, seed=1):
        answer = hf.robustness(assembly, name, points, -normals, engine="graph").force
        exact = decoupled.robustness(scene, name, points, -normals)
        both = np.isfinite(answer) & np.isfinite(exact)
        errors.append(np.abs(answer[both] / exact[both] - 1))
        for k in np.flatnonzero(np.isfinite(answer) != np.isfinite(exact)):
            near = nearby(built.body(name), points[k], normals[k])
            classes = np.isfinite(decoupled.robustness(scene, name, near, -normals[k]))
            clear_mismatches += int((classes != np.isfinite(answer[k])).all())
    error = np.concatenate(errors)
    assert len(error) > 300
    assert error.mean() <= limit
    assert clear_mismatches == 0
