"""Answers that may be undecided are neither true nor false: ``bool`` of them raises, with what to ask instead."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from typing import Any

import numpy as np
import pytest

import holdfast as hf
from holdfast.applications.disassembly.removal import Answer
from holdfast.applications.pushing.safe_pushes import Effect
from holdfast.scene.shipped.blocks import at


def resting(z: float = 0.1) -> hf.Scene:
    """A cube whose middle is at this height, over a plate whose top is at 0.05 m."""
    plate = hf.Body("plate", hf.Box((1, 1, 0.1)), fixed=True)
    return hf.Scene([plate, hf.Body("cube", hf.Box((0.1, 0.1, 0.1)), mass=1.0, pose=at(0, 0, z))], hf.Friction(0.5))


def push() -> hf.answers.Robustness:
    """A push on the cube from above."""
    return hf.robustness(resting(), "cube", (0, 0, 0.15), (0, 0, -1))


def carried(acceleration: float) -> hf.answers.Carried:
    """The cube on a plate that is accelerated and then left alone."""
    motion = hf.Profile([0.0, 1.0], [(acceleration, 0, 0), (0, 0, 0)])
    return hf.carry(resting(), motion)


# what is asked, the attribute that its error names, and that attribute's value
ASKED: dict[str, tuple[Callable[[], Any], str, bool]] = {
    "a cube that stands": (lambda: hf.stability(resting()), "stable", True),
    "a cube in mid-air": (lambda: hf.stability(resting(0.5)), "stable", False),
    "the verdict beside a push": (lambda: push().verdict, "stable", True),
    "a removal that is safe": (lambda: hf.can_remove(resting(), "cube"), "safe", True),
    "a removal that is not": (lambda: hf.can_remove(hf.shipped_scene("arch"), "v3"), "safe", False),
    "a motion under which it holds": (lambda: carried(1.0), "holds", True),
    "a motion under which it slides": (lambda: carried(9.0), "holds", False),
    "a settled scene": (lambda: hf.settle(resting(0.105)), "stable", True),
    "a scene that falls": (lambda: hf.settle(resting(0.5)), "stable", False),
    "an order of removals": (lambda: hf.disassembly_order(resting()), "reached", True),
    "an order of building": (lambda: hf.build_order(resting()), "reached", True),
}  # fmt: skip


@pytest.mark.parametrize("case", ASKED)
def test_bool_names_the_attribute_to_ask(case: str) -> None:
    ask, name, value = ASKED[case]
    answer = ask()
    with pytest.raises(hf.HoldfastError, match=rf"bool\(\) of {type(answer).__name__}: .*undecided.*ask \.{name}"):
        bool(answer)
    assert getattr(answer, name) is value


def test_a_place_refuses_bool() -> None:
    found = hf.plan_placement(
        resting(), hf.Body("cup", hf.Cylinder(0.03, 0.1), mass=0.2), search=hf.Search(seconds=20, seed=1)
    )
    with pytest.raises(hf.HoldfastError, match=r"ask \.stable"):
        bool(found)
    assert found.stable is (found.status is hf.Status.STABLE)
    several = hf.place_all(resting(), [hf.Body("cup", hf.Cylinder(0.03, 0.1), mass=0.2)], search=hf.Search(seed=1))
    with pytest.raises(hf.HoldfastError, match=r"ask \.stable"):
        bool(several)
    assert several.stable is (several.status is hf.Status.STABLE)


def test_what_is_not_decided_is_not_stable() -> None:
    unknown = replace(hf.stability(resting()).verdict, status=hf.Status.UNDECIDED)
    assert not unknown.stable
    told = push().undecided
    with pytest.raises(hf.HoldfastError, match=r"ask \.count"):
        bool(told)
    assert told.count == 0


@pytest.mark.parametrize("word", [*hf.Status, *Answer, *Effect], ids=repr)
def test_a_word_of_an_answer_refuses_bool_and_stays_a_text(word: Enum) -> None:
    for ask in (bool, lambda each: not each, lambda each: all([each]), lambda each: any([each])):
        with pytest.raises(hf.HoldfastError, match="compare it"):
            ask(word)
    assert word == word.value
    assert f"{word}" == word.value
    assert json.dumps(word) == f'"{word.value}"'
    assert pickle.loads(pickle.dumps(word)) is word
    assert copy.deepcopy(word) is word
    assert (np.array([word, word], dtype=object) == word).all()
