"""What two engines and a repetition say of the same pushes, and which of it cannot be true at once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import holdfast as hf

RELATIVE = 2e-3  # of an answer: `compliant` promises no better than its steps along a path
ENDLESS = 1e5  # weights of the pushed body: `compliant` balances each to 1e-7 of its own, and larger factors are no end
OF_WEIGHT = 1e-6  # of the total weight: what a solver resolves where bodies are only balanced


def nans(answer: hf.answers.Robustness) -> Iterator[str]:
    """Name the columns that hold NaN, or numbers that no push can have."""
    for name in ("force", "lower", "upper"):
        column = getattr(answer, name)
        if np.isnan(column).any() or (column < 0).any():
            yield f"{answer.engine}.{name}"


def contradictions(answer: hf.answers.Robustness) -> Iterator[tuple[str, str]]:
    """Compare the columns of one answer: pairs of a rule that is broken and the numbers."""
    columns = zip(answer.status, answer.force, answer.lower, answer.upper, strict=True)
    for k, (status, force, lower, upper) in enumerate(columns):
        told = f"push {k} by {answer.engine}: {status}, {lower!r} <= {force!r} <= {upper!r}"
        if not lower <= force <= upper and status is not hf.Status.UNDECIDED:
            yield "lower <= force <= upper", told
        if status is hf.Status.UNDECIDED and not lower <= upper:
            yield "lower <= upper", told
        if (status is hf.Status.INFINITE) != bool(np.isinf(force)):
            yield "infinite", told
        if status is hf.Status.UNSTABLE and force != 0:
            yield "unstable with a force", told


def between(
    limit: hf.answers.Robustness, other: hf.answers.Robustness, weight: float, own: float
) -> Iterator[tuple[str, str]]:
    """Compare the answers of an engine whose bodies hold with those of limit analysis, which proves its bounds.

    ``weight`` [N] is that of all bodies, ``own`` that of the pushed one.
    """
    proved = limit.verdict.status is hf.Status.UNSTABLE and limit.verdict.equilibrium_exists is False
    if proved and other.verdict.status is hf.Status.STABLE:
        yield "stable, yet proved to move", f"{limit.verdict.reason} | {other.verdict.reason}"
    for k, (upper, force, lower) in enumerate(zip(limit.upper, other.force, other.lower, strict=True)):
        if other.status[k] is hf.Status.UNDECIDED or limit.status[k] is hf.Status.UNDECIDED:
            continue
        if upper > ENDLESS * own:
            continue
        most = upper * (1 + RELATIVE) + OF_WEIGHT * weight
        told = f"push {k}: {other.engine} {lower!r}, {force!r}; limit {limit.force[k]!r} at most {upper!r}"
        if lower > most:
            yield f"{other.engine}.lower above limit.upper", told
        elif force > most:
            yield f"{other.engine} above limit.upper", told


def changed(first: hf.answers.Robustness, again: hf.answers.Robustness) -> bool:
    """Tell whether the same question had another answer."""
    return any(not np.array_equal(getattr(first, name), getattr(again, name)) for name in ("force", "lower", "upper"))
