"""How long contact detection takes, from fresh meshes, and how it grows with bodies and with triangles."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

import holdfast as hf
from holdfast.contacts.detect import Tolerances, default_gap, find_contacts
from holdfast.shipped.blocks import wall

REPEATS = 3
COURSES = ((2, 4), (4, 5), (10, 5), (10, 10), (20, 10), (25, 20))
LEVELS = range(6)


def refined(shape: hf.Box, levels: int) -> hf.Mesh:
    """Every triangle split into 4^levels."""
    mesh = trimesh.Trimesh(shape.surface.vertices, shape.surface.faces, process=False)
    for _ in range(levels):
        mesh = mesh.subdivide()
    mesh.merge_vertices()
    return hf.Mesh(np.array(mesh.vertices), np.array(mesh.faces))


def tins(towers: int, high: int, triangles: int) -> hf.Scene:
    """Towers of tins, of ``triangles`` each, that touch their neighbours along their sides."""
    segments = triangles // 4
    shape = hf.Cylinder(0.05, 0.1, segments).surface
    floor = hf.Body("floor", hf.Box((2, 2, 0.1)), pose=_at(0, 0, -0.05), fixed=True)
    bodies = [
        hf.Body(
            f"t{x}_{z}",
            hf.Mesh(shape.vertices, shape.faces),
            mass=1.0,
            com=(0, 0, 0),
            pose=_at(0.1 * x, 0, 0.05 + 0.1 * z),
        )
        for x in range(towers)
        for z in range(high)
    ]
    return hf.Scene([floor, *bodies], 0.5)


def _at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def bricks(courses: int, across: int, make: Callable[[hf.Box], hf.Mesh]) -> hf.Scene:
    """A wall in quarter bond, every brick made anew."""
    scene = wall(courses, across, 0.25, "wall")
    bodies = [
        b if b.fixed else hf.Body(b.name, make(b.shape), mass=b.mass, com=(0, 0, 0), pose=b.pose) for b in scene.bodies
    ]
    return hf.Scene(bodies, 0.6)


def faces(levels: int) -> hf.Scene:
    """Two boxes face to face."""
    box = hf.Box((0.3, 0.2, 0.1))
    poses = [np.eye(4), np.eye(4)]
    poses[1][:3, 3] = (0.03, 0.02, 0.1)
    return hf.Scene(
        [
            hf.Body(name, refined(box, levels), mass=1.0, com=(0, 0, 0), pose=pose, fixed=name == "a")
            for name, pose in zip("ab", poses, strict=True)
        ],
        0.5,
    )


def timed(build: Callable[[], hf.Scene]) -> dict[str, Any]:
    """Medians over fresh scenes: contacts alone, with cleaning and reducing the meshes, and all of ``assemble``."""
    alone, whole = [], []
    contacts = None
    for _ in range(REPEATS):
        scene = build()
        start = time.perf_counter()
        contacts = find_contacts(scene, Tolerances(default_gap(scene), 1.0))
        alone.append(time.perf_counter() - start)
        scene = build()
        start = time.perf_counter()
        hf.assemble(scene)
        whole.append(time.perf_counter() - start)
    assert contacts is not None
    movable = [b for b in scene.bodies if not b.fixed]
    return {
        "bodies": len(scene.bodies),
        "triangles a body": int(np.median([len(b.shape.surface.faces) for b in movable])),
        "interfaces": len(contacts.interfaces),
        "patches": sum(len(i.patches) for i in contacts.interfaces),
        "contacts s": float(np.median(alone)),
        "assemble s": float(np.median(whole)),
    }


def measure() -> list[dict[str, Any]]:
    timed(lambda: faces(1))
    rows = [
        {"case": "50 bricks of 12 triangles"} | timed(lambda: bricks(10, 5, lambda s: refined(s, 0))),
        {"case": "50 bricks of 192 triangles"} | timed(lambda: bricks(10, 5, lambda s: refined(s, 2))),
        {"case": "50 bricks of 12,288 triangles"} | timed(lambda: bricks(10, 5, lambda s: refined(s, 5))),
        {"case": "50 tins of 400 triangles"} | timed(lambda: tins(10, 5, 400)),
        {"case": "50 tins of 10,000 triangles"} | timed(lambda: tins(10, 5, 10_000)),
        {"case": "two 49,152-triangle boxes"} | timed(lambda: faces(6)),
    ]
    for courses, across in COURSES:
        rows.append(
            {"case": f"wall {courses} x {across}"}
            | timed(lambda c=courses, n=across: bricks(c, n, lambda s: refined(s, 0)))
        )
    for level in LEVELS:
        rows.append({"case": f"8 bricks, level {level}"} | timed(lambda k=level: bricks(4, 2, lambda s: refined(s, k))))
        rows.append({"case": f"8 tins, level {level}"} | timed(lambda k=level: tins(4, 2, min(12 * 4**k, 10_000))))
    return rows


def plot(rows: list[dict[str, Any]], path: Path) -> None:
    """Time against bodies, and against triangles."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), sharey=True)
    walls = [r for r in rows if r["case"].startswith("wall")]
    left.loglog([r["bodies"] for r in walls], [r["contacts s"] for r in walls], "o-", label="contacts")
    left.loglog(
        [r["bodies"] for r in walls], [r["assemble s"] for r in walls], "s--", label="assemble, overlaps included"
    )
    left.set_xlabel("bodies (bricks of 12 triangles)")
    left.set_ylabel("time [s]")
    for kind, label in (("8 bricks", "flat faces"), ("8 tins", "round sides")):
        some = [r for r in rows if r["case"].startswith(kind)]
        right.loglog([r["triangles a body"] for r in some], [r["contacts s"] for r in some], "o-", label=label)
    right.set_xlabel("triangles a body (8 bodies on a floor)")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
    figure.suptitle("Contact detection from fresh meshes")
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)
