"""Answers that 1.0.0rc1 and 1.0.0 saved are read: each tells what it told when it was saved.

``told.json`` holds for each file what the answer showed and told as plain data. Answers of 1.0.0rc1 lack columns that
it had and no version has any more.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import holdfast as hf
from holdfast.batches.saved import ANSWERS

SAVED = Path(__file__).parent / "saved"
TOLD = json.loads((SAVED / "told.json").read_text())
FILES = sorted(path.name for path in SAVED.iterdir() if path.name != "told.json")


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_an_earlier_version_is_read(name: str, tmp_path: Path) -> None:
    found = hf.load_answer(SAVED / name)
    told = {"shown": repr(found), **found.to_dict()}
    assert told == TOLD[name]
    assert json.dumps(told) == json.dumps(TOLD[name])  # in the same order
    found.save(tmp_path / name)
    assert hf.load_answer(tmp_path / name) == found


def test_files_hold_answers_of_all_kinds() -> None:
    assert {type(hf.load_answer(SAVED / name)) for name in FILES} == set(ANSWERS)
    assert sum("1.0.0rc1" in name for name in FILES) > 10


def test_columns_that_are_gone_are_not_saved_again(tmp_path: Path) -> None:
    for name in ("pushes-1.0.0rc1.json", "map-1.0.0rc1.npz"):
        hf.load_answer(SAVED / name).save(tmp_path / "again.json")
        assert "solved" not in (tmp_path / "again.json").read_text()
