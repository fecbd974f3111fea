"""A keeper tells every way in which an item may end, and goes on after each."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from holdfast.base.errors import HoldfastError
from holdfast.batches.keeper import Keeper, Limits
from holdfast.batches.words import CRASH, DONE, MEMORY, TIME

HERE = (str(Path(__file__).parent),)
FUNCTION = "batch_drill:drilled"


@pytest.fixture(scope="module")
def keeper() -> Iterator[Keeper]:
    with Keeper(FUNCTION, limits=Limits(60.0, 500.0), folders=HERE) as made:
        yield made


@pytest.mark.parametrize(
    ("word", "outcome", "told"),
    [
        ("nothing", DONE, ""),
        ("print", DONE, ""),
        ("eat", MEMORY, "MemoryError"),
        ("raise", CRASH, "ValueError: a defect"),
        ("exit", CRASH, "exit code 7"),
        ("segfault", CRASH, "signal 11"),
    ],
)
def test_every_ending_is_told_and_survived(keeper: Keeper, word: str, outcome: str, told: str) -> None:
    reply = keeper.ask((word, 4))
    assert reply.outcome == outcome
    assert told in reply.told
    assert reply.parts == (4,)
    assert reply.value == (4 if outcome == DONE else None)


def test_a_worker_that_raises_lives_on(keeper: Keeper) -> None:
    keeper.ask(("nothing", 0))
    before = keeper.started
    keeper.ask(("raise", 0))
    keeper.ask(("eat", 0))
    keeper.ask(("nothing", 0))
    assert keeper.started == before


@pytest.mark.parametrize("word", ["hang", "spin"])
def test_what_does_not_end_is_stopped(word: str) -> None:
    with Keeper(FUNCTION, limits=Limits(1.0), folders=HERE) as keeper:
        reply = keeper.ask((word, 3))
        assert (reply.outcome, reply.parts) == (TIME, (3,))
        assert "no answer within 1 s" in reply.told
        assert keeper.process is None
        assert keeper.ask(("nothing", 5)).value == 5


def test_an_item_whose_worker_is_killed_from_outside_is_given_again() -> None:
    with Keeper(FUNCTION, limits=Limits(60.0), folders=HERE) as keeper:
        keeper.ask(("nothing", 0))
        keeper.give(("hang", 1))
        time.sleep(0.1)
        assert keeper.process is not None
        os.kill(keeper.process.pid, signal.SIGKILL)
        keeper.process.wait()
        assert keeper.take() is None
        assert keeper.started == 2
    with Keeper(FUNCTION, limits=Limits(60.0), folders=HERE) as keeper:
        reply = keeper.ask(("killed", 1))
        assert reply.outcome == CRASH
        assert "killed 3 times" in reply.told


def test_a_worker_that_died_while_idle_is_replaced(keeper: Keeper) -> None:
    keeper.ask(("nothing", 0))
    assert keeper.process is not None
    keeper.process.kill()
    keeper.process.wait()
    assert keeper.ask(("nothing", 6)).value == 6


def test_a_worker_is_renewed() -> None:
    with Keeper(FUNCTION, folders=HERE, renewed=2) as keeper:
        assert [keeper.ask(("nothing", k)).value for k in range(5)] == list(range(5))
        assert keeper.started == 3


def test_a_worker_that_cannot_start_is_told() -> None:
    with Keeper("batch_drill_not_there:drilled", folders=HERE) as keeper, pytest.raises(HoldfastError) as told:
        keeper.ask(("nothing", 0))
    assert "batch_drill_not_there" in str(told.value)
