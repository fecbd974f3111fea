"""Show a single push in the terminal."""

from __future__ import annotations

import math

from rich.console import Group, RenderableType

from holdfast.base.public import number
from holdfast.engines.answers import Bound, Claim
from holdfast.engines.verdict import Status
from holdfast.queries.push import Robustness
from holdfast.queries.result import gives_way, holds_up_to
from holdfast.report.remarks import repeats
from holdfast.report.texts import headline, sentence

_STYLE = {
    Status.FINITE: "bold",
    Status.INFINITE: "bold green",
    Status.UNSTABLE: "bold red",
    Status.UNDECIDED: "bold yellow",
}


def push_report(result: Robustness) -> RenderableType:
    """Return lines with the force of the first push of an answer, its bounds, and what moves."""
    status, force, exists = result.status[0], float(result.force[0]), result.claim is Claim.EXISTS
    words = {
        Status.FINITE: f"{number(force, 'N')} before something moves",
        Status.INFINITE: f"however hard: {'an equilibrium exists' if exists else 'nothing moves'}",
        Status.UNSTABLE: "nothing: it does not stand even without a push",
        Status.UNDECIDED: "undecided",
    }
    lines: list[RenderableType] = [
        headline(result.body, (words[status], _STYLE[status]), f"  (engine {result.engine}: {result.claim.words})")
    ]
    mechanism = result.mechanism[0]
    if status is Status.FINITE:
        if force > 0:  # bounds of what is only balanced are rounding
            lines.append(sentence("; ".join(bounds_text(result))))
        lines.append(sentence(mechanism.text if mechanism else gives_way(result.mode[0], result.moving[0]), "dim"))
    if status is Status.UNDECIDED:
        lines += [sentence(reason, "yellow") for reason in result.undecided.reasons]
    if status is Status.UNSTABLE:
        crushed = mechanism is not None and mechanism.mode == "crush"
        lines.append(sentence(mechanism.text if mechanism and crushed else result.verdict.reason, "dim"))
    said = () if status is Status.FINITE else (*result.undecided.reasons, result.verdict.reason)
    notes = [note for note in result.notes if note not in said and not repeats(note, result.verdict)]
    return Group(*lines, *(sentence(f"note: {note}", "yellow") for note in notes))


def bounds_text(result: Robustness) -> list[str]:
    """Describe the lower and the upper bound of the first push of an answer."""
    lines = []
    if result.lower_bound is not Bound.NONE:
        lines.append(holds_up_to(result.answers, 0, "N"))
    if result.upper_bound is not Bound.NONE and math.isfinite(result.upper[0]):
        lines.append(f"{result.upper_bound} to move above {number(float(result.upper[0]), 'N')}")
    return lines or ["no bound is known on either side"]
