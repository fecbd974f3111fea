"""What fields may hold: annotations and shapes against what a file may bring."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import pytest

from holdfast.base.archive import first_misfit, fits
from holdfast.base.arrays import Float, Int, Objects
from holdfast.base.public import Record, column
from holdfast.base.values import Table


class Colour(Enum):
    RED = 1


class Named(Protocol):
    name: str

    def asked(self) -> None: ...


@dataclass
class Asked:
    name: str = "x"

    def asked(self) -> None: ...


@pytest.mark.parametrize(
    ("wanted", "good", "bad"),
    [
        (float, [0.0, 3, np.inf, -1e100, np.float64(1)], [True, "1", None, np.nan, 2e100, 10**400, [1.0]]),
        (int, [0, -5, 10**30], [1.0, True, "1", None]),
        (bool, [True, False], [0, 1, None]),
        (str, ["", "x"], [b"x", 1, None]),
        (float | None, [None, 1.0], ["", False]),
        (tuple[str, ...], [(), ("a", "b")], [["a"], ("a", 1), "ab"]),
        (tuple[str, float], [("a", 1.0)], [("a",), (1.0, "a"), ("a", 1.0, 2.0)]),
        (Literal["a", "b"], ["a"], ["c", 1, None, ["a"]]),
        (Mapping[tuple[str, str], float], [{}, {("a", "b"): 1}], [{"a": 1.0}, {("a", "b"): "x"}, []]),
        (Table[str, float], [Table({"a": 1.0})], [{"a": 1.0}, Table({1: 1.0}), None]),
        (Colour, [Colour.RED], [1, "RED"]),
        (Path | None, [Path("x"), None], ["x"]),
        (Named, [Asked()], [1, "x", None, Colour]),
        (Float, [np.zeros(3), np.full((2, 2), np.inf)], [np.array([np.nan]), np.zeros(3, int), [0.0], 0.0]),
        (Int, [np.zeros(3, dtype=np.int64)], [np.zeros(3), np.zeros(3, dtype=np.int8)]),
        (Objects, [np.array([None, 1], dtype=object)], [np.zeros(2)]),
        (Any, [None, print], []),
    ],
    ids=str,
)
def test_annotations_say_what_fits(wanted: Any, good: list[Any], bad: list[Any]) -> None:
    assert all(fits(item, wanted) for item in good)
    assert not any(fits(item, wanted) for item in bad)


class Cloud(Record):
    points: Float = column("n 3")
    weights: Float = column("n")
    name: str = column("2")


GOOD = {"points": np.zeros((4, 3)), "weights": np.zeros(4), "name": "ab"}


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({}, ""),
        ({"points": np.zeros((0, 3)), "weights": np.zeros(0)}, ""),
        ({"weights": np.zeros(5)}, "Cloud.weights has shape (5,), not (n)"),
        ({"points": np.zeros((4, 2))}, "Cloud.points has shape (4, 2), not (n, 3)"),
        ({"points": np.zeros(12)}, "Cloud.points has shape (12,), not (n, 3)"),
        ({"name": "abc"}, "Cloud.name has shape (3,), not (2)"),
        ({"name": 1}, "Cloud.name is a int, which it cannot be"),
        ({"weights": [0.0] * 4}, "Cloud.weights is a list, which it cannot be"),
    ],
)
def test_shapes_agree_with_each_other(wrong: dict[str, Any], told: str) -> None:
    assert first_misfit(Cloud, GOOD | wrong) == told


def test_items_of_another_kind_are_named() -> None:
    class Names(Record):
        names: Objects = column("n", of=str | None)

    for items, wrong in ((["a", None], ""), (["a", 1], "Names.names holds what it cannot hold")):
        array = np.empty(2, dtype=object)
        array[:] = items
        assert first_misfit(Names, {"names": array}) == wrong
