"""Show from what to what bodies became firmer, as a table and as a picture before and after."""

from __future__ import annotations

import os

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.firmer.result import STILL, Firmer
from holdfast.base.public import number
from holdfast.drawing.sequence import Frame, Sequence, write_sequence
from holdfast.report.bodies import solids_of
from holdfast.report.texts import MOST_ROWS, cell, headline


def firmer_report(result: Firmer) -> RenderableType:
    """Return what was moved, and the least push on each body before and after, or the least factor of a motion."""
    summary = result.summary()
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in summary.heads:
        table.add_column(heading)
    for row in summary.rows[:MOST_ROWS]:
        table.add_row(*map(cell, row))
    if len(summary.rows) > MOST_ROWS:
        table.add_row(f"... and {len(summary.rows) - MOST_ROWS} more", "", "")
    outcome = summary.headline, "bold green" if len(result) > 1 else "bold yellow"
    rest = f"  ({result.tried} poses tried, engine {result.engine}: {result.claim.words})"
    return Group(headline(result.assembly.scene.name or "scene", outcome, rest), table)


def save_firmer_png(result: Firmer, path: str | os.PathLike[str]) -> None:
    """Write the scene before and after as a PNG; before, with an arrow the way in which the first body was moved."""
    scene, unit = result.assembly.scene, "times" if result.times else "N"
    name, last = next(iter(result.poses.items()))
    centre = np.append(scene.body(name).com_body, 1.0)
    way = ((last - result[0].poses[name]) @ centre)[:3]
    far = float(np.linalg.norm(way))
    frames = []
    for step, when, least in ((result[0], "before", result.before), (result[-1], "after", result.after)):
        bodies = [body.moved(step.poses.get(body.name, body.pose)) for body in scene.bodies]
        marked = name if far > STILL and step is result[0] else ""
        frames.append(Frame(solids_of(bodies), marked, when, f"least {number(least, unit)}"))
    along = way / far if far > STILL else scene.up
    title, note = scene.name or "firmer", result.summary().headline
    write_sequence(Sequence(title, note, tuple(frames), along, scene.up, marked="what is moved, and which way"), path)
