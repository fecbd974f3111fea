"""The page about batches shows the columns that are written, and its snippets run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from holdfast.batches.schema import TABLES

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "batch.md").read_text(encoding="utf-8")


def columns() -> str:
    """The tables of columns as the page shows them."""
    parts = []
    for name, columns in TABLES.items():
        rows = [f"| `{c.name}` | {c.kind} | {c.unit} | {c.meaning} |" for c in columns]
        parts.append("\n".join([f"### {name}", "", "| column | kind | unit | meaning |", "|---|---|---|---|", *rows]))
    return "\n\n".join(parts)


def test_the_columns_are_those_of_the_schema() -> None:
    assert columns() in PAGE, f"put this under '## Columns':\n\n{columns()}"


def test_the_snippets_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    import holdfast as hf

    (tmp_path / "scenes").mkdir()
    for name in ("cube", "stack"):
        hf.save_scene(hf.shipped_scene(name), tmp_path / "scenes" / f"{name}.yaml")
    names: dict[str, object] = {}
    for text in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(text, names)  # a snippet of this repository
        printed = capsys.readouterr().out
        assert all(said in printed for said in re.findall(r"print\(.*\)\s+# (.*)", text))
    assert names["weak"] == ["scenes/cube.yaml", "scenes/stack.yaml"]
