"""The keeper tells every way in which a trial may end, and goes on after each."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from fuzz.keeper import Keeper
from fuzz.outcome import Ending


@pytest.fixture(scope="module")
def keeper() -> Iterator[Keeper]:
    with Keeper("fuzz.drill:tried", seconds=120.0, megabytes=200) as made:
        yield made


@pytest.mark.parametrize(
    ("item", "ending", "sign"),
    [
        ({"do": "nothing"}, Ending.OK, ""),
        ({"do": "tell"}, Ending.TOLD, "SceneError"),
        ({"do": "tell badly"}, Ending.LEAK, "control character outside"),
        ({"do": "raise"}, Ending.CRASH, "ValueError outside"),
        ({"do": "die"}, Ending.CRASH, "process ended with 7"),
        ({"do": "take", "bytes": 120e6}, Ending.MEMORY, "took much"),
        ({"do": "take", "bytes": 400e6}, Ending.MEMORY, "outside"),
        ({"do": "hide", "bytes": 400e6}, Ending.MEMORY, "outside"),
        ({"do": "take", "bytes": 1e6}, Ending.OK, ""),
    ],
)
def test_every_ending_is_told_and_survived(keeper: Keeper, item: dict, ending: Ending, sign: str) -> None:
    found = keeper.tried(item)
    assert (found.ending, found.sign) == (ending, sign), found.detail


def test_what_does_not_end_is_stopped_and_its_place_told() -> None:
    with Keeper("fuzz.drill:tried", seconds=1.0, megabytes=200) as keeper:
        found = keeper.tried({"do": "loop"})
        assert (found.ending, found.sign) == (Ending.HANG, "outside")
        assert "drill.py" in found.detail
        assert keeper.process is None


def test_a_worker_lasts_until_it_dies(keeper: Keeper) -> None:
    keeper.tried({"do": "nothing"})
    before = keeper.started
    keeper.tried({"do": "raise"})
    keeper.tried({"do": "die"})
    assert keeper.started == before
    keeper.tried({"do": "nothing"})
    assert keeper.started == before + 1
