"""What is said about an answer: parts and words that terminals, pages and pictures show alike."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from holdfast.base.text import escaped, listed, one_line
from holdfast.engines.answers import Claim
from holdfast.engines.verdict import Status, Verdict
from holdfast.queries.result import NAMED, Columns, kind_of

MOST_ROWS = 60  # largest number of rows in a table
MOST_FRAMES = 24  # largest number of states in a strip of removals or of poses
LONGEST_CELL = 120  # largest number of characters in a cell of a table
LONGEST_REASON = 2000  # largest number of characters of a reason or a note
SHOWN = 5  # largest number of names in a cell
# the verb of each verdict, and its style on the terminal
WORDS = {Status.STABLE: "stands", Status.UNSTABLE: "does not stand", Status.UNDECIDED: "is undecided"}
STYLES = {Status.STABLE: "bold green", Status.UNSTABLE: "bold red", Status.UNDECIDED: "bold yellow"}


class Headline(NamedTuple):
    """The first line of a report: the name of the scene or the body, the outcome with its style, and the rest."""

    name: str
    outcome: str
    style: str
    rest: str = ""

    def __rich__(self) -> Text:
        name, rest = one_line(self.name, LONGEST_CELL), one_line(self.rest)
        return Text.assemble((name, "bold"), ": ", (self.outcome, self.style), rest)


class Line(NamedTuple):
    """A sentence of an answer, which may name bodies."""

    text: str
    style: str = ""

    def __rich__(self) -> Text:
        return Text(one_line(self.text, LONGEST_REASON), style=self.style)


@dataclass(frozen=True)
class ReportTable:
    """A table of texts under ``heads``, of which the first ``most`` rows are shown.

    The columns with the numbers ``right`` are aligned to the right, and those with the numbers ``prose`` hold
    sentences, which may be longer than names. ``more_at`` is the column that says how many rows are left out. With
    ``whole``, no column but the last is wrapped; ``airy`` puts more space between columns.
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    title: str | None = None
    right: Sequence[int] = ()
    prose: Sequence[int] = ()
    most: int | None = None
    more_at: int = 0
    whole: bool = False
    airy: bool = False

    def __rich__(self) -> Table:
        padding = (0, 1) if self.airy else (0, 1, 0, 0)
        table = Table(title=self.title, title_justify="left", box=SIMPLE_HEAD, padding=padding)
        last = len(self.heads) - 1
        for k, head in enumerate(self.heads):
            justify, no_wrap = "right" if k in self.right else "left", self.whole and k < last
            table.add_column(_cell(head), justify=justify, no_wrap=no_wrap)  # type: ignore[arg-type]
        most = MOST_ROWS if self.most is None else self.most
        for row in self.rows[:most]:
            table.add_row(*(Line(text).__rich__() if k in self.prose else _cell(text) for k, text in enumerate(row)))
        if len(self.rows) > most:
            table.add_row(*[""] * self.more_at, f"... and {len(self.rows) - most} more")
        return table

    def html(self) -> str:
        """Return all rows as HTML, or that there are none."""
        if not self.rows:
            return "<p>none</p>"
        top = "".join(f"<th>{escaped(head)}</th>" for head in self.heads)
        body = "".join(f"<tr>{''.join(f'<td>{escaped(text)}</td>' for text in row)}</tr>" for row in self.rows)
        return f"<table><tr>{top}</tr>{body}</table>"


def _cell(text: str) -> Text:
    return Text(one_line(text, LONGEST_CELL))


class Report:
    """The parts of a report in order; a console of rich prints them."""

    def __init__(self, *parts: Headline | Line | Text | ReportTable) -> None:
        self.parts = parts

    def __rich__(self) -> RenderableType:
        return Group(*self.parts)


def noted(notes: Iterable[str]) -> list[Line]:
    """Return the notes of an answer as lines."""
    return [Line(f"note: {note}", "yellow") for note in notes]


def by_engine(engine: str, claim: Claim) -> str:
    """Return the end of a headline: the engine that answered, and what it promises."""
    return f"  (engine {engine}: {claim.words})"


def what_moves(pushed: str, mode: str, moving: tuple[str, ...]) -> str:
    """Describe what a push does, with the moving bodies unless only the ``pushed`` body moves."""
    return kind_of(mode) if moving in ((), (pushed,)) else f"{kind_of(mode)} of {listed(moving, NAMED)}"


def moving_words(mode: str, moving: tuple[str, ...], kind: str) -> str:
    """Describe what moves and how, after the ``kind`` of the answer, which may be ""."""
    what = f"{kind_of(mode)}: {listed(moving, SHOWN)}" if moving else ""
    return ", ".join(filter(None, [kind, what]))


def partly_undecided(unknown: int, count: int) -> str:
    """Return how many of the answers that a row stands for are undecided, unless all or none are."""
    return f"; {unknown} of {count} undecided" if 0 < unknown < count else ""


def remarks(result: Columns) -> list[Line]:
    """Return the reason of a verdict that is not STABLE, the number of undecided answers, and the notes, none twice."""
    lines = [] if result.verdict.status is Status.STABLE else [Line(result.verdict.reason, "dim")]
    notes = [note for note in result.notes if not repeats(note, result.verdict)]
    if result.undecided.count:
        known = {result.verdict.reason, *result.notes}.issuperset(result.undecided.reasons)
        lines.append(Line(result.undecided.brief if known else result.undecided.text, "bold yellow"))
    return lines + noted([*notes, *_way_out(result)])


def repeats(note: str, verdict: Verdict) -> bool:
    """Tell whether a note says of some bodies only what the reason of a verdict that is not STABLE says already."""
    said = (note.partition(word)[2] for word in (": does not stand: ", ": undecided: ") if word in note)
    return verdict.status is not Status.STABLE and (verdict.reason in note or any(s in verdict.reason for s in said))


def _way_out(result: Columns) -> list[str]:
    """Return how to leave out bodies that are only balanced, if the least answer is 0 because of them."""
    if not result.answers.decided.any():
        return []
    least = int(result.answers.ranking[0])
    if result.status[least] is not Status.FINITE or result.answers.force[least] != 0:
        return []
    names = [name for name in result.verdict.balanced if name in result.moving[least]]
    options = " ".join(f"--without {shlex.quote(name)}" for name in names)
    one = f"{listed(names, SHOWN)} {'are' if len(names) > 1 else 'is'} only balanced"
    return [f"the least is 0 because {one}: {options} asks about the rest"] if names else []
