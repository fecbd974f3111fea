"""Table III: placements where a body looks safe as long as what carries it counts as fixed, on scenes of ours."""

from __future__ import annotations

from collections.abc import Mapping

from bench.scenes.placement_scenes import TABLE_III
from bench.suite import Case, Row, Suite, table
from bench.suites.placements import cases_of, printed

PAPER = {
    "Approx": {"time": [4.5, 3.0, 0.7, 2.7], "rob": [0.3, 0.5, 0.5, 0.4]},
    "Ours": {"time": [3.9, 1.1, 0.4, 1.8], "rob": [0.4, 0.7, 0.5, 0.5]},
}


def cases() -> Mapping[str, Case]:
    """Scenes times engines."""
    return cases_of(TABLE_III)


def written(rows: list[Row]) -> str:
    """In the paper's form, then all figures."""
    return f"{printed(rows, list(TABLE_III), PAPER)}\n\n{table(rows)}"


SUITE = Suite("table3", __doc__ or "", cases, written=written)
