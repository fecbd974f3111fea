"""The pages for people who come from another tool, and the two on scenes and loops: their files, Python and commands.

They are run section by section, in order, and print what they say. Every page about a tool has the same parts.
"""

from __future__ import annotations

import importlib.util
import re
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from holdfast.cli.main import run
from holdfast.scene.formats.registry import readable

DOCS = Path(__file__).parents[2] / "docs"
TOOLS = ("compas", "drake", "gazebo", "isaac_newton", "moveit", "mujoco", "pybullet", "rhino_blender")
PAGES = {
    name: (DOCS / name).with_suffix(".md").read_text(encoding="utf-8")
    for name in (*(f"from/{tool}" for tool in TOOLS), "howto/bring_a_scene", "howto/in_a_loop")
}
SNIPPET = re.compile(r"(?:`(?P<file>[\w.]+)`:\n\n)?```(?P<kind>\w*)\n(?P<text>.*?)```", re.DOTALL)
NEEDS = {"mujoco": "mujoco", "pybullet": "pybullet", "newton": "newton", ".usda": "pxr", "crate.xml": "mujoco"}
PUSH = "13.08 N"  # on every page: a crate that tips at 4 kg x 9.81 m/s² x 0.05 m / 0.15 m


def sections() -> dict[str, str]:
    """All parts of the pages with something to run, by page and heading."""
    found = {}
    for page, text in PAGES.items():
        for part in re.split(r"^(?=## )", text, flags=re.MULTILINE):
            head = part.splitlines()[0].lstrip("# ")
            if "```python" in part or "```bash" in part:
                found[f"{page}: {head}"] = part
    return found


def command(line: str, monkeypatch: pytest.MonkeyPatch) -> object:
    """The exit code of a command, called in this process."""
    monkeypatch.setattr(sys, "argv", shlex.split(line, comments=True))
    with pytest.raises(SystemExit) as stopped:
        run()
    return stopped.value.code


@pytest.mark.parametrize("name", sections())
def test_every_section_runs_and_prints_what_it_says(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = sections()[name]
    for word, module in NEEDS.items():
        asked = re.search(rf"^(import|from) {word}\b", text, re.MULTILINE) or f"{word}`:" in text
        if asked and importlib.util.find_spec(module) is None:
            pytest.skip(f"needs {module}")
    monkeypatch.chdir(tmp_path)
    for written in SNIPPET.finditer(PAGES[name.partition(":")[0]]):
        if written["file"]:
            Path(written["file"]).write_text(written["text"], encoding="utf-8")
    for snippet in SNIPPET.finditer(text):
        if snippet["kind"] == "python":
            names: dict[str, Any] = {}
            exec(compile(snippet["text"], f"{name}.md", "exec"), names)
            promised = re.findall(r"print\(.*\)\s+# (.*)", snippet["text"])
            assert promised
            printed = capsys.readouterr().out.splitlines()
            assert [line for line in printed if line in promised] == promised, printed
        elif snippet["kind"] == "bash":
            for line in snippet["text"].splitlines():
                assert command(line, monkeypatch) in (0, None), line
                assert PUSH in capsys.readouterr().out or not line.startswith("holdfast push"), line


@pytest.mark.parametrize("tool", TOOLS)
def test_every_page_of_a_tool_has_the_same_parts(tool: str) -> None:
    text = PAGES[f"from/{tool}"]
    assert text.split("\n\n")[1].startswith("For people who ")
    assert "\n| you are used to | here |\n" in text
    assert "\n## What is read\n" in text
    assert "scene.notes" in text
    assert f"from/{tool}.md" in PAGES["howto/bring_a_scene"]
    assert PUSH in text


def test_there_is_no_other_page_of_a_tool() -> None:
    assert sorted(path.stem for path in (DOCS / "from").glob("*.md")) == sorted(TOOLS)


def test_the_page_on_formats_names_every_format_and_option() -> None:
    text = (DOCS / "reference" / "formats.md").read_text(encoding="utf-8")
    own = [
        each for each in readable() if str(getattr(each.read, "__module__", "")).startswith("holdfast.")
    ]  # no test's
    assert len(own) > 8
    for each in own:
        for word in (*each.suffixes, *(f"{option}=" for option in each.options)):
            assert f"`{word}" in text, f"{each.name}: {word}"


def test_the_way_in_can_be_found() -> None:
    assert "docs/howto/bring_a_scene.md" in (DOCS.parent / "README.md").read_text(encoding="utf-8")
