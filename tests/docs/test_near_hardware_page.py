"""The worked scene of docs/near_hardware.md runs, and every doubt takes something away."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "near_hardware.md"


def test_the_worked_scene_goes_down_from_doubt_to_doubt(tmp_path: Path) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    numbers = {line[:24].strip(): float(line.split()[-2]) for line in done.stdout.splitlines()}
    above, ideal, numerics, wooden, seen, friction, poses, mass = numbers.values()
    assert above >= ideal > numerics > wooden > seen > 0
    assert 0.5 * ideal < friction < ideal
    assert 0.5 * ideal < mass < poses < ideal
    told = re.findall(r"^print\(.*# ([\d.]+)$", code, re.MULTILINE)
    assert [float(text) for text in told] == pytest.approx(list(numbers.values()), rel=0.02), "as the page says"
