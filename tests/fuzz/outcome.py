"""How the trial of one input may end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum, auto


class Ending(StrEnum):
    """The classes of endings; only the first two are as they should be."""

    OK = auto()  # an answer, and nothing speaks against it
    TOLD = auto()  # one of holdfast's own errors
    CRASH = auto()  # any other error, or the death of the process
    HANG = auto()  # no ending within the time limit
    NAN = auto()  # an answer that is not a number
    CONTRADICTION = auto()  # two answers of which one must be wrong
    LEAK = auto()  # a hostile name that reached an output as it is
    MEMORY = auto()  # more memory than an input of its size may take


GOOD = (Ending.OK, Ending.TOLD)


@dataclass(frozen=True)
class Outcome:
    """The ending of one trial; ``sign`` is the same for all inputs that end so for the same reason.

    ``seconds`` and ``peak`` [MB], the largest resident memory of the process meanwhile, are measured around the trial.
    """

    ending: Ending
    sign: str = ""
    detail: str = ""
    seconds: float = 0.0
    peak: float = 0.0

    @property
    def good(self) -> bool:
        return self.ending in GOOD

    def like(self, other: Outcome) -> bool:
        """Tell whether both show the same defect."""
        return (self.ending, self.sign) == (other.ending, other.sign)
