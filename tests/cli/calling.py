"""The command line as a user calls it, within this process."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from holdfast.cli.main import run


class Answer(NamedTuple):
    """The exit code of a call, and what it printed."""

    code: int
    out: str
    err: str


Call = Callable[..., Answer]


def called(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: object) -> Answer:
    """The exit code of `holdfast` with these arguments, and what it printed to stdout and stderr."""
    monkeypatch.setattr(sys, "argv", ["holdfast", *map(str, arguments)])
    with pytest.raises(SystemExit) as stopped:
        run()
    out, err = capsys.readouterr()
    code = stopped.value.code
    return Answer(code if isinstance(code, int) else 0 if code is None else 1, out, err)


def column(text: str, name: str) -> list[Any]:
    """The entries with this name of all rows of an answer in JSON."""
    return [row[name] for row in json.loads(text)["rows"]]


def command(name: str) -> Callable[..., Any]:
    """A fixture that calls the command ``name`` with the arguments that it is given, in an empty folder."""

    @pytest.fixture
    def caller(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Any:
        monkeypatch.chdir(tmp_path)
        return lambda *arguments: called(monkeypatch, capsys, name, *arguments)

    return caller
