"""Warming up leaves nothing to be compiled when it is first used."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import holdfast as hf
from holdfast.applications import warmup
from holdfast.applications.placement import place_all, plan
from holdfast.applications.placement.place_search import Clock
from holdfast.base import machine_code

CODE = """
from holdfast.applications.warmup import compile_all
from holdfast.base.machine_code import ready
from holdfast.base.progress import listening
told = []
with listening(lambda stage, done, total: told.append((done, total))):
    count = compile_all()
print(told[-1][0] == told[-1][1], count, *ready())
"""


@pytest.mark.slow
def test_every_function_has_machine_code_afterwards(tmp_path: Path) -> None:
    """With an empty folder: what is loaded from a full one brings its short functions along, unseen."""
    known = dict(os.environ, HOLDFAST_CACHE_DIR=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", CODE], env=known, capture_output=True, text=True, check=True)
    finished, count, compiled, known_functions = done.stdout.split()
    assert finished == "True"
    assert int(count) > 50
    assert compiled == known_functions == count
    assert any(tmp_path.iterdir())


def test_what_is_compiled_is_remembered_for_this_version_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By ``holdfast warmup``, a batch or a plan, whichever comes first; a part of it is not all."""
    asked: list[str] = []

    def compiled(group: str, processes: int) -> int:
        asked.append(group)
        return len(asked)

    monkeypatch.setenv("HOLDFAST_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(warmup, "_compiled", compiled)
    monkeypatch.setattr(warmup, "shipped_folder", lambda: None)
    (tmp_path / "compiled-for-batches").touch()  # what release candidates wrote, whatever their version
    (tmp_path / "compiled-0123456789abcdef0123").mkdir()
    (tmp_path / "compiled-0123456789abcdef0123" / "all-compiled").touch()
    warmup.compile_once()
    warmup.compile_once()
    assert asked == ["all", "all"], "the folder of this version was not there, so nothing could be kept"
    machine_code.version_folder().mkdir()
    asked.clear()
    warmup.compile_all("table")
    assert not warmup.all_compiled()
    warmup.compile_all("all", 2)
    assert warmup.all_compiled()
    warmup.compile_once()
    assert asked == ["table", "all"]


@pytest.mark.parametrize(("search", "told"), [(None, True), ({"seconds": 5}, True), ({"solves": 20}, False)])
def test_the_seconds_of_a_plan_begin_when_all_is_compiled(
    search: dict[str, int] | None, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []
    started = Clock.started
    monkeypatch.setattr(Clock, "started", lambda seconds: (done.append("clock"), started(seconds))[1])
    for module in (plan, place_all):
        monkeypatch.setattr(module, "compile_once", lambda: done.append("compiled"))
    how = None if search is None else hf.Search(**search)
    cup = hf.Body("cup", hf.Box((0.05, 0.05, 0.05)), mass=0.2)
    for ask in (lambda: hf.plan_placement(hf.shipped_scene("cube"), cup, search=how, engine="graph"),
                lambda: hf.place_all(hf.shipped_scene("cube"), [cup], search=how, engine="graph")):  # fmt: skip
        done.clear()
        ask()
        assert done[:2] == (["compiled", "clock"] if told else ["clock", "clock"])
        assert done.count("compiled") == told
