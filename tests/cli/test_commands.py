"""The commands are imported when they are called; what the help says of them is what they say of themselves."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from calling import called

from holdfast.cli.main import COMMANDS


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_begins_as_the_command_does(name: str) -> None:
    place, text = COMMANDS[name]
    module, _, function = place.partition(":")
    said = getattr(import_module(module), function).__doc__
    assert said.split()[:3] == text.split()[:3]


def test_the_help_imports_neither_compiler_nor_engines() -> None:
    code = (
        "import sys; sys.argv = ['holdfast', '--help']\n"
        "from holdfast.cli.main import run\n"
        "try: run()\n"
        "except SystemExit: print([m for m in ('numba', 'numpy', 'scipy', 'trimesh', 'pydantic') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert all(name in done.stdout for name in COMMANDS)


def test_an_unknown_command_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = called(monkeypatch, capsys, "asses", "table")
    assert code == 2
    assert "asses" in err


def test_warmup_tells_the_folder(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("holdfast.cli.warmup.compile_all", lambda: 93)
    monkeypatch.setenv("HOLDFAST_CACHE_DIR", str(tmp_path))
    code, out, _ = called(monkeypatch, capsys, "warmup", "--json")
    assert (code, json.loads(out)) == (0, {"functions": 93, "folder": str(tmp_path)})
