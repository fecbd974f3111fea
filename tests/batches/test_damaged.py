"""Folders of batches that were damaged: the file is named, what it held is asked anew, and nothing is passed over."""

from __future__ import annotations

import json
import random
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import batch_drill
import pytest
import reproduced

import holdfast as hf
from holdfast.batches import tables
from holdfast.report.batch_report import write_report

pytestmark = pytest.mark.usefixtures("drill")


@pytest.fixture(scope="module", params=["parquet", "json lines"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, drill: None) -> Path:
    """A folder with eight scenes and their batch in three shards."""
    here = tmp_path_factory.mktemp("made")
    (here / "in").mkdir()
    for k in range(8):
        (here / "in" / f"{k}.yaml").write_text(f"scene {k}")
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "json lines":
            patch.setattr(tables, "has_pyarrow", lambda: False)
        batch(here)
    return here


@pytest.fixture
def here(made: Path, tmp_path: Path) -> Path:
    shutil.copytree(made, tmp_path / "here")
    return tmp_path / "here"


def batch(here: Path) -> hf.answers.BatchReport:
    scenes = [(f"{k}.yaml", here / "in" / f"{k}.yaml") for k in range(8)]
    return hf.batch(scenes, resources=hf.sets.Resources(shard_size=3), out=here / "out", workers=1)


def rows(here: Path) -> dict[str, Any]:
    found = reproduced.rows(here / "out")
    return {name: [{**row, "path": ""} for row in table] for name, table in found.items()}


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-20])


def changed(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2 :] = bytes(byte ^ 0x5A for byte in content[len(content) // 2 :])
    path.write_bytes(content)


def emptied(path: Path) -> None:
    path.write_bytes(b"")


def of_another_table(path: Path) -> None:
    other = "pushes" if path.parent.name == "scenes" else "scenes"
    shutil.copy(path.parents[1] / other / path.name, path)


def of_another_shard(path: Path) -> None:
    shutil.copy(path.with_name(path.name.replace("1", "0")), path)


SOUND = {"format": "holdfast-batch/1", "version": "1", "ask": [], "options": {}, "shard_size": 3, "storage": "parquet"}
DAMAGES = (cut, changed, emptied, of_another_table, Path.unlink)


@pytest.mark.parametrize("table", ["scenes", "pushes"])
@pytest.mark.parametrize("damage", DAMAGES, ids=lambda each: each.__name__)
def test_a_damaged_shard_is_named_and_asked_anew(
    here: Path, table: str, damage: Callable[[Path], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = rows(here)
    (path,) = (here / "out" / table).glob("000001.*")
    damage(path)
    if damage is emptied and path.parent.name == "pushes" and path.suffix == ".jsonl":
        pytest.skip("a table of JSON lines without rows is an empty file: nothing tells it from one that was emptied")
    gone = (table, damage) == ("scenes", Path.unlink)  # like a shard that was never finished: no error, but it is said
    with pytest.warns(hf.errors.HoldfastWarning) if gone else pytest.raises(hf.HoldfastError) as told:
        rows(here)
    said = str(told[0].message if gone else told.value)
    assert str(path) in said
    assert "run the same batch again" in said
    monkeypatch.setenv(batch_drill.TRACE, str(here / "trace"))
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        report = batch(here)
    assert [str(path) in str(each.message) for each in warned] == ([] if gone else [True])
    assert (report.asked, report.kept) == (3, 5)
    assert (here / "trace").read_text().split() == ["3.yaml", "4.yaml", "5.yaml"]
    assert rows(here) == before


def test_rows_of_another_shard_are_seen(here: Path) -> None:
    before = rows(here)
    (path,) = (here / "out" / "pushes").glob("000001.*")
    of_another_shard(path)
    with pytest.warns(
        hf.errors.HoldfastWarning, match=r"000001.*: has rows of '0\.yaml', which is not in the table scenes"
    ):
        assert batch(here).asked == 3
    assert rows(here) == before


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        "[" * 100_000,
        '{"format": "holdfast-batch/1"}',
        *(json.dumps(SOUND | wrong) for wrong in ({"shard_size": "a"}, {"shard_size": 0}, {"storage": "zip"})),
        *(json.dumps(SOUND | wrong) for wrong in ({"options": []}, {"options": {"load": 3}}, {"ask": 3})),
    ],
)
def test_what_says_what_was_asked_is_checked(here: Path, text: str) -> None:
    (here / "out" / "batch.json").write_text(text)
    for asked in (rows, batch, lambda here: write_report(here / "out", here / "page.html")):
        with pytest.raises(hf.HoldfastError, match=r"batch\.json: is damaged"):
            asked(here)


@pytest.mark.parametrize("name", ["scenes", "journal", "journal/lock", "journal/000001.jsonl"])
def test_a_file_where_a_folder_belongs_and_the_other_way_round_are_told(here: Path, name: str) -> None:
    path = here / "out" / name
    if path.is_dir():
        shutil.rmtree(path)
        path.write_text("")
    else:
        path.unlink(missing_ok=True)
        path.mkdir()
    with pytest.raises(hf.HoldfastError, match=name):
        batch(here)


def test_whatever_is_damaged_the_answers_are_right_or_it_is_told(here: Path, tmp_path: Path) -> None:
    """One file at random, damaged at random, 20 times; nothing but errors that name a file may come of it."""
    rng, before, told = random.Random(20261126), rows(here), 0
    for trial in range(20):
        there = tmp_path / f"{trial}"
        shutil.copytree(here, there)
        path = rng.choice(sorted(path for path in (there / "out").rglob("*") if path.is_file()))
        tamper(rng, path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", hf.errors.HoldfastWarning)
            try:
                batch(there)
                found = rows(there)
            except hf.HoldfastError as error:
                told += 1
                found, said = before, str(error)
                assert str(there) in said
        assert found == before, path
        shutil.rmtree(there)
    assert told < 10


def test_a_flipped_bit_in_a_number_is_told(here: Path) -> None:
    """Pages have checksums: each bit of a shard that is flipped changes no row, or is told."""
    before, rng = rows(here), random.Random(20270113)
    path = here / "out" / "pushes" / "000000.parquet"
    if not path.exists():
        pytest.skip("lines of JSON have no checksums: a flipped digit is another digit")
    whole = path.read_bytes()
    told = 0
    for _ in range(150):
        content = bytearray(whole)
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
        path.write_bytes(content)
        try:
            found = rows(here)
        except hf.HoldfastError:
            told += 1
        else:
            assert found == before
    assert told > 30


def tamper(rng: random.Random, path: Path) -> None:
    content = bytearray(path.read_bytes())
    match rng.randrange(4):
        case 0:
            del content[rng.randrange(len(content) + 1) :]
        case 1:
            path.unlink()
            return
        case 2:
            content = bytearray(rng.randbytes(rng.randrange(200)))
        case _:  # only where it is not seen by its meaning: numbers and texts that are as good as others are not tried
            at = rng.randrange(len(content) + 1)
            content[at:at] = b"\xff\0\xff"
    path.write_bytes(content)
