"""Find support points: points of the scene that can carry an object, weighted by the pushes that they withstand."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from holdfast.applications.placement.options import Options, Weights
from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float, Objects, objects
from holdfast.base.public import Record, column
from holdfast.queries.exposed import exposed_cells
from holdfast.queries.map import RobustnessMap, robustness_map
from holdfast.queries.request import EngineChoice

STEEPEST = 0.2  # cosine of the largest angle between up and the normal of a surface that can carry weight
MOST_FIXED = 3000  # largest number of points on fixed bodies, where no push needs an answer


class SupportPoints(Record):
    """The n exposed points of the scene that face up and can carry an object.

    ``points`` (n, 3) [m] and outward ``normals`` (n, 3) are in the world frame; ``body`` (n,) holds names. ``force``
    (n,) [N] is the inward push that each point withstands, nan if it was not computed, and ``area`` (n,) [m²] the area
    that the point represents. ``chance`` (n,) is the probability of choosing it; the probabilities add up to 1.
    """

    points: Float = column("n 3")
    normals: Float = column("n 3")
    body: Objects = column("n", of=str)
    force: Float = column("n")
    area: Float = column("n")
    chance: Float = column("n")


def scene_map(assembly: Assembly, engine: EngineChoice, spacing: float, names: Collection[str]) -> list[RobustnessMap]:
    """Return robustness maps of the movable and of the fixed bodies among ``names``.

    The map of the fixed bodies is coarse, because no push moves them.
    """
    maps = []
    movable = [body.name for body in assembly.movable if body.name in names]
    fixed = [body for body in assembly.bodies if body.fixed and body.name in names]
    if movable:
        maps.append(robustness_map(assembly, movable, spacing=spacing, engine=engine))
    if fixed:
        step = max(spacing, float(np.sqrt(sum(body.surface_world.area for body in fixed) / MOST_FIXED)))
        maps.append(robustness_map(assembly, [body.name for body in fixed], spacing=step, engine=engine))
    return maps


def support_points(
    maps: list[RobustnessMap], weight: float, up: Float, weights: Weights, region: Float
) -> SupportPoints:
    """Return the points of the maps that face up and lie in ``region`` (2, 3) [m], with their probabilities.

    ``weight`` [N] is the weight of the object, and ``up`` (3,) the unit vector opposite to gravity.
    """
    return _chosen(
        np.vstack([m.points for m in maps]),
        np.vstack([m.normals for m in maps]),
        np.concatenate([m.body for m in maps]),
        np.concatenate([m.force for m in maps]),
        np.concatenate([cells.areas for m in maps for cells in m.cells.values()]),
        weight,
        up,
        weights,
        region,
    )


def unmapped_points(assembly: Assembly, options: Options) -> SupportPoints:
    """Return the points of the supports without computing the pushes that they withstand; ``force`` is nan.

    Their probabilities are those of points that withstand any push.
    """
    names = [body.name for body in assembly.bodies if body.name in options.supports]
    area = sum(assembly.scene.body(name).surface_world.area for name in names)
    step = max(options.spacing, float(np.sqrt(area / MOST_FIXED)))
    cells = {name: exposed_cells(assembly, name, step)[0] for name in names}
    points = np.vstack([seen.points for seen in cells.values()])
    return _chosen(
        points,
        np.vstack([seen.normals for seen in cells.values()]),
        objects([name for name, seen in cells.items() for _ in seen.points]),
        np.full(len(points), np.nan),
        np.concatenate([seen.areas for seen in cells.values()]),
        0.0,
        assembly.scene.up,
        options.weights,
        options.box,
    )


def _chosen(
    points: Float,
    normals: Float,
    body: Objects,
    force: Float,
    area: Float,
    weight: float,
    up: Float,
    weights: Weights,
    region: Float,
) -> SupportPoints:
    level = normals @ up
    kept = (level > STEEPEST) & ((points >= region[0]) & (points <= region[1])).all(1)
    sure = ~np.isfinite(force)
    share = np.where(sure, 1.0, force / (np.where(sure, 1.0, force) + weight))
    chance = np.where(kept, area * share**weights.robustness * np.maximum(level, 0.0) ** weights.level, 0.0)[kept]
    total = chance.sum()
    if total > 0:
        chance = chance / total
    return SupportPoints(
        points=points[kept], normals=normals[kept], body=body[kept], force=force[kept], area=area[kept], chance=chance
    )
