"""README names commands that there are, and no file names an index or a machine. Pages are run elsewhere."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


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
