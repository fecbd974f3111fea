"""The page "From your scene to an answer" is run: of each section its files, its Python and its commands, in order."""

from __future__ import annotations

import importlib.util
import re
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from holdfast.cli.main import run

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "howto" / "bring_a_scene.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))
SNIPPET = re.compile(r"(?:`(?P<file>[\w.]+)`:\n\n)?```(?P<kind>\w*)\n(?P<text>.*?)```", re.DOTALL)
FORMATS = [name for name, text in SECTIONS.items() if "```" in text]
EXTRA = {"MuJoCo": "mujoco", "USD": "pxr"}  # what a section needs beside the library


def command(line: str, monkeypatch: pytest.MonkeyPatch) -> object:
    """The exit code of a command, called in this process."""
    monkeypatch.setattr(sys, "argv", shlex.split(line, comments=True))
    with pytest.raises(SystemExit) as stopped:
        run()
    return stopped.value.code


@pytest.mark.parametrize("name", FORMATS)
def test_every_section_runs_and_prints_what_it_says(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if name in EXTRA and importlib.util.find_spec(EXTRA[name]) is None:
        pytest.skip(f"needs {EXTRA[name]}")
    monkeypatch.chdir(tmp_path)
    kinds = []
    for snippet in SNIPPET.finditer(SECTIONS[name]):
        kind, text = snippet["kind"], snippet["text"]
        kinds.append(kind)
        if snippet["file"]:
            Path(snippet["file"]).write_text(text, encoding="utf-8")
        elif kind == "python":
            names: dict[str, Any] = {}
            exec(compile(text, "bring_a_scene.md", "exec"), names)
            promised = re.findall(r"print\(.*\)\s+# (.*)", text)
            assert promised
            printed = capsys.readouterr().out.splitlines()
            assert [line for line in printed if line in promised] == promised, printed
        else:
            assert kind == "bash"
            for line in text.splitlines():
                assert command(line, monkeypatch) in (0, None), line
            assert "13.08 N" in capsys.readouterr().out
    assert "python" in kinds
    assert "bash" in kinds


def test_every_section_says_what_goes_wrong_and_is_listed_above() -> None:
    links = re.findall(r"\[([^\]]+)\]\(#([\w-]+)\)", PAGE.split("\n## ", 1)[0])
    assert [name for name, _ in links] == FORMATS
    assert [anchor for _, anchor in links] == [name.lower().replace(" ", "-") for name in FORMATS]
    for name in FORMATS:
        assert "**What usually goes wrong: " in SECTIONS[name], name


def test_the_page_can_be_found() -> None:
    assert "docs/howto/bring_a_scene.md" in (ROOT / "README.md").read_text(encoding="utf-8")
