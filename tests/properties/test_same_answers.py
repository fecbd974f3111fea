"""What must not change an answer, on random assemblies (finding R5): names, axes, scale, and how a box is written.

On the default engine; the fast test takes one assembly of each family, `make test-slow` sixty in all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import holdfast as hf
from bench.scenes.random_assemblies import FAMILIES, standing
from bench.scenes.random_pushes import Push, random_pushes

PUSHES = 3  # on each assembly, up to 45 degrees from the inward normal
CLOSE = 0.01  # relative
Array = NDArray[np.float64]
Change = Callable[[hf.Scene, list[Push], Generator], tuple[hf.Scene, list[Push]]]


def rebuilt(body: hf.Body, **changes: Any) -> hf.Body:
    """The body with its mass and centre of mass given, so that another shape does not change them."""
    kept = {"mass": body.mass, "com": body.com_body, "pose": body.pose, "material": body.material, "fixed": body.fixed}
    if body.fixed:
        kept["mass"] = kept["com"] = None
    name, shape = changes.pop("name", body.name), changes.pop("shape", body.shape)
    return hf.Body(name, shape, **(kept | changes))


def relabelled(scene: hf.Scene, pushes: list[Push], rng: Generator) -> tuple[hf.Scene, list[Push]]:
    order = rng.permutation(len(scene.bodies))
    names = {scene.bodies[k].name: f"n{place}" for place, k in enumerate(rng.permutation(len(order)).tolist())}
    bodies = [rebuilt(scene.bodies[k], name=names[scene.bodies[k].name]) for k in order.tolist()]
    values = {names[name]: mu for name, mu in scene.friction.values.items()}
    friction = replace(scene.friction, values=values)
    return hf.Scene(bodies, friction, scene.gravity), [p._replace(body=names[p.body]) for p in pushes]


def turned(scene: hf.Scene, pushes: list[Push], rng: Generator) -> tuple[hf.Scene, list[Push]]:
    motion = np.eye(4)
    motion[:3, :3] = R = Rotation.random(random_state=rng).as_matrix()
    motion[:3, 3] = rng.uniform(-2, 2, 3)
    bodies = [body.moved(motion @ body.pose) for body in scene.bodies]
    there = [Push(p.body, R @ p.point + motion[:3, 3], R @ p.direction) for p in pushes]
    return hf.Scene(bodies, scene.friction, R @ scene.gravity), there


def enlarged(scene: hf.Scene, pushes: list[Push], rng: Generator) -> tuple[hf.Scene, list[Push]]:
    """All lengths multiplied, masses kept: forces stay what they are."""
    factor = float(np.exp(rng.uniform(-2, 2)))
    bodies = []
    for body in scene.bodies:
        pose = np.array(body.pose)
        pose[:3, 3] *= factor
        com = None if body.fixed else factor * body.com_body
        surface = body.shape.surface
        shape = hf.Mesh(factor * surface.vertices, surface.faces)
        if isinstance(body.shape, hf.Box):
            shape = hf.Box(factor * np.array(body.shape.size))
        if isinstance(body.shape, hf.Cylinder):
            shape = hf.Cylinder(factor * body.shape.radius, factor * body.shape.height, body.shape.segments)
        bodies.append(rebuilt(body, shape=shape, pose=pose, com=com))
    return hf.Scene(bodies, scene.friction, scene.gravity), [p._replace(point=factor * p.point) for p in pushes]


def meshed(scene: hf.Scene, pushes: list[Push], _: Generator) -> tuple[hf.Scene, list[Push]]:
    bodies = [
        rebuilt(body, shape=hf.Mesh(body.shape.surface.vertices, body.shape.surface.faces))
        if isinstance(body.shape, hf.Box)
        else body
        for body in scene.bodies
    ]
    return hf.Scene(bodies, scene.friction, scene.gravity), pushes


def subdivided(scene: hf.Scene, pushes: list[Push], _: Generator) -> tuple[hf.Scene, list[Push]]:
    bodies = []
    for body in scene.bodies:
        surface = body.shape.surface
        vertices, faces = trimesh.remesh.subdivide(surface.vertices, surface.faces)
        bodies.append(rebuilt(body, shape=hf.Mesh(vertices, faces)))
    return hf.Scene(bodies, scene.friction, scene.gravity), pushes


CHANGES: dict[str, Change] = {
    "names and order": relabelled,
    "axes": turned,
    "scale": enlarged,
    "boxes as meshes": meshed,
    "subdivision": subdivided,
}


def answers(scene: hf.Scene, pushes: list[Push]) -> Array:
    assembly = hf.assemble(scene)
    found = [hf.robustness(assembly, p.body, p.point, p.direction) for p in pushes]
    assert all(f.status[0] is not hf.Status.UNDECIDED for f in found)
    return np.array([f.force[0] for f in found])


def off(one: Array, other: Array) -> float:
    """The largest relative difference; infinite where only one is infinite."""
    same = (one == other) | (np.isinf(one) & np.isinf(other))
    with np.errstate(invalid="ignore"):
        return float(np.where(same, 0.0, np.abs(one - other) / np.minimum(one, other).clip(1e-9)).max())


def differences(family: str, seed: int, changes: dict[str, Change]) -> dict[str, float]:
    rng = np.random.default_rng([5, seed, list(FAMILIES).index(family)])
    assembly = standing(FAMILIES[family], rng)
    pushes = random_pushes(assembly, rng, PUSHES, slant=45.0)
    before = answers(assembly.scene, pushes)
    return {name: off(before, answers(*change(assembly.scene, pushes, rng))) for name, change in changes.items()}


@pytest.mark.parametrize("family", FAMILIES)
def test_names_order_and_axes_change_nothing(family: str) -> None:
    some = {name: CHANGES[name] for name in ("names and order", "axes", "boxes as meshes")}
    found = differences(family, 0, some)
    assert max(found.values()) < CLOSE, found


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_nothing_changes_the_answers_of_sixty_assemblies(family: str) -> None:
    """Four or five assemblies of each of fourteen families."""
    for seed in range(1, 6 if list(FAMILIES).index(family) < 4 else 5):
        found = differences(family, seed, CHANGES)
        assert max(found.values()) < CLOSE, (seed, found)
