"""Saved results are found from anywhere: in the checkout, or in a folder that is named."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

import holdfast as hf
from holdfast.cli import benchmark
from holdfast.cli.main import run
from holdfast.validation.benchmarks import reliability
from holdfast.validation.benchmarks.checkout import checkout, results_folder
from holdfast.validation.benchmarks.suite import Suite

ROOT = Path(__file__).parents[3]


def layout(folder: Path) -> Path:
    """An empty checkout, by the folder of its package."""
    (folder / "benchmarks" / "results").mkdir(parents=True)
    (folder / "pyproject.toml").touch()
    package = folder / "src" / "holdfast"
    package.mkdir(parents=True)
    return package


def test_the_results_of_this_checkout_are_found_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert checkout() == ROOT.resolve()
    assert results_folder(None) == ROOT.resolve() / "benchmarks" / "results"


def test_a_named_folder_goes_first(tmp_path: Path) -> None:
    assert results_folder(tmp_path, layout(tmp_path)) == tmp_path


def test_a_package_installed_beside_a_project_is_no_checkout(tmp_path: Path) -> None:
    layout(tmp_path)
    for package in (tmp_path / "site-packages" / "holdfast", tmp_path / ".venv" / "lib" / "site-packages" / "holdfast"):
        assert checkout(package) is None
        with pytest.raises(hf.HoldfastError, match=r"saved benchmark results: .* --results DIR"):
            results_folder(None, package)


def test_a_checkout_without_results_is_none(tmp_path: Path) -> None:
    package = layout(tmp_path)
    (tmp_path / "benchmarks" / "results").rmdir()
    assert checkout(package) is None


def test_settled_scenes_are_sought_beside_the_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cases = list(reliability.cases())
    monkeypatch.chdir(tmp_path)
    assert list(reliability.cases()) == cases


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """``holdfast benchmark try`` from another folder, in a checkout at ``home`` or with the package installed."""

    def call(home: Path | None, *options: object) -> tuple[object, str]:
        suite = Suite("try", "Tried.", lambda: {"a": lambda: [{"case": "a", "push s": 0.5}]})
        package = layout(home) if home else tmp_path / "site-packages" / "holdfast"
        monkeypatch.setattr(benchmark, "suite", lambda name: suite)
        monkeypatch.setattr(benchmark, "results_folder", lambda given: results_folder(given, package))
        away = tmp_path / "away"
        away.mkdir()
        monkeypatch.chdir(away)
        monkeypatch.setattr(sys, "argv", ["holdfast", "benchmark", "try", *map(str, options)])
        with pytest.raises(SystemExit) as stopped:
            run()
        assert list(away.iterdir()) == []
        return stopped.value.code, capsys.readouterr().err

    return call


def test_the_command_saves_into_the_checkout_from_another_folder(command: Any, tmp_path: Path) -> None:
    assert command(tmp_path / "home", "--save") == (0, "")
    saved = json.loads((tmp_path / "home" / "benchmarks" / "results" / "try.json").read_text())
    assert saved["rows"] == [{"case": "a", "push s": 0.5}]


def test_the_command_saves_into_a_named_folder(command: Any, tmp_path: Path) -> None:
    assert command(None, "--save", "--results", tmp_path / "named") == (0, "")
    assert (tmp_path / "named" / "try.md").exists()


@pytest.mark.parametrize("option", ["--save", "--compare"])
def test_the_command_without_a_checkout_asks_for_a_folder(command: Any, option: str) -> None:
    code, said = command(None, option)
    assert code == 2
    assert "--results DIR" in " ".join(said.split())


def test_measuring_alone_needs_no_folder(command: Any) -> None:
    assert command(None)[0] == 0
