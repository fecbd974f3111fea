"""Print the table of bench/notes/baselines.md, minutes a scene: ``referee_table.py [scene ...]``."""

from __future__ import annotations

import sys
from collections.abc import Iterable

import numpy as np
from referee_queries import SCENES, Query, engine, limit, queries, shipped

from bench.baselines import lmgc90, mujoco, penalty
from bench.baselines.search import Peak, grid_nodes

CORNERS, OWN, REFINED = 2, 5, 7  # nodes along a side
FINE = dict.fromkeys(SCENES, 9) | {"wall2x2": 7}  # of the DEM


def row(query: Query) -> list[float]:
    """R [N] by limit and by compliant at default nodes; then (compliant, referee) of four comparisons."""
    assembly = shipped(query.scene)
    sides = (CORNERS, OWN, REFINED, FINE[query.scene])
    corners, own, refined, fine = (grid_nodes(assembly, side) for side in sides)
    what = (assembly, query.body, query.point, query.direction)
    values = [limit(query), engine(query)]
    values += [engine(query, corners), told(query, lmgc90.peak(*what))]
    values += [engine(query, own), told(query, mujoco.peak(*what, own))]
    values += [engine(query, refined), told(query, mujoco.peak(*what, refined))]
    values += [engine(query, fine), told(query, penalty.peak(*what, fine))]
    return values


def told(query: Query, peak: Peak) -> float:
    """The force [N]; brackets wider than 1 % are named."""
    if peak.width > 0.005 or peak.undecided:
        sys.stderr.write(f"{query.scene} {query.number}: {peak}\n")
    return peak.force


def table(rows: Iterable[tuple[Query, list[float]]]) -> str:
    """The rows in Markdown, with what they come to."""
    pairs = ("LMGC90, corners", "MuJoCo, 5 x 5", "MuJoCo, 7 x 7", "DEM, 9 x 9")
    heads = ["query", "body", "point [m]", "direction", "limit", "compliant"]
    heads += [cell for pair in pairs for cell in ("compl.", pair, "ratio")]
    lines = ["| " + " | ".join(heads) + " |", "|---|---|---|---|" + "--:|" * (len(heads) - 4)]
    ratios = []
    for query, values in rows:
        vectors = [" ".join(f"{x:.3f}" for x in v) for v in (query.point, query.direction)]
        cells = [f"{query.scene} {query.number}", query.body, *vectors, f"{values[0]:.4g}", f"{values[1]:.4g}"]
        compared = list(zip(values[2::2], values[3::2], strict=True))
        for mine, theirs in compared:
            cells += [f"{mine:.4g}", f"{theirs:.4g}", f"{theirs / mine:.3f}"]
        ratios.append([theirs / mine for mine, theirs in compared] + [values[9] / values[1]])
        lines.append("| " + " | ".join(cells) + " |")
    lines.append("")
    for label, ratio in zip([*pairs, "DEM over compliant at default nodes"], np.array(ratios).T, strict=True):
        off = np.abs(ratio - 1)
        figures = (
            f"median {np.median(off):.2%}, mean {off.mean():.2%}, worst {off.max():.2%}, bias {ratio.mean() - 1:+.2%}"
        )
        lines.append(f"- {label}: {figures}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    chosen = sys.argv[1:] or SCENES
    sys.stdout.write(table((query, row(query)) for name in chosen for query in queries(name)))
