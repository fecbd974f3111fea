"""The command ``settle``: exit codes, files and JSON."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calling import Call

import holdfast as hf
from holdfast.scene.shipped.blocks import box, floor


@pytest.fixture
def scenes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    hover, hang, deep = (box("a", (0.1, 0.1, 0.1), 1, (0, 0, z)) for z in (0.052, 0.08, 0.03))
    for name, body in (("hover", hover), ("hang", hang), ("deep", deep)):
        hf.save_scene(hf.Scene([floor(0.4, 0.3), body], 0.5, name=name), f"{name}.yaml")


@pytest.mark.usefixtures("scenes")
@pytest.mark.parametrize(
    ("name", "code", "status"), [("hover", 0, "stable"), ("hang", 1, "unstable"), ("deep", 3, "undecided")]
)
def test_exit_codes_and_json(name: str, code: int, status: str, call: Call) -> None:
    ended, out, _ = call("settle", f"{name}.yaml", "--travel", "0.01", "--json")
    assert ended == code
    told = json.loads(out)
    assert told["verdict"] == status
    assert [body["body"] for body in told["rows"]] == ["a"]


@pytest.mark.usefixtures("scenes")
def test_files(call: Call) -> None:
    arguments = ("settle", "hover.yaml", "-o", "rest.yaml", "--png", "rest.png")
    ended, out, _ = call(*arguments)
    assert ended == 0
    assert "sank 2 mm" in " ".join(out.split())
    assert np.allclose(hf.load_scene("rest.yaml").body("a").pose[:3, 3], (0, 0, 0.05), atol=1e-5)
    assert Path("rest.png").exists()
