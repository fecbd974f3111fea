"""``python -m bench``: suites are listed and measured, and saved results are found from anywhere."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import holdfast as hf
from bench import __main__ as command
from bench import checkout
from bench.registry import SUITES
from bench.suite import Suite

ROOT = Path(__file__).parents[2]


def called(*arguments: object) -> object:
    """The exit code of the command."""
    with pytest.raises(SystemExit) as ended:
        command.app([*map(str, arguments)])
    return ended.value.code


@pytest.fixture(autouse=True)
def away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Another folder than the checkout, in which nothing may be left."""
    folder = tmp_path / "away"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """A suite that measures nothing."""
    suite = Suite("try", "Tried.", lambda: {"a": lambda: [{"case": "a", "push s": 0.5}]})
    monkeypatch.setattr(command, "suite", lambda name: suite)


def test_from_a_checkout_it_lists_all_suites() -> None:
    code = [sys.executable, "-m", "bench", "list", "--json"]
    done = subprocess.run(code, cwd=ROOT, capture_output=True, text=True, check=True)
    assert list(json.loads(done.stdout)) == list(SUITES)


def test_an_error_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["bench", "run", "mapps"])
    with pytest.raises(SystemExit) as ended:
        command.main()
    assert ended.value.code == 2
    assert "did you mean 'maps'" in capsys.readouterr().err


@pytest.mark.usefixtures("tried")
def test_results_are_saved_and_compared_with(tmp_path: Path, away: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert called("run", "try", "--save", "--results", tmp_path) == 0
    assert json.loads((tmp_path / "try.json").read_text())["rows"] == [{"case": "a", "push s": 0.5}]
    assert (tmp_path / "try.md").exists()
    assert called("run", "try", "--compare", "--results", away) == 0
    assert "nothing saved in" in capsys.readouterr().out
    assert list(away.iterdir()) == []


@pytest.mark.usefixtures("tried")
def test_measuring_alone_saves_nothing(away: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert called("run", "try", "--json") == 0
    assert json.loads(capsys.readouterr().out) == {"try": [{"case": "a", "push s": 0.5}]}
    assert list(away.iterdir()) == []


def test_what_is_measured_beside_must_be_a_checkout(tmp_path: Path) -> None:
    with pytest.raises(hf.HoldfastError, match="is no checkout of holdfast"), checkout.beside(tmp_path):
        pass


def test_saved_results_and_published_scenes_are_those_of_the_checkout() -> None:
    assert ROOT.resolve() / "bench" / "results" == checkout.RESULTS
    assert (checkout.RESULTS / "table1.json").is_file()
    assert ROOT.resolve().parent / "shared" / "cases" == checkout.CASES
