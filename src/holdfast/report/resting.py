"""Show the poses in which a body rests as a table and as a sheet of pictures."""

from __future__ import annotations

import os

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.resting_poses import RestingPoses, words
from holdfast.drawing.sequence import Frame, Sequence, write_sequence
from holdfast.report.bodies import solids_of
from holdfast.report.disassembly import MOST_FRAMES
from holdfast.report.texts import MOST_ROWS, cell, headline


def resting_report(result: RestingPoses, name: str) -> RenderableType:
    """Return a table of the poses, the most probable first."""
    summary = result.summary()
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in summary.heads:
        table.add_column(heading, justify="left" if not heading else "right")
    for row in summary.rows[:MOST_ROWS]:
        table.add_row(*map(cell, row))
    if len(result) > MOST_ROWS:
        table.add_row("", f"... and {len(result) - MOST_ROWS} more", "", "", "", "")
    outcome = _outcome(result), "bold green"
    return Group(headline(name, outcome, f"  (friction {result.mu:g})"), table)


def save_resting_png(result: RestingPoses, path: str | os.PathLike[str]) -> None:
    """Write the poses as a PNG, one panel for each, the most probable first."""
    frames = [
        Frame(solids_of([result.body.moved(pose.pose)]), "", f"{pose.probability:.1%}", _note(result, k))
        for k, pose in enumerate(list(result)[:MOST_FRAMES])
    ]
    shown = "" if len(frames) == len(result) else f", of which {len(frames)} are shown"
    up = np.array([0.0, 0.0, 1.0])
    note = "share of slow falls that end there, and the tilt of the plane at which it leaves"
    write_sequence(Sequence(f"{_outcome(result)}{shown}", note, tuple(frames), up, up), path)


def _note(result: RestingPoses, k: int) -> str:
    pose = result[k]
    return words(pose) if pose.rolls else f"{words(pose)}, tips at {pose.tipping_degrees:.3g}°"


def _outcome(result: RestingPoses) -> str:
    count = len(result)
    return f"rests in {count} poses" if count > 1 else "rests in one pose"
