"""Where a scene can carry something: points of its surface, weighted by what they withstand."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from holdfast.applications.placement.options import Weights
from holdfast.assembly.assembly import Assembly
from holdfast.base.archive import archived
from holdfast.base.arrays import Float, Int, Objects
from holdfast.base.values import Value
from holdfast.queries.map import RobustnessMap, robustness_map
from holdfast.queries.request import EngineChoice
from holdfast.scene.body import Body

STEEPEST = 0.2  # cosine: what faces up less carries no weight
MOST_FIXED = 3000  # points on fixed bodies: they need no answers, only places


@archived
@dataclass(frozen=True, eq=False, repr=False)
class SupportPoints(Value):
    """Exposed points of the scene that face up: ``points``, outward ``normals`` (n, 3), ``body`` (n,) names.

    ``force`` (n,) [N]: the inward push that each withstands; ``area`` (n,) [m²] that it stands for; ``chance`` (n,),
    of sum 1, of being chosen.
    """

    points: Float
    normals: Float
    body: Objects
    force: Float
    area: Float
    chance: Float

    def __post_init__(self) -> None:
        self.seal()


def scene_map(assembly: Assembly, engine: EngineChoice, spacing: float, names: Collection[str]) -> list[RobustnessMap]:
    """Maps of the movable and of the fixed bodies among ``names``, the latter coarse: nothing moves them."""
    maps = []
    movable = [body.name for body in assembly.movable if body.name in names]
    fixed = [body for body in assembly.bodies if body.fixed and body.name in names]
    if movable:
        maps.append(robustness_map(assembly, movable, spacing, engine=engine))
    if fixed:
        step = max(spacing, float(np.sqrt(sum(_area(body) for body in fixed) / MOST_FIXED)))
        maps.append(robustness_map(assembly, [body.name for body in fixed], step, engine=engine))
    return maps


def support_points(
    maps: list[RobustnessMap], weight: float, up: Float, weights: Weights, region: Float
) -> SupportPoints:
    """Points of the maps that face up and lie in ``region`` (2, 3), with the chance of each; ``weight`` [N]."""
    points = np.vstack([m.points for m in maps])
    normals = np.vstack([m.normals for m in maps])
    body = np.concatenate([m.body for m in maps])
    force = np.concatenate([m.force for m in maps])
    area = np.concatenate([_cell_areas(m) for m in maps])
    level = normals @ up
    kept = (level > STEEPEST) & ((points >= region[0]) & (points <= region[1])).all(1)
    share = np.where(np.isinf(force), 1.0, force / (np.where(np.isinf(force), 0.0, force) + weight))
    chance = np.where(kept, area * share**weights.robustness * np.maximum(level, 0.0) ** weights.level, 0.0)[kept]
    total = chance.sum()
    if total > 0:
        chance = chance / total
    return SupportPoints(
        points=points[kept], normals=normals[kept], body=body[kept], force=force[kept], area=area[kept], chance=chance
    )


def _area(body: Body) -> float:
    surface = body.surface_world
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2


def _cell_areas(m: RobustnessMap) -> Float:
    """(n,) area of the cell of every point of a map."""
    areas = []
    for cells in m.cells.values():
        a, b, c = (cells.vertices[cells.triangles[:, k]] for k in range(3))
        twice = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        numbers: Int = cells.cell
        areas.append(np.bincount(numbers, twice / 2, minlength=len(cells.points)))
    return np.concatenate(areas)
