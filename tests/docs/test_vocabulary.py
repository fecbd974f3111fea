"""One word, one meaning: names, units and types of public parameters, and the same words on the command line."""

from __future__ import annotations

import dataclasses
import re
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
import typer
import typer.main

import holdfast as hf
from holdfast.cli.assignments import help_texts
from holdfast.cli.main import COMMANDS

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

import vocabulary

VALUES = (hf.Where, hf.sets.Approach, hf.Search)


def test_public_calls_keep_to_the_vocabulary() -> None:
    assert vocabulary.faults() == []


def test_the_page_of_the_site_has_every_word() -> None:
    assert {*re.findall(r"^\| `(\w+)` \| \S", vocabulary.page(), re.MULTILINE)} == vocabulary.words().keys()


def options_of(name: str) -> list[Any]:
    """The parameters of a command."""
    module, _, function = COMMANDS[name][0].partition(":")
    alone = typer.Typer()
    alone.command(name)(getattr(import_module(f"holdfast.cli.{module}"), function))
    return list(typer.main.get_command(alone).params)


def told(gap: float, budget: float) -> None:
    """Ask with ``gap`` [mm]."""


def crowded(a: int, b: int, c: int, d: int, e: int, f: int, g: int, h: int, i: int) -> None:
    """Take too much."""


def counted(solves: float) -> None:
    """Take half a solve."""


@pytest.mark.parametrize(
    ("call", "fault"),
    [
        (told, "told: gap is in mm, but in m elsewhere"),
        (told, "told: budget is not in vocabulary.csv"),
        (crowded, "crowded takes 9 parameters, more than 8"),
        (counted, "counted: solves is a float, but a int elsewhere"),
    ],
)
def test_what_does_not_keep_to_it_is_found_out(monkeypatch: pytest.MonkeyPatch, call: Any, fault: str) -> None:
    known = list(vocabulary.calls())
    monkeypatch.setattr(vocabulary, "calls", lambda: iter([*known, (call.__name__, call)]))
    assert fault in vocabulary.faults()


def test_a_word_that_nobody_uses_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    more = vocabulary.words() | {"budget": vocabulary.Word("budget", "float", "s", "")}
    monkeypatch.setattr(vocabulary, "words", lambda: more)
    assert vocabulary.faults() == ["budget is in vocabulary.csv, but no public call takes it"]


def test_the_options_of_place_are_the_fields_of_its_values() -> None:
    options = {each.name: each for each in options_of("place")}
    for kind in VALUES:
        said = help_texts(kind)
        for field in dataclasses.fields(kind):
            assert options[field.name].help.startswith(said[field.name])
            assert options[field.name].opts[0] == "--" + field.name.replace("_", "-")


WORDS = {
    "map": {"accuracy", "spacing", "bodies", "gap", "angle_degrees"},
    "transport": {"bounds", "tilt_degrees", "bodies", "count"},
    "carry": {"bounds", "tilt_degrees", "pivot", "heading"},
    "build": {"solves", "pushes", "lift"},
    "disassemble": {"solves", "goal", "lift"},
    "settle": {"travel", "turn_degrees", "known", "upright", "pose_sigma", "gap"},
    "safe": {"radius", "travel", "spacing", "doubt"},
}


@pytest.mark.parametrize("name", WORDS)
def test_commands_have_the_words_of_python(name: str) -> None:
    there = {each.name for each in options_of(name)}
    assert WORDS[name] <= there
    assert WORDS[name] <= vocabulary.words().keys()
    assert not there & {"budget", "bound", "region", "tilt", "turn", "angle", "reach", "attempts"}
