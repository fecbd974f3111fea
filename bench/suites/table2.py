"""Table II: time to a stable placement and least robustness after it, on six scenes of ours in place of [16]'s."""

from __future__ import annotations

from collections.abc import Mapping

from bench.scenes.placement_scenes import TABLE_II
from bench.suite import Case, Row, Suite, table
from bench.suites.placements import cases_of, printed

PAPER = {
    "Approx": {
        "time": [0.387, 2.28, 0.551, 2.94, 2.43, 1.90, 1.75],
        "rob": [2.43, 1.85, 0.817, 0.416, 1.53, 2.28, 1.55],
    },
    "Ours": {
        "time": [0.41, 1.95, 0.550, 3.26, 2.73, 1.84, 1.79],
        "rob": [2.45, 2.14, 0.801, 0.478, 1.64, 2.47, 1.66],
    },
}


def cases() -> Mapping[str, Case]:
    """Scenes times engines."""
    return cases_of(TABLE_II)


def written(rows: list[Row]) -> str:
    """In the paper's form, then all figures."""
    return f"{printed(rows, list(TABLE_II), PAPER)}\n\n{table(rows)}"


SUITE = Suite("table2", __doc__ or "", cases, written=written)
