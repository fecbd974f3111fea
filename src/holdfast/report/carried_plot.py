"""Show the result of ``carry`` as a picture over time and as a table."""

from __future__ import annotations

import os

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.carrying.result import Carried
from holdfast.base.public import number
from holdfast.drawing.timeline import Timeline, write_timeline
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status
from holdfast.report.texts import STYLES, cell, headline, sentence
from holdfast.report.transport_plot import movers

ROWS = 12  # largest number of times in the table

WORDS = {Status.STABLE: "holds", Status.UNSTABLE: "gives way", Status.UNDECIDED: "is undecided"}


def save_carried_png(result: Carried, path: str | os.PathLike[str]) -> None:
    """Write the accelerations and the used share of the load's capacity over time (PNG)."""
    write_timeline(timeline(result), path)


def timeline(result: Carried) -> Timeline:
    """Return the content of the picture."""
    name, motion = result.assembly.scene.name or "load", result.profile
    word = WORDS[result.outcome]
    lines = [f"{word}: {result.reason}"]
    if result.claim is not Claim.ESTIMATED:
        lines.append(_safe_speed(result))
    lines.append(f"engine {result.engine} ({result.claim.words})")
    if result.undecided.count:
        lines.append(result.undecided.text)
    with np.errstate(divide="ignore"):
        certain = 1 / result.upper
    return Timeline(
        title=f"{name} carried: {motion.name or 'a motion'}",
        subtitle=f"{word} · {len(motion.time):,} times · each judged from rest, quasi-static",
        time=motion.time,
        acceleration=motion.acceleration,
        turning=motion.angular_acceleration,
        used=result.used,
        proved=np.where(result.answers.decided, certain, 0.0),
        movers=tuple(movers(result)),
        moved=result.time,
        lines=tuple(lines),
    )


def _safe_speed(result: Carried) -> str:
    """Return in words up to which speed the load is known to hold, or to have an equilibrium."""
    scale, what = result.time_scale(), "to hold" if result.claim is Claim.HOLDS else "to have an equilibrium"
    return f"known {what} at {number(scale)} times the speed" if scale > 0 else f"not known {what} at any speed"


def carried_report(result: Carried) -> RenderableType:
    """Return a table of the times with the smallest factors, in the order of time."""
    word, style = WORDS[result.outcome], STYLES[result.outcome]
    head = headline(
        result.assembly.scene.name or "assembly",
        (word, style),
        f" while it is carried: {result.profile.name or 'a motion'}  (engine {result.engine}: {result.claim.words})",
    )
    lines: list[RenderableType] = [head, sentence(result.reason)]
    if result.claim is not Claim.ESTIMATED:
        lines.append(sentence(_safe_speed(result)))
    if result.profile.source:
        lines.append(sentence(f"motion from {result.profile.source}", "dim"))
    lines += [sentence(f"note: {note}", "yellow") for note in result.notes]
    table = Table(title="times with the smallest factors", title_justify="left", box=SIMPLE_HEAD)
    for heading in ("at [s]", "ax", "ay", "az [m/s²]", "factor", "lower", "what moves first"):
        name = heading == "what moves first"
        table.add_column(cell(heading), justify="left" if name else "right", no_wrap=not name)
    words = movers(result)
    for k in _rows(result):
        known = result.answers.decided[k]
        motion = [f"{v + 0.0:.4g}" for v in result.profile.acceleration[k]]
        figures = [number(float(v)) if known else "?" for v in (result.factor[k], result.lower[k])]
        what = words[k] if known else "not known"
        table.add_row(*(cell(text) for text in (number(float(result.profile.time[k])), *motion, *figures, what)))
    return Group(*lines, table)


def _rows(result: Carried) -> list[int]:
    """Return the numbers of the times with the smallest factors and with the smallest lower bound, in order."""
    rows = result.answers.ranking[:ROWS].tolist()
    low = result.answers.holding
    return sorted(rows if low is None or low in rows else [*rows[: ROWS - 1], low])
