"""The page about USD pipelines: its commands are run in order, from its own file, and print what it shows."""

from __future__ import annotations

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from holdfast.batches.usd_validator import PARAMETERS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/howto/usd_pipelines.md").read_text(encoding="utf-8")
# What the command and the entry point do, also where neither this checkout nor its entry points are installed
PROGRAM = (
    "import sys\nimport usd_validation_nvidia as validator\n"
    "from holdfast.batches.usd_validator import HoldfastPlugin\n"
    "if 'HoldfastChecker' not in {rule.__name__ for rule in validator.CategoryRuleRegistry().rules}:\n"
    "    HoldfastPlugin().on_startup()\n"
    "validator.cli_main(sys.argv[1:])"
)


def test_the_page_names_every_parameter() -> None:
    assert all(f"`{name}" in PAGE for name in PARAMETERS)


@pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("usd_validation_nvidia", "pxr")),
    reason="needs usd-validation-nvidia and usd-core, of the extra usd",
)
def test_commands_print_what_is_shown(tmp_path: Path) -> None:
    file = re.search(r"`(\w+\.usda)`, .*?\n\n```\n(.*?)```", PAGE, re.DOTALL)
    assert file
    (tmp_path / file[1]).write_text(file[2], encoding="utf-8")
    shown = [line for block in re.findall(r"```console\n(.*?)```", PAGE, re.DOTALL) for line in block.splitlines()]
    printed: list[str] = []
    assert shown[0].startswith("$ nvidia_usd_validate ")
    for line in shown:
        if line.startswith("$ "):
            words = [sys.executable, "-c", PROGRAM, *shlex.split(line)[2:]]
            done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300)
            printed = [each.rstrip() for each in (done.stdout + done.stderr).splitlines()]
            assert done.returncode == (0 if "No issues found." in printed else 1), printed
        else:
            assert line == "..." or line in printed
