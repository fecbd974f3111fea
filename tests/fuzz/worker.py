"""What a worker of the fuzzer does with an input: try it, and judge the memory that this took."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from fuzz.outcome import Ending, Outcome
from holdfast.base.borders.worker import MEGABYTE, taken

_trials: list[tuple[Callable[[dict[str, Any]], Outcome], int]] = []  # the one function, and its megabytes


def warm(setup: tuple[str, int]) -> None:
    """Take the function (module:name) that tries inputs, and the memory [MB] that a trial may take.

    What is compiled and imported once is no part of a trial.
    """
    function, megabytes = setup
    module, name = function.split(":")
    home = importlib.import_module(module)
    getattr(home, "warm", int)()
    _trials[:] = [(getattr(home, name), megabytes)]


def answered(item: dict[str, Any], tell: Callable[[Any], None]) -> Outcome:
    """Try one input; half the memory that a trial may take is more than an input of its size should."""
    ((tried, megabytes),) = _trials
    before = taken("VmRSS")
    found = tried(item)
    peak = taken("VmHWM")
    if found.good and peak - before > megabytes * MEGABYTE / 2:
        return Outcome(Ending.MEMORY, "took much", f"{(peak - before) / MEGABYTE:.0f} MB; {found.detail}")
    return found
