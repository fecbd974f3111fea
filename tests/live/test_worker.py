"""The thread behind the window: the newest first, long work gives way, and errors are told."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from holdfast.base.errors import HoldfastError
from holdfast.base.progress import report
from holdfast.live.window_thread import Worker


@pytest.fixture
def told() -> list[str]:
    return []


@pytest.fixture
def failed() -> list[str]:
    return []


@pytest.fixture
def worker(told: list[str], failed: list[str]) -> Iterator[Worker]:
    one = Worker(told.append, failed.append)
    yield one
    one.close()


def test_of_waiting_jobs_with_one_name_only_the_newest_is_done(worker: Worker) -> None:
    done: list[int] = []
    held = threading.Event()
    worker.ask("first", lambda: held.wait(10) and None)
    for number in range(5):
        worker.ask("aim", lambda number=number: done.append(number))  # type: ignore[misc]
    held.set()
    assert worker.rest()
    assert done == [4]


def test_a_patient_job_gives_way_and_is_done_later(worker: Worker) -> None:
    order: list[str] = []
    begun, going = threading.Event(), threading.Event()

    def long() -> None:
        order.append("begins")
        begun.set()
        going.wait(10)
        report("map", 1, 2)
        order.append("ends")

    worker.ask("map", long, patient=True)
    assert begun.wait(10)
    worker.ask("push", lambda: order.append("push"))
    going.set()
    assert worker.rest()
    assert order == ["begins", "push", "begins", "ends"]


def test_an_error_of_holdfast_is_told_and_the_next_job_is_done(worker: Worker, failed: list[str]) -> None:
    def wrong() -> None:
        raise HoldfastError("mass: is 0; needs > 0")

    done: list[int] = []
    worker.ask("edit", wrong)
    worker.ask("push", lambda: done.append(1))
    assert worker.rest()
    assert failed == ["edit: mass: is 0; needs > 0"]
    assert done == [1]


def test_progress_is_told(worker: Worker, told: list[str]) -> None:
    worker.ask("map", lambda: report("points", 3, 9))
    assert worker.rest()
    assert told == ["points: 3 of 9", ""]


def test_closing_stops_a_job_at_its_next_report(told: list[str]) -> None:
    worker = Worker(told.append, told.append)
    begun, going = threading.Event(), threading.Event()
    ended: list[int] = []

    def long() -> None:
        begun.set()
        going.wait(10)
        report("map", 1, 2)
        ended.append(1)

    worker.ask("map", long)
    assert begun.wait(10)
    threading.Timer(0.05, going.set).start()
    worker.close()
    assert ended == []
