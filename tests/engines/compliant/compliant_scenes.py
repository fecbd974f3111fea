"""Scenes, random pushes and node grids that the tests of engine ``compliant`` share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from engine_scenes import Array
from numpy.typing import ArrayLike

from holdfast import Compliant, robustness
from holdfast.answers import Assembly
from holdfast.assembly.contact_nodes import ContactNodes, contact_nodes
from holdfast.elastic.system import PathResult
from holdfast.engines.compliant.engine import RestingState
from holdfast.engines.compliant.grid import Grid
from holdfast.queries.request import push_columns

SMALL = ["cube", "stack", "table", "tall_table", "wall2x2", "slope", "slope_two", "cantilever", "arch", "v_groove"]
SMALL += ["wedged_floor", "tabletop"]
STANDING = [*SMALL, "bonded_wall"]


def strength(assembly: Assembly, body: str, point: ArrayLike, direction: ArrayLike, **options: object) -> float:
    answer = robustness(assembly, body, point, direction, engine=Compliant(**options))  # type: ignore[arg-type]
    return float(answer.force[0])


def grid_of(assembly: Assembly) -> Grid:
    """The grid of an assembly that stands."""
    state = Compliant().prepare(assembly)
    assert isinstance(state, RestingState)
    return state.grid


def watch_paths(
    monkeypatch: pytest.MonkeyPatch, change: Callable[[Grid, PathResult], PathResult] = lambda _, found: found
) -> list[int]:
    """Let ``change`` alter every path from now on; the nodes a side of the grids whose paths are followed."""
    followed, seen = Grid.paths, []

    def paths(grid: Grid, W: Array) -> PathResult:
        seen.append(grid.springs.nodes)
        return change(grid, followed(grid, W))

    monkeypatch.setattr(Grid, "paths", paths)
    return seen


def random_pushes(assembly: Assembly, count: int, seed: int) -> list[tuple[str, Array, Array]]:
    """(body, point, unit direction): half of them level, where answers are finite."""
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        body = assembly.movable[rng.integers(len(assembly.movable))]
        surface = body.surface_world
        corners = surface.vertices[surface.faces[rng.integers(len(surface.faces))]]
        direction = rng.normal(size=3) * (1, 1, k % 2)
        found.append((body.name, rng.dirichlet([2, 2, 2]) @ corners, direction / np.linalg.norm(direction)))
    return found


def columns(assembly: Assembly, pushes: list[tuple[str, Array, Array]]) -> Array:
    return np.column_stack([push_columns(assembly, assembly.index[b], p[None], e[None])[:, 0] for b, p, e in pushes])


def even_grid(assembly: Assembly, side: int) -> ContactNodes:
    """``side`` x ``side`` nodes on every (rectangular, level) patch with the weights of the trapezoidal rule."""
    nodes = contact_nodes(assembly, 4, "quadrature")
    parts = []
    for number, interface in enumerate(assembly.interfaces):
        (patch,) = interface.patches
        low, high = patch.polygon.min(0), patch.polygon.max(0)
        u = np.linspace(0, 1, side)
        share = np.ones(side)
        share[[0, -1]] = 0.5
        x, y = np.meshgrid(u, u, indexing="ij")
        points = low + np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3) * (high - low)
        weights = np.outer(share, share).ravel()
        parts.append((number, points, weights / weights.sum() * patch.area))
    first = nodes.spans[:-1]
    owner = np.concatenate([np.full(len(p), n) for n, p, _ in parts])
    take = first[owner]
    return replace(
        nodes.chosen(np.ones(len(nodes), dtype=bool)),
        points=np.vstack([p for _, p, _ in parts]),
        axes=nodes.axes[take],
        mu=nodes.mu[take],
        weights=np.concatenate([w for _, _, w in parts]),
        pull=np.zeros(sum(len(w) for _, _, w in parts)),
        interface=owner,
        a=nodes.a[take],
        b=nodes.b[take],
    )
