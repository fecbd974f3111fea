"""Deadlines stop work between two reports, and the earlier of two nested ones holds."""

from __future__ import annotations

import time

import pytest

from holdfast.base.progress import OutOfTimeError, keep_to_time, left_if_stopped, listening, report, until

LONG_AGO, NEVER = -float("inf"), float("inf")


def test_a_deadline_that_has_passed_stops_the_next_report_before_it_is_heard() -> None:
    heard: list[str] = []
    with listening(lambda stage, done, total: heard.append(stage)):
        with until(NEVER):
            report("before", 0, 1)
        with until(LONG_AGO), pytest.raises(OutOfTimeError):
            report("after", 0, 1)
        report("again", 0, 1)
    assert heard == ["before", "again"]


def test_the_earlier_of_two_deadlines_holds() -> None:
    for outer, inner in ((LONG_AGO, NEVER), (NEVER, LONG_AGO)):
        with until(outer), until(inner), pytest.raises(OutOfTimeError):
            keep_to_time()
    keep_to_time()


def test_a_deadline_holds_in_a_thread_too() -> None:
    with until(time.perf_counter() - 1), pytest.raises(OutOfTimeError):
        left_if_stopped(keep_to_time)
