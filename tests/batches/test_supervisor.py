"""A supervisor tells every way in which an item may end, and goes on after each."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import holdfast
from holdfast.base.borders.supervisor import Limits, Supervisor, innermost
from holdfast.base.borders.worker import CRASH, DONE, MEMORY, TIME
from holdfast.base.errors import HoldfastError

HERE = (str(Path(__file__).parent),)
FUNCTION = "batch_drill:drilled"


@pytest.fixture(scope="module")
def supervisor() -> Iterator[Supervisor]:
    with Supervisor(FUNCTION, limits=Limits(60.0, 500.0), folders=HERE) as made:
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
def test_every_ending_is_told_and_survived(supervisor: Supervisor, word: str, outcome: str, told: str) -> None:
    reply = supervisor.ask((word, 4))
    assert reply.outcome == outcome
    assert told in reply.problem
    assert reply.parts == (4,)
    assert reply.value == (4 if outcome == DONE else None)


def test_a_worker_that_raises_lives_on(supervisor: Supervisor) -> None:
    supervisor.ask(("nothing", 0))
    before = supervisor.started
    supervisor.ask(("raise", 0))
    supervisor.ask(("eat", 0))
    supervisor.ask(("nothing", 0))
    assert supervisor.started == before


@pytest.mark.parametrize("word", ["hang", "spin"])
def test_what_does_not_end_is_stopped(word: str) -> None:
    with Supervisor(FUNCTION, limits=Limits(1.0), folders=HERE) as supervisor:
        reply = supervisor.ask((word, 3))
        assert (reply.outcome, reply.parts) == (TIME, (3,))
        assert "no answer within 1 s" in reply.problem
        assert supervisor.process is None
        assert supervisor.ask(("nothing", 5)).value == 5


def test_an_item_whose_worker_is_killed_from_outside_is_given_again() -> None:
    with Supervisor(FUNCTION, limits=Limits(60.0), folders=HERE) as supervisor:
        supervisor.ask(("nothing", 0))
        supervisor.give(("hang", 1))
        time.sleep(0.1)
        assert supervisor.process is not None
        os.kill(supervisor.process.pid, signal.SIGKILL)
        supervisor.process.wait()
        assert supervisor.take() is None
        assert supervisor.started == 2
    with Supervisor(FUNCTION, limits=Limits(60.0), folders=HERE) as supervisor:
        reply = supervisor.ask(("killed", 1))
        assert reply.outcome == CRASH
        assert "killed 3 times" in reply.problem


def test_a_worker_that_died_while_idle_is_replaced(supervisor: Supervisor) -> None:
    supervisor.ask(("nothing", 0))
    assert supervisor.process is not None
    supervisor.process.kill()
    supervisor.process.wait()
    assert supervisor.ask(("nothing", 6)).value == 6


def test_a_worker_is_renewed() -> None:
    with Supervisor(FUNCTION, folders=HERE, renewed=2) as supervisor:
        assert [supervisor.ask(("nothing", k)).value for k in range(5)] == list(range(5))
        assert supervisor.started == 3


def test_a_worker_that_cannot_start_is_told() -> None:
    with Supervisor("batch_drill_not_there:drilled", folders=HERE) as supervisor, pytest.raises(HoldfastError) as told:
        supervisor.ask(("nothing", 0))
    assert "batch_drill_not_there" in str(told.value)


def test_a_folder_called_holdfast_is_not_the_package() -> None:
    """A checkout often is called so; what runs in it, but not in the package, is somebody else's."""
    package = Path(holdfast.__file__).parent
    own = f'  File "{package}/engines/groups.py", line 3 in verdict'
    foreign = '  File "/home/ann/holdfast/scripts/drill.py", line 7 in drilled'
    assert innermost(f"{foreign}\n{own}") == "engines.groups:verdict"
    assert innermost(foreign) == ""
