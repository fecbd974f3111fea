"""README and the first page are run: the scene file is written, Python and commands are executed in order."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
WALKS = pytest.mark.parametrize(
    "page", [README, (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")], ids=["README", "tutorial"]
)


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)


@WALKS
def test_the_walk_through_works_as_printed(page: str, tmp_path: Path) -> None:
    (scene,) = blocks(page, "yaml")
    (tmp_path / "shelf.yaml").write_text(scene, encoding="utf-8")
    commands = [line for block in blocks(page, "bash") for line in block.splitlines() if line.startswith("holdfast ")]
    assert len(commands) >= 4
    environment = dict(os.environ, PATH=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    for command in commands:
        line, _, said = command.partition("#")
        done = subprocess.run(line, shell=True, cwd=tmp_path, capture_output=True, text=True, env=environment)
        code = re.search(r"exit code (\d)", said)
        assert done.returncode == (int(code[1]) if code else 0), f"{line}\n{done.stdout}{done.stderr}"
    assert (tmp_path / "shelf.png").stat().st_size > 10_000
    assert "largest push [N]" in (tmp_path / "shelf.html").read_text(encoding="utf-8")


@WALKS
def test_python_snippets_run_and_print_what_they_say(page: str, tmp_path: Path) -> None:
    (scene,) = blocks(page, "yaml")
    (tmp_path / "shelf.yaml").write_text(scene, encoding="utf-8")
    code = "\n".join(blocks(page, "python"))
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    promised = re.findall(r"print\(.*?\)\s+# (.*)", code)
    assert promised
    assert done.stdout.splitlines() == promised


def test_the_two_commands_are_the_ones_the_makefile_has() -> None:
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    for command in ("demo", "test"):
        assert f"make {command}" in README
        assert command in targets


def test_no_committed_file_names_a_package_index_or_a_path_of_this_machine() -> None:
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    files = [ROOT / name for name in listed.stdout.splitlines()]
    assert files, "needs a git checkout"
    suspicious = re.compile(
        r"https?://[^\s\"')]*(pypi|simple/|files\.pythonhosted)|--(extra-)?index-url|/root/|/opt/py"
    )
    for path in files:
        if path.suffix in {".py", ".toml", ".txt", ".md", ".yaml", ".yml", ".cfg", ""} and path != Path(__file__):
            assert not suspicious.search(path.read_text(encoding="utf-8", errors="ignore")), path
