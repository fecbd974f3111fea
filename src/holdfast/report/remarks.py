"""What tables of answers say in words beside their numbers."""

from __future__ import annotations

import shlex

from rich.text import Text

from holdfast.base.text import listed
from holdfast.engines.verdict import Status, Verdict
from holdfast.queries.result import Columns
from holdfast.report.texts import sentence

SHOWN = 5  # largest number of names in a cell


def remarks(result: Columns) -> list[Text]:
    """Return the reason of a verdict that is not STABLE, the number of undecided answers, and the notes, none twice."""
    stands = result.verdict.status is Status.STABLE
    remarks = [] if stands else [sentence(result.verdict.reason, "dim")]
    notes = [note for note in result.notes if not repeats(note, result.verdict)]
    if result.undecided.count:
        known = {result.verdict.reason, *result.notes}.issuperset(result.undecided.reasons)
        remarks.append(sentence(result.undecided.brief if known else result.undecided.text, "bold yellow"))
    return remarks + [sentence(f"note: {note}", "yellow") for note in (*notes, *_way_out(result))]


def repeats(note: str, verdict: Verdict) -> bool:
    """Tell whether a note says of some bodies only what the reason of a verdict that is not STABLE says already."""
    said = (note.partition(word)[2] for word in (": does not stand: ", ": undecided: ") if word in note)
    return verdict.status is not Status.STABLE and (verdict.reason in note or any(s in verdict.reason for s in said))


def _way_out(result: Columns) -> list[str]:
    """Return how to leave out bodies that are only balanced, if the least answer is 0 because of them."""
    names = [name for name in result.verdict.balanced if name in _moving_at_least(result)]
    options = " ".join(f"--without {shlex.quote(name)}" for name in names)
    one = f"{listed(names, SHOWN)} {'are' if len(names) > 1 else 'is'} only balanced"
    return [f"the least is 0 because {one}: {options} asks about the rest"] if names else []


def _moving_at_least(result: Columns) -> tuple[str, ...]:
    """Return which bodies move at the least answer if that is 0."""
    if not result.answers.decided.any():
        return ()
    least = int(result.answers.ranking[0])
    zero = result.status[least] is Status.FINITE and result.answers.force[least] == 0
    return tuple(result.moving[least]) if zero else ()


def moving_words(mode: str, moving: tuple[str, ...], kind: str) -> str:
    """Describe what moves and how, after the ``kind`` of the answer, which may be ""."""
    what = f"{mode}: {listed(moving, SHOWN)}" if moving else ""
    return ", ".join(filter(None, [kind, what]))
