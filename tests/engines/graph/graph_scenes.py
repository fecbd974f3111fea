"""Scenes, rigid motions and queries that the tests of engine ``graph`` share."""

from collections.abc import Mapping

import numpy as np
from engine_scenes import Array, pose
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from holdfast import Friction, Graph, robustness
from holdfast.answers import Assembly, Interface


def pair_friction(pairs: Mapping[tuple[str, str], float]) -> Friction:
    return Friction(pairs=dict(pairs))


def push(assembly: Assembly, body: str, point: ArrayLike, direction: ArrayLike, **options: object) -> float:
    """R of one push by ``Graph(**options)``."""
    return float(robustness(assembly, body, point, direction, engine=Graph(**options)).force[0])  # type: ignore[arg-type]


def random_motion(seed: int) -> Array:
    rng = np.random.default_rng(seed)
    return pose(rng.normal(size=3), Rotation.random(random_state=seed).as_matrix())


def apply(motion: Array, points: Array) -> Array:
    return np.asarray(points @ motion[:3, :3].T + motion[:3, 3])


def square(z: float = 0.0, half: float = 0.05) -> Array:
    return np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]])


def given(a: str, b: str, normal: ArrayLike) -> Interface:
    """The 0.1 m square at z = 0 between ``a`` and ``b``."""
    return Interface((a, b), square(), normal)
