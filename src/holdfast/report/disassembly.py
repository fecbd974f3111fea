"""Show an order of removals as a table and as a strip of pictures."""

from __future__ import annotations

import os

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.disassembly.least_hold import handled, hands_column
from holdfast.applications.disassembly.order import Disassembly
from holdfast.base.text import listed
from holdfast.drawing.sequence import Frame, Sequence, write_sequence
from holdfast.report.bodies import solids_of
from holdfast.report.texts import MOST_ROWS, cell, headline, sentence

MOST_FRAMES = 24  # largest number of states in a strip of pictures


def disassembly_report(result: Disassembly) -> RenderableType:
    """Return a table of the steps in order, and a table of the other bodies with the reasons why they stay."""
    name = result.assembly.scene.name or "scene"
    head = headline(name, _outcome(result), f"  (engine {result.engine}: {result.claim.words})")
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("step", justify="right")
    for heading in ("take out", *hands_column(result.hands), "why it may go"):
        table.add_column(heading)
    for k, step in enumerate(result.steps[:MOST_ROWS]):
        held = [sentence(text) for text in handled(step.holds, result.hands)]
        table.add_row(str(k + 1), cell(step.body), *held, sentence(step.reason))
    if len(result.steps) > MOST_ROWS:
        table.add_row("", f"... and {len(result.steps) - MOST_ROWS} more")
    parts: list[RenderableType] = [head]
    if result.steps:
        parts.append(table)
    if result.stuck:
        stuck = Table(title="why the others stay", title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
        for heading in ("body", "taking it out is", "reason"):
            stuck.add_column(heading)
        for removal in result.stuck[:MOST_ROWS]:
            stuck.add_row(cell(removal.body), cell(removal.answer), sentence(removal.reason))
        parts.append(stuck)
        if result.undecided.count:
            parts.append(sentence(f"{result.undecided.brief} of those that stay", "bold yellow"))
    return Group(*parts)


def save_strip(result: Disassembly, path: str | os.PathLike[str]) -> None:
    """Write the sequence as a PNG, one panel for each state, with the body that is removed next in colour.

    Of a long sequence, only every n-th state is drawn.
    """
    write_sequence(strip_of(result), path)


def strip_of(result: Disassembly) -> Sequence:
    """Return the states as a sequence of panels; if bodies remain, the last panel shows them."""
    assembly, count = result.assembly, len(result.steps)
    solids = {solid.name: solid for solid in solids_of(assembly.bodies)}
    chosen = np.unique(np.linspace(0, max(count - 1, 0), min(count, MOST_FRAMES)).round().astype(int)).tolist()
    frames = []
    for k in chosen[:count]:
        step = result.steps[k]
        gone = set(result.order[:k])
        note = "hold it against turning" if step.hold else "the rest stands without it"
        note += f"; hands at {listed([hold.body for hold in step.holds])}" if step.holds else ""
        left = tuple(solid for name, solid in solids.items() if name not in gone)
        frames.append(Frame(left, step.body, f"{k + 1}  {step.body}", note))
    if result.remaining or not frames:
        left = tuple(solid for name, solid in solids.items() if name not in result.order)
        stuck = "the goal is among them" if result.goal else "none of them may go next"
        note = "asked for no more" if result.reached else stuck
        frames.append(Frame(left, "", f"{len(result.remaining)} stay", note))
    return Sequence(
        f"{assembly.scene.name or 'assembly'}: taken apart",
        _outcome(result)[0] + f" · engine {result.engine} ({result.claim.words})",
        tuple(frames),
        np.asarray(result.lift),
        assembly.scene.up,
        marked="what is taken out next, and which way",
    )


def _outcome(result: Disassembly) -> tuple[str, str]:
    """Return the outcome in words, with a style."""
    count, whole = len(result.steps), len(result.assembly.movable)
    if result.reached and not result.goal:
        return f"all {whole} bodies come out one by one", "bold green"
    if result.falsework:
        return f"{count} of {whole} bodies come out, with props under {listed(result.falsework)}", "bold yellow"
    if result.reached:
        fewest = "no order takes fewer" if result.proven else f"no order takes fewer than {result.fewest:.0f}"
        return f"{listed(result.goal)} out after {count} removals ({fewest})", "bold green"
    if result.proven and result.goal:
        return f"{listed(result.goal)} cannot be taken out by any order", "bold red"
    if result.proven:
        return f"{count} of {whole} bodies come out, and no order takes out all", "bold red"
    return f"{count} of {whole} bodies come out; whether another order takes out all is not known", "bold yellow"
