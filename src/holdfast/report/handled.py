"""Show answers about bodies that are taken out, put in or pushed, as tables."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table

from holdfast.applications.disassembly.build import BuildOrder, shown
from holdfast.applications.disassembly.least_hold import handled, hands_column
from holdfast.applications.disassembly.removal import Answer, Removal
from holdfast.applications.pushing.result import Effect, SafePushes
from holdfast.base.public import Summary, number
from holdfast.base.text import listed
from holdfast.report.texts import MOST_ROWS, cell, headline, sentence

STYLE = {Answer.SAFE: "bold green", Answer.UNSAFE: "bold red", Answer.UNDECIDED: "bold yellow"}


def removal_report(result: Removal) -> RenderableType:
    """Return the answer, its reason, the bodies in the way and the bodies that would move."""
    word = {Answer.SAFE: "may be taken out", Answer.UNSAFE: "may not be taken out"}.get(result.answer, "undecided")
    parts = [headline(result.body, (word, STYLE[result.answer]), ""), sentence(result.reason)]
    if result.blockers:
        parts.append(sentence(f"in the way: {listed([name for name, _ in result.blockers])}"))
    if result.moving:
        parts.append(sentence(f"would move: {listed(result.moving)}"))
    return Group(*parts)


def build_report(result: BuildOrder) -> RenderableType:
    """Return a table of the steps with the smallest push that moves something, and of the bodies left over."""
    count, whole = len(result.steps), len(result.assembly.movable)
    if result.reached:
        outcome = f"all {whole} bodies go in one by one", "bold green"
    elif result.falsework:
        outcome = f"all {whole} bodies go in, with props under {listed(result.falsework)}", "bold yellow"
    else:
        doubt = "no order needs fewer" if result.proven else "whether another order needs fewer is not known"
        outcome = f"{listed(result.first)} must stand before the other {count}: {doubt}", "bold yellow"
    parts: list[RenderableType] = [
        headline(result.assembly.scene.name or "scene", outcome, f"  (engine {result.engine}: {result.claim.words})")
    ]
    if result.steps:
        rows = [
            (
                *(str(k + 1), step.body, shown(step), step.weakest.body if step.weakest else ""),
                *(*handled(step.holds, result.hands), step.reason),
            )
            for k, step in enumerate(result.steps)
        ]
        heads = ("step", "put in", "least push then", "on", *hands_column(result.hands), "why it may go in")
        parts.append(_table(heads, rows))
    if result.stuck:
        why = [(removal.body, str(removal.answer), removal.reason) for removal in result.stuck]
        parts.append(_table(("body", "last", "why it cannot be put in last"), why))
    return Group(*parts)


def pushes_report(result: SafePushes) -> RenderableType:
    """Return the number of pushes with each effect, and examples."""
    summary: Summary = result.summary()
    alone, nothing = int(result.alone.sum()), int(result.nothing.sum())
    style = "bold green" if alone or nothing else "bold yellow"
    outcome = f"{alone} of {len(result.effect)} pushes move it alone, {nothing} nothing", style
    rest = f"  (up to {number(result.force, 'N')}, engine {result.engine}: {result.claim.words})"
    unknown = int(result.are(Effect.UNKNOWN).sum())
    left = f"{result.unreached} more are out of the tool's reach; of {unknown} it is not known"
    rows = [tuple(row) for row in summary.rows]
    return Group(headline(result.body, outcome, rest), sentence(left), _table(tuple(summary.heads), rows))


def _table(heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> Table:
    made = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for head in heads:
        made.add_column(head)
    for row in rows[:MOST_ROWS]:
        made.add_row(*(cell(text) for text in row[:-1]), sentence(row[-1]))
    if len(rows) > MOST_ROWS:
        made.add_row("", f"... and {len(rows) - MOST_ROWS} more", *[""] * (len(heads) - 2))
    return made
