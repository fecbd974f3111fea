"""A batch keeps what it has answered, whatever stops it, and asks again only what has changed."""

from __future__ import annotations

import os
import random
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import batch_drill
import pytest
from reproduced import rows

import holdfast as hf
from holdfast.base import progress
from holdfast.batches import tables
from holdfast.batches.folder import Folder
from holdfast.batches.tables import TABLES

pytestmark = pytest.mark.usefixtures("drill")


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[], list[str]]:
    """The names of the scenes that workers were asked since the last call, sorted."""
    trace = tmp_path / "trace"
    monkeypatch.setenv(batch_drill.TRACE, str(trace))

    def names() -> list[str]:
        found = sorted(Path(name).name for name in trace.read_text().split("\n")[:-1]) if trace.exists() else []
        trace.unlink(missing_ok=True)
        return found

    return names


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Eight scene files."""
    made = tmp_path / "in"
    made.mkdir()
    for k in range(8):
        (made / f"{k}.yaml").write_text(f"scene {k}")
    return made


def batch(folder: Path, **options: Any) -> hf.answers.BatchReport:
    given = {"out": folder.parent / "out", "workers": 2, "resources": hf.sets.Resources(shard_size=3)} | options
    return hf.batch(str(folder / "*.yaml"), **given)


def test_all_scenes_have_rows_in_the_order_of_the_inputs(folder: Path) -> None:
    report = batch(folder)
    assert (report.scenes, report.asked, report.kept) == (8, 8, 0)
    assert dict(report.outcomes) == {"answered": 8}
    report.save(folder.parent / "report.json")
    assert hf.load_answer(folder.parent / "report.json") == report
    found = rows(folder.parent / "out")
    assert [row["reason"] for row in found["scenes"]] == [f"scene {k}" for k in range(8)]
    assert [row["number"] for row in found["pushes"]] == [k // 3 for k in range(24)]
    assert found["pushes"][5]["force"] == float("inf")
    shards = sorted(path.name[:6] for path in (folder.parent / "out" / "scenes").iterdir())
    assert shards == ["000000", "000001", "000002"]
    assert list((folder.parent / "out" / "journal").glob("*.jsonl")) == []


def test_it_says_how_far_it_is(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture) -> None:
    monkeypatch.setattr(progress, "EVERY", 0.01)
    batch(folder, workers=1)
    told = capsys.readouterr().err.splitlines()
    assert told, "a worker takes longer to start"
    assert all(re.fullmatch(r"scenes: [0-8] of 8, (after \d+ s|\S+ a second, \d+ s left)", line) for line in told)


def test_what_is_unchanged_is_not_asked_again(folder: Path, asked: Callable[[], list[str]]) -> None:
    batch(folder)
    before, stamp = rows(folder.parent / "out"), asked()
    assert len(stamp) == 8
    report = batch(folder)
    assert (report.asked, report.kept, asked()) == (0, 8, [])
    (folder / "4.yaml").write_text("scene 4, changed")
    assert batch(folder).asked == 1
    assert asked() == ["4.yaml"]
    after = rows(folder.parent / "out")
    assert after["scenes"][4]["reason"] == "scene 4, changed"
    assert [row for row in after["scenes"] if row["number"] != 4] == [r for r in before["scenes"] if r["number"] != 4]


def test_inputs_that_move_keep_their_rows(folder: Path, asked: Callable[[], list[str]]) -> None:
    batch(folder)
    asked()
    (folder / "2a.yaml").write_text("new in the middle")
    (folder / "0.yaml").unlink()
    (folder / "00.yaml").write_text("new at the beginning")
    (folder / "000.yaml").write_text("another")
    batch(folder)
    assert asked() == ["00.yaml", "000.yaml", "2a.yaml"]
    fresh = batch(folder, out=folder.parent / "fresh")
    assert fresh.scenes == 10
    assert rows(folder.parent / "out") == rows(folder.parent / "fresh")


def test_fewer_inputs_lose_nothing_for_later(folder: Path, asked: Callable[[], list[str]]) -> None:
    batch(folder)
    before = rows(folder.parent / "out")
    asked()
    out = folder.parent / "out"
    assert (
        hf.batch(str(folder / "[67].yaml"), resources=hf.sets.Resources(shard_size=3), out=out, workers=1).scenes == 2
    )
    assert [row["number"] for row in rows(out)["pushes"]] == [0, 0, 0, 1, 1, 1]
    batch(folder)
    assert asked() == []
    assert rows(out) == before
    assert list((out / "journal").glob("*.jsonl")) == []


def test_rows_that_a_shard_loses_outlast_the_end_of_the_driver(
    folder: Path, asked: Callable[[], list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    batch(folder)
    (folder / "-.yaml").write_text("new at the beginning: every row moves")
    write = Folder.write

    def last(self: Folder, shard: int, records: Any) -> None:
        write(self, shard, records)
        if shard == 0:  # the others are written while the new scene is asked
            raise KeyboardInterrupt

    monkeypatch.setattr(Folder, "write", last)
    with pytest.raises(KeyboardInterrupt):
        batch(folder, workers=1)
    monkeypatch.setattr(Folder, "write", write)
    assert "-.yaml" in asked()
    batch(folder, workers=1)
    assert asked() == []
    assert [row["reason"][:7] for row in rows(folder.parent / "out")["scenes"]][1:3] == ["scene 0", "scene 1"]


@pytest.mark.parametrize(
    ("word", "outcome", "told"),
    [
        ("hang", "time", "no answer within 3 s"),
        ("eat", "memory", "MemoryError"),
        ("exit", "crash", "exit code 7"),
        ("killed", "crash", "killed 3 times"),
    ],
)
def test_what_a_scene_does_is_one_row_and_harms_no_other(folder: Path, word: str, outcome: str, told: str) -> None:
    """All other endings: test_supervisor.py."""
    (folder / "3.yaml").write_text(f"{word} now")
    seconds = 60.0 if outcome == "memory" else 3.0  # a busy machine takes a while to use it up
    report = batch(folder, resources=hf.sets.Resources(megabytes=1000, shard_size=3), seconds=seconds)
    found = rows(folder.parent / "out")["scenes"]
    assert [row["outcome"] for row in found] == ["answered"] * 3 + [outcome] + ["answered"] * 4
    assert told in found[3]["problem"]
    assert report.failures[0][:2] == (str(folder / "3.yaml"), outcome)
    assert batch(folder, seconds=seconds).asked == 0
    (folder / "3.yaml").write_text("tame now")
    assert dict(batch(folder).outcomes) == {"answered": 8}


def test_an_outcome_can_be_asked_again(folder: Path, asked: Callable[[], list[str]]) -> None:
    (folder / "3.yaml").write_text("exit")
    batch(folder)
    asked()
    assert batch(folder, retry=["time", "crash"]).asked == 1
    assert asked() == ["3.yaml"]


def test_another_question_is_refused_by_name(folder: Path) -> None:
    batch(folder)
    with pytest.raises(hf.HoldfastError, match="holds answers for ask = "):
        batch(folder, ask=("stability", "map"))
    with pytest.raises(hf.HoldfastError, match="holds answers for options = "):
        batch(folder, options={"engine": "limit"})
    with pytest.raises(hf.HoldfastError, match="holds answers for shard_size = 3, not 4"):
        batch(folder, resources=hf.sets.Resources(shard_size=4))
    strange = folder.parent / "strange"
    strange.mkdir()
    (strange / "thesis.tex").write_text("")
    with pytest.raises(hf.HoldfastError, match=r"thesis\.tex"):
        batch(folder, out=strange)


def test_shards_divided_among_drivers_make_one_table(folder: Path) -> None:
    batch(folder, out=folder.parent / "whole")
    for part in ("0/2", "1/2"):
        batch(folder, resources=hf.sets.Resources(shard=part))
    assert rows(folder.parent / "out") == rows(folder.parent / "whole")


def test_json_lines_hold_the_same_as_parquet(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyarrow")
    batch(folder)
    monkeypatch.setattr(tables, "has_pyarrow", lambda: False)
    batch(folder, out=folder.parent / "lines")
    kinds = {path.suffix for name in TABLES for path in (folder.parent / "lines" / name).iterdir()}
    assert kinds == {".jsonl"}
    with pytest.raises(hf.HoldfastError, match="pyarrow is not installed"):
        rows(folder.parent / "out")
    lines = rows(folder.parent / "lines")
    monkeypatch.undo()
    assert rows(folder.parent / "out") == lines


def test_two_batches_do_not_write_to_one_folder(folder: Path) -> None:
    (folder / "0.yaml").write_text("hang")
    first = started(folder)
    assert first.stdout is not None
    assert first.stdout.readline() == b"drawn\n"
    with pytest.raises(hf.HoldfastError, match="another batch writes to it"):
        batch(folder)
    with pytest.raises(hf.HoldfastError, match="another batch writes to it"):
        batch(folder, resources=hf.sets.Resources(shard="0/2"))
    first.kill()
    first.wait()
    (folder / "0.yaml").write_text("tame")
    assert once_free(lambda: batch(folder)).scenes == 8


def once_free(ask: Callable[[], hf.answers.BatchReport], seconds: float = 60) -> hf.answers.BatchReport:
    """Ask as soon as nobody writes to the folder: the workers of a killed driver hold its lock until they notice."""
    end = time.monotonic() + seconds
    while True:
        try:
            return ask()
        except hf.HoldfastError as error:
            if "another batch writes to it" not in str(error) or time.monotonic() > end:
                raise
            time.sleep(0.1)


def started(folder: Path, **environment: str) -> subprocess.Popen[bytes]:
    """A driver in a process of its own, which says so when it draws the first scene."""
    code = (
        "import sys, holdfast as hf\n"
        "from pathlib import Path\n"
        "from holdfast.batches import workers\n"
        "workers.ANSWERED_BY = 'batch_drill:answered'\n"
        "folder = Path(sys.argv[1])\n"
        "def drawn():\n"
        "    print('drawn', flush=True)\n"
        "    yield from (str(path) for path in sorted(folder.glob('*.yaml')))\n"
        "hf.batch(drawn(), out=folder.parent / 'out', workers=2, resources=hf.sets.Resources(shard_size=3))\n"
    )
    command = [sys.executable, "-c", code, str(folder)]
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, **environment},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler) and None,  # off in the background
    )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_killed_at_random_moments_it_loses_and_repeats_nothing(
    folder: Path, asked: Callable[[], list[str]], seed: int
) -> None:
    draw = random.Random(seed)
    for k in range(40):
        (folder / f"{k}.yaml").write_text(f"slow {k}")
    batch(folder, out=folder.parent / "whole")
    asked()
    kills = 0
    while kills < (2 if seed == 1 else 4):
        driver = started(folder)
        assert driver.stdout is not None
        driver.stdout.readline()
        time.sleep(draw.uniform(0.1, 0.9))
        workers = Path(f"/proc/{driver.pid}/task/{driver.pid}/children").read_text().split()
        victim = driver.pid if kills % 2 == 0 or not workers else int(draw.choice(workers))
        kills += 1
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
        if victim != driver.pid:
            time.sleep(draw.uniform(0.1, 0.5))
            driver.kill()
        driver.wait()
    once_free(lambda: batch(folder))
    assert rows(folder.parent / "out") == rows(folder.parent / "whole")
    assert len(asked()) <= 40 + kills * 2 * 2  # those in flight, of two workers and of the orphans of a killed driver
    assert list((folder.parent / "out" / "journal").glob("*.jsonl")) == []


def test_a_disk_that_fills_is_told_and_loses_nothing(folder: Path, asked: Callable[[], list[str]]) -> None:
    batch(folder, out=folder.parent / "whole")
    asked()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    failures = 0
    try:
        for most in (400, 1500, 2500, 4000):  # bytes of a file: within a line, between two lines, within a table
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, limits[1]))
            try:
                batch(folder)
            except hf.HoldfastError as error:
                assert "cannot be written" in str(error)  # noqa: PT017 - it may be written, where the limit is large
                failures += 1
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, ignored)
    assert failures >= 2
    batch(folder)
    assert rows(folder.parent / "out") == rows(folder.parent / "whole")


def test_ctrl_c_leaves_what_can_be_resumed(folder: Path, asked: Callable[[], list[str]]) -> None:
    (folder / "0.yaml").write_text("slow")
    (folder / "7.yaml").write_text("hang")
    driver = started(folder)
    out = folder.parent / "out"
    for shard in ("000000", "000001"):  # the first scene may well end after the next ones
        wait_until(lambda shard=shard: any((out / "scenes").glob(f"{shard}.*")))
    journal = out / "journal" / "000002.jsonl"
    wait_until(lambda: journal.exists() and journal.read_bytes().endswith(b"\n"))
    workers = Path(f"/proc/{driver.pid}/task/{driver.pid}/children").read_text().split()
    driver.send_signal(signal.SIGINT)
    assert driver.wait(20) != 0
    wait_until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers))
    asked()
    (folder / "7.yaml").write_text("tame")
    batch(folder)
    assert asked() == ["7.yaml"]


def wait_until(true: Callable[[], bool]) -> None:
    until = time.monotonic() + 60
    while not true():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_names_must_differ_and_inputs_be_there(folder: Path) -> None:
    out = folder.parent / "out"
    twice = [("a", str(folder / "0.yaml")), ("a", str(folder / "1.yaml"))]
    with pytest.raises(hf.HoldfastError, match="numbers 0 and 1 have the name 'a'"):
        hf.batch(twice, out=out)
    for wrong, words in ((str(folder / "*.txt"), "names no scene file"), (3, "got 3"), ([3], "number 0 is 3")):
        with pytest.raises(hf.HoldfastError, match=words):
            hf.batch(wrong, out=out)  # type: ignore[arg-type]


def test_a_manifest_names_scenes_relative_to_its_folder(folder: Path) -> None:
    manifest = folder.parent / "list.csv"
    manifest.write_text("scene,name\nin/3.yaml,third\nin/1.yaml,\n", encoding="utf-8")
    hf.batch(manifest, out=folder.parent / "out")
    found = rows(folder.parent / "out")["scenes"]
    assert [(row["scene"], row["reason"]) for row in found] == [("third", "scene 3"), ("in/1.yaml", "scene 1")]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"ask": ()}, "ask: is empty"),
        ({"ask": "map:file"}, "'map:file' is unknown"),
        ({"options": {"map": {"spacin": 0.1}}}, "did you mean 'spacing'"),
        ({"options": {"assemble": {"gap": object()}}}, "cannot be written as JSON"),
        ({"resources": hf.sets.Resources(shard="2/2")}, "0 <= i < n"),
        ({"retry": ["never"]}, "'never' is no outcome"),
    ],
)
def test_wrong_arguments_are_told_before_anything_is_written(folder: Path, options: Any, words: str) -> None:
    with pytest.raises(hf.HoldfastError) as told:
        batch(folder, **options)
    assert words in str(told.value)
    assert not (folder.parent / "out").exists()


MANIFEST = "scene,name\n{place},one\n"
PUSHES = "body,x,y,z,dx,dy,dz\n{place},0,0,0,1,0,0\n"
BROKEN = {
    "line 2: is no CSV: field larger than field limit": lambda text: text.format(place="a" * 200_000).encode(),
    "line 2: has the byte 0xe9, which is not UTF-8": lambda text: text.format(place="é").encode("latin-1"),
    "line 1: has the byte 0xff, which is not UTF-8": lambda text: text.format(place="a").encode("utf-16"),
}


@pytest.mark.parametrize("words", BROKEN)
def test_broken_manifests_and_files_of_pushes_are_told(folder: Path, words: str) -> None:
    for name, text in (("manifest.csv", MANIFEST), ("pushes.csv", PUSHES)):
        path = folder / name
        path.write_bytes(BROKEN[words](text))
        with pytest.raises(hf.HoldfastError, match=rf"{name}, {words}.*; "):
            ask(folder, path)
    assert not (folder.parent / "out").exists()


def ask(folder: Path, path: Path) -> hf.answers.BatchReport:
    if path.stem == "manifest":
        return hf.batch(path, out=folder.parent / "out", workers=1)
    return hf.batch(str(folder / "*.yaml"), f"push:{path}", out=folder.parent / "out", workers=1)


def test_a_carriage_return_by_itself_ends_a_line(folder: Path) -> None:
    """As files of old Macs have it; within a name it makes two lines of one, and both are told."""
    (folder / "manifest.csv").write_bytes(b"scene,name\r0.yaml,one\r1.y\raml,two\r")
    report = ask(folder, folder / "manifest.csv")
    assert [each[:2] for each in report.failures] == [("1.y", "crash"), ("two", "crash")], "the drill reads them"
    (folder / "pushes.csv").write_bytes(b"body,x,y,z,dx,dy,dz\na\rb,0,0,0,1,0,0\n")
    with pytest.raises(hf.HoldfastError, match=r"pushes\.csv, line 2: holds no six numbers"):
        ask(folder, folder / "pushes.csv")


@pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" + 200 * b"\xff" + b"PAR1"])
def test_a_broken_parquet_manifest_is_told(folder: Path, content: bytes) -> None:
    (folder / "manifest.parquet").write_bytes(content)
    with pytest.raises(hf.HoldfastError, match=r"manifest\.parquet: is not a readable Parquet file: .*as CSV"):
        hf.batch(folder / "manifest.parquet", out=folder.parent / "out")


@pytest.mark.parametrize("place", ["no\0file", "/", "a" * 5000, "\ud800"])
def test_places_that_are_no_files_are_rows_of_their_own(folder: Path, place: str) -> None:
    report = hf.batch([str(folder / "0.yaml"), place], out=folder.parent / "out", workers=1)
    assert dict(report.outcomes) == {"answered": 1, "crash": 1}, "the drill reads whatever it is given"
    assert report.failures[0][0] == place.replace("\ud800", "\\ud800")


def test_a_file_whose_name_is_not_utf8_is_asked(folder: Path) -> None:
    os.rename(folder / "0.yaml", os.fsencode(folder) + b"/\xe9.yaml")
    report = batch(folder)
    assert dict(report.outcomes) == {"answered": 8}
    assert rows(folder.parent / "out")["scenes"][-1]["files"] == ["\\xe9.yaml"]
