"""Work in threads: all of it is done, its progress is told, and it can be stopped."""

from __future__ import annotations

import os
from collections.abc import Iterable
from threading import Event, current_thread

import pytest

from holdfast.base.progress import begin, cores, free_threads, in_parallel, left_if_stopped, listening, report


class Stopped(KeyboardInterrupt):
    """The user has had enough."""


def test_every_row_is_done_once_and_the_last_report_says_so() -> None:
    done: list[int] = []
    told: list[tuple[int, int]] = []
    with listening(lambda _, now, total: told.append((now, total))):
        in_parallel("work", lambda rows, memory: done.extend(rows), [None, None], 7, 14)
    assert sorted(done) == list(range(7))
    assert told[0] == (0, 14)
    assert told[-1] == (14, 14)


def test_what_is_done_in_a_thread_has_no_threads_and_no_listeners_of_its_own() -> None:
    told: list[tuple[str, int]] = []
    seen: list[int] = []

    def run(rows: Iterable[int], memory: None) -> None:
        for row in rows:
            report("inner", row, 3)
            seen.append(free_threads())

    with listening(lambda stage, now, total: told.append((stage, total))):
        in_parallel("outer", run, [None, None], 3, 3)
        assert set(told) == {("outer", 3)}
        report("after", 1, 1)
    assert told[-1] == ("after", 1)
    assert seen == [1, 1, 1]
    assert free_threads() == cores()


def test_work_is_shared_among_the_cores_that_the_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {1, 4, 5}, raising=False)
    assert cores() == free_threads() == 3
    monkeypatch.delattr("os.sched_getaffinity")
    assert cores() == free_threads() == os.cpu_count()


def test_what_a_thread_raises_is_raised_here() -> None:
    def run(rows: Iterable[int], memory: None) -> None:
        for row in rows:
            raise ValueError(f"row {row}")

    with pytest.raises(ValueError, match="row"):
        in_parallel("work", run, [None, None], 4, 4)


def test_a_listener_that_raises_stops_every_thread_after_its_row() -> None:
    """The rows wait for the stop, so that there is always one under way when it comes."""
    stopped, ended = Event(), Event()
    begun: list[int] = []

    def run(rows: Iterable[int], memory: None) -> None:
        for row in rows:
            begun.append(row)
            stopped.wait()
        ended.set()

    def listener(stage: str, done: int, total: int) -> None:
        if begun:
            raise Stopped

    with pytest.raises(Stopped), listening(listener):
        in_parallel("work", run, [None], 1000, 1000)
    stopped.set()
    assert ended.wait(60)
    assert begun == [0]


def test_a_call_that_may_be_left_returns_and_raises_as_any_other() -> None:
    assert left_if_stopped(divmod, 7, 3) == (2, 1)
    with pytest.raises(ZeroDivisionError):
        left_if_stopped(divmod, 7, 0)
    assert left_if_stopped(current_thread).daemon


def test_what_is_begun_is_waited_for_by_nobody_and_raises_nowhere() -> None:
    go_on, ended = Event(), Event()
    seen: list[int] = []

    def work() -> None:
        go_on.wait(60)
        report("begun", 0, 1)
        seen.append(free_threads())
        ended.set()
        raise ValueError("nobody hears of it")

    with listening(lambda stage, done, total: seen.append(-1)):
        begin(work)
        assert not seen
        go_on.set()
        assert ended.wait(60)
    assert seen == [1]
