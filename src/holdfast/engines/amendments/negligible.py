"""Forces that rounding alone tells from none: the body is only balanced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from holdfast.assembly.assembly import Assembly
from holdfast.base.arrays import Float
from holdfast.engines.answers import ONLY_BALANCED, Answers, only_balanced
from holdfast.engines.verdict import Status

NO_FORCE = 1e-8  # share of the weight of the pushed body below which a force is a rounding error of none


def without_negligible(found: Answers, W: Float, assembly: Assembly) -> Answers:
    """Return the answers with 0 for forces on one group that rounding alone tells from 0, and a note that says so.

    Engines ``limit`` and ``graph`` need it: of a plank balanced on an edge they tell 1e-18 N and 1e-15 N.
    Forces are compared with the own weight of the bodies that are pushed: a light body may rest on a heavy one.
    """
    own = np.abs(W * assembly.equation_scale[:, None]).max(0, initial=0.0) / assembly.weight
    finite = found.status == Status.FINITE
    slight = finite & (np.where(finite, found.force, 0.0) * own <= NO_FORCE)
    if not slight.any():
        return found
    force, lower = np.where(slight, 0.0, found.force), np.where(slight, 0.0, found.lower)
    names = tuple(dict.fromkeys(name for moving in found.moving[slight] for name in moving))
    noted = any(ONLY_BALANCED in note for note in found.notes)
    notes = found.notes if noted or not names else (*found.notes, only_balanced(names))
    return replace(found, force=force, lower=lower, notes=notes).after(
        "only balanced", "rounding alone tells the force from none"
    )
