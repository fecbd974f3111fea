"""The page about batches shows the columns that are written, and its snippets run."""

from __future__ import annotations

import re
from pathlib import Path

from holdfast.batches.schema import TABLES

PAGE = (Path(__file__).parents[2] / "docs" / "batch.md").read_text(encoding="utf-8")


def columns() -> str:
    """The tables of columns as the page shows them."""
    parts = []
    for name, columns in TABLES.items():
        rows = [f"| `{c.name}` | {c.kind} | {c.unit} | {c.meaning} |" for c in columns]
        parts.append("\n".join([f"### {name}", "", "| column | kind | unit | meaning |", "|---|---|---|---|", *rows]))
    return "\n\n".join(parts)


def test_the_columns_are_those_of_the_schema() -> None:
    assert columns() in PAGE, f"put this under '## Columns':\n\n{columns()}"


def test_the_snippet_runs(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    import holdfast as hf

    (tmp_path / "scenes").mkdir()
    for name in ("cube", "stack"):
        hf.save_scene(hf.shipped_scene(name), tmp_path / "scenes" / f"{name}.yaml")
    snippet = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert snippet is not None
    names: dict[str, object] = {}
    exec(snippet[1], names)  # a snippet of this repository
    assert names["weak"] == ["scenes/cube.yaml", "scenes/stack.yaml"]
