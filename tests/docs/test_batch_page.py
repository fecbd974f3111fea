"""The page about batches shows the columns that are written, and its snippets run."""

from __future__ import annotations

import re
from pathlib import Path

from holdfast.batches.schema import as_markdown

PAGE = (Path(__file__).parents[2] / "docs" / "batch.md").read_text(encoding="utf-8")


def test_the_columns_are_those_of_the_schema() -> None:
    assert as_markdown() in PAGE, "put what holdfast.batches.schema.as_markdown() returns under '## Columns'"


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
