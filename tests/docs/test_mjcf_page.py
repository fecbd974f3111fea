"""The walk-through of docs/from/mujoco.md is run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'holdfast-robotics[mujoco]'")

PAGE = Path(__file__).parents[2] / "docs" / "from" / "mujoco.md"


def test_the_walk_through_works_as_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(code, "mujoco.md", "exec"), names)
    assert names["answer"].force[0] == pytest.approx(4 * 9.81, rel=0.01)
    assert capsys.readouterr().out.startswith("()\n")
    assert names["hf"].load_scene("crate.xml").body("crate").mass == 4
