"""What is said about taking bodies out, putting them in and pushing them: orders of steps, and single answers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from holdfast.applications.disassembly.build import BuildOrder, shown
from holdfast.applications.disassembly.least_hold import handled, hands_column
from holdfast.applications.disassembly.order import Disassembly
from holdfast.applications.disassembly.removal import Answer, Removal
from holdfast.applications.pushing.safe_pushes import Effect, SafePushes
from holdfast.base.public import number
from holdfast.base.text import listed
from holdfast.drawing.panel_sheets import StateFrame, StateSequence
from holdfast.report.description import MOST_FRAMES, MOST_ROWS, STYLES, Headline, Line, Report, ReportTable, by_engine
from holdfast.report.map_picture import solids_of

if TYPE_CHECKING:
    from holdfast.applications.placement.result import Placements

MOST_PUT = 12  # largest number of states in a strip of objects that are put down
OUTCOMES = {  # of a removal, with the style on the terminal
    Answer.SAFE: ("may be taken out", "bold green"),
    Answer.UNSAFE: ("may not be taken out", "bold red"),
    Answer.UNDECIDED: ("undecided", "bold yellow"),
}


def removal_report(result: Removal) -> Report:
    """Return the answer, its reason, the bodies in the way and the bodies that would move."""
    lines = [result.reason]
    if result.blockers:
        lines.append(f"in the way: {listed([name for name, _ in result.blockers])}")
    if result.moving:
        lines.append(f"would move: {listed(result.moving)}")
    return Report(Headline(result.body, *OUTCOMES[result.answer]), *map(Line, lines))


def disassembly_report(result: Disassembly) -> Report:
    """Return a table of the steps in order, and a table of the other bodies with the reasons why they stay."""
    engine = by_engine(result.engine, result.claim)
    parts: list[Headline | Line | ReportTable] = [
        Headline(result.assembly.scene.name or "scene", *_taken_out(result), engine)
    ]
    if result.steps:
        heads = ("step", "take out", *hands_column(result.hands), "why it may go")
        rows = [
            (str(k), step.body, *handled(step.holds, result.hands), step.reason)
            for k, step in enumerate(result.steps, 1)
        ]
        parts.append(ReportTable(heads, rows, right=(0,), prose=range(2, len(heads)), more_at=1))
    if result.stuck:
        rows = [(removal.body, str(removal.answer), removal.reason) for removal in result.stuck[:MOST_ROWS]]
        heads = ("body", "taking it out is", "reason")
        parts.append(ReportTable(heads, rows, "why the others stay", prose=(2,)))
        if result.undecided.count:
            parts.append(Line(f"{result.undecided.brief} of those that stay", "bold yellow"))
    return Report(*parts)


def _taken_out(result: Disassembly) -> tuple[str, str]:
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


def strip_of(result: Disassembly) -> StateSequence:
    """Return the states as a sequence of panels, each with the body that is removed next in colour.

    Of a long sequence, only every n-th state is drawn. If bodies remain, the last panel shows them.
    """
    assembly = result.assembly
    solids = {solid.name: solid for solid in solids_of(assembly.bodies)}
    frames = []
    for k in _every_nth(len(result.steps), MOST_FRAMES):
        step, gone = result.steps[k], set(result.order[:k])
        note = "hold it against turning" if step.hold else "the rest stands without it"
        note += f"; hands at {listed([hold.body for hold in step.holds])}" if step.holds else ""
        left = tuple(solid for name, solid in solids.items() if name not in gone)
        frames.append(StateFrame(left, step.body, f"{k + 1}  {step.body}", note))
    if result.remaining or not frames:
        left = tuple(solid for name, solid in solids.items() if name not in result.order)
        stuck = "the goal is among them" if result.goal else "none of them may go next"
        note = "asked for no more" if result.reached else stuck
        frames.append(StateFrame(left, "", f"{len(result.remaining)} stay", note))
    return StateSequence(
        f"{assembly.scene.name or 'assembly'}: taken apart",
        _taken_out(result)[0] + f" · engine {result.engine} ({result.claim.words})",
        tuple(frames),
        np.asarray(result.lift),
        assembly.scene.up,
        marked="what is taken out next, and which way",
    )


def _every_nth(count: int, most: int) -> list[int]:
    """Return at most ``most`` numbers below ``count``, evenly spread, with the first and the last."""
    spread = np.linspace(0, max(count - 1, 0), min(count, most)).round().astype(int)
    return [int(k) for k in np.unique(spread)]


def build_report(result: BuildOrder) -> Report:
    """Return a table of the steps with the smallest push that moves something, and of the bodies left over."""
    count, whole = len(result.steps), len(result.assembly.movable)
    if result.reached:
        outcome = f"all {whole} bodies go in one by one", "bold green"
    elif result.falsework:
        outcome = f"all {whole} bodies go in, with props under {listed(result.falsework)}", "bold yellow"
    else:
        doubt = "no order needs fewer" if result.proven else "whether another order needs fewer is not known"
        outcome = f"{listed(result.first)} must stand before the other {count}: {doubt}", "bold yellow"
    engine = by_engine(result.engine, result.claim)
    parts: list[Headline | ReportTable] = [Headline(result.assembly.scene.name or "scene", *outcome, engine)]
    if result.steps:
        heads = ("step", "put in", "least push then", "on", *hands_column(result.hands), "why it may go in")
        rows = []
        for k, step in enumerate(result.steps, 1):
            on = step.weakest.body if step.weakest else ""
            rows.append((str(k), step.body, shown(step), on, *handled(step.holds, result.hands), step.reason))
        parts.append(ReportTable(heads, rows, prose=(len(heads) - 1,), more_at=1))
    if result.stuck:
        why = [(removal.body, str(removal.answer), removal.reason) for removal in result.stuck]
        parts.append(ReportTable(("body", "last", "why it cannot be put in last"), why, prose=(2,), more_at=1))
    return Report(*parts)


def placements_report(result: Placements, scene: str) -> Report:
    """Return a table of the steps in order, with the smallest push after each, or the reason why there are none."""
    whole = len(result.steps) + len(result.left)
    outcome, engine = f"{len(result.steps)} of {whole} objects placed", by_engine(result.engine, result.claim)
    rows = []
    for k, step in enumerate(result.steps, 1):
        place = ", ".join(f"{v + 0.0:.4g}" for v in step.pose[:3, 3])
        rows.append((str(k), step.body, place, listed(step.rests_on), step.least_text))
    heads = ("step", "put down", "at [m]", "on", "least push")
    return Report(
        Headline(result.assembly.scene.name or scene, outcome, STYLES[result.status], engine),
        *([ReportTable(heads, rows, right=(0, 4), prose=(3,), more_at=1)] if rows else []),
        Line(f"{result.reason}; {result.tries} attempts in {result.elapsed:.2g} s", "dim"),
    )


def placements_strip(result: Placements) -> StateSequence:
    """Return the states after the steps, with the newest object in colour; of many, every n-th is drawn."""
    assembly, count = result.assembly, len(result.steps)
    solids = {solid.name: solid for solid in solids_of(assembly.bodies)}
    frames = []
    for k in _every_nth(count, MOST_PUT):
        step, later = result.steps[k], set(result.order[k + 1 :])
        note = f"least push {step.least_text}" if step.least is not None and not step.balanced else step.least_text
        present = tuple(solid for name, solid in solids.items() if name not in later)
        frames.append(StateFrame(present, step.body, f"{k + 1}  {step.body}", note))
    if not frames:
        frames.append(StateFrame(tuple(solids.values()), "", "nothing is placed", result.reason))
    title = f"{assembly.scene.name or 'assembly'}: {count} of {count + len(result.left)} objects placed"
    subtitle = f"{result.reason} · engine {result.engine} ({result.claim.words})"
    marked, up = "the object that is put down", assembly.scene.up
    return StateSequence(title, subtitle, tuple(frames), up, up, arriving=True, marked=marked)


def pushes_report(result: SafePushes) -> Report:
    """Return the number of pushes with each effect, and examples."""
    summary = result.summary()
    alone, nothing = int(result.alone.sum()), int(result.nothing.sum())
    outcome = f"{alone} of {len(result.effect)} pushes move it alone, {nothing} nothing"
    rest = f"  (up to {number(result.force, 'N')}, engine {result.engine}: {result.claim.words})"
    unknown = int(result.are(Effect.UNKNOWN).sum())
    return Report(
        Headline(result.body, outcome, "bold green" if alone or nothing else "bold yellow", rest),
        Line(f"{result.unreached} more are out of the tool's reach; of {unknown} it is not known"),
        ReportTable(summary.heads, summary.rows, prose=(len(summary.heads) - 1,), more_at=1),
    )
