"""The page on carrying: its example runs, and its table names every motion with its numbers."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import holdfast as hf

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "carry.md"


def test_the_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(code, str(PAGE), "exec"), {})
    assert "unstable" in capsys.readouterr().out


def test_every_name_is_told() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert [name for name in hf.Profile.standards() if f"`{name}`" not in page] == []
