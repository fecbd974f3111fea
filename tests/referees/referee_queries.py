"""The 30 queries that engine and referees are compared on."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.baselines.search import push
from holdfast import Compliant, Status, assemble, robustness
from holdfast.answers import Assembly
from holdfast.assembly.contact_nodes import ContactNodes
from holdfast.elastic.system import PathOutcome
from holdfast.scene.shipped import shipped_scene

Array = NDArray[np.float64]

SCENES = ("cube", "stack", "table", "tall_table", "wall2x2")
EACH = 6
SEED = 20261121
MOST = 8.0  # total weights: pushes that engine ``limit`` lets go beyond are near-endless and left out


class Query(NamedTuple):
    scene: str
    number: int
    body: str
    point: Array
    direction: Array


@cache
def shipped(name: str) -> Assembly:
    return assemble(shipped_scene(name))


@cache
def queries(name: str) -> tuple[Query, ...]:
    """Uniform over bodies and their triangles; every other direction level; those with a finite answer by ``limit``."""
    assembly = shipped(name)
    rng = np.random.default_rng([SEED, SCENES.index(name)])
    found: list[Query] = []
    while len(found) < EACH:
        body = assembly.movable[rng.integers(len(assembly.movable))]
        surface = body.surface_world
        point = rng.dirichlet([1, 1, 1]) @ surface.vertices[surface.faces[rng.integers(len(surface.faces))]]
        direction = rng.normal(size=3) * (1, 1, len(found) % 2)
        direction /= np.linalg.norm(direction)
        answer = robustness(assembly, body.name, point, direction, engine="limit")
        if answer.status[0] is Status.FINITE and answer.force[0] < MOST * assembly.weight:
            found.append(Query(name, len(found), body.name, point, direction))
    return tuple(found)


def limit(query: Query) -> float:
    return float(robustness(shipped(query.scene), query.body, query.point, query.direction, engine="limit").force[0])


def engine(query: Query, nodes: ContactNodes | None = None) -> float:
    """R [N] of engine ``compliant`` at its default nodes, or on nodes given."""
    assembly = shipped(query.scene)
    if nodes is None:
        answer = robustness(assembly, query.body, query.point, query.direction, engine="compliant")
        return float(answer.force[0])
    column = push(assembly, query.body, query.point, query.direction)
    state = Compliant().on(assembly, assembly.weight_wrench(), nodes)
    paths = state.refined.answers(column[:, None], bounds=False).paths
    return float(paths.peak[0]) if paths.outcome[0] == PathOutcome.PEAK else float("inf")
