"""A journal takes what is appended, and drops what is left of a line."""

from __future__ import annotations

from pathlib import Path

import pytest

from holdfast.batches.tables import Journal, Record, name_of


def record(name: str, force: float = 1.0) -> Record:
    return {"scenes": [{"number": 0, "scene": name}], "pushes": [{"scene": name, "force": force}]}


@pytest.mark.parametrize("rest", [b"", b'{"scenes": [{"num', b"\0" * 40 + b"\n", b"[]\n"])
def test_what_is_left_of_a_line_is_dropped_and_written_over(tmp_path: Path, rest: bytes) -> None:
    path = tmp_path / "0.jsonl"
    first = Journal(path)
    first.append(record("a", float("inf")))
    first.close()
    with path.open("ab") as stream:
        stream.write(rest)
    second = Journal(path)
    assert list(second.places) == ["a"]
    second.append(record("b"))
    second.close()
    third = Journal(path)
    assert [name_of(third.record(name)) for name in third.places] == ["a", "b"]
    assert third.record("a")["pushes"][0]["force"] == float("inf")


def test_the_last_line_of_a_scene_counts(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "0.jsonl")
    for force in (1.0, 2.0):
        journal.append(record("a", force))
    for each in (journal, Journal(journal.path)):
        assert [r["pushes"][0]["force"] for r in map(each.record, each.places)] == [2.0]
    journal.remove()
    assert not journal.path.exists()
