"""How the time of ``graph`` grows with bodies and cuts, on quarter-bond walls two bricks wide and wider."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import holdfast as hf
from holdfast.engines.graph.cuts import feasible_cuts
from holdfast.shipped.blocks import wall

SHAPES = ((1, 1), (2, 2), (3, 2), (3, 3), (4, 3), (4, 4), (5, 4), (5, 5))


def measure() -> list[dict[str, Any]]:
    rows = []
    hf.robustness_map(hf.assemble(wall(2, 2, 0.25, "warm-up")), spacing=0.05, engine="graph")
    for courses, bricks in SHAPES:
        scene = wall(courses, bricks, 0.25, "wall")
        start = time.perf_counter()
        assembly = hf.assemble(scene)
        detected = time.perf_counter()
        edges = [tuple(k if k >= 0 else courses * bricks for k in pair) for pair in assembly.ends]
        cuts = len(feasible_cuts(courses * bricks + 1, edges, limit=10**6))
        counted = time.perf_counter()
        row: dict[str, Any] = {"case": f"{courses}x{bricks}", "bodies": courses * bricks, "cuts": cuts}
        row["detection s"] = detected - start
        row["enumeration s"] = counted - detected
        try:
            result = hf.robustness_map(assembly, spacing=0.02, engine="graph")
            row["points"] = len(result.force)
            row["map s"] = time.perf_counter() - counted
        except hf.SolverError:
            row["points"], row["map s"] = 0, "refused: over 20,000 cuts"
        rows.append(row)
    return rows


def plot(rows: list[dict[str, Any]], path: Path) -> None:
    """Time of a map and number of cuts over the number of bodies."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    done = [row for row in rows if isinstance(row["map s"], float)]
    figure = Figure(figsize=(7, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    bodies, thousands = [row["bodies"] for row in rows], [row["cuts"] / 1000 for row in rows]
    axes.semilogy(bodies[: len(done)], [row["map s"] for row in done], "o-", color="#b5173f", label="map [s]")
    axes.semilogy(bodies, thousands, "s--", color="#3b6ea5", label="cuts / 1000")
    axes.set_xlabel("movable bodies of a wall in quarter bond")
    axes.set_title("engine graph grows exponentially with the number of bodies", loc="left", fontsize=11)
    axes.grid(alpha=0.3, which="both")
    axes.legend(frameon=False)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(path, dpi=130)
