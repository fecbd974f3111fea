"""Answers in jams: ``lower`` is what is reached before bodies that the load jams have slid far.

Behind that, friction opposes where nodes came from and not where they go, and simulators let bodies go earlier.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from holdfast.engines.amendments.amendment import MATTERS, Amendment, Asked
from holdfast.engines.answers import Answers


@dataclass(frozen=True, eq=False)
class Sliding(Amendment):
    """Lowers the bounds of answers that are reached only after sliding far."""

    name: ClassVar[str] = "sliding far in a jam"
    why: ClassVar[str] = "what a jam holds only after its contacts have slid far is not promised"

    def applies(self, asked: Asked) -> bool:
        """Tell whether some path slides far before its bound is reached."""
        return asked.bounded and bool((asked.columns.before < asked.columns.lower).any())

    def amend(self, found: Answers, asked: Asked) -> Answers:
        """Return the answers with ``lower`` at most what is reached before bodies slide far.

        A path that turned out to have left its branch, as the answer has no end, tells nothing.
        """
        columns, loaded = asked.columns, asked.loaded
        slides = (columns.before < columns.lower) & (np.isfinite(found.force[loaded]) | np.isinf(columns.factor))
        if not slides.any():
            return found
        most = np.minimum(found.lower[loaded], np.where(slides, columns.before, np.inf))
        telling = int((most < (1 - MATTERS) * found.lower[loaded]).sum())
        lower = np.array(found.lower)
        lower[loaded] = most
        words = f"{telling} of {len(found)} answers hold only after sliding: lower is what is reached before"
        return replace(found, lower=lower, notes=(*found.notes, words) if telling else found.notes)
