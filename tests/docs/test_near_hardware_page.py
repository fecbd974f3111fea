"""The worked scene of docs/explanation/near_hardware.md runs, and every doubt takes something away."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import holdfast as hf

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "near_hardware.md"


def test_the_worked_scene_goes_down_from_doubt_to_doubt(tmp_path: Path) -> None:
    code = "\n".join(re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL))
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    numbers = {line[:24].strip(): float(line.split()[-2]) for line in done.stdout.splitlines()}
    first, above, ideal, numerics, wooden, seen, friction, poses, mass = numbers.values()
    assert above >= ideal > numerics > wooden > seen > 0
    assert 0.5 * ideal < friction < first < ideal
    assert 0.5 * ideal < mass < poses < ideal
    told = re.findall(r"^print\(.*# ([\d.]+)$", code, re.MULTILINE)
    assert [float(text) for text in told] == pytest.approx(list(numbers.values()), rel=0.02), "as the page says"


def test_a_coarse_map_overstates_the_weakest_push() -> None:
    crate = hf.Body("crate", hf.Box((0.1, 0.2, 0.2)), mass=4, pose=hf.pose(z=0.1))
    scene = hf.Scene([hf.Body("floor", hf.HalfSpace(), fixed=True), crate], 0.5)
    coarse, fine = (hf.robustness_map(scene, spacing=spacing).weakest().force for spacing in (0.08, 0.04))
    corner = float(hf.robustness(scene, "crate", (-0.05, -0.1, 0.2), (1, 0, 0)))
    assert (coarse, fine, corner) == pytest.approx((10.5, 9.5, 8.25), abs=0.05)
    assert "10.5, 9.5 and 8.5 N" in " ".join(PAGE.read_text(encoding="utf-8").split())
