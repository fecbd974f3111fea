"""The plug-ins on the pages, installed as an installer would, do what the pages say."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import holdfast as hf

HOWTO = Path(__file__).parents[2] / "docs" / "howto"


@pytest.mark.parametrize(("page", "name"), [("own_format", "points"), ("own_engine", "half")])
def test_what_the_page_shows_is_loaded_when_it_is_named(page: str, name: str, tmp_path: Path) -> None:
    text = (HOWTO / f"{page}.md").read_text(encoding="utf-8")
    (module,) = re.findall(rf'{name} = "(\w+)"', text)
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (lines,) = re.findall(r"```bash\n(.*?)```", text, re.DOTALL)
    assert f"odule `{module}`" in " ".join(text.split())
    assert '[project.entry-points."holdfast.plugins"]' in (HOWTO / "own_format.md").read_text(encoding="utf-8")
    (tmp_path / f"{module}.py").write_text(code, encoding="utf-8")
    package = tmp_path / f"{module}-0.1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module.replace('_', '-')}\nVersion: 0.1.0\n")
    (package / "entry_points.txt").write_text(f"[holdfast.plugins]\n{name} = {module}\n")
    command = f'set -e\nholdfast() {{ "{sys.executable}" -m holdfast "$@"; }}\n{lines}'
    path = os.pathsep.join([str(tmp_path), str(Path(hf.__file__).parents[1])])
    told = subprocess.run(
        ["bash", "-c", command],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert told.returncode == 0, told.stdout
    shown = re.findall(r"^# (.*)$", lines, re.MULTILINE)
    assert shown
    for line in shown:
        assert line in told.stdout.splitlines(), told.stdout
