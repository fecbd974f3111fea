"""Predicted and measured: pushes by a robot, and numbers that others have printed, beside the engines."""

from __future__ import annotations

from collections.abc import Mapping

from bench.experiments import (
    arches,
    brick_walls,
    overhangs,
    pushed_triangle,
    shaken_arch,
    three_cylinders,
    tilted_block,
    toppling_blocks,
)
from bench.experiments.pictures import plot
from bench.suite import Case, Row, Suite, table

SOURCES = tuple(
    module.SOURCE
    for module in (
        pushed_triangle,
        toppling_blocks,
        arches,
        shaken_arch,
        brick_walls,
        overhangs,
        three_cylinders,
        tilted_block,
    )
)


def cases() -> Mapping[str, Case]:
    found: dict[str, Case] = {}
    for source in SOURCES:
        found |= source.cases()
    return found


def written(rows: list[Row]) -> str:
    """One table for what was printed, one for each kind of row of the pushes, and the sources."""
    printed = [row for row in rows if "printed" in row]
    kinds = {tuple(row): None for row in rows if "printed" not in row}
    said = [f"- **{s.name}**: {s.citation}. Found: {s.found}. Assumed: {s.assumed}." for s in SOURCES]
    return "\n\n".join(
        ["\n".join(said), table(printed), *(table([row for row in rows if tuple(row) == kind]) for kind in kinds)]
    )


SUITE = Suite("experiments", __doc__, cases, plot, written)
