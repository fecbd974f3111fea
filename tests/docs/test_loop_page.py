"""The page "In a loop": every snippet is run where its simulator is installed, and prints what it says."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "in_a_loop.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))
OWN = ("Watched while it moves", "Many poses at once")  # the sections that need no simulator
NEEDS = {"PyBullet": "pybullet", "Newton": "newton", "SAPIEN": "sapien", "Genesis": "genesis"}


@pytest.mark.parametrize("name", SECTIONS)
def test_every_section_runs_and_prints_what_it_says(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    if name in NEEDS and importlib.util.find_spec(NEEDS[name]) is None:
        pytest.skip(f"needs {NEEDS[name]}, which holdfast does not install")
    (text,) = re.findall(r"```python\n(.*?)```", SECTIONS[name], re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(text, "in_a_loop.md", "exec"), names)
    promised = re.findall(r"print\(.*\)\s+# (.*)", text)
    assert len(promised) >= 2
    printed = capsys.readouterr().out.splitlines()
    assert [line for line in printed if line in promised] == promised, printed
    if name not in OWN:
        assert names["push"].force[0] == pytest.approx(4 * 9.81 * 0.05 / 0.15, rel=0.01)


def test_every_simulator_of_the_table_has_its_section() -> None:
    told = re.findall(r"^\| (\w+) \| `", PAGE, re.MULTILINE)
    assert [name.split()[0] for name in SECTIONS if name not in OWN] == [
        name for name in told if name != "MuJoCo"
    ]  # which has a page
