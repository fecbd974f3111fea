"""The lines for jq on the page about JSON: each runs as it stands, and says something."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import holdfast as hf

PAGE = (Path(__file__).parents[2] / "docs/howto/json.md").read_text(encoding="utf-8")
LINES = [line for block in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL) for line in block.splitlines()]


BLOCK = """<robot name="block"><link name="block">
<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0 0 0.05"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link></robot>"""


def test_there_are_ten_lines() -> None:
    assert len(LINES) >= 10


@pytest.mark.skipif(shutil.which("jq") is None, reason="needs jq")
@pytest.mark.parametrize("line", LINES)
def test_a_line_runs_as_it_stands(line: str, tmp_path: Path) -> None:
    hf.save_scene(hf.shipped_scene("cube").moved({"cube": hf.pose(z=0.5)}), tmp_path / "high.yaml")
    (tmp_path / "block.urdf").write_text(BLOCK, encoding="utf-8")
    ready = f'holdfast() {{ "{sys.executable}" -m holdfast "$@"; }}\n'
    done = subprocess.run(["bash", "-c", ready + line], cwd=tmp_path, capture_output=True, text=True, check=False)
    said = re.search("# .*exit code ([0-9])", line)
    assert done.returncode == (int(said[1]) if said else 0), done.stderr
    assert done.stdout.strip() or "settle" in line, done.stderr  # a table that stands does not move
