"""Show a map as a table for the terminal."""

from __future__ import annotations

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.base.text import LONGEST_NAME, one_line
from holdfast.engines.verdict import Status
from holdfast.queries.map import MapPoint, RobustnessMap
from holdfast.queries.result import promised, vector_text
from holdfast.report.remarks import moving_words, remarks
from holdfast.report.texts import STYLES, WORDS, cell, headline, sentence


def map_report(result: RobustnessMap) -> RenderableType:
    """Return a table with the weakest point of every body."""
    word, style = WORDS[result.verdict.status], STYLES[result.verdict.status]
    name = result.assembly.scene.name or "scene"
    head = headline(
        name, (word, style), f", {len(result.force):,} inward pushes  (engine {result.engine}: {result.claim.words})"
    )
    table = Table(title="weakest push on each body", title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in ("body", "force [N]", "at [mm]", "along", "what moves"):
        table.add_column(
            cell(heading), justify="right" if heading == "force [N]" else "left", no_wrap=heading != "what moves"
        )
    weakest = result.weakest_of_each_body()
    for weak in weakest[:30]:
        here = result.body == weak.body
        unknown = int((here & ~result.answers.decided).sum())
        *cells, what = _row(weak)
        partly = f"; {unknown} of {here.sum()} undecided" if 0 < unknown < here.sum() else ""
        table.add_row(*map(cell, (*cells, what + partly)))
    if len(weakest) > 30:
        table.add_row(f"... and {len(weakest) - 30} more", *[""] * 4)
    return Group(head, *remarks(result), *map(sentence, _held_everywhere(result)), table)


def _held_everywhere(result: RobustnessMap) -> list[str]:
    """Return a sentence with the bound that holds at all points, and the point where it is smallest."""
    row, held = result.answers.holding, promised(result.answers, "N")
    if row is None or not held:
        return []
    place = f"{vector_text(1e3 * result.points[row], '.0f')} mm"
    return [f"{held} at every point, the least on {one_line(result.body[row], LONGEST_NAME)} at {place}"]


def _row(weak: MapPoint) -> tuple[str, ...]:
    if weak.status is Status.INFINITE:
        return weak.body, "∞", "", "", "nothing"
    if weak.status is Status.UNDECIDED:
        return weak.body, "?", "", "", "undecided"
    if weak.status is Status.UNSTABLE:
        return weak.body, "0", "", "", moving_words(weak.mode, weak.moving, "falls without a push")
    place = vector_text((1e3 * v for v in weak.point), ".0f")
    what = moving_words(weak.mode, weak.moving, "" if weak.force > 0 else "only balanced")
    return weak.body, f"{weak.force:.4g}", place, _direction(weak.direction), what


def _direction(values: tuple[float, float, float]) -> str:
    """Return the name of an axis, or the components of any other direction."""
    for axis, value in zip("xyz", values, strict=True):
        if abs(value) > 1 - 1e-9:
            return f"{'+' if value > 0 else '-'}{axis}"
    return vector_text(np.round(values, 2), ".2f")
