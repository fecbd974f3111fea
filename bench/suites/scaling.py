"""How time grows with bodies, on walls in quarter bond: ``limit``, ``compliant``, and ``graph`` until it stops."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import BinaryIO

import numpy as np

import holdfast as hf
from bench.suite import Case, Row, Suite
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid
from holdfast.engines.limit_engine import Limit
from holdfast.queries.request import push_columns
from holdfast.scene.shipped.blocks import wall

SHAPES = ((2, 2), (4, 2), (4, 3), (4, 4), (5, 4), (8, 3), (9, 5), (19, 5), (29, 7), (50, 10))
SPACING = 0.02


def cases() -> Mapping[str, Case]:
    for engine in ("graph", "limit", "compliant"):
        hf.robustness_map(hf.assemble(wall(2, 2, 0.25, "warm-up")), ["b1_0"], spacing=0.05, engine=engine)
    return {f"{courses} x {bricks}": partial(_wall, courses, bricks) for courses, bricks in SHAPES}


def _wall(courses: int, bricks: int) -> list[Row]:
    start = time.perf_counter()
    assembly = hf.assemble(wall(courses, bricks, 0.25, "wall"))
    row: Row = {
        "case": f"{courses} x {bricks}",
        "bodies": courses * bricks,
        "interfaces": len(assembly.interfaces),
        "detection s": time.perf_counter() - start,
    }
    top = f"b{courses - 1}_{bricks - 1}"
    row |= _pushes(assembly, top)
    row["graph map s"] = _graph(assembly, top)
    return [row]


def _pushes(assembly: hf.answers.Assembly, body: str) -> Row:
    start = time.perf_counter()
    state = Limit().prepare(assembly)
    ready = time.perf_counter()
    at = assembly.com[assembly.index[body]]
    push = push_columns(assembly, assembly.index[body], (at - [0, 0.05, 0])[None], np.array([[0.0, 1, 0]]))[:, 0]
    state.solve(push)
    elastic = Grid.of(assembly, assembly.weight_wrench(), Springs(hf.Compliant().nodes))
    elastic.paths(push[:, None])
    queries, paths = [], []
    for _ in range(5):  # alternating; the shortest time of each counts, as other processes only add to it
        begin = time.perf_counter()
        state.solve(push)
        queries.append(time.perf_counter() - begin)
        begin = time.perf_counter()
        elastic.paths(push[:, None])
        paths.append(time.perf_counter() - begin)
    begin = time.perf_counter()
    result = hf.robustness_map(assembly, [body], spacing=SPACING, engine="limit", accuracy=0.01)
    return {
        "limit verdict s": ready - start,
        "limit query s": min(queries),
        "compliant query s": min(paths),
        "compliant / limit": min(paths) / min(queries),
        "points": len(result.force),
        "limit map s": time.perf_counter() - begin,
    }


def _graph(assembly: hf.answers.Assembly, body: str) -> float | str:
    start = time.perf_counter()
    try:
        hf.robustness_map(assembly, [body], spacing=SPACING, engine="graph")
    except hf.errors.SolverError:
        return "refused: over 20,000 cuts"
    return time.perf_counter() - start


def plot(rows: list[Row], file: BinaryIO) -> None:
    """Times over the number of bodies, both axes logarithmic."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 4.6), layout="constrained")
    axes = figure.add_subplot()
    rows = sorted(rows, key=lambda row: row["bodies"])
    done = [row for row in rows if isinstance(row["graph map s"], float)]
    lines = (
        (done, "graph map s", "graph: map of one brick (estimate)", "#b5173f", "o-"),
        (rows, "limit map s", "limit: certified map of one brick, gap 1 %", "#1f5f8b", "s-"),
        (rows, "limit query s", "limit: one push", "#5fa3cf", "^--"),
        (rows, "compliant query s", "compliant: one push", "#3d8b5f", "v--"),
    )
    for data, key, label, colour, style in lines:
        axes.loglog([row["bodies"] for row in data], [row[key] for row in data], style, color=colour, label=label)
    if done:
        last = done[-1]
        axes.annotate(
            "graph stops:\nover 20,000 cuts",
            (last["bodies"], last["graph map s"]),
            xytext=(12, -4),
            textcoords="offset points",
            fontsize=9,
            color="#b5173f",
        )
    axes.set_xlabel("movable bodies of a wall in quarter bond")
    axes.set_ylabel("seconds")
    axes.set_title("one brick of a growing wall: cuts explode, cone programs do not", loc="left", fontsize=11)
    axes.grid(alpha=0.3, which="both")
    axes.legend(frameon=False)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(file, dpi=130)


SUITE = Suite("scaling", __doc__, cases, plot)
