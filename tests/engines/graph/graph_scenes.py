"""Scenes, rigid motions and queries that the tests of engine ``graph`` share."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from holdfast import Body, Box, Friction, Graph, Mesh, Scene, robustness
from holdfast.answers import Assembly, Interface

Array = NDArray[np.float64]

GRAVITY = 9.81  # [m/s2]
X, Y, Z = np.eye(3)


def pose(centre: ArrayLike, rotation: Array | None = None) -> Array:
    result = np.eye(4)
    result[:3, :3] = np.eye(3) if rotation is None else rotation
    result[:3, 3] = centre
    return result


def block(name: str, size: ArrayLike, centre: ArrayLike, mass: float = 1.0, *, fixed: bool = False) -> Body:
    return Body(name, Box(np.asarray(size, dtype=float)), mass=None if fixed else mass, pose=pose(centre), fixed=fixed)


def floor() -> Body:
    return block("floor", (2, 2, 0.1), (0, 0, -0.05), fixed=True)


def cube_scene(mu: float = 0.6, gravity: Sequence[float] = (0, 0, -GRAVITY), mass: float = 1.0) -> Scene:
    return Scene([floor(), block("cube", (0.1, 0.1, 0.1), (0, 0, 0.05), mass)], mu, gravity)


def pair_friction(pairs: Mapping[tuple[str, str], float]) -> Friction:
    return Friction(pairs=dict(pairs))


def push(assembly: Assembly, body: str, point: ArrayLike, direction: ArrayLike, **options: object) -> float:
    """R of one push by ``Graph(**options)``."""
    return float(robustness(assembly, body, point, direction, engine=Graph(**options)).force[0])  # type: ignore[arg-type]


def random_motion(seed: int) -> Array:
    rng = np.random.default_rng(seed)
    return pose(rng.normal(size=3), Rotation.random(random_state=seed).as_matrix())


def moved(scene: Scene, motion: Array, *, order: Sequence[int] | None = None, prefix: str = "") -> Scene:
    """The scene after a rigid motion, gravity too; optionally its bodies in another order and renamed."""
    bodies = []
    for k in range(len(scene.bodies)) if order is None else order:
        body = scene.bodies[k]
        bodies.append(
            Body(
                prefix + body.name, body.shape, mass=body.mass, com=body.com, pose=motion @ body.pose, fixed=body.fixed
            )
        )
    return Scene(bodies, scene.friction, motion[:3, :3] @ scene.gravity)


def scaled(scene: Scene, factor: float) -> Scene:
    """All lengths times ``factor``, masses as they are."""
    bodies = []
    for body in scene.bodies:
        placed = np.array(body.pose)
        placed[:3, 3] *= factor
        shape = Mesh(body.shape.surface.vertices * factor, body.shape.surface.faces)
        com = None if body.com is None else body.com * factor
        bodies.append(Body(body.name, shape, mass=body.mass, com=com, pose=placed, fixed=body.fixed))
    return Scene(bodies, scene.friction, scene.gravity)


def heavier(scene: Scene, factor: float) -> Scene:
    """All masses times ``factor``."""
    bodies = [
        Body(b.name, b.shape, mass=None if b.fixed else factor * b.mass, com=b.com, pose=b.pose, fixed=b.fixed)
        for b in scene.bodies
    ]
    return Scene(bodies, scene.friction, scene.gravity)


def apply(motion: Array, points: Array) -> Array:
    return np.asarray(points @ motion[:3, :3].T + motion[:3, 3])


def surface_points(body: Body, count: int, rng: np.random.Generator) -> Array:
    surface = body.surface_world
    corners = surface.vertices[surface.faces[rng.integers(len(surface.faces), size=count)]]
    return np.asarray(np.einsum("nk,nkx->nx", rng.dirichlet([2, 2, 2], count), corners))


def square(z: float = 0.0, half: float = 0.05) -> Array:
    return np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])


def given(a: str, b: str, normal: ArrayLike) -> Interface:
    """The 0.1 m square at z = 0 between ``a`` and ``b``."""
    return Interface((a, b), square(), normal)
