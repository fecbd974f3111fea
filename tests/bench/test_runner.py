"""The registry and the runner of benchmarks, on a suite of their own."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

import holdfast as hf
from bench import registry, runner
from bench.checkout import RESULTS, ROOT
from bench.figures.pages import pages
from bench.suite import Row, Suite


def suite(measured: list[str], fails: str = "") -> Suite:
    def case(label: str) -> list[Row]:
        if label == fails:
            raise RuntimeError(label)
        measured.append(label)
        return [{"case": label, "force N": np.float64(3.0), "worst N": np.inf, "push s": 0.5}]

    def plot(rows: list[Row], file: BinaryIO) -> None:
        file.write(b"picture")

    return Suite("try", "A suite for this test.", lambda: {x: partial(case, x) for x in ("a", "b", "c")}, plot)


def test_an_interrupted_run_resumes_after_the_last_case_done(tmp_path: Path) -> None:
    measured: list[str] = []
    with pytest.raises(RuntimeError):
        runner.run(suite(measured, fails="c"), tmp_path)
    rows = runner.run(suite(measured), tmp_path)
    assert measured == ["a", "b", "c"]
    assert [row["case"] for row in rows] == ["a", "b", "c"]


def test_a_suite_without_its_scenes_says_what_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It used to end in an error of NumPy: a percentile of nothing."""
    cargo = registry.suite("cargo")
    monkeypatch.setattr("bench.scenes.real_pallets.CASES", tmp_path)
    with pytest.raises(hf.HoldfastError, match=r"benchmark cargo.*nothing to measure.*shared/cases"):
        runner.run(cargo)


def test_a_fresh_run_measures_everything(tmp_path: Path) -> None:
    measured: list[str] = []
    runner.run(suite(measured), tmp_path)
    runner.run(suite(measured), tmp_path, fresh=True)
    assert measured == ["a", "b", "c"] * 2


def test_what_another_version_left_is_measured_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured: list[str] = []
    runner.run(suite(measured), tmp_path)
    monkeypatch.setattr(runner, "__version__", "another")
    runner.run(suite(measured), tmp_path)
    assert len(measured) == 6


def test_results_are_strict_json_with_the_machine_and_leave_no_partial_file(tmp_path: Path) -> None:
    rows = runner.run(suite([]), tmp_path)
    runner.save(suite([]), rows, tmp_path)
    data = json.loads((tmp_path / "try.json").read_text(), parse_constant=pytest.fail)
    assert data["rows"][0] == {"case": "a", "force N": 3.0, "worst N": "inf", "push s": 0.5}
    assert data["machine"]["cores"] > 0
    assert (tmp_path / "try.md").read_text().count("\n| ") == 4  # head and three rows
    assert (tmp_path / "try.png").read_bytes() == b"picture"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["try.json", "try.md", "try.png"]


def test_times_are_compared_with_the_saved_ones(tmp_path: Path) -> None:
    rows = runner.run(suite([]), None)
    runner.save(suite([]), rows, tmp_path)
    slower = [row | {"push s": 1.0} for row in rows]
    assert runner.compared(suite([]), slower, tmp_path)[0] == "a, push s: 2.00 x the saved 0.5"
    assert "nothing saved" in runner.compared(suite([]), slower, tmp_path / "elsewhere")[0]


def test_a_broken_partial_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "try.partial.json").write_text("{")
    with pytest.raises(hf.HoldfastError, match=r"try\.partial\.json: is not JSON .*; remove it"):
        runner.run(suite([]), tmp_path)


@pytest.mark.parametrize("name", registry.SUITES)
def test_every_registered_suite_has_its_name_and_labels(name: str) -> None:
    found = registry.suite(name)
    assert found.name == name
    assert found.about


@pytest.mark.parametrize("name", registry.SUITES)
def test_a_page_cites_every_suite(name: str) -> None:
    """What nobody cites goes, or is measured for nothing."""
    text = "".join(path.read_text(encoding="utf-8") for path in pages(ROOT))
    cited = rf"bench/results/{name}\.|figure: (\w+\+)?{name}[.+]|bench run [\w ]*\b{name}\b"
    assert re.search(cited, text), f"no page cites {name}"


def test_every_saved_result_belongs_to_a_suite() -> None:
    assert {path.stem for path in RESULTS.iterdir() if not path.name.endswith(".partial.json")} == {*registry.SUITES}
