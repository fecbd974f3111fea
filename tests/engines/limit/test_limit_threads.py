"""One state asked by four threads at a time answers as it answers one, to the last digit."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import get_ident
from time import sleep
from typing import TypeVar

import numpy as np
import pytest
from engine_scenes import shipped
from limit_scenes import columns

from holdfast.base.arrays import Float
from holdfast.engines.contract import Within
from holdfast.engines.limit.proof import LoadLimit, LoadProgram, SolvedLoad
from holdfast.engines.limit_engine import Limit

T = TypeVar("T")
THREADS = 4


def at_once(ask: Callable[[int], T], count: int) -> list[T]:
    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(ask, range(count)))


def digits(limit: LoadLimit) -> tuple[object, ...]:
    arrays = (None if a is None else a.tobytes() for a in (limit.twists, limit.ray))
    return (limit.factor, limit.lower, limit.upper, limit.status, *arrays)


def test_an_answer_depends_on_no_earlier_load() -> None:
    """What threads rely on: which solver answers, and what it was asked before, is a matter of chance."""
    assembly = shipped("arch")
    W = columns(assembly, 12, 8) * 10.0 ** np.random.default_rng(1).uniform(-3, 3, 12)
    state = Limit().prepare(assembly)
    first = [digits(state.solve(w)) for w in W.T]
    assert [digits(state.solve(w)) for w in W.T[::-1]] == first[::-1]


@pytest.mark.parametrize(
    ("name", "count", "shared"), [("arch", 1, False), ("arch", 7, False), ("arch", 40, True), ("table", 40, False)]
)
def test_loads_of_one_call_are_shared_among_threads(
    name: str, count: int, shared: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of many loads, and where a program is large enough for threads to be worth their while."""
    assembly = shipped(name)
    W = columns(assembly, count, 9)
    found, maximise = {}, LoadProgram.maximise
    for threads in (1, THREADS):
        used: set[int] = set()

        def noted(self: LoadProgram, load: Float, around: float | None = None, used: set[int] = used) -> SolvedLoad:
            used.add(get_ident())
            sleep(0.01)  # long enough for another thread to take the next load
            return maximise(self, load, around)

        with monkeypatch.context() as patched:
            patched.setattr("holdfast.engines.limit.proof.free_threads", lambda threads=threads: threads)
            patched.setattr(LoadProgram, "maximise", noted)
            found[threads] = Limit().prepare(assembly).load_factor(W)
        assert (len(used) > 1) == (threads > 1 and shared)
    for name in ("force", "lower", "upper"):
        np.testing.assert_array_equal(getattr(found[THREADS], name), getattr(found[1], name))


def test_bounds_within_a_gap_hold_from_four_threads() -> None:
    """Later calls profit from the cuts of earlier ones, so bounds may be tighter, but each contains the answer."""
    assembly = shipped("table")
    slab = 6 * assembly.index["slab"]
    rng = np.random.default_rng(11)
    W = np.zeros((6 * len(assembly.movable), 60))
    W[slab] = 1.0
    W[slab + 3 : slab + 6] = rng.uniform(-0.1, 0.1, (3, 60)) * np.array([[0.0], [1.0], [1.0]])
    exact = Limit().prepare(assembly).load_factor(W).force
    state = Limit().prepare(assembly)
    for found in at_once(lambda _: state.load_factor(W, Within(0.05)), THREADS):
        assert (found.lower <= exact * (1 + 1e-6)).all()
        assert (found.upper >= exact * (1 - 1e-6)).all()
        assert (found.lower >= 0.95 * found.upper * (1 - 1e-9)).all()
