"""Where a scene can carry something: points of its surface, weighted by what they withstand."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from holdfast.arrays import Float, Int, Objects, checked_number
from holdfast.assembly.assembly import Assembly
from holdfast.errors import SceneError, message
from holdfast.robustness.map import RobustnessMap, robustness_map
from holdfast.robustness.request import EngineChoice
from holdfast.scene.body import Body

STEEPEST = 0.2  # cosine: what faces up less carries no weight
MOST_FIXED = 3000  # points on fixed bodies: they need no answers, only places


@dataclass(frozen=True)
class Weights:
    """What biases the choice: exponents, 0 for no influence.

    ``robustness`` of R / (R + weight of the object) at a point of the scene, ``level`` of the vertical part of its
    normal, ``steadiness`` of the tilt that a face of the object stands.
    """

    robustness: float = 2.0
    level: float = 1.0
    steadiness: float = 1.0

    def __post_init__(self) -> None:
        for name in ("robustness", "level", "steadiness"):
            checked_number(getattr(self, name), f"Weights: {name}", minimum=0)


@dataclass(frozen=True, eq=False)
class SupportPoints:
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
    return SupportPoints(points[kept], normals[kept], body[kept], force[kept], area[kept], chance)


def checked_region(region: object, up: Float) -> Float:
    """(2, 3) low and high corner of a box [m]; (2, 2) is horizontal and reaches from minus to plus infinity."""
    if region is None:
        return np.array([[-np.inf] * 3, [np.inf] * 3])
    where = "plan_placement: region"
    try:
        box = np.array(region, dtype=np.float64)
    except (TypeError, ValueError):
        raise SceneError(message(where, f"is {region!r:.60}", "needs the low and the high corner of a box")) from None
    if box.shape == (2, 2):
        if np.abs(up[:2]).max() > 1e-9:
            raise SceneError(message(where, "has two coordinates, but up is not z", "give three"))
        box = np.column_stack([box, [-np.inf, np.inf]])
    if box.shape != (2, 3) or np.isnan(box).any():
        raise SceneError(message(where, f"has shape {box.shape}", "needs (2, 2) or (2, 3): low and high corner [m]"))
    if not (box[0] < box[1]).all():
        raise SceneError(message(where, f"low {box[0].tolist()}, high {box[1].tolist()}", "needs low < high"))
    return box


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
