"""How long contact detection takes, from fresh meshes, and how it grows with bodies and with triangles."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import BinaryIO

import numpy as np
import trimesh

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.base.arrays import Float
from holdfast.contacts.contact_search import find_contacts
from holdfast.contacts.tolerances import Tolerances
from holdfast.scene.compound import Shape
from holdfast.scene.shipped.blocks import wall

REPEATS = 3
COURSES = ((2, 4), (4, 5), (10, 5), (10, 10), (20, 10), (25, 20))
LEVELS = range(6)


def refined(shape: Shape, levels: int) -> hf.Mesh:
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
    floor = hf.Body("floor", hf.Box(np.array([2, 2, 0.1])), pose=_at(0, 0, -0.05), fixed=True)
    bodies = [
        hf.Body(
            f"t{x}_{z}",
            hf.Mesh(shape.vertices, shape.faces),
            mass=1.0,
            com=np.zeros(3),
            pose=_at(0.1 * x, 0, 0.05 + 0.1 * z),
        )
        for x in range(towers)
        for z in range(high)
    ]
    return hf.Scene([floor, *bodies], 0.5)


def _at(x: float, y: float, z: float) -> Float:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def bricks(courses: int, across: int, levels: int) -> hf.Scene:
    """A wall in quarter bond, in which every brick has its own shape object."""
    scene = wall(courses, across, 0.25, "wall")
    bodies = [
        b if b.fixed else hf.Body(b.name, refined(b.shape, levels), mass=b.mass, com=np.zeros(3), pose=b.pose)
        for b in scene.bodies
    ]
    return hf.Scene(bodies, 0.6)


def faces(levels: int) -> hf.Scene:
    """Two boxes face to face."""
    box = hf.Box(np.array([0.3, 0.2, 0.1]))
    poses = [np.eye(4), np.eye(4)]
    poses[1][:3, 3] = (0.03, 0.02, 0.1)
    return hf.Scene(
        [
            hf.Body(name, refined(box, levels), mass=1.0, com=np.zeros(3), pose=pose, fixed=name == "a")
            for name, pose in zip("ab", poses, strict=True)
        ],
        0.5,
    )


def timed(build: Callable[[], hf.Scene]) -> Row:
    """Medians over fresh scenes: contacts alone, with cleaning and reducing the meshes, and all of ``assemble``."""
    alone, whole = [], []
    contacts = None
    for _ in range(REPEATS):
        scene = build()
        start = time.perf_counter()
        contacts = find_contacts(scene, Tolerances.measured(scene))
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


def cases() -> Mapping[str, Case]:
    timed(lambda: faces(1))
    scenes: dict[str, Callable[[], hf.Scene]] = {
        "50 bricks of 12 triangles": partial(bricks, 10, 5, 0),
        "50 bricks of 192 triangles": partial(bricks, 10, 5, 2),
        "50 bricks of 12,288 triangles": partial(bricks, 10, 5, 5),
        "50 tins of 400 triangles": partial(tins, 10, 5, 400),
        "50 tins of 10,000 triangles": partial(tins, 10, 5, 10_000),
        "two 49,152-triangle boxes": partial(faces, 6),
    }
    for courses, across in COURSES:
        scenes[f"wall {courses} x {across}"] = partial(bricks, courses, across, 0)
    for level in LEVELS:
        scenes[f"8 bricks, level {level}"] = partial(bricks, 4, 2, level)
        scenes[f"8 tins, level {level}"] = partial(tins, 4, 2, min(12 * 4**level, 10_000))
    return {label: partial(_measured, label, build) for label, build in scenes.items()}


def _measured(label: str, build: Callable[[], hf.Scene]) -> list[Row]:
    return [{"case": label} | timed(build)]


def plot(rows: list[Row], file: BinaryIO) -> None:
    """Time against bodies, and against triangles."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
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
    figure.savefig(file, dpi=130)


SUITE = Suite("contacts", "Contact detection from fresh meshes: medians of three.", cases, plot)
