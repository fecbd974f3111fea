"""Answers that lean on contacts which are open and idle at rest: ``lower`` is without them.

Which contacts these are, and why no bound may lean on them, is said in compliant/idle_contacts.py.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from holdfast.base.text import listed
from holdfast.engines.amendments.amendment import MATTERS, Amendment, Asked
from holdfast.engines.answers import Answers
from holdfast.engines.compliant.idle_contacts import open_pair
from holdfast.engines.mechanism import NAMED


@dataclass(frozen=True, eq=False)
class OpenContacts(Amendment):
    """Lowers the bounds of answers in which contacts take part that need not exist."""

    name: ClassVar[str] = "contacts that are open at rest"
    why: ClassVar[str] = "contacts that are open and carry nothing at rest may never close, so lower is without them"

    def applies(self, asked: Asked) -> bool:
        """Tell whether such contacts carry some of a load at its peak."""
        return asked.bounded and bool(asked.columns.leans.any()) and self.state.without_idle is not None

    def amend(self, found: Answers, asked: Asked) -> Answers:
        """Return the answers; of those that lean on contacts idle at rest, ``lower`` is as without all of these."""
        bare, leaning = self.state.without_idle, asked.loaded[asked.columns.leans]
        if bare is None:
            return found
        there, lower = bare.load_factor(asked.W[:, leaning], asked.accuracy), np.array(found.lower)
        least = np.minimum(lower[leaning], there.lower)
        telling = int((least < (1 - MATTERS) * lower[leaning]).sum())
        lower[leaning] = least
        assembly = self.grid.assembly
        which = listed([open_pair(assembly, k) for k in self.grid.idle if assembly.interfaces[k].certain], NAMED)
        if not telling or not which:  # of contacts that are not certain doubtful_contacts.py tells
            return replace(found, lower=lower)
        words = f"{telling} of {len(found)} answers lean on contacts that are open at rest, and lower is without them"
        return replace(found, lower=lower, notes=(*found.notes, f"{words}: {which}"))
