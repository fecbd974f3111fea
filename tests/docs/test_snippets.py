"""What the pages show is run in order, files, Python and commands, and says what is told.

A block that follows a line "`name.ext` ...:" is the content of that file, which is there from the start. Of Python,
"print(...) # text" promises the text. A command ends with exit code 0, or as its comment says ("# exit code 1"), and
writes the pictures that it names. A ``text`` block after commands shows lines that they print. Some pages have tests
that know more.
"""

from __future__ import annotations

import importlib.util
import re
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from bench.figures.pages import pages
from holdfast.cli.main import run

ROOT = Path(__file__).parents[2]
OWN = {"howto/bring_a_scene", "howto/in_a_loop", "howto/own_format", "howto/own_engine", "explanation/near_hardware"}
KINDS = ("python", "bash", "text")
NEEDS = {"viser": "hf.view("} | {name: f"import {name}" for name in ("jax", "mujoco", "rerun", "torch")}
BLOCK = re.compile(r"(?:`(?P<file>(?!hf\.)[\w.]+)`[^\n]*:\n\n)?```(?P<kind>[^\n]*)\n(?P<text>.*?)```", re.DOTALL)
PAGES = {
    name: blocks
    for path in pages(ROOT)
    if (name := path.relative_to(ROOT).with_suffix("").as_posix().removeprefix("docs/")) not in OWN
    and not name.startswith("from/")
    and (blocks := [b for b in BLOCK.finditer(path.read_text(encoding="utf-8")) if b["file"] or b["kind"] in KINDS])
}


def called(line: str, monkeypatch: pytest.MonkeyPatch) -> int:
    """The exit code of a command, called in this process."""
    monkeypatch.setattr(sys, "argv", shlex.split(line, comments=True))
    with pytest.raises(SystemExit) as stopped:
        run()
    return int(stopped.value.code or 0)


def words(text: str) -> str:
    """The text with single spaces, whatever its line breaks are."""
    return " ".join(text.split())


@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_shows_runs_and_says_what_is_told(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = "".join(block["text"] for block in PAGES[page])
    missing = [name for name, word in NEEDS.items() if word in shown and importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"needs {', '.join(missing)}")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    said = ""
    for block in PAGES[page]:
        if block["file"]:
            Path(block["file"]).write_text(block["text"], encoding="utf-8")
    for block in PAGES[page]:
        kind, text = "" if block["file"] else block["kind"], block["text"]
        if kind == "python":
            exec(compile(text, f"{page}.md", "exec"), names)
            said = capsys.readouterr().out
            for told in re.findall(r"print\(.*\)\s+# (.*)", text):
                assert any(line and told.startswith(line) for line in said.splitlines()), f"{told}: {said}"
        elif kind == "bash":
            for line in (line for line in text.splitlines() if line.startswith("holdfast ")):
                told = re.search(r"# .*exit code (\d)", line)
                assert called(line, monkeypatch) == (int(told[1]) if told else 0), f"{line}\n{capsys.readouterr()}"
                for picture in re.findall(r"--png (\S+)", line):
                    assert Path(picture).stat().st_size > 5_000, line
            said = capsys.readouterr().out
        elif kind == "text":
            for line in text.splitlines():
                assert words(line) in words(said), f"{line}: {said}"


def test_there_are_pages_with_snippets() -> None:
    assert {"README", "tutorial", "howto/transport", "howto/uncertainty"} <= PAGES.keys()
