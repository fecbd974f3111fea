"""From mesh files to a 1,000-point map: time beside the paper's."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
import trimesh

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.scene.shipped import shipped_scene

PAPER = {"cube": 0.13, "stack": 0.20, "table": 0.23}
POINTS = 1000
RUNS = 15


def write_as_meshes(name: str, folder: Path) -> tuple[Path, float]:
    """Save a shipped scene with its boxes as STL files; return its path and a spacing for at least 1,000 points."""
    scene = shipped_scene(name)
    bodies = []
    for body in scene.bodies:
        path = folder / f"{body.name}.stl"
        trimesh.Trimesh(body.shape.surface.vertices, body.shape.surface.faces).export(path)
        bodies.append(hf.Body(body.name, hf.Mesh.from_file(path), mass=body.mass, pose=body.pose, fixed=body.fixed))
    path = folder / f"{name}.yaml"
    hf.save_scene(hf.Scene(bodies, scene.friction, scene.gravity, name), path)
    spacing = 0.01
    for _ in range(8):
        spacing *= np.sqrt(run(path, spacing)[1] / POINTS)
    while run(path, spacing)[1] < POINTS:
        spacing *= 0.99
    return path, float(spacing)


def run(path: Path, spacing: float) -> tuple[float, int]:
    """Seconds for detection, forces and map, and the number of points; files are read before the clock starts."""
    scene = hf.load_scene(path)
    for body in scene.bodies:
        body.shape.surface  # noqa: B018 - reading and welding the mesh belongs to loading
    start = time.perf_counter()
    result = hf.robustness_map(hf.assemble(scene), spacing=spacing, engine="graph")
    return time.perf_counter() - start, len(result.force)


def measured(name: str) -> list[Row]:
    with tempfile.TemporaryDirectory() as folder:
        path, spacing = write_as_meshes(name, Path(folder))
        samples = [run(path, spacing) for _ in range(RUNS)]
        seconds = [sample[0] for sample in samples]
    median, printed = float(np.median(seconds)), PAPER[name]
    return [
        {
            "case": name,
            "points": samples[0][1],
            "median s": median,
            "p95 s": float(np.percentile(seconds, 95)),
            "paper s": printed,
            "times faster": printed / median,
        }
    ]


def cases() -> Mapping[str, Case]:
    return {name: partial(measured, name) for name in PAPER}


SUITE = Suite("pipeline", __doc__, cases)
