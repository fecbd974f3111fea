"""The bounded memory of what may be asked for again."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from holdfast.base.memory import Memory, Same


def test_a_content_is_made_once_and_the_longest_unused_goes_first() -> None:
    memory, made = Memory(3), []

    def ask(key: str, cost: int = 1) -> str:
        return memory.recalled(key, cost, lambda: made.append(key) or key.upper())

    assert [ask(key) for key in "abcaba"] == list("ABCABA")
    assert made == ["a", "b", "c"]
    ask("d")  # c was not used for longest
    assert [ask(key) for key in "abd"] == list("ABD")
    assert made == ["a", "b", "c", "d"]
    ask("c")
    assert made[-1] == "c"
    ask("large", 100)  # alone larger than the memory: it stays until something else is asked for
    assert len(memory) == 1
    ask("large", 100)
    assert made.count("large") == 1


def test_what_raises_is_not_kept_and_what_is_not_valid_is_made_anew() -> None:
    memory = Memory(10)
    with pytest.raises(ZeroDivisionError):
        memory.recalled("k", 1, lambda: 1 / 0)
    assert len(memory) == 0
    assert memory.recalled("k", 1, lambda: 1) == 1
    assert memory.recalled("k", 1, lambda: 2, valid=lambda content: content > 0) == 1
    assert memory.recalled("k", 1, lambda: 3, valid=lambda content: content > 1) == 3
    memory.forget("k")
    assert memory.recalled("k", 1, lambda: 4) == 4


def test_threads_wait_for_the_one_that_makes_a_content() -> None:
    memory, made, ready = Memory(10), [], threading.Barrier(4)

    def ask(_: int) -> object:
        ready.wait()
        return memory.recalled("k", 1, lambda: made.append(1) or object())

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(ask, range(4)))
    assert len(made) == 1
    assert len({id(one) for one in found}) == 1


def test_keys_of_objects_compare_by_identity() -> None:
    one, other = [1], [1]
    assert Same(one) == Same(one)
    assert Same(one) != Same(other)
    assert hash(Same(one)) == hash(Same(one))
