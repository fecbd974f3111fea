"""Long calls of the compiled core: Ctrl-C ends them, what does not fit is refused, and outcomes have one number."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from _thread import interrupt_main
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import IntEnum
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from elastic_blocks import block, push
from numpy.typing import NDArray
from path_events import Event

import holdfast as hf
from holdfast.elastic.system import BRIEF, QUICK, PathOutcome, PathResult, RestOutcome, System
from holdfast.engines.compliant.elastic_model import Springs
from holdfast.engines.compliant.grid import Grid
from holdfast.native import core
from holdfast.scene.shipped.blocks import wall

Array = NDArray[np.float64]

LATEST = 2.0  # [s] up to which Ctrl-C is answered, where 0.2 are promised on a machine that is not busy


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [(Event, core.EVENTS), (PathOutcome, core.PATH_OUTCOMES), (RestOutcome, core.REST_OUTCOMES)],
)
def test_outcomes_have_the_same_numbers_in_python_and_in_the_core(ours: type[IntEnum], theirs: dict[str, int]) -> None:
    assert {one.name: one.value for one in ours} == theirs


@cache
def bricks(layers: int = 20) -> tuple[System, Array, Array]:
    """50 bricks in each of 20 layers, how they rest, and a push along the wall on the last of them."""
    assembly = hf.assemble(wall(50, layers, 0.25, "wall"))
    grid = Grid.of(assembly, assembly.weight_wrench(), Springs(7))
    load = np.zeros(6 * len(assembly.movable))
    load[-5] = 1.0
    return grid.system, grid.settled.q, load


def follow(layers: int = 20) -> PathResult:
    system, rest, load = bricks(layers)
    found, work = PathResult.lost(1, len(load)), core.Work(system.model, system.fronts)
    stepper = core.Stepper(system.stuck, BRIEF)
    core.follow_each(
        system.model, work, stepper, rest, load[None], found, np.arange(1), np.full(1, np.inf), system.fronts
    )
    return found


def search(name: str) -> None:
    """For a state of rest under a push that no brick holds: it is not known to drift for long."""
    system, rest, load = bricks()
    pushed = system.model._replace(wrench=system.model.wrench + 1e3 * load)
    work, q = core.Work(pushed, system.fronts), system.under(pushed.wrench).stuck if name == "lessen_drag" else rest
    getattr(core, name)(pushed, work, 1.0, q.copy(), np.zeros(len(q)), 1e-11, 6000, system.fronts)


def seek_nearby() -> None:
    system, rest, load = bricks()
    rows, found = np.zeros(10_000, dtype=np.int64), np.zeros(1)
    one, work = load[None], core.Work(system.model, system.fronts)
    core.loads_nearby(system.model, work, one, np.ones(1), rest[None], one, found, rows, system.fronts)


@contextmanager
def interrupted(after: float) -> Iterator[list[float]]:
    """Press Ctrl-C some time [s] from now; gives when that was."""
    pressed: list[float] = []

    def press() -> None:
        pressed.append(time.perf_counter())
        interrupt_main()

    timer = threading.Timer(after, press)
    timer.start()
    try:
        yield pressed
    finally:
        timer.cancel()
        timer.join()


@pytest.mark.parametrize(
    "call", [follow, lambda: search("lessen_drag"), lambda: search("move"), seek_nearby],
    ids=["follow_each", "lessen_drag", "move", "loads_nearby"],
)  # fmt: skip
def test_a_long_call_answers_ctrl_c(call: Callable[[], object]) -> None:
    bricks()
    with interrupted(0.1) as pressed:
        with pytest.raises(KeyboardInterrupt):
            call()
        waited = time.perf_counter() - pressed[0]
    assert waited < LATEST


IN_THREADS = """
import threading
from _thread import interrupt_main
import numpy as np
from holdfast.elastic import system
from test_elastic_core import bricks
system.free_threads = lambda: 2
rests, q, load = bricks(4)
loads = np.tile(load, (100, 1))
rests.paths(q, loads[:2])
threading.Timer({after}, interrupt_main).start()
rests.paths(q, loads)
"""


@pytest.mark.parametrize("after", [0.2, 0.25])
def test_a_program_that_ends_with_threads_at_work_ends_as_python_does(after: float) -> None:
    """They ask for Python's global lock while Python ends, or after it has: with an abort, if nothing stops them."""
    paths = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    ended = subprocess.run(
        [sys.executable, "-c", IN_THREADS.format(after=after)],
        env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.stderr.splitlines()[-1] == "KeyboardInterrupt"
    assert ended.returncode == (-signal.SIGINT if os.name == "posix" else 0xC000013A)


def test_a_handler_that_lets_a_call_go_on_changes_nothing() -> None:
    expected, heard = follow(8), []
    before = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    try:
        with interrupted(0.02):
            found = follow(8)
    finally:
        signal.signal(signal.SIGINT, before)
    assert heard == [signal.SIGINT]
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("start", np.zeros(7)),
        ("loads", np.zeros((2, 5))),
        ("rows", np.array([2])),
        ("rows", np.array([-1])),
        ("most", np.zeros(1)),
        ("into", PathResult.lost(1, 6)),
        ("into", PathResult.lost(2, 12)),
        ("stepper", core.Stepper(np.zeros(12), QUICK)),
        ("work", core.Work(block(0.5), System.by_fronts(block(0.5)).fronts)),
        ("fronts", System.by_fronts(block(0.5)).fronts),
    ],
)
def test_what_does_not_fit_a_model_is_refused(name: str, value: object) -> None:
    model = block(0.5)
    known = {
        "model": model, "work": core.Work(model, None), "stepper": core.Stepper(np.zeros(6), QUICK),
        "start": np.zeros(6), "loads": np.stack([push((1.0, 0.0, 0.0))] * 2), "into": PathResult.lost(2, 6),
        "rows": np.arange(2), "most": np.full(2, np.inf), "fronts": None,
    }  # fmt: skip
    core.follow_each(**known)
    with pytest.raises(ValueError, match="expected"):
        core.follow_each(**known | {name: value})


def test_a_result_that_is_sealed_is_not_written_to() -> None:
    model = block(0.5)
    with pytest.raises(TypeError):
        core.follow_each(
            model, core.Work(model, None), core.Stepper(np.zeros(6), QUICK), np.zeros(6), np.ones((1, 6)),
            PathResult.lost(1, 6).sealed(), np.arange(1), np.ones(1), None,
        )  # fmt: skip
