"""Show where several objects are put down as a table and as a strip of pictures."""

from __future__ import annotations

import os

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.placement.several_result import Placements
from holdfast.base.text import listed
from holdfast.drawing.sequence import Frame, Sequence, write_sequence
from holdfast.report.bodies import solids_of
from holdfast.report.texts import MOST_ROWS, STYLES, cell, headline, sentence

MOST_FRAMES = 12  # largest number of states in a strip of pictures
MARKED = "the object that is put down"


def placements_report(result: Placements, scene: str) -> RenderableType:
    """Return a table of the steps in order, with the smallest push after each, or the reason why there are none."""
    whole = len(result.steps) + len(result.left)
    outcome = (f"{len(result.steps)} of {whole} objects placed", STYLES[result.status])
    head = headline(result.assembly.scene.name or scene, outcome, f"  (engine {result.engine}: {result.claim.words})")
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading, justify in (("step", "right"), ("put down", "left"), ("at [m]", "left"), ("on", "left")):
        table.add_column(heading, justify=justify)  # type: ignore[arg-type]
    table.add_column("least push", justify="right")
    for k, step in enumerate(result.steps[:MOST_ROWS]):
        place = ", ".join(f"{v + 0.0:.4g}" for v in step.pose[:3, 3])
        table.add_row(str(k + 1), cell(step.body), place, sentence(listed(step.rests_on)), step.least_text)
    if len(result.steps) > MOST_ROWS:
        table.add_row("", f"... and {len(result.steps) - MOST_ROWS} more", "", "", "")
    parts: list[RenderableType] = [head, table] if result.steps else [head]
    parts.append(sentence(f"{result.reason}; {result.tries} attempts in {result.elapsed:.2g} s", "dim"))
    return Group(*parts)


def save_placements_png(result: Placements, path: str | os.PathLike[str]) -> None:
    """Write the states after the steps as a PNG, with the newest object in colour; of many, every n-th is drawn."""
    assembly, count = result.assembly, len(result.steps)
    solids = {solid.name: solid for solid in solids_of(assembly.bodies)}
    frames = []
    for k in np.unique(np.linspace(0, max(count - 1, 0), min(count, MOST_FRAMES)).round().astype(int))[:count].tolist():
        step, later = result.steps[k], set(result.order[k + 1 :])
        note = f"least push {step.least_text}" if step.least is not None and not step.balanced else step.least_text
        shown = tuple(solid for name, solid in solids.items() if name not in later)
        frames.append(Frame(shown, step.body, f"{k + 1}  {step.body}", note))
    if not frames:
        frames.append(Frame(tuple(solids.values()), "", "nothing is placed", result.reason))
    title = f"{assembly.scene.name or 'assembly'}: {count} of {count + len(result.left)} objects placed"
    subtitle = f"{result.reason} · engine {result.engine} ({result.claim.words})"
    up = assembly.scene.up
    write_sequence(Sequence(title, subtitle, tuple(frames), up, up, arriving=True, marked=MARKED), path)
