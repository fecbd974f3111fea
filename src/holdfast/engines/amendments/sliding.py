"""Answers that are reached only after contacts have slid far: ``lower`` is what is reached before.

Friction opposes where a contact came from in this law, and where it goes in reality. Both agree while contacts give; of
rows that lean and of jams the law finds peaks that bodies reach only after sliding for long, and they let go earlier.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from holdfast.engines.amendments.amendment import MATTERS, Amendment, Asked
from holdfast.engines.answers import Answers
from holdfast.native import core


@dataclass(frozen=True, eq=False)
class Sliding(Amendment):
    """Lowers the bounds of answers that are reached only after sliding SLID times as far as contacts give."""

    name: ClassVar[str] = "sliding far"
    why: ClassVar[str] = f"what holds only after sliding {core.SLID:g} times as far as contacts give is not promised"

    def applies(self, asked: Asked) -> bool:
        """Tell whether some path slides far before its bound is reached.

        Of faces that touch at high points only, what bonded contacts give is far too little; the ideal ones are asked.
        """
        ideal = self.grid.springs.faces is None
        return asked.bounded and ideal and bool((asked.columns.before < asked.columns.lower).any())

    def amend(self, found: Answers, asked: Asked) -> Answers:
        """Return the answers with ``lower`` at most what is reached before contacts have slid far.

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
        far = f"{core.SLID:g} times as far as contacts give"
        words = f"{telling} of {len(found)} answers hold more only after sliding {far}"
        return replace(found, lower=lower, notes=(*found.notes, words) if telling else found.notes)
